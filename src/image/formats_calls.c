/* PNG, TIFF and Radiance HDR, by the module of formats_module.h. */
#include "image/formats.h"
#include "image/exr_rgb.h"
#include "image/formats_module.h"
#include "image/formats_rgb.h"
#include "image/png_write.h"
#include "image/regular_file.h"
#include "image/signature.h"

#include <string.h>
#include <unistd.h>

int formats_check(image_error *error) {
  return formats_module(error) ? 0 : -1;
}

int formats_read_header(const char *path, image *out, image_error *error) {
  const formats_table *module = formats_module(error);
  memset(out, 0, sizeof *out);
  return module ? module->read_header(path, out, error) : -1;
}

int formats_read(const char *path, const char *const *names, size_t count,
                 image *out, image_error *error) {
  const formats_table *module = formats_module(error);
  memset(out, 0, sizeof *out);
  return module ? module->read(path, names, count, out, error) : -1;
}

/* OpenImageIO opens whatever has a name. */
static int check_regular(const char *path, image_error *error) {
  const char *why;
  const int fd = regular_file_open(path, &why);
  if (fd < 0)
    return image_fail(error,
                      "%s: cannot be read: %s; an image that OpenImageIO reads "
                      "is needed",
                      path, why);
  close(fd);
  return 0;
}

int formats_read_rgb(const char *path, float **rgb, uint32_t *width,
                     uint32_t *height, image_error *error) {
  *rgb = NULL;
  if (signature_of_file(path) == FILE_FORMAT_EXR)
    return exr_read_rgb(path, rgb, width, height, error);
  if (check_regular(path, error) != 0)
    return -1;
  const formats_table *module = formats_module(error);
  return module ? module->read_rgb(path, rgb, width, height, error) : -1;
}

int png_write(const char *path, const unsigned char *rgb, uint32_t width,
              uint32_t height, existing_file existing, image_error *error) {
  const formats_table *module = formats_module(error);
  return module ? module->write_png(path, rgb, width, height, existing, error)
                : -1;
}
