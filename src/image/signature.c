/* The libraries offer no single test for these formats: exr_test_file_header()
 * and Imf::isOpenExrFile() know OpenEXR only, and OpenImageIO tries all of its
 * readers, video decoders included. */
#include "image/signature.h"
#include "image/regular_file.h"

#include <stdio.h>
#include <string.h>

static const struct {
  const char *bytes;
  size_t size;
  file_format format;
} signatures[] = {
    {"\x76\x2f\x31\x01", 4, FILE_FORMAT_EXR}, {"\x89PNG", 4, FILE_FORMAT_PNG},
    {"II*\0", 4, FILE_FORMAT_TIFF}, /* little-endian */
    {"MM\0*", 4, FILE_FORMAT_TIFF}, /* big-endian */
    {"#?RADIANCE", 10, FILE_FORMAT_HDR},      {"#?RGBE", 6, FILE_FORMAT_HDR},
};

file_format signature_format(const char *start, size_t size) {
  for (size_t i = 0; i < sizeof signatures / sizeof *signatures; i++)
    if (size >= signatures[i].size &&
        memcmp(start, signatures[i].bytes, signatures[i].size) == 0)
      return signatures[i].format;
  return FILE_FORMAT_OTHER;
}

file_format signature_of_file(const char *path) {
  char start[SIGNATURE_SIZE];
  const char *why;
  FILE *file = regular_file_stream(path, &why);
  if (!file)
    return FILE_FORMAT_OTHER;
  const size_t size = fread(start, 1, sizeof start, file);
  fclose(file);
  return signature_format(start, size);
}
