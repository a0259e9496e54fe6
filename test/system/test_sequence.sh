#!/bin/sh
# Sequences: which frames there are, what is done and not done with results that
# are there, what goes over from frames to results, what limits the pace, and
# the pictures of it.
#
# Speaks TAP.
srcdir=${srcdir:-$(dirname "$0")/../..}
. "$srcdir/test/support/tap.sh"

# The exact integral of few slices: no device, so no kernels to be compiled.
exact() {
  "$HBIL" process --quiet --quality reference --slices 1 --warm-up 0 "$@"
}
# One kernel of occlusion alone.
device() {
  "$HBIL" process --mode gtao --layers ao --slices 1 --steps-per-side 4 "$@"
}
# same NAME FOLDER FOLDER: the same files in both, bit by bit.
same() {
  run diff -r "$2" "$3"
  ok $status "$1"
}
# holds NAME FOLDER FILES...: these and no others, hidden ones included.
holds() {
  name=$1 folder=$2
  shift 2
  ls -A "$folder" >"$work/out"
  test "$(tr '\n' ' ' <"$work/out")" = "$(printf '%s ' "$@")"
  ok $? "$name"
}

works "a demo" "$HBIL" demo --frames 5 --size 40x30 -o "$work/demo"
frames=$work/demo/gbuffer
out=$work/never

# --- which frames ---

works "a plain list" exact -o "$work/all" "$frames"/*.exr
for pattern in 'frame_%04d.exr' 'frame_####.exr'; do
  rm -rf "$work/some"
  works "$pattern: all that are there" exact -o "$work/some" "$frames/$pattern"
  same "$pattern: as in a list" "$work/all" "$work/some"
done
works "a range with a step, and one frame" \
  exact --frames 1-3x2,5 -o "$work/odd" "$frames/frame_####.exr"
holds "are these" "$work/odd" frame_0001.exr frame_0003.exr frame_0005.exr
(cd "$frames" && exact --frames 2-2 -o "$work/here" frame_%04d.exr) \
  >"$work/out" 2>"$work/err"
ok $? "a pattern without a folder"
mkdir "$work/shot"
for n in 8 9 10 11 099; do
  cp "$frames/frame_0001.exr" "$work/shot/a.$n.exr"
  cp "$frames/frame_0001.json" "$work/shot/a.$n.json"
done
run "$HBIL" process --quality reference --slices 1 --warm-up 0 \
  -o "$work/lit" "$work/shot/a.#.exr"
grep '^\[' "$work/err" | sed 's|.*/||' | tr '\n' ' ' >"$work/out"
test "$(cat "$work/out")" = 'a.8.exr a.9.exr a.10.exr a.11.exr '
ok $? "numbers of any width, in their order, without those padded otherwise"
cp "$frames/frame_0001.exr" "$work/shot/b.%d.exr"
cp "$frames/frame_0001.json" "$work/shot/b.%d.json"
works "a file whose name is like a pattern" \
  exact -o "$work/lit" "$work/shot/b.%d.exr"
has "is taken as it is" "$work/lit/b.%d.exr"

rejected "missing frames are all named" \
  ': 5 of 9 frames are missing: 6-9, 20; --frames with those that are there (1-5) is needed' \
  exact --frames 2-9,20 -o "$out" "$frames/frame_%04d.exr"
rejected "those of a list, too" \
  ': 2 of 3 frames are missing: .*/x.exr, .*/y.exr$' \
  exact -o "$out" "$work/x.exr" "$frames/frame_0001.exr" "$work/y.exr"
mkdir "$work/holes"
cp "$frames"/frame_000[1245].* "$work/holes"
rejected "a hole is an accident" 'frame_####.exr: 1 of 5 frames is missing: 3; .*there (1-2, 4-5)' \
  exact -o "$out" "$work/holes/frame_####.exr"
works "unless it is asked for" \
  exact --frames 1-2,4-5 -o "$work/asked" "$work/holes/frame_####.exr"
