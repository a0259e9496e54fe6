/* A radiance cache on the content. */
#include "bench/radiance_cache.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/settings.h"
#include "image/quantile.h"

static int check(const bench_radiance_cache *w, hbil_status status,
                 image_error *error) {
  return status == HBIL_SUCCESS
             ? 0
             : image_fail(error, "device %s: %s", w->device->name,
                          hbil_context_message(
                              bench_fixture_context(w->trial.fixture)));
}

/* --- the cache --- */

/* A cube about the eye that holds nearly all surfaces. */
static int choose_extent(bench_radiance_cache *w, image_error *error) {
  const size_t pixels = bench_pixels(w->content);
  const bench_frame *frame = w->content->frame;
  double *depths = malloc(pixels * sizeof *depths);
  size_t count = 0;
  if (!depths)
    return image_no_memory(error, "depths");
  for (size_t i = 0; i < pixels; i++)
    if (bench_is_surface(w->content, i))
      depths[count++] = (double)frame->plane[BENCH_DEPTH][i];
  const double radius = count ? quantile(depths, count, 0.995) : 1.0;
  free(depths);
  w->config.voxel_size = radius / (0.5 * w->config.voxels - 2.0) /
                         ldexp(1.0, (int)w->config.levels - 1);
  for (int r = 0; r < 3; r++)
    w->config.centre[r] = frame->camera.world_from_view[4 * r + 3];
  return 0;
}

static int open_plan(bench_radiance_cache *w, bench_fixture *fixture,
                     hbil_cache_method method, image_error *error) {
  const bench_setting standard = bench_setting_default(w->content);
  hbil_config config;
  bench_setting_apply(&standard, w->content, &config);
  w->config.method = method;
  hbil_config_use_cache(&config, &w->config);
  return bench_trial_open(fixture, &config, NULL, &w->trial, error);
}

static int open_cache(bench_radiance_cache *w, image_error *error) {
  hbil_context *context = bench_fixture_context(w->trial.fixture);
  w->config.inputs = w->trial.config.inputs; /* with the fixture's formats */
  hbil_status status = hbil_cache_memory(context, &w->config, &w->memory);
  if (status == HBIL_SUCCESS)
    status = hbil_cache_create(context, &w->config, &w->cache);
  w->trial.cache = w->cache;
  return check(w, status, error);
}

int bench_radiance_cache_open(const bench_device *device,
                              const bench_content *content,
                              bench_fixture *fixture, hbil_cache_method method,
                              bench_radiance_cache *out, image_error *error) {
  *out = (bench_radiance_cache){.device = device, .content = content};
  hbil_cache_config_init(&out->config);
  return choose_extent(out, error) != 0 ||
                 open_plan(out, fixture, method, error) != 0 ||
                 open_cache(out, error) != 0
             ? -1
             : 0;
}

void bench_radiance_cache_close(bench_radiance_cache *w) {
  bench_trial_close(&w->trial);
  hbil_cache_destroy(w->cache);
  w->cache = NULL;
}

/* --- commands --- */

static int inject(const bench_radiance_cache *w, unsigned frame,
                  cl_bool is_static, image_error *error) {
  hbil_view view;
  bench_trial_view(&w->trial, frame, &view);
  view.static_view = is_static;
  return check(w,
               hbil_enqueue_cache_inject(w->cache, w->device->queue, &view, 1,
                                         0, NULL, NULL),
               error);
}

int bench_radiance_cache_inject(const bench_radiance_cache *w, unsigned frame,
                                image_error *error) {
  return inject(w, frame, CL_FALSE, error);
}

int bench_radiance_cache_inject_static(const bench_radiance_cache *w,
                                       unsigned frame, image_error *error) {
  return inject(w, frame, CL_TRUE, error);
}

int bench_radiance_cache_light(const bench_radiance_cache *w, unsigned frame,
                               image_error *error) {
  hbil_view view;
  bench_trial_view(&w->trial, frame, &view);
  return check(w,
               hbil_enqueue_cache_light_views(w->cache, w->device->queue, &view,
                                              1, 0, NULL, NULL),
               error);
}

int bench_radiance_cache_update(const bench_radiance_cache *w, cl_uint bounces,
                                cl_uint phases, cl_uint steps,
                                image_error *error) {
  hbil_cache_update how;
  hbil_cache_update_init(&how);
  how.bounces = bounces;
  how.phases = phases;
  how.steps = steps;
  how.far_field = w->trial.config.model.far_field;
  memcpy(how.environment, w->content->environment, sizeof how.environment);
  return check(w,
               hbil_enqueue_cache_update(w->cache, w->device->queue, &how, 0,
                                         NULL, NULL),
               error);
}

int bench_radiance_cache_finish(const bench_radiance_cache *w,
                                image_error *error) {
  const cl_int status = clFinish(w->device->queue);
  return status == CL_SUCCESS
             ? 0
             : bench_opencl_failed(w->device, status, "waiting", error);
}
