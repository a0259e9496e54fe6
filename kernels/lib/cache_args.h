/*
 * cache_args: the radiance cache, as the host, the kernels and the exact passes
 * need it.
 *
 * Cache space is the world's, about the cache's centre, in voxels of the finest
 * level.  Level l has voxels of 2^l, `voxels` across each way, and holds
 * [-voxels/2, voxels/2) 2^l.  Where a voxel lies in memory depends on the world
 * alone: coordinates wrap around, so that a move of the centre copies nothing.
 */
#ifndef HBIL_CACHE_ARGS_H
#define HBIL_CACHE_ARGS_H

#include "shared.h"

enum { HBIL_CACHE_MAX_LEVELS = 4, HBIL_CACHE_MOST_VOXELS = 256 };

/* What is known of a voxel: two bits each, sixteen voxels of a row to a word,
 * all of level 0 first. */
enum {
  HBIL_VOXEL_UNKNOWN = 0, /* no view has seen it */
  HBIL_VOXEL_EMPTY = 1,   /* a view looked through it */
  HBIL_VOXEL_SURFACE = 2,
  HBIL_VOXEL_SKY = 3 /* a view looked through it and saw the sky behind it */
};

/* What rays read, to skip empty space: a byte a voxel.  The lower two bits are
 * the state, but what a level has not seen has the state of the coarser level
 * there, so HBIL_VOXEL_SURFACE may be a surface of a coarser level.  The upper
 * six bits: of a surface, how many levels above this one it is; of all others
 * the clearance r: all voxels up to r away along each axis, so a cube of 2 r +
 * 1, have the same state.  With HBIL_MOST_CLEARANCE 3, rays of bounces take 4 %
 * longer; with 15, 1 % less. */
#define HBIL_MOST_CLEARANCE 7

/* The floats of a voxel, a cache line: means over the views that saw it, and
 * what has been gathered since. */
enum {
  HBIL_VOXEL_NORMAL = 0,      /* world space; 3 */
  HBIL_VOXEL_OFFSET = 3,      /* of the surface from the centre, along it */
  HBIL_VOXEL_REFLECTANCE = 4, /* diffuse; 3 */
  HBIL_VOXEL_WEIGHT = 7,      /* views, up to HBIL_CACHE_MOST_VIEWS */
  HBIL_VOXEL_SENT = 8,        /* radiance of the first bounce, or finished; 3 */
  HBIL_VOXEL_LIGHT_WEIGHT = 11, /* the same as a weight; -: finished radiance */
  HBIL_VOXEL_INDIRECT = 12,     /* irradiance over pi; 3 */
  /* 0: no view has seen it since the last update; -1: some have, but there is
   * no light to compare theirs with; else the sum of the channels of the light
   * that it sent before them, and in the lowest bits of this float how many
   * they are */
  HBIL_VOXEL_BEFORE = 15,
  HBIL_VOXEL_FLOATS = 16
};

/* Means follow changes: older views fade out beyond so many. */
#define HBIL_CACHE_MOST_VIEWS 16.0f

/* Light that a view shows replaces a voxel's mean, and doesn't join it, if it
 * is so far from it, in parts of the larger one of both, in the channel that
 * changes most (cache/inject.cl).  Means of noise differ by less. */
#define HBIL_CACHE_LIGHT_CHANGED 0.5f

/* The bits of HBIL_VOXEL_BEFORE that count views: more than a voxel's weight
 * may be.  They change the light by 2^-18 at most; only a tenth counts as a
 * change. */
#define HBIL_VOXEL_MOMENT_VIEWS 31u
/* Less light counts as none, so that the float is never denormal: devices may
 * make these 0, and with them the count. */
#define HBIL_VOXEL_LEAST_LIGHT 1e-30f
/* Factors of changes are at most so far from 1 (cache/change.cl). */
#define HBIL_CACHE_MOST_CHANGE 50.0f

