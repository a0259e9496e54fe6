#!/bin/sh
# The radiance cache of `hbil process`: which options make one, which views it
# takes, what --resume, files and dry runs do with it, and what info and
# hbil-bench truth know of it.
#
# Speaks TAP.
srcdir=${srcdir:-$(dirname "$0")/../..}
. "$srcdir/test/support/tap.sh"
HBIL_BENCH=${HBIL_BENCH:-./hbil-bench}

# Little sampling, and a cache that is small but for one test.
fast='--slices 1 --steps-per-side 6 --warm-up 0'
process() {
  # shellcheck disable=SC2086
  "$HBIL" process $fast "$@"
}
small() {
  process --cache-size 16 "$@"
}
quiet() {
  small --quiet --overwrite "$@"
}
# told PATTERN: the last command worked, and a line on standard error has it.
told() {
  test $status -eq 0 && grep -q -e "$1" "$work/err"
}
# same NAME FOLDER FOLDER: the same files in both, bit by bit.
same() {
  run diff -r "$2" "$3"
  ok $status "$1"
}

works "a demo" "$HBIL" demo --frames 4 --size 80x45 -o "$work/demo"
frames=$work/demo/gbuffer
one=$frames/frame_0001.exr
two=$frames/frame_0002.exr
out=$work/never
mkdir "$work/views"
for n in 2 3 4; do
  cp "$frames/frame_000$n.exr" "$work/views/v.$((3 * n)).exr"
  cp "$frames/frame_000$n.json" "$work/views/v.$((3 * n)).json"
done

# --- when there is a cache ---