rm "$work"/holes/frame_000[24].*
works "every fourth frame has no hole" \
  exact -o "$work/fourth" "$work/holes/frame_####.exr"
for range in '' '--frames 1-3'; do
  # shellcheck disable=SC2086
  rejected "no such frame at all $range" 'g.%d.exr: there is no such frame' \
    exact $range -o "$out" "$work/shot/g.%d.exr"
done
for range in '' 1- 1-2x 1-2x0 -1 1,,2 1-2, a 1-2y3 99999999 0-9999999; do
  rejected "--frames '$range'" "^hbil: --frames $range: FIRST-LAST" \
    exact --frames "$range" -o "$out" "$frames/frame_%04d.exr"
done
rejected "--frames from the last to the first" '^hbil: --frames 1,5-2: 5 is after 2; FIRST-LAST' \
  exact --frames 1,5-2 -o "$out" "$frames/frame_%04d.exr"
rejected "--frames without a place for them" 'has no place for a number' \
  exact --frames 1 -o "$out" "$frames/frame_0001.exr"
absent "what was rejected left nothing" "$out"

# --- results that are there ---

cp -r "$work/all" "$work/before"
rejected "a result that is there" \
  'all/frame_0003.exr: is there already; --overwrite.*--resume' \
  exact -o "$work/all" "$frames/frame_0003.exr"
same "is left alone" "$work/before" "$work/all"
works "--overwrite" exact --overwrite -o "$work/all" "$frames/frame_0003.exr"
cmp "$work/before/frame_0003.exr" "$work/all/frame_0003.exr" \
  >"$work/out" 2>"$work/err"
test $? -eq 1
ok $? "replaces it"
rejected "--overwrite and --resume" 'resume: not with --overwrite' \
  exact --overwrite --resume -o "$work/all" "$frames/frame_0003.exr"

says "--dry-run" '^1 of 1 frames would be written, 40 x 30 pixels: near_irradiance,' \
  exact --dry-run --contact-sheet "$out/sheet.png" -o "$out" \
  "$frames/frame_0001.exr"
absent "writes nothing" "$out"
rm -rf "$work/all"
cp -r "$work/before" "$work/all"
rm "$work/all/frame_0004.exr"
: >"$work/all/$left_here"
says "--dry-run and --resume" '^1 of 5 frames would be written' \
  exact --dry-run --resume -o "$work/all" "$frames/frame_####.exr"
grep -q 'frame_0003.exr (is there already)$' "$work/out" &&
  grep -q 'frame_0004.exr$' "$work/out"
ok $? "tell which"
test -e "$work/all/$left_here" &&
  test ! -e "$work/all/frame_0004.exr"
ok $? "and write and sweep nothing"
says "--dry-run and a folder without a parent" '^1 of 1 frames would' \
  exact --dry-run -o "$out/deeper/still" "$frames/frame_0001.exr"
absent "makes neither" "$out"
says "--dry-run and a sheet above the output folder" '^1 of 1 frames would' \
  exact --dry-run --contact-sheet "$out/sheet.png" -o "$out/deeper/still" "$frames/frame_0001.exr"
for option in "--contact-sheet $out/deep/sheet.png" "--learn --cache-save $out/deeper/still/c/cache"; do
  for dry in --dry-run ""; do
    # shellcheck disable=SC2086
    rejected "${option% *} in a folder that nothing makes $dry" 'cannot be written: No such file' \
      "$HBIL" process $dry $option -o "$out/deeper/still" "$frames/frame_0001.exr"
  done
done
rejected "--dry-run and a folder in a file" 'cannot be created' \
  exact --dry-run -o "$frames/frame_0001.exr/deeper" "$frames/frame_0001.exr"
rejected "and without --dry-run" 'cannot be created' \
  exact -o "$frames/frame_0001.exr/deeper" "$frames/frame_0001.exr"
