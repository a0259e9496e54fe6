/* A radiance cache beside the fixture, and the plan whose frames ask it. */
#ifndef HBIL_BENCH_RADIANCE_CACHE_H
#define HBIL_BENCH_RADIANCE_CACHE_H

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/opencl.h"

/* Rounds of bounces before anything is timed, and of a frame's update, as hbil
 * process has them. */
enum { BENCH_ROUNDS_AT_FIRST = 16, BENCH_ROUNDS_OF_A_FRAME = 4 };

/* All members are read alone. */
typedef struct bench_radiance_cache {
  const bench_device *device;
  const bench_content *content;
  hbil_cache_config config;
  hbil_cache *cache;
  size_t memory;     /* of the cache, bytes on the device */
  bench_trial trial; /* of the default setting and the cache's near field */
} bench_radiance_cache;

/* Makes a cache that holds nearly all surfaces of the measured frame, and a
 * plan that asks it by this far-field method.  bench_radiance_cache_close()
 * frees it in all cases. */
int bench_radiance_cache_open(const bench_device *device,
                              const bench_content *content,
                              bench_fixture *fixture, hbil_cache_method method,
                              bench_radiance_cache *out, image_error *error);
void bench_radiance_cache_close(
    bench_radiance_cache *w); /* allowed on a zeroed one */

/* Enqueue: the injection of a frame of the content; of the same frame as
 * before, as a static view; that frame as the only
 * light view (HBIL_CACHE_METHOD_RSM); an update with the content's far field.
 */
int bench_radiance_cache_inject(const bench_radiance_cache *w, unsigned frame,
                                image_error *error);
int bench_radiance_cache_inject_static(const bench_radiance_cache *w,
                                       unsigned frame, image_error *error);
int bench_radiance_cache_light(const bench_radiance_cache *w, unsigned frame,
                               image_error *error);
int bench_radiance_cache_update(const bench_radiance_cache *w, cl_uint bounces,
                                cl_uint phases, cl_uint steps,
                                image_error *error);

/* Waits for what was enqueued. */
int bench_radiance_cache_finish(const bench_radiance_cache *w,
                                image_error *error);

#endif