line='^hbil: radiance cache: 16 x 16 x 16 voxels of [0-9.]* and [0-9.]* units, [0-9.]* MiB'
run small -o "$work/moving" "$frames"/*.exr
told "$line; earlier frames\$" && test "$(grep -c 'radiance cache' "$work/err")" -eq 1
ok $? "a camera that moves makes a cache, which one line tells"
run process -o "$work/default" "$one" "$two"
told '^hbil: radiance cache: 64 x 64 x 64 voxels'
ok $? "of 64 voxels each way by default"
run process --overwrite --far environment -o "$work/none" "$frames"/*.exr
test $status -eq 0 && ! grep -q 'radiance cache' "$work/err"
ok $? "--far environment makes none"
differs "and the light is another" "$HBIL" compare --max-rmse 1e-4 \
  "$work/none/frame_0004.exr:indirect" "$work/moving/frame_0004.exr:indirect"
run process -o "$work/one" "$one"
test $status -eq 0 && ! grep -q 'radiance cache' "$work/err"
ok $? "a single frame makes none"
# pair NAME NUMBER VALUE: one frame twice in $work/NAME; the second one's camera
# has another number: so many from its matrix on, which is followed by fx, fy,
# cx, cy.
pair() {
  mkdir "$work/$1"
  for n in 1 2; do
    cp "$one" "$work/$1/f_$n.exr"
  done
  cp "${one%.exr}.json" "$work/$1/f_1.json"
  awk -v number="$2" -v value="$3" '
    /camera_to_world/ { counts = 1 }
    counts && /[0-9]/ && ++n == number { sub(/-?[0-9][-+0-9.e]*/, value) }
    { print }' "${one%.exr}.json" >"$work/$1/f_2.json"
}
pair equal 0 0
pair noise 4 1e-7
pair jitter 19 40.31
pair move 4 0.2
still='^hbil: the camera stands still'
run process -o "$work/equal-lit" "$work/equal"/*.exr
told "$still: no radiance cache (--far rays makes one)\$" &&
  test "$(grep -c 'radiance cache' "$work/err")" -eq 1
ok $? "nor does a camera that stands still, which one line tells"
run process -o "$work/noise-lit" "$work/noise"/*.exr
told "$still: no radiance cache" && ! grep -q 'radiance cache:' "$work/err"
ok $? "nor one that moves by roundings"
for layer in ao bent_normal near_irradiance indirect; do
  works "whose $layer is that of the one that stands still" "$HBIL" compare \
    --max-rmse 1e-3 "$work/equal-lit/f_2.exr:$layer" "$work/noise-lit/f_2.exr:$layer"
done
rm -r "$work/noise-lit/f_2.exr"
cp -r "$work/noise-lit" "$work/noise-resumed"
works "one frame of it is made" process --resume -o "$work/noise-lit" \
  "$work/noise"/*.exr
works "and once more" process --resume -o "$work/noise-resumed" "$work/noise"/*.exr
same "with the same bits" "$work/noise-lit" "$work/noise-resumed"
run process -o "$work/jitter-lit" "$work/jitter"/*.exr
told "$still but for a jitter of 0.31 pixels: no radiance cache" &&
  ! grep -q 'radiance cache:' "$work/err"
ok $? "nor one that jitters"
run process --overwrite --far rays --cache-size 16 -o "$work/jitter-lit" \
  "$work/jitter"/*.exr
told "$line" && ! grep -q "$still" "$work/err"
ok $? "unless it is asked for"
run small -o "$work/move-lit" "$work/move"/*.exr
told "$line" && ! grep -q "$still" "$work/err"
ok $? "one that moves has it"
run process --quiet -o "$work/quiet-lit" "$work/jitter"/*.exr
test $status -eq 0 && test ! -s "$work/err"
ok $? "--quiet says nothing of it"
run process --model paper -o "$work/paper" "$one" "$two"
test $status -eq 0 && ! grep -q 'radiance cache' "$work/err"
ok $? "nor the paper's model"
run small --model paper --view "$two" -o "$work/paper-view" "$one"
told "$line; 1 view\$"
ok $? "unless there is a view"
run process --normals from-depth -o "$work/rebuilt" "$one" "$two"
test $status -eq 0 && ! grep -q 'radiance cache' "$work/err"
ok $? "nor frames without normals"
rejected "with them a view has no use" 'from-depth: not with --view' \
  small --normals from-depth --view "$two" -o "$out" "$one"

run small --view "$frames/frame_000[12].exr" -o "$work/wild" "$one"
told "$line; 2 views\$"
ok $? "wildcards stand for several views"
rejected "wildcards without a file" '/none_\*\.exr: no such files' \
  small --view "$frames/none_*.exr" -o "$out" "$one"

# --- options that don't go together ---

for option in "--view $two" "--view-light direct" --learn "--cache-size 32" \
  "--cache-load $work/c" --cache-fixed "--cache-save $work/c" "--far cones" \
  "--light-view $two"; do
  word=${option%% *}
  # shellcheck disable=SC2086
  test "$word" = --far || for far in environment none; do
    # shellcheck disable=SC2086
    rejected "$word and --far $far" \
      "^hbil: $word: not with --far $far, which leaves the radiance cache out" \
      process $option --far $far -o "$out" "$one"
    # shellcheck disable=SC2086
    rejected "--far $far and $word" "^hbil: $word: not with --far $far" \
      process --far $far $option -o "$out" "$one"
  done
  # shellcheck disable=SC2086
  rejected "$word and the exact integral" \
    "^hbil: $word: not with --quality reference, which has no radiance cache" \
    "$HBIL" process $option --quality reference -o "$out" "$one"
  for mode in gtao hbao; do
    # shellcheck disable=SC2086
    rejected "$word and $mode" "^hbil: $word: not with --mode $mode" \
      process $option --mode $mode -o "$out" "$one"
  done
done
rejected "--view-light without --view" '^hbil: --view-light: --view FILE is needed' \
  process --view-light radiance -o "$out" "$one"
rejected "--cache-fixed without --cache-load" '^hbil: --cache-fixed: --cache-load FILE' \
  process --cache-fixed -o "$out" "$one"
rejected "--cache-fixed and --learn" '^hbil: --cache-fixed: not with --learn' \
  process --cache-fixed --learn --cache-load "$work/c" -o "$out" "$one"
rejected "--cache-size beside a file's" '^hbil: --cache-size: not with --cache-load' \
  process --cache-size 32 --cache-load "$work/c" -o "$out" "$one"
for size in 0 15 48 512 many; do
  rejected "--cache-size $size" "^hbil: --cache-size $size: one of 16, 32, 64, 128, 256" \
    process --cache-size $size -o "$out" "$one"
done

rejected "an unknown --far" '^hbil: --far nix: one of rays, cones, lpv, rsm, environment, none is needed' \
  process --far nix -o "$out" "$one"
rejected "--far rsm without a light" '^hbil: --far rsm: --light-view FILE is needed' \
  process --far rsm -o "$out" "$one"
rejected "--light-view for rays" '^hbil: --light-view: --far rsm is needed' \
  process --light-view "$two" -o "$out" "$one"
rejected "too many lights" '^hbil: --light-view: 5 files; 4 at most' \
  process --far rsm --light-view "$one" --light-view "$one" --light-view "$one" \
  --light-view "$one" --light-view "$one" -o "$out" "$one"

# --- ways to find the cache's light ---

small --view "$two" --far rays -o "$work/far-rays" "$one"
small --view "$two" -o "$work/far-default" "$one"
works "rays are the default" "$HBIL" compare --max-rmse 0 \
  "$work/far-rays/$(basename "$one")" "$work/far-default/$(basename "$one")"
for far in cones lpv "rsm --light-view $two"; do
  word=${far%% *}
  # shellcheck disable=SC2086
  run small --view "$two" --far $far -o "$work/far-$word" "$one"
  test $status -eq 0
  ok $? "--far $word"
  differs "is another light than rays find" "$HBIL" compare --max-rmse 1e-4 \
    "$work/far-$word/$(basename "$one")" "$work/far-rays/$(basename "$one")"
done

# --- far light without a cache ---

plain() {
  process --quiet --overwrite "$@"
}
works "--far none" plain --far none -o "$work/far-none" "$one" "$two"
works "no cache and no environment" plain --far environment --environment none \
  -o "$work/far-spelled" "$one" "$two"
same "--far none is both" "$work/far-none" "$work/far-spelled"
works "--far none behind its environment" plain --environment none --far none \
  -o "$work/far-spelled" "$one" "$two"
same "is --far none" "$work/far-none" "$work/far-spelled"
works "an environment that a model overrules is none" plain --dry-run \
  --environment frame --model paper --far none -o "$out" "$one"
for environment in frame 1,1,1 "$work/sky.exr"; do
  rejected "--far none and --environment ${environment##*/}" \
    "^hbil: --environment $environment: not with --far none, which leaves far light out" \
    process --far none --environment "$environment" -o "$out" "$one"
  rejected "the same in another order" "^hbil: --environment $environment: not with --far none" \
    process --environment "$environment" --far none -o "$out" "$one"
