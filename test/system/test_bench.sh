#!/bin/sh
# hbil-bench: each question gets an answer on a tiny picture, as Markdown and as
# JSON; mistakes on the command line get one line.
. "$srcdir/test/support/tap.sh"
BENCH=${HBIL_BENCH:-./hbil-bench}

# tiny QUESTION OPTION...: a few pixels, one run; truth takes folders of its own.
tiny() {
  question=$1
  shift
  case $question in
  truth) ;;
  thickness | flicker) set -- --size 64x48 --quick "$@" ;;
  *) set -- --size 64x48 --runs 1 --quick "$@" ;;
  esac
  "$BENCH" "$question" -o "$work/results" "$@"
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
for question in error thickness skips scaling temporal passes pilot cache truth flicker; do
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
for row in 'fast 2x20/2 g3' '2x8 g3 fp32' 'endless 2x8 g3' \
  'the paper as one plain kernel'; do
  grep -q "^| $row | [0-9]" "$work/results/error.md"
  ok $? "error has the row $row"
done
grep -q '^| gtao 2x8 g3 | [0-9. |]* | | 0\.[0-9]* | AO |' \
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

says "with a window, error has a band" '^| 2x8 g3 fp32 | .* | 0\.[0-9]* | 0\.[0-9]* |' \
  tiny error --window 40x30+8+4
grep -q 'These pixels are the window of 40 x 30 at (8, 4)' "$work/out" &&
  grep -q '"ao_band": 0\.[0-9]' "$work/results/error.json"
ok $? "of the window that it names"
for window in 40x30 0x4+1+1 40x30+1+1x -1x4+0+0; do
  rejected "no window: $window" 'WIDTHxHEIGHT+X+Y' \
    "$BENCH" error --quick "--window=$window"
done
rejected "a window outside of the picture" 'must lie in the picture' \
  tiny error --window 40x30+25+4

# --- thickness ---

says "thickness has a table" '^| 1e-06 | [0-9.]* | [0-9.]* | [0-9.]* | [0-9.]* |' \
  tiny thickness --pixels 40
grep -q '^| infinite | 0\.[0-9]* | 0\.[0-9]* | 0\.[0-9]* | [0-9.]* |' \
  "$work/results/thickness.md"
ok $? "up to an infinite one"
has "thickness writes its plot's data and JSON" "$work/results/thickness.dat" \
  "$work/results/thickness.gnuplot" "$work/results/thickness.json"
valid "thickness' JSON can be read" "$work/results/thickness.json"

# --- the other questions ---

# Widths here are multiples of 64 where they can be, so that all have the same
# kernels.
says "skips tells what is left out" '^| upper half is sky .*sky 50.0 %' \
  tiny skips --size 128x64
grep -q '^| a wall seen straight on .*open 100.0 % of pixels' "$work/out" &&
  grep -q '^| static, after 80 frames .*no gather, no recompose' "$work/out"
ok $? "skips has open walls and static frames"
valid "skips' JSON can be read" "$work/results/skips.json"
says "scaling has sizes" '^| 384 x 288 | [0-9]' tiny scaling --size 128x96
grep -q '^| first frame | [0-9]' "$work/out" &&
  grep -q '^| 128 | [0-9]' "$work/out"
ok $? "scaling has first frames and samples"
valid "scaling's JSON can be read" "$work/results/scaling.json"
says "temporal has frames that share slices" '^| 4x56/2 g3 | 0\.' \
  tiny temporal --pixels 40
valid "temporal's JSON can be read" "$work/results/temporal.json"
rejected "runs where nothing is timed" 'runs' "$BENCH" truth --runs 3 "$work"
says "cache has what a view costs" '^| inject a view | [0-9]' \
  tiny cache
grep -q '^| rays | [0-9.]* | | [-0-9.]* | [0-9.]* | [0-9.]* | [0-9.]* |$' "$work/out" &&
  grep -q '^| lpv | [0-9.]* | [-0-9.]* | [-0-9.]* | [0-9.]* | [0-9.]* | [0-9.]* |$' "$work/out"
ok $? "and each far-field method"
says "flicker has both scenes, with and without a cache" \
  '^| the procedural room | cache | 0\.[0-9]* | 0\.[0-9]* | 0\.[0-9]* | 0\.[0-9]* |' \
  tiny flicker
test "$(grep -c '^| the procedural corner | .*cache' "$work/out")" -eq 4
ok $? "and with shared slices"
valid "flicker's JSON can be read" "$work/results/flicker.json"
says "passes has the time of each pass" '^| 4x40/2 g3, motion vectors | [0-9]' \
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
rejected "flicker needs a second frame" 'a second frame is needed' \
  "$BENCH" flicker "$1"
says "flicker takes captured frames" 'frame_0002.exr | cache | ' \
  "$BENCH" flicker --quick -o "$work/results" "$@" "${1%1.exr}2.exr"
rejected "a dump has its own size" '--size: a dump has' \
  "$BENCH" error --size 64x48 "$1"

# --- truth ---

