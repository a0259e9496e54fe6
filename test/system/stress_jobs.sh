#!/bin/sh
# Kills jobs at random times while they write into one folder: nothing that was
# there is lost or damaged, and the last job leaves what a job in an empty folder
# does, and nothing else.
#
#   HBIL=build/hbil stress_jobs.sh KILLS [SEED]
#
# Prints what it did, and exits 1 after "not as it should be: ...".  `make
# stress-jobs` calls it; test_jobs.sh does with few kills.
kills=$1 seed=${2:-1}
HBIL=${HBIL:-./hbil}
work=$(mktemp -d "${TMPDIR:-/tmp}/hbil.XXXXXX") || exit 99
trap 'rm -rf "$work"' EXIT
trap 'exit 99' HUP INT TERM

wrong() {
  echo "not as it should be: $*"
  exit 1
}

# job MODE: all files that a job can write, whose bits don't depend on the mode.
all='--slices 1 --steps-per-side 6 --warm-up 1 --preview --cache-size 16'
job() {
  # shellcheck disable=SC2086
  exec "$HBIL" process --quiet $1 $all --cache-save "$2/saved" \
    --contact-sheet "$2/sheet.png" -o "$2" "$work"/demo/gbuffer/*.exr
}

"$HBIL" demo --frames 4 --size 32x18 -o "$work/demo" >/dev/null 2>&1 &&
  (job --overwrite "$work/want") && rm -rf "$work/want" || wrong "no demo"
begun=$(date +%s%N)
(job --overwrite "$work/want") || wrong "a job alone fails"
took=$(($(date +%s%N) - begun))

# Every file that is there has the bits of a job that nobody disturbed.
check_whole() {
  for file in "$work"/two/*; do
    test ! -e "$file" || cmp "$file" "$work/want/${file##*/}" ||
      wrong "after kill $n: ${file##*/}"
  done
}

awk -v n="$kills" -v seed="$seed" -v took="$took" 'BEGIN {
  srand(seed)
  for (i = 0; i < n; i++)
    printf "%.4f %s\n", 1.1 * rand() * took / 1e9,
      rand() < .5 ? "--overwrite" : "--resume" }' >"$work/plan"
n=0 hit=0 left=0 most=0
while read -r seconds mode; do
  n=$((n + 1))
  (job "$mode" "$work/two") 2>"$work/err" &
  pid=$!
  sleep "$seconds"
  kill -9 $pid 2>/dev/null && hit=$((hit + 1))
  wait $pid 2>/dev/null
  test ! -s "$work/err" || wrong "$(cat "$work/err")"
  check_whole
  there=$(find "$work/two" -name '[fs]*' 2>/dev/null | wc -l)
  test "$there" -ge "$most" || wrong "after kill $n: $there of $most files"
  most=$there
  left=$((left + $(find "$work/two" -name '.hbil-*.tmp' 2>/dev/null | wc -l)))
done <"$work/plan"
(job --resume "$work/two") || wrong "the last job fails"
diff -r "$work/want" "$work/two" || wrong "the last job"
echo "$n jobs, $hit of them killed, $left times with a file half-written;" \
  "nothing lost, nothing left (seed $seed)"
