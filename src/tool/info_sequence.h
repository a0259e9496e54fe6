/* What hbil info says of several files: whether they are one job's frames. */
#ifndef HBIL_TOOL_INFO_SEQUENCE_H
#define HBIL_TOOL_INFO_SEQUENCE_H

#include "image/error.h"
#include "tool/extent.h"

/* The files that hbil process can use. */
typedef struct usable {
  extent_picture *pictures; /* their maps are those of `maps` */
  channel_map *maps;        /* owned */
  size_t count;
} usable;

/* Prints the radiance cache that one job would have for all of the files, and
 * before it, if told is 1, what they are.  Returns 0, or -1 with `error` filled
 * if one job can't have all of them. */
int info_sequence_print(const usable *all, int told, image_error *error);

#endif
