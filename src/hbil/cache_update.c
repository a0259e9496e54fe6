/* Bounces, moves and the end of what a cache knows. */
#include "cache.h"

#include <math.h>
#include <string.h>

#include "far_field.h"

/* --- clearance --- */

/* Brings what rays read up to date with the states. */
static hbil_status update_clearance(commands *chain, hbil_cache *cache) {
  const hbil_cache_args args = cache_args(cache);
  const size_t n = cache->config.voxels, slices = n * cache->config.levels;
  const cl_int along_y = args.log2_voxels, along_z = 2 * along_y;
  const cl_mem clearance = cache->buffers[CACHE_CLEARANCE];
  const cl_mem part = cache->buffers[CACHE_SCRATCH];
  const argument x[] = {ARG(args), ARG(part), ARG(clearance)};
  const argument y[] = {ARG(args), ARG(along_y), ARG(clearance), ARG(part)};
  const argument z[] = {ARG(args), ARG(along_z), ARG(part), ARG(clearance)};
  hbil_status status = HBIL_SUCCESS;
  for (cl_int level = args.levels - 1; level >= 0 && status == HBIL_SUCCESS;
       --level) {
    const argument list[] = {ARG(args), ARG(level),
                             ARG(cache->buffers[CACHE_STATES]), ARG(part)};
    status = LAUNCH(chain, CACHE_KERNEL_RESOLVE_STATES, list, n / 16, n, n);
  }
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, CACHE_KERNEL_CLEARANCE_ALONG_X, x, n, slices, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, CACHE_KERNEL_CLEARANCE_ALONG, y, n, slices, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, CACHE_KERNEL_CLEARANCE_ALONG, z, n, slices, 1);
  return status;
}

/* --- bounces --- */

/* What each voxel sends, and the mean. */
static hbil_status update_radiance(commands *chain, hbil_cache *cache,
                                   hbil_cache_round_args round) {
  const hbil_cache_args args = cache_args(cache);
  const cl_mem last_change = cache->buffers[CACHE_LAST_CHANGE];
  const argument sent[] = {ARG(args),
                           ARG(cache->buffers[CACHE_STATES]),
                           ARG(cache->buffers[CACHE_VOXELS]),
                           ARG(cache->buffers[CACHE_RADIANCE]),
                           ARG(round),
                           ARG(last_change)};
  const argument part[] = {ARG(args),
                           ARG(cache->buffers[CACHE_STATES]),
                           ARG(cache->buffers[CACHE_RADIANCE]),
                           ARG(cache->buffers[CACHE_UNLIT]),
                           ARG(cache->buffers[CACHE_MEANS]),
                           ARG(round),
                           ARG(last_change)};
  const argument sum[] = {ARG(cache->buffers[CACHE_MEANS]), ARG(round),
                          ARG(last_change)};
  hbil_status status =
      LAUNCH_WORDS(chain, cache, CACHE_KERNEL_UPDATE_RADIANCE, sent);
  if (status == HBIL_SUCCESS)
    status =
        LAUNCH(chain, CACHE_KERNEL_MEAN_PART, part, HBIL_CACHE_PARTS, 1, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, CACHE_KERNEL_MEAN_SUM, sum, 1, 1, 1);
  return status;
}

/* No region has less light than before. */
static hbil_status level_ratios(commands *chain, hbil_cache *cache) {
  const cl_float level = 1.0f;
  cl_uint bits;
  memcpy(&bits, &level, sizeof bits);
  cache->falls = false;
  return fill_memory(chain, cache->buffers[CACHE_RATIOS], bits, 0,
                     cache->bytes[CACHE_RATIOS]);
}

static void forget_nothing(hbil_cache *cache) {
  for (int i = 0; i < HBIL_CACHE_REGIONS; ++i)
    cache->left[i] = 1.0f;
}

/* Regions whose middles are in the box lose so much of the light that the last
 * frame hands on. */