/* Regions of the cache that follow changes of light, and along an axis
 * (cache/change.cl). */
enum { HBIL_CACHE_REGIONS_ACROSS = 4, HBIL_CACHE_REGIONS = 64 };
/* Floats of the sums of a region. */
#define HBIL_CHANGE_SUMS 8
/* They do if there is so much less light, if what is lost is at least so much
 * of all changes without their signs, and if there are so many voxels, by
 * weight. Noise of voxels cancels in regions; a box that moves or a cloud's
 * edge has both signs.  Light that has gone altogether counts only if it was
 * more than half of all: next to a patch of sun, one view sees a voxel's lit
 * part and the next one its dark part. */
#define HBIL_CHANGE_LEAST 0.1f
#define HBIL_CHANGE_AGREEMENT 0.7f
#define HBIL_CHANGE_VOXELS 25.0f

/* The outermost texel that a view's footprint of a voxel reaches. */
#define HBIL_CACHE_FOOTPRINT 3

/* What is farther from a voxel's centre, along an axis, is beside the voxel; in
 * voxels.  Points of a plane between two voxels are in both of them. */
#define HBIL_CACHE_INSIDE 0.51f
/* The weight of light that no view has shown in the voxel, but beside it: below
 * 1, which light needs to count as changed. */
#define HBIL_CACHE_NOT_IN_SIGHT 0.99f

/* Parts of the sums over the cache. */
#define HBIL_CACHE_PARTS 64

/* Rays of a surface in an update.  With 64, of which each update traces a
 * quarter, four walks are no nearer to the truth on average
 * (doc/measurements.md). */
#define HBIL_CACHE_RAYS 16
/* An update traces the rays of new surfaces and of every n-th old one; the rest
 * have the hits of the last update (cache/ray_hits.cl).  They don't where more
 * than one in so many voxels is a surface, since then each has fewer rays. */
#define HBIL_CACHE_TURNS 4
#define HBIL_LAST_LIST (HBIL_CACHE_RAYS / HBIL_CACHE_RAY_HITS)
/* Words of the list of surfaces before the first one (lib/ray_hits.clh). */
#define HBIL_LIST_HEAD (HBIL_CACHE_PARTS + 16)
/* Hits of rays that there is memory for, per voxel. */
#define HBIL_CACHE_RAY_HITS 2

/* A surface guesses what its rays into the unseen bring by what its other rays
 * meet, as if one more of 16 had met the mean of all surfaces
 * (doc/measurements.md). */
#define HBIL_CACHE_MEAN_SHARE 0.0625f

/* A ray hits a voxel's plane if it crosses it within this many voxels of the
 * centre, along each axis.  Planes of neighbours then overlap by half a voxel,
 * without gaps. */
#define HBIL_CACHE_SLACK 0.75f
/* Rays begin this far above the surface, along the normal and along the ray,
 * and no hit is nearer than the last; in voxels of the level.  A surface's own
 * voxels have planes through it, which rays away from it don't meet. */
#define HBIL_CACHE_LIFT 0.05f
#define HBIL_CACHE_START 0.2f
#define HBIL_CACHE_NEAREST 0.5f
/* A hit is shown by the frame if the frame's surface is this many voxels from
 * it at most. */
#define HBIL_CACHE_SHOWN 2.0f

typedef struct hbil_cache_args {
  hbil_int voxels, levels;
  hbil_int log2_voxels;
  /* of the centre, in voxels of the coarsest level, modulo `voxels` */
  hbil_int shift[3];
} hbil_cache_args;
HBIL_ASSERT_LAYOUT(hbil_cache_args, shift, 3, 6)

/* A view becomes a table of up to HBIL_CACHE_MOST_TEXELS texels: every
 * `stride`th pixel of every `stride`th row.  Words of a texel: */
