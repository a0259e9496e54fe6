// The functions of the module's table (image/formats_module.h).
#ifndef HBIL_OIIO_MODULE_HPP
#define HBIL_OIIO_MODULE_HPP

#include "image/formats_module.h"

extern "C" {

int oiio_read_header(const char *path, image *out, image_error *error);
int oiio_read(const char *path, const char *const *names, size_t count,
              image *out, image_error *error);
int oiio_read_rgb(const char *path, float **rgb, uint32_t *width,
                  uint32_t *height, image_error *error);
int oiio_write_png(const char *path, const unsigned char *rgb, uint32_t width,
                   uint32_t height, existing_file existing, image_error *error);
int oiio_draw_tile(picture *to, const picture_window *at, const picture *tile);
int oiio_draw_text(picture *to, int x, int y, int size, picture_align align,
                   const char *text);
}

#endif
