#!/bin/sh
# Packs what is built for x86-64 machines that have neither a network nor
# packages, but glibc as new as this machine's: the tool, the bench, test
# programs, examples and the libraries that they need.
#
#   bundle/make.sh BUILD SOURCE OUT.tar.xz [pocl]
#
# BUILD is the folder of a finished `make check TESTS=`.  With `pocl` the
# driver and its compiler are packed, too, for machines without OpenCL.  There:
#
#   tar xf OUT.tar.xz && hbil-bundle/run devices
#
# OpenImageIO stays behind, since it needs some 250 more libraries.  So the
# bundle reads and writes EXR files alone, no PNG.
set -eu
build=$(cd "$1" && pwd) source=$(cd "$2" && pwd) out=$3 pocl=${4:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' HUP INT TERM
bundle=$work/hbil-bundle

# needs FILE...: the libraries that the loader finds for them.  The C library
# is the target's own.
needs() {
  LD_LIBRARY_PATH=$build/.libs ldd "$@" 2>/dev/null |
    awk '$2 == "=>" && $3 ~ /^\// { print $3 }' | sort -u |
    grep -vE '/(libc|libm|libdl|librt|libpthread|libmvec)\.so'
}

# take FOLDER LIBRARY...: copies those that aren't there yet.  C++'s libraries
# go to a folder of their own, for targets that lack them.
take() {
  to=$1
  shift
  for file; do
    case $file in
    */libstdc++.so* | */libgcc_s.so*) cp -nL "$file" "$bundle/c++/" ;;
    *) cp -nL "$file" "$to/" ;;
    esac
  done
}

programs() {
  mkdir -p "$bundle/bin" "$bundle/lib" "$bundle/c++" "$bundle/test/gpu/want" \
    "$bundle/examples"
  cp "$build/.libs/hbil" "$build/.libs/hbil-bench" "$bundle/bin/"
  cp "$build"/test/*/.libs/test_* "$build/test/system/.libs/device_frame" \
    "$bundle/test/"
  for example in "$build"/examples/.libs/[0-9]*; do
    cp "$example" "$bundle/examples/"
  done
  cp -r "$source/kernels" "$bundle/kernels"
  cp "$source/bundle/run" "$bundle/run"
  cp "$source/test/gpu/run" "$bundle/test/gpu/run"
  # shellcheck disable=SC2046
  take "$bundle/lib" $(needs "$bundle"/bin/* "$bundle"/test/test_* \
    "$bundle"/examples/*)
  strip --strip-unneeded "$bundle"/bin/* "$bundle"/test/test_* \
    "$bundle"/test/device_frame "$bundle"/examples/* "$bundle"/lib/*
}

# What this machine's CPU makes of the frames that test/gpu/run compares.
wanted_frames() {
  for plan in camera motion; do
    LD_LIBRARY_PATH=$bundle/lib "$bundle/test/device_frame" "$plan" \
      "$bundle/test/gpu/want/$plan" >/dev/null
  done
}

# replace LIBRARY PATTERN: a library of empty functions in place of one that
# LLVM names but PoCL never calls, with the names and versions that it asks for.
replace() {
  nm -D --with-symbol-versions "$folder"/libLLVM*.so* |
    awk -v wanted="$2" '$1 == "U" && $2 ~ wanted {
      split($2, part, "@+")
      print "void " part[1] "(void) {}" >(out ".c")
      if (part[2]) of[part[2]] = of[part[2]] part[1] "; "
    } END { for (v in of) print v " { " of[v] "};" >(out ".map") }' \
      out="$work/empty" -
  touch "$work/empty.map"
  rm -f "$folder/$1"
  map=
  [ ! -s "$work/empty.map" ] || map=-Wl,--version-script=$work/empty.map
  # shellcheck disable=SC2086
  cc -shared -fPIC -w -o "$folder/$1" "$work/empty.c" -Wl,-soname,"$1" $map
  rm -f "$work"/empty.*
}

# PoCL looks for its files from where its library lies.  The bitcode is that of
# the processors that most machines have.
driver() {
  library=$(cat /etc/OpenCL/vendors/pocl.icd)
  [ -e "$library" ] || library=$(ldconfig -p | awk '/libpocl\.so\.2/ { print $NF; exit }')
  from=$(dirname "$library")
  folder=$bundle/pocl/lib/x86_64-linux-gnu
  mkdir -p "$folder/pocl" "$bundle/pocl/share/pocl" "$bundle/pocl/bin" \
    "$bundle/pocl/libexec"
  cp -L "$library" "$folder/libpocl.so.2"
  cp -L "$from"/pocl/libpocl-devices-pthread.so \
    "$from"/pocl/libpocl-devices-basic.so "$folder/pocl/"
  cp -r /usr/share/pocl/include "$bundle/pocl/share/pocl/"
  for kind in GENERIC sse2 avx2 avx512; do
    cp /usr/share/pocl/kernel-*-"$kind".bc "$bundle/pocl/share/pocl/"
  done
  cp -L "$(readlink -f "$(command -v ld)")" "$bundle/pocl/libexec/ld"
  cp "$source/bundle/ld" "$bundle/pocl/bin/ld"
  # shellcheck disable=SC2046
  take "$folder" $(needs "$library" "$folder"/pocl/*.so "$bundle/pocl/libexec/ld")
  for file in "$folder"/libz3.so.* "$folder"/libxml2.so.*; do
    case $file in
    *'*') ;;
    *z3*) replace "${file##*/}" '^Z3_' ;;
    *) replace "${file##*/}" '^(xml|html)' ;;
    esac
  done
  rm -f "$folder"/libicu*
}

programs
wanted_frames
[ "$pocl" != pocl ] || driver
tar -C "$work" --owner=0 --group=0 --sort=name -c hbil-bundle |
  xz -T0 ${XZ_LEVEL:+"-$XZ_LEVEL"} >"$work/archive"
mv "$work/archive" "$out"
ls -l "$out"
