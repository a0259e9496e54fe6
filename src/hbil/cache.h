/* A radiance cache: its kernels and buffers, and where it is. */
#ifndef HBIL_CACHE_H
#define HBIL_CACHE_H

#include "cache_config.h"
#include "lib/cache_args.h"
#include "timeline.h"

/*
 * The programs and kernels of a cache (kernel_set.h).  c is its config.
 *
 * Views are read pixel by pixel, because these may be far apart, and moves are
 * rare.  What is for orthographic views is behind the same for perspective
 * ones.
 */
#define CACHE_PROGRAMS(X)                                                      \
  X(CACHE_PROGRAM_VIEW, "cache/view", true,                                    \
    .defines = "-DORTHOGRAPHIC=0 -DHBIL_WIDTH=1")                              \
  X(CACHE_PROGRAM_VIEW_FLAT, "cache/view", true,                               \
    .defines = "-DORTHOGRAPHIC=1 -DHBIL_WIDTH=1")                              \
  X(CACHE_PROGRAM_INJECT, "cache/inject", true, .defines = "-DORTHOGRAPHIC=0") \
  X(CACHE_PROGRAM_INJECT_FLAT, "cache/inject", true,                           \
    .defines = "-DORTHOGRAPHIC=1")                                             \
  X(CACHE_PROGRAM_CLEARANCE, "cache/clearance", true,                          \
    .defines = "-DHBIL_WIDTH=1")                                               \
  X(CACHE_PROGRAM_RAY_HITS, "cache/ray_hits", true, .relaxed = false)          \
  X(CACHE_PROGRAM_BOUNCE, "cache/bounce", true, .relaxed = true)               \
  X(CACHE_PROGRAM_CHANGE, "cache/change", true, .defines = "-DHBIL_WIDTH=1")   \
  X(CACHE_PROGRAM_MOVE, "cache/move", true, .defines = "-DHBIL_WIDTH=1")       \
  X(CACHE_PROGRAM_LOCAL_LIGHT, "cache/local_light",                            \
    c->method == HBIL_CACHE_METHOD_RAYS, .defines = "-DHBIL_WIDTH=1")          \
  X(CACHE_PROGRAM_PYRAMID, "cache/pyramid",                                    \
    c->method == HBIL_CACHE_METHOD_CONES, .defines = "-DHBIL_WIDTH=1")         \
  X(CACHE_PROGRAM_VOLUMES, "cache/volumes",                                    \
    c->method == HBIL_CACHE_METHOD_LPV, .defines = "-DHBIL_WIDTH=1")           \
  X(CACHE_PROGRAM_PROPAGATE, "cache/propagate",                                \
    c->method == HBIL_CACHE_METHOD_LPV, .relaxed = false)

