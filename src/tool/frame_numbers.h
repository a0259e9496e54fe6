/* Lists of frame numbers. */
#ifndef HBIL_TOOL_FRAME_NUMBERS_H
#define HBIL_TOOL_FRAME_NUMBERS_H

#include "image/error.h"

#include <stddef.h>

/* Numbers have at most seven digits. */
enum { FRAME_DIGITS = 7, FRAME_LAST = 9999999, FRAMES_MOST = 1000000 };

typedef struct frame_numbers {
  unsigned *values; /* owned */
  size_t count, room;
} frame_numbers;

/* Appends a number.  0, or -1 if memory runs out. */
int frame_numbers_add(frame_numbers *n, unsigned value);

void frame_numbers_sort(frame_numbers *n);

/* It may be called on a zeroed list. */
void frame_numbers_free(frame_numbers *n);

/* Reads the digits at *next, which moves behind them.  -1 if there are none or
 * too many. */
int frame_number_read(const char **next, unsigned *out);

/* Reads the value of --frames, such as "1-240x2,300", into a zeroed list.  0,
 * or -1 with `error` filled. */
int frame_numbers_read(const char *text, frame_numbers *out,
                       image_error *error);

/* "5, 17-19 and 12 more". */
void frame_numbers_name(const frame_numbers *n, char *text, size_t size);

#endif
