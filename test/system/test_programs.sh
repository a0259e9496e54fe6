#!/bin/sh
# Built programs are stored between runs where the driver doesn't store them, in
# a folder of the user's.  Whatever happens to that folder, results are the same
# and nothing is said.
. "$srcdir/test/support/tap.sh"

pocl=/etc/OpenCL/vendors/pocl.icd
if ! test -e $pocl; then
  skip "stored programs" "no PoCL"
  echo "1..$count"
  exit 0
fi
OCL_ICD_VENDORS=$pocl
export OCL_ICD_VENDORS
unset HBIL_KERNEL_DIR HBIL_PROGRAM_DIR XDG_CACHE_HOME

works "a demo" "$HBIL" demo --frames 1 --size 40x30 -o "$work/demo"
frame=$work/demo/gbuffer/frame_0001.exr

# process NAME=VALUE...: lights the frame into $work/lit, with as few programs as
# possible.
process() {
  env "$@" "$HBIL" process --quiet --overwrite --layers ao --reprojection none \
    -o "$work/lit" "$frame"
}
# same NAME [NAME=VALUE...]: a run that says nothing and has the same bits as one
# without stored programs.
same() {
  name=$1
  shift
  run process "$@"
  test $status -eq 0 && ! test -s "$work/out" && ! test -s "$work/err" &&
    cmp "$work/lit/frame_0001.exr" "$work/want.exr" >"$work/out" 2>&1
  ok $? "$name"
}
here() {
  same "$1" HBIL_PROGRAM_DIR="$programs"
}
# true_that NAME COMMAND...
true_that() {
  name=$1
  shift
  "$@" >"$work/out" 2>"$work/err"
  ok $? "$name"
}
# A program that is stored again is another file.
files() {
  ls -Ai "$programs"
}
unchanged() {
  files >"$work/now"
  diff "$work/files" "$work/now" >"$work/out" 2>"$work/err"
  ok $? "$1"
}
stored() { # FOLDER: some programs and nothing else are there
  test "$(find "$1" -type f -name '*-*.bin' | wc -l)" -ge 4 &&
    test "$(find "$1" -type f -name '*-*.bin' | wc -l)" -eq "$(ls -A "$1" | wc -l)"
}
empty() {
  test -z "$(ls -A "$1" 2>/dev/null)"
}

process HBIL_PROGRAM_DIR= >"$work/out" 2>"$work/err"
mv "$work/lit/frame_0001.exr" "$work/want.exr"

# --- a folder that the user names, with any driver ---

