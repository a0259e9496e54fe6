#!/bin/sh
# Dumps as they come, from the outside: a file for each pass, several parts,
# windows, and what is said about mistakes.  What single layouts come to is
# test_sources.c.
#
# Speaks TAP.
srcdir=${srcdir:-$(dirname "$0")/../..}
. "$srcdir/test/support/tap.sh"

# No device, so no kernels to be compiled.
process() {
  "$HBIL" process --quality reference --slices 2 --warm-up 0 "$@"
}
same() { # NAME FILE FILE
  works "$1" "$HBIL" compare --max-rmse 0 "$2" "$3"
}
# warns NAME PATTERN COMMAND...: succeeds with a warning that has the pattern.
warns() {
  name=$1 pattern=$2
  shift 2
  run "$@"
  test $status -eq 0 && grep 'warning: ' "$work/err" | grep -q -e "$pattern"
  ok $? "$name"
}

works "a demo" "$HBIL" demo --frames 2 --size 60x44 -o "$work/demo"
frames=$work/demo/gbuffer
one=$frames/frame_0001.exr
two=$frames/frame_0002.exr
camera=${one%.exr}.json
works "the frames as they are" process --layers ao,bent_normal,near_irradiance -o "$work/a" \
  "$one" "$two"
grep -q warning "$work/err"
test $? -ne 0
ok $? "and nothing is warned of"

# --- what info says ---

says "the source is told, and its word" '(--source generic)' "$HBIL" info "$one"
says "and how depth is taken" 'depth is .*axis (--depth)' "$HBIL" info "$one"
says "and what is missing costs" 'background not in the file: ' \
  "$HBIL" info "$one"
says "info finds mistakes, too" 'warning .*--depth planar' \
  "$HBIL" info --depth ray "$one"

# --- mistakes ---

warns "depth that isn't along the ray" '--depth planar' \
  process --layers ao --depth ray --overwrite -o "$work/ray" "$one"
warns "normals that aren't the camera's" '--normals world' \
  process --layers ao --normals camera --overwrite -o "$work/ray" "$one"
warns "a radius that is larger than all" 'metres against centimetres' \
  process --layers ao --radius 5000 --overwrite -o "$work/ray" "$one"
warns "the camera of another size of lens" '--camera positions' \
  process --layers ao --fov 150 --overwrite -o "$work/ray" "$one"
grep -q ': --fov replaces the lens of the camera (the JSON file beside it): 8.*in place of' "$work/err"
ok $? "and that --fov replaces its own"
warns "the same before anything is written" '--depth planar' \
  process --dry-run --depth ray -o "$work/dry" "$one"
absent "by --dry-run" "$work/dry"
run process --quiet --layers ao --depth ray --overwrite -o "$work/ray" "$one"
test $status -eq 0 && test ! -s "$work/err"
ok $? "nothing is warned of with --quiet"

works "a first result" process --layers ao -o "$work/again" "$one"
run process --resume --layers ao --unit-scale 2 -o "$work/again" "$one"
test $status -eq 0 && ! grep -q 'is there already' "$work/err"
ok $? "a result of another reading is computed again"
run process --resume --layers ao --unit-scale 2 -o "$work/again" "$one"
grep -q 'is there already' "$work/err"
ok $? "but one of the same is"

out=$work/none
rejected "an unknown source" 'one of generic, blender' \
  process --source maya -o "$out" "$one"
rejected "a device's depth without its planes" '--clip NEAR,FAR is needed' \
  process --depth device -o "$out" "$one"
rejected "motion in unknown units" '--motion-scale X,Y is needed' \
  process --source arnold --reprojection motion \
  --map depth=depth,normal=normal,motion=motion -o "$out" "$one"
rejected "planes in the wrong order" '--clip 2,1: ' \
  process --clip 2,1 -o "$out" "$one"
rejected "an axis that isn't" '--flip xw: some of x, y, z' \
  process --flip xw -o "$out" "$one"
rejected "an angle that isn't" '--fov 180: ' process --fov 180 -o "$out" "$one"
rejected "a scale of nothing" '--unit-scale 0: ' \
  process --unit-scale 0 -o "$out" "$one"
