#!/bin/sh
# The tool from the outside: what it does, what it refuses and how it says so.
#
# Speaks TAP.
srcdir=${srcdir:-$(dirname "$0")/..}
. "$srcdir/test/tap.sh"

# --- without input ---

says "the version is told" '^hbil [0-9]' "$HBIL" --version
says "help lists the commands" '^  process' "$HBIL" --help
for command in process info compare devices demo; do
  says "$command has help" "^usage: hbil $command" "$HBIL" $command --help
done
says "a device is listed" '^0  ' "$HBIL" devices
refused "no command" 'hbil --help' "$HBIL"
refused "an unknown command" 'nonsense' "$HBIL" nonsense
refused "an unknown option" '--nonsense' "$HBIL" process --nonsense
refused "an option without its value" 'needs a value' "$HBIL" process --radius

# --- a sequence of our own ---

works "the demo makes and lights a sequence" \
  "$HBIL" demo --frames 2 --size 64x48 -o "$work/demo"
works "a second demo, of another size" \
  "$HBIL" demo --frames 1 --size 33x17 -o "$work/other"
one=$work/demo/gbuffer/frame_0001.exr
two=$work/demo/gbuffer/frame_0002.exr
other=$work/other/gbuffer/frame_0001.exr
says "position from depth and camera is that of the file" 'they agree' \
  "$HBIL" info "$one"

process() {
  "$HBIL" process --quiet --overwrite "$@"
}
compare() {
  "$HBIL" compare "$@"
}

works "a sequence is processed" process -o "$work/a" "$one" "$two"
has "every frame has its result" "$work/a/frame_0001.exr" \
  "$work/a/frame_0002.exr"
for l in near_irradiance far_irradiance indirect ao bent_normal cone_cosine beauty; do
  works "layer $l is there and finite" \
    compare --max-rmse 0 "$work/a/frame_0002.exr:$l" "$work/a/frame_0002.exr"
done
works "the same again" process -o "$work/b" "$one" "$two"
works "two runs give the same bits" \
  compare --max-rmse 0 "$work/a/frame_0002.exr" "$work/b/frame_0002.exr"

works "only some layers" \
  process --layers ao,near_irradiance -o "$work/some" --preview "$one"
# another build of the gather: rounding, and what it moves across a sector
works "asked for: AO" \
  compare --max-rmse 1e-4 "$work/some/frame_0001.exr:ao" "$work/a/frame_0001.exr"
refused "not asked for: beauty" 'no layer beauty' \
  compare "$work/some/frame_0001.exr:beauty" "$work/a/frame_0001.exr"
has "a preview for each layer" "$work/some/frame_0001.ao.png" \
  "$work/some/frame_0001.near_irradiance.png"
absent "no preview of other layers" "$work/some/frame_0001.beauty.png"

says "timings have a column for each pass" \
  'reproject *push_pull *split *gather *recompose *temporal *composite' \
  process --timings -o "$work/t" "$one"
run process --timings --json -o "$work/t" "$one" "$two"
missing=$status
for pass in reproject push_pull split gather recompose composite; do
  grep -q "\"$pass\": [0-9]" "$work/out" || missing=1
done
ok $missing "timings as JSON have a member for each pass"
grep -q '"motion": 0' "$work/out"
ok $? "and count what was repaired"
works "a frame by itself" \
  process --reprojection none -o "$work/still" "$one"
works "the frame repeated, nothing carried" \
  process --reprojection none --repeat 3 -o "$work/still3" "$one"
works "repeating without history changes nothing" \
  compare --max-rmse 0 "$work/still/frame_0001.exr" "$work/still3/frame_0001.exr"
for way in scatter motion; do
  works "the frame repeated, by $way" \
    process --reprojection $way --repeat 3 -o "$work/$way" "$one"
  differs "repeating adds bounces, by $way" compare --max-rmse 0 \
    "$work/still/frame_0001.exr:near_irradiance" "$work/$way/frame_0001.exr"
done
# Three runs of a frame by itself are its warm-up.
says "a frame's later runs use the horizon cache" 'from the horizon cache 9[0-9.]* %' \
  process --repeat 5 --timings -o "$work/factors" "$one"