programs=$work/programs
here "the first run"
true_that "the first run stores its programs" stored "$programs"
true_that "they are for the user alone" test -z "$(find "$programs" -perm /077)"
files >"$work/files"
here "the second run"
unchanged "the second run loads all of them"
touch -d 2000-01-01 "$programs"/*
here "a run years later"
true_that "the times of files are those of their last use" test -z "$(find "$programs" -name '*.bin' ! -newermt 2020-01-01)"

# --- other kernels ---

# Comments would not count.
cp -R "$srcdir/kernels" "$work/kernels"
chmod -R u+w "$work/kernels"
echo 'int another_function(void); int another_function(void) { return 1; }' \
  >>"$work/kernels/gather.cl"
same "kernels of HBIL_KERNEL_DIR" HBIL_PROGRAM_DIR="$programs" HBIL_KERNEL_DIR="$work/kernels"
true_that "other kernels have programs of their own" \
  test "$(find "$programs" -name 'gather-*' | wc -l)" -eq 2
rm -r "$programs"
here "the library's own kernels again"

# --- damage ---

# damage NAME: the files of $programs are damaged.  They are replaced at once.
damage() {
  here "$1: the first run"
  stored "$programs"
  ok $? "$1: replaced"
  files >"$work/files"
  here "$1: the second run"
  unchanged "$1: loaded"
}
each() { # COMMAND...: with each program
  for program in "$programs"/*.bin; do
    "$@" "$program"
  done
}
break_off() {
  head -c 100 "$1" >"$work/part"
  mv "$work/part" "$1"
}
make_empty() {
  : >"$1"
}
change_byte() {
  printf x | dd of="$1" bs=1 seek=1000 conv=notrunc 2>/dev/null
}
each break_off
damage "programs that break off"
each make_empty
damage "empty programs"
each change_byte
damage "programs with another byte"
each truncate -s 300M
damage "programs of 300 MiB"

# --- what is no regular file ---

link_to_elsewhere() {
  cp "$1" "$work/elsewhere"
  ln -sf "$work/elsewhere/${1##*/}" "$1"
}
elsewhere() {
  (cd "$work/elsewhere" && ls -il --time-style=full-iso)
}
make_fifo() {
  rm "$1"
  mkfifo "$1"
}
make_folder() {
  rm "$1"
  mkdir "$1"
}
mkdir "$work/elsewhere"
each link_to_elsewhere
touch -d 2000-01-01 "$work"/elsewhere/*
elsewhere >"$work/before"
damage "symbolic links"
elsewhere >"$work/after"
true_that "symbolic links are not followed" cmp "$work/before" "$work/after"
if command -v timeout >/dev/null; then
  each make_fifo
  run timeout 60 env HBIL_PROGRAM_DIR="$programs" "$HBIL" process --quiet --overwrite \
    --layers ao --reprojection none -o "$work/lit" "$frame"
  ok $status "FIFOs: nothing waits"
  true_that "FIFOs: replaced" stored "$programs"
else
  skip "FIFOs: nothing waits" "no timeout"
  skip "FIFOs: replaced" "no timeout"
fi
each make_folder
here "folders in place of programs"
true_that "folders in place of programs: nothing else is left" \
  test -z "$(find "$programs" -type f)"
rm -r "$programs"

# --- several processes ---

# PoCL's own cache would not bear two that compile.
for i in 1 2 3; do
  POCL_CACHE_DIR=$work/pocl-$i HBIL_PROGRAM_DIR=$programs "$HBIL" process --quiet \
    --layers ao --reprojection none -o "$work/lit-$i" "$frame" >"$work/says-$i" 2>&1 &
done
wait
cat "$work"/says-* >"$work/out"
test ! -s "$work/out" && cmp "$work/lit-1/frame_0001.exr" "$work/want.exr" &&
  cmp "$work/lit-2/frame_0001.exr" "$work/want.exr" &&
  cmp "$work/lit-3/frame_0001.exr" "$work/want.exr"
ok $? "three processes at once"
true_that "three processes store their programs whole" stored "$programs"
files >"$work/files"
here "a fourth one"
unchanged "a fourth one loads all of them"

# --- the limit ---

old=gather-0123456789abcdef
younger=gather-0123456789abcdee
left=$programs/.hbil-00000000-0123456789abcdef.tmp
truncate -s 200M "$programs/$old.bin" "$programs/$younger.bin"
: >"$left"
touch -d 2000-01-01 "$programs/$old.bin" "$left"
touch -d 2000-01-02 "$programs/$younger.bin"
truncate -s 300M "$programs/notes.bin"
here "a folder of more than 256 MiB"
true_that "a run that stores nothing deletes nothing" test -e "$programs/$old.bin"
rm "$programs"/split-*.bin
here "one of its programs is missing"
true_that "what was not used for longest is deleted" test ! -e "$programs/$old.bin"
true_that "what is left is small enough, and stays" test -e "$programs/$younger.bin"
true_that "what a killed run has left is removed" test ! -e "$left"
true_that "files of others stay" test -e "$programs/notes.bin"
rm "$programs/notes.bin" "$programs/$younger.bin"
true_that "the programs of this run stay" stored "$programs"

# --- folders that can't be used ---

: >"$work/file"
same "a file in place of the folder" HBIL_PROGRAM_DIR="$work/file"
same "a folder whose parent is missing" HBIL_PROGRAM_DIR="$work/a/b"
same "a folder that can't be made" HBIL_PROGRAM_DIR=/proc/programs
mkdir "$work/public"
chmod 777 "$work/public"
same "a folder where others may write" HBIL_PROGRAM_DIR="$work/public"
true_that "a folder where others may write has no programs" empty "$work/public"
if test "$(id -u)" = 0; then
  mkdir -m 755 "$work/foreign"
  chown 1 "$work/foreign"
  same "another user's folder" HBIL_PROGRAM_DIR="$work/foreign"
  true_that "another user's folder has no programs" empty "$work/foreign"
else
  mkdir -m 500 "$work/locked"
  same "a folder that is locked" HBIL_PROGRAM_DIR="$work/locked"
  true_that "a folder that is locked has no programs" empty "$work/locked"
fi

# --- the folder of caches ---

if ! $CC -shared -fPIC -DCL_TARGET_OPENCL_VERSION=120 -o "$work/platform_name.so" \
  "$srcdir/test/system/platform_name.c" -ldl 2>"$work/err"; then
  skip "other platforms" "no shared libraries"
  echo "1..$count"
  exit 0
fi
caches=$work/caches
another() { # NAME PLATFORM [ARGUMENTS OF ENV]...
  name=$1 platform=$2
  shift 2
  same "$name" "$@" LD_PRELOAD="$work/platform_name.so" HBIL_TEST_PLATFORM="$platform"
}
another "a driver that stores nothing" "Another platform" XDG_CACHE_HOME="$caches"
true_that "its programs are in XDG_CACHE_HOME" stored "$caches/hbil"
another "an empty HBIL_PROGRAM_DIR" "Another platform" XDG_CACHE_HOME="$work/none" \
  HBIL_PROGRAM_DIR=
true_that "an empty HBIL_PROGRAM_DIR: nothing is stored" test ! -e "$work/none"
mkdir "$work/home"
another "without XDG_CACHE_HOME" "Another platform" HOME="$work/home"
true_that "without XDG_CACHE_HOME, programs are in HOME/.cache" stored "$work/home/.cache/hbil"
programs=$work/home/.cache/hbil
files >"$work/files"
another "once more" "Another platform" HOME="$work/home"
unchanged "they are loaded from there"
another "a relative XDG_CACHE_HOME" "Another platform" HOME="$work/home" XDG_CACHE_HOME=caches
true_that "a relative XDG_CACHE_HOME does not count" test ! -e caches
another "a HOME that is missing" "Another platform" HOME="$work/nobody"
true_that "a HOME that is missing is not made" test ! -e "$work/nobody"
another "without HOME" "Another platform" -u HOME
another "a HOME that can't be written" "Another platform" HOME=/proc
for platform in "Portable Computing Language" "NVIDIA CUDA" rusticl Oclgrind; do
  another "$platform" "$platform" XDG_CACHE_HOME="$work/none"
  true_that "$platform: stores nothing" test ! -e "$work/none"
done

echo "1..$count"
