// EXR files written through OpenEXR's C++ library, which has every compression
// and uses all CPUs for it.
#include "image/guarded.h"
#include "image/image.h"
#include "image/temporary.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <deque>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

// In the order of Imf::Compression.
extern "C" const char *const exr_compressions[] = {
    "none", "rle",  "zips", "zip",  "piz",   "pxr24",
    "b44",  "b44a", "dwaa", "dwab", "input", nullptr};

static_assert(EXR_COMPRESSION_OF_ZIP == int(Imf::ZIP_COMPRESSION),
              "the list follows the library's");
static_assert(EXR_COMPRESSION_OF_INPUT == int(Imf::DWAB_COMPRESSION) + 1,
              "the list ends behind the library's");

namespace {

// A file descriptor as the library's stream.  It ignores what fails while it
// closes a file, so the first failure is kept here.
class Descriptor : public Imf::OStream {
public:
  Descriptor(const char *path, int file) : Imf::OStream(path), fd(file) {
  }
  void write(const char bytes[], int count) override {
    for (int done = 0; done < count;) {
      const ssize_t n =
          pwrite(fd, bytes + done, size_t(count - done), off_t(at));
      if (n < 0 && errno == EINTR)
        continue;
      if (n <= 0)
        fail(n < 0 ? errno : ENOSPC);
      done += int(n);
      at += uint64_t(n);
    }
  }
  uint64_t tellp() override {
    return at;
  }
  void seekp(uint64_t position) override {
    at = position;
  }
  const std::string &failure() const {
    return message;
  }

private:
  void fail(int why) {
    if (message.empty())
      message = std::strerror(why);
    throw std::runtime_error(message);
  }
  const int fd;
  uint64_t at = 0;
  std::string message;
};

// What a file says of its own storage, and what would be untrue of ours.
bool is_storage(const std::string &name) {
  static const char *const names[] = {"channels",
                                      "compression",
                                      "dataWindow",
                                      "lineOrder",
                                      "tiles",
                                      "type",
                                      "name",
                                      "version",
                                      "chunkCount",
                                      "deepImageState",
                                      "maxSamplesPerPixel",
                                      "view",
                                      "multiView",
                                      "preview",
                                      "acesImageContainerFlag",
                                      EXR_KEY};
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

// The header of a file's first part; its pixels have been read already, so it
// is not damaged.  Parsed alone: the library would read tables of chunks, too.
bool read_header(const char *path, Imf::Header &out) {
  static const char magic[4] = {0x76, 0x2f, 0x31, 0x01};
  char start[8];
  Imf::StdIFStream in(path);
  try {
    in.read(start, sizeof start);
  } catch (const std::exception &) {
    return false; // shorter than any
  }
  if (std::memcmp(start, magic, sizeof magic) != 0)
    return false;
  int version = 0;
  for (int i = 0; i < 4; i++)
    version |= int((unsigned char)(start[4 + i])) << 8 * i;
  out.readFrom(in, version);
  return true;
}

Imath::Box2i box(const image_window &w) {
  return {{w.x, w.y}, {w.x + int(w.width) - 1, w.y + int(w.height) - 1}};
}

Imath::Box2i data_window(const image &img) {
  return box(image_data_window(&img));
}

Imf::M44fAttribute matrix(const double m[16]) {
  Imath::M44f out;
  for (int i = 0; i < 16; i++)
    out[i / 4][i % 4] = float(m[i]);
  return Imf::M44fAttribute(out);
}

void take_attributes(const exr_style &style, Imf::Header &header) {
  Imf::Header like;
  if (!style.like || !read_header(style.like, like))
    return;
  for (auto i = like.begin(); i != like.end(); ++i)
    if (!is_storage(i.name()))
      header.insert(i.name(), i.attribute());
  if (style.compression == EXR_COMPRESSION_OF_INPUT)
    header.compression() = like.compression();
}

Imf::PixelType type_of(const image &img, const unsigned char *half, size_t i) {
  if ((half && half[i]) || img.planes[i].type == IMAGE_HALF)
    return Imf::HALF;
  return img.planes[i].type == IMAGE_UINT ? Imf::UINT : Imf::FLOAT;
}

Imf::Header make_header(const image &img, const unsigned char *half,
                        const exr_style &style) {
  const Imath::Box2i window = data_window(img);
  Imf::Header header(window, window);
  const image_matrices &m = img.matrices;
  header.compression() = style.compression == EXR_COMPRESSION_OF_INPUT
                             ? Imf::ZIP_COMPRESSION
                             : Imf::Compression(style.compression);
  take_attributes(style, header);
  header.displayWindow() = box(image_display_window(&img));
  if (m.has_camera)
    header.insert("worldToCamera", matrix(m.world_to_camera));
  if (m.has_ndc)
    header.insert("worldToNDC", matrix(m.world_to_ndc));
  if (img.key[0])
    header.insert(EXR_KEY, Imf::StringAttribute(img.key));
  for (size_t i = 0; i < img.count; i++)
    header.channels().insert(img.planes[i].name, type_of(img, half, i));
  return header;
}

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

void write_pixels(const image &img, const unsigned char *half_planes,
                  Imf::OutputFile &file) {
  const size_t pixels = size_t(img.width) * img.height;
  const Imath::Box2i window = data_window(img);
  std::deque<std::vector<half>> halves; // until they are written
  Imf::FrameBuffer planes;
  for (size_t i = 0; i < img.count; i++) {
    const Imf::PixelType type = type_of(img, half_planes, i);
    const size_t size = type == Imf::HALF ? sizeof(half) : sizeof(float);
    const void *from = img.planes[i].pixels;
    if (type == Imf::HALF) {
      halves.push_back(to_half(img.planes[i].pixels, pixels));
      from = halves.back().data();
    }
    planes.insert(img.planes[i].name,
                  Imf::Slice::Make(type, from, window, size, size * img.width));
  }
  file.setFrameBuffer(planes);
  file.writePixels(int(img.height));
}

// Threads that compress; the pool is the library's own.
int threads() {
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
  const Imf::Header header = make_header(img, half, style);
  Descriptor stream(path, fd);
  {
    Imf::OutputFile file(stream, header, threads());
    write_pixels(img, half, file);
  }
  if (stream.failure().empty())
    return 0;
  return image_fail(error, "%s: cannot be written: %s", path,
                    stream.failure().c_str());
}

} // namespace

extern "C" int exr_write_as(const char *path, const image *img,
                            const unsigned char *half, const exr_style *style,
                            image_error *error) {
  static const exr_style plain = {EXR_COMPRESSION_OF_ZIP, nullptr};
  char *temporary = temporary_name(path, error);
  if (!temporary)
    return -1;
  const int fd = open(temporary, O_RDWR | O_CREAT | O_TRUNC, 0666);
  if (fd < 0) {
    image_fail(error, "%s: cannot be written: %s", path, std::strerror(errno));
    std::free(temporary);
    return -1;
  }
  int failed = guarded(path, "written", error, [&] {
    return write_file(path, fd, *img, half, style ? *style : plain, error);
  });
  if (close(fd) != 0 && !failed)
    failed = image_fail(error, "%s: cannot be written: %s", path,
                        std::strerror(errno));
  if (!failed)
    return temporary_commit(temporary, path, error);
  temporary_discard(temporary);
  return -1;
}

extern "C" int exr_write(const char *path, const image *img,
                         const unsigned char *half, image_error *error) {
  return exr_write_as(path, img, half, nullptr, error);
}
