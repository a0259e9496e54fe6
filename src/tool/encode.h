/* Writes what a job makes of a frame: the result, its previews and its row of
 * the contact sheet. */
#ifndef HBIL_TOOL_ENCODE_H
#define HBIL_TOOL_ENCODE_H

#include "tool/contact_sheet.h"
#include "tool/report.h"
#include "tool/resume.h"
#include "image/error.h"
#include "image/image.h"

typedef struct encoder {
  const job *whole; /* of all places; set before encoder_begin() */
  const job *job;   /* of the place whose frames come; NULL: none yet */
  resume *resume;   /* its exposure is set here */
  contact_sheet sheet;
  progress progress;
  int lines;           /* 1: a line for each frame, even on a terminal */
  size_t needed, done; /* frames that are computed */
  size_t clipped[LAYER_COUNT]; /* pixels whose light half floats can't hold */
} encoder;

/* Before the first frame of a place.  0, or -1 with `error` filled. */
int encoder_begin(encoder *e, const job *j, resume *r, image_error *error);

/*
 * Writes the files of a frame, unless they exist, and prints its line.  result:
 * its layers, if it was computed; else only its row of the contact sheet is
 * made, from the file.  copied: channels that are added to the file; freed.
 * Frames come in order.  0, or -1 with `error` filled.
 */
int encode_frame(encoder *e, size_t item, image *result, image *copied,
                 image_error *error);

/* Whether the contact sheet has tiles of the radiance cache.  Fills those of a
 * place, after its last frame: bytes are what hbil_cache_save() gives.  0, or
 * -1 with `error` filled. */
int encoder_shows_cache(const encoder *e);
int encoder_show_cache(encoder *e, const void *bytes, size_t size,
                       image_error *error);

/* After the last frame: writes the contact sheet.  0, or -1. */
int encoder_finish(encoder *e, image_error *error);

void encoder_close(encoder *e);

#endif