enum { HBIL_CACHE_MOST_TEXELS = 1 << 17 };
enum {
  HBIL_TEXEL_DEPTH = 0,       /* planar, in voxels of level 0; 0: sky */
  HBIL_TEXEL_NORMAL = 1,      /* world space, as in packed planes */
  HBIL_TEXEL_REFLECTANCE = 2, /* three unorm10, red lowest */
  HBIL_TEXEL_SENT = 3,        /* as radiance in packed planes */
  HBIL_TEXEL_WORDS = 4
};

/* cache/view.cl */
typedef struct hbil_cache_view_args {
  hbil_view_args view;            /* of the view's pixels */
  hbil_int stride, width, height; /* of the table, in texels */
  hbil_int finished;              /* `direct` is finished radiance */
  hbil_float scale;               /* voxels of level 0 per world unit */
  hbil_transform_args normals; /* from where normals are stored to view space */
  hbil_transform_args to_world;
  hbil_external_plane_args depth, normal;
  hbil_surface_args surface; /* direct_scale: 1 if finished */
  hbil_depth_args decode;
  hbil_float per_exposure; /* 1 over hbil_view's */
  hbil_int first;          /* texels of the buffer before the table */
} hbil_cache_view_args;
HBIL_ASSERT_LAYOUT(hbil_cache_view_args, first, 67, 68)

/* cache/inject.cl.  view: of texels; lengths in voxels of level 0. */
typedef struct hbil_cache_inject_args {
  hbil_cache_args cache;
  hbil_view_args view;
  hbil_transform_args to_view, to_cache;
  hbil_int finished;
} hbil_cache_inject_args;
HBIL_ASSERT_LAYOUT(hbil_cache_inject_args, finished, 38, 39)

/* cache/ray_hits.cl.  The update handles the voxels whose number is `phase`
 * modulo `phases`. */
typedef struct hbil_cache_list_args {
  hbil_cache_args cache;
  hbil_int phases, phase;
} hbil_cache_list_args;
/* Surfaces whose number is `turn` modulo `turns` are traced, and those that are
 * not in the last list. */
typedef struct hbil_cache_trace_args {
  hbil_cache_args cache;
  hbil_int turns, turn;
} hbil_cache_trace_args;
HBIL_ASSERT_LAYOUT(hbil_cache_trace_args, turn, 7, 8)
HBIL_ASSERT_LAYOUT(hbil_cache_list_args, phase, 7, 8)

/* A round of bounces.  It is left out if the round before changed nothing.
 * fresh: something else has changed, so it isn't.  Numbers wrap around. */
typedef struct hbil_cache_round_args {
  hbil_uint number;
  hbil_int fresh;
} hbil_cache_round_args;
HBIL_ASSERT_LAYOUT(hbil_cache_round_args, fresh, 1, 2)

/* cache/bounce.cl.  environment: as in composite, for radiance. */
typedef struct hbil_cache_bounce_args {
  hbil_cache_args cache;
  hbil_environment_args environment;
  hbil_float sky[3]; /* radiance of the sky that direct light contains */
  hbil_float unseen_light;
} hbil_cache_bounce_args;
HBIL_ASSERT_LAYOUT(hbil_cache_bounce_args, unseen_light, 36, 37)

/* cache/move.cl */
typedef struct hbil_cache_move_args {
  hbil_cache_args cache; /* after the move */
  hbil_int moved[3];     /* by so many voxels of the coarsest level */
} hbil_cache_move_args;
HBIL_ASSERT_LAYOUT(hbil_cache_move_args, moved, 6, 9)

/* split.cl: light that the last frame hands on falls as the cache's views say
 * (cache/change.cl). */
typedef struct hbil_fall_args {
  hbil_transform_args to_cache; /* from view space */
  hbil_cache_args cache;
  hbil_int changed; /* an update has found factors since the last frame */
} hbil_fall_args;
HBIL_ASSERT_LAYOUT(hbil_fall_args, changed, 18, 19)

/* The weight of light that is forgotten wholly: nothing beside a view's 1. */
#define HBIL_LEAST_LIGHT_WEIGHT 0x1p-20f