done
works "--far environment and its light" plain --far environment --environment 1,1,1 \
  -o "$work/far-given" "$one"
differs "which shows" "$HBIL" compare --max-rmse 1e-4 \
  "$work/far-given/$(basename "$one")" "$work/far-none/$(basename "$one")"
works "the last --far counts" plain --far rays --far none -o "$work/far-last" "$one" "$two"
same "even behind another" "$work/far-none" "$work/far-last"
for with in "--mode gtao" "--mode hbao" "--model paper"; do
  # shellcheck disable=SC2086
  works "--far none with $with" plain $with --far none -o "$work/far-none-with" "$one"
  # shellcheck disable=SC2086
  works "$with alone" plain $with --environment none -o "$work/far-with" "$one"
  same "is the same" "$work/far-none-with" "$work/far-with"
done
works "--far none with the exact integral" "$HBIL" process --quiet --overwrite \
  --quality reference --slices 1 --warm-up 0 --far none -o "$work/far-exact" "$one"

# --- the contact sheet ---

# pixels FILE: "WIDTH HEIGHT" of a PNG.
pixels() {
  od -A n -t u1 -j 16 -N 8 "$1" | awk '{
    print 256 * (256 * (256 * $1 + $2) + $3) + $4,
      256 * (256 * (256 * $5 + $6) + $7) + $8 }'
}
works "a contact sheet" quiet --layers ao --contact-sheet "$work/sheet.png" \
  -o "$work/sheet" "$frames"/*.exr
# two tiles of 160 x 90 with gaps of 8 and a line of 22 above, and one for each frame
test "$(pixels "$work/sheet.png")" = "344 568"
ok $? "has a tile for the cache"
works "without one" process --quiet --far environment --layers ao \
  --contact-sheet "$work/bare.png" -o "$work/bare" "$frames"/*.exr
test "$(pixels "$work/bare.png")" = "176 568"
ok $? "it has none"
works "of results that are there" small --quiet --resume --layers ao \
  --contact-sheet "$work/sheet2.png" -o "$work/sheet" "$frames"/*.exr
works "it is the same" cmp "$work/sheet.png" "$work/sheet2.png"
# sheet NAME VIEW: of what VIEW shows in the first frame.
sheet() {
  quiet --layers ao --view "$2" --contact-sheet "$work/$1.png" \
    -o "$work/$1" "$one"
}
works "of a frame that is its own view" sheet own "$one"
works "of a frame with another view" sheet other "$two"
works "ambient occlusion doesn't depend on the cache" "$HBIL" compare \
  --max-rmse 0 "$work/own/frame_0001.exr:ao" "$work/other/frame_0001.exr:ao"
differs "so the cache's tile is another one" cmp "$work/own.png" "$work/other.png"

# --- views ---

run small --view "$work/views/v.#.exr" -o "$work/views-3" "$one"
told "$line; 3 views\$"
ok $? "a pattern, whose numbers may have holes"
grep -q '^hbil: radiance cache: 30 %, .* left$' "$work/err" &&
  grep -q '^hbil: radiance cache: 100 %$' "$work/err"
ok $? "shows progress"
works "the same views one by one" quiet --view "$work/views/v.6.exr" \
  --view "$work/views/v.9.exr" --view "$work/views/v.12.exr" -o "$work/single" "$one"
same "have the same light" "$work/views-3" "$work/single"
run quiet --view "$work/views/v.%d.exr" -o "$work/single" "$one"
test $status -eq 0 && test ! -s "$work/err" && test ! -s "$work/out"
ok $? "--quiet says nothing"
differs "views change the light" "$HBIL" compare --max-rmse 1e-4 \
  "$work/single/frame_0001.exr:indirect" "$work/one/frame_0001.exr:indirect"
run small --learn -o "$work/learnt" "$frames"/*.exr
told "$line; all frames\$" && grep -q 'radiance cache: 100 %$' "$work/err"
ok $? "--learn"
differs "the first frame knows the last one" "$HBIL" compare --max-rmse 1e-4 \
  "$work/learnt/frame_0001.exr:indirect" "$work/moving/frame_0001.exr:indirect"
# The lamp goes down to an eighth before the last frame.  Times eight, its light
# differs by what the frame before hands on (measured: .28, of a mean of .15; if
# frames that are learnt aren't seen again, 1.02).
if command -v oiiotool >/dev/null; then
  last=$(ls "$frames"/*.exr | tail -n 1)
  dimmed=$work/dimmed
  mkdir "$dimmed"
  cp "$frames"/* "$dimmed"
  factors=$(oiiotool --info -v "$last" | sed -n 's/^ *channel list: //p' |
    tr -d ' ' | tr , '\n' |
    sed -e 's/^direct[.].*/.125/' -e 's/^emission[.].*/.125/' -e '/^[.]125/!s/.*/1/' |
    paste -s -d , -)
  oiiotool "$last" --mulc "$factors" -d float -o "$dimmed/${last##*/}"
  run small --learn -o "$work/learnt-dimmed" "$dimmed"/*.exr
  oiiotool "$work/learnt-dimmed/${last##*/}" --mulc 8 -d float -o "$work/again.exr"
  works "--learn shows each frame its own light" "$HBIL" compare --max-rmse 0.4 \
    "$work/again.exr:indirect" "$work/learnt/${last##*/}:indirect"
