#!/bin/sh
# `hbil process` on a device, from the outside: layers, timings, histories, the
# modes, presets and the paper's model do what the help says.
. "$srcdir/test/support/tap.sh"

# Frames are lit as if they were alone: test_world.sh is about the radiance cache.
process() {
  "$HBIL" process --quiet --overwrite --far environment "$@"
}
compare() {
  "$HBIL" compare "$@"
}
# Most settings are tried with one frame and this much sampling, so that the
# kernels of one run serve the others.
fast='--slices 1 --steps-per-side 6'

works "a demo" "$HBIL" demo --frames 2 --size 64x48 -o "$work/demo"
one=$work/demo/gbuffer/frame_0001.exr
two=$work/demo/gbuffer/frame_0002.exr

# --- layers ---

works "a sequence is processed" process -o "$work/a" "$one" "$two"
has "every frame has its result" "$work/a/frame_0001.exr" \
  "$work/a/frame_0002.exr"
for layer in near_irradiance far_irradiance ao bent_normal cone_cosine indirect \
  beauty; do
  works "layer $layer is there and finite" compare --max-rmse 0 \
    "$work/a/frame_0002.exr:$layer" "$work/a/frame_0002.exr"
done
works "the same sequence once more" process -o "$work/b" "$one" "$two"
works "two runs give the same bits" \
  compare --max-rmse 0 "$work/a/frame_0002.exr" "$work/b/frame_0002.exr"

# The device makes the halves unless the program needs floats for pictures.
works "halves from the device" process --precision half -o "$work/h" "$one" "$two"
works "halves from the program" process --precision half --preview -o "$work/p" "$one" "$two"
works "are the same" compare --max-rmse 0 "$work/h/frame_0002.exr" "$work/p/frame_0002.exr"
works "and those of the floats, rounded" compare --max-rmse 2.5e-4 \
  "$work/h/frame_0002.exr:ao" "$work/a/frame_0002.exr:ao"
cmp -s "$work/h/frame_0001.exr" "$work/a/frame_0001.exr"
test $? -ne 0
ok $? "which they are not"

# Light beyond the largest half, made by each of the two.
clipped='^hbil: warning: half floats end at 65504, at which [0-9]* pixels of far_irradiance are clipped; --precision float holds them$'
for way in half "half --preview" float; do
  # shellcheck disable=SC2086
  run "$HBIL" process --overwrite $fast --warm-up 0 --far environment --layers ao,far_irradiance \
    --environment 1e6,0,0 --precision $way -o "$work/guess" "$one" "$two"
  test $status -eq 0 &&
    test "$(grep -c "$clipped" "$work/err")" -eq "$(test "$way" = float && echo 0 || echo 1)"
  ok $? "a warning tells how many pixels are clipped: $way"
done

works "only some layers" \
  process --layers ao,near_irradiance -o "$work/some" --preview "$one"
# Another variant of the gather: roundings, and sectors that they move.
works "the layer that was asked for is the same" compare --max-rmse 1e-4 \
  "$work/some/frame_0001.exr:ao" "$work/a/frame_0001.exr"
rejected "there is no other layer" 'no layer beauty' \
  compare "$work/some/frame_0001.exr:beauty" "$work/a/frame_0001.exr"
has "each layer has a preview" "$work/some/frame_0001.ao.png" \
  "$work/some/frame_0001.near_irradiance.png"
absent "other layers have none" "$work/some/frame_0001.beauty.png"

# --- light that is a guess ---

guessed() {
  sed -n "s/^hbil: unknown: the light of \([0-9.]*\) % of what surfaces see is a guess$/\1/p" \
    "$work/err"
}
warned='^hbil: warning: most of the indirect light is a guess, .*--environment'
run "$HBIL" process --overwrite --far environment --warm-up 0 --environment frame \
  --timings --json -o "$work/guess" "$one" "$two"
test $status -eq 0 && test "$(guessed | wc -l)" -eq 1 &&
  ! grep -q "$warned" "$work/err" &&
  awk -v said="$(guessed)" '/"unknown": / { share = 100 * ($2 + 0); n++ }
    END { exit !(n == 3 && said > 20 && said < 50 && said - share < .1 &&
                 share - said < .1) }' "$work/out"