#define CACHE_KERNELS(X)                                                       \
  X(CACHE_KERNEL_READ_VIEW, "read_view", CACHE_PROGRAM_VIEW, true)             \
  X(CACHE_KERNEL_READ_VIEW_FLAT, "read_view", CACHE_PROGRAM_VIEW_FLAT, true)   \
  X(CACHE_KERNEL_INJECT, "inject", CACHE_PROGRAM_INJECT, true)                 \
  X(CACHE_KERNEL_INJECT_FLAT, "inject", CACHE_PROGRAM_INJECT_FLAT, true)       \
  X(CACHE_KERNEL_RESOLVE_STATES, "resolve_states", CACHE_PROGRAM_CLEARANCE,    \
    true)                                                                      \
  X(CACHE_KERNEL_CLEARANCE_ALONG_X, "clearance_along_x",                       \
    CACHE_PROGRAM_CLEARANCE, true)                                             \
  X(CACHE_KERNEL_CLEARANCE_ALONG, "clearance_along", CACHE_PROGRAM_CLEARANCE,  \
    true)                                                                      \
  X(CACHE_KERNEL_LIST_PARTS, "list_parts", CACHE_PROGRAM_RAY_HITS, true)       \
  X(CACHE_KERNEL_LIST_SURFACES, "list_surfaces", CACHE_PROGRAM_RAY_HITS, true) \
  X(CACHE_KERNEL_TRACE_RAYS, "trace_rays", CACHE_PROGRAM_RAY_HITS, true)       \
  X(CACHE_KERNEL_MEAN_PART, "mean_part", CACHE_PROGRAM_BOUNCE, true)           \
  X(CACHE_KERNEL_MEAN_SUM, "mean_sum", CACHE_PROGRAM_BOUNCE, true)             \
  X(CACHE_KERNEL_BOUNCE, "bounce", CACHE_PROGRAM_BOUNCE, true)                 \
  X(CACHE_KERNEL_UPDATE_RADIANCE, "update_radiance", CACHE_PROGRAM_BOUNCE,     \
    true)                                                                      \
  X(CACHE_KERNEL_CHANGE_PART, "change_part", CACHE_PROGRAM_CHANGE, true)       \
  X(CACHE_KERNEL_CHANGE_REGION, "change_region", CACHE_PROGRAM_CHANGE, true)   \
  X(CACHE_KERNEL_CHANGE_RATIO, "change_ratio", CACHE_PROGRAM_CHANGE, true)     \
  X(CACHE_KERNEL_FOLLOW_CHANGE, "follow_change", CACHE_PROGRAM_CHANGE, true)   \
  X(CACHE_KERNEL_FORGET, "forget", CACHE_PROGRAM_MOVE, true)                   \
  X(CACHE_KERNEL_FORGET_BOX, "forget_box", CACHE_PROGRAM_MOVE, true)           \
  X(CACHE_KERNEL_AREA_LIGHT, "area_light", CACHE_PROGRAM_LOCAL_LIGHT, true)    \
  X(CACHE_KERNEL_JOIN_AREAS, "join_areas", CACHE_PROGRAM_LOCAL_LIGHT, true)    \
  X(CACHE_KERNEL_LEVEL_STEP, "level_step", CACHE_PROGRAM_PYRAMID, true)        \
  X(CACHE_KERNEL_NEXT_STEP, "next_step", CACHE_PROGRAM_PYRAMID, true)          \
  X(CACHE_KERNEL_VOLUME_SOURCES, "volume_sources", CACHE_PROGRAM_VOLUMES,      \
    true)                                                                      \
  X(CACHE_KERNEL_VOLUME_BORDER, "volume_border", CACHE_PROGRAM_PROPAGATE,      \
    true)                                                                      \
  X(CACHE_KERNEL_PROPAGATE, "propagate", CACHE_PROGRAM_PROPAGATE, true)

/* Sums that tell how light has changed (cache/change.cl). */
#define CHANGE_BYTES                                                           \
  (HBIL_CHANGE_SUMS * sizeof(cl_float) * HBIL_CACHE_REGIONS *                  \
   (1 + HBIL_CACHE_PARTS))

/*
 * The buffers of a cache: enumerator and bytes.  voxels is their number in all
 * levels, c the cache's config.
 */
