#!/bin/sh
# The command line: help, what `hbil compare` says, and bad input, which is
# rejected in one line and leaves nothing behind.
. "$srcdir/test/support/tap.sh"

# --- without input ---

says "the version is told" '^hbil [0-9]' "$HBIL" --version
says "help lists the commands" '^  process' "$HBIL" --help
for command in process info compare devices demo; do
  says "$command has help" "^usage: hbil $command" "$HBIL" $command --help
done
says "a device is listed" '^0  ' "$HBIL" devices
rejected "no command" 'hbil --help' "$HBIL"
rejected "an unknown command" 'nonsense' "$HBIL" nonsense
rejected "an unknown option" '--nonsense' "$HBIL" process --nonsense
rejected "an option without its value" 'needs a value' "$HBIL" process --radius

# --- a sequence of our own ---

works "the demo makes a sequence and lights it" \
  "$HBIL" demo --frames 2 --size 64x48 -o "$work/demo"
works "a second demo, of another size" \
  "$HBIL" demo --frames 1 --size 33x17 -o "$work/other"
# A lamp that the camera doesn't see lights the frame by what it shines at.
for scene in corner sky; do
  works "a demo with a view from the light of $scene" "$HBIL" demo --scene $scene \
    --light-view --frames 1 --size 64x48 -o "$work/$scene"
  works "the same without that view" "$HBIL" demo --scene $scene \
    --frames 1 --size 64x48 -o "$work/$scene-dim"
  differs "its light arrives in $scene" "$HBIL" compare --max-rmse .01 \
    "$work/$scene/frame_0001.exr:far_irradiance" \
    "$work/$scene-dim/frame_0001.exr:far_irradiance"
done
rejected "two kinds of views in one demo" '--views: not with --light-view' \
  "$HBIL" demo --views --light-view -o "$work/both"
one=$work/demo/gbuffer/frame_0001.exr
two=$work/demo/gbuffer/frame_0002.exr
other=$work/other/gbuffer/frame_0001.exr
says "position from depth and camera is that of the file" 'they agree' \
  "$HBIL" info "$one"

# The exact integral of few slices needs no device.
process() {
  "$HBIL" process --quiet --overwrite "$@"
}
compare() {
  "$HBIL" compare "$@"
}

works "a sequence is processed" process --quality reference --slices 2 \
  --warm-up 0 -o "$work/a" "$one" "$two"

# --- compare ---

a=$work/a/frame_0001.exr
differs "over the limit" compare --max-rmse 1e-6 "$a:near_irradiance" "$a:indirect"
says "within the limit" '^RMSE' compare --max-rmse 1e6 "$a:near_irradiance" "$a:indirect"
says "as JSON" '"rmse": [0-9]' compare --json "$a:near_irradiance" "$a:indirect"
awk -F'[:,]' '/"(within_95|largest_error|rmse)"/ { gsub(/[ "]/, "", $1); v[$1] = $2 }
  END { exit !(v["within_95"] > v["rmse"] && v["within_95"] < v["largest_error"]) }' \
  "$work/out"
ok $? "95 % are within more than the RMSE and less than the most"
works "with a heat map" \
  compare --heatmap "$work/heat.png" "$a:near_irradiance" "$a:indirect"
has "the heat map is there" "$work/heat.png"
works "masked by a G-buffer" compare --mask "$one" "$a:near_irradiance" "$a:indirect"
rejected "images of two sizes" 'one size' compare "$a:ao" \
  "$work/other/frame_0001.exr"
rejected "layers of other channels" 'same channels' compare "$a:near_irradiance" "$a:ao"
rejected "a layer that isn't there" 'no layer nothing' compare "$a:nothing" "$a"
rejected "a mask without depth" 'no depth' compare --mask "$a" "$a" "$a"
rejected "one file only" 'two are needed' compare "$a"

# --- bad input ---

out=$work/none
rejected "no output folder" '-o DIR' process "$one"
rejected "no frame" 'FRAME.exr' process -o "$out"
rejected "a bad number" '--radius' process -o "$out" --radius two "$one"
rejected "a bad word" 'none, camera, motion' \
  process -o "$out" --reprojection never "$one"
rejected "a bad setting" '.' process -o "$out" --radius=-1 "$one"
rejected "an unknown layer" '--layers' process -o "$out" --layers glow "$one"

rejected "a missing file" 'gone.exr' process -o "$out" "$work/gone.exr"
echo "not a picture" >"$work/text.exr"
rejected "not an EXR" 'text.exr: not an OpenEXR' \
  process -o "$out" "$work/text.exr"
mkdir "$work/holds"
rejected "a folder without frames" 'holds: holds no EXR file' \
  process -o "$out" "$work/holds"
size=$(wc -c <"$one")
dd if="$one" of="$work/cut.exr" bs=1 count=$((size / 2)) 2>/dev/null
cp "${one%.exr}.json" "$work/cut.json"
rejected "a truncated EXR" 'cut.exr: truncated' \
  process -o "$out" "$work/cut.exr"
dd if="$one" of="$work/header.exr" bs=1 count=100 2>/dev/null
rejected "an EXR cut within its header" 'header.exr: damaged' \
  process -o "$out" "$work/header.exr"
rejected "no depth channel" 'frame_0001.exr: no depth' process -o "$out" "$a"
rejected "info: no depth channel" 'frame_0001.exr: no depth' "$HBIL" info "$a"
rejected "frames of two sizes" '33 x 17.*64 x 48' \
  process -o "$out" "$one" "$other"
