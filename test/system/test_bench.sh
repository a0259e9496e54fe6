#!/bin/sh
# hbil-bench: each question gets an answer on a tiny picture, as Markdown and as
# JSON; mistakes on the command line get one line.
. "$srcdir/test/support/tap.sh"
BENCH=${HBIL_BENCH:-./hbil-bench}

# tiny QUESTION OPTION...: a few pixels, one run.
tiny() {
  question=$1
  shift
  "$BENCH" "$question" --size 64x48 --runs 1 --quick -o "$work/results" "$@"
}

# rejected NAME PATTERN COMMAND...: exit status 2 and one line that starts with
# the program's name and has the pattern.
rejected() {
  name=$1 pattern=$2
  shift 2
  run "$@"
  test $status -eq 2 && test "$(wc -l <"$work/err")" -eq 1 &&
    grep -q "^hbil-bench: .*$pattern" "$work/err"
  ok $? "$name"
}

# valid NAME FILE: it is JSON that names the machine and the date.
valid() {
  if ! command -v python3 >"$work/out" 2>&1; then
    skip "$1" "no python3"
    return
  fi
  python3 -c 'import json, sys
r = json.load(open(sys.argv[1]))
assert r["machine"]["device"] and r["date"] and r["tables"] and r["hbil"]' \
    "$2" >"$work/out" 2>"$work/err"
  ok $? "$1"
}

says "the program lists its questions" '^  passes ' "$BENCH" --help
for question in error skips scaling temporal passes pilot formats; do
  says "$question has help" "^usage: hbil-bench $question" \
    "$BENCH" $question --help
done

# --- error ---

cat >"$work/page.md" <<'END'
before
<!-- hbil-bench error -->
old table
<!-- end -->
after
END
says "error has a table" '^| paper 2x8 g0 same-layer | [0-9.]* |' \
  tiny error --pixels 40 --markdown "$work/page.md"
has "error writes its table, its data and JSON" "$work/results/error.md" \
  "$work/results/error.dat" "$work/results/error.gnuplot" \
  "$work/results/error.json"
valid "error's JSON can be read" "$work/results/error.json"
for row in 'fast 1x16 g2 same-layer' '2x8 g2 fp32' 'endless 2x8 g2' \
  'the paper as one plain kernel'; do
  grep -q "^| $row | [0-9]" "$work/results/error.md"
  ok $? "error has the row $row"
done
grep -q '^| gtao 2x8 g2 | [0-9. |]* | | 0\.[0-9]* | AO |' \
  "$work/results/error.md"
ok $? "AO alone has no error of light"
grep -q '^before$' "$work/page.md" && grep -q '^after$' "$work/page.md" &&
  grep -q '^| paper 2x8' "$work/page.md" && ! grep -q 'old table' "$work/page.md"
ok $? "--markdown replaces the section and nothing else"
if command -v gnuplot >"$work/out" 2>&1; then
  has "gnuplot draws error.png" "$work/results/error.png"
else
  skip "gnuplot draws error.png" "no gnuplot"
fi

# --- the other questions ---

says "skips tells what is left out" '^| upper half is sky .*sky 50.0 %' \
  tiny skips
grep -q '^| a wall seen straight on .*open 100.0 % of pixels' "$work/out" &&
  grep -q '^| static, light has settled .*no gather, no recompose' "$work/out"
ok $? "skips has open walls and static frames"
valid "skips' JSON can be read" "$work/results/skips.json"
says "scaling has sizes" '^| 384 x 288 | [0-9]' tiny scaling
grep -q '^| first frame | [0-9]' "$work/out" &&
  grep -q '^| 128 | [0-9]' "$work/out"
ok $? "scaling has first frames and samples"
valid "scaling's JSON can be read" "$work/results/scaling.json"
says "temporal has means over frames" '^| 2x48 g2 | 4 | 0\.' \
  tiny temporal --pixels 40
valid "temporal's JSON can be read" "$work/results/temporal.json"
says "formats has the error of each format" '| FLOAT16 | 48 | 0\.' \
  tiny formats --pixels 40
says "passes has the time of each pass" '^| 2x48 g2, motion vectors | [0-9]' \
  tiny passes
works "passes compares kernels" tiny passes --name kernels --json \
  --kernels "$srcdir/kernels" --kernels "$srcdir/kernels"
cp "$work/out" "$work/kernels.json"
valid "--json prints JSON" "$work/kernels.json"
grep -q '"pass": "gather"' "$work/results/kernels.json"
ok $? "pass by pass"

# --- captured frames ---

"$HBIL" demo -o "$work/demo" --size 64x48 --frames 2 >"$work/out" 2>"$work/err"
set -- "$work"/demo/*/frame_0001.exr
works "error takes a dump" "$BENCH" error --quick --runs 1 --pixels 16 \
  -o "$work/results" --name dump --dump "$1"
grep -q "frame_0001.exr, 64 x 48 pixels" "$work/results/dump.md"
ok $? "and names it"
rejected "a truth without a dump" '--truth: one --dump' \
  "$BENCH" error --truth "$1"
rejected "a dump has its own size" '--size: a dump has' \
  "$BENCH" error --size 64x48 "$1"

# --- mistakes ---

rejected "no question" 'no command' "$BENCH"
rejected "an unknown question" 'speed: no such command' "$BENCH" speed
rejected "an unknown option" '--fast is not an option' "$BENCH" skips --fast
rejected "an option of another question" '--kernels is not an option' \
  "$BENCH" skips --kernels "$srcdir/kernels"
rejected "an option without its value" '--runs needs a value' \
  "$BENCH" skips --runs
rejected "no runs" '--runs 0: a whole number' "$BENCH" skips --runs 0
rejected "no pixels" '--pixels 0: a whole number' "$BENCH" error --pixels 0
rejected "a bad size" '--size 64: WIDTHxHEIGHT' "$BENCH" skips --size 64
rejected "a device that isn't there" '--device nothing: no such device' \
  "$BENCH" skips --device nothing
rejected "no kernels there" 'a folder of kernel files is needed' \
  "$BENCH" passes --kernels "$work/none"
rejected "a page without the section" 'the lines <!-- hbil-bench skips -->' \
  tiny skips --markdown "$work/page.md"
rejected "no folder for the results" 'no results can be written' \
  "$BENCH" skips -o "$work/none/none"
rejected "a file where there is no need" 'no file is needed' \
  "$BENCH" scaling "$work/page.md"

echo "1..$count"
