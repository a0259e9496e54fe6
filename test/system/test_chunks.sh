#!/bin/sh
# A sequence in chunks, as farms split it: with a pre-roll from its beginning a
# chunk has the bits of the whole job, decisions and a cache can be shared, chunks
# write into one folder and are resumed there, and the guide's recipes run.
. "$srcdir/test/support/tap.sh"
. "$srcdir/test/support/slurm.sh"

fast='--slices 1 --steps-per-side 6 --warm-up 1'
process() {
  # shellcheck disable=SC2086
  "$HBIL" process $fast "$@"
}
quiet() {
  process --quiet "$@"
}
# same NAME FILE FILE
same() {
  run cmp "$2" "$3"
  ok $status "$1"
}
# holds NAME FOLDER FILES...: these and no others, hidden ones included.
holds() {
  name=$1 folder=$2
  shift 2
  ls -A "$folder" >"$work/out" 2>"$work/err"
  printf '%s\n' "$@" | sort | diff - "$work/out" >>"$work/err"
  ok $? "$name"
}

works "a demo" "$HBIL" demo --frames 6 --size 48x32 -o "$work/demo"
frames=$work/demo/gbuffer
all=$frames/frame_####.exr

# --- the pre-roll ---

works "a whole sequence" quiet --far environment -o "$work/whole" "$all"
works "a chunk" quiet --far environment --frames 4-6 -o "$work/alone" "$all"
differs "begins with other light" "$HBIL" compare --max-rmse 1e-4 \
  "$work/alone/frame_0004.exr:indirect" "$work/whole/frame_0004.exr:indirect"
works "a chunk with frames before it" \
  quiet --far environment --frames 4-6 --pre-roll 99 -o "$work/chunk" "$all"
holds "writes none of those" "$work/chunk" frame_0004.exr frame_0005.exr frame_0006.exr
for n in 4 5 6; do
  same "frame $n has the bits of the whole job's" \
    "$work/chunk/frame_000$n.exr" "$work/whole/frame_000$n.exr"
done
run process --far environment --frames 5-6 --pre-roll 2 -o "$work/short" "$all"
test $status -eq 0 && test "$(grep -c '^\[pre-roll [12]/2\] .*frame_000[34].exr$' "$work/err")" -eq 2 &&
  test "$(grep -c '^\[[12]/2\] .*short/frame_000[56].exr$' "$work/err")" -eq 2
ok $? "only as many as asked for, which are told"
LC_ALL=C grep -q "$(printf '[\033\r]')" "$work/err"
test $? -eq 1
ok $? "without codes for a terminal"
differs "are nearer to it than none, if not the same" "$HBIL" compare --max-rmse 0 \
  "$work/short/frame_0005.exr:indirect" "$work/whole/frame_0005.exr:indirect"
run process --far environment --dry-run --frames 2-6x2 --pre-roll 3 -o "$work/none" "$all"
test $status -eq 0 && ! grep -q 'pre-roll' "$work/out"
ok $? "every second frame has every second one before it: here none"
says "and here one" 'frame_0002.exr .*(pre-roll, not written)' \
  process --far environment --dry-run --frames 4-6x2 --pre-roll 3 -o "$work/none" "$all"
grep -q '^2 of 2 frames would be written' "$work/out" &&
  test "$(grep -c 'pre-roll' "$work/out")" -eq 1
ok $? "which isn't counted"
works "the beginning of the sequence has none" \
  quiet --far environment --frames 1-3 --pre-roll 5 -o "$work/chunk" "$all"
same "and is that of the whole job" "$work/chunk/frame_0003.exr" "$work/whole/frame_0003.exr"
rejected "--pre-roll without --frames" 'pre-roll: --frames .* is needed' \
  quiet --pre-roll 2 -o "$work/none" "$all"
works "previews and a contact sheet" quiet --far environment --layers ao --frames 5-6 --pre-roll 2 \
  --preview --contact-sheet "$work/sheet.png" -o "$work/pictures" "$all"
holds "are of the chunk alone" "$work/pictures" frame_0005.ao.png frame_0005.exr \
  frame_0006.ao.png frame_0006.exr

# --- decisions ---

