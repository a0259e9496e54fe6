/*
 * A radiance cache with everything around it: views of a scene, and what the
 * cache holds on the device, as the exact passes have it.
 *
 * The usual order: cache_prepare(), changes of `config`, cache_start(), then
 * cache_inject() and so on, cache_free().
 */
#ifndef HBIL_TEST_CACHE_H
#define HBIL_TEST_CACHE_H

#include "exact/cache.h"

#include "test/support/fixture.h"

/* The cache's buffers. */
typedef enum cache_buffer {
  CACHE_STATES,
  CACHE_CLEARANCE,
  CACHE_VOXELS,
  CACHE_RADIANCE,
  CACHE_UNLIT,
  CACHE_MEANS,
  CACHE_TEXELS,
  CACHE_RATIOS,
  CACHE_BUFFERS
} cache_buffer;

typedef struct cache_fixture {
  hbil_context *context; /* of the cache's vector width */
  cl_uint vector_width;  /* the shim answers with it */
  hbil_cache_config config;
  hbil_cache *cache;
} cache_fixture;

/* A cache of 3 levels of 32 voxels about the scene, of that vector width. */
void cache_prepare(cache_fixture *f, cl_uint vector_width);
/* Creates the cache for views like those of the setup. */
void cache_start(cache_fixture *f, const setup *like);
void cache_free(cache_fixture *f);
/* Frees all three. */
void cache_end(cache_fixture *f, setup *s, exact_cache *cache);

/* A view of a scene, on the device.  The world is turned, so that no surface
 * lies along voxels.  Its planes are those of s->frame and s->input; it has no
 * kernels.  setup_free() ends it. */
void view_start(setup *s, scene_kind kind, int width, int height,
                uint32_t index, hbil_projection projection);
/* The same, without creating anything: for a plan of the caller. */
void view_prepare(setup *s, scene_kind kind, int width, int height,
                  uint32_t index, hbil_projection projection);

/* A view that shows what a setup's frame shows. */
hbil_view cache_view(const setup *s, hbil_view_light light);
void cache_inject(cache_fixture *f, const setup *s, hbil_view_light light);
void cache_update(cache_fixture *f, const hbil_cache_update *update);
/* An update by default, but for the number of bounces. */
hbil_cache_update cache_bounces(cl_uint bounces);
void cache_move(cache_fixture *f, const double centre[3]);

/* Makes the next update do all its work, also where only a test has changed
 * what the cache holds. */
void cache_touch(cache_fixture *f);

/* Creates the cache, and injects two views of a scene, with a move between, so
 * that places wrap around.  The last view remains in `last`; `cache`, from
 * checked_cache(), is moved, too. */
void cache_fill(cache_fixture *f, exact_cache *cache, scene_kind kind,
                hbil_view_light light, setup *last);

/* A buffer of the cache that was used last, by all kernels that use it. */
cl_mem cache_memory(cache_buffer which);
/* All bytes of a buffer, after its last kernel; the caller frees. */
void *cache_read(cache_buffer which, size_t *bytes);
/* What the cache holds: states, values, radiance and unlit parts.  `like` is
 * where it is. */
void cache_import(exact_cache *like);
/* An exact cache at the fixture's first place. */
exact_cache checked_cache(const cache_fixture *f);

/* The table of the last view: `width` * `height` texels, which the caller
 * frees. */
exact_texel *cache_texels(int *width, int *height);
exact_texel texel_of_words(const uint32_t word[HBIL_TEXEL_WORDS]);
/* The light of a word: three mantissas of 8 bits, and their unit. */
void light_of_word(uint32_t word, double light[3], double *unit);

#endif
