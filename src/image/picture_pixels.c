/* Pictures of 8 bits; what is drawn into them is drawn by the module of
 * formats_module.h. */
#include "image/picture.h"
#include "image/formats_module.h"

#include <stdlib.h>
#include <string.h>

int picture_new(uint32_t width, uint32_t height, picture *out) {
  const size_t bytes = (size_t)3 * width * height;
  *out = (picture){width, height, malloc(bytes ? bytes : 1)};
  if (out->rgb)
    memset(out->rgb, PICTURE_GREY, bytes);
  return out->rgb ? 0 : -1;
}

void picture_free(picture *p) {
  free(p->rgb);
  memset(p, 0, sizeof *p);
}

int picture_tile(picture *to, const picture_window *at, const picture *tile) {
  const formats_table *module = formats_module(NULL);
  return module ? module->draw_tile(to, at, tile) : -1;
}

int picture_text(picture *to, int x, int y, int size, picture_align align,
                 const char *text) {
  const formats_table *module = formats_module(NULL);
  return module ? module->draw_text(to, x, y, size, align, text) : -1;
}
