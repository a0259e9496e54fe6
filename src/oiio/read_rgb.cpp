#include "image/catch_exceptions.hpp"
#include "image/exr_rgb.h"
#include "oiio/input.hpp"
#include "oiio/module.hpp"

#include <cstdlib>
#include <memory>

namespace {

bool read_pixels(OIIO::ImageInput &in, float *rgb) {
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
  const SilencedStderr silenced;
  auto in = OIIO::ImageInput::open(path);
  if (!in)
    return image_fail(error,
                      "%s: cannot be read: %s; an image that "
                      "OpenImageIO reads is needed",
                      path, OIIO::geterror().c_str());
  const OIIO::ImageSpec &spec = in->spec();
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.deep ||
      spec.nchannels < 1 ||
      uint64_t(spec.width) > RGB_MAX_PIXELS / uint64_t(spec.height))
    return image_fail(error,
                      "%s: %d x %d x %d pixels; a flat image of at most "
                      "%d pixels is needed",
                      path, spec.width, spec.height, spec.depth,
                      RGB_MAX_PIXELS);
  const size_t pixels = size_t(spec.width) * size_t(spec.height);
  std::unique_ptr<float, void (*)(void *)> out(
      static_cast<float *>(std::calloc(3 * pixels, sizeof(float))), std::free);
  if (!out)
    return image_no_memory(error, path);
  if (!read_pixels(*in, out.get()))
    return image_fail(error,
                      "%s: truncated or damaged: %s; a complete image "
                      "is needed",
                      path, in->geterror().c_str());
  *width = uint32_t(spec.width);
  *height = uint32_t(spec.height);
  *rgb = out.release();
  return 0;
}

} // namespace

extern "C" int oiio_read_rgb(const char *path, float **rgb, uint32_t *width,
                             uint32_t *height, image_error *error) {
  *rgb = nullptr;
  return catch_exceptions(path, "read", error, [&] {
    return read_file(path, rgb, width, height, error);
  });
}
