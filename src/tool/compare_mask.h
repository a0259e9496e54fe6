/* Which pixels `hbil compare` compares: the surfaces of a G-buffer. */
#ifndef HBIL_TOOL_COMPARE_MASK_H
#define HBIL_TOOL_COMPARE_MASK_H

#include "dump/gbuffer.h"
#include "image/error.h"
#include "image/image.h"

typedef struct compare_mask {
  gbuffer g;  /* without planes, all pixels are compared */
  int albedo; /* 1: black surfaces are not compared either */
} compare_mask;

/* Reads the G-buffer `path`; NULL compares all pixels.  like: an image of the
 * size that it must have.  Returns 0, or -1 with `error` filled;
 * compare_mask_free() frees it in both cases. */
int compare_mask_read(const char *path, int albedo, const image *like,
                      compare_mask *out, image_error *error);
void compare_mask_free(compare_mask *m);

/* The mask of one channel; the planes are the G-buffer's own or NULL. */
typedef struct channel_mask {
  const float *depth, *albedo;
} channel_mask;

/* letter: the last part of the channel's name. */
channel_mask compare_mask_channel(const compare_mask *m, const char *letter);

/* Whether pixel i of the channel is compared. */
int channel_mask_has(const channel_mask *m, size_t i);

#endif
