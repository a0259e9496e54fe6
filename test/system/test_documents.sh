#!/bin/sh
# The documents tell the truth: every command in them is run on small frames, or
# is found in the test that runs it, and every option, file, link, test, target
# of make, function and variable that they name exists.
. "$srcdir/test/support/tap.sh"

here=$PWD
documents="README.md HACKING.md NEWS examples/README.md doc/guide.md
  doc/method.md doc/measurements.md doc/drivers.md doc/man1_examples.txt"

# --- what the documents say ---

# Code of a document: indented lines, and what stands in backquotes, also across
# two lines; without the blocks of other languages.
code_of() {
  sed '/^```[a-z]/,/^```$/d' "$srcdir/$1" >"$work/text"
  sed -n 's/^    //p' "$work/text"
  sed '/^    /d' "$work/text" | awk 'BEGIN { RS = "" }
    { gsub(/\n */, " "); n = split($0, part, "`")
      for (i = 2; i <= n; i += 2) print part[i] }'
}
# Comments behind commands go.
for document in $documents; do
  test -s "$srcdir/$document"
  ok $? "$document is there"
  code_of "$document"
done >"$work/all"
grep '^ok\|^not ok' "$work/all" | tee "$work/tap"
count=$(wc -l <"$work/tap")
grep -v '^ok \|^not ok ' "$work/all" | sed 's/  *#.*//; s/ *$//' | sort -u >"$work/code"
prose() {
  for document in $documents; do cat "$srcdir/$document"; done
}
for document in README.md doc/guide.md doc/measurements.md doc/drivers.md; do
  code_of "$document" | grep -E '^([A-Z_]*=[^ ]* )?(build/)?hbil(-bench)? [a-z]' \
    >"$work/out"
  test -s "$work/out"
  ok $? "$document has commands of hbil"
done

# none_missing NAME: what is missing was written to $work/out, a line each.
none_missing() {
  : >"$work/err"
  test ! -s "$work/out"
  ok $? "$1"
}

# --- names ---

(cd "$srcdir" && find . -type f ! -path './.git/*' ! -path './build/*' |
  sed 's|^\./||') >"$work/files"
# every word of the sources, and of what autotools make of them
(cd "$srcdir" && find src kernels include test examples python doc Makefile.am \
  configure.ac configure bootstrap -type f ! -name '*.md' \
  ! -name 'test_documents.sh' -exec cat {} +) |
  tr -c 'A-Za-z0-9_\n' '\n' | sort -u >"$work/words"

commands=$("$HBIL" --help | sed -n 's/^  \([a-z][a-z]*\) .*/\1/p')
for command in $commands; do
  "$HBIL" "$command" --help >"$work/$command.help"
done
questions=$("$HBIL_BENCH" --help | sed -n 's/^  \([a-z][a-z]*\) .*/\1/p')
for question in $questions; do
  "$HBIL_BENCH" "$question" --help >"$work/bench-$question.help"
done
test -n "$commands" && test -n "$questions"
ok $? "both programs list what they can do"
# those of pkg-config, grep, valgrind, oclgrind, apt-get, configure, Slurm, GNU
# parallel and Blender
printf '%s\n' --cflags --libs --include --tool --uninitialized --data-races \
  --help --version --disable-tool --enable-werror --array --halt --job-name \
  --cpus-per-task --python --no-build-isolation --no-index >"$work/known"
for option in --disable-tool --enable-werror; do
  grep -q -e "$option\$\|$option " "$srcdir/configure" || echo "$option"
