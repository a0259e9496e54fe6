#!/bin/sh
# examples/hbil_export_camera.py: where Blender is, or its Python module (bpy), the
# cameras that it writes fit the positions that Blender renders.
#
#   HBIL_BPY  a Python that has bpy (python3)
. "$srcdir/test/support/tap.sh"

script=$srcdir/examples/hbil_export_camera.py
name="the script is sound to Python"
if command -v python3 >/dev/null; then
  works "$name" python3 -c 'import ast, sys; ast.parse(open(sys.argv[1]).read())' "$script"
else
  skip "$name" "no python3"
fi

name="Blender renders a scene"
if command -v blender >/dev/null; then
  render="blender -b --factory-startup --python $srcdir/test/system/blender_scene.py --"
elif "${HBIL_BPY:-python3}" -c 'import bpy' 2>/dev/null; then
  render="${HBIL_BPY:-python3} $srcdir/test/system/blender_scene.py"
else
  skip "$name" "no blender and no python3 with bpy (HBIL_BPY)"
  echo "1..$count"
  exit 0
fi

out=$work/renders
mkdir "$out"
export PYTHONDONTWRITEBYTECODE=1
# shellcheck disable=SC2086
says "$name" 'hbil: one_L is a pano camera; hbil needs' \
  $render "$srcdir/examples" "$out"

# fits NAME FILE [OPTIONS...]: the camera beside it leads to its positions.
fits() {
  name=$1 file=$2
  shift 2
  says "$name: the camera fits" 'rebuilt from depth .* they agree' \
    "$HBIL" info "$@" "$out/$file.exr"
}
fits "a plain picture" plain
fits "shifts, a sensor fit and wide pixels" shift
fits "an orthographic camera" parallel
fits "a cropped border" crop
for mode in OFFAXIS PARALLEL TOE; do
  for eye in left right; do
    fits "stereo, $mode, $eye" stereo_$mode --eye $eye
  done
done
fits "a file for the left eye" eyes_L
fits "a file for the right eye" eyes_R
fits "two cameras, left" cameras --eye left
fits "two cameras, right" cameras --eye right
for n in 1 2; do
  fits "an animation, frame $n" walk_000$n
  run cmp "$out/walk_000$n.json" "$out/walk_000$n.json.before"
  ok $status "its camera is that which was written before, frame $n"
done
run cmp "$out/walk_0001.json" "$out/walk_0002.json"
test $status -eq 1
ok $? "which moves"
says "all passes are there" 'direct  *[A-Za-z]*[.]DiffDir[.]R' "$HBIL" info "$out/plain.exr"
for pass in normal albedo emission position indirect motion picture alpha; do
  grep -q "^  $pass  *[A-Z]" "$work/out"
  ok $? "pass: $pass"
done
# one frame, little sampling: what the recipe says comes out
works "the guide's recipe lights the animation" "$HBIL" process \
  --quality reference --slices 2 --warm-up 0 -o "$work/lit" "$out/walk_####.exr"
grep -q 'beauty is the file.s picture (ViewLayer.Combined.R)' "$work/err"
ok $? "and Blender's picture"
has "both frames" "$work/lit/walk_0001.exr" "$work/lit/walk_0002.exr"

echo "1..$count"