run process --repeat 4 --timings -o "$work/t" "$one"
test $status -eq 0 && ! grep -q 'horizon cache' "$work/out"
ok $? "but not where they are few"
run sh -c 'ulimit -v 4000000 && exec "$@"' sh "$HBIL" process --repeat 5 --timings \
  --overwrite -o "$work/t" "$one"
test $status -eq 0 && ! grep -q 'horizon cache' "$work/out"
ok $? "nor unasked where memory is limited"
run process --repeat 5 --horizon-cache 0 --timings -o "$work/no_factors" "$one"
test $status -eq 0 && ! grep -q 'horizon cache' "$work/out" &&
  cmp "$work/factors/frame_0001.exr" "$work/no_factors/frame_0001.exr"
ok $? "nor where they may take no memory, which changes no bit"
run process --repeat 3 --horizon-cache 1 --timings --json -o "$work/t" "$one"
test $status -eq 0 && grep -A 1 '"cached"' "$work/out" | grep -q '"pixels": [1-9]'
ok $? "and as far as there is memory"

works "a still frame by scatter or by motion is the same" \
  compare --max-rmse 1e-3 "$work/scatter/frame_0001.exr:near_irradiance" \
  "$work/motion/frame_0001.exr"

works "every setting is taken" \
  process -o "$work/settings" --model paper --radius 2.5 --slices 1 --steps-per-side 4 \
  --step-growth 1 --sample-grid same-layer --facing-fade=-0.2,0.1 --back-facing-fallback black \
  --disocclusion-threshold 0.1 --gather-emission no --unfiltered \
  --environment 1,0.5,0.25 --device 0 --camera "${one%.exr}.json" "$one"
differs "an environment gives far light" compare --max-rmse 0 \
  "$work/settings/frame_0001.exr:far_irradiance" "$work/a/frame_0001.exr"
works "an image as environment" \
  process -o "$work/map" --environment "$work/some/frame_0001.ao.png" "$one"

# --- modes and presets ---

for mode in gtao hbao; do
  works "$mode writes all that it has" \
    process --mode $mode -o "$work/$mode" "$one"
  refused "$mode has no near light" "--layers near_irradiance: not with --mode $mode" \
    process --mode $mode --layers ao,near_irradiance -o "$work/never" "$one"
  refused "$mode looks at no light" "--environment frame: not with --mode" \
    process --mode $mode --environment frame -o "$work/never" "$one"
  refused "$mode: no layer near_irradiance" 'no layer near_irradiance' \
    compare "$work/$mode/frame_0001.exr:near_irradiance" "$work/a/frame_0001.exr"
done
works "gtao's occlusion is hbil's" \
  compare --max-rmse 1e-6 "$work/gtao/frame_0001.exr:ao" "$work/a/frame_0001.exr"
works "gtao has bent normals" \
  compare --max-rmse 1e-6 "$work/gtao/frame_0001.exr:bent_normal" \
  "$work/a/frame_0001.exr"
refused "hbao has none" '--layers bent_normal: not with --mode hbao' \
  process --mode hbao --layers bent_normal -o "$work/never" "$one"
refused "hbao takes no map" 'a map is not possible' \
  process --mode hbao --environment "$work/some/frame_0001.ao.png" \
  -o "$work/never" "$one"
run "$HBIL" process --overwrite --mode gtao -o "$work/gtao" "$one"
test $status -eq 0 && grep -q 'unblocked directions: none' "$work/err"
ok $? "gtao says that it takes no far light"
for falloff in linear soft none; do
  works "hbao, falloff $falloff" process --mode hbao --falloff $falloff \
    --radius 1 -o "$work/falloff-$falloff" "$one"
done
differs "falloffs differ" compare --max-rmse 1e-3 \
  "$work/falloff-linear/frame_0001.exr:ao" "$work/falloff-none/frame_0001.exr"
refused "a falloff without hbao" '--mode hbao is needed' \
  process --falloff soft -o "$work/never" "$one"
refused "an unknown mode" 'one of hbil, gtao, hbao' \
  process --mode ssao -o "$work/never" "$one"

for quality in fast balanced high; do
  works "quality $quality" \
    process --quality $quality -o "$work/$quality" "$one"
done
works "what follows a preset has the last word" process --quality fast \
  --slices 2 --steps-per-side 48 --step-growth 2 --sample-grid full-resolution \
  -o "$work/fast48" "$one"
