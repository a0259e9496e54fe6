// Files are written by OpenEXR's C++ library, because OpenEXRCore 3.1 cannot
// compress DWA and uses one CPU only.
#include "image/exr_write.h"
#include "image/catch_exceptions.hpp"
#include "image/exr_checksum.h"
#include "image/exr_header.hpp"
#include "image/exr_output.hpp"
#include "image/temporary.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfThreading.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <memory>
#include <thread>
#include <vector>

namespace {

// Clamps finite values.  Imf::floatToHalf() would make large ones infinite.
std::vector<half> to_half(const float *pixels, size_t count) {
  std::vector<half> out(count);
  for (size_t i = 0; i < count; i++) {
    const float most = std::isfinite(pixels[i]) ? float(HALF_MAX) : INFINITY;
    out[i] = half(std::isnan(pixels[i])
                      ? pixels[i]
                      : std::min(std::max(pixels[i], -most), most));
  }
  return out;
}

// Writes each plane in the type that the header gives its channel.
void write_pixels(const image &img, Imf::OutputFile &file) {
  const Imf::Header &header = file.header();
  const size_t pixels = size_t(img.width) * img.height;
  std::deque<std::vector<half>> halves; // in use until the pixels are written
  Imf::FrameBuffer planes;
  for (size_t i = 0; i < img.count; i++) {
    const Imf::PixelType type = header.channels()[img.planes[i].name].type;
    const size_t size = type == Imf::HALF ? sizeof(half) : sizeof(float);
    const void *from = img.planes[i].pixels;
    if (img.planes[i].halves)
      from = img.planes[i].halves;
    else if (type == Imf::HALF) {
      halves.push_back(to_half(img.planes[i].pixels, pixels));
      from = halves.back().data();
    }
    planes.insert(img.planes[i].name,
                  Imf::Slice::Make(type, from, header.dataWindow(), size,
                                   size * img.width));
  }
  file.setFrameBuffer(planes);
  file.writePixels(int(img.height));
}

// The number of threads that compress.  The first call creates the library's
// pool of threads.
int compression_threads() {
  static const int count = [] {
    const int cpus = int(std::thread::hardware_concurrency());
    const int used = std::min(std::max(cpus, 1), 16);
    Imf::setGlobalThreadCount(used);
    return used;
  }();
  return count;
}

int write_file(const char *path, int fd, const image &img,
               const unsigned char *half, const exr_style &style,
               image_error *error) {
  const std::unique_ptr<exr_checksum, decltype(&exr_checksum_free)> checksum(
      img.key[0] ? exr_checksum_new() : nullptr, exr_checksum_free);
  if (img.key[0] && !checksum)
    return image_no_memory(error, path);
  ExrOutput stream(path, fd);
  uint64_t chunks;
  {
    Imf::OutputFile file(stream, exr_header(img, half, style),
                         compression_threads());
    chunks = stream.tellp();
    stream.hash_into(checksum.get());
    write_pixels(img, file);
  } // the destructor writes the table of chunks
  if (!stream.failure().empty())
    return image_fail(error, "%s: cannot be written: %s", path,
                      stream.failure().c_str());
  return checksum ? exr_checksum_store(checksum.get(), fd, chunks, path, error)
                  : 0;
}

} // namespace

extern "C" int exr_write_as(const char *path, const image *img,
                            const unsigned char *half, const exr_style *style,
                            image_error *error) {
  static const exr_style plain = {EXR_COMPRESSION_OF_ZIP, nullptr,
                                  EXISTING_REPLACED};
  temporary file;
  if (!style)
    style = &plain;
  if (temporary_open(path, &file, error) != 0)
    return -1;
  // closing a copy tells of errors that come late; the lock stays
  const int fd = fcntl(file.fd, F_DUPFD_CLOEXEC, 0);
  int failed = catch_exceptions(path, "written", error, [&] {
    return write_file(path, fd, *img, half, *style, error);
  });
  if (close(fd) != 0 && !failed)
    failed = image_fail(error, "%s: cannot be written: %s", path,
                        std::strerror(errno));
  if (!failed)
    return temporary_commit(&file, path, style->existing, error);
  temporary_discard(&file);
  return -1;
}

extern "C" int exr_write(const char *path, const image *img,
                         const unsigned char *half, image_error *error) {
  return exr_write_as(path, img, half, nullptr, error);
}
