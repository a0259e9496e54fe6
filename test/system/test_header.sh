#!/bin/sh
# The public headers in other programs: every standard of C and C++ that they
# claim, with each compiler, and beside OpenCL's own C++ header, before and after
# it, whatever OpenCL version the program asks for.
. "$srcdir/test/support/tap.sh"

strict='-Wall -Wextra -Wpedantic -Werror -Wshadow'
includes="-I$srcdir/include $(pkg-config --cflags OpenCL)"

# program INCLUDES...: a user's file that has these lines first, and uses every
# kind of thing in the headers.
program() {
  printf '%s\n' "$@"
  cat <<'END'

#if HBIL_VERSION_MAJOR < 0
#error "no version"
#endif

int main(void) {
  hbil_config config;
  hbil_frame frame;
  hbil_context *context = NULL;
  hbil_config_init(&config);
  hbil_frame_init(&frame);
  config.model.mode = HBIL_MODE_GTAO;
  config.execution.skip = HBIL_SKIP_SKY | HBIL_SKIP_OPEN;
  return hbil_context_create(NULL, NULL, &context) == HBIL_INVALID_ARGUMENT &&
                 config.struct_size == sizeof config
             ? 0
             : 1;
}
END
}
program '#include <hbil/hbil_stages.h>' >"$work/user.c"
cp "$work/user.c" "$work/user.cpp"

# compiles NAME COMPILER ARGUMENTS...: without a warning; skipped without COMPILER.
compiles() {
  name=$1 compiler=$2
  shift 2
  if command -v "$compiler" >/dev/null; then
    # shellcheck disable=SC2086
    works "$name" "$compiler" $strict $includes -fsyntax-only "$@"
  else
    skip "$name" "no $compiler"
  fi
}

version=-DCL_TARGET_OPENCL_VERSION=120
for compiler in gcc clang; do
  for std in c99 c11 c17; do
    compiles "$compiler takes the headers in $std" $compiler -std=$std $version \
      -Wstrict-prototypes "$work/user.c"
  done
done
for compiler in g++ clang++; do
  for std in c++11 c++14 c++17 c++20; do
    compiles "$compiler takes the headers in $std" $compiler -std=$std $version \
      -Wold-style-cast "$work/user.cpp"
  done
done
# OpenCL's headers have the version that the program asks for, and no other.
for version in 120 200 300; do
  {
    cat "$work/user.c"
    echo "_Static_assert(CL_TARGET_OPENCL_VERSION == $version, \"another version\");"
  } >"$work/version.c"
  compiles "the program's OpenCL $version holds" gcc -std=c11 \
    -DCL_TARGET_OPENCL_VERSION=$version "$work/version.c"
done

# --- beside <CL/opencl.hpp> ---

# CL_TARGET_OPENCL_VERSION is left to opencl.hpp, or to OpenCL's default where
# hbil's header is first.
hpp='#include <CL/opencl.hpp>'
program '#include <hbil/hbil_stages.h>' "$hpp" >"$work/before.cpp"
program "$hpp" '#include <hbil/hbil_stages.h>' >"$work/after.cpp"
found=yes
echo "$hpp" | ${CXX:-c++} -x c++ -E -DCL_HPP_TARGET_OPENCL_VERSION=300 - \
  >"$work/out" 2>"$work/err" || found=no
for version in 120 200 300; do
  for order in before after; do
    for compiler in g++ clang++; do
      name="$compiler takes hbil.h $order opencl.hpp for OpenCL $version"
      if test $found = yes; then
        compiles "$name" $compiler -std=c++17 "$work/$order.cpp" \
          -DCL_HPP_TARGET_OPENCL_VERSION=$version \
          -DCL_HPP_MINIMUM_OPENCL_VERSION=$version
      else
        skip "$name" "no CL/opencl.hpp (opencl-clhpp-headers)"
      fi
    done
  done
done

# --- linked ---

# shellcheck disable=SC2086
works "a C++ program links with the library" ./libtool --silent --tag=CXX \
  --mode=link ${CXX:-c++} -std=c++11 $includes -o "$work/user" "$work/user.cpp" \
  libhbil.la
works "and calls it" "$work/user"

echo "1..$count"
