#!/bin/sh
# The host code of library and tool under the sanitizers of addresses, leaks and
# undefined behaviour, built in a folder of its own: a few tests that reach most
# of it, every OpenCL call that fails among them, and the tool on a sequence.
. "$srcdir/test/support/tap.sh"

here=$PWD
build=$here/test/sanitized
# lines for reports, but no variables for debuggers
flags='-g1 -O1 -fsanitize=address,undefined -fno-sanitize-recover=all'
tests='test/unit/test_status test/unit/test_lifetimes test/unit/test_messages test/property/test_faults test/unit/test_suggest test/property/test_guards'

# What PoCL and its compiler allocate for the whole process is theirs; other
# implementations leak while they are loaded, and are not.
printf 'leak:%s\n' libpocl libLLVM libclang libOpenCL libhwloc >"$work/theirs"
pocl=/etc/OpenCL/vendors/pocl.icd
test ! -e $pocl || export OCL_ICD_VENDORS=$pocl
export ASAN_OPTIONS=halt_on_error=1:exitcode=66
export LSAN_OPTIONS=suppressions=$work/theirs:print_suppressions=0:exitcode=66
export UBSAN_OPTIONS=print_stacktrace=1

echo 'int main(void) { return 0; }' >"$work/any.c"
# shellcheck disable=SC2086
if ! ${CC:-cc} $flags -o "$work/any" "$work/any.c" 2>/dev/null ||
  ! "$work/any"; then
  skip "the sanitizers find nothing" "the compiler has none"
  echo "1..$count"
  exit 0
fi

mkdir -p "$build"
sanitized() {
  (cd "$build" && "$@")
}
# Once more where the leak sanitizer itself has broken down, at the end of a
# process whose threads are ending: that says nothing of the process.  Nothing
# takes longer than a few minutes, but a sanitizer may wait for itself.
checked() {
  for try in 1 2 3; do
    sanitized timeout 900 "$@" >"$work/checked" 2>&1
    outcome=$?
    test $outcome -ne 0 || break
    { test $outcome -eq 124 ||
      grep -q 'LeakSanitizer has encountered a fatal error' "$work/checked"; } &&
      ! grep -q 'ERROR: \|runtime error:\|^not ok\|FAILED' "$work/checked" || break
  done
  cat "$work/checked"
  return $outcome
}
make_all() {
  test -f "$build/Makefile" ||
    sanitized "$srcdir/configure" -q --disable-static CFLAGS="$flags" \
      CXXFLAGS="$flags" || return
  # shellcheck disable=SC2086
  sanitized make -s hbil hbil-formats.la hbil-bench $tests
}
works "library, program and bench build with sanitizers" make_all
for test in $tests; do
  works "they find nothing in $test" checked "$test"
done
HBIL=$build/hbil
works "nor in a demo" "$HBIL" demo --frames 2 --size 64x48 -o "$work/demo"
set -- "$work"/demo/gbuffer/frame_*.exr
export HBIL_PROGRAM_DIR="$work/programs" # the first job stores, the second one loads
works "nor in a job with all there is" checked "$HBIL" process --quiet \
  --overwrite --preview --timings --json --copy-channels --precision half \
  --compression dwaa --contact-sheet "$work/sheet.png" \
  --reprojection motion -o "$work/job" "$@"
works "nor in a job that is done already" checked \
  "$HBIL" process --resume --reprojection motion -o "$work/job" "$@"
works "nor in the exact integral" checked "$HBIL" process --quiet \
  --overwrite --quality reference --slices 4 -o "$work/exact" "$1"
works "nor in info" checked "$HBIL" info "$1"
works "nor in a comparison" checked \
  "$HBIL" compare --heatmap "$work/heat.png" \
  "$work/job/frame_0001.exr:ao" "$work/exact/frame_0001.exr:ao"
mkdir "$work/scene"
cp "$1" "${1%.exr}.json" "$work/scene"
cp "$work/exact/frame_0001.exr" "$work/scene/truth_avg_0001.exr"
works "nor in a bench of a scene with its truth" checked \
  "$build/hbil-bench" truth -o "$work/bench" "$work/scene"
mkdir "$work/bin"
printf '#!/bin/sh\nexit 1\n' >"$work/bin/gnuplot"
chmod +x "$work/bin/gnuplot"
PATH=$work/bin:$PATH
works "nor in a short bench" checked \
  "$build/hbil-bench" error --quick --size 64x48 \
  --runs 1 --pixels 20 -o "$work/bench"
absent "which has no plot where gnuplot fails" "$work/bench/error.png"

echo "1..$count"