works "and is the default, then" compare --max-rmse 0 \
  "$work/fast48/frame_0001.exr" "$work/a/frame_0001.exr"
refused "an unknown preset" 'fast, balanced, high, reference' \
  process --quality best -o "$work/never" "$one"
refused "too many slices for a device" 'from 1 to 32, or --quality reference' \
  process --slices 64 -o "$work/never" "$one"

# --- the exact integral ---

exact() {
  OCL_ICD_VENDORS=$work/nothing "$HBIL" process --overwrite \
    --quality reference --slices 64 --warm-up 0 "$@"
}
dense() {
  process --slices 32 --steps-per-side 256 --step-growth 0 --unfiltered --warm-up 0 "$@"
}
# agrees NAME LAYER LIMIT: the second frame, which has what the first carries.
agrees() {
  works "$1" compare --max-rmse "$3" "$work/exact/frame_0002.exr:$2" \
    "$work/dense/frame_0002.exr:$2"
}
mkdir "$work/nothing"
works "a third demo, for the exact integral" \
  "$HBIL" demo --frames 2 --size 40x30 -o "$work/small"
first=$work/small/gbuffer/frame_0001.exr
second=$work/small/gbuffer/frame_0002.exr
# Occluders without end: 256 steps a side meet every pixel of a row of 40, so
# only 64 slices for all pixels against 32 that turn from pixel to pixel, and
# samples that are snapped to pixels are left: .002 of AO is measured.  E_near
# and the bent normal deviate as much, E_near times some radiance (here .015).
for way in scatter motion; do
  works "exact, no device, by $way" exact --relative-thickness inf \
    --environment frame --reprojection $way -o "$work/exact" "$first" "$second"
  works "densest, by $way" dense --relative-thickness inf \
    --environment frame --reprojection $way -o "$work/dense" "$first" "$second"
  agrees "exact agrees, by $way: AO" ao 0.004
  agrees "exact agrees, by $way: near" near_irradiance 0.03
  agrees "exact agrees, by $way: far" far_irradiance 0.01
  agrees "exact agrees, by $way: indirect" indirect 0.012
  agrees "exact agrees, by $way: bent" bent_normal 0.007
  agrees "exact agrees, by $way: beauty" beauty 0.008
done
# Parallel rays see a room from above, with more edges that some of so many
# slices meet and others don't: exact results of 32 and of 48 slices are .006 of
# AO apart by themselves, where it is .0015 above.
works "a demo of parallel rays" \
  "$HBIL" demo --orthographic --frames 2 --size 40x30 -o "$work/parallel"
flat=$work/parallel/gbuffer
works "exact, parallel rays" exact --relative-thickness inf \
  --environment frame -o "$work/exact" "$flat/frame_0001.exr" \
  "$flat/frame_0002.exr"
works "densest, parallel rays" dense --relative-thickness inf \
  --environment frame -o "$work/dense" "$flat/frame_0001.exr" \
  "$flat/frame_0002.exr"
agrees "exact agrees, parallel rays: AO" ao 0.012
agrees "exact agrees, parallel rays: near" near_irradiance 0.03
agrees "exact agrees, parallel rays: far" far_irradiance 0.01
agrees "exact agrees, parallel rays: indirect" indirect 0.012
agrees "exact agrees, parallel rays: bent" bent_normal 0.025
agrees "exact agrees, parallel rays: beauty" beauty 0.008
works "few samples" process --relative-thickness inf --environment frame \
  --steps-per-side 4 -o "$work/few" "$first" "$second"
differs "are told from it" compare --max-rmse 0.03 \
  "$work/exact/frame_0002.exr:ao" "$work/few/frame_0002.exr"
# Occluders that end: the library has 32 sectors a side, rounded alike in all
# slices of a pixel, 1/(32 sqrt(12)) = .009 of AO.
run exact -o "$work/exact" "$first" "$second"
test $status -eq 0 && grep -q 'exact integral of 2 frames, 2 runs.*about' \
  "$work/err" && grep -q 'exact integral: 100 %' "$work/err"
