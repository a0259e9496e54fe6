#!/bin/sh
# The sources follow the project's own rules: names and prose without the words
# that were retired, files and functions of limited length, kernels without what
# some compilers don't take, includes that go down only, and no two files that need
# each other.
. "$srcdir/test/support/tap.sh"

here=$PWD
cd "$srcdir" || exit 99
generated='src/hbil/kernel_sources\.c|src/bench/bench_texts\.c|python/build/.*'
code=$(find src kernels include examples python test -type f \
  -regex '.*\.\(c\|h\|cl\|clh\|cpp\|hpp\|sh\|awk\|py\|am\|map\)' |
  grep -v -E "^($generated|test/system/test_words\.sh)\$" | sort)
prose="README.md HACKING.md NEWS $(find doc examples -name '*.md' | sort)
  $(find doc -name '*.awk' -o -name 'help.sh' | sort)"

# none NAME: $work/out has a line for each finding.
none() {
  : >"$work/err"
  test ! -s "$work/out"
  ok $? "$1"
}

# --- words ---

# What the program prints is checked as well.
{
  "$HBIL" --help
  for command in $("$HBIL" --help | sed -n 's/^  \([a-z][a-z]*\) .*/\1/p'); do
    "$HBIL" "$command" --help
  done
} >"$work/help.txt"

# retired INSTEAD PATTERN [EXCEPTION]: no line has the whole words of the
# pattern, unless it has the exception as well.
retired() {
  # shellcheck disable=SC2086
  grep -I -n -i -w -E -e "$2" $code $prose "$work/help.txt" |
    grep -v -i -E -e "${3:-^$}" >"$work/out"
  none "no \"$2\" ($1)"
}
retired 'span, row block' 'strips?'
retired 'store, reuse, history, cache, retain' 'keep|keeps|kept|keeping'
retired 'sample counts, sampling level' 'ladders?|rungs?'
retired 'error estimator' 'judge[ds]?|judging|judgement'
retired 'exact result' 'rulers?'
retired 'measured tiles' '(turned|lit|sound|wanting) (tile|span)s?'
retired 'error bound, statement' 'promise[ds]?' 'promises about your files|what-hbil-promises'
retired 'fixture' 'labs?'
retired 'invariances' 'relatives'
retired 'plane addressing' 'places\.clh|hbil_places|place_of'
retired 'rejected; back-facing fallback' 'refus(e|es|ed|ing)'
retired 'sample grid' 'lattices?' 'Fibonacci lattice'
retired 'static frame' 'still frames?'
retired 'exact integral, path-traced truth' \
  'the reference|references?.?s? (integral|image|result|renderer)|ref_[a-z0-9_]+' \
  'reference (preset|quality)|the reference count'
retired 'hbil_plane, hbil_statistics, hbil_sanitized ...' \
  'hbil_(format|tiles|lattice|refused|skipped|repaired|share)|HBIL_(TILE|STRIP_[A-Z]*|LATTICE_[A-Z]*|REFUSED_[A-Z]*)'
retired 'a name that says what the helper does' 'gpu_[a-z_]+|test_gpu'
# shellcheck disable=SC2086
grep -I -n -E -e \
  '--(samples|lattice|facing|refused|disocclusion|temporal|background|raw|keep|feedback|max-error|choose-every|form-factors)([^-a-z]|$)' \
  $code $prose "$work/help.txt" >"$work/out"
none "no option by its former name"

# --- the glossary ---

# Rows of doc/method.md: | word, word | meaning | words that it replaces |.
sed -n '/^## Glossary/,/^## /s/^| //p' doc/method.md | grep -v '^word \|^---' \
  >"$work/glossary"
test "$(wc -l <"$work/glossary")" -ge 20
ok $? "the glossary has words"
cut -d '|' -f 1 "$work/glossary" | tr ',' '\n' | sed 's/^ *//; s/ *$//' |
  sort | uniq -d >"$work/out"
none "none of them twice"
cut -d '|' -f 3 "$work/glossary" | tr ',' '\n' | sed 's/^ *//; s/ *$//' |
  grep . >"$work/replaced"
