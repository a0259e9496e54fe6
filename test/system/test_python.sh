#!/bin/sh
# The Python package: its own tests, put together as `make pythonpath` does, and
# what pip installs and `make wheel` makes of the sources, without a network.
. "$srcdir/test/support/tap.sh"

# find_python MODULES: sets $python to one that has them; fails if there is none
find_python() {
  for python in python3 /usr/bin/python3; do
    "$python" -c "import $1" 2>/dev/null && return
  done
  return 1
}
if ! find_python 'cffi, numpy, pytest, pyopencl' && ! find_python 'cffi, numpy'; then
  skip "the Python package" "no python3 with cffi and numpy"
  echo "1..$count"
  exit 0
fi
unset MAKEFLAGS MFLAGS MAKELEVEL MAKEOVERRIDES TESTS
HBIL_SOURCE=$srcdir
PYTHONDONTWRITEBYTECODE=1
export HBIL HBIL_SOURCE PYTHONDONTWRITEBYTECODE
library=$PWD/.libs/libhbil.so.1
here=$PWD

works "make pythonpath" "$python" "$srcdir/python/package.py" "$work/path" \
  "$srcdir/include" "$library"
has "the package has what is made for it" "$work/path/hbil/_declarations.py" \
  "$work/path/hbil/libhbil.so.1"

# with_package COMMAND...
with_package() {
  (cd "$work" && PYTHONPATH=$work/path "$@")
}
name="pytest"
if "$python" -c 'import pytest' 2>/dev/null; then
  run with_package "$python" -m pytest -q -p no:cacheprovider \
    -c "$srcdir/python/pyproject.toml" "$srcdir/python/tests"
  ok $status "$name"
else
  skip "$name" "no python3-pytest"
fi
for example in 05_python 10_notebook; do
  name="example $example"
  if test $example != 05_python ||
    "$python" -c 'import pyopencl' 2>/dev/null; then
    says "$name" 'mean' with_package "$python" "$srcdir/examples/$example.py"
  else
    skip "$name" "no python3 with pyopencl"
  fi
done
has "which draws" "$work/room.png"

# The five lines of README.md: those that python reads.
sed -n '/^>>> /s/^>>> //p' "$srcdir/README.md" >"$work/lines.py"
test "$(wc -l <"$work/lines.py")" -eq 3
ok $? "README.md has a first picture"
rm -f "$work/room.png"
works "its lines run" with_package "$python" "$work/lines.py"
has "and draw" "$work/room.png"

# sources: a copy, since setuptools writes beside them
cp -R "$srcdir/python" "$work/sources" && rm -rf "$work/sources/build"
cd "$work" || exit 99
name="pip install, without a network"
if find_python 'setuptools, wheel, pip, cffi, numpy'; then
  pip() {
    HBIL_LIBRARY=$library "$python" -m pip --disable-pip-version-check "$@" \
      --no-build-isolation --no-index --no-deps ./sources
  }
  works "$name" pip install -q --no-compile --target "$work/installed"
  says "what is installed is of this version" \
    "^$("$HBIL" --version | sed 's/hbil //')\$" env PYTHONPATH="$work/installed" \
    "$python" -c 'import hbil; print(hbil.version())'
  (cd installed/hbil && find . ! -type d) | sort >"$work/offered"
  (cd path/hbil && find . ! -type d) | sort >"$work/expected"
  same_lists "it is what make pythonpath makes" "$work/expected" "$work/offered"
  works "a wheel" pip wheel -q -w "$work/wheel"
  run ls "$work/wheel"
  grep -q '^hbil-.*-py3-none-manylinux_2_[0-9]*_.*\.whl$' "$work/out"
  ok $? "for any Python and glibc: $(cat "$work/out")"
else
  skip "$name" "no python3 with cffi, numpy, pip, setuptools and wheel"
fi
cd "$here" || exit 99

echo "1..$count"
