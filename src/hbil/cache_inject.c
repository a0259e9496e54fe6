/* Injection: what views show becomes what the cache knows. */
#include "cache.h"

#include <math.h>
#include <string.h>

#include "camera.h"
#include "checks.h"
#include "planes.h"

/* A view as the checks and the planes' addresses have a frame. */
static hbil_frame frame_of_view(const hbil_view *view) {
  hbil_frame frame;
  hbil_frame_init(&frame);
  frame.camera = view->camera;
  frame.depth = view->depth;
  frame.normal = view->normal;
  frame.albedo = view->albedo;
  frame.f0 = view->f0;
  frame.direct = view->direct;
  frame.emission = view->emission;
  memcpy(frame.hardware_depth, view->hardware_depth,
         sizeof frame.hardware_depth);
  return frame;
}

/* The formats of a plan whose frames are like this view. */
static hbil_config config_of_view(const hbil_cache *cache,
                                  const hbil_view *view) {
  hbil_config config = cache->views;
  config.width = view->width;
  config.height = view->height;
  config.inputs.projection = view->projection;
  return config;
}

/* A caller's view, whose header may have a smaller struct: views are as far
 * apart as the first one says. */
const hbil_view *view_at(const hbil_view *views, cl_uint i) {
  return (const hbil_view *)((const char *)views +
                             (size_t)i * views->struct_size);
}

static hbil_status check_view(hbil_cache *cache, const hbil_view *views,
                              cl_uint i) {
  hbil_view view;
  const hbil_view *given = view_at(views, i);
  if (given->struct_size != views->struct_size)
    return fail(cache->context, HBIL_INVALID_FRAME,
                "struct_size: %zu, that of views[0] is %zu; call "
                "hbil_view_init() for each",
                given->struct_size, views->struct_size);
  hbil_status status = view_take(cache->context, given, &view);
  if (status != HBIL_SUCCESS)
    return status;
  const hbil_frame frame = frame_of_view(&view);
  const hbil_config config = config_of_view(cache, &view);
  const staging staged = {0, 0};
  const plane_rules rules = {.context = cache->context,
                             .config = &config,
                             .staged = &staged,
                             .owner = "cache"};
  status = camera_check(cache->context, &view.camera);
  if (status == HBIL_SUCCESS)
    status = check_exposure(cache->context, HBIL_INVALID_FRAME, view.exposure);
  return status == HBIL_SUCCESS ? check_planes(&rules, &frame, INPUT_PLANES)
                                : status;
}

hbil_status check_views(hbil_cache *cache, const hbil_view *views,
                        cl_uint count) {
  hbil_status status = HBIL_SUCCESS;
  for (cl_uint i = 0; i < count && status == HBIL_SUCCESS; ++i) {
    cache->context->checked_view = count > 1 ? i + 1 : 0;
    status = check_view(cache, views, i);
  }
  cache->context->checked_view = 0;
  return status;
}

/* Every `stride`th pixel and row fit into a table of so many texels. */
static cl_uint stride_of(const hbil_view *view, cl_uint most) {
  cl_uint stride = 1;
  while ((size_t)((view->width + stride - 1) / stride) *
             ((view->height + stride - 1) / stride) >
         most)
    ++stride;
  return stride;
}

static hbil_cache_view_args view_args(const hbil_cache *cache,
                                      const hbil_config *config,
                                      const hbil_view *view,
                                      const hbil_frame *frame, cl_uint most) {
  const cl_uint stride = stride_of(view, most);
  return (hbil_cache_view_args){
      .view = camera_view(&view->camera, config),
      .stride = (cl_int)stride,
      .width = (cl_int)((view->width + stride - 1) / stride),
      .height = (cl_int)((view->height + stride - 1) / stride),
      .finished = view->light == HBIL_VIEW_FINISHED,
      .scale = (cl_float)cache_scale(cache),
      .normals = camera_view_from_normals(&view->camera, config),
      .to_world = camera_to_world(&view->camera),
      .decode = depth_args(config, frame),
      .per_exposure = 1.0f / light_exposure(view->exposure)};
}

/* The view of the texels, whose lengths are in voxels: pixel x is texel
 * x / stride, and both have their centres half a pixel on. */
static hbil_view_args texel_view(const hbil_cache *cache, const hbil_view *view,
                                 const hbil_cache_view_args *table) {
  const double stride = table->stride;
  const bool flat = view->projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const double unit = stride * (flat ? cache_scale(cache) : 1.0);
  hbil_view_args v = {.width = table->width,
                      .height = table->height,
                      .fx = (cl_float)(view->camera.fx / unit),
                      .fy = (cl_float)(view->camera.fy / unit),
                      .cx = (cl_float)((view->camera.cx - 0.5) / stride + 0.5),
                      .cy = (cl_float)((view->camera.cy - 0.5) / stride + 0.5)};
  v.inv_fx = 1.0f / v.fx;
  v.inv_fy = 1.0f / v.fy;
  return v;
}

