#!/bin/sh
# What README.md, HACKING.md, NEWS and examples/README.md tell to do can be done:
# every command in them is run, in its own words but with small sizes, or is
# found where another test runs it; every option, file, test, target of make,
# function and variable that they name is there.
. "$srcdir/test/support/tap.sh"

here=$PWD
documents="README.md HACKING.md NEWS examples/README.md"
for document in $documents; do
  # lines of code, and what stands in backquotes, also across two lines
  sed -n 's/^    //p' "$srcdir/$document"
  sed '/^    /d' "$srcdir/$document" |
    awk 'BEGIN { RS = "" }
      { gsub(/\n */, " "); n = split($0, part, "`")
        for (i = 2; i <= n; i += 2) print part[i] }'
done | sort -u >"$work/code"
prose() {
  for document in $documents; do cat "$srcdir/$document"; done
}

# none_missing NAME: what is missing was written to $work/out, a line each.
none_missing() {
  : >"$work/err"
  test ! -s "$work/out"
  ok $? "$1"
}

# --- what is named ---

(cd "$srcdir" && find . -type f ! -path './.git/*' ! -path './build/*' |
  sed 's|^\./||') >"$work/files"
# every word of the sources, and of what autotools make of them
(cd "$srcdir" && find src kernels include test examples doc Makefile.am \
  configure.ac configure bootstrap -type f ! -name 'README.md' \
  ! -name 'test_documents.sh' -exec cat {} +) |
  tr -c 'A-Za-z0-9_\n' '\n' | sort -u >"$work/words"

commands=$("$HBIL" --help | sed -n 's/^  \([a-z][a-z]*\) .*/\1/p')
for command in $commands; do
  "$HBIL" "$command" --help >"$work/$command.help"
done
# those of pkg-config, grep, valgrind and oclgrind are theirs
printf '%s\n' --cflags --libs --include --tool --uninitialized --help --version \
  --disable-tool --enable-werror >"$work/known"
for option in --disable-tool --enable-werror; do
  grep -q -e "$option\$\|$option " "$srcdir/configure" || echo "$option"
done >"$work/out"
none_missing "configure has the options that are named"
cat "$work"/*.help | grep -o -e '^ *-.*' | grep -o -e '--[a-z][a-z-]*' >>"$work/known"
prose | grep -o -e '\(^\|[^-A-Za-z0-9]\)--[a-z][a-z-]*' | sed 's/^[^-]//' |
  sort -u | grep -v -x -F -f "$work/known" >"$work/out"
none_missing "every option that is named is in a help text"

# `--depth planar|ray`: the words of an option.
grep -o -e '^\(hbil [a-z]* \)\?--[a-z-]* [a-z]*|[a-z|]*' "$work/code" |
  sed 's/^hbil [a-z]* //' | tr '|' ' ' |
  while read -r option words; do
    for word in $words; do
      cat "$work"/*.help | grep -e "^  $option " | grep -q -w "$word" ||
        echo "$option $word"
    done
  done >"$work/out"
none_missing "every word that an option is said to take is in its help"

# What looks like a file: a path, or the name of a source.
given='program\.c|sheet\.png|lit/.*|test/scratch/.*|\.clh?'
tr ' ' '\n' <"$work/code" | grep -E \
  '^[A-Za-z0-9_./-]*\.(c|h|cl|clh|sh|awk|cpp|py|ac|am|map|md|supp|pc|png)$|^(src|test|doc|debian|kernels|include|examples|man)/[A-Za-z0-9_./-]*$' |
  grep -v -x -E "$given" | sort -u |
  while read -r file; do
    test -e "$srcdir/$file" || grep -q -x -e "$file" -e ".*/$file" "$work/files" ||
      test -e "$srcdir/$file.c" || test -e "$srcdir/$file.sh" || echo "$file"
  done >"$work/out"
none_missing "every file that is named is there"
prose | grep -o '](\([^)#]*\))' | sed 's/](\(.*\))/\1/' | grep -v '^http' | sort -u |
  while read -r file; do
    test -e "$srcdir/$file" || test -e "$srcdir/examples/$file" || echo "$file"
  done >"$work/out"
