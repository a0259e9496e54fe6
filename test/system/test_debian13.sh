#!/bin/sh
# A bare Debian 13: ./bootstrap there, the installed example, the tests that know a
# new compiler's faults first (PoCL 6 with LLVM 18; gcc 14), and a frame of the demo,
# which is as it is here.
#
# mmdebstrap makes that system from the mirror that this one has, in namespaces and a
# tmpfs of its own.  They end with this process, however it ends, and leave no
# processes, mounts or files behind.
. "$srcdir/test/support/tap.sh"

# --- whether there can be one ---

finish() {
  echo "1..$count"
  exit 0
}

# none REASON: there is none.
none() {
  skip "a bare Debian 13" "$1"
  finish
}

# mirrors: where this system has Debian's packages from.
mirrors() {
  # shellcheck disable=SC2016
  apt-get indextargets --format '$(ORIGIN)|$(LABEL)|$(COMPONENT)|$(REPO_URI)' \
    'Created-By: Packages' 2>"$work/err" | sed -n 's/^Debian|Debian|main|//p'
}

# no_mirror FILE: the reason, from what apt said.
no_mirror() {
  none "no mirror: $(grep '^E:' "$1" | head -n 1)"
}

# namespaces COMMAND...: runs it in some in place of this process; they end with its
# parent.
namespaces() {
  exec setpriv --pdeathsig KILL \
    unshare --mount --pid --fork --kill-child --mount-proc "$@"
}

if test -z "$HBIL_MIRROR"; then
  test -z "$HBIL_PACKAGING" || none "packages are built without a network"
  test "$(id -u)" -eq 0 || none "not root"
  for command in mmdebstrap setpriv unshare; do
    command -v $command >/dev/null || none "no $command"
  done
  ! grep -q '^VERSION_ID="*13' /etc/os-release || none "this system is one"
  (namespaces mount -t tmpfs none "$work") 2>"$work/err" ||
    none "no namespaces: $(tail -n 1 "$work/err")"
  test "$(awk '/^MemAvailable:/ { print int($2 / 1024) }' /proc/meminfo)" -ge 5120 ||
    none "less than 5 GiB of memory"
  HBIL_MIRROR=$(mirrors | head -n 1)
  test -n "$HBIL_MIRROR" || none "no mirror of Debian in apt's sources"
  /usr/lib/apt/apt-helper download-file "${HBIL_MIRROR%/}/dists/trixie/InRelease" \
    "$work/InRelease" >"$work/out" 2>&1 || no_mirror "$work/out"
  export HBIL_MIRROR
  # A shell handles signals while it waits, but not while a command runs.
  # shellcheck disable=SC2016
  TMPDIR=$work namespaces sh -c \
    'mount -t tmpfs -o mode=755,size=4g none "$TMPDIR" && exec sh "$0"' "$0" &
  wait $!
  exit
fi

# --- the system ---

root=$TMPDIR/debian13

# there COMMAND...: in that system, as a user finds it.
there() {
  run chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    http_proxy="$http_proxy" https_proxy="$https_proxy" \
    sh -c 'cd /hbil && exec "$@"' sh "$@"
  cat "$work/err" >>"$work/said"
}

# works_there NAME COMMAND...
works_there() {
  name=$1
  shift
  there "$@"
  ok $status "$name"
}

apt-config dump Acquire::http Acquire::https Acquire::Check-Valid-Until >"$work/apt"
# apt's lists stay there, and aren't downloaded twice
run mmdebstrap --mode=root --variant=apt --skip=cleanup/apt/lists \
  --aptopt="$work/apt" \
  --dpkgopt=force-unsafe-io --dpkgopt='path-exclude=/usr/share/doc/*' \
  --dpkgopt='path-exclude=/usr/share/man/*' \
  --dpkgopt='path-exclude=/usr/share/locale/*' trixie "$root" "$HBIL_MIRROR"
if test "$status" -ne 0; then
  # the mirror went away, or this system is older than the keys of Debian 13
  ! grep -q 'Failed to fetch\|NO_PUBKEY' "$work/err" || no_mirror "$work/err"
fi
ok "$status" "mmdebstrap makes a Debian 13"
test "$status" -eq 0 || finish
for folder in proc sys dev; do
  mount --rbind /$folder "$root/$folder" || exit 99
done

# The sources as a tarball has them; autoreconf is that system's own.
unset MAKEFLAGS MFLAGS MAKELEVEL MAKEOVERRIDES TESTS DESTDIR
works "its copy of the sources" make -s distdir distdir="$root/hbil"
rm -f "$root/hbil/configure"

# --- there ---

# Tests and scenes take less time if the C compiler optimises a little.
works_there "./bootstrap, with warnings as errors" env \
  CONFIGURE_FLAGS='-q --enable-werror --disable-static CFLAGS=-O1 CXXFLAGS=-O0' \
  ./bootstrap
wanted=$(sed -n "/^test_packages='/,/'\$/p" "$srcdir/bootstrap" |
  sed 's/^test_packages=//' | tr -d "'" | tr ' ' '\n' | grep -v -x oclgrind)
# shellcheck disable=SC2086
works_there "packages for tests: all but oclgrind" apt-get install -s -qq $wanted

programs=
for test in kernels gather binaries messages; do
  programs="$programs test/unit/test_$test"
done
# shellcheck disable=SC2086
works_there "programs of tests" make -s -C build -j "$(nproc)" $programs
for program in $programs; do
  works_there "$(basename "$program")" env HBIL_STRESS_CASE=1 "build/$program"
done
works_there "make install" make -s -C build install
works_there "the installed example" make -s -C build installcheck

# --- the same light ---

# Both compilers get the same arithmetic: nothing is contracted, and only rounding
# may differ where relaxed math allows it.  Measured: 0.
works_there "the demo" build/hbil demo --frames 1 -o demo
works "the same frame here" "$HBIL" demo --frames 1 -o "$work/demo"
works "has the same light, within 1e-6" "$HBIL" compare --max-rmse 1e-6 \
  "$root/hbil/demo/frame_0001.exr" "$work/demo/frame_0001.exr"
sed -n 's/^RMSE/# &/p' "$work/out"

# as in test/support/run.sh
grep 'warnings\{0,1\} generated' "$work/said" >"$work/out"
test ! -s "$work/out"
ok $? "PoCL's compiler has no warnings there"

finish