hbil_status read_texels(commands *chain, hbil_cache *cache,
                        const hbil_view *view, int buffer, cl_uint first,
                        cl_uint most, hbil_view_args *of_texels) {
  const hbil_config config = config_of_view(cache, view);
  const int flat = view->projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const hbil_frame frame = frame_of_view(view);
  hbil_cache_view_args table = view_args(cache, &config, view, &frame, most);
  table.first = (cl_int)first;
  const cl_mem depth = plane_bind(&config, &frame, PLANE_DEPTH, &table.depth);
  const cl_mem normal =
      plane_bind(&config, &frame, PLANE_NORMAL, &table.normal);
  const cl_mem albedo =
      plane_bind(&config, &frame, PLANE_ALBEDO, &table.surface.albedo);
  const cl_mem f0 = plane_bind(&config, &frame, PLANE_F0, &table.surface.f0);
  const cl_mem direct =
      plane_bind(&config, &frame, PLANE_DIRECT, &table.surface.direct);
  const cl_mem emission =
      plane_bind(&config, &frame, PLANE_EMISSION, &table.surface.emission);
  table.surface.direct_scale =
      table.finished ? 1.0f : config.inputs.direct_scale;
  const argument read[] = {ARG(table),  ARG(cache->buffers[buffer]),
                           ARG(depth),  ARG(normal),
                           ARG(albedo), ARG(f0),
                           ARG(direct), ARG(emission)};
  *of_texels = texel_view(cache, view, &table);
  return LAUNCH(chain, CACHE_KERNEL_READ_VIEW + flat, read, (size_t)table.width,
                (size_t)table.height, 1);
}

hbil_status inject_view(commands *chain, hbil_cache *cache,
                        const hbil_view *view) {
  const int flat = view->projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const double scale = cache_scale(cache);
  double centre[3];
  cache->settled = false;
  hbil_cache_inject_args args = {.cache = cache_args(cache),
                                 .finished = view->light == HBIL_VIEW_FINISHED};
  hbil_status status = read_texels(chain, cache, view, CACHE_TEXELS, 0,
                                   HBIL_CACHE_MOST_TEXELS, &args.view);
  cache_centre(cache, centre);
  args.to_view = camera_from_cache(&view->camera, centre, scale, scale);
  args.to_cache = camera_to_cache(&view->camera, centre, scale, scale);
  const argument inject[] = {ARG(args), ARG(cache->buffers[CACHE_TEXELS]),
                             ARG(cache->buffers[CACHE_STATES]),
                             ARG(cache->buffers[CACHE_VOXELS]),
                             ARG(cache->buffers[CACHE_RADIANCE])};
  if (status == HBIL_SUCCESS)
    status = LAUNCH_WORDS(chain, cache, CACHE_KERNEL_INJECT + flat, inject);
  return status;
}

/* --- static views --- */

/* Whether a call's view may be left out, because enough like it have come
 * before it.  Remembers it. */
static bool is_known(hbil_cache *cache, const hbil_view *view, bool alone) {
  const float exposure = light_exposure(view->exposure);
  const bool same = view->static_view && alone &&
                    exposure == cache->seen_exposure &&
                    !memcmp(&view->camera, &cache->seen, sizeof cache->seen);
  cache->static_views = same ? cache->static_views + 1 : 0;
  if (cache->static_views > HBIL_STATIC_VIEWS) {
    cache->static_views = HBIL_STATIC_VIEWS;
    return true;
  }
  cache->seen = view->camera;
  cache->seen_exposure = alone ? exposure : 0.0f; /* no exposure is 0 */
  return false;
}

/* --- the order of views --- */

/* Less than 0 if a is injected before b.  Means in floats depend on the order
 * of what they are of, so views have an order of their own.  Finished radiance
 * comes last: it replaces direct light. */
static int compare(const hbil_view *a, const hbil_view *b) {
  if (a->light != b->light)
    return a->light < b->light ? -1 : 1;
  if (a->projection != b->projection)
    return a->projection < b->projection ? -1 : 1;
  if (a->width != b->width)
    return a->width < b->width ? -1 : 1;
  if (a->height != b->height)
    return a->height < b->height ? -1 : 1;
  return memcmp(&a->camera, &b->camera, sizeof a->camera);
}

/* Whether view i comes before view k; equal ones in the caller's order. */
static bool is_before(const hbil_view *views, cl_uint i, cl_uint k) {
  const int order = compare(view_at(views, i), view_at(views, k));
  return order < 0 || (order == 0 && i < k);
}

/* The next view after `last` (count: the first one) in that order; `count`
 * after the last one.  Nothing is allocated, and views are few. */
static cl_uint next_view(const hbil_view *views, cl_uint count, cl_uint last) {
  cl_uint best = count;
  for (cl_uint i = 0; i < count; ++i)
    if ((last == count || is_before(views, last, i)) &&
        (best == count || is_before(views, i, best)))
      best = i;
  return best;
}

hbil_status hbil_enqueue_cache_inject(hbil_cache *cache, cl_command_queue queue,
                                      const hbil_view *views, cl_uint count,
                                      cl_uint wait_count,
                                      const cl_event *wait_list,
                                      cl_event *event) {
  commands chain;
  hbil_view view;
  if (cache && !views && count)
    return fail_null(cache->context, __func__, "views");
  hbil_status status = cache ? check_views(cache, views, count) : HBIL_SUCCESS;
  if (status != HBIL_SUCCESS)
    return status;
  status = begin_cache_commands(__func__, cache, queue, wait_count, wait_list,
                                event != NULL, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  for (cl_uint i = next_view(views, count, count);
       i < count && status == HBIL_SUCCESS; i = next_view(views, count, i)) {
    status = view_take(cache->context, view_at(views, i), &view);
    if (status == HBIL_SUCCESS && !is_known(cache, &view, count == 1))
      status = inject_view(&chain, cache, &view);
  }
  if (status != HBIL_SUCCESS)
    cache_changed(cache, true);
  if (status == HBIL_SUCCESS)
    status = finish_commands(&chain, event);
  end_commands(&chain);
  return status;
}