else
  skip "--learn shows each frame its own light" "no oiiotool"
fi
rejected "no such view" 'w.%d.exr: there is no such frame' \
  small --view "$work/views/w.%d.exr" -o "$out" "$one"
rejected "a view that isn't there" 'w.exr: cannot be' \
  small --view "$work/views/w.exr" -o "$out" "$one"

# A view that is no picture of the place.
mkdir "$work/odd"
rejected "a folder as view" 'odd: cannot be read: Is a directory' \
  small --view "$work/odd" -o "$out" "$one"
rejected "a PNG as view" 'frame_0001.ao.png: no depth channel' \
  small --view "$work/demo/frame_0001.ao.png" -o "$out" "$one"
cp "$two" "$work/odd/nowhere.exr"
rejected "a view without a camera" 'nowhere.json: camera cannot be read' \
  small --map position= --view "$work/odd/nowhere.exr" -o "$out" "$one"
rejected "a view whose place is unknown" \
  'nowhere.exr: the place of its camera is unknown (--fov)' \
  small --quiet --fov 60 --map position= --view "$work/odd/nowhere.exr" -o "$out" "$one"
rejected "a view without indirect light" \
  'no indirect light; --view-light radiance needs' \
  small --view-light radiance --view "$two" -o "$out" "$one"
mkdir "$out"
cp "$two" "${two%.exr}.json" "$out"
rejected "a result never replaces a view" 'would overwrite the view' \
  small --overwrite --view "$out/frame_0002.exr" -o "$out" "$two"
rm -r "$out"

# usable NAME FILE: a view that is odd, but one.
usable() {
  works "$1: is taken" quiet --view "$2" -o "$work/odd-lit" "$one"
  works "$1: the light is finite" "$HBIL" compare --max-rmse 0 \
    "$work/odd-lit/frame_0001.exr" "$work/odd-lit/frame_0001.exr"
}
usable "the frame itself" "$one"
# moved X NAME: the second frame, its camera moved along the world's x axis.
moved() {
  cp "$two" "$work/odd/$2.exr"
  awk -v by="$1" '/camera_to_world/ { at = NR }
    at && !done && /-?[0-9.e+-]+,?$/ && ++n == 4 {
      sub(/-?[0-9.][0-9.e+-]*/, by); done = 1 }
    { print }' "${two%.exr}.json" >"$work/odd/$2.json"
}
moved 1000 far
usable "a view far away" "$work/odd/far.exr"
moved 2.4 wall
usable "a view from inside a wall" "$work/odd/wall.exr"
run small --learn --view "$work/odd/wall.exr" --view "$two" -o "$work/odd-told" "$one"
told '^hbil: .*/wall.exr: warning: the camera stands .*: the camera of another frame' &&
  test "$(grep -c 'warning' "$work/err")" -eq 1
ok $? "a view with the camera of another picture is told of, once"
run small --overwrite --camera positions --view "$work/odd/wall.exr" -o "$work/odd-told" "$one"
test $status -eq 0 && ! grep -q 'warning' "$work/err"
ok $? "and --camera positions, which the warning names, helps"
# A channel under another name of the same length isn't there.
without() { # NAME CHANNELS AS
  LC_ALL=C sed "s/$2\\./$3./g" "$two" >"$work/odd/$1.exr"
  cp "${two%.exr}.json" "$work/odd/$1.json"
}
without positions depth depti
usable "a view whose depth is in its positions" "$work/odd/positions.exr"
LC_ALL=C sed 's/position\./positipn./g' "$work/odd/positions.exr" \
  >"$work/odd/no-depth.exr"
cp "${two%.exr}.json" "$work/odd/no-depth.json"
rejected "a view without depth" 'no-depth.exr: no depth channel' \
  small --view "$work/odd/no-depth.exr" -o "$out" "$one"
without no-normals normal normbl
rejected "a view without normals" 'no-normals.exr: no normals' \
  small --view "$work/odd/no-normals.exr" -o "$out" "$one"
