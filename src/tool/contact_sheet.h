/* Frames and their layers side by side in one picture: layers in columns, at
 * most eight frames in rows. */
#ifndef HBIL_TOOL_CONTACT_SHEET_H
#define HBIL_TOOL_CONTACT_SHEET_H

#include "tool/tool.h"

typedef struct contact_sheet {
  unsigned layers; /* bit mask */
  size_t frames;   /* of the whole sequence */
  size_t row;      /* that comes next */
  uint32_t tile_width, tile_height;
  picture picture;
  int unlabelled; /* there is no font */
} contact_sheet;

/* 0, or -1 when out of memory. */
int contact_sheet_open(contact_sheet *s, unsigned layers, size_t frames,
                       uint32_t width, uint32_t height);
void contact_sheet_close(contact_sheet *s);
/* Whether this frame has a row, which comes next. */
int contact_sheet_shows(const contact_sheet *s, size_t frame);
/* The layers of that frame, tone-mapped with this exposure.  0, or -1 when out
 * of memory. */
int contact_sheet_add(contact_sheet *s, const char *name, const image *result,
                      float exposure);

#endif
