/*
 * The exact screen-space integral as the tool uses it: test/reference.c, which
 * the library is tested against.  Needs no OpenCL device.
 */
#ifndef HBIL_TOOL_EXACT_H
#define HBIL_TOOL_EXACT_H

#include "dump/gbuffer.h"
#include "test/reference.h"

/* CPUs of this machine; all of them are used. */
int exact_threads(void);

/* Seconds that the gather of so many pixels of a job takes, from a few that
 * are looked at now. */
double exact_probe(const ref_job *job, int slices, size_t wanted);

/* --- a sequence of frames, as in sequence.c --- */

/* What will be asked for in all, so that the time can be told. */
typedef struct exact_work {
  unsigned frames, runs; /* runs of all frames together */
  int quiet;             /* nothing is told */
} exact_work;

typedef struct exact_sequence exact_sequence;

/* What hbil_plan_create() refuses and the command line allows: there is no plan
 * here. */
int exact_check(const hbil_config *config, image_error *error);
/* config: settings, which are right, with any number of slices; those of
 * sampling beside it do nothing.  Formats are filled in from map and layers. */
int exact_open(const hbil_config *config, const channel_map *map,
               unsigned layers, const exact_work *work, exact_sequence **out,
               image_error *error);
void exact_close(exact_sequence *e);
/* So many frames and runs are left in all. */
void exact_expect(exact_sequence *e, unsigned frames, unsigned runs);
/* Runs a frame `repeat` times and takes the layers into result's planes. */
void exact_run(exact_sequence *e, const gbuffer *g, const camera_file *camera,
               float environment[9][3], unsigned repeat, image *result);

/* As sequence_take_light() and its like. */
size_t exact_light_size(const exact_sequence *e);
void exact_take_light(const exact_sequence *e, void *bytes);
void exact_give_light(exact_sequence *e, const camera_file *camera,
                      const void *bytes);

#endif
