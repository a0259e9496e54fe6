#!/bin/sh
# Runs one test with a PoCL kernel cache that no other test uses meanwhile:
# programs that build kernels side by side would fight over a common one.  The
# first of a few caches that is free is taken, so that later tests find kernels
# of earlier ones; what was built in other caches comes in before, and goes out
# after the test, by way of one that no test uses.  Without flock (util-linux)
# each test has its own.  A test whose kernels don't compile without a remark
# fails.  Each log has how long the test took.
name=$(for last in "$@"; do :; done; basename "$last" .sh)
caches=$PWD/test/pocl-cache
mkdir -p "$caches/shared"
POCL_CACHE_DIR=$caches/$name
slot=
if command -v flock >/dev/null; then
  for slot in 1 2 3 4 5 6 7 8 ''; do
    test -n "$slot" || break
    # held until the test ends: it has the descriptor
    exec 9>"$caches/$slot.lock"
    if flock -n 9; then
      POCL_CACHE_DIR=$caches/$slot
      break
    fi
  done
fi
export POCL_CACHE_DIR
mkdir -p "$POCL_CACHE_DIR"

# share FROM TO: links to the files that TO lacks, one test at a time.
share() {
  test -z "$slot" ||
    flock "$caches/shared.lock" cp -rln "$1/." "$2" 2>/dev/null || :
}
share "$caches/shared" "$POCL_CACHE_DIR"
said=$caches/$name.stderr
begun=$(date +%s)
"$@" 2>"$said"
status=$?
cat "$said" >&2
echo "$name: $(($(date +%s) - begun)) s" >&2
# PoCL says so on the terminal of whoever launches such a kernel first
if grep -q 'warnings\{0,1\} generated' "$said"; then
  echo "$name: the compiler has remarks on a kernel" >&2
  status=1
fi
rm -f "$said"
share "$POCL_CACHE_DIR" "$caches/shared"
exit $status