rejected "normals of no kind" '--normals round: one of world' \
  process --normals round -o "$out" "$one"
rejected "a role that isn't" '--map glow: ROLE=LAYER is needed' \
  process --map glow=depth -o "$out" "$one"
rejected "a layer that isn't there" 'frame_0001.exr has no such layer' \
  process --map depth=gone -o "$out" "$one"
# without positions, which tell it, too
oiiotool "$one" --ch depth.Z,normal.X,normal.Y,normal.Z,albedo.R,albedo.G,albedo.B,direct.R,direct.G,direct.B \
  -o "$work/alone.exr"
rejected "no camera for normals of the world" 'how the camera is turned' \
  process --fov 60 -o "$out" "$work/alone.exr"
rejected "two lenses" '--fov: not with --orthographic' \
  process --fov 60 --orthographic 3 -o "$out" "$one"
rejected "a picture of no size" '--orthographic 0: ' \
  process --orthographic 0 -o "$out" "$one"
sed 's/"cx"/"projection": "fisheye", "cx"/' "$camera" >"$work/flat.json"
rejected "rays of another kind" 'field projection is wrong; "perspective" or' \
  process --camera "$work/flat.json" -o "$out" "$one"
absent "and nothing is written" "$out"

# --- beauty, if the file has a finished picture ---

# A result is a frame with a picture, its indirect light and something for alpha.
pass=$work/pass.exr
works "a picture of other light" process --copy-channels --environment .2,.3,.4 \
  --layers beauty,indirect,ao -o "$work/picture" "$one"
cp "$work/picture/frame_0001.exr" "$pass"
cp "$camera" "$work/pass.json"
picture='picture=beauty,alpha=ao,indirect=indirect'
lit="--environment 1,.5,2 --layers beauty"
# shellcheck disable=SC2086
works "diffuse light" process $lit -o "$work/diffuse" "$one"
# shellcheck disable=SC2086
run process $lit --map "$picture" -o "$work/replace" "$pass"
test $status -eq 0 && grep -q 'beauty is the file.s picture (beauty.R)' "$work/err"
ok $? "its own light replaces it, which is said"
# sums of floats of a picture with values of up to 4
works "which is the same" "$HBIL" compare --max-rmse 1e-6 \
  "$work/replace/pass.exr:beauty" "$work/diffuse/frame_0001.exr"
works "alpha is the frame's" "$HBIL" compare --max-rmse 0 \
  "$work/replace/pass.exr:beauty.A" "$pass:ao.V"
# shellcheck disable=SC2086
works "--beauty diffuse" process $lit --beauty diffuse --map "$picture" \
  -o "$work/asked" "$pass"
same "has neither" "$work/asked/pass.exr" "$work/diffuse/frame_0001.exr"
# shellcheck disable=SC2086
run process --resume $lit --map "$picture" -o "$work/asked" "$pass"
test $status -eq 0 && ! grep -q 'is there already' "$work/err"
ok $? "another beauty is computed again"
rejected "a picture without its light" \
  'pass.exr: has no picture; --beauty replace needs' \
  process --beauty replace -o "$work/none" "$pass"
rejected "a picture that isn't written" '--layers is without beauty' \
  process --beauty replace --layers ao --map "$picture" -o "$work/none" "$pass"
absent "and nothing is written then" "$work/none"

# --- parallel rays ---

works "a demo of parallel rays" \
  "$HBIL" demo --orthographic --frames 2 --size 60x44 -o "$work/parallel"
flat=$work/parallel/gbuffer
works "its frames" process --layers ao,bent_normal,near_irradiance -o "$work/flat" \
  "$flat/frame_0001.exr" "$flat/frame_0002.exr"
grep -q warning "$work/err"
test $? -ne 0
ok $? "nothing is warned of"
differs "they are no perspective's" "$HBIL" compare --max-rmse 0.1 \
  "$work/flat/frame_0001.exr:ao" "$work/a/frame_0001.exr"