done >"$work/out"
none_missing "configure has the options that are named"
cat "$work"/*.help | grep -o -e '^ *-.*' | grep -o -e '--[a-z][a-z-]*' >>"$work/known"
prose | grep -o -e '\(^\|[^-A-Za-z0-9]\)--[a-z][a-z-]*' | sed 's/^[^-]//' |
  sort -u | grep -v -x -F -f "$work/known" >"$work/out"
none_missing "every option that is named is in a help text"

# `--depth planar|ray`: the words of an option.
sed 's/\\|/|/g' "$work/code" |
  grep -o -e '^\(hbil [a-z]* \)\?--[a-z-]* [a-z]*|[a-z|]*' |
  sed 's/^hbil [a-z]* //' | tr '|' ' ' |
  while read -r option words; do
    for word in $words; do
      cat "$work"/*.help | grep -e "^  $option " | grep -q -w "$word" ||
        echo "$option $word"
    done
  done >"$work/out"
none_missing "every word that an option is said to take is in its help"

# What looks like a file: a path, or the name of a source.
given='program\.c|sheet\.png|lit/.*|packed/.*|full/.*|SCENE/.*|\.clh?|bench-results/.*'
tr ' ' '\n' <"$work/code" | grep -E \
  '^[A-Za-z0-9_./-]*\.(c|h|cl|clh|sh|awk|cpp|py|ac|am|map|md|supp|pc|png)$|^(src|test|doc|debian|kernels|include|examples|man)/[A-Za-z0-9_./-]*$' |
  grep -v -x -E "$given" | sort -u |
  while read -r file; do
    test -e "$srcdir/$file" || grep -q -x -e "$file" -e ".*/$file" "$work/files" ||
      test -e "$srcdir/$file.c" || test -e "$srcdir/$file.sh" || echo "$file"
  done >"$work/out"
none_missing "every file that is named is there"

