/*
 * Random settings, inputs and cameras from extremes: every output is finite and
 * in range, and the gather and the filter are near double precision.
 *
 * `make check` draws a few, `make stress` draws for HBIL_STRESS_SECONDS.
 */
#include "test/support/contents.h"
#include "test/support/deviation.h"
#include "test/support/stress.h"

#include <stdio.h>
#include <time.h>

/* Frames of each draw, and draws of the short form. */
enum { FRAMES = 3, FEWEST = 2 };

static cl_uint below(random_state *r, int count) {
  return (cl_uint)(random_unit(r) * count);
}

static bool maybe(random_state *r, double probability) {
  return random_unit(r) < probability;
}

static hbil_plane_format any_format(random_state *r, int channels, bool unorm) {
  const hbil_component kinds[] = {HBIL_FLOAT32, HBIL_FLOAT16, HBIL_UNORM8};
  const cl_uint strides[] = {1, (cl_uint)channels, 4};
  return (hbil_plane_format){kinds[below(r, unorm ? 3 : 2)],
                             strides[below(r, 3)]};
}

static void any_formats(hbil_config *c, random_state *r) {
  for (plane_id id = 0; id < PLANE_COUNT; ++id) {
    const bool colour = id >= PLANE_ALBEDO && id <= PLANE_EMISSION;
    hbil_plane_format *format = plane_format(c, id);
    *format = any_format(r, plane_channels(id), colour);
    if ((colour || id >= PLANE_FIRST_OUTPUT) && maybe(r, 0.2))
      format->component = HBIL_NONE;
  }
  c->outputs.ao = one_float; /* so that there is an output */
  c->inputs.depth_kind = (hbil_depth_kind)below(r, 2);
  c->inputs.normal_space = (hbil_space)below(r, 2);
  c->outputs.bent_normal_space = (hbil_space)below(r, 2);
  c->inputs.direct_scale = maybe(r, 0.2) ? 1e10f : 1.0f;
  c->inputs.sky_depth = maybe(r, 0.2) ? 1e6f : INFINITY;
}

static void any_model(hbil_config *c, random_state *r) {
  const float lengths[] = {1e-6f, 0.3f, 2.0f, 1e4f, 1e12f};
  c->inputs.projection = maybe(r, 0.2) ? HBIL_PROJECTION_ORTHOGRAPHIC
                                       : HBIL_PROJECTION_PERSPECTIVE;
  c->model.mode = (hbil_mode)(maybe(r, 0.6) ? 0 : below(r, 3));
  c->model.falloff = (hbil_falloff)below(r, 3);
  c->model.radius = maybe(r, 0.5) ? INFINITY : ANY_OF(r, lengths);
  c->model.thickness = maybe(r, 0.7) ? INFINITY : ANY_OF(r, lengths);
  c->model.relative_thickness = maybe(r, 0.6)   ? INFINITY
                                : maybe(r, 0.5) ? 0.08f
                                                : 1e-6f;
  c->model.facing_fade[0] =
      maybe(r, 0.3) ? -1.0f : (float)random_unit(r) - 0.6f;
  c->model.facing_fade[1] = c->model.facing_fade[0] == -1.0f || maybe(r, 0.3)
                                ? c->model.facing_fade[0]
                                : c->model.facing_fade[0] + 0.3f;
  c->model.back_facing_fallback = (hbil_back_facing_fallback)below(r, 3);
  c->model.gather_emission = (cl_bool)below(r, 2);
  c->history.reprojection = (hbil_reprojection)below(r, 3);
  c->model.feedback = (hbil_feedback)below(r, 2);
  c->history.disocclusion_threshold = maybe(r, 0.2) ? INFINITY : 0.05f;
  c->model.far_field = (hbil_far_field)below(r, 4);
  c->model.roughness = maybe(r, 0.2) ? 0.3f : maybe(r, 0.2) ? 1.0f : 0.6f;
  if (c->model.mode != HBIL_MODE_HBIL) {
    c->outputs.near_irradiance.component = c->outputs.unknown.component =
        c->outputs.glossy.component = HBIL_NONE;
    c->model.far_field = (hbil_far_field)below(r, 2);
  }
  if (c->model.mode == HBIL_MODE_HBAO)
    c->outputs.bent_normal.component = c->outputs.cone_cosine.component =
        HBIL_NONE;
}