says "info tells the size of the picture" \
  'orthographic, 17.* pixels a unit, the picture 3.4 x 2.49333 units' \
  "$HBIL" info "$flat/frame_0001.exr"
says "and that positions fit" "of the picture's width, they agree" \
  "$HBIL" info "$flat/frame_0001.exr"

# The same camera told in other ways: 3.4 units across, of Blender's setting,
# and where the file says nothing (3.4 is a float there: 1e-7 of it).
sed '/"f[xy]"/d; s/"cx"/"ortho_scale": 3.4, "cx"/' "$flat/frame_0001.json" \
  >"$work/scale.json"
works "Blender's size" process --layers ao,bent_normal,near_irradiance \
  --camera "$work/scale.json" -o "$work/scale" "$flat/frame_0001.exr"
same "is the same" "$work/scale/frame_0001.exr" "$work/flat/frame_0001.exr"
sed '/"projection"/d; s/"cy": [0-9.]*,/"cy": 22/; s/"fx": [0-9.]*/"fx": 100/' \
  "$flat/frame_0001.json" >"$work/scale.json"
works "the size as an option" process --layers ao,bent_normal,near_irradiance --orthographic 3.4 \
  --camera "$work/scale.json" -o "$work/option" "$flat/frame_0001.exr"
works "comes to the same" "$HBIL" compare --max-rmse 1e-6 \
  "$work/option/frame_0001.exr" "$work/flat/frame_0001.exr"
warns "a picture of another size" '--orthographic' process --layers ao \
  --orthographic 20 --overwrite -o "$work/ray" "$flat/frame_0001.exr"
rejected "a sequence of both kinds" \
  'has an orthographic camera, but .*frame_0001.exr has a perspective one' \
  process -o "$out" "$one" "$flat/frame_0002.exr"
sed 's/"cx"/"projection": "orthographic", "cx"/' "$camera" >"$work/flat.json"
works "a result of a perspective" \
  process --layers ao -o "$work/kinds" "$one"
run process --resume --layers ao --camera "$work/flat.json" \
  -o "$work/kinds" "$one"
test $status -eq 0 && ! grep -q 'is there already' "$work/err"
ok $? "is computed again for parallel rays of the same numbers"

# --- what other programs write ---

if ! command -v oiiotool >/dev/null; then
  skip "files of other programs" "no oiiotool (Debian: openimageio-tools)"
  echo "1..$count"
  exit 0
fi

# One pass a file, of several formats; the frame itself has its light only.
passes=$work/passes
mkdir "$passes"
for frame in 0001 0002; do
  from=$frames/frame_$frame.exr
  oiiotool "$from" --ch depth.Z -d float -o "$passes/z$frame.tif"
  oiiotool "$from" --ch normal.X,normal.Y,normal.Z --chnames R,G,B \
    -o "$passes/n.$frame.exr"
  oiiotool "$from" --ch albedo.R,albedo.G,albedo.B --chnames R,G,B \
    -d float -o "$passes/albedo_$frame.tif"
  oiiotool "$from" --ch emission.R,emission.G,emission.B,direct.R,direct.G,direct.B \
    -o "$passes/frame_$frame.exr"
  cp "${from%.exr}.json" "$passes"
done
map='depth=z#.tif,normal=n.####.exr,albedo=albedo_#.tif'
works "a file for each pass" process --layers ao,bent_normal,near_irradiance --map "$map" \
  -o "$work/b" "$passes/frame_0001.exr" "$passes/frame_0002.exr"
for frame in 0001 0002; do
  same "comes to the same, frame $frame" "$work/a/frame_$frame.exr" \
    "$work/b/frame_$frame.exr"
done
says "info tells in which file a pass is" 'in .*z0001.tif' \
  "$HBIL" info --map "$map" "$passes/frame_0001.exr"
oiiotool "$one" --ch direct.R,direct.G,direct.B --chnames R,G,B \
  -o "$passes/light_0001.hdr"
works "a Radiance picture of light" process --layers near_irradiance \
  --map "$map,direct=light_#.hdr" -o "$work/hdr" "$passes/frame_0001.exr"