for document in $(find . -maxdepth 1 -name '*.md') doc/*.md examples/*.md; do
  sed '/^## Glossary/,/^## /d; s/`[^`]*`//g; /^    /d' "$document" |
    tr '\n' ' ' | grep -o -i -w -F -f "$work/replaced" | sed "s|^|$document: |"
done >"$work/out"
none "no document has a word that the glossary replaces"

# --- lengths ---

# longer LIMIT FILE...: those with more lines.
longer() {
  limit=$1
  shift
  wc -l "$@" | awk -v limit="$limit" '$2 != "total" && $1 > limit'
}
# shellcheck disable=SC2046,SC2086
{
  longer 500 $(echo "$code" | grep -E '^(src|kernels|include)/.*\.(c|h|cl|clh|cpp|hpp)$')
  longer 800 $(echo "$code" | grep '^test/')
} >"$work/out"
none "no file is longer than 500 lines; a test than 800"
{
  longer 150 README.md
  longer 350 HACKING.md
} >"$work/out"
none "README has at most 150 lines, HACKING 350"

# clang-format puts a function's closing brace, and nothing else, in column 1.
# shellcheck disable=SC2046,SC2086
awk '
  FNR == 1 { body = 0 }
  !body && /^[A-Za-z_]/ { start = FNR; limit = /^kernel / ? 120 : 80 }
  !body && /\{$/ { body = 1; next }
  body && /^}/ {
    if ($0 == "}" && FNR - start + 1 > limit)
      print FILENAME ":" start ": " FNR - start + 1 " lines"
    body = 0
  }' $(echo "$code" | grep -E '\.(c|h|cl|clh|cpp|hpp)$') >"$work/out"
none "no function is longer than 80 lines, no kernel than 120"

# --- what kernels don't use ---

# Relaxed math has neither infinity nor NaN: clang 18 warns of them, and FLT_MAX
# does what they did.  PoCL 4 to 6 end the process at inline assembly.
# shellcheck disable=SC2046
awk '
  FNR == 1 { comment = 0 }
  {
    code = ""
    rest = $0
    while (rest != "") {
      at = comment ? index(rest, "*/") : match(rest, /\/[*\/]/)
      if (!at) at = length(rest) + 1
      if (!comment) code = code " " substr(rest, 1, at - 1)
      comment = comment ? at > length(rest) : substr(rest, at, 2) == "/*"
      if (substr(rest, at, 2) == "//") break
      rest = substr(rest, at + 2)
    }
    gsub(/[^A-Za-z0-9_]+/, " ", code)
    if ((" " code " ") ~ / (INFINITY|NAN|HUGE_VALF?|__builtin_(inf|nan|huge_val)f?|(__)?asm(__)?) /)
      print FILENAME ":" FNR ": " $0
  }' $(find kernels -type f | sort) >"$work/out"
none "no kernel uses infinity, NaN or inline assembly"

# --- includes ---

# includes FOLDER ALLOWED: files in src/FOLDER include these folders alone.
includes() {
  grep -r -n '^ *# *include "' "src/$1" | grep -v -E "$generated" |
    grep -v -E "include \"($2)(/[^\"]*)?\"" >"$work/out"
  none "src/$1 includes no other folder than $(echo "$2" | tr '|' ' ')"
}
own='[a-z_]*\.(h|hpp)'
includes hbil "hbil|lib|shared\.h|$own"
includes exact 'exact|hbil|lib|shared\.h'
includes image 'image'
includes oiio 'oiio|image'
includes dump 'dump|image|hbil'
includes scene "scene|hbil|$own"
includes tool 'tool|dump|scene|exact|image|hbil'
includes bench 'bench|tool|dump|scene|exact|image|hbil|lib|shared\.h'
grep -r -n 'include "test/' src kernels include examples >"$work/out"
none "nothing outside of test/ includes anything of test/"

# Headers that include each other: tsort names the cycle.
# shellcheck disable=SC2046
grep -H '^ *# *include "' $(echo "$code" | grep -E '\.(h|hpp|clh)$') |
  sed 's/^\(src\/\|include\/\|kernels\/\)\{0,1\}\([^:]*\):.*"\([^"]*\)".*/\2 \3/' \
    >"$work/pairs"
tsort "$work/pairs" >"$work/order" 2>"$work/out"
none "no header includes itself, by whatever way"

# --- files that need each other ---

cd "$here" || exit 99
name="no files of src need each other's functions, by whatever way"
# Objects of the libraries and programs, once each.
find src -name '*.o' ! -path '*/.libs/*' 2>/dev/null >"$work/objects"
if command -v nm >/dev/null && test -s "$work/objects"; then
  while read -r object; do
    nm -g "$object" | awk -v object="${object%.o}" '
      NF == 2 && $1 == "U" { print "U", $2, object }
      NF == 3 && $2 ~ /^[TDBRCV]$/ { print "T", $3, object }'
  done <"$work/objects" | sort -u >"$work/symbols"
  awk '
    FNR == NR { if ($1 == "T") owner[$2] = owner[$2] " " $3; next }
    $1 == "U" && ($2 in owner) {
      n = split(owner[$2], of, " ")
      for (i = 1; i <= n; i++)
        if (of[i] != $3) print $3, of[i], $2
    }' "$work/symbols" "$work/symbols" >"$work/uses"
  cut -d ' ' -f 1,2 "$work/uses" | tsort >"$work/order" 2>"$work/out"
  none "$name"
else
  skip "$name" "no nm, or no objects"
fi

echo "1..$count"
