#!/bin/sh
# ./bootstrap check installs what it can: a package that the system doesn't have or
# that fails takes no other one with it, and each is named.  The commands that it
# calls are replaced; test_debian13.sh runs it as it is.
. "$srcdir/test/support/tap.sh"

mkdir "$work/bin" "$work/tree" "$work/tree/build"
cp "$srcdir/bootstrap" "$work/tree"

# The system: packages that are installed, one a line; words of those that it
# doesn't have, and of those that cannot be installed.
fake_command() { # NAME: its text comes from standard input
  { echo '#!/bin/sh' && cat; } >"$work/bin/$1"
  chmod +x "$work/bin/$1"
}
fake_command dpkg-query <<'END'
for last; do :; done
grep -q -x -e "$last" "$system/installed" && echo 'install ok installed'
END
fake_command apt-cache <<'END'
shift
for package; do
  case " $absent " in *" $package "*) continue ;; esac
  printf '%s:\n  Installed: (none)\n  Candidate: 1.0-1\n' "$package"
done
END
fake_command apt-get <<'END'
echo "$*" >>"$system/calls"
case $1 in indextargets) echo Packages ;; esac
test "$1" = install || exit 0
shift 3
for package; do
  case " $absent $failing " in *" $package "*) exit 100 ;; esac
done
printf '%s\n' "$@" >>"$system/installed"
END
fake_command configure </dev/null
mv "$work/bin/configure" "$work/tree"
# is newer, so nothing is configured
touch "$work/tree/build/config.status"
fake_command make <<'END'
echo '# PASS:  3' >build/test-suite.log
END
echo 'exit 1' | fake_command sudo
# shellcheck disable=SC2016
echo 'echo "$user"' | fake_command id
system=$work user=0
export system absent failing user

# packages NAME: those of this list of bootstrap, one a line
packages() {
  sed -n "/^$1='/,/'\$/p" "$srcdir/bootstrap" | sed "s/^$1=//" | tr -d "'" |
    tr ' ' '\n'
}
packages packages >"$work/needed"
packages test_packages >"$work/wanted"
sort -u "$work/needed" "$work/wanted" >"$work/all"

# bootstrap ABSENT FAILING: runs ./bootstrap check on a system that has the
# packages in $work/installed
bootstrap() {
  absent=$1 failing=$2
  : >"$work/calls"
  run env PATH="$work/bin:$PATH" "$work/tree/bootstrap" check
  cat "$work/err" >>"$work/out"
  sort "$work/installed" >"$work/sorted"
}

# installs NAME: everything but what is absent or fails, which one line names; the
# tests run.
installs() {
  name=$1
  # shellcheck disable=SC2086
  printf '%s\n' $absent $failing | sort >"$work/left"
  sed -n 's/.*cannot be installed.*: //p' "$work/out" | tr ' ' '\n' | sort >"$work/named"
  sort "$work/sorted" "$work/left" | diff "$work/all" - >>"$work/out" &&
    diff "$work/left" "$work/named" >>"$work/out" &&
    test "$(grep -c 'cannot be installed' "$work/out")" -eq 1 &&
    test "$status" -eq 0 && grep -q '^3 passed, 0 failed, 0 skipped$' "$work/out"
  ok $? "$name"
}

: >"$work/installed"
bootstrap '' ''
same_lists "all packages are installed" "$work/all" "$work/sorted"
! grep -q 'cannot be' "$work/out"
ok $? "and none is said to be missing"
test "$(grep -c '^install' "$work/calls")" -eq 2
ok $? "in two steps: what is needed, and what tests need"

: >"$work/installed"
bootstrap oclgrind ''
installs "a package that the system doesn't have"
test "$(grep -c '^install' "$work/calls")" -eq 2
ok $? "which apt-get isn't asked for"
: >"$work/installed"
bootstrap '' valgrind
installs "a package that cannot be installed"
: >"$work/installed"
bootstrap 'oclgrind mmdebstrap' 'zsh cmake'
installs "several of both"

: >"$work/installed"
bootstrap '' gcc
test "$status" -ne 0 && ! grep -q passed "$work/out"
ok $? "without a package that is needed there is nothing to test"

grep -v -x oclgrind "$work/all" >"$work/installed"
user=1000
bootstrap oclgrind ''
installs "nobody is asked for a password"
! grep -q '^update\|^install' "$work/calls"
ok $? "where nothing can be installed"
cp "$work/needed" "$work/installed"
bootstrap '' "$(paste -s -d ' ' "$work/wanted")"
installs "the tests run for users without rights"

# These print, and do nothing else on a system where everything is missing.
: >"$work/installed"
: >"$work/calls"
for option in -h --help; do
  run env PATH="$work/bin:$PATH" "$work/tree/bootstrap" "$option"
  test "$status" -eq 0 && test ! -s "$work/err" &&
    grep -q '^usage: \./bootstrap \[demo|check\]$' "$work/out" &&
    grep -q '^  \./bootstrap demo ' "$work/out"
  ok $? "$option prints the usage"
done
run env PATH="$work/bin:$PATH" "$work/tree/bootstrap" chekc
test "$status" -ne 0 && test ! -s "$work/out" && grep -q 'usage: ' "$work/err"
ok $? "a word that isn't known is an error"
test ! -s "$work/calls"
ok $? "and nothing is installed"

echo "1..$count"
