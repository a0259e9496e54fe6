#!/bin/sh
# Whatever the library rejects, the tool's user reads which option, which file or
# which limit of the device is the reason, for each status of hbil_base.h.
#
# Speaks TAP.
srcdir=${srcdir:-$(dirname "$0")/../..}
. "$srcdir/test/support/tap.sh"

process() {
  "$HBIL" process --quiet --slices 1 --steps-per-side 4 --far environment \
    --layers ao -o "$work/none" "$@"
}
works "a demo" "$HBIL" demo --frames 2 --size 32x18 -o "$work/demo"
one=$work/demo/gbuffer/frame_0001.exr
two=$work/demo/gbuffer/frame_0002.exr

# --- every status ---

# OpenCL fails on demand where a library can be put in front of it.
failing=$work/failing.so
${CC:-cc} -shared -fPIC -o "$failing" "$srcdir/test/system/failing_opencl.c" -ldl \
  >"$work/out" 2>"$work/err" || failing=
# fails NAME PATTERN VARIABLE=VALUE: a job whose OpenCL calls fail so.
fails() {
  if test -n "$failing"; then
    rejected "$1" "$2" env LD_PRELOAD="$failing" "$3" "$HBIL" process --quiet \
      --slices 1 --steps-per-side 4 --far environment --layers ao \
      -o "$work/none" "$one"
  else
    skip "$1" "no compiler"
  fi
}
mkdir "$work/kernels"
cp -r "$srcdir/kernels/." "$work/kernels"
chmod -R u+w "$work/kernels"
echo 'nonsense(' >>"$work/kernels/composite.cl"
limit='device .*: not enough memory: .*; it has [1-9][0-9]* MiB; smaller frames'

sed -n 's/^ *\(HBIL_[A-Z_]*\) = [0-9][0-9]*.*/\1/p' \
  "$srcdir/include/hbil/hbil_base.h" >"$work/statuses"
test "$(wc -l <"$work/statuses")" -ge 9
ok $? "the header has the statuses"
while read -r status_name; do
  case $status_name in
  HBIL_SUCCESS) ;;
  HBIL_INVALID_ARGUMENT)
    # Null pointers, wait lists, queues and sizes that are the tool's own: no
    # command can make them wrong.  A cache file whose bytes the library would
    # reject has another checksum, so the tool rejects it before, by name
    # (test_world).
    ;;
  HBIL_INVALID_CONFIG)
    rejected "$status_name" '^hbil: --radius: -1; must be positive' process --radius=-1 "$one"
    ;;
  HBIL_INVALID_FRAME)
    rejected "$status_name" '^hbil: --environment: -1; must be finite and not negative' \
      process --environment=-1,0,0 "$one"
    ;;
  HBIL_OUT_OF_HOST_MEMORY)
    fails "$status_name" 'device .*: not enough memory: .*smaller frames' FAIL_BUFFER=-6
    ;;
  HBIL_OUT_OF_DEVICE_MEMORY) fails "$status_name" "$limit" FAIL_BUFFER=-4 ;;
  HBIL_UNSUPPORTED_DEVICE)
    fails "$status_name" 'device .*has .* and no compiler; OpenCL 1.2' FAIL_COMPILER=1
    ;;
  HBIL_BUILD_FAILED)
    run env HBIL_KERNEL_DIR="$work/kernels" "$HBIL" process --quiet --slices 1 \
      --steps-per-side 4 --far environment -o "$work/none" "$one"
    # the compiler says something of its own
    test $status -eq 2 && test "$(grep -c '^hbil: ' "$work/err")" -eq 1 &&
      grep -q '^hbil: device .*: HBIL_KERNEL_DIR .*/kernels: .*composite.cl' "$work/err"
    ok $? "$status_name"
    ;;
  HBIL_OPENCL_ERROR)
    fails "$status_name" 'device .*: clEnqueueNDRangeKernel.*CL_INVALID_' FAIL_LAUNCH=-52
    ;;
  *)
    echo "no command for it" >"$work/err"
    ok 1 "$status_name"
    ;;
  esac
done <"$work/statuses"

# --- every option that the library checks ---

for option in thickness=0 relative-thickness=-1 unit-scale=1e9 step-growth=65 \
  facing-fade=-2,0 facing-fade=1,0 offscreen-light=2 roughness=0.1 \
  disocclusion-threshold=0 'motion-scale=1e7,1 --reprojection motion'; do
  # shellcheck disable=SC2086
  rejected "--$option" "^hbil: --${option%%=*}: .*[0-9]" process --$option "$one"
done
rejected "half resolution without the filter" '--unfiltered: not with --resolution half' \
  process --resolution half --unfiltered "$one"
rejected "hbao's other radius" '--ao-radius.*--mode hbao' \
  process --mode hbao --ao-radius 1 "$one"
rejected "bounces beside near light" '--ao-bounces paper: not with --mode hbil' \
  process --ao-bounces paper "$one"
rejected "glossy light of cones" '--layers glossy: not with --far cones' \
  process --far cones --layers glossy "$one"

# --- a picture that is too large ---

# One pixel more than the library takes, by the header's word.
at=$(LC_ALL=C grep -a -b -o dataWindow "$one" | head -n 1 | cut -d : -f 1)
wide() { # FILE, and the bytes of the last pixel's x
  cp "$one" "$1"
  cp "${one%.exr}.json" "${1%.exr}.json"
  # xmin ymin xmax ymax follow the attribute's name, type and size
  # shellcheck disable=SC2059
  printf "$2" | dd of="$1" bs=1 seek=$((at + 21 + 8)) conv=notrunc 2>/dev/null
}
wide "$work/wide.exr" '\000\100\000\000'
size='wide.exr: 16385 x 18 pixels; .*at most 16384 x 16384'
rejected "a frame" "$size" process "$work/wide.exr"
rejected "a frame, for the exact integral" "$size" "$HBIL" process --quiet \
  --quality reference --slices 1 -o "$work/none" "$work/wide.exr"
rejected "the frame that decides" "$size" process --decide-by "$work/wide.exr" "$one"
rejected "a view" "$size" "$HBIL" process --quiet --view "$work/wide.exr" \
  -o "$work/none" "$one"
rejected "a view from a light" "$size" "$HBIL" process --quiet --far rsm \
  --light-view "$work/wide.exr" -o "$work/none" "$one"
wide "$work/left.exr" '\377\077\000\000'
# from pixel -1 on, so that both together are one pixel too wide
cp "$two" "$work/right.exr"
cp "${two%.exr}.json" "$work/right.json"
printf '\377\377\377\377' |
  dd of="$work/right.exr" bs=1 seek=$((at + 21)) conv=notrunc 2>/dev/null
rejected "frames that are too large together" \
  'right.exr: its data window makes that of all frames 16385 x 18 pixels; at most' \
  process "$work/left.exr" "$work/right.exr"
absent "what was rejected left nothing" "$work/none"

echo "1..$count"
