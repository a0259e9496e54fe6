#!/bin/sh
# Builds the fuzz target of the file readers with clang and runs it: `make fuzz`.
#
#   HBIL_FUZZ_SECONDS  how long (1800)
#   HBIL_DATA          folder of the real dumps, whose odd and damaged files
#                      are the seeds (shared/data beside the tree)
#   CLANG, CLANGXX     the compilers (clang, clang++)
#
# What it finds stays in test/scratch/fuzz/found, the corpus beside it.
set -eu
srcdir=${srcdir:-$(dirname "$0")/../..}
data=${HBIL_DATA:-$srcdir/../shared/data}
seconds=${HBIL_FUZZ_SECONDS:-1800}
out=test/scratch/fuzz
flags='-g -O1 -fno-omit-frame-pointer -fsanitize=fuzzer,address,undefined
  -fno-sanitize-recover=undefined'
packages='OpenEXR libdeflate OpenImageIO jansson'

command -v "${CLANG:-clang}" >/dev/null || {
  echo "make fuzz: ${CLANG:-clang} is missing; on Debian: apt-get install clang" >&2
  exit 1
}

# compile COMPILER STANDARD FILE
compile() {
  # shellcheck disable=SC2046,SC2086
  "$1" "-std=$2" $flags -I"$srcdir/src" -I"$srcdir" \
    -DHBIL_PACKAGE_VERSION='"fuzz"' $(pkg-config --cflags $packages) -c "$3" -o "$out/$(basename "$3").o"
}

mkdir -p "$out/corpus" "$out/seeds" "$out/found"
# An object of a file that has been renamed since would be linked as well.
rm -f "$out"/*.o
for file in "$srcdir"/src/image/*.c "$srcdir/test/system/fuzz_reader.c"; do
  # the module of other formats is linked
  case $file in */formats_module.c) continue ;; esac
  compile "${CLANG:-clang}" c11 "$file"
done
for file in "$srcdir"/src/image/*.cpp "$srcdir"/src/oiio/*.cpp; do
  compile "${CLANGXX:-clang++}" c++17 "$file"
done
# shellcheck disable=SC2046,SC2086
"${CLANGXX:-clang++}" $flags "$out"/*.o $(pkg-config --libs $packages) \
  -o "$out/fuzz_reader"

# Camera files are not EXR, which no file of the two folders is.
printf '{"camera_to_world": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]],
  "fx": 1, "fy": 1.5e0, "cx": 0, "cy": -1, "resolution": [64, 48]}' \
  >"$out/seeds/camera.json"
for folder in malformed real_exr; do
  test ! -d "$data/$folder" || cp -f "$data/$folder"/* "$out/seeds"
done

# Small whole files in every compression, where Debian's openimageio-tools are.
if command -v oiiotool >/dev/null; then
  for compression in none rle zips zip piz pxr24 b44 b44a dwaa dwab; do
    for type in half float; do
      for shape in scanline 'tile 16 16'; do
        # shellcheck disable=SC2086
        oiiotool --pattern noise:type=uniform 20x40 5 \
          --chnames R,G,B,depth.Z,normal.Y -d $type --$shape \
          --compression $compression \
          -o "$out/seeds/$compression-$type-${shape%% *}.exr"
      done
    done
  done
fi

# 64 KiB are enough for every feature; larger seeds are cut.  A second is an
# age for so little.
ASAN_OPTIONS=allocator_may_return_null=1:detect_leaks=1 \
  exec "$out/fuzz_reader" -max_total_time="$seconds" -max_len=65536 \
  -timeout=20 -rss_limit_mb=3000 -print_final_stats=1 \
  -artifact_prefix="$out/found/" ${FUZZ_FLAGS:-} "$out/corpus" "$out/seeds"
