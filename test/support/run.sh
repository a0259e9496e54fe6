#!/bin/sh
# Runs one test, and shares compiled kernels among all tests.
#
#   run.sh [SHELL] TEST
#
# PoCL's cache on disk breaks when two processes write to it at once.  So each
# test locks one of a few caches for as long as it runs, and test/pocl-cache has
# one more, "shared", which no test writes to: kernels that are missing are
# linked from there into the test's cache, and new ones are linked back, before
# the test, after it, and every ten seconds, so that tests that run beside each
# other don't compile the same.  Links cost no space, and what PoCL
# has finished appears under its name at once.  Without flock (util-linux) each
# test has a cache of its own.
#
# A test fails whose kernels cause a compiler's warning.  The log ends with the
# seconds that the test took: wall, and CPU of the test and its children.
name=$(for last in "$@"; do :; done; basename "$last" .sh)
caches=$PWD/test/pocl-cache
mkdir -p "$caches/shared"
POCL_CACHE_DIR=$caches/$name
slot=
if command -v flock >/dev/null; then
  for slot in 1 2 3 4 5 6 7 8 ''; do
    test -n "$slot" || break
    # the lock is released when the last process with the descriptor ends
    exec 9>"$caches/$slot.lock"
    if flock -n 9; then
      POCL_CACHE_DIR=$caches/$slot
      break
    fi
  done
fi
export POCL_CACHE_DIR
mkdir -p "$POCL_CACHE_DIR"

# share FROM TO: links the files that TO lacks, one test at a time.  Files that
# PoCL is writing have other names.
share() {
  test -z "$slot" || (
    cd "$1" && flock "$caches/shared.lock" \
      find . \( -name program.bc -o -name build.log -o \
        -name '*.so' ! -name 'tempfile*' \) \
      -exec cp -ln --parents -t "$2" {} + 2>/dev/null
  ) || :
}

share "$caches/shared" "$POCL_CACHE_DIR"
exchange=
if test -n "$slot"; then
  # not more often: each time takes .2 s of CPU
  while sleep 10 && kill -0 $$; do # as long as this shell lives
    share "$POCL_CACHE_DIR" "$caches/shared"
    share "$caches/shared" "$POCL_CACHE_DIR"
  done >/dev/null 2>&1 9>&- &
  exchange=$!
fi
errors=$caches/$name.stderr
begun=$(date +%s)
"$@" 2>"$errors"
status=$?
test -z "$exchange" || kill "$exchange"
cat "$errors" >&2
# PoCL prints warnings when a kernel is launched for the first time
if grep -q 'warnings\{0,1\} generated' "$errors"; then
  echo "$name: the compiler has warnings for a kernel" >&2
  status=1
fi
share "$POCL_CACHE_DIR" "$caches/shared"
times >"$errors"
echo "$name: $(($(date +%s) - begun)) s, CPU $(tail -n 1 "$errors")" >&2
rm -f "$errors"
exit $status