works "missing folders are made" \
  exact -o "$work/far/away/lit" "$frames/frame_0001.exr"
has "and filled" "$work/far/away/lit/frame_0001.exr"
mkdir "$work/far/there"
rejected "a job that fails" 'no such device' \
  device --device nonsense -o "$work/far/there/a/b/c" "$frames/frame_0001.exr"
absent "removes those that it has made" "$work/far/there/a"
test -d "$work/far/there"
ok $? "and no others"

# --- a folder of frames ---

works "a folder in place of its frames" exact -o "$work/folder" "$frames"
same "is their pattern" "$work/before" "$work/folder"
works "with --frames" exact --frames 2,4 -o "$work/folder-2" "$frames/"
holds "those alone" "$work/folder-2" frame_0002.exr frame_0004.exr
mkdir "$work/single"
cp "$frames/frame_0001.exr" "$work/single/only.exr"
cp "$frames/frame_0001.json" "$work/single/only.json"
works "a folder with a single file" exact -o "$work/only" "$work/single"
has "has one frame" "$work/only/only.exr"
cp "$frames/frame_0001.exr" "$work/single/other.0001.exr"
rejected "a folder with two sequences" 'single: holds .*; the pattern of one sequence' \
  exact -o "$out" "$work/single"
mkdir "$work/gap"
cp "$frames"/frame_000[1245].* "$work/gap"
rejected "a folder with a hole" 'frame_####.exr: 1 of 5 frames is missing: 3;' \
  exact -o "$out" "$work/gap"
mkdir "$work/padding"
cp "$frames/frame_0001.exr" "$work/padding/frame_9.exr"
cp "$frames/frame_0001.exr" "$work/padding/frame_10.exr"
cp "$frames/frame_0002.exr" "$work/padding/frame_0011.exr"
rejected "a folder with numbers of another padding" \
  'holds frame_#.exr and frame_####.exr; the pattern of one sequence' \
  exact -o "$out" "$work/padding"
rejected "a folder without frames" 'there: holds no EXR file' \
  exact -o "$out" "$work/far/there"
rejected "--dry-run finds what is wrong" 'is there already' \
  exact --dry-run -o "$work/before" "$frames/frame_0001.exr"

# info takes what process takes, and its status is about all of it.
for files in "$frames" "$frames/frame_####.exr"; do
  run "$HBIL" info "$files"
  test $status -eq 0 && test "$(grep -c '40 x 30 pixels, read as' "$work/out")" -eq 1 &&
    grep -q '^sequence: 5 frames, .*frame_0001.exr to .*frame_0005.exr, ' "$work/out"
  ok $? "info of ${files##*/}"
done
rejected "info of a folder with a hole" 'frame_####.exr: 1 of 5 frames is missing: 3;' \
  "$HBIL" info "$work/gap"
says "unless --frames leaves it out" '^radiance cache' "$HBIL" info --frames 1-2,4 "$work/gap"
works "a frame of another size" "$HBIL" demo --frames 1 --size 48x30 -o "$work/wider"
for command in "process -o $out" info; do
  # shellcheck disable=SC2086
  rejected "it is no frame of that sequence, says ${command%% *}" \
    'wider/.*: 48 x 30 pixels, but .* has 40 x 30; frames of one size' \
    "$HBIL" $command "$frames/frame_0001.exr" "$work/wider/gbuffer/frame_0001.exr"
done
rejected "nor with a pattern" 'wider/.*: 48 x 30 pixels, but .* has 40 x 30' \
  "$HBIL" info "$frames" "$work/wider/gbuffer"

# --- side by side ---

