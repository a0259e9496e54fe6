#!/bin/sh
# The host code of tool and library under valgrind's memcheck: nothing is read
# or written where nothing is, nothing unset is used or written to a file,
# nothing leaks.  test/valgrind.supp has what isn't ours.
. "$srcdir/test/support/tap.sh"

if ! command -v valgrind >/dev/null; then
  skip "memcheck has nothing to report" "no valgrind"
  echo "1..$count"
  exit 0
fi

# other implementations leak while they are loaded
pocl=/etc/OpenCL/vendors/pocl.icd
test ! -e $pocl || export OCL_ICD_VENDORS=$pocl

# libtool's wrapper would be what valgrind looks at.
memcheck() {
  ./libtool --mode=execute valgrind -q --error-exitcode=66 --num-callers=40 \
    --leak-check=full --errors-for-leak-kinds=definite,possible \
    --suppressions="$srcdir/test/system/valgrind.supp" "$@"
}
clean() { # NAME COMMAND...
  name=$1
  shift
  works "$name" memcheck "$@"
}
# seen NAME STATEMENTS: memcheck reports what they do.
seen() {
  printf '#include <stdlib.h>\nint main(void) { char *volatile p = malloc(8); %s }\n' \
    "$2" >"$work/faulty.c"
  ${CC:-cc} -o "$work/faulty" "$work/faulty.c" && run memcheck "$work/faulty"
  test $status -eq 66
  ok $? "$1"
}

seen "a leak would be seen" 'p = NULL; return 0;'
seen "so would a write behind the end" 'p[8] = 0; free(p); return 0;'

clean "what a first frame decides" test/unit/test_suggest
clean "maps of light" test/unit/test_environment
# Leaks of the compiler, which runs in here, have no end; test_sanitize looks for
# those of the library.  frames_* need real kernels.
clean "contexts and plans that are destroyed in any order" --leak-check=no \
  test/unit/test_lifetimes 'frames_*'

# The first one, without valgrind, has the kernels compiled.
demo="demo --frames 2 --size 40x30"
# shellcheck disable=SC2086
works "a demo" "$HBIL" $demo -o "$work/demo"
one=$work/demo/gbuffer/frame_0001.exr
two=$work/demo/gbuffer/frame_0002.exr
name="a demo: library and tool, from scene to result"
if grep -q '^flags.* avx512f' /proc/cpuinfo 2>/dev/null; then
  skip "$name" "valgrind has no AVX-512: kernels would be compiled under it"
else
  # shellcheck disable=SC2086
  clean "$name" "$HBIL" $demo -o "$work/again"
fi
clean "info" "$HBIL" info "$one" "$two"
clean "the exact integral" "$HBIL" process --quality reference --slices 2 \
  --warm-up 0 --reprojection motion --preview -o "$work/exact" "$one" "$two"

echo "1..$count"
