/* Computes the light of a job's frames: through the library, or by the exact
 * integral. */
#ifndef HBIL_TOOL_LIGHTING_H
#define HBIL_TOOL_LIGHTING_H

#include "tool/job.h"
#include "tool/program_folder.h"
#include "tool/sequence.h"
#include "image/error.h"
#include "image/image.h"

#include <stdint.h>

struct exact_sequence;

typedef struct lighting {
  device device;                /* of the library */
  hbil_context *context;        /* on it; has the kernels of all places */
  program_folder *programs;     /* of the context; NULL: none */
  sequence *sequence;           /* either this */
  job_cache *cache;             /* with it; NULL: no radiance cache */
  struct exact_sequence *exact; /* or that */
} lighting;

/* Opens the device and the library on it, or checks the settings of the exact
 * integral.  l is zeroed before.  0, or -1 with `error` filled. */
int lighting_prepare(lighting *l, const job *j, image_error *error);

/* Makes kernels and buffers for the job as it is now.  0, or -1 with `error`
 * filled. */
int lighting_open(lighting *l, job *j, image_error *error);

/* Frees what lighting_open() made, so that it may be called for another place.
 */
void lighting_end(lighting *l);

/* It may be called on a zeroed lighting and whatever the others returned. */
void lighting_close(lighting *l);

/* Bytes of device memory; 0 for the exact integral. */
size_t lighting_memory(const lighting *l);

/* job_cache_learn(), job_cache_see_frame() and job_cache_save(), if there is a
 * radiance cache. */
int lighting_learn(lighting *l, image_error *error);
int lighting_see(lighting *l, const char *path, const gbuffer *g,
                 image_error *error);
int lighting_save(lighting *l, image_error *error);
/* job_cache_bytes(); there must be a radiance cache. */
int lighting_cache_bytes(lighting *l, void **bytes, size_t *size,
                         image_error *error);

/* See sequence_hash(); 0 for the exact integral. */
uint64_t lighting_hash(const lighting *l, const gbuffer *g);

/* Computes a frame's layers into the planes of result (j->layers) and of hidden
 * (j->hidden), which cover j->window.
 * Frames come in order.  row: see sequence_run().  0, or -1. */
int lighting_run(lighting *l, const job *j, size_t item, const gbuffer *g,
                 uint64_t hash, image *result, image *hidden, timing_row *row,
                 image_error *error);

/* See sequence_history_size() and those below it.  item: the frame whose
 * history it is. */
size_t lighting_history_size(const lighting *l);
int lighting_history_save(lighting *l, void *bytes, image_error *error);
int lighting_history_restore(lighting *l, const job *j, int item, void *bytes,
                             image_error *error);

/* Tells, for the time that is shown, how many frames and runs are left. */
void lighting_expect(lighting *l, unsigned frames, unsigned runs);

#endif
