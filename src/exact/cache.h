/*
 * The radiance cache, pass by pass in double precision.
 *
 * There is no packing here: a voxel is a struct, and voxels are found by their
 * level and their cell.  Cache space is that of the kernels (lib/cache_args.h):
 * lengths in voxels of level 0, from the cache's middle.  Level l has cells of
 * 2^l, from -voxels/2 to voxels/2 - 1 along each axis.
 */
#ifndef HBIL_EXACT_CACHE_H
#define HBIL_EXACT_CACHE_H

#include "exact/exact.h"
#include "exact/vector.h"
#include "lib/cache_args.h"

/* ------------------------------------------------------------------------ */
/* Voxels (cache.c)                                                          */

typedef struct exact_voxel {
  int state;                       /* HBIL_VOXEL_UNKNOWN ... */
  double value[HBIL_VOXEL_FLOATS]; /* HBIL_VOXEL_NORMAL ... */
  double radiance[3];              /* that it sends */
  double unlit; /* part of its open directions that the sky does not light,
                   0..1; below 0: it does not tell */
} exact_voxel;

typedef struct exact_cache {
  int voxels, levels;
  double voxel_size; /* world units across a voxel of level 0 */
  long middle[3];    /* of the cache, in voxels of the coarsest level */
  exact_voxel *all;  /* owned */
} exact_cache;

/* A voxel's level, and its cell there. */
typedef struct exact_place {
  int level;
  int cell[3];
} exact_place;

/* All unknown.  The middle is the multiple of the coarsest voxel that is
 * nearest to `centre`, in the world.  Leaves an empty cache, which may be
 * freed, if it fails. */
exact_status exact_cache_create(exact_cache *cache,
                                const hbil_cache_config *config);
void exact_cache_free(exact_cache *cache);
/* Voxels of all levels. */
size_t exact_cache_count(const exact_cache *cache);

/* The voxel of a place, which must be inside. */
exact_voxel *exact_cache_at(const exact_cache *cache, const exact_place *place);
/* The number that the kernels give it: its index in their memory, where places
 * wrap around.  The place that has a number. */
size_t exact_cache_number(const exact_cache *cache, const exact_place *place);
exact_place exact_cache_place(const exact_cache *cache, size_t number);
/* Whether a level has the cell. */
bool exact_cache_has(const exact_cache *cache, const exact_place *place);
/* The middle of a voxel, in cache space. */
vec3 exact_cache_centre(const exact_place *place);
/* The world's place in cache space, and back. */
vec3 exact_cache_from_world(const exact_cache *cache, vec3 world);
vec3 exact_cache_to_world(const exact_cache *cache, vec3 at);

/* Moves the middle to the multiple of the coarsest voxel that is nearest to a
 * place in the world.  Voxels stay in the world; those that come in are unknown
 * and zero. */
exact_status exact_cache_move(exact_cache *cache, const double centre[3]);

/* ------------------------------------------------------------------------ */
/* Views (cache_view.c, cache_inject.c)                                      */

/* What a view's pixel shows. */
typedef struct exact_texel {
  double depth; /* planar, in voxels of level 0; 0: sky */
  vec3 normal;  /* world space, unit length */
  double reflectance[3], sent[3];
} exact_texel;

/* A pixel of a view.  frame: the view's inputs, its camera, and its size and
 * formats as a configuration; finished: as HBIL_VIEW_FINISHED. */
exact_texel exact_cache_texel(const exact_frame *frame,
                              const exact_cache *cache, bool finished, int x,
                              int y);

/* A view, as a table of every stride-th pixel of every stride-th row. */
typedef struct exact_cache_view {
  hbil_camera camera;
  bool orthographic, finished;
  int stride;
  int width, height;        /* in texels */
  const exact_texel *texel; /* width * height, top row first */
} exact_cache_view;

/* How many views HBIL_VOXEL_BEFORE counts, and the light in it. */
unsigned exact_voxel_before(double held, double *light);

/* Looks at all voxels in the view.  margin: unless NULL, for each voxel, by its
 * number, how near to its other side the nearest of the decisions was that made
 * its new state and values: in pixels, voxels of level 0, or cosines. */
void exact_cache_inject(exact_cache *cache, const exact_cache_view *view,
                        double *margin);

/* Voxels that no view has seen since the last update are dimmed as those that
 * were (cache_change.c). */
void exact_cache_follow_change(exact_cache *cache);
/* By what factor light at a place in cache space has fallen, of those of the
 * regions. */
double exact_cache_fallen(const exact_cache *cache,
                          const float ratios[HBIL_CACHE_REGIONS], vec3 at);

/* What the caller knows to have changed is forgotten (cache_change.c). */
void exact_cache_forget(exact_cache *cache, const hbil_cache_change *change);

/* ------------------------------------------------------------------------ */
/* Rays (cache_rays.c)                                                       */

/* The state of a place as rays see it: that of the finest level from the
 * place's own on that has seen it.  place: becomes that level's place; the
 * coarsest one's if none has. */
int exact_cache_state_for_rays(const exact_cache *cache, exact_place *place);

typedef enum exact_ray_kind {
  EXACT_RAY_UNKNOWN = 0, /* it ends in what no view has seen */
  EXACT_RAY_SKY = 1,
  EXACT_RAY_HIT = 2
} exact_ray_kind;

typedef struct exact_ray_end {
  exact_ray_kind kind;
  exact_place place; /* of the surface that is hit */
  double distance;   /* likewise */
  double lost;       /* to the first place that no view has seen; 0: none */
} exact_ray_end;

/* Follows a ray of unit direction from the distance `start` on, from voxel to
 * voxel. */