works "the same sequence once more" exact -o "$work/again" "$frames"/*.exr
same "comes out bit by bit" "$work/before" "$work/again"
# Each stage in turn breaks off at the third frame: those before it are whole.
broken() { # NAME PATTERN
  rm -rf "$work/stopped"
  rejected "$1" "$2" exact -o "$work/stopped" "$work/bad/frame_####.exr"
  holds "$1: two frames and the light behind them" "$work/stopped" \
    .hbil-light.frame_0001 frame_0001.exr frame_0002.exr
}
mkdir "$work/bad"
cp "$frames"/* "$work/bad"
size=$(wc -c <"$frames/frame_0003.exr")
head -c $((size - 100)) "$frames/frame_0003.exr" >"$work/bad/frame_0003.exr"
broken "a frame that can't be read" 'frame_0003.exr: truncated'
cp "$frames/frame_0003.exr" "$work/bad"
mkdir "$work/stopped/frame_0003.exr"
rejected "a result that can't be written" \
  'frame_0003.exr: cannot be written: Is a directory' \
  exact --overwrite -o "$work/stopped" "$work/bad/frame_####.exr"
holds "two frames and the light behind them" "$work/stopped" \
  .hbil-light.frame_0001 frame_0001.exr frame_0002.exr frame_0003.exr
rmdir "$work/stopped/frame_0003.exr"
works "resumed" exact --resume -o "$work/stopped" "$work/bad/frame_####.exr"
same "as if nothing had happened" "$work/before" "$work/stopped"

# --- pace ---

run "$HBIL" process --quality reference --slices 1 --warm-up 0 \
  -o "$work/told" "$frames"/*.exr
pace='[0-9.]* ms a frame, [0-9.e+]* frames/s; limited by \(decode\|device\|encode\)'
pace="$pace (decode [0-9.]*, device [0-9.]*, encode [0-9.]*, wall [0-9.]* x"
test $status -eq 0 && test "$(grep -c '^\[[1-5]/5\] /' "$work/err")" -eq 5 &&
  tail -n 1 "$work/err" | grep -q "^hbil: $pace"
ok $? "plain lines, and at the end what limits the pace"
run exact --overwrite -o "$work/told" "$frames"/*.exr
test $status -eq 0 && test ! -s "$work/err" && test ! -s "$work/out"
ok $? "--quiet says nothing"
says "--timings tell it, too" "^$pace" device --timings -o "$work/device" \
  "$frames"/*.exr
grep -q '^stage, ms  *decode  *device  *encode$' "$work/out" &&
  test "$(grep -c 'frame_0005.exr  *[0-9.]*  *[0-9.]*  *[0-9.]*$' \
    "$work/out")" -eq 1
ok $? "for every frame"
run device --json --overwrite -o "$work/device" "$frames"/*.exr
missing=$status
for member in decode device encode wall wall_over_slowest; do
  sed -n '/"pipeline"/,$p' "$work/out" | grep -q "\"$member\": [0-9]" ||
    missing=1
done
grep -q '"limit": "\(decode\|device\|encode\)"' "$work/out" || missing=1
test "$(grep -c '"encode": [0-9]' "$work/out")" -eq 6 || missing=1
ok $missing "and as JSON"

if script -qec true /dev/null >"$work/out" 2>"$work/err"; then
  run script -qec "'$HBIL' process --mode gtao --layers ao --slices 1 \
    --steps-per-side 4 --overwrite -o '$work/device' '$frames/frame_####.exr'" /dev/null
  test $status -eq 0 &&
    grep -q '\[#*\.*\] [1-5]/5, [0-9.e+]* frames/s, .* left' "$work/out" &&
    ! grep -q '\[[1-5]/5\]' "$work/out"
  ok $? "on a terminal there is a bar"
else
  skip "on a terminal there is a bar" "no script"
fi

# --- what a result has of its frame ---

one=$frames/frame_0001.exr
works "--copy-channels" exact --copy-channels --layers ao,near_irradiance -o "$work/copied" "$one"
for channels in depth normal position albedo direct emission motion; do
  works "has the frame's $channels" "$HBIL" compare --max-rmse 0 \
    "$work/copied/frame_0001.exr:$channels" "$one:$channels"
done
works "and the layers are those without it" "$HBIL" compare --max-rmse 0 \
  "$work/copied/frame_0001.exr:near_irradiance" "$work/before/frame_0001.exr:near_irradiance"
works "a result can be a frame again" \
  exact --copy-channels -o "$work/twice" --camera "${one%.exr}.json" \
  "$work/copied/frame_0001.exr"
works "--copy-channels and --resume" exact --copy-channels --layers ao,near_irradiance --resume \
  -o "$work/copied" "$one"
works "--precision half" exact --precision half --layers ao -o "$work/half" "$one"
# halves have 11 bits: 2^-12 of a value up to 1
works "loses little" "$HBIL" compare --max-rmse 2.5e-4 \
  "$work/half/frame_0001.exr:ao" "$work/before/frame_0001.exr:ao"
for how in none rle zips piz input; do
  works "--compression $how" exact --layers ao --compression $how \
    -o "$work/$how" "$one"
  works "loses nothing: $how" "$HBIL" compare --max-rmse 0 \
    "$work/$how/frame_0001.exr:ao" "$work/before/frame_0001.exr:ao"
done
exact --layers ao -o "$work/default" "$one"
cmp -s "$work/default/frame_0001.exr" "$work/none/frame_0001.exr"
ok $? "no compression is the default"
size=$(wc -c <"$work/none/frame_0001.exr")
test "$size" -gt "$(wc -c <"$work/zips/frame_0001.exr")"
ok $? "none is larger than zips"
exact --precision half --layers ao --compression none -o "$work/half-none" "$one"
test $((size - $(wc -c <"$work/half-none/frame_0001.exr"))) -eq $((40 * 30 * 2))
ok $? "floats have four bytes, halves two"
# Colours that are halves decide that layers are: here those of a result.
exact --precision half --layers near_irradiance --copy-channels -o "$work/mixed" "$one"
for how in auto half float; do
  works "--precision $how, of a frame with halves" exact --precision $how --layers ao \
    --map direct=near_irradiance --camera "${one%.exr}.json" -o "$work/of-$how" \
    "$work/mixed/frame_0001.exr"
done
cmp -s "$work/of-auto/frame_0001.exr" "$work/of-half/frame_0001.exr"
ok $? "halves are the default there"
test $(($(wc -c <"$work/of-float/frame_0001.exr") - \
  $(wc -c <"$work/of-half/frame_0001.exr"))) -eq $((40 * 30 * 2))
ok $? "and floats are not"
rejected "an unknown compression" 'none, rle, zips, zip, piz' \
  exact --compression lzma -o "$out" "$one"
run "$HBIL" process --quality reference --slices 1 --warm-up 0 --precision half --resume \
  --layers ao --compression zips -o "$work/zips" "$one"
test $status -eq 0 && ! grep -q 'is there already$' "$work/err"
ok $? "floats are not the halves that are asked for"
if command -v oiiotool >/dev/null; then
  oiiotool "$one" --attrib:type='float[8]' chromaticities \
    0.713,0.293,0.165,0.83,0.128,0.044,0.32168,0.33767 --attrib owner me \
    --origin +7+5 --fullsize 64x48+0+0 -o "$work/shot/c.exr" >"$work/out" 2>&1
  cp "${one%.exr}.json" "$work/shot/c.json"
  works "a frame with attributes and windows" \
    exact --copy-channels --compression piz -o "$work/attributes" "$work/shot/c.exr"
  oiiotool --info -v "$work/attributes/c.exr" >"$work/out" 2>"$work/err"
  missing=0
  for line in 'chromaticities: 0.713, 0.293, 0.165, 0.83' 'Copyright: "me"' \
    'compression: "piz"' 'pixel data origin: x=7, y=5' \
    'full/display size: 64 x 48'; do
    grep -q "$line" "$work/out" || missing=1
  done
  ok $missing "goes over with them"
  # every channel LAYER.LETTER, as Nuke, Blender and others split names; the
  # order is oiiotool's
  grep -q 'channel list: ao.V, .*beauty.R, beauty.G, beauty.B, bent_normal.X' \
    "$work/out" &&
    sed -n 's/.*channel list: //p' "$work/out" | tr -d ' ' | tr ',' '\n' |
    grep -q -v '^[a-z_]*\.[RGBXYZV]$'
  test $? -eq 1
  ok $? "channels are shown as layers"
  works "of which one can be taken" oiiotool "$work/attributes/c.exr" \
    --ch near_irradiance.R,near_irradiance.G,near_irradiance.B -o "$work/near.exr"
else
  for name in "a frame with attributes and windows" "goes over with them" \
    "channels are shown as layers" "of which one can be taken"; do
    skip "$name" "no oiiotool"
  done
fi

# --- pictures ---

# pixels FILE: "WIDTH HEIGHT" of a PNG.
pixels() {
  od -A n -t u1 -j 16 -N 8 "$1" | awk '{
    print 256 * (256 * (256 * $1 + $2) + $3) + $4,
      256 * (256 * (256 * $5 + $6) + $7) + $8 }'
}
works "--contact-sheet" exact --contact-sheet "$work/sheet.png" \
  -o "$work/sheet" "$frames/frame_####.exr"
# four tiles of 160 x 120 and three below, with gaps of 8 and a line of 22 above each,
# and one for the name of each of five frames
test "$(pixels "$work/sheet.png")" = "680 1610"
ok $? "has layers in lines of four, frames below each other"
works "from results that are there" exact --resume \
  --contact-sheet "$work/sheet2.png" -o "$work/sheet" "$frames/frame_####.exr"
run cmp "$work/sheet.png" "$work/sheet2.png"
ok $status "it is the same"
rejected "a sheet that is there" 'sheet.png: is there already; --overwrite' \
  exact --contact-sheet "$work/sheet.png" -o "$out" "$one"
for name in sheet.jpg sheet.exr sheet.tif; do
  rejected "a sheet that is named $name" "$name: --contact-sheet writes PNG alone; a name that ends in .png" \
    exact --contact-sheet "$work/$name" -o "$out" "$frames/frame_0001.exr"
done
rejected "a sheet in no folder" 'sheet.png: cannot be written' \
  exact --contact-sheet "$work/no/sheet.png" -o "$out" "$one"
i=0
while test $i -lt 11; do
  i=$((i + 1))
  n=$(printf '%02d' $i)
  cp "$one" "$work/shot/many.$n.exr"
  cp "${one%.exr}.json" "$work/shot/many.$n.json"
done
works "of a long sequence" exact --layers ao --contact-sheet "$work/long.png" \
  -o "$work/long" "$work/shot/many.##.exr"
test "$(pixels "$work/long.png")" = "176 1376"
ok $? "it shows eight frames"
# looks FRAME: whether another picture there changes the sheet.
looks() {
  cp "$frames/frame_0005.exr" "$work/shot/many.$1.exr"
  exact --overwrite --layers ao --contact-sheet "$work/other.png" \
    -o "$work/long" "$work/shot/many.##.exr"
  cp "$one" "$work/shot/many.$1.exr"
  ! cmp -s "$work/long.png" "$work/other.png"
}
looks 01 && looks 11
ok $? "the first and the last among them"
! looks 04
ok $? "and not the fourth"
works "a heat map" "$HBIL" compare --heatmap "$work/heat.png" \
  "$work/before/frame_0001.exr:near_irradiance" "$work/before/frame_0002.exr:near_irradiance"
test "$(pixels "$work/heat.png")" = "200 70"
ok $? "has a legend below"
works "--preview" exact --preview -o "$work/preview" "$frames"/frame_000[15].exr
for l in near_irradiance far_irradiance indirect ao bent_normal cone_cosine beauty; do
  test "$(pixels "$work/preview/frame_0005.$l.png")" = "40 30"
  ok $? "--preview: $l"
done

echo "1..$count"
