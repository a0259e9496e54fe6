/*
 * Methods of a cache other than rays, pass by pass in double precision:
 * cones (cache_cones.c), light propagation volumes (cache_volumes.c) and
 * reflective shadow maps (cache_rsm.c).  Cache space is that of exact/cache.h.
 */
#ifndef HBIL_EXACT_CACHE_METHODS_H
#define HBIL_EXACT_CACHE_METHODS_H

#include "exact/cache.h"

/* ------------------------------------------------------------------------ */
/* What they share (cache_probes.c)                                          */

/* The places of all probes; everything else in them becomes 0. */
void exact_place_probes(const exact_frame *frame, const exact_planes *split,
                        exact_probes *probes);
/* A valid probe in cache space: its place, its normal, and the size of the
 * voxels of the finest level there. */
typedef struct exact_stand {
  vec3 at, n;
  double size;
} exact_stand;
exact_stand exact_probe_stand(const exact_frame *frame,
                              const exact_cache *cache, const exact_probe *p);
/* Adds `share` of a direction of cache space to a function of directions. */
void exact_probe_add(const exact_frame *frame, double sum[4], double share,
                     vec3 direction);
/* Whether the frame shows the surface at a place of cache space, which a ray of
 * that direction meets; tolerance: of depth, in voxels of level 0. */
bool exact_frame_shows(const exact_frame *frame, const exact_cache *cache,
                       const exact_planes *split, vec3 at, vec3 direction,
                       double tolerance);

/* ------------------------------------------------------------------------ */
/* Cones                                                                     */

/* What is seen of a cube along +x -x +y -y +z -z: light times opacity, and
 * opacity; and the shares of it that no view has seen, and that have the sky
 * behind. */
typedef struct exact_mip {
  double along[6][4];
  double unseen, sky;
} exact_mip;

/* The cubes of step m are 2^(m+1) voxels of level 0 across.  Up to the last
 * level they fill level m, and from there on the cache. */
typedef struct exact_pyramid {
  int voxels, levels;
  exact_mip *mip; /* owned; the finest step first */
} exact_pyramid;

exact_status exact_pyramid_create(exact_pyramid *pyramid,
                                  const exact_cache *cache);
void exact_pyramid_free(exact_pyramid *pyramid);
/* One for each level, and so many more that the last has a single cube. */
int exact_pyramid_steps(const exact_pyramid *pyramid);
/* Cubes of a step across. */
int exact_pyramid_across(const exact_pyramid *pyramid, int step);
exact_mip *exact_pyramid_at(const exact_pyramid *pyramid, int step, int x,
                            int y, int z);
/* A level's from its voxels, but where the step before is from that. */
void exact_pyramid_build(const exact_cache *cache, exact_pyramid *pyramid,
                         int step);
/* The cube of two voxels of a level across whose lowest cell is `low`. */
exact_mip exact_mip_of_voxels(const exact_cache *cache, int level,
                              const int low[3]);

void exact_probe_cones(const exact_frame *frame, const exact_cache *cache,
                       const exact_pyramid *pyramid, const exact_planes *split,
                       exact_probes *probes);

/* ------------------------------------------------------------------------ */
/* Light propagation volumes                                                 */

/* Intensity by the direction w in which light travels: mean + slope.w. */
typedef struct exact_intensity {
  double mean;
  vec3 slope;
} exact_intensity;

typedef struct exact_cell {
  exact_intensity light[3];
  double opacity[6]; /* of sources: for light along +x -x +y -y +z -z */
} exact_cell;

/* For each level cells from -1 to `across` along each axis, of which the first
 * and the last are outside. */
typedef struct exact_volumes {
  int across, levels;
  exact_cell *cell; /* owned */
} exact_volumes;

/* All zero. */
exact_status exact_volumes_create(exact_volumes *volumes,
                                  const exact_cache *cache);
void exact_volumes_free(exact_volumes *volumes);
exact_cell *exact_volumes_at(const exact_volumes *volumes, int level, int x,
                             int y, int z);
/* What the cache's surfaces send into the cells, which must be zero, and the
 * cells' opacities. */
void exact_volume_sources(const exact_cache *cache, exact_volumes *sources);
/* The cells outside. */
void exact_volume_border(exact_volumes *volumes, hbil_far_field far_field,
                         const float environment[9][3]);
/* A step of light: the cells inside of `after`. */
void exact_propagate(const exact_volumes *sources, const exact_volumes *before,
                     exact_volumes *after);
/* The factor by which the positive part of an intensity, as the faces take it,
 * is the flux 4 pi times the mean. */
double exact_flux_factor(const exact_intensity *intensity);

void exact_probe_volumes(const exact_frame *frame, const exact_cache *cache,
                         const exact_volumes *volumes,
                         const exact_planes *split, exact_probes *probes);

/* ------------------------------------------------------------------------ */
/* Reflective shadow maps                                                    */

/* Radiance over the solid angle of what a light's view shows, 1 and with the
 * direction, at a place of cache space: sums over all texels. */
void exact_light_sum(const exact_cache *cache, const exact_cache_view *light,
                     vec3 at, vec3 n, double sum[3][4]);
/* The same as the kernel estimates it, from HBIL_RSM_SAMPLES texels. */
void exact_light_samples(const exact_cache *cache,
                         const exact_cache_view *light, vec3 at, vec3 n,
                         uint32_t turn, double sum[3][4]);

/* all: every texel, not those that the kernel takes. */
void exact_probe_lights(const exact_frame *frame, const exact_cache *cache,
                        const exact_cache_view *lights, int count, bool all,
                        const exact_planes *split, exact_probes *probes);

#endif