none_missing "every link leads to a file"
prose | grep -o -w 'test_[a-z0-9_]*' | sort -u |
  while read -r test; do
    test -e "$srcdir/test/$test.c" || test -e "$srcdir/test/$test.sh" || echo "$test"
  done >"$work/out"
none_missing "every test that is named is there"
prose | grep -o -E '\b((HBIL|STRESS|BENCH|FUZZ)_[A-Z0-9_]*|hbil_[a-z0-9_]*|exact_[a-z0-9_]+)\b' |
  sort -u | grep -v -x -F -f "$work/words" | grep -v '_$' >"$work/out"
none_missing "every variable, function and type that is named is in the sources"
grep -o '^[a-z][a-z0-9_]*()$' "$work/code" | tr -d '()' | sort -u |
  grep -v -x -F -f "$work/words" >"$work/out"
none_missing "so are functions of other names"

# Tests that a pattern chooses.
grep -o "HBIL_STRESS_TEST='[a-z]*\*'" "$work/code" | sed "s/.*'\(.*\)\*'/\1/" |
  while read -r begins; do
    grep -q "cmocka_unit_test($begins" "$srcdir/test/test_stress.c" || echo "$begins*"
  done >"$work/out"
none_missing "test_stress has the tests that patterns choose"

# --- commands of hbil ---

# in a folder of their own; everything there is small
demo='--frames 3 --size 24x16'
gbuffer=demo/gbuffer
frame=$gbuffer/frame_0001.exr
lit=demo/frame_0001.exr
mkdir "$work/folder" && cd "$work/folder" || exit 99
hbil() {
  "$HBIL" "$@"
}
# shellcheck disable=SC2086
works "a demo, which the commands are about" hbil demo $demo

# small: commands with small frames, files that are there, and words for what
# stands for any.
small() {
  sed -e "s|build/hbil|hbil|; s|=kernels|=$srcdir/kernels|; s|/tmp/||g" \
    -e 's|demo720|demo|g; s| \.\.\.$||; s|\.exr\.\.\.|.exr|' \
    -e "s|--frames 1-240x2|--frames 1-3x2 $gbuffer/frame_####.exr|" \
    -e "s|\<frame_000[0-9].exr|$gbuffer/&|g; s|FRAME\.exr|$frame|g" \
    -e "s|\<[AB]\.exr:[a-zA-Z]*|$lit:ao|g; s|--heatmap PNG|--heatmap heat.png|" \
    -e 's| PNG$| sheet.png|; s| NAME$| zip|; s| N$| 2|; s| MIB$| 64|; s| WIDTH$| 6|; s|[][]||g'
}

# complete WORDS: with what the command can't be run without.  A demo is small; a
# bench is too long, but says what it doesn't understand before it helps; where
# kernels are compiled anew there are few.
complete() {
  case $1 in
  POCL_CACHE_DIR=*) echo "$1 --layers ao --reprojection none" ;;
  *'hbil demo'*) echo "$1 $demo -o demo" ;;
  *'hbil bench'*) echo "$1 --help" ;;
  *'hbil compare'*.exr*.exr*) echo "$1" ;;
  *'compare --mask') echo "$1 $frame $lit $lit" ;;
  *'hbil compare'*) echo "$1 $lit:ao $lit:ao" ;;
  *'hbil info') echo "$1 $frame" ;;
  *'process '*' -o '* | *'process -o '*) echo "$1" ;;
  *process*.exr*) echo "$1 --dry-run -o dry" ;;
  *process*) echo "$1 --dry-run -o dry $frame" ;;
  *) echo "$1" ;;
  esac
}