ok $? "the share of light that is a guess is printed once, and in JSON"
rejected "its layer is written on request alone" 'no layer unknown' \
  compare "$work/guess/frame_0001.exr:unknown" "$work/guess/frame_0001.exr"
# shellcheck disable=SC2086
run "$HBIL" process --overwrite --far environment $fast --warm-up 0 --environment frame \
  --layers unknown,ao -o "$work/share" "$one" "$two"
test $status -eq 0 && test -n "$(guessed)"
ok $? "--layers unknown"
works "has a value everywhere" compare --max-rmse 0 \
  "$work/share/frame_0001.exr:unknown" "$work/share/frame_0001.exr"
# The frame's estimate takes all open directions, where no sky shines.
works "which is that of ao in a room" compare --max-rmse 1e-6 --mask "$one" \
  "$work/share/frame_0001.exr:unknown" "$work/share/frame_0001.exr:ao"
# shellcheck disable=SC2086
run "$HBIL" process --overwrite --far environment $fast --warm-up 0 --environment frame \
  --radius 0.1 -o "$work/guess" "$one" "$two"
test $status -eq 0 && test "$(grep -c "$warned" "$work/err")" -eq 1 &&
  ! grep -q -e '--learn' "$work/err"
ok $? "a warning says once that most of the light is a guess; --learn needs a cache"
works "a scene that shows little" "$HBIL" demo --scene corner --frames 2 --size 80x45 \
  -o "$work/corner"
# shellcheck disable=SC2086
run "$HBIL" process --overwrite --far rays --cache-size 16 $fast --warm-up 0 \
  -o "$work/guess" "$work"/corner/gbuffer/frame_000[12].exr
test $status -eq 0 && grep -q "$warned" "$work/err" &&
  grep -q -e ', --learn if later frames' "$work/err"
ok $? "where there is one, it helps"
# shellcheck disable=SC2086
run "$HBIL" process --overwrite --far rays --cache-size 16 $fast --warm-up 0 \
  -o "$work/guess" "$work/corner/gbuffer/frame_0001.exr"
test $status -eq 0 && grep -q "$warned" "$work/err" && ! grep -q -e '--learn' "$work/err"
ok $? "but has nothing to learn from in a single frame"
# shellcheck disable=SC2086
run process $fast --warm-up 0 --environment frame --radius 0.1 \
  -o "$work/guess" "$one"
test $status -eq 0 && test ! -s "$work/err"
ok $? "--quiet doesn't"
# shellcheck disable=SC2086
run "$HBIL" process --overwrite $fast --warm-up 0 --environment none \
  -o "$work/guess" "$one"
test $status -eq 0 && test -z "$(guessed)" && ! grep -q "$warned" "$work/err"
ok $? "without a guess there is no such line"

# --- light ---

# shellcheck disable=SC2086
run "$HBIL" process --overwrite $fast --warm-up 0 --far environment --map direct= \
  -o "$work/guess" "$one"
test $status -eq 0 && grep -q 'warning: no direct light; emission alone' "$work/err"
ok $? "a frame without direct light is told of, where emission lights it"

# --- timings ---

says "timings have a column for each pass" \
  'reproject *push_pull *split *gather *recompose *composite' \
  process --timings -o "$work/t" "$one"
run process --timings --json -o "$work/t" "$one" "$two"
missing=$status
for pass in reproject push_pull split gather recompose composite; do
  grep -q "\"$pass\": [0-9]" "$work/out" || missing=1
done
ok $missing "timings as JSON have a member for each pass"
grep -q '"motion": 0' "$work/out"
ok $? "and the number of values that were sanitized"
# the parts of a job and what remains are its whole time, to the last digits
sums='/"job": {/ { inside = 1; next }
  inside && /}/ { inside = 0 }
  inside { gsub("[\",:]", " "); value[$1] = $2; if ($2 < 0) wrong = 1
    if ($1 != "total") { sum += $2; parts++ } }
  END { off = sum - value["total"]
    exit wrong || parts != 7 || !(value["frames"] > 0) || !(value["build"] > 0) ||
      !(value["open"] > 0) || !(value["read"] > 0) || off > 0.01 || off < -0.01 }'
awk "$sums" "$work/out"
ok $? "and the parts of the job, which are the whole"
says "the table has them, too" \
  '^wall, ms *open *read *choose *build *learn *frames *other *total$' \
  process --timings --overwrite -o "$work/t" "$one"
