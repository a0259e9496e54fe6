#include "image/catch_exceptions.hpp"
#include "image/formats.h"
#include "oiio/input.hpp"
#include "oiio/module.hpp"

#include <memory>
#include <string>

namespace {

// Opens the first image of a file, with the values as they are stored.
//
// The size is limited here, because OpenImageIO's own limit
// (limits:imagesize_MB) applies to the whole process.
std::unique_ptr<OIIO::ImageInput> open_image(const char *path,
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
          FORMATS_MAX_VALUES / uint64_t(spec.nchannels)) {
    image_fail(error,
               "%s: %d x %d pixels, %d channels; a flat image of at most %d "
               "values is needed",
               path, spec.width, spec.height, spec.nchannels,
               FORMATS_MAX_VALUES);
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
  const auto type = OIIO::TypeDesc::BASETYPE(spec.format.basetype);
  out->integers = type != OIIO::TypeDesc::FLOAT &&
                  type != OIIO::TypeDesc::HALF &&
                  type != OIIO::TypeDesc::DOUBLE;
  // Files of 8 bits that don't name their colour space are sRGB by convention.
  const std::string space = spec.get_string_attribute("oiio:ColorSpace");
  out->gamma = space == "sRGB" ||
               (space.empty() && spec.format.basetype == OIIO::TypeDesc::UINT8);
}

int read_header(const char *path, image *out, image_error *error) {
  const SilencedStderr silenced;
  auto in = open_image(path, error);
  if (!in)
    return -1;
  describe(in->spec(), out);
  for (const std::string &name : in->spec().channelnames)
    if (!image_declare(out, name.c_str()))
      return image_no_memory(error, path);
  return 0;
}

int read_plane(OIIO::ImageInput &in, const char *path, const char *name,
               image *out, image_error *error) {
  const int channel = in.spec().channelindex(name);
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

int read_planes(const char *path, const char *const *names, size_t count,
                image *out, image_error *error) {
  const SilencedStderr silenced;
  auto in = open_image(path, error);
  if (!in)
    return -1;
  describe(in->spec(), out);
  for (size_t i = 0; i < count; i++)
    if (read_plane(*in, path, names[i], out, error) != 0)
      return -1;
  return 0;
}

} // namespace

extern "C" int oiio_read_header(const char *path, image *out,
                                image_error *error) {
  *out = image{};
  const int failed = catch_exceptions(
      path, "read", error, [&] { return read_header(path, out, error); });
  if (failed)
    image_free(out);
  return failed;
}

extern "C" int oiio_read(const char *path, const char *const *names,
                         size_t count, image *out, image_error *error) {
  *out = image{};
  const int failed = catch_exceptions(path, "read", error, [&] {
    return read_planes(path, names, count, out, error);
  });
  if (failed)
    image_free(out);
  return failed;
}