without no-direct direct dirfct
usable "a view without direct light" "$work/odd/no-direct.exr"
LC_ALL=C sed 's/emission\./emissipn./g' "$work/odd/no-direct.exr" \
  >"$work/odd/no-light.exr"
cp "${two%.exr}.json" "$work/odd/no-light.json"
rejected "a view without light" \
  'no-light.exr: no direct light and no emission; a view needs one' \
  small --view "$work/odd/no-light.exr" -o "$out" "$one"
without no-albedo albedo albedp
usable "a view without albedo" "$work/odd/no-albedo.exr"
works "a demo of one pixel" "$HBIL" demo --frames 1 --size 1x1 -o "$work/pixel"
usable "a view of one pixel" "$work/pixel/gbuffer/frame_0001.exr"
# The 19 channels of 80 pixels in each of the last twenty rows, uncompressed.
works "an uncompressed frame" process --quiet --layers ao --copy-channels \
  --compression none -o "$work/plain" "$two"
cp "$work/plain/frame_0002.exr" "$work/odd/nan.exr"
cp "${two%.exr}.json" "$work/odd/nan.json"
size=$(wc -c <"$work/odd/nan.exr") row=$((19 * 80 * 4)) i=0
while test $i -lt 20; do
  i=$((i + 1))
  tr '\0' '\377' </dev/zero | dd of="$work/odd/nan.exr" bs=1 conv=notrunc \
    count=$row seek=$((size - i * row - (i - 1) * 8)) iflag=fullblock 2>/dev/null
done
says "a view with NaN" '([1-9][0-9]* not finite)' "$HBIL" info "$work/odd/nan.exr"
usable "a view with NaN" "$work/odd/nan.exr"
foreign=$HBIL_DATA/cornell/frame_0006.exr
if test -e "$foreign"; then
  rejected "a view of another renderer" \
    'another unit of direct light than that of .*; a view of the same renderer' \
    small --view "$foreign" -o "$out" "$one"
else
  skip "a view of another renderer" "no dumps in $HBIL_DATA/cornell"
fi
absent "what was rejected left nothing" "$out"

# --- resume ---

works "a moving camera" quiet -o "$work/whole" "$frames"/*.exr
same "gives the same bits once more" "$work/moving" "$work/whole"
# Without --reprojection, frames hand on nothing but what the cache knows.
works "without history" quiet --reprojection none -o "$work/alone" "$frames"/*.exr
# resumed NAME FOLDER OPTIONS...: each single frame comes out as in FOLDER.
resumed() {
  name=$1 folder=$2 wrong=0
  shift 2
  for n in 1 2 3 4; do
    rm -rf "$work/resumed"
    cp -r "$folder" "$work/resumed"
    rm "$work/resumed/frame_000$n.exr"
    small --resume "$@" -o "$work/resumed" "$frames"/*.exr >"$work/out" \
      2>"$work/err" || wrong=1
    test "$(grep -c 'is there already' "$work/err")" -eq 3 || wrong=1
    diff -r "$folder" "$work/resumed" >>"$work/out" || wrong=1
  done
  ok $wrong "resumed, $name: as if nothing had happened"
}
resumed "with history" "$work/whole"
resumed "without history" "$work/alone" --reprojection none
resumed "learnt" "$work/learnt" --learn
# The third result breaks off the job; the next one continues it.
mkdir -p "$work/stopped/frame_0003.exr"
rejected "a result that can't be written" 'cannot be written: Is a directory' \
  quiet -o "$work/stopped" "$frames"/*.exr
rmdir "$work/stopped/frame_0003.exr"
works "resumed with the saved light" small --quiet --resume -o "$work/stopped" \
  "$frames"/*.exr
same "as if nothing had happened" "$work/whole" "$work/stopped"
# stays OPTIONS...: whether the result of the last such command stays, 1 or 0.
stays() {
  run process --resume -o "$work/stays" "$@"
  grep -c 'is there already$' "$work/err"
}
rm -rf "$work/stays"
stays --cache-size 16 --view "$two" "$one" >"$work/count"
cp "$two" "$work/odd/renamed.exr"
cp "${two%.exr}.json" "$work/odd/renamed.json"
test "$(stays --cache-size 16 --view "$work/odd/renamed.exr" "$one")" -eq 1
ok $? "a view is known by its content, not by its name"
test "$(stays --cache-size 16 --view "$work/views/v.9.exr" "$one")" -eq 0 &&
  test "$(stays --cache-size 16 --view "$work/views/v.9.exr" "$one")" -eq 1
ok $? "another view makes another result"
sed 's/^\(.*"fx": \)\([0-9]\)/\11\2/' "$work/views/v.9.json" >"$work/odd/far.json"
cp "$work/views/v.9.exr" "$work/odd/far.exr"
test "$(stays --cache-size 16 --view "$work/odd/far.exr" "$one")" -eq 0
ok $? "and so does another camera of it"
test "$(stays "$one")" -eq 0 && test "$(stays --far environment "$one")" -eq 1
ok $? "and no view, where --far environment changes nothing"
test "$(stays --cache-size 16 --learn "$one")" -eq 0
ok $? "and --learn"

# --- files ---

works "--cache-save" quiet --view "$work/views/v.#.exr" \
  --cache-save "$work/saved" -o "$work/from" "$one"
same "changes nothing" "$work/views-3" "$work/from"
ls "$work"/.hbil-*.tmp >"$work/out" 2>"$work/err"
test $? -ne 0
ok $? "and leaves nothing but the file"
run process --cache-load "$work/saved" -o "$work/loaded" "$one"
told "$line; .*/saved\$" && ! grep -q warning "$work/err"
ok $? "--cache-load makes a cache for one frame"
mkdir "$work/elsewhere"
cp "$one" "$work/elsewhere/f.exr"
awk '/camera_to_world/ { counts = 1 }
  counts && /[0-9]/ && ++n == 4 { sub(/-?[0-9][-+0-9.e]*/, 1000) }
  { print }' "${one%.exr}.json" >"$work/elsewhere/f.json"
