#include "image/exr_dwa.h"
#include "image/catch_exceptions.hpp"
#include "image/error.h"

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>

#include <algorithm>
#include <cstdint>

namespace {

// The unpacked bytes of the largest block that the C++ library holds at once: a
// chunk of scanlines, or a row of tiles.  exr_get_chunk_unpacked_size() counts
// a single tile only.
uint64_t block_bytes(const exr_file &f, int part) {
  const exr_attr_chlist_t *channels = exr_file_channels(&f, part);
  exr_tile_level_mode_t levels;
  exr_tile_round_mode_t rounding;
  uint32_t width = 0, height = 0;
  int32_t lines = 0;
  uint64_t pixel = 0;
  if (exr_get_tile_descriptor(f.context, part, &width, &height, &levels,
                              &rounding) != EXR_ERR_SUCCESS &&
      exr_get_scanlines_per_chunk(f.context, part, &lines) == EXR_ERR_SUCCESS)
    height = uint32_t(lines);
  for (int i = 0; i < channels->num_channels; i++)
    pixel += channels->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
  return pixel * height * std::max(width, f.width);
}

// The bytes of the chunk tables of all parts, which the C++ library always
// reads.
uint64_t table_bytes(const exr_file &f) {
  uint64_t chunks = 0;
  for (int part = 0; part < f.parts; part++) {
    int32_t count = 0;
    exr_get_chunk_count(f.context, part, &count);
    chunks += count > 0 ? uint64_t(count) : 0;
  }
  return 8 * chunks;
}

// The C++ library has no replaceable allocator, so its memory is estimated
// before it starts.  It holds one block packed, unpacked and in between;
// 2.7 to 3.1 blocks were measured.
int check_memory(exr_file &f, int part) {
  const uint64_t needed = 4 * block_bytes(f, part) + table_bytes(f);
  if (needed <= f.budget.limit - f.budget.held)
    return 0;
  f.budget.exceeded = 1;
  return exr_file_fail(&f, EXR_DAMAGED_PIXELS, EXR_ERR_OUT_OF_MEMORY);
}

int decode(const exr_file &f, int part, const image &img,
           const exr_source *sources) {
  // No threads: each would hold a block of its own.
  Imf::MultiPartInputFile file(f.stream.path, 0);
  Imf::InputPart in(file, part);
  const Imath::Box2i window = in.header().dataWindow();
  if (window.size() != Imath::V2i(int(img.width) - 1, int(img.height) - 1))
    return image_fail(f.error,
                      "%s: two readers see two sizes; a complete file "
                      "is needed",
                      f.stream.path);
  const exr_attr_chlist_t *channels = exr_file_channels(&f, part);
  Imf::FrameBuffer planes;
  for (size_t i = 0; i < img.count; i++)
    if (sources[i].part == part)
      planes.insert(channels->entries[sources[i].channel].name.str,
                    Imf::Slice::Make(img.planes[i].type == IMAGE_UINT
                                         ? Imf::UINT
                                         : Imf::FLOAT,
                                     img.planes[i].pixels, window,
                                     sizeof(float), sizeof(float) * img.width));
  in.setFrameBuffer(planes);
  in.readPixels(window.min.y, window.max.y);
  return 0;
}

} // namespace

extern "C" int exr_dwa_compressed(const exr_file *f, int part) {
  exr_compression_t compression = EXR_COMPRESSION_NONE;
  exr_get_compression(f->context, part, &compression);
  return compression == EXR_COMPRESSION_DWAA ||
         compression == EXR_COMPRESSION_DWAB;
}

extern "C" int exr_dwa_decode(exr_file *f, int part, const image *img,
                              const exr_source *sources) {
  return catch_exceptions(f->stream.path, "read", f->error, [&] {
    return check_memory(*f, part) != 0 ? -1 : decode(*f, part, *img, sources);
  });
}
