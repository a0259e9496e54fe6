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
  CACHE_PROGRAM_WAYS,
  CACHE_PROGRAM_BOUNCE,
  CACHE_PROGRAM_MOVE,
  CACHE_PROGRAM_COUNT
};

enum {
  CACHE_KERNEL_READ_VIEW, /* likewise */
  CACHE_KERNEL_READ_VIEW_FLAT,
  CACHE_KERNEL_INJECT,
  CACHE_KERNEL_INJECT_FLAT,
  CACHE_KERNEL_RESOLVE,
  CACHE_KERNEL_BRICK,
  CACHE_KERNEL_MEAN_PART,
  CACHE_KERNEL_MEAN_SUM,
  CACHE_KERNEL_BOUNCE,
  CACHE_KERNEL_PUBLISH,
  CACHE_KERNEL_FORGET,
  CACHE_KERNEL_COUNT
};
/* trial launches are counted by kernel */
_Static_assert((int)CACHE_KERNEL_COUNT <= (int)KERNEL_COUNT, "KERNEL_COUNT");

enum {
  CACHE_STATES,   /* two bits a voxel */
  CACHE_WAYS,     /* as states: what rays read */
  CACHE_BRICKS,   /* a word a brick */
  CACHE_VOXELS,   /* HBIL_VOXEL_FLOATS floats a voxel */
  CACHE_RADIANCE, /* a word a voxel: what it sends */
  CACHE_UNLIT,    /* a byte a voxel: how much of the open is no sky */
  CACHE_MEANS,    /* mean radiance and unlit part; then sums of parts */
  CACHE_TEXELS,   /* of the view that is being injected */
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
  cl_uint round;     /* of bounces so far, which turns their rays */
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
hbil_status forget_outside(commands *chain, hbil_cache *cache,
                           const cl_long moved[3]);
hbil_status forget_all(commands *chain, hbil_cache *cache);

#endif
