/* Prints how long a job took and what was skipped: as a table, or as JSON. */
#ifndef HBIL_TOOL_TIMINGS_H
#define HBIL_TOOL_TIMINGS_H

#include "image/error.h"
#include "tool/pipeline.h"
#include "tool/sequence.h"

#include <stdint.h>
#include <stdio.h>

/* The parts of a job, one after the other. */
typedef enum timing_part {
  TIMING_OPEN = 0, /* headers, cameras, conventions, the device */
  TIMING_READ,     /* the first frame, where it decides something */
  TIMING_CHOOSE,   /* of the light, and of the radiance cache's place */
  TIMING_BUILD,    /* kernels and buffers */
  TIMING_LEARN,    /* what the radiance cache knows before the first frame */
  TIMING_FRAMES,   /* all stages of all frames */
  TIMING_PARTS
} timing_part;

typedef struct timing_report {
  const char *device;
  uint32_t width, height;
  unsigned repeat;
  size_t memory; /* bytes on the device */
  const timing_row *rows;
  size_t count;
  const double (*stages)[PIPELINE_STAGES]; /* seconds: decode, device, encode */
  double wall;                             /* seconds for all frames */
  size_t computed;     /* frames whose result did not exist */
  double learning;     /* milliseconds until the radiance cache knew all that it
                          knows before the first frame; negative: there is none */
  const double *parts; /* seconds: TIMING_PARTS of them */
  double total;        /* seconds since the job began */
} timing_report;

/* One line, without its end: how fast the job was, and which stage limited it.
 */
void timings_summary(const timing_report *report, FILE *out);

/* A table on standard output. */
void timings_table(const timing_report *report);

/* The same as JSON.  0, or -1 with `error` filled. */
int timings_json(const timing_report *report, image_error *error);

/* Warns of inputs whose pixels were sanitized, in one line on standard error;
 * nothing if there are none. */
void timings_warn_sanitized(const timing_row *rows, size_t count);

#endif