run process --cache-load "$work/saved" -o "$work/loaded" "$work/elsewhere/f.exr"
told '/saved: warning: knows 0 % of the surfaces of the first frame, as if it were of another'
ok $? "a warning tells of a cache of another place"
works "which is what was saved" process --quiet --overwrite \
  --cache-load "$work/saved" --cache-save "$work/again" --learn \
  -o "$work/loaded" "$one"
# What a file knows, frames can do without views.
works "the light of views, without them" "$HBIL" compare --max-rmse 0.01 \
  "$work/loaded/frame_0001.exr:indirect" "$work/from/frame_0001.exr:indirect"
rejected "a file that is there" 'again: is there already; --overwrite' \
  small --learn --cache-save "$work/again" -o "$out" "$one"
rejected "a folder that isn't" 'again/c: cannot be written' \
  small --learn --cache-save "$work/no/again/c" -o "$out" "$one"
rejected "a folder as file" 'views: cannot be written' \
  small --learn --overwrite --cache-save "$work/views" -o "$out" "$one"
# unusable NAME PATTERN: the file $work/wrong.
unusable() {
  rejected "$1" "wrong: .*$2" process --cache-load "$work/wrong" -o "$out" "$one"
}
size=$(wc -c <"$work/saved")
# write AT BYTES: over those of a copy of the saved file, as printf %b reads them.
write() {
  cp "$work/saved" "$work/wrong"
  printf %b "$2" | dd of="$work/wrong" bs=1 seek="$1" conv=notrunc 2>/dev/null
}
unusable "no file" 'cannot be read: No such file'
: >"$work/wrong"
unusable "an empty file" 'is no radiance cache'
cp "$one" "$work/wrong"
unusable "a foreign file" 'is no radiance cache; a file that --cache-save'
head -c $((size - 1)) "$work/saved" >"$work/wrong"
unusable "a truncated file" 'is truncated'
head -c 60 "$work/saved" >"$work/wrong"
unusable "a truncated head" 'is no radiance cache'
{ cat "$work/saved" && echo; } >"$work/wrong"
unusable "a file that is too long" 'truncated or damaged'
write 8 '9.9'
unusable "a file of another version" 'another version'
write 32 '\0021'
unusable "a size that is impossible" 'is damaged'
write 40 '\0377\0377\0377\0377\0377\0377\0377\0377'
unusable "a voxel size that isn't a number" 'is damaged'
write $((size / 2)) '\0125\0252\0125\0252'
run process --quiet --cache-load "$work/wrong" -o "$out" "$one"
test $status -eq 2 && test "$(wc -l <"$work/err")" -eq 1 &&
  grep -q 'wrong: is damaged' "$work/err"
ok $? "a damaged file"
absent "what was rejected left nothing" "$out"
rejected "a folder" 'cannot be read: Is a directory' \
  process --cache-load "$work/views" -o "$out" "$one"
