// PNG, every image that OpenImageIO reads, and DWA through OpenEXR's C++
// library, behind C interfaces.  No exception leaves this file.
#include "image/exr_dwa.h"
#include "image/exr_rgb.h"
#include "image/guarded.h"
#include "image/image.h"
#include "image/temporary.h"

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenImageIO/imageio.h>

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

namespace {

// libpng, libjpeg and libtiff tell standard error what is wrong, too; the
// tool's own line is enough.
class Silence {
public:
  Silence() : standard(dup(STDERR_FILENO)) {
    const int nowhere = open("/dev/null", O_WRONLY);
    if (standard >= 0 && nowhere >= 0)
      dup2(nowhere, STDERR_FILENO);
    if (nowhere >= 0)
      close(nowhere);
  }
  ~Silence() {
    if (standard >= 0) {
      dup2(standard, STDERR_FILENO);
      close(standard);
    }
  }
  Silence(const Silence &) = delete;
  Silence &operator=(const Silence &) = delete;

private:
  const int standard;
};

int write_png(const char *path, const char *temporary, const unsigned char *rgb,
              uint32_t width, uint32_t height, image_error *error) {
  auto out = OIIO::ImageOutput::create("png");
  if (!out)
    return image_fail(error, "%s: cannot be written: %s", path,
                      OIIO::geterror().c_str());
  OIIO::ImageSpec spec(int(width), int(height), 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  if (!out->open(temporary, spec) ||
      !out->write_image(OIIO::TypeDesc::UINT8, rgb) || !out->close())
    return image_fail(error, "%s: cannot be written: %s", path,
                      out->geterror().c_str());
  return 0;
}

// Channels from begin to end, `stride` floats from pixel to pixel. Of a TIFF
// that breaks off OpenImageIO says so, and that it was read.
bool read_channels(OIIO::ImageInput &in, int begin, int end, float *out,
                   size_t stride) {
  return in.read_image(0, 0, begin, end, OIIO::TypeDesc::FLOAT, out,
                       OIIO::stride_t(stride * sizeof(float))) &&
         !in.has_error();
}

bool read_rgb(OIIO::ImageInput &in, float *rgb) {
  const OIIO::ImageSpec &spec = in.spec();
  const int channels = spec.nchannels < 3 ? 1 : 3;
  if (!read_channels(in, 0, channels, rgb, 3))
    return false;
  const size_t pixels = size_t(spec.width) * size_t(spec.height);
  for (size_t i = 0; channels == 1 && i < pixels; i++)
    rgb[3 * i + 1] = rgb[3 * i + 2] = rgb[3 * i];
  return true;
}

int read_file(const char *path, float **rgb, uint32_t *width, uint32_t *height,
              image_error *error) {
  const Silence silence;
  auto in = OIIO::ImageInput::open(path);
  if (!in)
    return image_fail(error,
                      "%s: cannot be read: %s; an image that "
                      "OpenImageIO reads is needed",
                      path, OIIO::geterror().c_str());
  const OIIO::ImageSpec &spec = in->spec();
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.deep ||
      spec.nchannels < 1 ||
      uint64_t(spec.width) > IMAGE_MAP_PIXELS / uint64_t(spec.height))
    return image_fail(error,
                      "%s: %d x %d x %d pixels; a flat image of at most "
                      "%d pixels is needed",
                      path, spec.width, spec.height, spec.depth,
                      IMAGE_MAP_PIXELS);
  const size_t pixels = size_t(spec.width) * size_t(spec.height);
  std::unique_ptr<float, void (*)(void *)> out(
      static_cast<float *>(std::calloc(3 * pixels, sizeof(float))), std::free);
  if (!out)
    return image_no_memory(error, path);
  if (!read_rgb(*in, out.get()))
    return image_fail(error,
                      "%s: truncated or damaged: %s; a complete image "
                      "is needed",
                      path, in->geterror().c_str());
  *width = uint32_t(spec.width);
  *height = uint32_t(spec.height);
  *rgb = out.release();
  return 0;
}

// The first image of a file, as it is stored: colours stay encoded, alpha stays
// what it is.
std::unique_ptr<OIIO::ImageInput> open_planes(const char *path,
                                              image_error *error) {
  OIIO::ImageSpec as_stored;
  as_stored.attribute("oiio:UnassociatedAlpha", 1);
  auto in = OIIO::ImageInput::open(path, &as_stored);
  if (!in) {
    image_fail(error, "%s: cannot be read: %s; a whole file is needed", path,
               OIIO::geterror().c_str());
    return nullptr;
  }
  const OIIO::ImageSpec &spec = in->spec();
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.deep ||
      spec.nchannels < 1 ||
      uint64_t(spec.width) * uint64_t(spec.height) >
          IMAGE_MAP_PIXELS / uint64_t(spec.nchannels)) {
    image_fail(error,
               "%s: %d x %d pixels, %d channels; a flat image of at most %d "
               "values is needed",
               path, spec.width, spec.height, spec.nchannels, IMAGE_MAP_PIXELS);
    return nullptr;
  }
  return in;
}