# Links: files, and headings by their names on GitHub.
heading() { # FILE NAME
  sed -n 's/^##* //p' "$1" | tr 'A-Z' 'a-z' | sed 's/[^a-z0-9 _-]//g; s/ /-/g' |
    grep -q -x -e "$2"
}
for document in $documents; do
  folder=$srcdir/$(dirname "$document")
  grep -o '](\([^)]*\))' "$srcdir/$document" | sed 's/](\(.*\))/\1/' |
    grep -v '^http' | sort -u |
    while read -r link; do
      file=${link%%#*} name=${link#"${link%%#*}"}
      target=${file:+$folder/$file}
      target=${target:-$srcdir/$document}
      test -e "$target" || { echo "$document: $link"; continue; }
      test -z "$name" || heading "$target" "${name#\#}" || echo "$document: $link"
    done
done >"$work/out"
none_missing "every link leads to a file and a heading"
prose | grep -o -w 'test_[a-z0-9_]*' | sort -u |
  while read -r test; do
    grep -q -e "/$test\.c\$" -e "/$test\.sh\$" "$work/files" || echo "$test"
  done >"$work/out"
none_missing "every test that is named is there"
prose | grep -o -E '\b((HBIL|STRESS|BENCH|FUZZ)_[A-Z0-9_]*|hbil_[a-z0-9_]*|exact_[a-z0-9_]+)\b' |
  sort -u | grep -v -x -F -f "$work/words" | grep -v '_$' >"$work/out"
none_missing "every variable, function and type that is named is in the sources"
grep -o '^[a-z][a-z0-9_]*()$' "$work/code" | tr -d '()' | sort -u |
  grep -v -x -F -f "$work/words" >"$work/out"
none_missing "so are functions of other names"

# --- commands of hbil, in a folder of their own ---

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
mkdir lit packed full exact rebuilt
for folder in lit rebuilt; do cp "$lit" $folder/frame_0001.exr; done
works "a cache" hbil process --quiet --cache-save shot.cache --layers ao -o learnt "$frame"
for folder in lit packed full exact; do cp "$lit" "$folder/FRAME.exr"; done

# small: commands with small frames, files that are there, and words for what
# stands for any.
small() {
  sed -e "s|build/hbil|hbil|; s|/tmp/||g; s|=kernels|=$srcdir/kernels|" \
    -e 's| \.\.\.$||; s|\.exr\.\.\.|.exr|; s|frame_0006|frame_0001|g' \
    -e "s|--frames 1-240x2[0-9,]*|--frames 1-3x2 $gbuffer/frame_####.exr|" \
    -e "s|SCENE/frame_\*|$gbuffer/frame_*|; s|SCENE/frame_|$gbuffer/frame_|" \
    -e "s|[A-Za-z/]*truth[a-z_]*[0-9]*\.exr:[A-Za-z.]*|$lit:indirect|" \
    -e "s,'\(views/\)\{0\,1\}\(face_\*\|\*\)\.exr',$gbuffer/frame_0003.exr," \
    -e "s,'\(walk\|frame\)_####\.exr','$gbuffer/frame_####.exr'," \
    -e "s,'shot\.####\.exr','$gbuffer/frame_####.exr',g" \
    -e "s|shot\.0001\.exr|$gbuffer/frame_0001.exr|; s|--frames 26-50|--frames 2-3|" \
    -e 's|--cache-size N$|--cache-size 32|' \
    -e 's|--view-light radiance|--view-light direct|' \
    -e "s|--far rsm --light-view views/light\.exr|--far=rsm --light-view $gbuffer/frame_0003.exr|" \
    -e 's|--far rsm|--far rays|' \
    -e "s|\([^/]\)\<\(frame_000[0-9].exr\)|\1$gbuffer/\2|g" \
    -e "s|\([^/]\)\<DEPTH\.exr|\1$frame|g" \
    -e "s|\([^/]\)\<FRAME\.exr|\1$frame|g" \
    -e "s|\<[AB]\.exr:[a-zA-Z_]*|$lit:ao|g; s|--heatmap PNG|--heatmap heat.png|" \
    -e 's| PNG$| sheet.png|; s| NAME$| zip|; s| N$| 2|; s| MIB$| 64|' \
    -e 's| WIDTH$| 6|; s| X$| 9|; s|[][]||g'
}

# complete WORDS: with what the command can't be run without.  Where kernels are
# compiled anew there are few.
complete() {
  case $1 in
  POCL_CACHE_DIR=*) echo "$1 --layers ao --reprojection none" ;;
  *'hbil demo'*) echo "$1 $demo -o demo" ;;
  *'hbil compare'*.exr*.exr*) echo "$1" ;;
  *'compare --mask') echo "$1 $frame $lit $lit" ;;
  *'hbil compare'*) echo "$1 $lit:ao $lit:ao" ;;
  *'hbil info') echo "$1 $frame" ;;
  *process*' --resume '*) echo "$1" ;;
  *process*'--quality reference -o'*) echo "$1 --slices 2 --overwrite" ;;
  *'process '*' -o '* | *'process -o '*) echo "$1 --overwrite" ;;
  *process*.exr*) echo "$1 --dry-run -o dry" ;;
  *process*) echo "$1 --dry-run -o dry $frame" ;;
  *) echo "$1" ;;
  esac
}

# Options that stand alone, each with its value, become one command, whose last
# ones overrule the others; the words of those with a choice were looked up above.
options=$(grep -e '^--[a-z-]*[ =][^ ]' -e '^--timings$' "$work/code" | small |
  grep -v -e '|\|\.\.\.\|--map\|^--quality reference' \
    -e '^--device' -e '^--eye' -e '^--view-layer' -e '^--cache-load' -e '^--cache-fixed' \
    -e '^--cuts' -e '^--slice-frames' \
    -e '[ =][A-Z][A-Z,]*$' |
  while read -r option words; do
    ! grep -q -e "^ *\(-[a-z], \)\{0,1\}${option%%=*} " "$work/process.help" ||
      echo "$option $words"
  done | sort -u | tr '\n' ' ')
test -n "$options"
ok $? "there are options that stand alone"
{
  grep -E '^([A-Z_]*=[^ ]* )?(build/)?hbil [a-z]' "$work/code" | small
  grep -e '^--quality reference' "$work/code" |
    sed 's/^/hbil process /' | small
  grep -e '^--heatmap\|^--max-rmse' "$work/code" | sed 's/^/hbil compare /' | small
  echo "hbil process $options --model default"
  echo "hbil process --slice-frames 4"
} | sort -u >"$work/commands"
test "$(wc -l <"$work/commands")" -ge 10
ok $? "there are commands to run"
while read -r words; do
  case $words in *--map*) continue ;; esac
  command=$(complete "$words")
  run eval "$command"
  ok $status "$command"
