#!/bin/sh
# Files and values from outside can do no harm: a result or one clear line,
# nothing half-written, and a job that was broken off goes on with --resume.
#
# Speaks TAP.
srcdir=${srcdir:-$(dirname "$0")/../..}
. "$srcdir/test/support/tap.sh"

process() {
  "$HBIL" process --quiet "$@"
}
# The exact integral of few slices: no device, so no kernels to be compiled.
exact() {
  process --quality reference --slices 2 --warm-up 0 "$@"
}
# same NAME FOLDER FOLDER: the same files in both, bit by bit.
same() {
  run diff -r "$2" "$3"
  ok $status "$1"
}

works "a demo" "$HBIL" demo --frames 4 --size 40x30 -o "$work/demo"
frames=$work/demo/gbuffer
one=$frames/frame_0001.exr
camera=$frames/frame_0001.json
out=$work/none

# --- damaged files and those of other programs ---

# info is given all of a folder at once: every file is told once, understood or
# rejected.  Two gigabytes of addresses hold the tool, its libraries and the
# largest image that a header in there claims.
look_at() { # NAME FILE...
  name=$1
  shift
  (
    ulimit -v 2000000
    ulimit -t 60
    "$HBIL" info "$@"
  ) >"$work/out" 2>"$work/err"
  status=$?
  bad=0
  test $status -eq 0 || test $status -eq 2 || bad=1
  for file; do
    lines=$(grep -c -F "hbil: $file: " "$work/err")
    understood=$(grep -c -F "$file: " "$work/out")
    test "$lines" -le 1 && test $((lines + understood)) -ge 1 || bad=1
  done
  test "$(grep -c -v '^hbil: /' "$work/err")" -eq 0 || bad=1
  ok $bad "info: $name"
}

# process takes the first of them and no other; what it says is one line.
process_each() { # NAME FILE...
  name=$1 bad=0
  shift
  : >"$work/told"
  for file; do
    (
      ulimit -t 60
      process --quality fast --camera "$camera" -o "$work/each" "$file"
    ) >"$work/out" 2>"$work/err"
    status=$?
    if test $status -eq 2; then
      test "$(wc -l <"$work/err")" -eq 1 && grep -q '^hbil: ' "$work/err" &&
        test ! -e "$work/each"
    else
      test $status -eq 0 && test ! -s "$work/err" &&
        test "$(ls -A "$work/each")" = "$(basename "${file%.*}").exr"
    fi || {
      bad=1
      echo "$file: exit status $status" >>"$work/told"
      cat "$work/err" >>"$work/told"
      ls -A "$work/each" >>"$work/told" 2>&1
    }
    rm -rf "$work/each"
  done
  mv "$work/told" "$work/err"
  ok $bad "process: $name"
}