/* The same.  The box is in cache space; shares are 0..1. */
typedef struct hbil_cache_forget_args {
  hbil_cache_args cache;
  hbil_float low[3], high[3];
  hbil_float surfaces, light;
} hbil_cache_forget_args;
HBIL_ASSERT_LAYOUT(hbil_cache_forget_args, light, 13, 14)

/* Floats of a probe.  Sums over its rays of values, and of three times values
 * times the direction, in view space: order-1 functions of a direction. */
enum {
  HBIL_PROBE_POSITION = 0,  /* view space; 3 */
  HBIL_PROBE_VALID = 3,     /* 1: there is a surface */
  HBIL_PROBE_NORMAL = 4,    /* view space; 3 */
  HBIL_PROBE_FRAMES_AT = 7, /* after follow_probes: frames that it stands for */
  HBIL_PROBE_KNOWN = 8,     /* rays whose light is known, not shown; 4 */
  HBIL_PROBE_UNKNOWN = 12,  /* rays into what no view has seen; 4 */
  HBIL_PROBE_LIGHT = 16,    /* radiance of the known ones; 4 a channel */
  /* of the unknown ones: radiance that areas tell, and the share of rays that
   * it is told of, both times a weight and without directions; 3, 1 */
  HBIL_PROBE_GUESS = 28,
  HBIL_PROBE_FLOATS = 32
};

/* Areas of the cache (lib/local_light.clh): voxels across the smallest, floats
 * of each, and the least sum of cosines of surfaces that tells something. */
#define HBIL_AREA_VOXELS 8
enum { HBIL_AREA_FLOATS = 24 };
#define HBIL_AREA_LEAST 3.0f
/* The weight of what areas tell of unseen light, beside the estimate.  It is
 * less where more than half of this share of a probe's rays is unknown, and 0
 * from this share on: then views lack a side of the place, and not only what
 * hides behind something.  It also falls to 0 where of the other rays so many
 * go to the sky, as in the open few hidden surfaces are lit like those seen. */
#define HBIL_AREA_WEIGHT 0.75f
#define HBIL_AREA_HOLE 0.4f
#define HBIL_AREA_SKY 0.25f

/* Floats of a texel of the pyramid (lib/pyramid.clh): light times opacity, and
 * opacity, along +x -x +y -y +z -z; then the shares of its voxels that no view
 * has seen, and that have the sky behind. */
enum { HBIL_MIP_UNSEEN = 24, HBIL_MIP_SKY = 25, HBIL_MIP_FLOATS = 28 };

/* Cones of a probe. */
#define HBIL_CONES 16
/* Where a cone begins, in voxels: a voxel's diagonal, so that it leaves its own
 * surface. */
#define HBIL_CONE_START 1.7f
/* The size of the voxels that a cone is sampled in, over its width.  With
 * interpolation a sample is wider than a voxel (doc/measurements.md). */
#define HBIL_CONE_DETAIL 0.6f
/* What is seen of a sample is divided by the share of it that has been seen, or
 * by this if that is less. */
#define HBIL_CONE_LEAST_SEEN 0.05f

/* Planes of a light propagation volume (lib/volumes.clh). */
#define HBIL_VOLUME_PLANES 15

/* Views of lights: as many as the public header says, texels of each, and how
 * many of them a probe asks. */
enum { HBIL_LIGHT_VIEWS = 4, HBIL_LIGHT_MOST_TEXELS = 1 << 16 };
#define HBIL_RSM_SAMPLES 256

/* Lengths in voxels of level 0, places in cache space. */
typedef struct hbil_light_view_args {
  hbil_view_args view; /* of texels */
  hbil_transform_args to_cache;
  hbil_int flat; /* orthographic */
} hbil_light_view_args;
HBIL_ASSERT_LAYOUT(hbil_light_view_args, flat, 20, 21)
typedef struct hbil_light_views_args {
  hbil_int count;
  hbil_light_view_args light[HBIL_LIGHT_VIEWS];
} hbil_light_views_args;
HBIL_ASSERT_LAYOUT(hbil_light_views_args, light, 1, 85)

