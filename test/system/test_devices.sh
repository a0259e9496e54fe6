#!/bin/sh
# A few frames, by two plans, on the devices at hand: PoCL; oclgrind, which
# checks every access, looks for races and for what nothing has set; rusticl's
# llvmpipe.  What they make of it is held against PoCL's (device_frame.c).
. "$srcdir/test/support/tap.sh"

frame=test/system/device_frame
icd=/etc/OpenCL/vendors/rusticl.icd

on_pocl() {
  run "$frame" "$plan" "$work/pocl"
  ok $status "$plan on PoCL: $(grep -v '^[[]\|^ok\|^1\.\.\|^#' "$work/out" | head -n 1)"
}

# Motion reads, and masks, what lies around the history: oclgrind would report
# it.  libtool's wrapper would be what oclgrind looks at; optimised code has
# intrinsics that oclgrind 21.10 doesn't know.
under_oclgrind() {
  checks=--data-races
  test "$plan" = motion || checks="$checks --uninitialized"
  # shellcheck disable=SC2086
  run ./libtool --mode=execute oclgrind --build-options -O0 $checks \
    --log "$work/log" "$frame" "$plan" "$work/oclgrind" "$work/pocl"
  ok $status "$plan under oclgrind, within 1e-4"
  cat "$work/log" >"$work/out" 2>/dev/null
  test -e "$work/oclgrind" && ! test -s "$work/log"
  ok $? "$plan: oclgrind has nothing to report ($checks)"
}

on_rusticl() {
  name="$plan on rusticl's llvmpipe, within 1e-4"
  run env OCL_ICD_VENDORS=$icd RUSTICL_ENABLE=llvmpipe "$frame" "$plan" \
    "$work/rusticl" "$work/pocl"
  if test $status -ne 0 && grep -q 'no OpenCL' "$work/err" "$work/out"; then
    skip "$name" "rusticl offers no device"
  else
    ok $status "$name"
  fi
}

for plan in camera motion; do
  rm -f "$work"/*
  on_pocl
  if command -v oclgrind >/dev/null; then
    under_oclgrind
  else
    skip "$plan under oclgrind" "no oclgrind"
    skip "$plan: oclgrind has nothing to report" "no oclgrind"
  fi
  if test -e $icd; then
    on_rusticl
  else
    skip "$plan on rusticl's llvmpipe" "no rusticl"
  fi
done

# Binaries and images are where drivers differ most.  The tests skip by name
# what rusticl 22.3 does not have.  Of binaries, what is damaged or fails is up
# to the library, on any driver.
for test in test_binaries test_images; do
  name="$test on rusticl's llvmpipe"
  if ! test -e $icd; then
    skip "$name" "no rusticl"
    continue
  fi
  run env OCL_ICD_VENDORS=$icd RUSTICL_ENABLE=llvmpipe \
    HBIL_TEST_FILTER='*builds_nothing' test/unit/$test
  if test $status -ne 0 && grep -q 'no OpenCL' "$work/err" "$work/out"; then
    skip "$name" "rusticl offers no device"
  else
    ok $status "$name"
  fi
done

echo "1..$count"