exact_ray_end exact_cache_follow(const exact_cache *cache, vec3 origin,
                                 vec3 direction, double start);

/* Its parts.  The voxel of the finest level that has a point; false: none has.
 * The distance at which a ray leaves a voxel.  Whether a ray hits the surface
 * of a voxel, whose values are v, and at which distance. */
bool exact_cache_find(const exact_cache *cache, vec3 at, exact_place *place);
double exact_cache_leave(const exact_place *place, vec3 origin, vec3 direction);
bool exact_cache_hits(const double *v, const exact_place *place, vec3 origin,
                      vec3 direction, double *distance);

/* Mixes the bits of a number, which turns rays. */
uint32_t exact_mixed(uint32_t number);
/* Coordinates in [0,1) of ray i of `count`. */
void exact_ray_place(int i, int count, uint32_t turn, double *u, double *v);
/* The direction of cosine z with the normal n and azimuth 2 pi v about it. */
vec3 exact_about_normal(vec3 n, double z, double v);

/* Areas (cache_areas.c): those of a step across; the sums of (red, green, blue,
 * 1) over the surfaces of one that face along +x -x +y -y +z -z, by the cosine;
 * the light at p along d from the surfaces of the smallest area around p that
 * has some which face it (false: none has). */
int exact_cache_areas_across(const exact_cache *cache, int step);
void exact_cache_area(const exact_cache *cache, int step, const int area[3],
                      double sum[6][4]);
bool exact_cache_local_light(const exact_cache *cache, vec3 p, vec3 d,
                             double light[3]);

/* Radiance of the environment from a direction in the world. */
double exact_environment(hbil_far_field far_field,
                         const float environment[9][3], int channel,
                         vec3 direction);

/* ------------------------------------------------------------------------ */
/* Bounces (cache_bounce.c)                                                  */

/* What a voxel sends: its radiance from its values. */
void exact_cache_update_radiance(exact_voxel *voxel);

/* Means over the surfaces of the coarsest level. */
typedef struct exact_cache_mean {
  double radiance[3];
  double unlit; /* of those that tell; 1 if none does */
} exact_cache_mean;
exact_cache_mean exact_cache_mean_of(const exact_cache *cache);

/* One round, on the voxels whose number is `phase` modulo update->phases:
 * `after` gets their indirect light and their unlit part.  before and after:
 * the same places. */
void exact_cache_bounce(const exact_cache *before,
                        const hbil_cache_update *update, double unseen_light,
                        uint32_t phase, const exact_cache_mean *mean,
                        exact_cache *after);

/* ------------------------------------------------------------------------ */
/* Probes (cache_probes.c, probe_light.c)                                    */

/* Order-1 functions of a direction in view space: a mean, and three times the
 * mean of the product with the direction. */
typedef struct exact_probe {
  bool valid;         /* there is a surface */
  vec3 place, normal; /* view space */
  double known[4];    /* share of rays whose light is known, not shown */
  double unknown[4];  /* share of rays into what no view has seen */
  double light[3][4]; /* radiance of the known ones */
  double guess[4];    /* of the unknown ones: radiance that areas tell, and the
                         share of rays; no function of the direction */
  double frames;      /* after exact_follow_probes(): that it stands for */
} exact_probe;

/* Probes stand at the corners of cells of `spacing` pixels, and some cells have
 * one more inside.  Line 2 i has the corners of row i, and line 2 i + 1 the
 * insides of the cells between the rows i and i + 1. */
typedef struct exact_probes {
  int spacing, columns, lines, count;
  exact_probe *probe; /* owned; line by line */
} exact_probes;

/* The probes of a configuration's pictures, all zero. */
exact_status exact_probes_create(exact_probes *probes,
                                 const hbil_config *config);
void exact_probes_free(exact_probes *probes);

/* SPLIT and the cache -> probes. */
void exact_make_probes(const exact_frame *frame, const exact_cache *cache,
                       const exact_planes *split, exact_probes *probes);
/* Each becomes a mean with those around it. */
void exact_filter_probes(const exact_frame *frame, const exact_probes *probes,
                         exact_probes *filtered);

/* Joins filtered probes with those that the last frame left, which `before`
 * saw.
 */
void exact_follow_probes(const exact_frame *frame, const hbil_camera *before,
                         const exact_probes *filtered, const exact_probes *past,
                         exact_probes *followed);

/* What the cache knows of a pixel's open directions. */
typedef struct exact_probe_light {
  double light[3]; /* radiance times the share of the hemisphere */
  double share;    /* of the open directions */
  /* of the others: radiance that areas tell times its weight, and the weight */
  double guess[3], guess_share;
} exact_probe_light;

/* The mean of (1, direction) over the open directions, a share `ao` of the
 * hemisphere about the bent normal. */
void exact_open_mean(double ao, vec3 bent, double mean[4]);
/* The weight of probe i at a place that is given in cells: a tent about its
 * corner or its cell's middle, zero `reach` cells away. */
double exact_probe_tent(const exact_probes *probes, int i, double across,
                        double down, double reach);
/* The weight at a pixel; 0 where the probe isn't valid. */
double exact_probe_corner(const exact_probes *probes, int i, int x, int y);
/* How much a probe is that of a surface at p, in view space, that faces along
 * `facing`. */
double exact_probe_weight(const exact_frame *frame, const exact_probe *probe,
                          vec3 p, vec3 facing);
/* All 0 without frame->probes. */
exact_probe_light exact_light_of_probes(const exact_frame *frame, int x, int y,
                                        double ao, vec3 bent);

#endif