static void forget_regions(hbil_cache *cache,
                           const hbil_cache_forget_args *box) {
  const int across = HBIL_CACHE_REGIONS_ACROSS;
  const float coarsest = (float)(1u << (cache->config.levels - 1));
  const float width = coarsest * (float)cache->config.voxels / (float)across;
  for (int i = 0; i < HBIL_CACHE_REGIONS; ++i) {
    const int at[3] = {i % across, i / across % across, i / (across * across)};
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) {
      const float middle =
          ((float)at[axis] + 0.5f - 0.5f * (float)across) * width;
      inside &= middle > box->low[axis] && middle < box->high[axis];
    }
    cache->left[i] *= inside ? 1.0f - box->light : 1.0f;
  }
}

/* What is told counts, not what views show.  Regions side by side with the same
 * factor are one fill. */
static hbil_status lower_ratios(commands *chain, const hbil_cache *cache) {
  hbil_status status = HBIL_SUCCESS;
  for (int i = 0, end; i < HBIL_CACHE_REGIONS && status == HBIL_SUCCESS;
       i = end) {
    cl_uint bits;
    for (end = i + 1;
         end < HBIL_CACHE_REGIONS && cache->left[end] == cache->left[i];)
      ++end;
    memcpy(&bits, &cache->left[i], sizeof bits);
    if (cache->left[i] < 1.0f)
      status =
          fill_memory(chain, cache->buffers[CACHE_RATIOS], bits,
                      (size_t)i * sizeof bits, (size_t)(end - i) * sizeof bits);
  }
  return status;
}

