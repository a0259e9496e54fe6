#include "image/catch_exceptions.hpp"
#include "image/png_mark.h"
#include "image/temporary.h"
#include "oiio/module.hpp"

#include <OpenImageIO/imageio.h>

namespace {

int write_file(const char *path, const char *temporary,
               const unsigned char *rgb, uint32_t width, uint32_t height,
               image_error *error) {
  auto out = OIIO::ImageOutput::create("png");
  if (!out)
    return image_fail(error, "%s: cannot be written: %s", path,
                      OIIO::geterror().c_str());
  OIIO::ImageSpec spec(int(width), int(height), 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute(PNG_MARK_NAME, PNG_MARK);
  if (!out->open(temporary, spec) ||
      !out->write_image(OIIO::TypeDesc::UINT8, rgb) || !out->close())
    return image_fail(error, "%s: cannot be written: %s", path,
                      out->geterror().c_str());
  return 0;
}

} // namespace

extern "C" int oiio_write_png(const char *path, const unsigned char *rgb,
                              uint32_t width, uint32_t height,
                              image_error *error) {
  char *temporary = temporary_name(path, error);
  if (!temporary)
    return -1;
  const int failed = catch_exceptions(path, "written", error, [&] {
    return write_file(path, temporary, rgb, width, height, error);
  });
  if (!failed)
    return temporary_commit(temporary, path, error);
  temporary_discard(temporary);
  return -1;
}