rm -rf "$work/stays"
loaded() {
  run process --resume --cache-load "$1" -o "$work/stays" "$one"
  grep -c 'is there already$' "$work/err"
}
loaded "$work/saved" >"$work/count"
cp "$work/saved" "$work/copy"
test "$(loaded "$work/copy")" -eq 1 && test "$(loaded "$work/again")" -eq 0
ok $? "a file is known by its content"
rm -f "$work/later"
works "a job that is done still saves its cache" small --quiet --resume \
  --cache-save "$work/later" -o "$work/whole" "$frames"/*.exr
works "as one that wasn't" quiet --cache-save "$work/first" -o "$work/other" \
  "$frames"/*.exr
for file in later first; do
  process --quiet --learn --cache-load "$work/$file" -o "$work/from-$file" "$one" \
    >"$work/out" 2>"$work/err"
done
works "which lights as the other" "$HBIL" compare --max-rmse 0 \
  "$work/from-later/frame_0001.exr" "$work/from-first/frame_0001.exr"

# --- what is told ---

says "--dry-run names the views" '/v.12.exr (view)$' small --dry-run \
  --view "$work/views/v.#.exr" -o "$out" "$one"
with=$(sed -n 's/^device .*, \([0-9]*\).* MiB on it$/\1/p' "$work/out")
run process --dry-run --view "$two" -o "$out" "$one"
large=$(sed -n 's/^device .*, \([0-9]*\).* MiB on it$/\1/p' "$work/out")
test "$large" -gt $((with + 20))
ok $? "and counts the cache's memory"
absent "and writes nothing" "$out"
says "--timings" '^radiance cache: [0-9.]* ms before the first frame$' \
  small --quiet --overwrite --timings --view "$two" -o "$work/timed" "$one"
says "as JSON" '"radiance_cache_learning": [0-9.]*' \
  small --quiet --overwrite --json --view "$two" -o "$work/timed" "$one"
says "which is null without a cache" '"radiance_cache_learning": null' \
  process --quiet --overwrite --json -o "$work/timed" "$one"
says "info" '^radiance cache: [0-9.]* units wide about .* 64 x 64 x 64 voxels of' \
  "$HBIL" info "$frames"/*.exr
info=$(sed -n 's/^radiance cache: .* voxels of \([0-9.]*\) units.*/\1/p' "$work/out")
process --overwrite -o "$work/default" "$frames"/*.exr >"$work/out" 2>"$work/err"
told=$(sed -n 's/^hbil: radiance cache: .* voxels of \([0-9.]*\) and.*/\1/p' "$work/err")
test -n "$info" && test "$info" = "$told"
ok $? "tells the size that process chooses"

# --- hbil-bench truth ---

scene=$work/scene
mkdir -p "$scene/walk" "$scene/views" "$scene/walk/views"
cp "$frames"/frame_0004.* "$scene"
cp "$frames"/frame_000[34].* "$scene/walk"
cp "$frames"/frame_0001.exr "$scene/views/face_a.exr"
cp "$frames"/frame_0001.json "$scene/views/face_a.json"
cp "$frames"/frame_0002.exr "$scene/views/face_b.exr"
cp "$frames"/frame_0002.json "$scene/views/face_b.json"
cp "$work/none/frame_0004.exr" "$scene/truth_avg_0004.exr"
truth() {
  # shellcheck disable=SC2086
  "$HBIL_BENCH" truth -o "$work/bench" "$@"
}
# shellcheck disable=SC2086
says "truth: a pattern of views" "^| scene |.*" truth "$scene" -- $fast \
  --cache-size 16 --view '{scene}/views/face_?.exr'
cp "$work/out" "$work/many"
# shellcheck disable=SC2086
works "truth: the views themselves" truth "$scene" -- $fast --cache-size 16 \
  --view '{scene}/views/face_a.exr' --view='{scene}/views/face_b.exr'
grep '^| scene' "$work/many" >"$work/a"
grep '^| scene' "$work/out" >"$work/b"
same_lists "are the same" "$work/a" "$work/b"
# shellcheck disable=SC2086
run truth "$scene" -- $fast --view '{scene}/no*'
test $status -eq 2 && grep -q -e '--view /.*/scene/no\*: there is no' "$work/err"
ok $? "truth: no such view"
# shellcheck disable=SC2086
says "truth: that of the folder above" '^| scene/walk |' truth "$scene/walk" -- \
  $fast --cache-size 16 --learn
cp "$frames/frame_0002.json" "$scene/frame_0004.json"
# shellcheck disable=SC2086
run truth "$scene/walk" -- $fast
test $status -eq 2 && grep -q 'truth_avg_0004.exr: another camera' "$work/err"
ok $? "truth: not if its camera is another one"
rm "$scene/truth_avg_0004.exr"
# shellcheck disable=SC2086
run truth "$scene/walk" -- $fast
test $status -eq 2 && grep -q 'here or in the folder above' "$work/err"
ok $? "truth: none at all"
# shellcheck disable=SC2086
run truth "$scene/walk" -- $fast --cache-save "$work/x"
test $status -eq 2
ok $? "truth: saves no cache"

# --- which pictures decide what open directions end in ---

for scene in corner sky; do
  works "a demo of another place, $scene" "$HBIL" demo --scene $scene --frames 2 \
    --size 80x45 -o "$work/$scene"
done
inside=$work/corner/gbuffer/frame_0001.exr
outside=$work/sky/gbuffer/frame_0002.exr
closed='surfaces: no sky is visible, and none lights the shadows$'
open='weaker than that of the visible sky$'
# decides NAME PATTERN OPTION...: what one line says of open directions.
decides() {
  name=$1 pattern=$2
  shift 2
  run process --dry-run -o "$out" "$@"
  told "^hbil: light of unblocked directions: .*$pattern" &&
    test "$(grep -c 'unblocked directions' "$work/err")" -eq 1
  ok $? "$name"
}
decides "the first frame decides" "$closed" "$inside" "$outside"
decides "and a view" "$open" --view "$outside" "$inside"
decides "and what is learnt" "$open" --learn "$inside" "$outside"
decides "but for chunks one frame, and views" "$closed" --learn \
  --decide-by "$inside" "$inside" "$outside"

