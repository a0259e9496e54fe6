#!/bin/sh
# Pairs of frames on the devices at hand: PoCL; oclgrind, which checks every
# access and looks for races; rusticl's llvmpipe.  What they make of it is held
# against PoCL's (device_frame.c).
. "$srcdir/test/tap.sh"

frame=test/device_frame

run "$frame" "$work/pocl"
ok $status "pairs of frames on PoCL: $(grep -v '^[[]\|^ok\|^1\.\.\|^#' "$work/out" | head -n 1)"

if command -v oclgrind >/dev/null; then
  # libtool's wrapper would be what oclgrind looks at; optimised code has
  # intrinsics that oclgrind 21.10 doesn't know
  run ./libtool --mode=execute oclgrind --build-options -O0 --data-races \
    --log "$work/log" "$frame" "$work/oclgrind" "$work/pocl"
  ok $status "the same under oclgrind, within 1e-4"
  cat "$work/log" >"$work/out" 2>/dev/null
  test -e "$work/oclgrind.1" && ! test -s "$work/log"
  ok $? "oclgrind has nothing to report"
else
  skip "the same under oclgrind" "no oclgrind"
  skip "oclgrind has nothing to report" "no oclgrind"
fi

icd=/etc/OpenCL/vendors/rusticl.icd
name="the same on rusticl's llvmpipe, within 1e-4"
if test -e $icd; then
  run env OCL_ICD_VENDORS=$icd RUSTICL_ENABLE=llvmpipe "$frame" \
    "$work/rusticl" "$work/pocl"
  if test $status -ne 0 && grep -q 'no OpenCL' "$work/err" "$work/out"; then
    skip "$name" "rusticl offers no device"
  else
    ok $status "$name"
  fi
else
  skip "$name" "no rusticl"
fi

echo "1..$count"