# process NAME OPTION...: results of the demo's frames in $work/NAME.
process() {
  into=$work/$1
  shift
  "$HBIL" process --quiet --overwrite --layers indirect -o "$into" "$@" \
    "$gbuffer"/frame_*.exr
}
# scene NAME FILE: the demo's frames, and FILE as the last one's truth.
scene() {
  mkdir -p "$work/$1"
  cp "$gbuffer"/frame_*.exr "$gbuffer"/frame_*.json "$work/$1"
  cp "$2" "$work/$1/truth_avg_0002.exr"
}
# first KEY FILE: the first number of that name in a JSON file.
first() {
  sed -n "s/^ *\"$1\": \([-0-9.e+]*\),\{0,1\}\$/\1/p" "$2" | head -n 1
}
# figure KEY: of the first scene.
figure() {
  first "$1" "$work/results/truth.json"
}
# near NAME A B: two numbers that differ by less than A / 10000 + 1e-6.
near() {
  awk -v a="$2" -v b="$3" 'BEGIN {
    off = a > b ? a - b : b - a
    exit !(a != "" && b != "" && off <= a / 1e4 + 1e-6) }'
  differ=$?
  echo "$2 and $3" >"$work/out"
  ok $differ "$1"
}
# compared KEY A B: what hbil compare says at the pixels of the last frame.
compared() {
  "$HBIL" compare --json --mask "$gbuffer/frame_0002.exr" "$2" "$3" \
    >"$work/compared"
  first "$1" "$work/compared"
}
mkdir "$work/temporary"
export TMPDIR="$work/temporary"
gbuffer=$work/demo/gbuffer
last=frame_0002.exr

works "an exact integral is a truth" process exact --quality reference --slices 8
scene exact-scene "$work/exact/$last"
process ours && process paper --model paper &&
  process black --model paper --layers far_irradiance
exact=$work/exact/$last:indirect
says "truth has a row for each scene" \
  '^| exact-scene | 0\.[0-9]* | [0-9.]* | 1 | [0-9.]* | [0-9.]* |' \
  tiny truth "$work/exact-scene" "$work/exact-scene/"
test "$(grep -c '^| exact-scene | 0\.' "$work/out")" -eq 2 &&
  grep -q '^| geometric mean | ' "$work/out" && grep -q '^| worst | ' "$work/out"
ok $? "and rows of all"
valid "truth's JSON can be read" "$work/results/truth.json"
near "RMSE is that of hbil process and hbil compare" "$(figure rmse)" \
  "$(compared rmse "$work/ours/$last:indirect" "$exact")"
near "so is that of the paper's model" "$(figure paper_rmse)" \
  "$(compared rmse "$work/paper/$last:indirect" "$exact")"
near "means are compared" "$(figure mean_ratio)" "$(awk \
  -v a="$(compared mean "$exact" "$work/ours/$last:indirect")" \
  -v b="$(compared mean "$exact" "$exact")" 'BEGIN { print a / b }')"
# Black far light is the answer zero.  The variance of a channel is its mean
# square less the square of its mean.
for c in R G B; do
  for key in rmse mean values; do
    compared $key "$work/black/$last:far_irradiance.$c" "$exact.$c"
  done | tr '\n' ' '
  echo
done | awk '{ square += $1 * $1 * $3; off += ($1 * $1 - $2 * $2) * $3; n += $3 }
  END { print sqrt(off / n), sqrt(square / off) }' >"$work/trivial"
near "the floor is the constant mean's" "$(figure floor)" \
  "$(cut -d ' ' -f 1 "$work/trivial")"
near "zero is over it" "$(figure zero)" "$(cut -d ' ' -f 2 "$work/trivial")"

# Far light of one colour on open surfaces: its chromaticity is (1, 2, 3) / 6, and
# that of white a third each, so they are sqrt(2) / 6 apart.
far='--mode gtao --environment'
# shellcheck disable=SC2086
process coloured $far 1,2,3 &&
  process dark $far 1,1,1 --copy-channels
scene coloured-scene "$work/coloured/$last"
# shellcheck disable=SC2086
works "truth takes options of hbil process" tiny truth "$work/coloured-scene" \
  -- $far 1,1,1
near "chroma of a colour against white" "$(figure chroma)" 0.2357023
near "light is a half as much" "$(figure mean_ratio)" 0.5
near "one colour is no error of chroma" "$(figure chroma_constant_mean)" 0
# shellcheck disable=SC2086
works "brightness is none" tiny truth "$work/coloured-scene" -- $far 2,4,6
near "of chroma" "$(figure chroma)" 0
near "but twice the mean" "$(figure mean_ratio)" 2

# A frame that holds its own truth.
mkdir "$work/own"
cp "$gbuffer"/frame_*.exr "$gbuffer"/frame_*.json "$work/own"
cp "$work/dark/$last" "$work/own/$last"
# shellcheck disable=SC2086
works "truth takes the light of the last frame" tiny truth "$work/own" \
  -- $far 2,2,2
near "which is half as bright" "$(figure mean_ratio)" 2

