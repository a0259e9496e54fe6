/* The radiance cache of a job: what its views and frames have shown of the
 * place. */
#ifndef HBIL_TOOL_WORLD_H
#define HBIL_TOOL_WORLD_H

#include "tool/device.h"
#include "dump/gbuffer.h"
#include "tool/job.h"
#include "image/error.h"

typedef struct world world;

/* Chooses j->cache, by what the job's views and frames show, and the radius of
 * the near field that goes with it.  Nothing if the job has no cache.  0, or -1
 * with `error` filled. */
int world_choose(job *j, image_error *error);

/* Makes the cache, which knows nothing yet.  The context is that of the plan.
 * Returns 0, or -1 with `error` filled and *out NULL. */
int world_open(const device *d, hbil_context *context, const job *j,
               world **out, image_error *error);
void world_close(world *w); /* NULL is allowed */

hbil_cache *world_cache(const world *w);
/* Bytes of device memory. */
size_t world_memory(const world *w);

/* Brings what is known before the first frame into the cache: settings'
 * cache_load, the views and, with settings->learn, all frames.  Shows progress.
 * 0, or -1 with `error` filled. */
int world_learn(world *w, image_error *error);
/* Seconds that this took. */
double world_learning_seconds(const world *w);

/* Injects a frame before its light is computed, and lets light bounce.  Nothing
 * if it has been learnt already.  path: its file, for messages.  given: INPUTS
 * buffers, of those inputs that are on the device already, the others NULL; or
 * NULL.  0, or -1 with `error` filled. */
int world_see_frame(world *w, const char *path, const gbuffer *g,
                    const cl_mem *given, image_error *error);

/* What hbil_cache_save() gives, which the caller frees.  0, or -1 with `error`
 * filled. */
int world_bytes(world *w, void **bytes, size_t *size, image_error *error);

/* Writes the cache to settings->cache_save.  0, or -1 with `error` filled. */
int world_save(world *w, image_error *error);

#endif
