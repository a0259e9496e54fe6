#!/bin/sh
# The bundle (bundle/make.sh), unpacked elsewhere and run without any variable of
# this machine's: its size, its driver, its tests, and test/gpu/run.
. "$srcdir/test/support/tap.sh"

if test -n "$HBIL_PACKAGING" || ! test -x .libs/hbil; then
  skip "the bundle" "no shared library, or packages are being built"
  echo "1..$count"
  exit 0
fi

# unpack NAME [pocl]
unpack() {
  rm -rf "$work/hbil-bundle"
  run sh "$srcdir/bundle/make.sh" . "$srcdir" "$work/$1" $2
  ok $status "$1 can be made"
  works "$1 can be unpacked" tar -C "$work" -xf "$work/$1"
}

# Without a driver: 5 MB at xz's usual level.
unpack bundle.tar.xz
test "$(wc -c <"$work/bundle.tar.xz")" -le 5000000
ok $? "is at most 5 MB: $(wc -c <"$work/bundle.tar.xz") bytes"
mkdir "$work/none"
run env -i TMPDIR="$work" OCL_ICD_VENDORS="$work/none" \
  "$work/hbil-bundle/run" devices
test $status -ne 0 && grep -q '^hbil: no OpenCL device' "$work/err"
ok $? "says that there is no driver"

# With PoCL; a low level, which takes a tenth of the time.
if test -e /etc/OpenCL/vendors/pocl.icd &&
  /sbin/ldconfig -p | grep -q 'libpocl\.so\.2'; then
  XZ_LEVEL=0
  export XZ_LEVEL
  unpack bundle-pocl.tar.xz pocl
  run env -i TMPDIR="$work" DRIVER=pocl "$work/hbil-bundle/run" devices
  test $status -eq 0 && grep -q 'Portable Computing Language' "$work/out"
  ok $? "has a driver of its own"
  # the kernels that tests share are those of the same driver
  run env -i TMPDIR="$work" POCL_CACHE_DIR="$POCL_CACHE_DIR" DRIVER=pocl \
    TESTS="test_pattern test_camera" SIZES=64x36 RUNS=1 "$work/hbil-bundle/test/gpu/run" "$work/gpu"
  ok $status "test/gpu/run has nothing to report"
  grep -q '^Tests: 2 programs: [1-9][0-9]* passed, 0 failed' "$work/gpu/gpu.md"
  ok $? "counts the tests"
  test "$(grep -c 'as on the CPU' "$work/gpu/gpu.md")" = 2
  ok $? "compares frames"
  test "$(grep -c 'Measured on' "$work/gpu/gpu.md")" = 3
  ok $? "has a table for each question"
  # a frame of other bits must be seen
  head -c 4000 /dev/urandom >"$work/hbil-bundle/test/gpu/want/camera"
  run env -i TMPDIR="$work" POCL_CACHE_DIR="$POCL_CACHE_DIR" DRIVER=pocl \
    TESTS=test_camera SIZES=" " \
    "$work/hbil-bundle/test/gpu/run" "$work/gpu2"
  test $status -ne 0 && grep -q 'camera: differs' "$work/gpu2/gpu.md"
  ok $? "a frame that differs is told"
else
  skip "the bundle with PoCL" "no PoCL"
fi

set -- "$work"/hbil-bundle.*
test ! -e "$1"
ok $? "leaves nothing in TMPDIR"

echo "1..$count"