# Single files, whose truth may be that of a name with fewer parts.
mkdir "$work/single"
cp "$gbuffer/$last" "$work/single/box.exr"
cp "$gbuffer/frame_0002.json" "$work/single/box.json"
cp "$gbuffer/$last" "$work/single/box_other_view.exr"
cp "$gbuffer/frame_0002.json" "$work/single/box_other_view.json"
cp "$work/exact/$last" "$work/single/box_truth.exr"
says "truth takes a folder with NAME_truth.exr" '^| single | 0\.' \
  tiny truth "$work/single" --name single
says "FOLDER/NAME takes the truth of a shorter name" '^| box_other_view | 0\.' \
  tiny truth "$work/single/box_other_view"
ls "$work/temporary" >"$work/left"
test ! -s "$work/left" && test "$(ls "$work/single" | wc -l)" -eq 5
ok $? "no result is left"

# The last frame is that of the highest number, not the last in the alphabet.
mkdir "$work/numbered"
for kind in exr json; do
  cp "$gbuffer/frame_0001.$kind" "$work/numbered/frame_9.$kind"
  cp "$gbuffer/frame_0002.$kind" "$work/numbered/frame_10.$kind"
done
cp "$work/exact/$last" "$work/numbered/truth_avg_10.exr"
works "truth orders frames by number" tiny truth "$work/numbered"
near "with the same RMSE" "$(figure rmse)" \
  "$(compared rmse "$work/ours/$last:indirect" "$exact")"

mkdir "$work/nothing" "$work/untrue" "$work/blind" "$work/small"
cp "$gbuffer/$last" "$gbuffer/frame_0002.json" "$work/untrue"
cp "$work/exact-scene/truth_avg_0002.exr" "$work/blind"
oiiotool "$gbuffer/$last" \
  --ch depth.Z,normal.X,normal.Y,normal.Z,albedo.R,albedo.G,albedo.B,direct.R,direct.G,direct.B \
  -o "$work/blind/$last" # without positions, which would tell the camera
cp "$gbuffer/$last" "$gbuffer/frame_0002.json" "$work/small"
"$HBIL" demo --size 32x24 --frames 1 -o "$work/other" >"$work/out" 2>"$work/err"
cp "$work/other/frame_0001.exr" "$work/small/truth_avg_0002.exr"
rejected "truth without a folder" 'truth: no folder' tiny truth
rejected "a folder that isn't there" 'none: no such folder' \
  tiny truth "$work/none"
rejected "an empty folder" 'nothing: no frames' tiny truth "$work/nothing"
rejected "frames without a truth" 'untrue: no truth; truth_avg_NNNN.exr' \
  tiny truth "$work/exact-scene" "$work/untrue"
rejected "frames without a camera" 'frame_0002.json: camera cannot be read' \
  tiny truth "$work/exact-scene" "$work/blind"
rejected "a truth of another size" 'truth_avg_0002.exr: 32 x 24 pixels, but .*frame_0002.exr has 64 x 48' \
  tiny truth "$work/small"
cp "$work/single/box.exr" "$work/single/box_truth.exr"
rejected "a truth without light" 'box_truth.exr: no indirect light' \
  tiny truth "$work/single"
cp "$work/single/box.exr" "$work/single/more_truth.exr"
rejected "several truths" '2 files NAME_truth.exr; FOLDER/NAME' \
  tiny truth "$work/single"
rejected "options that hbil process has not" '-- *: --fast is not an option' \
  tiny truth "$work/exact-scene" -- --fast
rejected "options of what is written" '--dry-run: not here' \
  tiny truth "$work/exact-scene" -- --dry-run
rejected "frames behind the options" 'a.exr: not here' \
  tiny truth "$work/exact-scene" -- a.exr
rejected "a picture's size for truth" '--size is not an option' \
  tiny truth --size 64x48 "$work/exact-scene"

# A real frame with black albedo, and what its own measurement says of the
# trivial answers.
real=$HBIL_DATA/staircase
if test -d "$real"; then
  mkdir "$work/real"
  for file in frame_0006.exr frame_0006.json truth_avg_0006.exr; do
    ln -s "$(cd "$real" && pwd)/$file" "$work/real/$file"
  done
  works "staircase has a truth" tiny truth "$work/real"
  near "the constant mean's RMSE" "$(figure floor)" \
    "$(first baseline_constant_mean_rmse "$real/baselines.json")"
  near "and that of no light" "$(figure zero)" "$(awk \
    -v a="$(first baseline_zero_rmse "$real/baselines.json")" \
    -v b="$(figure floor)" 'BEGIN { print a / b }')"
else
  for what in "staircase has a truth" "the constant mean's RMSE" \
    "and that of no light"; do
    skip "$what" "no dumps in $real"
  done
fi
# A truth that is the difference of two noisy pictures.  Measured: .137, and .43
# where negative values make chromaticities without bounds.
single=$HBIL_DATA/renderers/mitsuba/sky_hide
if test -e "$single.exr"; then
  works "a truth with negative values" tiny truth "$single"
  awk -v c="$(figure chroma_constant_mean)" 'BEGIN { exit !(c > 0.1 && c < 0.2) }'
  ok $? "has chromaticities within bounds"
else
  for what in "a truth with negative values" "has chromaticities within bounds"; do
    skip "$what" "no files $single.*"
  done
fi

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
