#!/bin/sh
# Builds an example as anybody would, who has pkg-config and nothing else of this
# tree, and runs it with what is installed.  `make installcheck` calls it with CC,
# DESTDIR, bindir, libdir and tool ("hbil", or empty) set.
#
#   installed.sh EXAMPLE.c
set -eu
example=$1
PKG_CONFIG_PATH=$DESTDIR$libdir/pkgconfig${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}
PKG_CONFIG_SYSROOT_DIR=$DESTDIR
LD_LIBRARY_PATH=$DESTDIR$libdir${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export PKG_CONFIG_PATH PKG_CONFIG_SYSROOT_DIR LD_LIBRARY_PATH

work=$(mktemp -d "${TMPDIR:-/tmp}/hbil.XXXXXX")
trap 'rm -rf "$work"' EXIT
flags=$(pkg-config --cflags --libs hbil)
# shellcheck disable=SC2086
$CC -std=c11 -DCL_TARGET_OPENCL_VERSION=120 "$example" $flags -lm -o "$work/example"
"$work/example"

# the same with the kernels' sources that are installed
HBIL_KERNEL_DIR=$DESTDIR$(PKG_CONFIG_SYSROOT_DIR='' \
  pkg-config --variable=kernelsdir hbil)
export HBIL_KERNEL_DIR
test -s "$HBIL_KERNEL_DIR/gather.cl"
"$work/example"

version=$(pkg-config --modversion hbil)
if test -n "$tool" && test "$("$DESTDIR$bindir/$tool" --version)" != "hbil $version"; then
  echo "$DESTDIR$bindir/$tool is not of version $version" >&2
  exit 1
fi