# Without its lamps' emission a frame decides otherwise.
mkdir "$work/other"
cp "$frames"/* "$work/other"
LC_ALL=C sed 's/emission\./emissiom./g' "$frames/frame_0001.exr" >"$work/dark.exr"
cp "$frames/frame_0001.json" "$work/dark.json"
decided() {
  sed -n 's/^hbil: \(light of\|emission\)/\1/p' "$work/err"
}
run process --far environment --frames 4-6 -o "$work/d1" "$all"
decided >"$work/own"
run process --far environment --frames 4-6 --decide-by "$frames/frame_0001.exr" -o "$work/d2" "$all"
test $status -eq 0 && decided >"$work/first" && test -s "$work/first"
ok $? "--decide-by a frame"
run process --far environment --frames 4-6 --decide-by "$work/dark.exr" -o "$work/d3" "$all"
decided >"$work/without"
test $status -eq 0 && grep -q '^emission' "$work/first" && ! grep -q '^emission' "$work/without"
ok $? "which alone decides"
works "a chunk of which the first frame decides" quiet --far environment --frames 1 -o "$work/d4" "$all"
works "the same, decided by it" quiet --far environment --frames 1 \
  --decide-by "$frames/frame_0001.exr" -o "$work/d5" "$all"
same "is the same" "$work/d4/frame_0001.exr" "$work/d5/frame_0001.exr"
run process --dry-run --frames 6 -o "$work/none" "$all"
test $status -eq 0 && ! grep -q 'radiance cache' "$work/err"
ok $? "a chunk of one frame has no cache"
run process --dry-run --frames 6 --decide-by "$frames/frame_0001.exr" -o "$work/none" "$all"
test $status -eq 0 && grep -q '^hbil: radiance cache: ' "$work/err"
ok $? "unless the camera of the frame that decides is elsewhere"
rejected "a frame that isn't there" 'gone.exr: cannot be read' \
  quiet --decide-by "$work/gone.exr" -o "$work/none" "$all"
absent "leaves nothing" "$work/none"

# --- chunks in one folder ---

one=$work/folder
works "a first chunk" quiet --far environment --frames 1-3 -o "$one" "$all"
: >"$one/.hbil-light.frame_0004"
: >"$one/$left_here"
: >"$one/$left_elsewhere"
works "a chunk that is resumed beside another" \
  quiet --far environment --resume --frames 1-3 -o "$one" "$all"
holds "leaves what may be the other one's, and removes what is nobody's" "$one" \
  "$left_elsewhere" .hbil-light.frame_0004 frame_0001.exr frame_0002.exr frame_0003.exr
rm "$one/.hbil-light.frame_0004" "$one/$left_elsewhere"
works "a second chunk, whose pre-roll is there" \
  quiet --far environment --frames 4-6 --pre-roll 3 -o "$one" "$all"
run diff -r "$work/whole" "$one"
ok $status "together they are the whole sequence"
rm "$one/frame_0005.exr"
run process --far environment --resume --frames 4-6 --pre-roll 3 -o "$one" "$all"
test $status -eq 0 && test "$(grep -c 'is there already$' "$work/err")" -eq 2
ok $? "a result that is gone"
run diff -r "$work/whole" "$one"
ok $status "comes back with the same bits"
# broken off at the second frame of the chunk, and continued with the light there
rm -rf "$one"
mkdir -p "$one/frame_0005.exr"
rejected "a chunk that is broken off says so in a line" 'frame_0005.exr: cannot be written' \
  quiet --far environment --overwrite --frames 4-6 --pre-roll 3 -o "$one" "$all"
rmdir "$one/frame_0005.exr"
holds "it has left its light" "$one" .hbil-light.frame_0004 frame_0004.exr
works "resumed" quiet --far environment --resume --frames 4-6 --pre-roll 3 -o "$one" "$all"
for n in 4 5 6; do
  same "frame $n is as if nothing had happened" \
    "$one/frame_000$n.exr" "$work/whole/frame_000$n.exr"
done
holds "and its light is gone" "$one" frame_0004.exr frame_0005.exr frame_0006.exr

# --- a cache for all ---

works "a cache of all frames" quiet --cache-size 16 --view "$all" \
  --cache-save "$work/shot.cache" --frames 1 -o "$work/learn" "$all"
for chunk in 1-3 4-6; do
  run process --cache-load "$work/shot.cache" --frames $chunk --pre-roll 3 \
    -o "$work/cached" "$all"
  test $status -eq 0 && grep -q 'radiance cache: 16 x 16 x 16 voxels' "$work/err"
  ok $? "chunk $chunk has it"
done
works "the whole sequence with it" quiet --cache-load "$work/shot.cache" \
  -o "$work/cached-whole" "$all"
same "the second chunk has the same light" \
  "$work/cached/frame_0006.exr" "$work/cached-whole/frame_0006.exr"

for chunk in 1-3 4-6; do
  works "chunk $chunk with the cache as it is" quiet --cache-load "$work/shot.cache" \
    --cache-fixed --reprojection none --frames $chunk -o "$work/fixed" "$all"
done
works "a single frame" quiet --cache-load "$work/shot.cache" --cache-fixed \
  --reprojection none --frames 6 --decide-by "$frames/frame_0004.exr" -o "$work/fixed-6" "$all"
works "has the same light, whatever came before" "$HBIL" compare --max-rmse 0 \
  "$work/fixed/frame_0006.exr" "$work/fixed-6/frame_0006.exr"
works "where the cache sees frames" quiet --cache-load "$work/shot.cache" \
  --reprojection none --frames 4-6 -o "$work/seen" "$all"
differs "it is another" "$HBIL" compare --max-rmse 1e-6 \
  "$work/fixed/frame_0006.exr:indirect" "$work/seen/frame_0006.exr:indirect"

# --- the guide's recipes ---

# block TITLE: the code behind the line of the guide that has the title.
block() {
  awk -v title="$1" 'index($0, title) { found = 1; next }
    found && /^```/ { if (++fence == 2) exit; next }
    found && fence == 1' "$srcdir/doc/guide.md"
}
mkdir "$work/farm" "$work/bin"
cp "$frames"/* "$work/farm"
cd "$work/farm" || exit 99
# the guide's shot has a hundred frames in chunks of 25, this one has six
printf '#!/bin/sh\nexec "%s" "$@"\n' "$HBIL" >"$work/bin/hbil"
printf '#!/bin/sh\nexec "$@"\n' >"$work/bin/srun"
chmod +x "$work/bin"/*
PATH=$work/bin:$PATH
six() {
  sed "s/shot\./frame_/g; s/seq 1 25 100/seq 1 3 6/; s/\* 25 + 1/* 3 + 1/
    s/+ 24/+ 2/g; s/--pre-roll 8/--pre-roll 3 --far environment --quiet $fast/"
}
block '**GNU parallel**' | six >"$work/parallel.sh"
grep -q '^seq 1 3 6 | parallel' "$work/parallel.sh" && grep -q -e '--pre-roll 3' "$work/parallel.sh"
ok $? "the guide has a recipe for GNU parallel"
if command -v parallel >/dev/null; then
  PARALLEL_HOME=$work/home
  export PARALLEL_HOME
  mkdir "$PARALLEL_HOME"
  : >"$PARALLEL_HOME/will-cite"
  works "GNU parallel lights the sequence" sh "$work/parallel.sh"
  run diff -r "$work/whole" lit
  ok $status "as one job would"
  rm -rf lit
  head -c 1000 "$frames/frame_0005.exr" >frame_0005.exr
  run sh "$work/parallel.sh"
  test $status -ne 0 && test "$(grep -c '^hbil: ' "$work/err")" -eq 1 &&
    test ! -e lit/frame_0005.exr && cmp -s lit/frame_0003.exr "$work/whole/frame_0003.exr"
  ok $? "a chunk that fails makes it fail, with one line"
  cp "$frames/frame_0005.exr" .
  works "run again, it does what is missing" sh "$work/parallel.sh"
  run diff -r "$work/whole" lit
  ok $status "and all is there"
  rm -rf lit
else
  for name in "GNU parallel lights the sequence" "as one job would" \
    "a chunk that fails makes it fail, with one line" \
    "run again, it does what is missing" "and all is there"; do
    skip "$name" "no parallel"
  done
fi
block '**A Slurm job array**' | six >"$work/array.sh"
for task in 0 1; do
  works "task $task of the Slurm job array" env SLURM_ARRAY_TASK_ID=$task sh "$work/array.sh"
done
run diff -r "$work/whole" lit
ok $status "which together are the sequence"

# And by a Slurm, with its own srun.
rm "$work/bin/srun"
rm -rf lit
if without=$(slurm_missing); then
  skip "Slurm lights the sequence" "$without"
  skip "as one job would" "$without"
elif ! slurm_start "$work/slurm" >"$work/out" 2>"$work/err"; then
  slurm_stop "$work/slurm"
  skip "Slurm lights the sequence" "Slurm doesn't start: $(tail -n 1 "$work/err")"
  skip "as one job would" "Slurm doesn't start"
else
  run sbatch --wait --array=0-1 --output="$work/task%a" "$work/array.sh"
  test $status -eq 0
  ok $? "Slurm lights the sequence"
  run diff -r "$work/whole" lit
  ok $status "as one job would"
  slurm_stop "$work/slurm"
fi
cd / || exit 99

echo "1..$count"
