#!/bin/sh
# Your files (doc/guide.md): commands lose no file that they
# read, replace nothing but what is theirs, and believe no damaged file.
#
# Speaks TAP.
srcdir=${srcdir:-$(dirname "$0")/../..}
. "$srcdir/test/support/tap.sh"

process() {
  "$HBIL" process --quiet "$@"
}
# The exact integral of few slices: no device, so no kernels to be compiled.
exact() {
  process --quality reference --slices 1 --warm-up 0 "$@"
}
# spares NAME FILE PATTERN COMMAND...: the command is rejected with the pattern,
# and the file has the same bytes as before.
spares() {
  name=$1 file=$2 pattern=$3
  shift 3
  cp "$file" "$work/original"
  rejected "$name" "$pattern" "$@"
  run cmp "$work/original" "$file"
  ok $status "$name: the file stays as it is"
}

works "a demo" "$HBIL" demo --frames 2 --size 32x18 -o "$work/demo"
in=$work/in out=$work/out.d
cp -r "$work/demo/gbuffer" "$in"
one=$in/frame_0001.exr
two=$in/frame_0002.exr

# --- files that a job reads ---

overwritten='would overwrite'
spares "--cache-save, whose name was forgotten before a pattern" "$one" \
  'frame_0001.exr: is not a radiance cache, and --cache-save replaces nothing else' \
  process --overwrite -o "$out" --cache-save "$one" "$two"
spares "--contact-sheet, whose name was forgotten" "$one" \
  'frame_0001.exr: is not a picture that hbil wrote' \
  process --overwrite -o "$out" --contact-sheet "$one" "$two"
spares "a cache in place of the frame" "$one" "$overwritten the frame" \
  process --overwrite -o "$out" --cache-save "$one" "$one"
spares "the same with --resume" "$one" "$overwritten the frame" \
  process --resume -o "$out" --cache-save "$one" "$one"
spares "a contact sheet in place of a camera" "$in/frame_0001.json" \
  "$overwritten the camera file" \
  process --overwrite -o "$out" --contact-sheet "$in/frame_0001.json" "$one"
spares "or of the camera of all frames" "$in/frame_0002.json" \
  "$overwritten the camera file" process --overwrite -o "$out" \
  --camera "$in/frame_0002.json" --contact-sheet "$in/frame_0002.json" "$one"
spares "or of a view's camera" "$in/frame_0002.json" "$overwritten the camera file" \
  process --overwrite -o "$out" --view "$two" --contact-sheet "$in/frame_0002.json" "$one"
spares "a cache in place of a view" "$two" "$overwritten the view" \
  process --overwrite -o "$out" --view "$two" --cache-save "$two" "$one"
spares "or of a view from a light" "$two" "$overwritten the light view" process \
  --overwrite -o "$out" --far rsm --light-view "$two" --cache-save "$two" "$one"
spares "a contact sheet in place of a pass" "$two" "$overwritten the pass" \
  process --overwrite -o "$out" --map albedo=frame_0002.exr:albedo \
  --contact-sheet "$two" "$one"
mkdir "$work/results"
cp "$one" "$work/results"
cp "$in/frame_0001.json" "$work/results"
map=$work/results/frame_0001.exr
spares "a result in place of the environment map" "$map" "$overwritten the environment map" \
  exact --overwrite -o "$work/results" --environment "$map" "$one"
spares "or of the frame that decides" "$map" "$overwritten the frame of --decide-by" \
  exact --overwrite -o "$work/results" --decide-by "$map" "$one"
spares "or of the frame itself, which --overwrite doesn't help" "$one" \
  "$overwritten the frame" exact -o "$in" "$one"
printf 'hbilcac1' >"$work/cache"
spares "a contact sheet in place of a cache" "$work/cache" 'no radiance cache' \
  process --overwrite -o "$out" --cache-load "$work/cache" \
  --contact-sheet "$work/cache" "$one"

# --- other names of the same file ---

ln -s "$one" "$work/link"
ln "$one" "$work/hard"
ln -s "$in" "$work/linked"
for name in "$work/link" "$work/hard" "$work/linked/frame_0001.exr" \
  "$work/demo/../in/./frame_0001.exr"; do
  spares "a cache named ${name#"$work"}" "$one" "$overwritten the frame" \
    process --overwrite -o "$out" --cache-save "$name" "$one"
done
spares "a frame by another name" "$one" "$overwritten the frame" \
  process --overwrite -o "$out" --cache-save "$one" "$work/linked/frame_0001.exr"
spares "an output folder that is spelled through one that is made" "$one" \
  "$overwritten the frame" exact --overwrite -o "$work/new/../in" "$one"
rm "$work/link" "$work/hard"

# --- what a job writes, twice ---

rejected "a cache in place of a result that isn't there yet" \
  "--cache-save $overwritten the result of .*/frame_0001.exr;" process \
  --overwrite -o "$out" --cache-save "$out/./frame_0001.exr" "$one"
rejected "the same in a dry run, without the folder" \
  "--cache-save $overwritten the result of .*/frame_0001.exr;" process --dry-run \
  -o "$out/deeper" --cache-save "$out/x/../deeper/frame_0001.exr" "$one"