# --- cuts ---

# Frames 1 to 3 of one place, and as 4 to 6 those of another one, 120 units away.
mkdir "$work/film" "$work/second"
works "a demo of another place" "$HBIL" demo --scene corner --frames 3 --size 80x45 \
  -o "$work/place"
for n in 1 2 3; do
  cp "$frames/frame_000$n.exr" "$frames/frame_000$n.json" "$work/film"
  from=$work/place/gbuffer/frame_000$n to=$work/film/frame_000$((n + 3))
  oiiotool "$from.exr" --addc 0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,120,0,0 -o "$to.exr"
  awk '/camera_to_world/ { at = NR + 5 } NR == at { $1 += 120 } { print }' \
    "$from.json" >"$to.json"
  cp "$to.exr" "$to.json" "$work/second"
done
film=$work/film/frame_####.exr
run small -o "$work/filmed" "$film"
told '0004.exr: a cut: another place, 1[12][0-9] units away, .*--cuts' &&
  test "$(grep -c 'a cut:' "$work/err")" -eq 1 &&
  test "$(grep -c 'radiance cache: 16' "$work/err")" -eq 2
ok $? "a cut to another place is found, which has a cache of its own"
quiet -o "$work/filmed_second" "$work/second/frame_####.exr"
mkdir "$work/behind"
cp "$work"/filmed/frame_000[456].exr "$work/behind"
same "and its frames are those of a job that begins there" "$work/behind" "$work/filmed_second"
cp -r "$work/filmed" "$work/cutshort"
rm "$work/cutshort/frame_0002.exr" "$work/cutshort/frame_0005.exr"
works "an interrupted job goes on at both sides" small --resume --quiet \
  --contact-sheet "$work/film.png" -o "$work/cutshort" "$film"
same "as if it had not been interrupted" "$work/cutshort" "$work/filmed"
works "with --learn" quiet --learn -o "$work/learnt" "$film"
works "each place learns from its own frames" quiet --learn -o "$work/filmed_second" \
  "$work/second/frame_####.exr"
works "and no others" "$HBIL" compare --max-rmse 0 "$work/learnt/frame_0005.exr" \
  "$work/filmed_second/frame_0005.exr"
run small --timings --json --overwrite -o "$work/filmed" "$film"
test $status -eq 0 && test "$(grep -c '"frame": .*frame_' "$work/out")" -eq 6
ok $? "timings are one list"
run small --cuts none -o "$work/uncut" "$film"
test $status -eq 0 && ! grep -q 'a cut:' "$work/err"
ok $? "--cuts none: there is no cut"
differs "and voxels are too wide for both" "$HBIL" compare --max-rmse 1e-3 \
  "$work/uncut/frame_0006.exr:indirect" "$work/filmed/frame_0006.exr:indirect"
run small --overwrite --cuts 3 -o "$work/uncut" "$film"
told '0003.exr: a cut: ' && test "$(grep -c 'a cut:' "$work/err")" -eq 1
ok $? "--cuts overrules"
run small --dry-run --cuts 3,4 -o "$out" "$film"
test "$(grep -c 'frame_000[1-6].exr -> ' "$work/out")" -eq 6 &&
  grep -q '^6 of 6 frames would' "$work/out"
ok $? "a dry run lists the frames of all places"
run small --dry-run -o "$out" --frames 5,6 --pre-roll 4 "$film"
test "$(grep -c 'pre-roll, not written' "$work/out")" -eq 4 &&
  grep -q '^2 of 2 frames would' "$work/out"
ok $? "and pre-roll goes across a cut"
for n in 1 7; do
  rejected "--cuts $n" "--cuts $n: .* $n" small --cuts $n -o "$out" "$film"
done
run small --dry-run --cuts 3,4,9 --frames 3-6 -o "$out" "$film"
told '0004.exr: a cut: ' && test "$(grep -c 'a cut:' "$work/err")" -eq 1
ok $? "a chunk takes the cuts behind its first frame, and leaves those of others"
run small --dry-run --cuts 4 --frames 1-3 -o "$out" "$film"
test $status -eq 0 && ! grep -q 'a cut:' "$work/err"
ok $? "or none"
rejected "a cut at a gap in the chunk" '--cuts 4: no frame has the number 4' \
  small --dry-run --cuts 4 --frames 3,5,6 -o "$out" "$film"
rejected "--cuts and a view" 'cuts 4: not with views' small --cuts 4 --view "$one" \
  -o "$out" "$film"
rejected "--cuts and one file" 'cuts: not with --cache-save' small --cuts 4 \
  --cache-save "$work/x" -o "$out" "$film"
rejected "--cuts of no numbers" 'cuts four: none, or numbers' small --cuts four \
  -o "$out" "$film"
run small --dry-run -o "$out" "$one" "$frames/frame_0004.exr" "$two"
test $status -eq 0 && ! grep -q 'a cut:' "$work/err"
ok $? "a leap within a place is no cut"

echo "1..$count"
