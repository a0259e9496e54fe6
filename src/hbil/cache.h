/* A radiance cache: its kernels and buffers, and where it is. */
#ifndef HBIL_CACHE_H
#define HBIL_CACHE_H

#include "commands.h"
#include "lib/cache_args.h"

enum {
  /* each also for orthographic views, behind the one for perspective views */
  CACHE_PROGRAM_VIEW,
  CACHE_PROGRAM_VIEW_FLAT,
  CACHE_PROGRAM_INJECT,
  CACHE_PROGRAM_INJECT_FLAT,
  CACHE_PROGRAM_CLEARANCE,
  CACHE_PROGRAM_RAY_HITS,
  CACHE_PROGRAM_BOUNCE,
  CACHE_PROGRAM_MOVE,
  CACHE_PROGRAM_PYRAMID,
  CACHE_PROGRAM_VOLUMES,
  CACHE_PROGRAM_PROPAGATE,
  CACHE_PROGRAM_COUNT
};

enum {
  CACHE_KERNEL_READ_VIEW, /* likewise */
  CACHE_KERNEL_READ_VIEW_FLAT,
  CACHE_KERNEL_INJECT,
  CACHE_KERNEL_INJECT_FLAT,
  CACHE_KERNEL_RESOLVE_STATES,
  CACHE_KERNEL_CLEARANCE_ALONG_X,
  CACHE_KERNEL_CLEARANCE_ALONG,
  CACHE_KERNEL_LIST_PARTS,
  CACHE_KERNEL_LIST_SURFACES,
  CACHE_KERNEL_TRACE_RAYS,
  CACHE_KERNEL_MEAN_PART,
  CACHE_KERNEL_MEAN_SUM,
  CACHE_KERNEL_BOUNCE,
  CACHE_KERNEL_UPDATE_RADIANCE,
  CACHE_KERNEL_FORGET,
  CACHE_KERNEL_LEVEL_STEP,
  CACHE_KERNEL_NEXT_STEP,
  CACHE_KERNEL_VOLUME_SOURCES,
  CACHE_KERNEL_VOLUME_BORDER,
  CACHE_KERNEL_PROPAGATE,
  CACHE_KERNEL_COUNT
};
/* trial launches are counted by kernel */
_Static_assert((int)CACHE_KERNEL_COUNT <= (int)KERNEL_COUNT, "KERNEL_COUNT");

enum {
  CACHE_STATES,    /* two bits a voxel */
  CACHE_CLEARANCE, /* a byte a voxel: what rays read (cache/clearance.cl) */
  CACHE_CLEARANCE_PART, /* the same, with clearances along some axes */
  CACHE_VOXELS,         /* HBIL_VOXEL_FLOATS floats a voxel */
  CACHE_RADIANCE,       /* a word a voxel: what it sends */
  CACHE_UNLIT,          /* a byte a voxel: how much of the open is no sky */
  CACHE_MEANS,          /* mean radiance and unlit part; then sums of parts */
  CACHE_TEXELS,         /* of the view that is being injected */
  CACHE_LIST,           /* the surfaces of an update (lib/ray_hits.clh) ... */
  CACHE_RAY_HITS,       /* ... and where their rays end */
  /* for other providers than rays */
  CACHE_PYRAMID,      /* HBIL_MIP_FLOATS floats a texel (lib/pyramid.clh) */
  CACHE_SOURCES,      /* 12 planes a volume (lib/volumes.clh) */
  CACHE_OPACITIES,    /* 6 planes a volume */
  CACHE_VOLUMES,      /* HBIL_VOLUME_PLANES planes a volume ... */
  CACHE_VOLUMES_NEXT, /* ... and the same after a step */
  CACHE_LIGHT_VIEWS,  /* HBIL_LIGHT_MOST_TEXELS texels each */
  CACHE_BUFFER_COUNT
};

struct hbil_cache {
  hbil_context *context;
  hbil_cache_config config;
  hbil_plan views; /* holds the views' formats, for checks; it has no device
                      memory and no kernels */
  cl_program programs[CACHE_PROGRAM_COUNT];
  cl_kernel kernels[CACHE_KERNEL_COUNT];
  cl_mem buffers[CACHE_BUFFER_COUNT];
  timeline line;
  cl_long middle[3]; /* in voxels of the coarsest level */
  cl_uint updates;   /* with bounces so far, which choose the voxels */
  struct {
    hbil_camera camera;
    hbil_view_args texels; /* lengths in voxels of level 0 */
    bool flat;
  } light[HBIL_MAX_LIGHT_VIEWS]; /* views in CACHE_LIGHT_VIEWS ... */
  cl_int lights;                 /* ... and how many there are */
};

/* Numbers of voxels of all levels. */
size_t cache_voxel_count(const hbil_cache_config *config);
/* Enqueues a kernel for all words of states. */
#define LAUNCH_WORDS(chain, cache, kernel, args)                               \
  LAUNCH(chain, kernel, args, (cache)->config.voxels / 16,                     \
         (cache)->config.voxels,                                               \
         (size_t)(cache)->config.voxels * (cache)->config.levels)
/* Rejects a cache whose buffers the device can't have. */
hbil_status cache_check_memory(hbil_context *context,
                               const hbil_cache_config *config);
/* Bytes of a buffer. */
size_t cache_buffer_bytes(const hbil_cache_config *config, int buffer);

/* Where the cache is, as kernels take it; the middle in the world; voxels of
 * level 0 per world unit. */
hbil_cache_args cache_args(const hbil_cache *cache);
void cache_centre(const hbil_cache *cache, double centre[3]);
double cache_scale(const hbil_cache *cache);
/* The middle, in voxels of the coarsest level, that is nearest to a place. */
void cache_middle(const hbil_cache_config *config, const double centre[3],
                  cl_long middle[3]);

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
/* cache_pyramid.c, cache_volumes.c: bring them up to date with the voxels. They
 * do nothing in caches without them, but spread_light(). */
hbil_status build_pyramid(commands *chain, hbil_cache *cache);
hbil_status empty_volumes(commands *chain, hbil_cache *cache);
hbil_status spread_light(commands *chain, hbil_cache *cache,
                         const hbil_cache_update *update);
/* cache_light_view.c: makes a view the light view `number`; and all of them as
 * the kernel takes them. */
hbil_status read_light_view(commands *chain, hbil_cache *cache,
                            const hbil_view *view, cl_int number);
hbil_light_views_args light_views_args(const hbil_cache *cache);
/* cache_inject.c: the i-th of a caller's views, and its checks. */
const hbil_view *view_at(const hbil_view *views, cl_uint i);
hbil_status check_view(hbil_cache *cache, const hbil_view *views, cl_uint i);
/* cache_inject.c: a view becomes a table of `most` texels or fewer, which
 * begins behind `first` texels of a buffer and whose camera is *of_texels. */
hbil_status read_texels(commands *chain, hbil_cache *cache,
                        const hbil_view *view, int buffer, cl_uint first,
                        cl_uint most, hbil_view_args *of_texels);
hbil_status forget_outside(commands *chain, hbil_cache *cache,
                           const cl_long moved[3]);
hbil_status forget_all(commands *chain, hbil_cache *cache);

#endif