rejected "a contact sheet in place of a preview" "$overwritten a preview of" exact \
  --preview -o "$out" --contact-sheet "$out/frame_0001.ao.png" "$one"
rejected "or of the light that is carried on" "$overwritten the light to carry on" \
  exact -o "$out" --contact-sheet "$out/.hbil-light.frame_0001" "$one"
ln -s "$work/later" "$work/link"
rejected "a cache and a contact sheet of one name, through a link" \
  "--cache-save $overwritten --contact-sheet; another name is needed" process \
  -o "$out" --contact-sheet "$work/later" --cache-save "$work/link" "$one"
absent "what was rejected left nothing" "$out"

# --- what else is there ---

echo "my own" >"$work/text"
for option in --contact-sheet --cache-save; do
  for how in --overwrite --resume; do
    spares "$option $how in place of a text" "$work/text" "$option replaces nothing else" \
      process $how -o "$out" $option "$work/text" "$one"
  done
done
LC_ALL=C sed 's/Software/Zoftware/' "$work/demo/frame_0001.ao.png" >"$work/other.png"
spares "a contact sheet in place of another program's picture" "$work/other.png" \
  'is not a picture that hbil wrote' \
  exact --overwrite -o "$out" --contact-sheet "$work/other.png" "$one"
: >"$work/sheet.png"
works "a contact sheet in place of an empty file" exact --overwrite -o "$out" \
  --contact-sheet "$work/sheet.png" "$one"
works "and of an older one" exact --overwrite -o "$out" \
  --contact-sheet "$work/sheet.png" "$one"
rm -r "$out"
mkdir "$out"
echo "my own" >"$out/frame_0001.ao.png"
spares "a preview that isn't the job's" "$out/frame_0001.ao.png" 'is there already' \
  exact --preview --layers ao -o "$out" "$one"

# --- what --resume replaces ---

rm -r "$out"
mkdir "$out"
result=$out/frame_0001.exr
not_own='frame_0001.exr: is not a result of hbil, .*--overwrite, which would replace'
echo "my own" >"$result"
spares "--resume in place of a text" "$result" "$not_own" exact --resume -o "$out" "$one"
cp "$one" "$result"
spares "or of a G-buffer of a demo" "$result" "$not_own" exact --resume -o "$out" "$one"
LC_ALL=C sed 's/hbilKey/hbilKez/' "$one" >"$result"
spares "or of an EXR without a key" "$result" "$not_own" exact --resume -o "$out" "$one"
works "--overwrite replaces it" exact --overwrite -o "$out" "$one"
rm "$result"
cp "$work/other.png" "$out/frame_0001.ao.png"
spares "or of another program's picture" "$out/frame_0001.ao.png" \
  'frame_0001.ao.png: is not a picture that hbil wrote' \
  exact --preview --layers ao --resume -o "$out" "$one"
rm "$out/frame_0001.ao.png"
: >"$result"
works "an empty file has nothing to lose" exact --resume -o "$out" "$one"
has "and becomes the result" "$result"

# --- what --resume believes ---

# again OPTIONS...: resumes, and says what is there and what is damaged.
again() {
  run "$HBIL" process --quality reference --slices 1 --warm-up 0 --resume "$@"
}
# heals NAME LINE FOLDER FOLDER OPTIONS...: the second folder becomes like the
# first one, and one line says what was damaged.
heals() {
  name=$1 line=$2 whole=$3 folder=$4
  shift 4
  again -o "$folder" "$@" "$one" "$two"
  test $status -eq 0 && test "$(grep -c "$line" "$work/err")" -eq 1 &&
    test "$(grep -c 'is damaged' "$work/err")" -eq 1 &&
    diff -r "$whole" "$folder" >>"$work/err"
  ok $? "$name"
}
# change FILE PLACE: eight bytes become others.
change() {
  dd if="$1" of="$work/bytes" bs=1 skip="$2" count=8 2>/dev/null
  LC_ALL=C tr '\000-\377' '\001-\377\000' <"$work/bytes" |
    dd of="$1" bs=1 seek="$2" conv=notrunc 2>/dev/null
}
works "two frames" exact --preview -o "$work/whole" "$one" "$two"
mkdir "$work/cut"
head -c 3000 "$two" >"$work/cut/frame_0002.exr"
cp "$in/frame_0002.json" "$work/cut"
rejected "a job that breaks off" 'frame_0002.exr: truncated' \
  exact --preview -o "$work/stopped" "$one" "$work/cut/frame_0002.exr"
