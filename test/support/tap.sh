# What the tests of the tool share; `srcdir` is set before this is read.
#
#   HBIL       the program (./hbil)
#   srcdir     top of the source tree
#   HBIL_DATA  folder of the real dumps (shared/data beside the tree)
#
# $work is a folder that is gone afterwards.  The last line of a test is
# echo "1..$count".

HBIL=${HBIL:-./hbil}
work=$(mktemp -d "${TMPDIR:-/tmp}/hbil.XXXXXX") || exit 99
trap 'rm -rf "$work"' EXIT
trap 'exit 99' HUP INT TERM

if test -z "$HBIL_DATA"; then
  for HBIL_DATA in "$srcdir/../shared/data" "$srcdir/../../shared/data"; do
    test -d "$HBIL_DATA" && break
  done
fi

count=0

# What a job that was killed on this machine leaves: a temporary file that nobody
# has locked (src/image/temporary_name.c).  Elsewhere: what one of another
# machine leaves.
left_here=.hbil-$(head -c 8 /proc/sys/kernel/random/boot_id)-0123456789abcdef.tmp
left_elsewhere=.hbil-00000000-0123456789abcdef.tmp

# ok STATUS NAME: one result; what the command said follows a failure.
ok() {
  count=$((count + 1))
  if test "$1" -eq 0; then
    echo "ok $count - $2"
  else
    echo "not ok $count - $2"
    sed 's/^/# /' "$work/out" "$work/err"
  fi
}

skip() {
  count=$((count + 1))
  echo "ok $count - $1 # SKIP $2"
}

# run COMMAND...: its words land in $work/out and $work/err, its exit status
# in $status.
run() {
  "$@" >"$work/out" 2>"$work/err"
  status=$?
}

# works NAME COMMAND...
works() {
  name=$1
  shift
  run "$@"
  ok $status "$name"
}

# says NAME PATTERN COMMAND...: succeeds and prints a line with the pattern.
says() {
  name=$1 pattern=$2
  shift 2
  run "$@"
  test $status -eq 0 && grep -q -e "$pattern" "$work/out"
  ok $? "$name"
}

# rejected NAME PATTERN COMMAND...: exit status 2 and exactly one line on
# standard error, which starts with "hbil: " and has the pattern.
rejected() {
  name=$1 pattern=$2
  shift 2
  run "$@"
  test $status -eq 2 &&
    test "$(wc -l <"$work/err")" -eq 1 &&
    grep -q '^hbil: ' "$work/err" &&
    grep -q -e "$pattern" "$work/err"
  ok $? "$name"
}

# differs NAME COMMAND...: exit status 1.
differs() {
  name=$1
  shift
  run "$@"
  test $status -eq 1
  ok $? "$name"
}

# has NAME FILE...: all are there and not empty.
has() {
  name=$1 missing=0
  shift
  for file; do
    test -s "$file" || missing=1
  done
  ok $missing "$name"
}

# absent NAME PATH: nothing is there.
absent() {
  test ! -e "$2"
  ok $? "$1"
}

# same_lists NAME LIST LIST: two files agree line by line, and are not empty; what only
# one has is shown.
same_lists() {
  name=$1
  test -s "$2" && diff "$2" "$3" >"$work/out" 2>"$work/err"
  ok $? "$name"
}