for folder in malformed real_exr; do
  if test -d "$HBIL_DATA/$folder"; then
    look_at "$folder" "$HBIL_DATA/$folder"/*
    process_each "$folder" "$HBIL_DATA/$folder"/*
  else
    skip "info: $folder" "no $HBIL_DATA/$folder"
    skip "process: $folder" "no $HBIL_DATA/$folder"
  fi
done

# Our own frame, cut off or with some bytes changed.
size=$(wc -c <"$one")
mkdir "$work/damaged"
at=7
while test $at -lt "$size"; do
  dd if="$one" of="$work/damaged/cut-$at" bs=$at count=1 2>/dev/null
  cp "$one" "$work/damaged/changed-$at"
  printf '\377\001\200\177' |
    dd of="$work/damaged/changed-$at" bs=1 seek=$at conv=notrunc 2>/dev/null
  at=$((at * 3 / 2 + 1))
done
look_at "a damaged frame" "$work/damaged"/*

# patched NAME FIELD SKIP BYTES: the frame with some bytes of a header field.
patched() {
  at=$(grep -a -b -o "$2" "$one" | head -n 1 | cut -d : -f 1)
  cp "$one" "$work/$1"
  # shellcheck disable=SC2059
  printf "$4" | dd of="$work/$1" bs=1 seek=$((at + $3)) conv=notrunc 2>/dev/null
}
# xmin ymin xmax ymax follow the attribute's name, type and size
begin=21
patched wide.exr dataWindow $((begin + 8)) '\377\311\232\073\377\311\232\073'
rejected "1e9 x 1e9 pixels" 'wide.exr: damaged.*1000000000) too large' \
  "$HBIL" info "$work/wide.exr"
patched large.exr dataWindow $((begin + 8)) '\377\377\000\000\377\377\000\000'
rejected "65536 x 65536 pixels" 'large.exr: claims 65536 x 65536' \
  "$HBIL" info "$work/large.exr"
patched around.exr dataWindow $begin \
  '\000\000\000\200\000\000\000\200\377\377\377\177\377\377\377\177'
rejected "a window of 2^32 pixels a side" 'around.exr: damaged' \
  "$HBIL" info "$work/around.exr"
patched backwards.exr dataWindow $begin '\377\377\377\177'
rejected "a window that ends before it begins" 'backwards.exr: damaged' \
  "$HBIL" info "$work/backwards.exr"
# the window that would follow would be of 64 x 64 pixels, out of thin air
patched nowindow.exr box2i 0 'box9x'
rejected "a window of another type" 'nowindow.exr: damaged' \
  "$HBIL" info "$work/nowindow.exr"

# --- names ---

odd=$(printf 'a folder\nof \303\251\342\202\254 "it'\''s" $HOME')
mkdir "$work/$odd"
cp "$one" "$work/$odd/-frame
one.exr"
cp "$camera" "$work/$odd/-frame
one.json"
run "$HBIL" process --quality reference --slices 2 --warm-up 0 \
  -o "$work/$odd/lit
here" "$work/$odd/-frame
one.exr"
grep '^\[' "$work/err" >"$work/out"
test $status -eq 0 && test "$(wc -l <"$work/out")" -eq 1 &&
  grep -q -F 'folder\nof' "$work/out" && grep -q -F 'frame\none.exr' "$work/out"
ok $? "spaces, newlines, quotes and other scripts in paths"
has "and the result has that name" "$work/$odd/lit
here/-frame
one.exr"
rejected "a newline in the name of what is missing" 'gone\\nagain.exr: cannot' \
  "$HBIL" info "$work/$odd/gone
again.exr"
rejected "a name that turns the terminal" 'x1b\[2J.xc2.x9b.x7f:' \
  "$HBIL" info "$(printf '\033[2J\302\233\177')"
long=$work/$(printf '%02000d' 1)
rejected "a name that is too long" 'File name too long' "$HBIL" info "$long"

LC_ALL=C sed -e 's/albedo/a\n\x1b\xff.d/g' -e 's/motion/%s%n\\t/g' "$one" \
  >"$work/channels.exr"
cp "$camera" "$work/channels.json"
run "$HBIL" info "$work/channels.exr"
test $status -eq 0 && grep -q -F 'not used   %s%n\t' "$work/out" &&
  grep -q -F 'a\n\x1b' "$work/out"
ok $? "channels with odd names"
works "and they are left alone" exact -o "$work/channels" "$work/channels.exr"

# --- cameras ---

bad=$work/bad.json
# camera_rejected NAME PATTERN
camera_rejected() {
  rejected "$1" "bad.json: $2" exact -o "$out" --camera "$bad" "$one"
}
# camera_with NAME PATTERN FIELD VALUE: its number or its arrays replaced.
camera_with() {
  number='[-0-9.e+]*'
  flat='\[[^][]*\]'
  nested='\[\( *\[[^][]*\],*\)* *\]'
  tr -d '\n' <"$camera" |
    sed "s/\"$3\": *\($nested\|$flat\|$number\)/\"$3\": $4/" >"$bad"
  camera_rejected "$1" "$2"
}
dd if=/dev/zero of="$bad" bs=1 count=0 seek=100000000 2>/dev/null
camera_rejected "a camera of 100 MB" 'larger than 1024 KiB'
head -c 10000 /dev/zero | tr '\0' '[' >"$bad"
camera_rejected "a camera 10,000 deep" 'not JSON.*depth'
: >"$bad"
camera_rejected "an empty camera" 'not JSON'
printf '{"fx": 1, "fx": 2}' >"$bad"
camera_rejected "a field twice" 'not JSON.*field fx: duplicate'
camera_with "fx 1e999" 'not JSON.*field fx:.*overflow' fx 1e999
camera_with "fx 1e300" 'field fx is wrong' fx 1e300
camera_with "fx NaN" 'not JSON.*field fx:' fx NaN
camera_with "fy of 30 digits" 'not JSON.*field fy:' fy \
  123456789012345678901234567890
camera_with "fy negative" 'field fy is wrong' fy -1
camera_with "cx a word" 'field cx is wrong' cx '"20"'
camera_with "cy nothing" 'field cy is wrong' cy null
camera_with "cx far away" 'field cx is wrong' cx -1e10
row='[0,0,0,1]'
for matrix in NaN:'not JSON.*field camera_to_world:' \
  1e999:'not JSON.*field camera_to_world:' 0:'field camera_to_world is wrong' \
  2:'field camera_to_world is wrong' -1:'field camera_to_world is wrong' \
  '"1"':'field camera_to_world is wrong' '[]':'field camera_to_world is wrong'; do
  camera_with "a matrix with ${matrix%%:*}" "${matrix#*:}" camera_to_world \
    "[[1,0,0,0],[0,${matrix%%:*},0,0],[0,0,1,0],$row]"
done
camera_with "a matrix of zeros" 'field camera_to_world is wrong.*rigid' \
  camera_to_world "[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,0]]"
camera_with "a singular matrix" 'field camera_to_world is wrong.*rigid' \
  camera_to_world "[[1,0,0,0],[1,0,0,0],[0,0,1,0],$row]"
camera_with "a matrix of three rows" 'field camera_to_world is wrong' \
  camera_to_world "[[1,0,0,0],[0,1,0,0],$row]"
camera_with "a camera at the end of the world" 'field camera_to_world is wrong' \
  camera_to_world "[[1,0,0,1e30],[0,1,0,0],[0,0,1,0],$row]"
camera_with "a resolution below zero" 'field resolution is wrong' \
  resolution '[-40,30]'

# --- what is no file ---

# To open a FIFO waits for a writer.  timeout's exit status isn't 2.
mkfifo "$work/pipe" "$work/pipe.exr"
waits_for_none() { # NAME PATTERN COMMAND...
  name=$1 pattern=$2
  shift 2
  rejected "$name" "$pattern" timeout 30 "$@"
}
no_file='not a regular file'
plain="--quality reference --slices 2 --warm-up 0 -o $out"
waits_for_none "a FIFO: info" "pipe.exr: cannot be read: $no_file" \
  "$HBIL" info "$work/pipe.exr"
waits_for_none "a FIFO: compare" "pipe.exr: cannot be read: $no_file" \
  "$HBIL" compare "$one" "$work/pipe.exr"
# shellcheck disable=SC2086
for option in --camera --environment --decide-by; do
  waits_for_none "a FIFO: $option" "pipe: .*cannot be read: $no_file" \
    "$HBIL" process $plain $option "$work/pipe" "$one"
done
for option in --view --cache-load "--far rsm --light-view"; do
  waits_for_none "a FIFO: $option" "pipe: cannot be read: $no_file" \
    "$HBIL" process -o "$out" $option "$work/pipe" "$one"
done
# shellcheck disable=SC2086
waits_for_none "a FIFO: a frame" "pipe.exr: cannot be read: $no_file" \
  "$HBIL" process $plain "$work/pipe.exr"
mkdir "$work/beside"
cp "$one" "$work/beside"
mkfifo "$work/beside/frame_0001.json"
# shellcheck disable=SC2086
waits_for_none "a FIFO: a camera beside its frame" "cannot be read: $no_file" \
  "$HBIL" process $plain "$work/beside/frame_0001.exr"
# shellcheck disable=SC2086
waits_for_none "a device without an end" "zero: cannot be read: $no_file" \
  "$HBIL" process $plain --environment /dev/zero "$one"
mkdir "$work/resume"
mkfifo "$work/resume/frame_0001.exr" "$work/resume/.hbil-light.frame_0001"
works "a FIFO in a result's place is no result" timeout 60 "$HBIL" process --quiet \
  --quality reference --slices 2 --warm-up 0 --resume -o "$work/resume" "$one"
absent "what was rejected left nothing behind" "$out"

# --- numbers ---

for value in slices=99999999999999999999 slices=18446744073709551617 slices=-1 \
  slices=1e3 slices=nan slices= steps-per-side=0x10 repeat=1.5 \
  warm-up=99999999999999999999 radius=nan radius=1e400 radius=-1e400 radius= \
  radius=x thickness=1,2 relative-thickness=nan step-growth=1e39 \
  disocclusion-threshold=nan facing-fade= \
  facing-fade=nan,nan facing-fade=1e400,0 facing-fade=0.1 facing-fade=0,0,0; do
  rejected "--$value" "^hbil: --${value%%=*} " process -o "$out" "--$value" "$one"
done
rejected "an empty word" '^hbil: --mode ' process -o "$out" --mode '' "$one"
rejected "an empty list" '^hbil: --layers ' process -o "$out" --layers '' "$one"
rejected "an empty output folder" 'output folder' process -o '' "$one"
rejected "an empty name" '^hbil: : cannot be read' exact -o "$out" ''
rejected "an empty device" 'no such device' \
  process -o "$out" --device '' "$one"
rejected "device 1e20" 'no such device' \
  process -o "$out" --device 100000000000000000000 "$one"

# --- environments ---

map=$work/map
# map_rejected NAME PATTERN
map_rejected() {
  rejected "$1" "$2" exact -o "$out" --environment "$map" "$one"
}
rejected "an environment of NaN" 'cannot be read' \
  exact -o "$out" --environment nan,0,0 "$one"
rejected "an infinite environment" 'not finite' \
  exact -o "$out" --environment inf,0,0 "$one"
rejected "two numbers as environment" 'environment 1,2: cannot be read: neither three numbers' \
  exact -o "$out" --environment 1,2 "$one"
rejected "an empty environment" 'cannot be read' \
  exact -o "$out" --environment '' "$one"
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000000 +X 1000000000\n' \
  >"$map"
map_rejected "a map of 1e9 x 1e9 pixels" 'map: 1000000000 x 1000000000'
printf 'P6 16384 16384 255\n' >"$map"
map_rejected "a map of 2^28 pixels" 'map: 16384 x 16384'
# libpng would say something of its own
printf '\211PNG\r\n\032\n\0\0\0\rIHDR\073\232\312\0\073\232\312\0\010\2\0\0\0\300\100\250\1' \
  >"$map"
map_rejected "a PNG of 1e9 x 1e9 pixels" 'map: cannot be read'
printf 'PF\n2 1\n-1.0\n\0\0\300\177\0\0\200\177\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0' \
  >"$map"
works "a map with NaN has no light there" \
  exact -o "$work/map-lit" --environment "$map" "$one"
cp "$work/wide.exr" "$map"
map_rejected "an EXR map of 1e9 x 1e9 pixels" 'map: damaged'
if test -d "$HBIL_DATA/real_exr"; then
  # three halves of four, of which OpenEXR's quick routines wrote the fourth
  works "a map of some channels" exact -o "$work/map-lit" --overwrite --environment \
    "$HBIL_DATA/real_exr/oexr_beachball_multipart.0001.exr" "$one"
else
  skip "a map of some channels" "no $HBIL_DATA/real_exr"
fi
absent "what was rejected left nothing" "$out"

# --- broken off ---

# Whole frames, the sequence without interruption.  A radiance cache looks at
# all frames first, so with one, a frame that can't be read ends the job before
# its first result.
works "a sequence" process -o "$work/whole" "$frames"/*.exr
works "a sequence by the camera" process --far environment -o "$work/camera" "$frames"/*.exr
works "a sequence by motion, with previews" exact --reprojection motion \
  --preview -o "$work/motion" "$frames"/*.exr
absent "after the last frame there is no carried light" \
  "$work/camera/.hbil-light.frame_0001"

# kill -9 as soon as the second result is there.
killed() { # COMMAND...
  "$@" -o "$work/killed" "$frames"/*.exr >"$work/out" 2>"$work/err" &
  job=$!
  while test ! -e "$work/killed/frame_0002.exr" && kill -0 $job 2>/dev/null; do
    :
  done
  # the shell that runs the function, and the program itself
  kill -9 $job 2>/dev/null
  wait $job 2>/dev/null
}
rm -rf "$work/killed"
killed "$HBIL" process --quiet
cp "$work/camera/frame_0001.exr" "$work/killed/$left_here"
run "$HBIL" process --resume -o "$work/killed" "$frames"/*.exr
test $status -eq 0 &&
  test "$(grep -c 'frame_000[12].exr is there already$' "$work/err")" -eq 2
ok $? "after kill -9: what is there is left alone"
same "and the rest is as without it" "$work/whole" "$work/killed"

# A frame that can't be read in the middle, then another in its place: the light
# of the frame before it is given back, that of a first frame, whose last runs
# were static, and that of another one.
for at in 2 3; do
  cp -r "$frames" "$work/broken$at"
  head -c 3000 "$frames/frame_000$at.exr" >"$work/broken$at/frame_000$at.exr"
done
rejected "with a radiance cache: told before the first result" \
  'frame_0003.exr: truncated' process -o "$work/early" "$work/broken3"/*.exr
absent "with a radiance cache: nothing is left" "$work/early"
for way in camera motion; do
  again() {
    if test $way = camera; then
      process --far environment -o "$work/resumed" "$@"
    else
      exact --reprojection motion --preview -o "$work/resumed" "$@"
    fi
  }
  for at in 2 3; do
    rm -rf "$work/resumed"
    rejected "$way: broken off at $at" "frame_000$at.exr: truncated" \
      again "$work/broken$at"/*.exr
    has "$way: the carried light is stored" "$work/resumed/.hbil-light.frame_0001"
    works "$way: resumed" again --resume "$frames"/*.exr
    same "$way: as without interruption" "$work/$way" "$work/resumed"
  done
done
# What the slices of the last frames found is carried as well.
shared() {
  process --far environment --slice-frames 4 "$@"
}
for mode in hbil gtao; do
  rm -rf "$work/resumed"
  works "$mode: shared slices" shared --mode $mode -o "$work/$mode" \
    "$frames"/*.exr
  rejected "$mode: broken off" 'frame_0003.exr: truncated' \
    shared --mode $mode -o "$work/resumed" "$work/broken3"/*.exr
  works "$mode: resumed" \
    shared --mode $mode --resume -o "$work/resumed" "$frames"/*.exr
  same "$mode: as without interruption" "$work/$mode" "$work/resumed"
done
run cmp "$work/hbil/frame_0004.exr" "$work/camera/frame_0004.exr"
test $status -ne 0
ok $? "frames that share slices differ"
rm -rf "$work/resumed"
exact --reprojection motion --preview -o "$work/resumed" "$frames"/*.exr
run "$HBIL" process --quality reference --slices 2 --warm-up 0 --preview \
  --reprojection motion --resume -o "$work/resumed" "$frames"/*.exr
test $status -eq 0 && test "$(grep -c 'is there already$' "$work/err")" -eq 4 &&
  ! grep -q 'exact integral' "$work/err"
ok $? "nothing is lit where nothing is missing"
rm "$work/resumed/frame_0002.ao.png" "$work/resumed/frame_0003.exr"
works "a hole, without carried light" exact --reprojection motion --preview \
  --resume -o "$work/resumed" "$frames"/*.exr
same "is filled alike" "$work/motion" "$work/resumed"
size=$(wc -c <"$work/motion/frame_0002.exr")
head -c $((size / 2)) "$work/motion/frame_0002.exr" \
  >"$work/resumed/frame_0002.exr"
works "half a result" exact --reprojection motion --preview --resume \
  -o "$work/resumed" "$frames"/*.exr
same "is none" "$work/motion" "$work/resumed"
run "$HBIL" process --quality reference --slices 3 --warm-up 0 --preview \
  --reprojection motion --resume -o "$work/resumed" "$frames"/*.exr
test $status -eq 0 && ! grep -q 'is there already$' "$work/err"
ok $? "results of other settings are none"
exact -o "$work/resumed" --overwrite "$one"
# the same but for one bit of the camera
mkdir "$work/moved"
cp "$one" "$work/moved"
sed 's/"cx": *20\(\.0\)\{0,1\}/"cx": 20.000000001/' "$camera" \
  >"$work/moved/frame_0001.json"
run "$HBIL" process --quality reference --slices 2 --warm-up 0 --resume \
  -o "$work/resumed" "$work/moved/frame_0001.exr"
test $status -eq 0 && ! grep -q 'is there already$' "$work/err" &&
  ! cmp -s "$camera" "$work/moved/frame_0001.json"
ok $? "nor are those of another camera"
rejected "--resume measures nothing" 'resume: not with --timings' \
  process --resume --timings -o "$out" "$one"

# --- no room ---

# Every file ends at 16 KiB: a result has 80.
(
  ulimit -f 32 # POSIX: blocks of 512 bytes; some shells take 1024
  exact -o "$work/limited" "$one"
) >"$work/out" 2>"$work/err"
status=$?
test $status -eq 2 && test "$(wc -l <"$work/err")" -eq 1 &&
  grep -q 'limited/frame_0001.exr: cannot be written: File too large' \
    "$work/err" && test ! -e "$work/limited"
ok $? "a file that can't be as large"
mkdir "$work/disk"
mounted() {
  unshare -rm sh -c 'mount -t tmpfs -o size=100k none "$0" && "$@"' \
    "$work/disk" "$@" 2>/dev/null
}
if mounted true; then
  cat >"$work/full" <<END
"$HBIL" process --quiet --quality reference --slices 2 --warm-up 0 \
  -o "$work/disk" "$frames"/*.exr 2>"$work/err"
echo \$? >"$work/status"
ls -A "$work/disk" >"$work/out"
END
  mounted sh "$work/full"
  test "$(cat "$work/status")" -eq 2 && test "$(wc -l <"$work/err")" -eq 1 &&
    grep -q 'cannot be written: No space left' "$work/err" &&
    ! grep -q '[.]tmp$' "$work/out"
  ok $? "a full disk: one line, and whole files only"
else
  skip "a full disk: one line, and whole files only" "no right to mount one"
fi
if test -w /dev/full; then
  "$HBIL" info "$one" >/dev/full 2>"$work/err"
  status=$?
  test $status -eq 2 && test "$(wc -l <"$work/err")" -eq 1
  ok $? "what can't be said is an error"
else
  skip "what can't be said is an error" "no /dev/full"
fi

echo "1..$count"