/* A probe counts half at a distance from its plane of two thirds of this share
 * of the depth. */
#define HBIL_PROBE_TOLERANCE 0.02f

/* Directions about a normal are in one of two bases, by its z.  Walls that
 * stand upright have a z of plus or minus a rounding, so the bases change where
 * few surfaces do; below -1 no division would be left. */
#define HBIL_BASIS_TURNS (-0.3f)

/* Rays of a probe, where most of the probes around it are alike. */
#define HBIL_PROBE_RAYS 32
/* So many probes across, and down, share one sequence of directions.  The
 * filter is a tent, zero at this distance, so it has all of the sequence in
 * equal shares. */
#define HBIL_PROBE_TILE 3

/* So many frames of probes are averaged, unless something of a probe differs by
 * more than this from its past (doc/measurements.md, "Changes where nothing
 * changes"). */
#define HBIL_PROBE_FRAMES 4
#define HBIL_PROBE_CHANGE 0.25f
/* Surfaces less alike than this are taken for different ones: a place whose
 * probes around it in the last frame are, together, has no past, and a pixel
 * that none of the probes at its cell's corners is like gets one.  A surface as
 * far from a probe's plane as the tolerance counts a quarter. */
#define HBIL_PROBE_LEAST_LIKENESS 0.05f

/* Rays of a probe for the output `glossy`, and the floats of such a probe.
 * Position, validity and normal are those of HBIL_PROBE_. */
#define HBIL_GLOSSY_RAYS 32
enum {
  HBIL_GLOSSY_PROBE_AXIS = 8,     /* reflected direction, view space; 3 */
  HBIL_GLOSSY_PROBE_KNOWN = 11,   /* as HBIL_PROBE_KNOWN, of the lobe */
  HBIL_GLOSSY_PROBE_UNKNOWN = 12, /* likewise */
  HBIL_GLOSSY_PROBE_LIGHT = 13,   /* likewise; 3 */
  HBIL_GLOSSY_PROBE_FLOATS = 16
};

/* cache/probe_*.cl, cache/filter_probes.cl */
typedef struct hbil_probes_args {
  hbil_cache_args cache;
  hbil_probe_grid_args grid;
  hbil_view_args view;
  hbil_transform_args to_cache; /* from view space */
  hbil_transform_args to_view;  /* from cache space */
  hbil_layer_args split;
  hbil_environment_args environment;
  hbil_float scale;  /* voxels of level 0 per world unit */
  hbil_float radius; /* of the near field, in voxels of level 0 */
  hbil_float lobe;   /* as in hbil_gather_args */
} hbil_probes_args;
HBIL_ASSERT_LAYOUT(hbil_probes_args, lobe, 77, 78)

/* cache/follow_probes.cl */
typedef struct hbil_follow_args {
  hbil_probe_grid_args grid;
  hbil_view_args before;     /* the last frame's */
  hbil_transform_args back;  /* from this view space to the last frame's */
  hbil_transform_args forth; /* the other way round */
  hbil_int has_before;
} hbil_follow_args;
HBIL_ASSERT_LAYOUT(hbil_follow_args, has_before, 35, 36)

#ifndef __OPENCL_VERSION__
/* What the bytes of hbil_cache_save() begin with.  States, a byte a voxel for
 * its unlit part, and the floats of voxels follow. */
typedef struct hbil_cache_saved_head {
  char magic[16]; /* with the version */
  cl_uint voxels, levels, updates, unused;
  double voxel_size; /* world units across a voxel of level 0 */
  cl_long middle[3]; /* in voxels of the coarsest level */
  cl_ulong hash; /* of all bytes behind the head, and of the head without it */
} hbil_cache_saved_head;
#endif

#endif
