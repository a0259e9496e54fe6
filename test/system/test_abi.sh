#!/bin/sh
# A program that was compiled with this version's header, by a library whose
# structs have grown since: one is made of the sources, with fields behind the
# last ones that must have their defaults.  And the sizes that no header had.
. "$srcdir/test/support/tap.sh"

if ! test -f .libs/libhbil.so; then
  skip "a program goes on with a library whose structs have grown" \
    "no shared library"
  echo "1..$count"
  exit 0
fi
opencl="$(pkg-config --cflags --libs OpenCL)"
later=$work/later
mkdir -p "$later/hbil"

# grown FILE PLACE WORDS: a copy of FILE with WORDS behind the first { in PLACE.
grown() {
  sed -e "$2 s|{|{ $3|" "$srcdir/src/hbil/$1" >"$later/$1"
  cmp -s "$srcdir/src/hbil/$1" "$later/$1" && echo "$1 has no $2" >&2
}
for header in "$srcdir"/include/hbil/*.h; do
  sed 's/^} hbil_\(config\|frame\);/cl_ulong later[2]; &/' "$header" \
    >"$later/hbil/$(basename "$header")"
done
{
  grown config.c '/^ *hbil_config defaults = /' '.later = {7, 7},'
  mv "$later/config.c" "$work/defaults.c"
  sed '/^static hbil_status config_check/,/{/ s|{|{ if (config->later[1] != 7) \
    return fail(context, HBIL_INVALID_CONFIG, "no default");|' \
    "$work/defaults.c" >"$later/config.c"
  grown frame.c '/^static hbil_status check_frame/,/{/' 'if (frame->later[1]) \
    return fail(plan->context, HBIL_INVALID_FRAME, "no default");'
} 2>"$work/missing"
sources=src/hbil/kernel_sources.c
for source in "$srcdir"/src/hbil/*.c; do
  name=$(basename "$source")
  case $name in kernel_sources.c) continue ;; esac
  test ! -f "$later/$name" || source=$later/$name
  sources="$sources $source"
done
# shellcheck disable=SC2086
run ${CC:-cc} -std=c11 -O0 -fPIC -shared -Wl,-soname,libhbil.so.1 \
  "-Wl,--version-script=$srcdir/src/hbil/libhbil.map" -o "$later/libhbil.so.1" \
  "-I$later" "-I$srcdir/src/hbil" "-I$srcdir/src" "-I$srcdir/kernels" \
  "-I$srcdir/include" $sources $opencl -lm
test $status -eq 0 && test "$(grep -c 'later\[1\]' "$later/config.c")" = 1 &&
  test "$(grep -c 'later = {7' "$later/config.c")" = 1 &&
  test "$(grep -c 'later\[1\]' "$later/frame.c")" = 1 &&
  test "$(cat "$later"/hbil/*.h | grep -c 'later\[2\]')" = 2
ok $? "a library is made whose structs have grown by 16 bytes"
# shellcheck disable=SC2086
works "and a program with the header as it is" ${CC:-cc} -std=c11 \
  -o "$work/caller" "-I$srcdir/include" "$srcdir/test/system/abi_caller.c" \
  .libs/libhbil.so $opencl

# by LIBRARY CONFIG_BYTES FRAME_BYTES: the program with those, run with a library.
by() {
  folder=$1
  shift
  env LD_LIBRARY_PATH="$folder${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" \
    "$work/caller" "$@"
}
works "which has a frame of this library" by .libs
read -r config frame <"$work/out"
tail -n 1 "$work/out" >"$work/expected"

# taken NAME LIBRARY CONFIG_BYTES FRAME_BYTES: the very same frame comes out.
taken() {
  name=$1
  shift
  run by "$@"
  test $status -eq 0 && tail -n 1 "$work/out" | cmp -s - "$work/expected"
  ok $? "$name"
}
# no NAME PATTERN LIBRARY CONFIG_BYTES FRAME_BYTES: rejected in one line.
no() {
  name=$1 pattern=$2
  shift 2
  run by "$@"
  test $status -eq 1 && test "$(wc -l <"$work/err")" -eq 1 &&
    grep -q "^struct_size: $pattern" "$work/err"
  ok $? "$name"
}

taken "and the same of the one that has grown" "$later"
for more in 8 16; do
  taken "structs of $more bytes more are taken by that" "$later" \
    $((config + more)) $((frame + more))
done
for folder in .libs "$later"; do
  test "$folder" = .libs && grown=0 which='this library' ||
    { grown=16 which='the one that has grown'; }
  no "$which rejects a config that is too large" \
    "$((config + grown + 8)), hbil_config of .* has $((config + grown)) bytes; .*newer" \
    "$folder" $((config + grown + 8)) "$frame"
  no "and such a frame" \
    "$((frame + grown + 8)), hbil_frame of .* has $((frame + grown)) bytes; .*newer" \
    "$folder" "$config" $((frame + grown + 8))
  no "and a config that no header had" \
    "$((config - 8)), .*at least $config bytes; call hbil_config_init" \
    "$folder" $((config - 8)) "$frame"
  no "and such a frame, too" \
    "$((frame - 8)), .*at least $frame bytes; call hbil_frame_init" \
    "$folder" "$config" $((frame - 8))
done

echo "1..$count"
