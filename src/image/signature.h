/*
 * File formats, recognised by the bytes that a file begins with.
 */
#ifndef HBIL_IMAGE_SIGNATURE_H
#define HBIL_IMAGE_SIGNATURE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum file_format {
  FILE_FORMAT_OTHER = 0, /* none of those below */
  FILE_FORMAT_EXR,
  FILE_FORMAT_PNG,
  FILE_FORMAT_TIFF,
  FILE_FORMAT_HDR /* Radiance */
} file_format;

/* The number of bytes that is enough to recognise each format. */
enum { SIGNATURE_SIZE = 10 };

/* The format of a file that begins with these bytes. */
file_format signature_format(const char *start, size_t size);

/* The format of a file; FILE_FORMAT_OTHER if it cannot be read. */
file_format signature_of_file(const char *path);

#ifdef __cplusplus
}
#endif

#endif
