#!/bin/sh
# The program starts fast: OpenImageIO and the 250 libraries behind it are loaded
# by what reads or writes other formats than OpenEXR, and by nothing else.
. "$srcdir/test/support/tap.sh"

module=$(dirname "$HBIL")/.libs/hbil-formats.so
works "a demo" "$HBIL" demo --frames 1 --size 40x30 -o "$work/demo"
frame=$work/demo/gbuffer/frame_0001.exr
process() {
  "$HBIL" process --quiet --overwrite --quality reference --slices 1 --warm-up 0 \
    --layers ao "$@"
}

# loads COMMAND...: the names of libraries that the program loads
loads() {
  LD_DEBUG=files LD_DEBUG_OUTPUT="$work/loaded" "$@" >"$work/out" 2>"$work/err"
  status=$?
  cat "$work"/loaded.* >"$work/libraries"
  rm -f "$work"/loaded.*
}
without() { # NAME COMMAND...
  name=$1
  shift
  loads "$@"
  test $status -eq 0 && grep -q libOpenEXR "$work/libraries" &&
    ! grep -q 'OpenImageIO\|hbil-formats' "$work/libraries"
  ok $? "$name: without OpenImageIO"
}

without "--version" "$HBIL" --version
without "info" "$HBIL" info "$frame"
without "process" process -o "$work/lit" "$frame"
without "compare" "$HBIL" compare "$work/lit/frame_0001.exr" "$work/lit/frame_0001.exr"
loads process --preview -o "$work/lit" "$frame"
test $status -eq 0 && grep -q OpenImageIO "$work/libraries" &&
  test -s "$work/lit/frame_0001.ao.png"
ok $? "--preview loads it"

if test -e "$module"; then
  # a program whose module is not beside it, nor where it was to be installed
  mkdir "$work/bin"
  cp "$(dirname "$module")/hbil" "$work/bin/hbil"
  LD_LIBRARY_PATH=$work/bin${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
  export LD_LIBRARY_PATH
  for library in "$(dirname "$module")"/libhbil.so*; do
    test ! -e "$library" || cp "$library" "$work/bin"
  done
  HBIL=$work/bin/hbil
  cp "$work/lit/frame_0001.ao.png" "$work/ao.png"
  echo 'no library' >"$work/bin/hbil-formats.so"
  rejected "a module that is damaged: a job with pictures" \
    'hbil-formats.so.*; a complete installation' process --preview -o "$work/none" "$frame"
  rejected "a heat map" 'a complete installation' \
    "$HBIL" compare --heatmap "$work/heat.png" "$frame" "$frame"
  rejected "a PNG" 'a complete installation' "$HBIL" info "$work/ao.png"
  absent "leave nothing behind" "$work/none"
  works "what needs none runs" process -o "$work/lit" "$frame"
else
  for name in "a module that is damaged: a job with pictures" "a heat map" "a PNG" \
    "leave nothing behind" "what needs none runs"; do
    skip "$name" "the program has it inside"
  done
fi

echo "1..$count"
