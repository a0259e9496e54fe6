#define _DEFAULT_SOURCE 1 /* madvise() */
#include "image/image_memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* Bytes: of a huge page, which saves the kernel most page faults and others
 * lookups of addresses, of a page, which lets every OpenCL driver for CPUs use
 * the memory itself, and of a cache line for planes. */
enum { HUGE_PAGE = 2 << 20, PAGE = 4096, LINE = 64 };

static _Thread_local image_memory *selected;

static size_t round_up(size_t size, size_t unit) {
  return (size + unit - 1) / unit * unit;
}

size_t image_memory_plane(size_t bytes) {
  return round_up(bytes, LINE);
}

void image_memory_empty(image_memory *m, size_t size) {
  m->used = 0;
  if (size <= m->size)
    return;
  const size_t unit = size < HUGE_PAGE ? PAGE : HUGE_PAGE;
  free(m->bytes);
  m->size = round_up(size, unit);
  m->bytes = aligned_alloc(unit, m->size);
  if (!m->bytes)
    m->size = 0;
#ifdef MADV_HUGEPAGE
  else if (unit == HUGE_PAGE) /* if it fails, pages are small */
    (void)madvise(m->bytes, m->size, MADV_HUGEPAGE);
#endif
}

void image_memory_free(image_memory *m) {
  free(m->bytes);
  memset(m, 0, sizeof *m);
}

void image_memory_select(image_memory *m) {
  selected = m;
}

void *image_memory_take(size_t bytes) {
  const size_t room = image_memory_plane(bytes);
  if (!selected || !bytes || room > selected->size - selected->used)
    return NULL;
  void *plane = selected->bytes + selected->used;
  selected->used += room;
  return plane;
}

void image_memory_move(image *img) {
  const size_t bytes = sizeof(float) * img->width * img->height;
  for (size_t i = 0; i < img->count; i++) {
    image_plane *plane = &img->planes[i];
    float *to =
        plane->pixels && !plane->is_lent ? image_memory_take(bytes) : NULL;
    if (!to)
      continue;
    memcpy(to, plane->pixels, bytes);
    free(plane->pixels);
    plane->pixels = to;
    plane->is_lent = 1;
  }
}
