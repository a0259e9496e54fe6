/* Reads the frames of a job. */
#ifndef HBIL_TOOL_FRAME_SOURCE_H
#define HBIL_TOOL_FRAME_SOURCE_H

#include "dump/gbuffer.h"
#include "tool/first_frame.h"
#include "tool/job.h"
#include "image/error.h"
#include "image/image.h"

typedef struct frame_source {
  const job *job;
  first_frame *first; /* which may be there already */
  int warned; /* 1: a frame's mistakes were told; other frames are alike */
} frame_source;

/* Reads the planes that the computation uses, and warns if they don't fit
 * together.  Frames are read one after the other.  Returns 0 and a G-buffer
 * that gbuffer_free() frees, or -1 with `error` filled. */
int frame_source_read(frame_source *s, size_t item, gbuffer *out,
                      image_error *error);

/* Reads the frame's channels that no layer of the result replaces, in their own
 * types.  Returns 0 and an image that image_free() frees, or -1. */
int frame_source_read_copied(const frame_source *s, size_t item, image *out,
                             image_error *error);

#endif
