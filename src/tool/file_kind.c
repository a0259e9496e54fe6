/* What a file is that lies where another one is to be written. */
#define _POSIX_C_SOURCE 200809L
#include "tool/file_kind.h"

#include "image/exr_read.h"
#include "image/png_mark.h"
#include "image/regular_file.h"
#include "image/signature.h"
#include "tool/cache_file.h"
#include "tool/job_key.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* So many bytes of zeros at its beginning show that a file is blank.  File
 * systems leave such files, or empty ones, where power failed before the bytes
 * had reached the disk. */
enum { LOOKED_AT = 4096 };

static int is_blank(const char *path) {
  unsigned char start[LOOKED_AT];
  const char *why;
  FILE *file = regular_file_stream(path, &why);
  if (!file)
    return 0;
  const size_t size = fread(start, 1, sizeof start, file);
  int blank = !ferror(file);
  for (size_t i = 0; i < size && blank; i++)
    blank = start[i] == 0;
  fclose(file);
  return blank;
}

static file_kind kind_of_exr(const char *path) {
  image header;
  if (exr_read_header(path, &header, NULL) != 0)
    return FILE_OTHER;
  const file_kind kind = job_key_is_valid(header.key)             ? FILE_RESULT
                         : strcmp(header.key, FILE_DEMO_KEY) == 0 ? FILE_DEMO
                                                                  : FILE_OTHER;
  image_free(&header);
  return kind;
}

file_kind file_kind_of(const char *path) {
  struct stat info;
  if (stat(path, &info) != 0)
    return errno == ENOENT || errno == ENOTDIR ? FILE_ABSENT : FILE_OTHER;
  if (!S_ISREG(info.st_mode))
    return FILE_IRREGULAR;
  switch (signature_of_file(path)) {
  case FILE_FORMAT_EXR:
    return kind_of_exr(path);
  case FILE_FORMAT_PNG:
    return png_look(path).marked ? FILE_PICTURE : FILE_OTHER;
  default:
    return cache_file_recognise(path) ? FILE_CACHE
           : is_blank(path)           ? FILE_BLANK
                                      : FILE_OTHER;
  }
}

const char *file_kind_name(file_kind kind) {
  switch (kind) {
  case FILE_RESULT:
    return "a result of hbil";
  case FILE_DEMO:
    return "a G-buffer of hbil demo";
  case FILE_PICTURE:
    return "a picture that hbil wrote";
  case FILE_CACHE:
    return "a radiance cache";
  default:
    return "a file of hbil";
  }
}
