#!/bin/sh
# What an OpenCL driver lacks: PoCL's folder for compiled kernels is replaced
# where it can't be used, and where the driver ends the process, a line says so.
. "$srcdir/test/support/tap.sh"

works "a demo" "$HBIL" demo --frames 1 --size 32x18 -o "$work/demo"
one=$work/demo/gbuffer/frame_0001.exr
if ! "$HBIL" devices 2>/dev/null | head -n 1 | grep -q 'Portable Computing Language'; then
  skip "PoCL's folder" "another driver"
  echo "1..$count"
  exit
fi
: >"$work/file"
mkdir "$work/tmp"
# with CACHE TMPDIR OPTIONS: one kernel of occlusion alone, compiled anew.
with() {
  folder=$1 tmp=$2
  shift 2
  POCL_CACHE_DIR=$folder TMPDIR=$tmp "$HBIL" process --overwrite --mode gtao --layers ao \
    --slices 1 --steps-per-side 4 -o "$work/lit" "$@" "$one"
}
# ends NAME: 0, or 2 and a last line of ours.
ends() {
  test $status -eq 0 ||
    { test $status -eq 2 && tail -n 1 "$work/err" | grep -q '^hbil: '; }
  ok $? "$1"
}

# --- a folder that can't be used ---

works "a folder in a file" with "$work/file/cache" "$work/tmp"
grep -q "file/cache, can't be used (Not a directory); they go to $work/tmp/hbil-pocl-" "$work/err"
ok $? "is told, and another one is used"
test "$(find "$work/tmp" -name '*.so' | wc -l)" -gt 0 &&
  test "$(find "$work/tmp" -maxdepth 1 -name 'hbil-pocl-*' -perm 700 | wc -l)" -eq 1
ok $? "which is this user's alone"
run with "$work/file/cache" "$work/tmp" --quiet
test $status -eq 0 && test ! -s "$work/err"
ok $? "--quiet doesn't tell"
says "devices are found without it" 'Portable Computing Language' \
  env POCL_CACHE_DIR="$work/file/cache" TMPDIR="$work/tmp" "$HBIL" devices
chmod 777 "$work/tmp"/hbil-pocl-*
rejected "a folder that others may write is not used" \
  "PoCL's folder for compiled kernels cannot be written: Not a directory; POCL_CACHE_DIR" \
  with "$work/file/cache" "$work/tmp" --quiet
rm -r "$work/tmp"/hbil-pocl-*
mkdir "$work/elsewhere"
chmod 700 "$work/elsewhere"
ln -s "$work/elsewhere" "$work/tmp/hbil-pocl-$(id -u)"
rejected "nor one that a link leads to" 'cannot be written' \
  with "$work/file/cache" "$work/tmp" --quiet
rm "$work/tmp"/hbil-pocl-*
rejected "nor is there one in no folder" 'cannot be written' \
  with "$work/file/cache" "$work/file" --quiet

# --- a driver that ends the process ---

# A full disk, and no other folder; each size stops the compiler elsewhere.
mkdir "$work/disk"
full() {
  unshare -rm sh -c 'mount -t tmpfs -o size="$1" none "$0" && shift && "$@"' \
    "$work/disk" "$@"
}
if full 64k true 2>/dev/null; then
  for size in 100k 400k; do
    cat >"$work/job" <<END
POCL_CACHE_DIR=$work/disk/cache TMPDIR=$work/file "$HBIL" process --quiet --overwrite \
  --mode gtao --slices 1 --steps-per-side 4 -o "$work/lit" "$one"
END
    run full $size sh "$work/job"
    ends "a disk with $size of room"
    rm -f "$work/job"
  done
else
  skip "a disk with little room" "no right to mount one"
fi
limited() { # OPTION LIMIT: with a new folder each time
  rm -rf "$work/cache"
  run sh -c 'ulimit "$0" "$1" && shift && exec "$@"' "$1" "$2" env POCL_CACHE_DIR="$work/cache" \
    "$HBIL" process --quiet --overwrite --mode gtao --slices 1 --steps-per-side 4 \
    -o "$work/lit" "$one"
  ends "ulimit $1 $2"
}
for size in 8 64 256 1024; do
  limited -f $size
done
for size in 200000 300000 400000 500000 600000; do
  limited -v $size
done

# --- a signal ---

# A job in the exact integral, which has no driver.
"$HBIL" process --quiet --overwrite --quality reference --slices 32 --repeat 1000 \
  -o "$work/lit" "$one" 2>"$work/err" &
job=$!
sleep 1
kill -SEGV $job
wait $job
test $? -eq 2 && test "$(grep -c '^hbil: ' "$work/err")" -eq 1 && grep -q SIGSEGV "$work/err"
ok $? "a crash has its line, too"

echo "1..$count"