# 8 bits of a common exponent: 2^-9 of the largest channel
works "which is as exact as they are" "$HBIL" compare --max-rmse 4e-3 \
  "$work/hdr/frame_0001.exr:near_irradiance" "$work/a/frame_0001.exr"
for kind in tif exr hdr; do
  file=$(ls "$passes" | grep "0001.$kind\$" | head -n 1)
  size=$(wc -c <"$passes/$file")
  dd if="$passes/$file" of="$work/cut.$kind" bs=1 count=$((size / 3)) \
    2>/dev/null
  rejected "a pass that is cut off, .$kind" "cut.$kind: " \
    process --quiet --map "$map,albedo=$work/cut.$kind" -o "$out" \
    "$passes/frame_0001.exr"
done
oiiotool --create 8x8 3 -o "$passes/small.png"
oiiotool --create 8x4 3 --addc .5,.25,2 -o "$passes/sky.exr"
run process --dry-run --environment "$passes/sky.exr" -o "$out" "$one"
test $status -eq 0 && grep -q 'sky.exr: .* 8 x 4 pixels, mean radiance 0.5 0.25 2; .* top row is +z' "$work/err" &&
  ! grep -q 'above 1' "$work/err"
ok $? "what was understood of an environment is told"
run process --dry-run --environment "$passes/small.png" -o "$out" "$one"
grep -q 'small.png: .* no value is above 1: ' "$work/err"
ok $? "and that it may be for a display"
rejected "an environment that is cut off" 'cut.tif: truncated' \
  process --quiet --environment "$work/cut.tif" -o "$out" "$one"
rejected "a pass of another size" '8 x 8 pixels, but .* has 60 x 44' \
  process --map "$map,albedo=small.png" -o "$out" "$passes/frame_0001.exr"

# What sRGB is, in files of integers and of floats.
oiiotool "$one" --ch direct.R,direct.G,direct.B --chnames R,G,B -d uint16 -o "$passes/light.tif"
oiiotool "$one" --ch depth.Z,normal.X,normal.Y,normal.Z,albedo.R,albedo.B,direct.R,direct.G,direct.B \
  -o "$passes/lacks_0001.exr"
cp "$camera" "$passes/lacks_0001.json"
run "$HBIL" info --colours srgb --map "$map,direct=light.tif" "$passes/frame_0001.exr"
test $status -eq 0 && grep -q 'direct .*light.tif, sRGB, made linear' "$work/out" &&
  grep -q 'emission.R *[^,]*$' "$work/out"
ok $? "light in integers can be sRGB, light in floats can't"
warns "a layer without one of its channels" 'albedo is left out, .* no channel albedo.G; ' \
  process --dry-run --colours srgb -o "$out" "$passes/lacks_0001.exr"
grep -q ': --colours srgb: light in floats is taken as linear$' "$work/err"
ok $? "and which colours are linear"
# A depth that is longer than the positions say, by less than a pixel and by more.
for by in 1.003:'(.* pixels), they agree within' 1.045:'they differ: store both'; do
  f=${by%%:*}
  oiiotool "$one" --mulc 1,1,1,$f,1,1,1,1,1,1,1,1,1,1,1,1,1,1 -o "$passes/far_0001.exr"
  cp "$camera" "$passes/far_0001.json"
  says "info says whether positions fit a depth times $f" "position .*${by#*:}" \
    "$HBIL" info "$passes/far_0001.exr"
done

# Houdini's Karma: no row of the table, so it is named.
oiiotool "$one" --ch depth.Z,normal.X,normal.Y,normal.Z,albedo.R,albedo.G,albedo.B,direct.R,direct.G,direct.B \
  --chnames Pz,N.X,N.Y,N.Z,albedo.R,albedo.G,albedo.B,directdiffuse.R,directdiffuse.G,directdiffuse.B \
  -o "$passes/karma.exr"
cp "$camera" "$passes/karma.json"
rejected "Karma's passes" 'Karma.*--map depth=LAYER.*direct=directdiffuse' \
  process -o "$out" "$passes/karma.exr"
