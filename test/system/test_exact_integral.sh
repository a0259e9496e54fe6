#!/bin/sh
# The exact integral: `hbil process --quality reference` runs without a device,
# agrees with the densest samples of a device in every layer, and says what it
# has no use for.
. "$srcdir/test/support/tap.sh"

process() {
  "$HBIL" process --quiet --overwrite "$@"
}
compare() {
  "$HBIL" compare "$@"
}

exact() {
  OCL_ICD_VENDORS=$work/nothing "$HBIL" process --overwrite \
    --quality reference --slices 64 --warm-up 0 "$@"
}
dense() {
  process --far environment --slices 32 --steps-per-side 256 --step-growth 0 \
    --unfiltered --warm-up 0 "$@"
}
# agrees NAME LAYER LIMIT: the second frame, which has what the first carries.
agrees() {
  works "$1" compare --max-rmse "$3" "$work/exact/frame_0002.exr:$2" \
    "$work/dense/frame_0002.exr:$2"
}
mkdir "$work/nothing"
works "a demo" "$HBIL" demo --frames 2 --size 40x30 -o "$work/small"
first=$work/small/gbuffer/frame_0001.exr
second=$work/small/gbuffer/frame_0002.exr
# Occluders without end: 256 steps a side meet every pixel of a row of 40, so
# only 64 slices for all pixels against 32 that turn from pixel to pixel, and
# samples that are snapped to pixels beside the slice's line are left.  With so
# few pixels the latter matter most: .0055 of AO is measured, .002 if exact
# samples are snapped as well.  E_near and the bent normal deviate as much,
# E_near times some radiance (here .015).
for way in camera motion; do
  works "exact, no device, by $way" exact --relative-thickness inf \
    --environment frame --reprojection $way -o "$work/exact" "$first" "$second"
  works "densest, by $way" dense --relative-thickness inf \
    --environment frame --reprojection $way -o "$work/dense" "$first" "$second"
  agrees "exact agrees, by $way: AO" ao 0.008
  agrees "exact agrees, by $way: near" near_irradiance 0.03
  agrees "exact agrees, by $way: far" far_irradiance 0.01
  agrees "exact agrees, by $way: indirect" indirect 0.012
  agrees "exact agrees, by $way: bent" bent_normal 0.013
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
# The library decodes depth buffers on the device, and the exact integral is
# given what the host decodes.  A reversed buffer holds more for what is nearer,
# but any positive numbers will do: here it is planar depths.
for range in 2,100 2,inf; do
  works "exact, reversed depth, $range" exact --relative-thickness inf \
    --environment frame --depth reversed --clip $range -o "$work/exact" \
    "$first" "$second"
  works "densest, reversed depth, $range" dense --relative-thickness inf \
    --environment frame --depth reversed --clip $range -o "$work/dense" \
    "$first" "$second"
  agrees "exact agrees, reversed depth, $range: AO" ao 0.018
  agrees "exact agrees, reversed depth, $range: near" near_irradiance 0.03
done
# with the kernels of the densest ones
works "few samples" process --far environment --relative-thickness inf --environment frame \
  --steps-per-side 4 --unfiltered -o "$work/few" "$first" "$second"
differs "are told from it" compare --max-rmse 0.03 \
  "$work/exact/frame_0002.exr:ao" "$work/few/frame_0002.exr"
# Occluders that end: the library has 32 sectors a side, rounded alike in all
# slices of a pixel, 1/(32 sqrt(12)) = .009 of AO.
run exact -o "$work/exact" "$first" "$second"
test $status -eq 0 && grep -q 'exact integral of 2 frames, 2 runs.*expected to take' \
  "$work/err" && grep -q 'exact integral: 100 %' "$work/err"
ok $? "the exact integral tells how long it takes and how far it is"
works "densest, thick occluders" dense -o "$work/dense" "$first" "$second"
agrees "exact agrees, thick occluders: AO" ao 0.03
agrees "exact agrees, thick occluders: near" near_irradiance 0.013
works "exact hbao" exact --mode hbao --relative-thickness inf --radius 2 \
  -o "$work/exact" "$second"
works "densest hbao" dense --mode hbao --relative-thickness inf --radius 2 \
  -o "$work/dense" "$second"
agrees "exact agrees: hbao" ao 0.018
run exact --quiet -o "$work/exact" "$first"
test $status -eq 0 && test ! -s "$work/err"
ok $? "the exact integral is quiet if asked to"
for useless in '--steps-per-side 8' '--step-growth 1' '--sample-grid full-resolution' '--unfiltered' \
  '--device 0' '--timings' '--json'; do
  # shellcheck disable=SC2086
  rejected "the exact integral without ${useless% *}" \
    "${useless% *}: not with --quality reference" \
    exact $useless -o "$work/never" "$first"
done
rejected "the exact integral with too many slices" 'from 1 to 4096' \
  exact --slices 5000 -o "$work/never" "$first"
rejected "the exact integral with a bad radius of ao" '--ao-radius -1: a positive' \
  exact --ao-radius=-1 -o "$work/never" "$first"
rejected "the exact integral with a bad radius" '--radius -1: a positive' \
  exact --radius=-1 -o "$work/never" "$first"
rejected "the exact integral with a bad facing" '--facing-fade 1,0' \
  exact --facing-fade=1,0 -o "$work/never" "$first"
absent "what was rejected left nothing" "$work/never"

echo "1..$count"