ok $? "the exact integral tells how long it takes and how far it is"
works "densest, thick occluders" dense -o "$work/dense" "$first" "$second"
agrees "exact agrees, thick occluders: AO" ao 0.013
agrees "exact agrees, thick occluders: near" near_irradiance 0.013
works "exact hbao" exact --mode hbao --relative-thickness inf --radius 2 \
  -o "$work/exact" "$second"
works "densest hbao" dense --mode hbao --relative-thickness inf --radius 2 \
  -o "$work/dense" "$second"
agrees "exact agrees: hbao" ao 0.006
run exact --quiet -o "$work/exact" "$first"
test $status -eq 0 && test ! -s "$work/err"
ok $? "the exact integral is quiet if asked to"
for useless in '--steps-per-side 8' '--step-growth 1' '--sample-grid full-resolution' '--unfiltered' \
  '--device 0' '--timings' '--json'; do
  # shellcheck disable=SC2086
  refused "the exact integral without ${useless% *}" \
    "${useless% *}: not with --quality reference" \
    exact $useless -o "$work/never" "$first"
done
refused "the exact integral with too many slices" 'from 1 to 4096' \
  exact --slices 5000 -o "$work/never" "$first"
refused "the exact integral with a bad radius" '--radius -1: a positive' \
  exact --radius=-1 -o "$work/never" "$first"
refused "the exact integral with a bad facing" '--facing-fade 1,0' \
  exact --facing-fade=1,0 -o "$work/never" "$first"
absent "what was refused left nothing" "$work/never"

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
refused "images of two sizes" 'one size' compare "$a:ao" \
  "$work/other/frame_0001.exr"
refused "layers of other channels" 'same channels' compare "$a:near_irradiance" "$a:ao"
refused "a layer that isn't there" 'no layer nothing' compare "$a:nothing" "$a"
refused "a mask without depth" 'no depth' compare --mask "$a" "$a" "$a"
refused "one file only" 'two are needed' compare "$a"

# --- a first run ---

rm -rf "$work/fresh"
POCL_CACHE_DIR=$work/fresh process -o "$work/t" "$one" 2>"$work/warnings"
ok $? "a first run, without any kernel at hand"
test ! -s "$work/warnings"
ok $? "no kernel has a compiler's warning"
cp "$one" "$work/again.exr"
cp "${one%.exr}.json" "$work/again.json"
for way in "" --no-skip; do
  works "a frame again${way:+, $way}" \
    process --timings $way -o "$work/again$way" "$one" "$work/again.exr"
  cp "$work/out" "$work/again$way.txt"
done
grep -q '/again.exr .*no reproject; no push_pull' "$work/again.txt" &&
  ! grep -q 'no split\|no gather' "$work/again--no-skip.txt"
ok $? "a frame again is found out, and not with --no-skip"
works "and light is the same" compare --max-rmse 0 \
  "$work/again/again.exr" "$work/again--no-skip/again.exr"

# --- bad input ---

out=$work/none
refused "no output folder" '-o DIR' process "$one"
refused "no frame" 'FRAME.exr' process -o "$out"
refused "a bad number" '--radius' process -o "$out" --radius two "$one"
refused "a bad word" 'none, scatter, motion' \
  process -o "$out" --reprojection never "$one"
refused "a bad setting" '.' process -o "$out" --radius=-1 "$one"
refused "an unknown layer" '--layers' process -o "$out" --layers glow "$one"

refused "a missing file" 'gone.exr' process -o "$out" "$work/gone.exr"
echo "not a picture" >"$work/text.exr"
refused "not an EXR" 'text.exr: not an OpenEXR' \
  process -o "$out" "$work/text.exr"
refused "a folder in place of a file" "$work: " process -o "$out" "$work"
size=$(wc -c <"$one")
dd if="$one" of="$work/cut.exr" bs=1 count=$((size / 2)) 2>/dev/null
cp "${one%.exr}.json" "$work/cut.json"
refused "a truncated EXR" 'cut.exr: truncated' \
  process -o "$out" "$work/cut.exr"
dd if="$one" of="$work/header.exr" bs=1 count=100 2>/dev/null
refused "an EXR cut within its header" 'header.exr: damaged' \
  process -o "$out" "$work/header.exr"
refused "no depth channel" 'frame_0001.exr: no depth' process -o "$out" "$a"
refused "info: no depth channel" 'frame_0001.exr: no depth' "$HBIL" info "$a"
refused "frames of two sizes" '33 x 17.*64 x 48' \
  process -o "$out" "$one" "$other"
