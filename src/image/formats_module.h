/*
 * The module that knows PNG, TIFF and Radiance HDR, through OpenImageIO
 * (src/oiio).  OpenImageIO and the 250 libraries behind it take longer to load
 * than the rest of the program to run on a small file, so the module is loaded
 * at first use.
 */
#ifndef HBIL_IMAGE_FORMATS_MODULE_H
#define HBIL_IMAGE_FORMATS_MODULE_H

#include "image/error.h"
#include "image/image.h"
#include "image/picture.h"
#include "image/temporary.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What the module does.  The functions are documented in formats.h,
 * formats_rgb.h, png_write.h and picture.h. */
typedef struct formats_table {
  const char *version; /* of the package that the module was built with */
  int (*read_header)(const char *path, image *out, image_error *error);
  int (*read)(const char *path, const char *const *names, size_t count,
              image *out, image_error *error);
  int (*read_rgb)(const char *path, float **rgb, uint32_t *width,
                  uint32_t *height, image_error *error);
  int (*write_png)(const char *path, const unsigned char *rgb, uint32_t width,
                   uint32_t height, existing_file existing, image_error *error);
  int (*draw_tile)(picture *to, const picture_window *at, const picture *tile);
  int (*draw_text)(picture *to, int x, int y, int size, picture_align align,
                   const char *text);
} formats_table;

/* The module's one symbol. */
extern const formats_table hbil_formats;

/* Returns the module's table, or NULL with `error` filled if there is no such
 * module.  Any thread may call it. */
const formats_table *formats_module(image_error *error);

#ifdef __cplusplus
}
#endif

#endif