#define CACHE_BUFFERS(X)                                                       \
  /* two bits a voxel */                                                       \
  X(CACHE_STATES, voxels / 4)                                                  \
  /* a byte a voxel: what rays read */                                         \
  X(CACHE_CLEARANCE, voxels)                                                   \
  /* for a moment: the same with clearances along some axes; sums of regions,  \
     then of parts and regions */                                              \
  X(CACHE_SCRATCH, voxels > CHANGE_BYTES ? voxels : CHANGE_BYTES)              \
  X(CACHE_VOXELS, HBIL_VOXEL_FLOATS * sizeof(cl_float) * voxels)               \
  /* a word a voxel: what it sends */                                          \
  X(CACHE_RADIANCE, sizeof(cl_uint) * voxels)                                  \
  /* a byte a voxel: how much of the open is no sky */                         \
  X(CACHE_UNLIT, voxels)                                                       \
  /* mean radiance and unlit part; then sums of parts */                       \
  X(CACHE_MEANS, 8 * sizeof(cl_float) * (1 + HBIL_CACHE_PARTS))                \
  /* the number of the round of bounces that changed something last */         \
  X(CACHE_LAST_CHANGE, sizeof(cl_uint))                                        \
  /* factors of regions */                                                     \
  X(CACHE_RATIOS, sizeof(cl_float) * HBIL_CACHE_REGIONS)                       \
  /* of the view that is being injected */                                     \
  X(CACHE_TEXELS,                                                              \
    HBIL_TEXEL_WORDS * sizeof(cl_uint) * (size_t)HBIL_CACHE_MOST_TEXELS)       \
  /* the surfaces of an update (lib/ray_hits.clh), and where their rays        \
     end; vectors are read, so some more behind the last */                    \
  X(CACHE_LIST, sizeof(cl_uint) * (HBIL_LIST_HEAD + voxels))                   \
  X(CACHE_LAST_LIST,                                                           \
    sizeof(cl_uint) * (HBIL_LIST_HEAD + voxels / HBIL_LAST_LIST))              \
  X(CACHE_RAY_HITS,                                                            \
    sizeof(cl_uint) * (HBIL_CACHE_RAY_HITS * voxels + HBIL_WIDEST))            \
  X(CACHE_RAY_HITS_NEXT,                                                       \
    sizeof(cl_uint) * (HBIL_CACHE_RAY_HITS * voxels + HBIL_WIDEST))            \
  /* HBIL_AREA_FLOATS floats an area (lib/local_light.clh) */                  \
  X(CACHE_AREAS, c->method == HBIL_CACHE_METHOD_RAYS                           \
                     ? HBIL_AREA_FLOATS * sizeof(cl_float) *                   \
                           cubes_of_steps(c, HBIL_AREA_VOXELS)                 \
                     : 0)                                                      \
  /* HBIL_MIP_FLOATS floats a texel (lib/pyramid.clh) */                       \
  X(CACHE_PYRAMID,                                                             \
    c->method == HBIL_CACHE_METHOD_CONES                                       \
        ? HBIL_MIP_FLOATS * sizeof(cl_float) * cubes_of_steps(c, 2)            \
        : 0)                                                                   \
  /* planes of volumes (lib/volumes.clh); the last ones after a step */        \
  X(CACHE_SOURCES, volume_bytes(c, 12))                                        \
  X(CACHE_OPACITIES, volume_bytes(c, 6))                                       \
  X(CACHE_VOLUMES, volume_bytes(c, HBIL_VOLUME_PLANES))                        \
  X(CACHE_VOLUMES_NEXT, volume_bytes(c, HBIL_VOLUME_PLANES))                   \
  /* HBIL_LIGHT_MOST_TEXELS texels each */                                     \
  X(CACHE_LIGHT_VIEWS, c->method == HBIL_CACHE_METHOD_RSM                      \
                           ? sizeof(cl_uint) * HBIL_MAX_LIGHT_VIEWS *          \
                                 HBIL_TEXEL_WORDS *                            \
                                 (size_t)HBIL_LIGHT_MOST_TEXELS                \
                           : 0)

enum { CACHE_PROGRAMS(LISTED_ENUMERATOR) CACHE_PROGRAM_COUNT };
enum { CACHE_KERNELS(LISTED_ENUMERATOR) CACHE_KERNEL_COUNT };
enum { CACHE_BUFFERS(LISTED_ENUMERATOR) CACHE_BUFFER_COUNT };
_Static_assert((int)CACHE_PROGRAM_COUNT <= (int)MOST_PROGRAMS, "MOST_PROGRAMS");
_Static_assert((int)CACHE_KERNEL_COUNT <= (int)MOST_KERNELS, "MOST_KERNELS");

struct hbil_cache {
  hbil_context *context;
  hbil_cache_config config;
  hbil_config views; /* formats of views, with the size of one pixel */
  kernel_set kernels;
  cl_mem buffers[CACHE_BUFFER_COUNT];
  size_t bytes[CACHE_BUFFER_COUNT]; /* of these */
  timeline line;
  cl_long middle[3]; /* in voxels of the coarsest level */
  cl_uint updates;   /* with bounces so far, which choose the voxels */
  bool settled;      /* voxels are as they were after the last update */
  bool has_hits;     /* of all surfaces; the cache hasn't moved since */
  cl_uint changes;   /* times that factors of regions were found */
  bool falls;        /* they may be below 1 */
  float left[HBIL_CACHE_REGIONS]; /* of light, by what was forgotten since */
  cl_uint turns_left; /* updates until all hits are of what voxels are now */
  int hits;           /* which of the two buffers has them */
  cl_uint rounds;     /* of bounces so far */
  /* what the last bounces were computed with */
  hbil_cache_bounce_args bounced;
  /* the view that was injected last (exposure 0: none), and how many static
   * ones in a row */
  hbil_camera seen;
  float seen_exposure;
  cl_uint static_views;
  struct {
    hbil_camera camera;
    hbil_view_args texels; /* lengths in voxels of level 0 */
    bool flat;
  } light[HBIL_MAX_LIGHT_VIEWS]; /* views in CACHE_LIGHT_VIEWS ... */
  cl_int lights;                 /* ... and how many there are */
};

