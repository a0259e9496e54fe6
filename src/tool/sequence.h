/* Runs the frames of a sequence through the library: planes to cl_mem, all
 * passes, cl_mem to planes. */
#ifndef HBIL_TOOL_SEQUENCE_H
#define HBIL_TOOL_SEQUENCE_H

#include "dump/gbuffer.h"
#include "tool/device.h"
#include "tool/layers.h"
#include "tool/job_cache.h"
#include "image/error.h"
#include "image/image.h"

#include <stdint.h>

typedef struct sequence sequence;

/* config: the settings; formats are filled in from the map and the set of
 * layers (layers.h), of which results have those in `halves` as halves.  The
 * device and the library's context on it must outlive the sequence.  Returns 0,
 * or -1 with `error` filled and *out NULL. */
int sequence_open(const device *d, hbil_context *context,
                  const hbil_config *config, const channel_map *map,
                  unsigned layers, unsigned halves, sequence **out,
                  image_error *error);
void sequence_close(sequence *s); /* NULL is allowed */

/* The radiance cache that the frames ask from now on; NULL: none.  It stays the
 * caller's. */
void sequence_set_cache(sequence *s, job_cache *cache);

/* Bytes of device memory of the plan. */
size_t sequence_memory(const sequence *s);

/* What is measured of a frame. */
typedef struct timing_row {
  const char *frame; /* its name, which the caller sets */
  double milliseconds[HBIL_PASS_COUNT];
  hbil_statistics statistics;
  hbil_sanitized sanitized;
  /* Pixels that show surfaces, and the mean of `unknown` over them; the caller
   * sets both (unknown.h). */
  size_t surfaces;
  double unknown;
} timing_row;

/*
 * Runs a frame `repeat` times and copies each layer into the planes of result,
 * or, if it has none there, of hidden.
 * Runs after the first, and a frame that equals the previous one, are static
 * frames (hbil.h).  hash: that of sequence_hash().  Of the row, which is for
 * the last run, milliseconds and statistics are filled if config.profiling is
 * set, sanitized always.  Returns 0, or -1 with `error` filled.
 */
int sequence_run(sequence *s, const gbuffer *g, uint64_t hash,
                 const far_light *far, unsigned repeat, image *result,
                 image *hidden, timing_row *row, image_error *error);

/* A hash of the planes that sequence_run() uploads, by which it recognises the
 * previous frame.  Another thread may call it meanwhile. */
uint64_t sequence_hash(const sequence *s, const gbuffer *g);

/*
 * The history: what the last frame hands on to the next one.  If it is restored
 * into a new sequence with the same device and settings, the next frame has the
 * same bits as without the interruption.  size: bytes; 0 if these settings have
 * no history.
 */
size_t sequence_history_size(const sequence *s);
int sequence_history_save(sequence *s, void *bytes, image_error *error);
int sequence_history_restore(sequence *s, void *bytes, image_error *error);

#endif
