#include "test/support/stress.h"

#include "lib/estimate_args.h"

#include <stdio.h>

stress_settings stress_effort = {1, 0.0};
char stress_case[2048];

__attribute__((constructor)) static void read_effort(void) {
  const char *seed = getenv("HBIL_STRESS_SEED");
  const char *seconds = getenv("HBIL_STRESS_SECONDS");
  if (seed)
    stress_effort.seed = strtoull(seed, NULL, 10);
  if (seconds)
    stress_effort.seconds = strtod(seconds, NULL);
  cmocka_set_test_filter(getenv("HBIL_STRESS_TEST"));
}

void check_case(const char *what, double value, double limit) {
  if (!(value <= limit))
    print_error("trying %s\n", stress_case);
  check_at_most(what, value, limit);
}

/* ------------------------------------------------------------------------ */
/* Plans                                                                     */

const char *const stress_plan_names[PLANS] = {
    "SH, float32", "unseen light estimated, float32", "SH, packed",
    "unseen light estimated, packed"};

bool stress_is_packed(plan_kind kind) {
  return kind == PACKED_SH || kind == PACKED_ESTIMATE;
}

void stress_one_sample(setup *s) {
  s->config.model.mode = HBIL_MODE_GTAO;
  s->config.sampling.slices = s->config.sampling.steps_per_side = 1;
  s->config.outputs.near_irradiance.component =
      s->config.outputs.bent_normal.component = HBIL_NONE;
  s->config.outputs.beauty = s->config.inputs.f0 = three_floats;
  s->config.execution.skip = 0;
  s->config.execution.vector_width = 1;
}

static void configure(setup *s, plan_kind kind) {
  if (kind == ONE_SAMPLE) {
    stress_one_sample(s);
    return;
  }
  setup_all_outputs(s);
  s->config.outputs.glossy = three_floats;
  s->config.inputs.f0 = three_floats;
  if (stress_is_packed(kind))
    s->config.sampling.storage = HBIL_STORAGE_PACKED;
  if (kind == PLAIN_SH || kind == PACKED_SH) {
    s->config.model.far_field = HBIL_FAR_SH;
    s->config.execution.vector_width = 1; /* the width of GPUs */
    return;
  }
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.model.far_field = HBIL_FAR_FRAME;
  s->config.model.offscreen_light = 1.0f; /* or a furnace loses light */
  s->config.history.reprojection = HBIL_REPROJECTION_MOTION;
}

static setup plans[ALL_PLANS];

bool stress_tries(plan_kind kind) {
  return stress_effort.seconds > 0.0 || kind == PLAIN_SH ||
         kind == PACKED_ESTIMATE;
}

void stress_normals_to_view(setup *s) {
  const double *m = s->frame.camera.world_from_view;
  const size_t pixels = (size_t)s->config.width * s->config.height;
  for (size_t i = 0; i < pixels; ++i) {
    double n[3];
    for (int c = 0; c < 3; ++c)
      n[c] = m[c] * (double)s->input[EXACT_NORMAL][i] +
             m[4 + c] * (double)s->input[EXACT_NORMAL + 1][i] +
             m[8 + c] * (double)s->input[EXACT_NORMAL + 2][i];
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] = (float)n[c];
  }
}

void stress_load_room(setup *s, uint32_t index) {
  setup_load_scene(s, SCENE_ROOM, index);
  stress_normals_to_view(s);
  for (int c = 0; c < 3; ++c)
    setup_fill(s, EXACT_F0 + c, 0.04f);
  s->frame.frame_index = index;
}

setup *stress_begin(plan_kind kind) {
  setup *s = &plans[kind];
  if (!s->plan) {
    setup_init(s, WIDTH, HEIGHT);
    configure(s, kind);
    setup_start(s);
  }
  hbil_plan_reset(s->plan);
  stress_load_room(s, 0);
  memset(s->frame.environment, 0, sizeof s->frame.environment);
  return s;
}

void stress_run(setup *s) {
  setup_upload(s);
  setup_run(s, hbil_enqueue_frame);
}

/* ------------------------------------------------------------------------ */
/* Checks                                                                    */

static void check_finite(const char *what, const exact_planes *planes) {
  const size_t total = count_values(planes);
  for (size_t i = 0; i < total; ++i)
    if (!isfinite(planes->values[i]))
      fail_msg("%s: value %zu of plane %zu is %g\ntrying %s", what,
               i % (total / (size_t)planes->count),
               i / (total / (size_t)planes->count), planes->values[i],
               stress_case);
}

static void check_range(const char *what, const exact_planes *planes, int first,
                        int count, double least, double most) {
  const size_t plane = (size_t)planes->width * (size_t)planes->height;
  for (size_t i = plane * (size_t)first; i < plane * (size_t)(first + count);
       ++i)
    if (!(planes->values[i] >= least && planes->values[i] <= most))
      fail_msg("%s: %.9g at pixel %zu is outside %g .. %g\ntrying %s", what,
               planes->values[i], i % plane, least, most, stress_case);
}

/* Whether light is guessed after all bounces. */
static bool guesses(setup *s) {
  return s->config.model.far_field == HBIL_FAR_FRAME ||
         s->config.model.back_facing_fallback == HBIL_FALLBACK_FRAME_MEAN;
}

