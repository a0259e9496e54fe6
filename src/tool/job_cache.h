/* The radiance cache of a job: what its views and frames have shown of the
 * place. */
#ifndef HBIL_TOOL_JOB_CACHE_H
#define HBIL_TOOL_JOB_CACHE_H

#include "tool/device.h"
#include "tool/device_plane.h"
#include "dump/gbuffer.h"
#include "tool/job.h"
#include "image/error.h"

typedef struct job_cache job_cache;

/* Chooses j->cache, by what the job's views and frames show, and the radius of
 * the near field that goes with it.  Nothing if the job has no cache.  0, or -1
 * with `error` filled. */
int job_cache_choose(job *j, image_error *error);

/* Makes the cache, which knows nothing yet.  The context is that of the plan.
 * Returns 0, or -1 with `error` filled and *out NULL. */
int job_cache_open(const device *d, hbil_context *context, const job *j,
                   job_cache **out, image_error *error);
void job_cache_close(job_cache *jc); /* NULL is allowed */

hbil_cache *job_cache_of(const job_cache *jc);
/* Bytes of device memory. */
size_t job_cache_memory(const job_cache *jc);

/* Brings what is known before the first frame into the cache: settings'
 * cache_load, the views and, with settings->learn, all frames.  Shows progress.
 * 0, or -1 with `error` filled. */
int job_cache_learn(job_cache *jc, image_error *error);
/* Seconds that this took. */
double job_cache_learning_seconds(const job_cache *jc);

/* Injects a frame before its light is computed, and lets light bounce.  Nothing
 * with settings->cache_fixed.  path: its file, for messages.  given: INPUTS
 * buffers, of those inputs that are on the device already, the others NULL; or
 * NULL.  0, or -1 with `error` filled. */
int job_cache_see_frame(job_cache *jc, const char *path, const gbuffer *g,
                        const device_plane *given, image_error *error);

/* What hbil_cache_save() gives, which the caller frees.  0, or -1 with `error`
 * filled. */
int job_cache_bytes(job_cache *jc, void **bytes, size_t *size,
                    image_error *error);

/* Writes the cache to settings->cache_save.  0, or -1 with `error` filled. */
int job_cache_save(job_cache *jc, image_error *error);

#endif
