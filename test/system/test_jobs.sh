#!/bin/sh
# Jobs that write into one folder, at once or after one another was killed: each
# file is one job's and whole, the loser says so, and nothing is left over.
. "$srcdir/test/support/tap.sh"

# The exact integral of few slices: no device, so no kernels to be compiled.
exact() {
  "$HBIL" process --quiet --quality reference --slices "$@"
}
holds() { # NAME FOLDER FILES...: these and no others, hidden ones included.
  name=$1 folder=$2
  shift 2
  ls -A "$folder" >"$work/out" 2>"$work/err"
  printf '%s\n' "$@" | sort | diff - "$work/out" >>"$work/err"
  ok $? "$name"
}

works "a demo" "$HBIL" demo --frames 3 --size 32x18 -o "$work/demo"
frames=$work/demo/gbuffer
one=$frames/frame_0001.exr
works "one kind of results" exact 1 -o "$work/a" "$frames"
works "and another" exact 2 -o "$work/b" "$frames"

# --- two jobs at once ---

# both COMMAND...: two jobs of different settings in one folder; their exit
# statuses in $first and $second, what they say in err1 and err2.
both() {
  rm -rf "$work/two"
  # shellcheck disable=SC2068
  $@ "$HBIL" process --quiet --quality reference --slices 1 $how -o "$work/two" "$frames" \
    2>"$work/err1" &
  job=$!
  # shellcheck disable=SC2068
  $@ "$HBIL" process --quiet --quality reference --slices 2 $how -o "$work/two" "$frames" \
    2>"$work/err2"
  second=$?
  wait $job
  first=$?
  cat "$work/err1" "$work/err2" >"$work/err"
}
# Which of the jobs a frame is from.
of_job() {
  cmp -s "$work/two/$1" "$work/a/$1" && echo a && return
  cmp -s "$work/two/$1" "$work/b/$1" && echo b || echo neither
}
bad=0 how=
for try in 1 2 3 4; do
  both
  jobs=$(for f in "$work"/two/*; do of_job "${f##*/}"; done | sort -u)
  test "$(ls -A "$work/two" | wc -l)" -eq 3 && test "$(wc -l <"$work/err")" -eq 1 &&
    grep -q '^hbil: .*/frame_000[123].exr: is there already' "$work/err" &&
    case "$first $second $jobs" in
    '0 2 a' | '2 0 b') true ;;
    *) false ;;
    esac || bad=1
  echo "try $try: $first $second $jobs" >>"$work/out"
done
ok $bad "of two jobs one writes all results, and the other says so in one line"
if unshare --pid --fork true 2>"$work/err"; then
  bad=0 how=--overwrite
  for try in 1 2 3 4; do
    both unshare --pid --fork
    for f in frame_0001.exr frame_0002.exr frame_0003.exr; do
      test "$(of_job $f)" != neither || bad=1
    done
    test "$first $second $(ls -A "$work/two" | wc -l)" = '0 0 3' || bad=1
  done
  ok $bad "in two containers with the same process ids, each result is of one job"
else
  skip "in two containers with the same process ids" "no right to unshare"
fi
mkdir "$work/taken"
echo 'mine' >"$work/taken/frame_0001.ao.png"
rejected "a preview that is there" 'frame_0001.ao.png: is there already' \
  exact 1 --preview -o "$work/taken" "$one"
holds "is left alone" "$work/taken" frame_0001.ao.png
works "unless with --overwrite" exact 1 --preview --layers ao --overwrite \
  -o "$work/taken" "$one"

# --- what killed jobs leave ---

left() {
  for folder in "$work/lit" "$work/caches" "$work/sheets"; do
    mkdir -p "$folder"
    : >"$folder/$left_here"
  done
}
for mode in '' --overwrite --resume; do
  left
  # shellcheck disable=SC2086
  works "a job after one that was killed ${mode:-in an empty folder}" "$HBIL" process --quiet \
    --slices 1 --steps-per-side 6 --cache-size 16 $mode --cache-save "$work/caches/saved" \
    --contact-sheet "$work/sheets/sheet.png" -o "$work/lit" "$one"
  holds "leaves results alone" "$work/lit" frame_0001.exr
  holds "the cache alone" "$work/caches" saved
  holds "and the picture alone" "$work/sheets" sheet.png
done
left
works "compare sweeps where it writes" "$HBIL" compare --heatmap "$work/sheets/heat.png" \
  "$work/a/frame_0001.exr:ao" "$work/b/frame_0001.exr:ao"
holds "so does it" "$work/sheets" heat.png sheet.png
: >"$frames/$left_here"
works "a demo once more" "$HBIL" demo --frames 3 --size 32x18 -o "$work/demo"
absent "sweeps as well" "$frames/$left_here"
if command -v flock >/dev/null; then
  : >"$work/lit/$left_here"
  works "beside a job that lives" flock "$work/lit/$left_here" \
    "$HBIL" process --quiet --quality reference --slices 1 --resume -o "$work/lit" "$one"
  holds "its file stays" "$work/lit" "$left_here" frame_0001.exr
else
  skip "beside a job that lives" "no flock"
  skip "its file stays" "no flock"
fi
: >"$work/a/.hbil-light.frame_0002"
works "a whole sequence after a chunk that was killed" exact 1 --overwrite -o "$work/a" "$frames"
holds "has no light to carry on" "$work/a" frame_0001.exr frame_0002.exr frame_0003.exr

# --- long names ---

# long LENGTH: the frames under names of so many bytes.
long() {
  stem=$(printf "%0$(($1 - 6))d" 0 | tr 0 w)_
  rm -rf "$work/long"
  mkdir "$work/long"
  for n in 1 2 3; do
    cp "$frames/frame_000$n.exr" "$work/long/$stem$n.exr"
  done
}
for length in 233 240 250; do
  long $length
  works "names of $length bytes" exact 1 --camera "${one%.exr}.json" -o "$work/lit-$length" "$work/long"
  holds "have results" "$work/lit-$length" "${stem}1.exr" "${stem}2.exr" "${stem}3.exr"
  size=$(wc -c <"$work/long/${stem}2.exr")
  mkdir "$work/cut"
  cp "$work/long"/* "$work/cut"
  head -c $((size - 100)) "$work/long/${stem}2.exr" >"$work/cut/${stem}2.exr"
  rejected "broken off" truncated \
    exact 1 --camera "${one%.exr}.json" -o "$work/again-$length" "$work/cut"
  test "$(ls -A "$work/again-$length" | wc -l)" -eq 2
  ok $? "with one result, and light to carry on"
  works "and resumed" exact 1 --resume --camera "${one%.exr}.json" -o "$work/again-$length" \
    "$work/long"
  run diff -r "$work/lit-$length" "$work/again-$length"
  ok $status "as without interruption"
  rm -rf "$work/cut"
done
rejected "previews whose names are too long" \
  'near_irradiance.png: cannot be written: its name has 266 bytes; .* at most 255 ' \
  exact 1 --preview --camera "${one%.exr}.json" -o "$work/none" "$work/long"
absent "leave nothing" "$work/none"

# --- kills ---

run sh "$srcdir/test/system/stress_jobs.sh" 8 "$$"
ok $status "jobs that are killed at random times lose nothing and leave nothing"

echo "1..$count"