refused "the same result twice" 'different file names' \
  process -o "$out" "$one" "$one"
refused "a result in place of its input" 'overwrite' \
  process -o "$work/demo/gbuffer" "$one"
absent "after bad input there is no output folder" "$out"

cp "$one" "$work/frame.exr"
refused "no camera" 'frame.json: camera cannot be read' \
  process -o "$out" "$work/frame.exr"
camera=$work/camera.json
for field in fx fy cx cy camera_to_world; do
  sed "s/\"$field\"/\"no_$field\"/" "${one%.exr}.json" >"$camera"
  refused "a camera without $field" "camera.json: field $field is missing" \
    process -o "$out" --camera "$camera" "$one"
done
sed 's/"fx": [-0-9.e+]*/"fx": "wide"/' "${one%.exr}.json" >"$camera"
refused "a camera with a word for a number" 'field fx is wrong' \
  process -o "$out" --camera "$camera" "$one"
sed 's/"fx": [-0-9.e+]*/"fx": 0/' "${one%.exr}.json" >"$camera"
refused "a camera without a focal length" 'field fx is wrong' \
  process -o "$out" --camera "$camera" "$one"
sed 's/"cx": [-0-9.e+]*/"cx": NaN/' "${one%.exr}.json" >"$camera"
refused "a camera with NaN" 'camera.json: not JSON' \
  process -o "$out" --camera "$camera" "$one"
refused "a camera that is not JSON" 'text.exr: not JSON' \
  process -o "$out" --camera "$work/text.exr" "$one"
refused "the camera of another size" 'camera is for 33 x 17' \
  process -o "$out" --camera "${other%.exr}.json" "$one"

refused "no such device" 'no such device' \
  process -o "$out" --device nonsense "$one"
absent "without a device there is no output folder" "$out"
mkdir "$work/empty"
OCL_ICD_VENDORS=$work/empty
export OCL_ICD_VENDORS
refused "no OpenCL device" 'no OpenCL device' process -o "$out" "$one"
refused "devices: no OpenCL device" 'no OpenCL device' "$HBIL" devices
unset OCL_ICD_VENDORS

refused "an output folder without a parent" 'none/deeper: output folder' \
  process -o "$out/deeper" "$one"
refused "a file in place of the output folder" 'text.exr: output folder' \
  process -o "$work/text.exr" "$one"
if test -d /proc/self; then
  refused "an output folder that cannot be written" '/proc: output folder' \
    process -o /proc "$one"
else
  skip "an output folder that cannot be written" "no /proc"
fi
refused "an environment that is no image" 'text.exr: cannot be read' \
  process -o "$out" --environment "$work/text.exr" "$one"

# The first frame is whole, the second breaks off: what is written stays, and
# nothing half-written is beside it.
run process -o "$work/broken" "$one" "$work/cut.exr"
test $status -eq 2 &&
  test "$(ls -A "$work/broken" | tr '\n' ' ')" = ".hbil-light frame_0001.exr "
ok $? "a sequence that breaks off leaves whole files only"

# --- real dumps ---

if test -d "$HBIL_DATA"; then
  for scene in cornell staircase veach_bidir viking_ao; do
    frame=$HBIL_DATA/$scene/frame_0006.exr
    truth=$HBIL_DATA/$scene/truth_avg_0006.exr
    says "$scene: understood" '100.0 % face the eye' "$HBIL" info "$frame"
    works "$scene: processed" process -o "$work/$scene" "$frame"
    works "$scene: finite in every layer" compare --max-rmse 0 \
      "$work/$scene/frame_0006.exr" "$work/$scene/frame_0006.exr"
    says "$scene: compared with the path tracer" '^RMSE' \
      compare --mask "$frame" "$work/$scene/frame_0006.exr:indirect" \
      "$truth:DiffInd"
  done
  says "cornell: the noise of its truth" 'RMSE *0.00540342' \
    compare --mask "$HBIL_DATA/cornell/frame_0006.exr" \
    "$HBIL_DATA/cornell/frame_0006.exr:DiffInd" \
    "$HBIL_DATA/cornell/seedB_0006.exr"
else
  skip "real dumps" "no dumps"
fi

echo "1..$count"
