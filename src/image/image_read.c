#include "image/image_read.h"
#include "image/exr_read.h"
#include "image/formats.h"
#include "image/signature.h"

/* What is not recognised goes to the EXR reader, which says what is needed. */
static int is_other_format(const char *path) {
  const file_format format = signature_of_file(path);
  return format == FILE_FORMAT_PNG || format == FILE_FORMAT_TIFF ||
         format == FILE_FORMAT_HDR;
}

int image_read_header(const char *path, image *out, image_error *error) {
  return is_other_format(path) ? formats_read_header(path, out, error)
                               : exr_read_header(path, out, error);
}

int image_read(const char *path, const char *const *names, size_t count,
               image *out, image_error *error) {
  return is_other_format(path) ? formats_read(path, names, count, out, error)
                               : exr_read(path, names, count, out, error);
}