awk '/^wall, ms/ { getline; for (i = 2; i < NF; i++) sum += $i
    found = 1; off = sum - $NF }
  END { exit !found || off > 0.01 || off < -0.01 }' "$work/out"
ok $? "and they add up"

# --- values that mean nothing ---

name="values that mean nothing are counted in one line"
if command -v oiiotool >/dev/null; then
  # of the channels in their order: albedo, depth, direct light, ...
  oiiotool "$one" --mulc 17,17,17,1,-1,-1,-1,1,1,1,1,1,1,1,1,1,1,1 -o "$work/dark.exr" >"$work/out" 2>&1
  cp "${one%.exr}.json" "$work/dark.json"
  # shellcheck disable=SC2086
  run "$HBIL" process --overwrite --far environment $fast --warm-up 0 -o "$work/t" "$two" "$work/dark.exr"
  replaced='^hbil: warning: pixels whose values mean nothing (.* albedo above 1,.*) were replaced: albedo [0-9]*, direct [0-9]*; the first ones in'
  test $status -eq 0 && test "$(grep -c "$replaced .*/dark.exr (hbil info)\$" "$work/err")" -eq 1
  ok $? "$name"
else
  skip "$name" "no oiiotool"
fi

# --- histories ---

# shellcheck disable=SC2086
works "one run of a frame without history" \
  process $fast --reprojection none -o "$work/single" "$one"
# shellcheck disable=SC2086
works "three runs of it" \
  process $fast --reprojection none --repeat 3 -o "$work/repeated" "$one"
works "are the same" compare --max-rmse 0 "$work/single/frame_0001.exr" \
  "$work/repeated/frame_0001.exr"
for way in camera motion; do
  # shellcheck disable=SC2086
  works "three runs by $way" \
    process $fast --reprojection $way --repeat 3 -o "$work/$way" "$one"
  differs "add bounces" compare --max-rmse 0 \
    "$work/single/frame_0001.exr:near_irradiance" "$work/$way/frame_0001.exr"
done
works "a static frame is the same by the camera and by motion" \
  compare --max-rmse 1e-3 "$work/camera/frame_0001.exr:near_irradiance" \
  "$work/motion/frame_0001.exr"

# --- frames that don't change ---

cp "$one" "$work/again.exr"
cp "${one%.exr}.json" "$work/again.json"
for way in "" --no-skip; do
  # shellcheck disable=SC2086
  works "a frame twice${way:+, $way}" process $fast --timings $way \
    -o "$work/again$way" "$one" "$work/again.exr"
  cp "$work/out" "$work/again$way.txt"
done
grep -q '/again.exr .*no reproject; no push_pull' "$work/again.txt" &&
  ! grep -q 'no split\|no gather' "$work/again--no-skip.txt"
ok $? "is recognized, unless with --no-skip"
works "and has the same light" compare --max-rmse 0 \
  "$work/again/again.exr" "$work/again--no-skip/again.exr"

# --- settings ---

works "every setting is accepted" \
  process -o "$work/settings" --model paper --radius 2.5 --slices 1 --steps-per-side 6 \
  --step-growth 1 --sample-grid same-layer --facing-fade=-0.2,0.1 \
  --back-facing-fallback black --disocclusion-threshold 0.1 \
  --gather-emission no --unfiltered --environment 1,0.5,0.25 --device 0 \
  --camera "${one%.exr}.json" "$one"
differs "an environment changes the far field" compare --max-rmse 0 \
  "$work/settings/frame_0001.exr:far_irradiance" "$work/a/frame_0001.exr"
# shellcheck disable=SC2086
works "an image as environment" process $fast -o "$work/map" \
  --environment "$work/some/frame_0001.ao.png" "$one"

# --- kernels ---

POCL_CACHE_DIR=$work/fresh process --layers ao --reprojection none \
  -o "$work/t" "$one" 2>"$work/warnings"
ok $? "a first run, without compiled kernels"
test ! -s "$work/warnings"
ok $? "no kernel has a compiler's warning"

# --- modes ---