rejected "the same frame twice" 'frame_0001.exr: is given twice' \
  process -o "$out" "$one" "$one"
rejected "a result in place of its input" 'overwrite' \
  process -o "$work/demo/gbuffer" "$one"
absent "after bad input there is no output folder" "$out"

cp "$one" "$work/frame.exr"
rejected "no camera" 'frame.json: camera cannot be read' \
  process -o "$out" --map position= "$work/frame.exr"
rejected "no camera in the positions" 'it has no positions; a camera file' \
  process -o "$out" --camera positions --map position= "$work/frame.exr"
says "a camera in the positions" 'fitted to the positions: focal' \
  "$HBIL" info "$work/frame.exr"
camera=$work/camera.json
for field in fx fy cx cy camera_to_world; do
  sed "s/\"$field\"/\"no_$field\"/" "${one%.exr}.json" >"$camera"
  rejected "a camera without $field" "camera.json: field $field is missing" \
    process -o "$out" --camera "$camera" "$one"
done
sed 's/"fx": [-0-9.e+]*/"fx": "wide"/' "${one%.exr}.json" >"$camera"
rejected "a camera with a word for a number" 'field fx is wrong' \
  process -o "$out" --camera "$camera" "$one"
sed 's/"fx": [-0-9.e+]*/"fx": 0/' "${one%.exr}.json" >"$camera"
rejected "a camera without a focal length" 'field fx is wrong' \
  process -o "$out" --camera "$camera" "$one"
sed 's/"cx": [-0-9.e+]*/"cx": NaN/' "${one%.exr}.json" >"$camera"
rejected "a camera with NaN" 'camera.json: not JSON' \
  process -o "$out" --camera "$camera" "$one"
rejected "a camera that is not JSON" 'text.exr: not JSON' \
  process -o "$out" --camera "$work/text.exr" "$one"
rejected "the camera of another size" 'camera is for 33 x 17' \
  process -o "$out" --camera "${other%.exr}.json" "$one"

rejected "no such device" 'no such device' \
  process -o "$out" --device nonsense "$one"
absent "without a device there is no output folder" "$out"
mkdir "$work/empty"
OCL_ICD_VENDORS=$work/empty
export OCL_ICD_VENDORS
rejected "no OpenCL device" 'no OpenCL device' process -o "$out" "$one"
rejected "devices: no OpenCL device" 'no OpenCL device (.*: no platform)' \
  "$HBIL" devices
pocl=/etc/OpenCL/vendors/pocl.icd
if test -e $pocl; then
  OCL_ICD_VENDORS=$pocl
  rejected "devices: a platform without any" \
    'no OpenCL device (Portable Computing Language: no device)' \
    env POCL_DEVICES= "$HBIL" devices
else
  skip "devices: a platform without any" "no PoCL"
fi
# A driver that can't be loaded is told with what it lacks, once for each way to
# name it, and beside those that can be loaded.
vendors=$work/vendors
mkdir "$vendors"
echo "$work/libdriver.so" >"$vendors/driver.icd"
lacks() { # WHAT NAME
  rejected "a driver lacks $1: $2" \
    "no platform); a driver can't be loaded: .*$missing: cannot open shared object file" \
    "$HBIL" devices
}
missing=$work/libdriver.so
for OCL_ICD_VENDORS in "$vendors" "$vendors/driver.icd" "$missing"; do
  lacks "its library" "${OCL_ICD_VENDORS#"$work/"}"
done
echo 'void needed(void); void needed(void) {}' >"$work/needed.c"
echo 'void needed(void); void driver(void); void driver(void) { needed(); }' >"$work/driver.c"
if $CC -shared -fPIC -o "$work/libneeded.so" "$work/needed.c" 2>"$work/err" &&
  $CC -shared -fPIC -o "$work/libdriver.so" "$work/driver.c" -L"$work" -lneeded 2>"$work/err"; then
  rm "$work/libneeded.so"
  missing=libneeded.so OCL_ICD_VENDORS=$vendors
  lacks "a library of another package" vendors
else
  skip "a driver lacks a library of another package: vendors" "no shared libraries"
fi
: >"$vendors/empty.icd"
rejected "a driver's file without a name" 'empty.icd: it names no library' "$HBIL" devices
rm "$vendors/empty.icd"
name="devices: what is there, and the driver that is not"
if test -e $pocl; then
  cp $pocl "$vendors"
  OCL_ICD_VENDORS=$vendors
  run "$HBIL" devices
  test $status -eq 0 && grep -q '^0  ' "$work/out" &&
    test "$(cut -d : -f 1-2 "$work/err")" = "hbil: $vendors/driver.icd"
  ok $? "$name"
else
  skip "$name" "no PoCL"
fi
unset OCL_ICD_VENDORS

rejected "a file in place of the output folder" 'text.exr: output folder' \
  process -o "$work/text.exr" "$one"
if test -d /proc/self; then
  rejected "an output folder that cannot be written" '/proc: output folder' \
    process -o /proc "$one"
else
  skip "an output folder that cannot be written" "no /proc"
fi
rejected "an environment that is no image" 'text.exr: cannot be read' \
  process -o "$out" --environment "$work/text.exr" "$one"

# The first frame is whole, the second breaks off: what is written stays, and
# nothing half-written is beside it.
run process -o "$work/broken" "$one" "$work/cut.exr"
test $status -eq 2 &&
  test "$(ls -A "$work/broken" | tr '\n' ' ')" = ".hbil-light.frame_0001 frame_0001.exr "
ok $? "a sequence that breaks off leaves whole files only"

echo "1..$count"