# Options that stand alone, each with its value, or behind hbil process without
# a frame, become one command, whose last ones fit all others; the words of
# those with a choice were looked up above.
process='^hbil process\( .*\)\?$'
options=$(sed "/exr/!{/$process/s/^hbil process *//}; s/^--max-history-frames\$/& 2/" "$work/code" |
  grep -e '^--[a-z-]*[ =]' -e '^--timings' | grep -v '|' |
  grep -v -e '^--map\|^--runs\|^--scale\|^--heatmap\|^--quality reference\|^--horizon-cache' |
  small |
  sort -u | tr '\n' ' ')
{
  grep -E '^([A-Z_]*=[^ ]* )?(build/)?hbil [a-z]' "$work/code" |
    sed "/exr/!{/$process/d}" | small
  grep -e '^--quality reference\|^--horizon-cache' "$work/code" |
    sed 's/^/hbil process /' | small
  grep -e '^--runs\|^--scale' "$work/code" | sed 's/^/hbil bench /'
  grep -e '^--heatmap' "$work/code" | sed 's/^/hbil compare /' | small
  echo "hbil process $options --relative-thickness inf --extrapolate yes"
} | sort -u >"$work/commands"
while read -r words; do
  command=$(complete "$words")
  run eval "$command"
  ok $status "$command"
done <"$work/commands"
grep -e '^--map .' "$work/code" >"$work/maps"
while read -r words; do
  run eval "hbil process --dry-run -o dry $words $frame"
  test $status -eq 2 && grep -q 'has no such layer\|z\.0001\.exr: cannot be read' "$work/err"
  ok $? "$words, understood, but this frame has no such layer"
done <"$work/maps"
# The kernel's code, in the cache of a command above.
grep '^objdump' "$work/code" | small >"$work/disassemble"
run sh "$work/disassemble"
test $status -eq 0 && grep -q '<_pocl_kernel_gather_workgroup' "$work/out"
ok $? "objdump shows the gather's code"
cd "$here" || exit 99

# --- other commands ---

# make's targets: nothing is made, but there is what they are made of.
make -qp 2>/dev/null | sed -n 's/^\([a-z][a-z_/]*\):.*/\1/p' >"$work/targets"
grep -o '^make\( -C build\)\?\( [a-z].*\)\?$' "$work/code" |
  sed 's/^make//; s/ -C build//; s/ [A-Z]*=.*//; s/^ //' | sort -u | grep . |
  grep -v -x -F -f "$work/targets" >"$work/out"
none_missing "every target of make that is named is there"
works "make bench starts the bench" make -s bench BENCH_FLAGS=--help
run make -n stress STRESS_SECONDS=1
test $status -eq 0 && grep -q 'STRESS_SECONDS=1' "$work/out"
ok $? "make stress starts the tests"
run make -n fuzz
test $status -eq 0 && sh -n "$srcdir/test/system/fuzz.sh"
ok $? "make fuzz starts its script"
name="which has something to compile"
if command -v "${CLANG:-clang}" >/dev/null; then
  works "$name" "${CLANG:-clang}" -std=c11 -fsyntax-only -Wall -Wextra -Werror \
    "-I$srcdir/src" "-I$srcdir" "$srcdir/test/system/fuzz_reader.c"
else
  skip "$name" "no clang"
fi

# What another test runs: it must have the command.
elsewhere() { # COMMAND FILE
  if test -e "$srcdir/$2"; then
    grep -q -e "$1" "$srcdir/$2"
    ok $? "$1 is in $2"
  else
    skip "$1 is in $2" "the tarball has none"
  fi
}
elsewhere './bootstrap demo' .ci/run
elsewhere './bootstrap check' .ci/run
for part in distcheck installcheck uninstall 'dpkg-buildpackage -us -uc' \
  'autoreconf -fi'; do
  elsewhere "$part" test/test_install.sh
done
for part in --scaling --skips; do
  elsewhere "bench $part" test/test_tool.sh
done
compile=$(grep '^cc -std' "$work/code" | sed 's/ [0-9a-z_]*\.c / program.c /' | sort -u)
test "$(echo "$compile" | wc -l)" -eq 1
ok $? "the compiler's command is one, which test_install.sh runs"

# Nothing else that is told could be run: a program of this system, with words
# behind it.
sed 's/^\([A-Z_]*=[^ ]* \)*//' "$work/code" | grep '^[A-Za-z./_-]* [^=]' |
  while read -r program words; do
    case $program in
    hbil | build/hbil | make | cc | objdump | autoreconf | dpkg-buildpackage | \
      man | ./bootstrap | valgrind | apt-get | test/test_stress | --* | */) ;;
    *) ! command -v "$program" >/dev/null || echo "$program $words" ;;
    esac
  done >"$work/out"
none_missing "there is no other command"

echo "1..$count"