for mode in gtao hbao; do
  works "$mode writes every layer that it has" \
    process --mode $mode -o "$work/$mode" "$one"
  rejected "$mode has no near light" \
    "--layers near_irradiance: not with --mode $mode" \
    process --mode $mode --layers ao,near_irradiance -o "$work/never" "$one"
  rejected "$mode takes no light from the frame" \
    "--environment frame: not with --mode" \
    process --mode $mode --environment frame -o "$work/never" "$one"
  rejected "$mode writes no layer of near light" 'no layer near_irradiance' \
    compare "$work/$mode/frame_0001.exr:near_irradiance" "$work/a/frame_0001.exr"
done
works "gtao has the occlusion of hbil" \
  compare --max-rmse 1e-6 "$work/gtao/frame_0001.exr:ao" "$work/a/frame_0001.exr"
works "and its bent normals" compare --max-rmse 1e-6 \
  "$work/gtao/frame_0001.exr:bent_normal" "$work/a/frame_0001.exr"
rejected "hbao has none" '--layers bent_normal: not with --mode hbao' \
  process --mode hbao --layers bent_normal -o "$work/never" "$one"
rejected "hbao takes no map" 'a map is not possible' \
  process --mode hbao --environment "$work/some/frame_0001.ao.png" \
  -o "$work/never" "$one"
run "$HBIL" process --overwrite --mode gtao -o "$work/gtao" "$one"
test $status -eq 0 && grep -q 'unblocked directions: none' "$work/err"
ok $? "gtao says that it has no far light"
for falloff in linear soft none; do
  works "hbao, falloff $falloff" process --mode hbao --falloff $falloff \
    --radius 1 -o "$work/falloff-$falloff" "$one"
done
differs "falloffs differ" compare --max-rmse 1e-3 \
  "$work/falloff-linear/frame_0001.exr:ao" "$work/falloff-none/frame_0001.exr"
rejected "a falloff needs hbao" '--mode hbao is needed' \
  process --falloff soft -o "$work/never" "$one"
for bounces in none albedo; do
  works "gtao, bounces $bounces" process --mode gtao --environment 1,1,1 \
    --ao-bounces $bounces -o "$work/bounces-$bounces" "$one"
done
works "bounces leave the occlusion" compare --max-rmse 0 \
  "$work/bounces-albedo/frame_0001.exr:ao" "$work/bounces-none/frame_0001.exr"
differs "bounces change the light" compare --max-rmse 1e-2 \
  "$work/bounces-albedo/frame_0001.exr:indirect" \
  "$work/bounces-none/frame_0001.exr"
rejected "an unknown mode" 'one of hbil, gtao, hbao' \
  process --mode ssao -o "$work/never" "$one"

# --- models and presets ---

# The paper's model, and the same in single settings.
works "the paper's model" process --model paper -o "$work/paper" "$one"
differs "is not the default" compare --max-rmse 1e-3 \
  "$work/paper/frame_0001.exr:near_irradiance" "$work/a/frame_0001.exr"
works "has no far field" process --model paper --layers ao,far_irradiance \
  -o "$work/paper-far" "$one"
works "and 8 equal steps a side" process --model paper --steps-per-side 8 \
  --step-growth 0 --warm-up 0 \
  --relative-thickness inf -o "$work/paper8" "$one"
works "which are its defaults" compare --max-rmse 0 "$work/paper/frame_0001.exr" \
  "$work/paper8/frame_0001.exr"
rejected "an unknown model" 'default, paper' \
  process --model other -o "$work/never" "$one"

for quality in fast balanced high; do
  works "quality $quality" \
    process --quality $quality --layers ao -o "$work/$quality" "$one"
done
sampling='--slices 1 --steps-per-side 6 --step-growth 2
  --sample-grid full-resolution'
# shellcheck disable=SC2086
works "options after a preset" \
  process --quality high $sampling -o "$work/changed" "$one"
# shellcheck disable=SC2086
works "options alone" process $sampling -o "$work/alone" "$one"
works "give the same" compare --max-rmse 0 "$work/changed/frame_0001.exr" \
  "$work/alone/frame_0001.exr"
rejected "an unknown preset" 'fast, balanced, high, reference' \
  process --quality best -o "$work/never" "$one"
rejected "too many slices for a device" 'from 1 to 32, or --quality reference' \
  process --slices 64 -o "$work/never" "$one"
absent "what was rejected left nothing" "$work/never"

echo "1..$count"
