/* Pictures side by side: layers of frames, and what a radiance cache knows. */
#ifndef HBIL_TOOL_CONTACT_SHEET_H
#define HBIL_TOOL_CONTACT_SHEET_H

#include "exact/saved_cache.h"
#include "image/image.h"
#include "image/picture.h"
#include "image/window.h"
#include "tool/job.h"
#include "tool/layers.h"

#include <stddef.h>
#include <stdint.h>

/* ------------------------------------------------------------------------ */
/* What a radiance cache knows                                               */

/*
 * Makes a picture of the pixels of f that are in `shown`, width x height pixels
 * large: the radiance of the voxel that a pixel's ray meets, tone-mapped with
 * this exposure; grey where it leaves the cache through what views have seen;
 * dark stripes where it passes through what no view has seen.  0, or -1 if
 * memory runs out.
 */
int cache_picture(const exact_saved_cache *cache, const job_frame *f,
                  const image_window *shown, uint32_t width, uint32_t height,
                  float exposure, picture *out);

/* ------------------------------------------------------------------------ */
/* The sheet                                                                 */

typedef struct contact_sheet {
  unsigned layers; /* a set (layers.h) */
  int cache;       /* 1: the last tile shows the radiance cache */
  size_t frames;   /* of the whole sequence */
  size_t row;      /* that comes next */
  uint32_t tile_width, tile_height;
  picture picture;
  int unlabelled; /* 1: there is no font */
} contact_sheet;

/* width, height: pixels of a frame.  0, or -1 if memory runs out. */
int contact_sheet_open(contact_sheet *s, unsigned layers, int cache,
                       size_t frames, uint32_t width, uint32_t height);

/* It may be called on a zeroed sheet. */
void contact_sheet_close(contact_sheet *s);

/* Whether this frame fills the row that comes next. */
int contact_sheet_shows(const contact_sheet *s, size_t frame);

/* Adds a row with the frame's layers, tone-mapped with this exposure.  0, or -1
 * if memory runs out. */
int contact_sheet_add(contact_sheet *s, const char *name, const image *result,
                      float exposure);

/* The rows so far, and the frame that each shows. */
size_t contact_sheet_rows(const contact_sheet *s);
size_t contact_sheet_frame(const contact_sheet *s, size_t row);

/* Fills a row's tile of the radiance cache.  0, or -1 if memory runs out. */
int contact_sheet_add_cache(contact_sheet *s, size_t row, const picture *tile);

#endif
