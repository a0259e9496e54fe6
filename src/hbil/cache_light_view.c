/* Reflective shadow maps: views from where lights are. */
#include "cache.h"

#include "camera.h"
#include "config.h"

_Static_assert((int)HBIL_LIGHT_VIEWS == HBIL_MAX_LIGHT_VIEWS, "light views");

hbil_status read_light_view(commands *chain, hbil_cache *cache,
                            const hbil_view *view, cl_int number) {
  cache->light[number].camera = view->camera;
  cache->light[number].flat = view->projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  return read_texels(chain, cache, view, CACHE_LIGHT_VIEWS,
                     (cl_uint)number * HBIL_LIGHT_MOST_TEXELS,
                     HBIL_LIGHT_MOST_TEXELS, &cache->light[number].texels);
}

hbil_light_views_args light_views_args(const hbil_cache *cache) {
  const double scale = cache_scale(cache);
  hbil_light_views_args args = {.count = cache->lights};
  double centre[3];
  cache_centre(cache, centre);
  for (int i = 0; i < cache->lights; ++i)
    args.light[i] = (hbil_light_view_args){
        .view = cache->light[i].texels,
        .to_cache =
            camera_to_cache(&cache->light[i].camera, centre, scale, scale),
        .flat = cache->light[i].flat};
  return args;
}

hbil_status hbil_enqueue_cache_light_views(hbil_cache *cache,
                                           cl_command_queue queue,
                                           const hbil_view *views,
                                           cl_uint count, cl_uint wait_count,
                                           const cl_event *wait_list,
                                           cl_event *event) {
  commands chain;
  hbil_view view;
  if (cache && !views && count)
    return fail_null(cache->context, __func__, "views");
  if (cache && cache->config.method != HBIL_CACHE_METHOD_RSM)
    return fail(cache->context, HBIL_INVALID_ARGUMENT,
                "cache: its method is %s; light views need "
                "HBIL_CACHE_METHOD_RSM",
                cache_method_name(cache->config.method));
  if (cache && count > HBIL_MAX_LIGHT_VIEWS)
    return fail(cache->context, HBIL_INVALID_ARGUMENT,
                "count: %u; a cache has %d light views at most",
                (unsigned)count, HBIL_MAX_LIGHT_VIEWS);
  hbil_status status = cache ? check_views(cache, views, count) : HBIL_SUCCESS;
  if (status != HBIL_SUCCESS)
    return status;
  status = begin_cache_commands(__func__, cache, queue, wait_count, wait_list,
                                event != NULL, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  cache->lights = 0;
  for (cl_uint i = 0; i < count && status == HBIL_SUCCESS; ++i) {
    status = view_take(cache->context, view_at(views, i), &view);
    if (status == HBIL_SUCCESS)
      status = read_light_view(&chain, cache, &view, (cl_int)i);
  }
  if (status == HBIL_SUCCESS)
    status = finish_commands(&chain, event);
  if (status == HBIL_SUCCESS)
    cache->lights = (cl_int)count;
  end_commands(&chain);
  return status;
}