works "but what is said of them is taken" process --layers ao --direct radiance \
  --map depth=Pz,normal=N,albedo=albedo,direct=directdiffuse -o "$work/karma" "$passes/karma.exr"

# Motion blur in Blender leaves no motion vectors.
names=depth.Z,normal.X,normal.Y,normal.Z,albedo.R,albedo.G,albedo.B,direct.R,direct.G,direct.B
for frame in 0001 0002; do
  oiiotool "$frames/frame_$frame.exr" --ch $names,motion.X=0,motion.Y=0 -o "$passes/blur_$frame.exr"
  cp "$frames/frame_$frame.json" "$passes/blur_$frame.json"
done
warns "motion vectors that are all 0 under a moving camera" 'motion vectors are all 0' \
  process --layers ao --reprojection motion -o "$work/blur" "$passes/blur_0001.exr" "$passes/blur_0002.exr"
# the first one's camera but for a rounding of its x, the fourth number of its matrix
awk '/camera_to_world/ { n = 1 }
  n && /^ *-?[0-9]/ && ++k == 4 { printf "%.17g\n", $1 + 1e-7; next } { print }' \
  "$passes/blur_0001.json" >"$passes/blur_0002.json"
run process --layers ao --reprojection motion --overwrite -o "$work/blur" \
  "$passes/blur_0001.exr" "$passes/blur_0002.exr"
test $status -eq 0 && ! grep -q 'motion vectors' "$work/err" &&
  ! cmp -s "$passes/blur_0001.json" "$passes/blur_0002.json"
ok $? "but not while it stands, to a rounding"

# Several parts, each a layer, whose channels are plain.
oiiotool "$one" --ch direct.R,direct.G,direct.B --chnames R,G,B \
  --attrib oiio:subimagename direct \
  "$one" --ch depth.Z --chnames Z --attrib oiio:subimagename depth \
  --siappend \
  "$one" --ch normal.X,normal.Y,normal.Z --chnames X,Y,Z \
  --attrib oiio:subimagename normal --siappend \
  "$one" --ch albedo.R,albedo.G,albedo.B --chnames R,G,B \
  --attrib oiio:subimagename albedo --siappend -o "$work/frame_0001.exr"
cp "$camera" "$work/frame_0001.json"
works "several parts" process --layers ao,bent_normal \
  -o "$work/parts" "$work/frame_0001.exr"
same "come to the same" "$work/parts/frame_0001.exr:ao" \
  "$work/a/frame_0001.exr:ao"

# Pixels beyond the edges of the picture light it and are not written.
mkdir "$work/wide"
for frame in 0001 0002; do
  oiiotool "$frames/frame_$frame.exr" --fullsize 40x30+10+7 \
    -o "$work/wide/frame_$frame.exr"
  cp "$frames/frame_$frame.json" "$work/wide"
done
works "overscan" process --layers ao,bent_normal,near_irradiance -o "$work/c" \
  "$work/wide/frame_0001.exr" "$work/wide/frame_0002.exr"
for frame in 0001 0002; do
  oiiotool "$work/a/frame_$frame.exr" --crop 40x30+10+7 -o "$work/crop.exr"
  same "is used, then cropped, frame $frame" "$work/crop.exr" \
    "$work/c/frame_$frame.exr"
done
run oiiotool --info -v "$work/c/frame_0002.exr"
grep -q '40 x   30' "$work/out" && grep -q 'full/display size: 40 x 30' \
  "$work/out" && grep -q 'pixel data origin: x=10, y=7' "$work/out"
ok $? "and the windows are those of the picture"
says "info tells the windows" 'at 0, 0 of a picture of 40 x 30 at 10, 7' \
  "$HBIL" info "$work/wide/frame_0001.exr"

# The same of a picture that doesn't tell where its overscan begins.
works "--crop" process --layers ao,bent_normal,near_irradiance --crop 10,7,40,30 \
  -o "$work/cropped" "$one" "$two"
for frame in 0001 0002; do
  same "has the part of the whole, frame $frame" "$work/c/frame_$frame.exr" \
    "$work/cropped/frame_$frame.exr"