void describe(const OIIO::ImageSpec &spec, image *out) {
  *out = image{};
  out->x = spec.x;
  out->y = spec.y;
  out->width = uint32_t(spec.width);
  out->height = uint32_t(spec.height);
  if (spec.full_width > 0 && spec.full_height > 0)
    out->display = {spec.full_x, spec.full_y, uint32_t(spec.full_width),
                    uint32_t(spec.full_height)};
  // Eight bits without a word about them are sRGB, by all habits.
  const std::string space = spec.get_string_attribute("oiio:ColorSpace");
  out->gamma = space == "sRGB" ||
               (space.empty() && spec.format.basetype == OIIO::TypeDesc::UINT8);
}

int list_planes(const char *path, image *out, image_error *error) {
  const Silence silence;
  auto in = open_planes(path, error);
  if (!in)
    return -1;
  describe(in->spec(), out);
  for (const std::string &name : in->spec().channelnames)
    if (!image_declare(out, name.c_str()))
      return image_no_memory(error, path);
  return 0;
}

int take_plane(OIIO::ImageInput &in, const char *path, const char *name,
               image *out, image_error *error) {
  const OIIO::ImageSpec &spec = in.spec();
  const int channel = spec.channelindex(name);
  if (image_find(out, name))
    return 0;
  if (channel < 0)
    return image_fail(error, "%s: has no channel %s (see hbil info)", path,
                      name);
  const image_plane *plane = image_add(out, name);
  if (!plane)
    return image_no_memory(error, path);
  if (!read_channels(in, channel, channel + 1, plane->pixels, 1))
    return image_fail(error,
                      "%s: truncated or damaged: %s; a complete image is "
                      "needed",
                      path, in.geterror().c_str());
  return 0;
}

int take_planes(const char *path, const char *const *names, size_t count,
                image *out, image_error *error) {
  const Silence silence;
  auto in = open_planes(path, error);
  if (!in)
    return -1;
  describe(in->spec(), out);
  for (size_t i = 0; i < count; i++)
    if (take_plane(*in, path, names[i], out, error) != 0)
      return -1;
  return 0;
}

// Planes of one part, straight from OpenEXR's C++ library.
int read_part(const char *path, int part, uint32_t width, uint32_t height,
              const exr_target *targets, size_t count, image_error *error) {
  Imf::MultiPartInputFile file(path, 0); // threads would hold a chunk each
  Imf::InputPart in(file, part);
  const Imath::Box2i window = in.header().dataWindow();
  Imf::FrameBuffer planes;
  for (size_t i = 0; i < count; i++)
    planes.insert(targets[i].channel,
                  Imf::Slice::Make(targets[i].integers ? Imf::UINT : Imf::FLOAT,
                                   targets[i].pixels, window, sizeof(float),
                                   sizeof(float) * width));
  if (window.size() != Imath::V2i(int(width) - 1, int(height) - 1))
    return image_fail(error,
                      "%s: two readers see two sizes; a complete file "
                      "is needed",
                      path);
  in.setFrameBuffer(planes);
  in.readPixels(window.min.y, window.max.y);
  return 0;
}

} // namespace

extern "C" int exr_dwa_read(const char *path, int part, uint32_t width,
                            uint32_t height, const exr_target *targets,
                            size_t count, image_error *error) {
  return guarded(path, "read", error, [&] {
    return read_part(path, part, width, height, targets, count, error);
  });
}

extern "C" int png_write(const char *path, const unsigned char *rgb,
                         uint32_t width, uint32_t height, image_error *error) {
  char *temporary = temporary_name(path, error);
  if (!temporary)
    return -1;
  const int failed = guarded(path, "written", error, [&] {
    return write_png(path, temporary, rgb, width, height, error);
  });
  if (!failed)
    return temporary_commit(temporary, path, error);
  temporary_discard(temporary);
  return -1;
}

extern "C" int formats_recognise(const char *path) {
  static const std::string starts[] = {"\x89PNG", std::string("II*\0", 4),
                                       std::string("MM\0*", 4), "#?RADIANCE",
                                       "#?RGBE"};
  char start[10] = "";
  FILE *file = std::fopen(path, "rb");
  if (!file)
    return 0;
  const size_t read = std::fread(start, 1, sizeof start, file);
  std::fclose(file);
  for (const std::string &s : starts)
    if (read >= s.size() && s.compare(0, s.size(), start, s.size()) == 0)
      return 1;
  return 0;
}

extern "C" int formats_read_header(const char *path, image *out,
                                   image_error *error) {
  *out = image{};
  const int failed = guarded(path, "read", error,
                             [&] { return list_planes(path, out, error); });
  if (failed)
    image_free(out);
  return failed;
}

extern "C" int formats_read(const char *path, const char *const *names,
                            size_t count, image *out, image_error *error) {
  *out = image{};
  const int failed = guarded(path, "read", error, [&] {
    return take_planes(path, names, count, out, error);
  });
  if (failed)
    image_free(out);
  return failed;
}

extern "C" int formats_read_rgb(const char *path, float **rgb, uint32_t *width,
                                uint32_t *height, image_error *error) {
  *rgb = nullptr;
  if (exr_recognise(path))
    return exr_read_rgb(path, rgb, width, height, error);
  return guarded(path, "read", error,
                 [&] { return read_file(path, rgb, width, height, error); });
}
