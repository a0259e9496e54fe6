/*
 * Sequences of frames through the exact integral (--quality reference), with
 * the same settings and the same files as through the library (sequence.c).
 * Needs no OpenCL device.
 */
#ifndef HBIL_TOOL_EXACT_H
#define HBIL_TOOL_EXACT_H

#include "dump/gbuffer.h"
#include "exact/exact.h"
#include "image/camera_json.h"
#include "image/error.h"
#include "image/image.h"
#include "tool/layers.h"

/* The amount of work, from which the time is predicted. */
typedef struct exact_work {
  unsigned frames, runs; /* runs of all frames together */
  int quiet;             /* nothing is printed */
} exact_work;

typedef struct exact_sequence exact_sequence;

/* Rejects settings that the command line allows and hbil_plan_create() would
 * reject: the exact integral has no plan. */
int exact_sequence_check(const hbil_config *config, image_error *error);
/* config: settings that passed the check, with any number of slices from 1; the
 * other settings of sampling have no effect.  Formats are filled in from map
 * and layers. */
int exact_sequence_open(const hbil_config *config, const channel_map *map,
                        unsigned layers, const exact_work *work,
                        exact_sequence **out, image_error *error);
void exact_sequence_close(exact_sequence *e);
/* Corrects the amount of work, before the first run. */
void exact_sequence_expect(exact_sequence *e, unsigned frames, unsigned runs);
/* Runs a frame `repeat` times and copies each layer to the planes of result or,
 * if it has none there, of hidden. */
int exact_sequence_run(exact_sequence *e, const gbuffer *g,
                       const camera_file *camera, const far_light *far,
                       unsigned repeat, image *result, image *hidden,
                       image_error *error);

/* The light that the last frame hands on to the next one, for a process that
 * goes on with the sequence later: its size in bytes (0: none), the bytes, and
 * the way back, with the camera of that frame. */
size_t exact_sequence_light_size(const exact_sequence *e);
void exact_sequence_take_light(const exact_sequence *e, void *bytes);
void exact_sequence_give_light(exact_sequence *e, const camera_file *camera,
                               const void *bytes);

#endif