/* Numbers of voxels of all levels. */
size_t cache_voxel_count(const hbil_cache_config *config);
/* Cubes of so many voxels across: those of each level and, beyond these, of
 * twice as many until one fills the cache. */
size_t cubes_of_steps(const hbil_cache_config *config, size_t across);
/* Enqueues a kernel for all words of states. */
#define LAUNCH_WORDS(chain, cache, kernel, args)                               \
  LAUNCH(chain, kernel, args, (cache)->config.voxels / 16,                     \
         (cache)->config.voxels,                                               \
         (size_t)(cache)->config.voxels * (cache)->config.levels)
/* Bytes of each buffer; fails if the device can't have one of them. */
hbil_status cache_sizes(hbil_context *context, const hbil_cache_config *config,
                        size_t bytes[CACHE_BUFFER_COUNT]);

/* Where the cache is, as kernels take it; the middle in the world; voxels of
 * level 0 per world unit. */
hbil_cache_args cache_args(const hbil_cache *cache);
void cache_centre(const hbil_cache *cache, double centre[3]);
double cache_scale(const hbil_cache *cache);
/* The middle, in voxels of the coarsest level, that is nearest to a place. */
void cache_middle(const hbil_cache_config *config, const double centre[3],
                  cl_long middle[3]);

/* Notes that what voxels hold changes by something else than views.  hits_hold:
 * rays still end where they did. */
static inline void cache_changed(hbil_cache *cache, bool hits_hold) {
  cache->settled = false;
  cache->has_hits &= hits_hold;
  cache->static_views = 0;
  cache->seen_exposure = 0.0f;
}

/* A chain for a cache's commands in a queue. */
commands commands_of_cache(hbil_cache *cache, cl_command_queue queue);

/* Checks the arguments of a public function and begins its commands.
 * end_commands() ends them, unless this fails. */
hbil_status begin_cache_commands(const char *function, hbil_cache *cache,
                                 cl_command_queue queue, cl_uint wait_count,
                                 const cl_event *wait_list, bool with_event,
                                 commands *chain);

/* cache_inject.c, cache_update.c: launch their kernels.  In trial launches
 * `view` has no planes. */
hbil_status inject_view(commands *chain, hbil_cache *cache,
                        const hbil_view *view);
hbil_status update_cache(commands *chain, hbil_cache *cache,
                         const hbil_cache_update *update);
/* cache_areas.c, cache_pyramid.c, cache_volumes.c: bring them up to date with
 * the voxels.  They do nothing in caches without them, but spread_light().
 * since: the last round of bounces before this update; fresh if more than
 * radiance may have changed. */
hbil_status sum_areas(commands *chain, hbil_cache *cache,
                      hbil_cache_round_args since);
hbil_status build_pyramid(commands *chain, hbil_cache *cache);
hbil_status empty_volumes(commands *chain, hbil_cache *cache);
hbil_status spread_light(commands *chain, hbil_cache *cache,
                         const hbil_cache_update *update);
/* cache_light_view.c: makes a view the light view `number`; and all of them as
 * the kernel takes them. */
hbil_status read_light_view(commands *chain, hbil_cache *cache,
                            const hbil_view *view, cl_int number);
hbil_light_views_args light_views_args(const hbil_cache *cache);
/* cache_inject.c: the i-th of a caller's views, and the checks of all. */
const hbil_view *view_at(const hbil_view *views, cl_uint i);
hbil_status check_views(hbil_cache *cache, const hbil_view *views,
                        cl_uint count);
/* cache_inject.c: a view becomes a table of `most` texels or fewer, which
 * begins behind `first` texels of a buffer and whose camera is *of_texels. */
hbil_status read_texels(commands *chain, hbil_cache *cache,
                        const hbil_view *view, int buffer, cl_uint first,
                        cl_uint most, hbil_view_args *of_texels);
hbil_status forget_outside(commands *chain, hbil_cache *cache,
                           const cl_long moved[3]);
hbil_status forget_all(commands *chain, hbil_cache *cache);

#endif