static void any_sampling(hbil_config *c, random_state *r) {
  const cl_uint samples[] = {1, 3, 8, 33}, widths[] = {1, 4, 8, 16, 8, 8};
  c->sampling.slices = 1 + below(r, 4);
  c->sampling.steps_per_side = ANY_OF(r, samples);
  c->sampling.step_growth = maybe(r, 0.3) ? 0.0f : 4.0f * (float)random_unit(r);
  c->sampling.sample_grid = (hbil_sample_grid)below(r, 2);
  c->sampling.unfiltered = maybe(r, 0.2);
  if (!c->sampling.unfiltered)
    c->sampling.resolution =
        (hbil_resolution)below(r, HBIL_RESOLUTION_HALF + 1);
  c->sampling.storage =
      maybe(r, 0.5) ? HBIL_STORAGE_PACKED : HBIL_STORAGE_FLOAT32;
  c->execution.vector_width = ANY_OF(r, widths);
  c->execution.skip =
      maybe(r, 0.5) ? HBIL_SKIP_ALL : below(r, HBIL_SKIP_ALL + 1);
}

static void tell_settings(uint64_t seed, const hbil_config *c,
                          const char *inputs, const camera_view *v) {
  STRESS_CASE(
      "seed %llu: %s, %u x %u, projection %d mode %d falloff %d radius %g "
      "thickness %g %g "
      "facing fade %g %g fallback %d gather_emission %d reprojection %d "
      "feedback %d "
      "disocclusion %g far_field %d, %u x %u growth %g grid %d resolution %d "
      "unfiltered %d "
      "storage %d width %u skip %u, depth %d/%u kind %d, normal %d/%u in %d, "
      "direct_scale %g, field of view %g, off centre %g, %g, pixels 1 : %g",
      (unsigned long long)seed, inputs, c->width, c->height,
      (int)c->inputs.projection, (int)c->model.mode, (int)c->model.falloff,
      (double)c->model.radius, (double)c->model.thickness,
      (double)c->model.relative_thickness, (double)c->model.facing_fade[0],
      (double)c->model.facing_fade[1], (int)c->model.back_facing_fallback,
      (int)c->model.gather_emission, (int)c->history.reprojection,
      (int)c->model.feedback, (double)c->history.disocclusion_threshold,
      (int)c->model.far_field, c->sampling.slices, c->sampling.steps_per_side,
      (double)c->sampling.step_growth, (int)c->sampling.sample_grid,
      (int)c->sampling.resolution, (int)c->sampling.unfiltered,
      (int)c->sampling.storage, c->execution.vector_width, c->execution.skip,
      (int)c->inputs.depth.component, c->inputs.depth.stride,
      (int)c->inputs.depth_kind, (int)c->inputs.normal.component,
      c->inputs.normal.stride, (int)c->inputs.normal_space,
      (double)c->inputs.direct_scale, v->fov, v->off_x, v->off_y, v->pixel);
}

/* The same with `count` planes; planes that the plan lacks are 0. */
static exact_planes widened(exact_planes planes, int count) {
  exact_planes wide = checked_planes(planes.width, planes.height, count);
  memcpy(wide.values, planes.values,
         sizeof(double) * (size_t)(planes.width * planes.height) *
             (size_t)(planes.count < count ? planes.count : count));
  exact_planes_free(&planes);
  return wide;
}

/* The gather against double on the split planes, and the filter on what was
 * gathered.  10 bits of E_near are off by half of FAR_OFF.  Packed bent
 * normals, whose step is 1/511 however short they are, are left to
 * test_storage.  More than that differ only samples that a rounding lets rise,
 * sectors that it covers, and gradients of surfaces seen edge on, 6e-8 over a
 * cosine of 1e-4: one value in a hundred may be (measured over 56 comparisons:
 * none), or three in a tiny picture. */