done <"$work/commands"
# Maps are understood, but these frames have no such layers.
grep -e '--map [^ ]*=' "$work/code" | sed 's/^hbil process//; s/-o [a-z]*//' |
  grep -o -e "--map '[^']*'" -e '--map [^ ]*' | grep -v 'ROLE' |
  sort -u >"$work/maps"
test -s "$work/maps"
ok $? "there are maps"
while read -r words; do
  run eval "hbil process --dry-run -o dry $words $frame"
  test $status -eq 2 && grep -q 'no such layer\|no such channel\|cannot be read' "$work/err"
  ok $? "$words, understood"
done <"$work/maps"
# The kernel's code, in the cache of a command above.
grep '^objdump' "$work/code" | small >"$work/disassemble"
run sh "$work/disassemble"
test $status -eq 0 && grep -q '<_pocl_kernel_gather_workgroup' "$work/out"
ok $? "objdump shows the gather's code"
cd "$here" || exit 99

# --- other commands ---

# The bench takes long: its words are checked, and test_bench.sh runs every
# question.
grep -E '^(build/)?hbil-bench [a-z]' "$work/code" | sed 's/^.*hbil-bench //' |
  while read -r question words; do
    test -s "$work/bench-$question.help" || echo "hbil-bench $question"
    for word in $words; do
      case $word in
      --) break ;; # what follows is for hbil process
      --*) grep -q -e "$word " "$work/bench-$question.help" ||
        echo "hbil-bench $question $word" ;;
      esac
    done
  done >"$work/out"
none_missing "hbil-bench has the questions and options that are named"
for question in $questions; do
  grep -q -e "tiny $question" "$srcdir/test/system/test_bench.sh" || echo "$question"
done | grep -v '^pilot$' >"$work/out"
none_missing "test_bench.sh asks every question"

# make's targets: nothing is made, but there is what they are made of.
make -qp 2>/dev/null | sed -n 's/^\([a-z][a-z_/-]*\):.*/\1/p' >"$work/targets"
grep -o '^make\( -C build\)\?\( [a-z-].*\)\?$' "$work/code" |
  sed 's/^make//; s/ -C build//; s/ -j[0-9]*//; s/ [A-Z_]*=.*//; s/^ //' |
  tr ' ' '\n' | sort -u | grep . | grep -v -x -F -f "$work/targets" >"$work/out"
none_missing "every target of make that is named is there"
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
elsewhere 'sbatch .*--array' test/system/test_chunks.sh
for part in distcheck installcheck uninstall 'dpkg-buildpackage -us -uc' \
  'autoreconf -fi'; do
  elsewhere "$part" test/system/test_install.sh
done
compile=$(grep '^cc -std' "$work/code" | sed 's/ [0-9a-z_]*\.c / program.c /' | sort -u)
test "$(echo "$compile" | wc -l)" -eq 1 && test -n "$compile"
ok $? "the compiler's command is one, which test_install.sh runs"

# Nothing else that is told could be run: a program of this system, with words
# behind it.
sed 's/^\([A-Z_]*=[^ ]* \)*//' "$work/code" | grep '^[A-Za-z./_-]* [^=]' |
  while read -r program words; do
    case $program in
    hbil | build/hbil | build/hbil-bench | hbil-bench | make | cc | objdump | \
      autoreconf | dpkg-buildpackage | man | ./bootstrap | valgrind | apt-get | \
      blender | pip | sbatch | --* | */*) ;;
    *) case $words in '->'* | '='*) ;; *)
      ! command -v "$program" >/dev/null || echo "$program $words" ;;
    esac ;;
    esac
  done >"$work/out"
none_missing "there is no other command"

echo "1..$count"
