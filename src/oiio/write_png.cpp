#include "image/catch_exceptions.hpp"
#include "image/png_mark.h"
#include "image/temporary.h"
#include "oiio/module.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace {

// Writes to a stream: a second file of the temporary's name would lack its
// lock.
int write_file(const char *path, std::FILE *stream, const unsigned char *rgb,
               uint32_t width, uint32_t height, image_error *error) {
  OIIO::Filesystem::IOFile file(stream, OIIO::Filesystem::IOProxy::Write);
  auto out = OIIO::ImageOutput::create("png"); // goes before the proxy does
  if (!out)
    return image_fail(error, "%s: cannot be written: %s", path,
                      OIIO::geterror().c_str());
  OIIO::ImageSpec spec(int(width), int(height), 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute(PNG_MARK_NAME, PNG_MARK);
  if (!out->set_ioproxy(&file) || !out->open(path, spec) ||
      !out->write_image(OIIO::TypeDesc::UINT8, rgb) || !out->close())
    return image_fail(error, "%s: cannot be written: %s", path,
                      out->geterror().c_str());
  return 0;
}

// OpenImageIO doesn't see all errors of a stream.
int close_file(const char *path, std::FILE *stream, bool failed,
               image_error *error) {
  const bool bad = std::fflush(stream) != 0 || std::ferror(stream);
  const int why = errno;
  if ((std::fclose(stream) == 0 && !bad) || failed)
    return failed ? -1 : 0;
  return image_fail(error, "%s: cannot be written: %s", path,
                    std::strerror(bad ? why : errno));
}

} // namespace

extern "C" int oiio_write_png(const char *path, const unsigned char *rgb,
                              uint32_t width, uint32_t height,
                              existing_file existing, image_error *error) {
  temporary t;
  if (temporary_open(path, &t, error) != 0)
    return -1;
  std::FILE *stream = temporary_stream(&t);
  int failed = stream
                   ? catch_exceptions(path, "written", error,
                                      [&] {
                                        return write_file(path, stream, rgb,
                                                          width, height, error);
                                      })
                   : image_fail(error, "%s: cannot be written: %s", path,
                                std::strerror(errno));
  if (stream)
    failed = close_file(path, stream, failed != 0, error);
  if (!failed)
    return temporary_commit(&t, path, existing, error);
  temporary_discard(&t);
  return -1;
}