/* What no view sees any more follows what views see. */
static hbil_status follow_change(commands *chain, hbil_cache *cache) {
  const hbil_cache_args args = cache_args(cache);
  const cl_mem changes = cache->buffers[CACHE_SCRATCH];
  const cl_mem ratios = cache->buffers[CACHE_RATIOS];
  const argument part[] = {ARG(args), ARG(cache->buffers[CACHE_STATES]),
                           ARG(cache->buffers[CACHE_VOXELS]), ARG(changes)};
  const argument region[] = {ARG(changes)};
  const argument ratio[] = {ARG(changes), ARG(ratios)};
  const argument follow[] = {ARG(args), ARG(cache->buffers[CACHE_STATES]),
                             ARG(ratios), ARG(cache->buffers[CACHE_VOXELS])};
  ++cache->changes;
  cache->falls = true;
  hbil_status status =
      LAUNCH(chain, CACHE_KERNEL_CHANGE_PART, part, HBIL_CACHE_PARTS, 1, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, CACHE_KERNEL_CHANGE_REGION, region,
                    HBIL_CACHE_REGIONS, 1, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH(chain, CACHE_KERNEL_CHANGE_RATIO, ratio, HBIL_CACHE_REGIONS,
                    1, 1);
  if (status == HBIL_SUCCESS)
    status = LAUNCH_WORDS(chain, cache, CACHE_KERNEL_FOLLOW_CHANGE, follow);
  if (status == HBIL_SUCCESS)
    status = lower_ratios(chain, cache);
  forget_nothing(cache);
  return status;
}

/* Work-items among which listed surfaces are divided.  Only the device knows
 * how many surfaces there are.  CPUs: eight groups for each core, so that none
 * waits long for the others. */
static size_t items(const hbil_cache *cache) {
  const hbil_context *c = cache->context;
  return c->is_cpu ? 8 * c->group[0] * c->compute_units
                   : cache_voxel_count(&cache->config) / 16;
}

/* Lists the surfaces that this update handles, and traces their rays. */
static hbil_status trace_rays(commands *chain, hbil_cache *cache,
                              const hbil_cache_update *update) {
  const hbil_cache_args where = cache_args(cache);
  const hbil_cache_list_args args = {
      .cache = where,
      .phases = (cl_int)update->phases,
      .phase = (cl_int)(cache->updates % update->phases)};
  const bool takes = cache->has_hits && update->phases == 1;
  const int last = cache->hits, next = !last;
  const hbil_cache_trace_args turn = {
      .cache = where,
      .turns = takes ? HBIL_CACHE_TURNS : 1,
      .turn = (cl_int)(cache->updates % HBIL_CACHE_TURNS)};
  const argument parts[] = {ARG(args), ARG(cache->buffers[CACHE_STATES]),
                            ARG(cache->buffers[CACHE_LIST]),
                            ARG(cache->buffers[CACHE_LAST_LIST])};
  const argument list[] = {ARG(args), ARG(cache->buffers[CACHE_STATES]),
                           ARG(cache->buffers[CACHE_LIST])};
  const argument rays[] = {ARG(turn),
                           ARG(cache->buffers[CACHE_CLEARANCE]),
                           ARG(cache->buffers[CACHE_VOXELS]),
                           ARG(cache->buffers[CACHE_LIST]),
                           ARG(cache->buffers[CACHE_RAY_HITS + next]),
                           ARG(cache->buffers[CACHE_LAST_LIST]),
                           ARG(cache->buffers[CACHE_RAY_HITS + last]),
                           ARG(cache->buffers[CACHE_STATES])};
  cache->hits = next;
  cache->turns_left -= takes ? 1 : cache->turns_left;
  cache->has_hits = update->phases == 1;
  hbil_status status =
      LAUNCH(chain, CACHE_KERNEL_LIST_PARTS, parts, HBIL_CACHE_PARTS, 1, 1);
  if (status == HBIL_SUCCESS)
    status =
        LAUNCH(chain, CACHE_KERNEL_LIST_SURFACES, list, HBIL_CACHE_PARTS, 1, 1);
  return status == HBIL_SUCCESS
             ? LAUNCH(chain, CACHE_KERNEL_TRACE_RAYS, rays, items(cache), 1, 1)
             : status;
}

static hbil_cache_bounce_args bounce_args(const hbil_cache *cache,
                                          const hbil_cache_update *update) {
  hbil_cache_bounce_args args = {
      .cache = cache_args(cache),
      .environment = far_radiance_args(update->far_field, update->environment),
      .unseen_light = cache->config.unseen_light};
  for (int c = 0; update->far_field == HBIL_FAR_FRAME && c < 3; ++c)
    args.sky[c] = update->environment[0][c];
  return args;
}

static hbil_status bounce(commands *chain, hbil_cache *cache,
                          hbil_cache_round_args round) {
  const argument list[] = {ARG(cache->bounced),
                           ARG(cache->buffers[CACHE_LIST]),
                           ARG(cache->buffers[CACHE_RAY_HITS + cache->hits]),
                           ARG(cache->buffers[CACHE_VOXELS]),
                           ARG(cache->buffers[CACHE_RADIANCE]),
                           ARG(cache->buffers[CACHE_MEANS]),
                           ARG(cache->buffers[CACHE_UNLIT]),
                           ARG(round),
                           ARG(cache->buffers[CACHE_LAST_CHANGE])};
  hbil_status status =
      LAUNCH(chain, CACHE_KERNEL_BOUNCE, list, items(cache), 1, 1);
  return status == HBIL_SUCCESS ? update_radiance(chain, cache, round) : status;
}

/* All bounces of an update.  The device leaves out those that would change
 * nothing (cache/bounce.cl). */
static hbil_status bounce_all(commands *chain, hbil_cache *cache,
                              const hbil_cache_update *update, bool traced) {
  if (!update->bounces)
    return HBIL_SUCCESS;
  const hbil_cache_bounce_args args = bounce_args(cache, update);
  /* the floats' bits: a -0 for a 0 is one more round */
  bool fresh = traced || memcmp(&args, &cache->bounced, sizeof args) != 0;
  hbil_status status = HBIL_SUCCESS;
  cache->bounced = args;
  for (cl_uint i = 0; i < update->bounces && status == HBIL_SUCCESS; ++i) {
    const hbil_cache_round_args round = {.number = ++cache->rounds,
                                         .fresh = fresh};
    status = bounce(chain, cache, round);
    fresh = false;
  }
  return status;
}

/* What voxels hold has changed since the last update. */
static hbil_status settle(commands *chain, hbil_cache *cache) {
  const hbil_cache_round_args round = {.number = cache->rounds,
                                       .fresh = CL_TRUE};
  hbil_status status = update_clearance(chain, cache);
  if (status == HBIL_SUCCESS)
    status = follow_change(chain, cache);
  if (status == HBIL_SUCCESS)
    status = update_radiance(chain, cache, round);
  return status;
}

hbil_status update_cache(commands *chain, hbil_cache *cache,
                         const hbil_cache_update *update) {
  const bool settled = cache->settled;
  const bool traced = settled && cache->has_hits && cache->turns_left == 0 &&
                      update->phases == 1;
  const bool traces = update->bounces > 0 && !traced;
  const hbil_cache_round_args since = {.number = cache->rounds,
                                       .fresh = !settled};
  cache->settled = false; /* should anything fail */
  cache->turns_left = settled ? cache->turns_left : HBIL_CACHE_TURNS;
  hbil_status status = !settled       ? settle(chain, cache)
                       : cache->falls ? level_ratios(chain, cache)
                                      : HBIL_SUCCESS;
  if (status == HBIL_SUCCESS && traces)
    status = trace_rays(chain, cache, update);
  if (status == HBIL_SUCCESS)
    status = bounce_all(chain, cache, update, traces);
  if (status == HBIL_SUCCESS)
    status = sum_areas(chain, cache, since);
  if (status == HBIL_SUCCESS)
    status = build_pyramid(chain, cache);
  if (status == HBIL_SUCCESS && cache->config.method == HBIL_CACHE_METHOD_LPV)
    status = spread_light(chain, cache, update);
  cache->updates += update->bounces > 0;
  cache->settled = status == HBIL_SUCCESS;
  cache->has_hits &= cache->settled;
  return status;
}

hbil_status hbil_enqueue_cache_update(hbil_cache *cache, cl_command_queue queue,
                                      const hbil_cache_update *given,
                                      cl_uint wait_count,
                                      const cl_event *wait_list,
                                      cl_event *event) {
  commands chain;
  hbil_cache_update update;
  hbil_status status =
      cache ? cache_update_take(cache->context, given, &update) : HBIL_SUCCESS;
  if (status == HBIL_SUCCESS)
    status = begin_cache_commands(__func__, cache, queue, wait_count, wait_list,
                                  event != NULL, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  status = update_cache(&chain, cache, &update);
  if (status == HBIL_SUCCESS)
    status = finish_commands(&chain, event);
  end_commands(&chain);
  return status;
}

/* --- moves --- */

static const hbil_cache_round_args fresh = {.fresh = CL_TRUE};

/* moved: in voxels of the coarsest level; the cache is there already. */
hbil_status forget_outside(commands *chain, hbil_cache *cache,
                           const cl_long moved[3]) {
  hbil_cache_move_args args = {.cache = cache_args(cache)};
  cache_changed(cache, false); /* numbers are those of other places */
  const cl_long most = cache->config.voxels;
  for (int i = 0; i < 3; ++i)
    args.moved[i] = (cl_int)(moved[i] > most    ? most
                             : moved[i] < -most ? -most
                                                : moved[i]);
  const argument list[] = {ARG(args), ARG(cache->buffers[CACHE_STATES])};
  hbil_status status = LAUNCH_WORDS(chain, cache, CACHE_KERNEL_FORGET, list);
  if (status == HBIL_SUCCESS) /* regions are other places now, too */
    status = level_ratios(chain, cache);
  if (status == HBIL_SUCCESS)
    status = empty_volumes(chain, cache);
  if (status == HBIL_SUCCESS)
    status = update_clearance(chain, cache);
  /* areas and texels are counted from the cache's corner */
  if (status == HBIL_SUCCESS)
    status = sum_areas(chain, cache, fresh);
  return status == HBIL_SUCCESS ? build_pyramid(chain, cache) : status;
}

hbil_status hbil_enqueue_cache_move(hbil_cache *cache, cl_command_queue queue,
                                    const double centre[3], cl_uint wait_count,
                                    const cl_event *wait_list,
                                    cl_event *event) {
  commands chain;
  cl_long before[3], moved[3];
  if (cache && !centre)
    return fail_null(cache->context, __func__, "centre");
  for (int i = 0; cache && i < 3; ++i)
    if (!(fabs(centre[i]) / cache->config.voxel_size < CACHE_FARTHEST_MIDDLE))
      return fail(cache->context, HBIL_INVALID_ARGUMENT,
                  "centre[%d]: %g; must be finite and less than 2^52 voxels "
                  "away",
                  i, centre[i]);
  hbil_status status = begin_cache_commands(__func__, cache, queue, wait_count,
                                            wait_list, event != NULL, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  memcpy(before, cache->middle, sizeof before);
  cache_middle(&cache->config, centre, cache->middle);
  for (int i = 0; i < 3; ++i)
    moved[i] = cache->middle[i] - before[i];
  if (moved[0] || moved[1] || moved[2])
    status = forget_outside(&chain, cache, moved);
  if (status != HBIL_SUCCESS)
    memcpy(cache->middle, before, sizeof before);
  else
    status = finish_commands(&chain, event);
  end_commands(&chain);
  return status;
}

/* --- what the caller knows to have changed --- */

/* A place along an axis in cache space, not farther away than floats are exact.
 */
static cl_float in_cache_space(const hbil_cache *cache, double world,
                               int axis) {
  const double coarsest = ldexp(1.0, (int)cache->config.levels - 1);
  const double at =
      world / cache->config.voxel_size - (double)cache->middle[axis] * coarsest;
  const double most = coarsest * cache->config.voxels;
  return (cl_float)fmin(fmax(at, -most), most);
}

hbil_status hbil_enqueue_cache_forget(hbil_cache *cache, cl_command_queue queue,
                                      const hbil_cache_change *given,
                                      cl_uint wait_count,
                                      const cl_event *wait_list,
                                      cl_event *event) {
  commands chain;
  hbil_cache_change change;
  if (cache && !given)
    return fail_null(cache->context, __func__, "change");
  hbil_status status =
      cache ? cache_change_take(cache->context, given, &change) : HBIL_SUCCESS;
  if (status == HBIL_SUCCESS)
    status = begin_cache_commands(__func__, cache, queue, wait_count, wait_list,
                                  event != NULL, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  hbil_cache_forget_args args = {.cache = cache_args(cache),
                                 .surfaces = change.surfaces,
                                 .light = change.light};
  for (int i = 0; i < 3; ++i) {
    args.low[i] = in_cache_space(cache, change.low[i], i);
    args.high[i] = in_cache_space(cache, change.high[i], i);
  }
  const argument list[] = {ARG(args), ARG(cache->buffers[CACHE_STATES]),
                           ARG(cache->buffers[CACHE_VOXELS])};
  cache_changed(cache, change.surfaces == 0.0f);
  forget_regions(cache, &args);
  status = LAUNCH_WORDS(&chain, cache, CACHE_KERNEL_FORGET_BOX, list);
  if (status == HBIL_SUCCESS)
    status = finish_commands(&chain, event);
  end_commands(&chain);
  return status;
}

/* --- the end --- */

hbil_status forget_all(commands *chain, hbil_cache *cache) {
  hbil_status status = HBIL_SUCCESS;
  cache_changed(cache, false);
  /* voxels, too, so that saved bytes tell nothing of what was before */
  for (int i = 0; i < CACHE_TEXELS && status == HBIL_SUCCESS; ++i)
    status = fill_memory(chain, cache->buffers[i], 0, 0, cache->bytes[i]);
  if (status == HBIL_SUCCESS)
    status = level_ratios(chain, cache);
  if (status == HBIL_SUCCESS)
    status = empty_volumes(chain, cache);
  if (status == HBIL_SUCCESS)
    status = sum_areas(chain, cache, fresh);
  if (status == HBIL_SUCCESS)
    status = build_pyramid(chain, cache);
  cache->updates = 0;
  cache->lights = 0;
  forget_nothing(cache);
  return status;
}

hbil_status hbil_enqueue_cache_reset(hbil_cache *cache, cl_command_queue queue,
                                     cl_uint wait_count,
                                     const cl_event *wait_list,
                                     cl_event *event) {
  commands chain;
  hbil_status status = begin_cache_commands(__func__, cache, queue, wait_count,
                                            wait_list, event != NULL, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  status = forget_all(&chain, cache);
  if (status == HBIL_SUCCESS)
    status = finish_commands(&chain, event);
  end_commands(&chain);
  return status;
}