light=.hbil-light.frame_0001
size=$(wc -c <"$work/stopped/$light")
for damage in none zeros nan byte short long key version; do
  rm -rf "$work/resumed"
  cp -r "$work/stopped" "$work/resumed"
  file=$work/resumed/$light
  case $damage in
  zeros) dd if=/dev/zero of="$file" bs=1 seek=400 count=800 conv=notrunc ;;
  nan)
    { head -c 40 "$work/stopped/$light" &&
      tail -c +41 "$work/stopped/$light" | LC_ALL=C tr '\000-\377' '[\377*]'; } >"$file"
    ;;
  byte) change "$file" $((size / 2)) ;;
  short) head -c $((size - 1)) "$work/stopped/$light" >"$file" ;;
  long) echo >>"$file" ;;
  key) change "$file" 8 ;;
  version) printf 1 | dd of="$file" bs=1 seek=7 conv=notrunc ;;
  esac 2>/dev/null
  if test $damage = none; then
    again --preview -o "$work/resumed" "$one" "$two"
    test $status -eq 0 && ! grep -q damaged "$work/err" &&
      diff -r "$work/whole" "$work/resumed" >>"$work/err"
    ok $? "the light to carry on is used where it is whole"
  else
    heals "and not where it is damaged: $damage" "$light: is damaged or of another version" \
      "$work/whole" "$work/resumed" --preview
  fi
done

damaged='frame_0001.exr: is damaged or has no checksum'
for compression in none zip pxr24 b44 dwaa; do
  exact --precision half --compression $compression -o "$work/$compression" "$one" "$two" \
    >"$work/out" 2>"$work/err"
  rm -rf "$work/resumed"
  cp -r "$work/$compression" "$work/resumed"
  again --precision half --compression $compression -o "$work/resumed" "$one" "$two"
  test $status -eq 0 && test "$(grep -c 'is there already$' "$work/err")" -eq 2 &&
    ! grep -q damaged "$work/err"
  ok $? "$compression: whole results stay"
  file=$work/resumed/frame_0001.exr
  change "$file" $(($(wc -c <"$file") - 100))
  heals "$compression: eight bytes of a result" "$damaged; it is computed again" \
    "$work/$compression" "$work/resumed" --precision half --compression $compression
done
rm -rf "$work/resumed"
cp -r "$work/whole" "$work/resumed"
LC_ALL=C sed 's/hbilChecksum/hbilChecksun/' "$work/whole/frame_0001.exr" \
  >"$work/resumed/frame_0001.exr"
change "$work/resumed/frame_0002.exr" 3000
heals "a result without a checksum, and another one" "$damaged, like 1 other; it is" \
  "$work/whole" "$work/resumed" --preview
file=$work/resumed/frame_0002.ao.png
head -c $(($(wc -c <"$work/whole/frame_0002.ao.png") - 50)) \
  "$work/whole/frame_0002.ao.png" >"$file"
heals "a preview that is cut off" 'frame_0002.ao.png: is damaged' "$work/whole" \
  "$work/resumed" --preview
rm -rf "$work/resumed"
cp -r "$work/whole" "$work/resumed"
again --slices 2 --preview -o "$work/resumed" "$one" "$two"
others='^hbil: .*/frame_0001.exr: was made with other options .*, like 1 other; it is computed again'
test $status -eq 0 && test "$(grep -c "$others" "$work/err")" -eq 1 &&
  test "$(grep -c 'is computed again' "$work/err")" -eq 1 &&
  ! cmp -s "$work/whole/frame_0001.exr" "$work/resumed/frame_0001.exr"
ok $? "results of other options are replaced, which one line says"
rm "$work/resumed/frame_0002.exr"
again --quiet --preview -o "$work/resumed" "$one" "$two"
test $status -eq 0 && test ! -s "$work/err" &&
  diff -r "$work/whole" "$work/resumed" >>"$work/err"
ok $? "and --quiet doesn't"
again --preview -o "$work/whole" "$one" "$two"
test $status -eq 0 && ! grep -q 'computed again' "$work/err"
ok $? "nor is it said of results that stay"

# --- other commands ---

a=$work/demo/frame_0001.ao.png b=$work/demo/frame_0002.ao.png
spares "a heat map in place of an image" "$a" "--heatmap $overwritten the image" \
  "$HBIL" compare --heatmap "$a" "$a" "$b"
spares "or of the mask" "$one" "$overwritten the mask" "$HBIL" compare \
  --heatmap "$one" --mask-depth "$one" "$a" "$b"
spares "or of any other file" "$work/text" '--heatmap replaces nothing else' \
  "$HBIL" compare --heatmap "$work/text" "$a" "$b"
demo() {
  "$HBIL" demo --frames 2 --size 32x18 -o "$@"
}
works "a demo again, in place of the first one" demo "$work/demo"
rm -r "$out"
exact -o "$out" "$one" >"$work/out" 2>"$work/err"
spares "a demo in a folder of results" "$out/frame_0001.exr" 'no earlier demo wrote it' \
  demo "$out"
mkdir "$out/gbuffer"
exact --copy-channels -o "$out/gbuffer" "$two" >"$work/out" 2>"$work/err"
rm "$out/frame_0001.exr"
spares "or of G-buffers" "$out/gbuffer/frame_0002.exr" 'no earlier demo wrote it' \
  demo "$out"
rm "$out/gbuffer/frame_0002.exr"
cp "$in/frame_0001.json" "$out/gbuffer"
spares "or of cameras" "$out/gbuffer/frame_0001.json" 'no earlier demo wrote it' \
  demo "$out"
rm -r "$out"

echo "1..$count"
