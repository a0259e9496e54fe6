/*
 * A frame with a radiance cache that has seen its scene, and the frame's
 * probes.
 *
 * The usual order: lit_prepare(), changes of `s`, setup_start(&l.s) and passes,
 * lit_free().
 */
#ifndef HBIL_TEST_LIT_FRAME_H
#define HBIL_TEST_LIT_FRAME_H

#include "test/support/cache.h"

enum { LIT_WIDTH = 173, LIT_HEIGHT = 91 };

typedef struct lit_frame {
  cache_fixture f;
  device_fixture device; /* with the cache's context */
  exact_cache cache;     /* what f.cache holds */
  setup s;
} lit_frame;

/* A cache that has seen the scene, whose kernels have vectors of that width,
 * and a frame of it with all outputs, whose camera the cache has not had. */
void lit_prepare(lit_frame *l, hbil_cache_method method, cl_uint width,
                 scene_kind kind, hbil_projection projection,
                 hbil_far_field far_field);
void lit_free(lit_frame *l);

/* Random factors for the regions of a cache. */
void lit_draw_factors(uint64_t seed, float ratios[HBIL_CACHE_REGIONS]);
/* Updates the cache, then sets the factors of its regions. */
void lit_fall(lit_frame *l, const float ratios[HBIL_CACHE_REGIONS]);
/* The factor for the light that the last frame hands on to a pixel; NAN so near
 * to a region's border that a rounding decides. */
double lit_fallen(const lit_frame *l, const float ratios[HBIL_CACHE_REGIONS],
                  int x, int y);
/* Light from everywhere, more of it from some sides. */
void lit_environment(setup *s);

/* Probes of the frame, all zero. */
exact_probes lit_no_probes(const setup *s);
/* The probes in an argument of a kernel, of a method's frame. */
exact_probes lit_probes(const setup *s, const char *kernel, cl_uint index);
/* The largest differences of places and normals, of shares, and of light. */
void probe_difference(const exact_probe *a, const exact_probe *b,
                      double off[3]);
/* Whether probe i stands where the exact one does.  Which pixel of a cell has a
 * probe may be decided by a rounding; a corner's pixel isn't, so this fails the
 * test if a corner's probe stands elsewhere. */
bool same_place(const exact_probes *got, int i, const exact_probe *want);

#endif