done
oiiotool --info -v "$work/cropped/frame_0002.exr" >"$work/cropped.txt"
grep -q 'full/display size: 40 x 30' "$work/cropped.txt" &&
  grep -q 'pixel data origin: x=10, y=7' "$work/cropped.txt"
ok $? "and its windows"
for crop in 30,0,31,44 0,0,40.5,30 0,-1,4,4 5,5,0,0; do
  rejected "--crop $crop" "crop $crop: .* 60 x 44 pixels; x and y" \
    process --crop "$crop" -o "$work/never" "$one"
done

# What lies beyond a smaller data window is nothing; each frame has its own.
oiiotool "$two" --crop 30x20+20+10 -o "$work/wide/frame_0002.exr"
works "windows of several sizes" process --layers ao -o "$work/d" \
  "$one" "$work/wide/frame_0002.exr"
same "leave other frames alone" "$work/d/frame_0001.exr:ao" \
  "$work/a/frame_0001.exr:ao"
works "and are finite where there is nothing" "$HBIL" compare --max-rmse 0 \
  "$work/d/frame_0002.exr" "$work/d/frame_0002.exr"
oiiotool "$work/d/frame_0001.exr" --crop 30x20+20+10 -o "$work/crop.exr"
works "a mask is of the pixels that are compared" "$HBIL" compare --max-rmse 0 \
  --mask-depth "$one" "$work/d/frame_0001.exr" "$work/crop.exr"
oiiotool "$one" --origin +500+0 --fullsize 60x44+0+0 -o "$work/alone.exr"
cp "$camera" "$work/alone.json"
rejected "a picture without pixels" 'none of its pixels lie in its display' \
  process -o "$out" "$work/alone.exr"
# --- exposure ---

# exposed FRAME: its light times eight, which the header says.
exposed() {
  oiiotool "$1" --mulc 1,1,1,1,8,8,8,8,8,8,1,1,1,1,1,1,1,1 \
    --attrib:type=float studio:factor 8 -o "$work/bright/frame_0002.exr"
}
# eight_times NAME FOLDER: indirect light of the second frame against $work/a.
eight_times() {
  for folder in a "$2"; do
    oiiotool "$work/$folder/frame_0002.exr" --ch indirect.R,indirect.G,indirect.B \
      -o "$work/$folder.light.exr"
  done
  oiiotool "$work/a.light.exr" --mulc 8 -o "$work/a.light.exr"
  same "$1" "$work/a.light.exr" "$work/$2.light.exr"
}
mkdir "$work/bright"
oiiotool "$one" --attrib:type=float studio:factor 1 -o "$work/bright/frame_0001.exr"
exposed "$two"
cp "$camera" "${two%.exr}.json" "$work/bright"
works "light without exposure" process --layers indirect --overwrite -o "$work/a" \
  "$one" "$two"
works "a jump of exposure that the header tells" process --layers indirect \
  --exposure studio:factor -o "$work/e" "$work"/bright/frame_000?.exr
eight_times "is a jump in that very frame, by the same factor" e
says "info tells numbers of the header" 'numbers .*studio:factor 8 ' \
  "$HBIL" info "$work/bright/frame_0002.exr"
says "and what is taken for exposure" 'exposure   8; .*(--exposure)' \
  "$HBIL" info --exposure studio:factor "$work/bright/frame_0002.exr"
rejected "a number that isn't there" '0002.exr: --exposure no: .* no such number; .*info' \
  process --layers indirect --exposure no -o "$out" "$work/bright/frame_0002.exr"
sed '$s/}/,"exposure":8}/' "${two%.exr}.json" >"$work/bright/frame_0002.json"
works "a jump that the camera file tells" process --layers indirect \
  -o "$work/f" "$work"/bright/frame_000?.exr
eight_times "is the same" f
sed '$s/}/,"exposure":-8}/' "${two%.exr}.json" >"$work/bright/frame_0002.json"
rejected "an exposure that none is" 'frame_0002.json: .*exposure.*1e-12 to 1e12' \
  process --layers indirect -o "$out" "$work/bright/frame_0002.exr"

absent "and after all that nothing is written" "$out"

echo "1..$count"