/* The most that model.ao_bounces makes of a far field: F0(AO) is 1.00614 where
 * AO is .983, and the fit with an albedo of 1 is 1.0001 where AO is 1. */
static double most_bounces(const hbil_model *m) {
  return m->ao_bounces == HBIL_AO_BOUNCES_PAPER    ? 1.00615
         : m->ao_bounces == HBIL_AO_BOUNCES_ALBEDO ? 1.00011
                                                   : 1.0;
}

/* The largest radiance of the surfaces and of a constant far field.  A guess
 * can be 1 / (1 - HBIL_UNSEEN_GAIN) times the radiance of the first bounce. */
static double brightest(setup *s) {
  double most = 0.0;
  if (s->config.model.mode == HBIL_MODE_HBIL) {
    exact_planes split = stage_read(s, HBIL_STAGE_SPLIT);
    if (split.count > HBIL_SPLIT_RED)
      most = largest_value(&split, HBIL_SPLIT_RED, 3);
    exact_planes_free(&split);
    if (guesses(s))
      most /= 1.0 - (double)HBIL_UNSEEN_GAIN;
  }
  if (s->config.model.far_field == HBIL_FAR_CONSTANT)
    for (int c = 0; c < 3; ++c)
      most = fmax(most, (double)s->frame.environment[0][c] *
                            most_bounces(&s->config.model));
  return most;
}

/* The most irradiance that such radiance gives.  Half-float outputs and packed
 * E_near add half a step of the largest value, 2^-10; float sums add some
 * hundred roundings. */
static double most_light(setup *s, plane_id id, double radiance) {
  const bool coarse = s->config.sampling.storage != HBIL_STORAGE_FLOAT32 ||
                      plane_format(&s->config, id)->component == HBIL_FLOAT16;
  return PI * radiance * (1.0 + (coarse ? 0x1p-9 : 1e-5));
}

static void check_stage(setup *s, hbil_stage stage, const char *name) {
  const bool undefined_light =
      (stage == HBIL_STAGE_GATHERED || stage == HBIL_STAGE_RESOLVED) &&
      !gathers_light(s);
  hbil_buffer b;
  if (hbil_plan_buffer(s->plan, stage, &b) != HBIL_SUCCESS)
    return;
  exact_planes planes = stage_read(s, stage);
  const size_t plane = (size_t)planes.width * (size_t)planes.height;
  for (int p = HBIL_LIGHT_RED; undefined_light && p < planes.count; ++p)
    if (p < HBIL_LIGHT_BENT)
      memset(planes.values + plane * (size_t)p, 0, plane * sizeof(double));
  check_finite(name, &planes);
  exact_planes_free(&planes);
}

static void check_bent(const exact_planes *out, double tolerance) {
  for (int y = 0; y < out->height; ++y)
    for (int x = 0; x < out->width; ++x) {
      double size = 0.0;
      for (int c = 0; c < 3; ++c)
        size += pow(*exact_at(out, EXACT_BENT_NORMAL + c, x, y), 2.0);
      if (size != 0.0 && !(fabs(sqrt(size) - 1.0) <= tolerance))
        fail_msg("bent at (%d, %d): length %.9g\ntrying %s", x, y, sqrt(size),
                 stress_case);
    }
}

static bool asks_for(setup *s, plane_id id) {
  return plane_format(&s->config, id)->component != HBIL_NONE;
}

void check_sane(setup *s) {
  const bool sh = s->config.model.far_field == HBIL_FAR_SH;
  const double radiance = brightest(s);
  exact_planes out = outputs_read(s);
  check_finite("outputs", &out);
  check_range("ao", &out, EXACT_AO, 1, 0.0, 1.0);
  check_range("near_irradiance", &out, EXACT_NEAR_IRRADIANCE, 3, 0.0,
              most_light(s, PLANE_NEAR, radiance));
  check_range("far_irradiance", &out, EXACT_FAR_IRRADIANCE, 3, 0.0,
              sh ? INFINITY : most_light(s, PLANE_FAR, radiance));
  check_range("unknown", &out, EXACT_UNKNOWN, 1, 0.0, 1.0);
  check_range("error_estimate", &out, EXACT_ERROR_ESTIMATE, 2, 0.0, INFINITY);
  check_range("cone", &out, EXACT_CONE_COSINE, 1, 0.0, 1.0);
  check_range("indirect", &out, EXACT_INDIRECT, 3, 0.0, INFINITY);
  check_range("radiance", &out, EXACT_BEAUTY, 3, 0.0, INFINITY);
  if (asks_for(s, PLANE_BENT)) /* three roundings; 2^-11 each in half floats */
    check_bent(&out, s->config.outputs.bent_normal.component == HBIL_FLOAT16
                         ? 1e-3
                         : 1e-6);
  exact_planes_free(&out);
  check_stage(s, HBIL_STAGE_SPLIT, "split");
  check_stage(s, HBIL_STAGE_GATHERED, "gathered");
  check_stage(s, HBIL_STAGE_RESOLVED, "resolved");
  check_stage(s, HBIL_STAGE_HISTORY, "history");
  hbil_statistics statistics;
  assert_success(s,
                 hbil_plan_statistics(s->plan, s->device->queue, &statistics));
  if (!statistics.not_run[HBIL_PASS_REPROJECT])
    check_stage(s, HBIL_STAGE_CARRIED, "carried");
}
