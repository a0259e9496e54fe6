#!/bin/sh
# Every example in C and C++ runs and finds its own results sane; test_install.sh
# has those that need an installed library.
. "$srcdir/test/support/tap.sh"

for name in 01_minimal 02_in_your_pipeline 03_single_passes 04_many_devices \
  07_renderer_loop 09_cache; do
  works "example $name" "$EXAMPLES/$name"
done
if test -x "$EXAMPLES/08_cpp"; then
  works "example 08_cpp" "$EXAMPLES/08_cpp"
else
  skip "example 08_cpp" "no CL/opencl.hpp (opencl-clhpp-headers)"
fi

echo "1..$count"
