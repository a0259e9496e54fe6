#!/bin/sh
# The library as it is linked: exports what its map and the header name and
# nothing else, and never prints or ends the process; the documents' examples.
. "$srcdir/test/support/tap.sh"
headers=$(echo "$srcdir"/include/hbil/*.h)
library=.libs/libhbil.so

# hbil_ names that are followed by a parenthesis in a declaration of the API
declared() {
  # shellcheck disable=SC2086
  awk '/^HBIL_API/ { api = 1 }
       api && match($0, /hbil_[a-z0-9_]+\(/) {
         print substr($0, RSTART, RLENGTH - 1); api = 0 }' $headers | sort
}

# what stands under "global:"
mapped() {
  awk '/^(local:|})/ { global = 0 }
       global { sub(/;.*/, ""); print $1 }
       /^global:/ { global = 1 }' "$srcdir/src/hbil/libhbil.map" | sort
}

exported() {
  nm -D --defined-only "$library" | awk '$2 == "T" { print $3 }' |
    sed 's/@.*//' | sort
}

undefined() {
  nm -D --undefined-only "$library" | awk '{ print $NF }' | sed 's/@.*//'
}

declared >"$work/declared"
mapped >"$work/mapped"
same_lists 'the map names what the header declares' "$work/declared" "$work/mapped"
if test -f "$library"; then
  exported >"$work/exported"
  same_lists 'the library exports what the map names' "$work/mapped" "$work/exported"
  undefined | grep -E '^(_exit|exit|abort|quick_exit|__assert_fail)$' >"$work/out"
  test ! -s "$work/out"
  ok $? 'never ends the process'
  # fwrite() is for files of stored programs; to print it needs stdout or stderr
  undefined | grep -E '^(v?f?printf|__v?f?printf_chk|puts|putchar|fputs|perror|stderr|stdout)$' \
    >"$work/out"
  test ! -s "$work/out"
  ok $? 'never prints'
else
  for name in 'the library exports what the map names' \
    'never ends the process' 'never prints'; do
    skip "$name" "no shared library"
  done
fi

# The house inside: which object uses functions of which other one.
archive=.libs/libhbil.a
upper='plan|plan_create|cache|cache_create|cache_inject|cache_update|cache_volumes|cache_pyramid|cache_light_view|cache_report|probes|passes|frame|report'
if test -f "$archive"; then
  nm -A -g "$archive" | sed 's/.*libhbil_la-\([a-z0-9_]*\)\.o:/\1 /' >"$work/symbols"
  awk '$(NF - 1) != "U" && $NF !~ /^hbil_/' "$work/symbols" >"$work/out"
  test ! -s "$work/out"
  ok $? 'all names in the static library begin with hbil_'
  awk 'NR == FNR { if ($(NF - 1) != "U") owner[$NF] = $1; next }
       $(NF - 1) == "U" && $NF in owner && owner[$NF] != $1 {
         print $1, owner[$NF] }' "$work/symbols" "$work/symbols" | sort -u >"$work/uses"
  grep -E "^(kernel_set|buffers|timeline|program|binary|staging|checks|planes|layout|defines) ($upper)\$" \
    "$work/uses" >"$work/out"
  test ! -s "$work/out"
  ok $? 'what plans and caches are made of knows neither'
else
  for name in 'all names in the static library begin with hbil_' \
    'what plans and caches are made of knows neither'; do
    skip "$name" "no static library"
  done
fi

includes="-I$srcdir/include $(pkg-config --cflags OpenCL)"

# The documents' examples in C, each in a function that has the variables that
# the text speaks of.
c_blocks() {
  sed -n '/^```c$/,/^```$/{/^```/d;p}' "$srcdir/$1"
}
parameters='cl_context cl_context, cl_device_id cl_device, cl_command_queue queue'
readme="$parameters, cl_uint wait_count, const cl_event *wait_list"
guide="$parameters, const double camera_to_world[16], double fx, double fy,
  const double projection[16], const double view[16], const double eye[3],
  double cx, double cy, cl_mem depth_buffer, cl_mem normal_buffer,
  cl_mem albedo_buffer, cl_mem direct_buffer, cl_mem indirect_buffer,
  cl_event gbuffer_ready, const float *depth, const float *normal,
  const float *direct, const float *emission"
{
  echo '#include <hbil/hbil.h>'
  echo "void readme($readme);"
  echo "void readme($readme) {"
  echo 'hbil_context *context; hbil_config config; hbil_plan *plan;'
  echo 'hbil_frame frame; cl_event event;'
  c_blocks README.md
  echo '}'
  echo "void guide($guide);"
  echo "void guide($guide) {"
  c_blocks doc/guide.md
  echo '(void)status; }'
} >"$work/documents.c"
test "$(grep -c hbil_enqueue_frame "$work/documents.c")" -ge 2
ok $? "README.md and doc/guide.md have examples in C"
# shellcheck disable=SC2086
works "which compile" ${CC:-cc} -std=c11 -Wall -Wextra -Werror $includes \
  -fsyntax-only "$work/documents.c"

echo "1..$count"