static void check_near_double(setup *s) {
  deviation all[DEVIATIONS] = {{0}};
  const bool light = gathers_light(s);
  exact_planes got = stage_read(s, HBIL_STAGE_RESOLVED);
  const bool bent = got.count > HBIL_LIGHT_BENT &&
                    s->config.sampling.storage == HBIL_STORAGE_FLOAT32;
  exact_planes resolved = widened(got, HBIL_LIGHT_PLANES);
  exact_planes split =
      widened(stage_read(s, HBIL_STAGE_SPLIT), HBIL_SPLIT_PLANES);
  exact_planes gathered =
      widened(stage_read(s, HBIL_STAGE_GATHERED), HBIL_GATHERED_PLANES);
  exact_planes want =
      checked_planes(split.width, split.height, HBIL_GATHERED_PLANES);
  exact_estimate_frame(&s->job, &split, &gathered);
  checked_gather(&s->job, &split, &want);
  add_light_deviation(all, GATHER_AO, &gathered, &want, light, bent);
  exact_recompose(&s->job, &split, &gathered, &want);
  add_light_deviation(all, RECOMPOSE_AO, &resolved, &want, light, bent);
  exact_planes_free(&split);
  exact_planes_free(&gathered);
  exact_planes_free(&resolved);
  exact_planes_free(&want);
  for (int i = 0; i < DEVIATIONS; ++i) {
    if (!all[i].count)
      continue;
    if (getenv("HBIL_TEST_VERBOSE"))
      print_message("%s: %zu of %zu far off, the largest by %.3g\n",
                    deviation_name(i), all[i].far_off, all[i].count,
                    all[i].largest);
    check_case(deviation_name(i), (double)all[i].far_off,
               3.0 + 0.01 * (double)all[i].count);
  }
}

/* Depths over all that can be, in any unit. */
static void scale_depths(setup *s, double scale) {
  const size_t pixels = (size_t)s->config.width * s->config.height;
  for (size_t i = 0; i < pixels; ++i)
    s->input[EXACT_DEPTH][i] = (float)(s->input[EXACT_DEPTH][i] * scale);
}

static void check_settings(uint64_t seed) {
  random_state r = {seed};
  setup s;
  const content what = (content)below(&r, CONTENTS);
  const double scale = pow(10.0, 16.0 * random_unit(&r) - 6.0);
  const double spoiled = maybe(&r, 0.5) ? 0.0 : 0.1 * random_unit(&r);
  camera_view v = views[below(&r, VIEWS)];
  if (maybe(&r, 0.5))
    v.fov = 1.0 + 169.0 * random_unit(&r);
  setup_init(&s, 1 + (int)below(&r, 97), 1 + (int)below(&r, 67));
  any_formats(&s.config, &r);
  any_model(&s.config, &r);
  any_sampling(&s.config, &r);
  char inputs[128];
  snprintf(inputs, sizeof inputs, "%s in units of %g, %.3g of it spoiled",
           content_names[what], scale, spoiled);
  tell_settings(seed, &s.config, inputs, &v);
  if (getenv("HBIL_TEST_VERBOSE"))
    print_message("%s\n", stress_case);
  setup_start(&s);
  for (uint32_t i = 0; i < FRAMES; ++i) {
    if (what == ROOM) {
      stress_load_room(&s, i);
    } else {
      set_view(&s, &v);
      load_content(&s, what, i, &r);
    }
    for (int c = 0; c < 3; ++c) {
      s.frame.environment[0][c] = (float)random_unit(&r);
      s.frame.camera.world_from_view[4 * c + 3] += 0.1 * i * scale;
    }
    scale_depths(&s, scale);
    spoil(&s, &r, spoiled);
    stress_run(&s);
    check_sane(&s);
    check_near_double(&s);
  }
  setup_free(&s);
}

static double now(void) {
  struct timespec t;
  timespec_get(&t, TIME_UTC);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Each is compiled, which takes seconds: the short form draws two. */
static void any_settings_are_sane(void **state) {
  const double end = now() + stress_effort.seconds;
  (void)state;
  for (uint64_t i = 0; i < FEWEST || now() < end; ++i)
    check_settings(stress_effort.seed + i);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(any_settings_are_sane),
  };
  stress_read_effort();
  return RUN_WITH_DEVICE(tests);
}
