/*
 * Numerical stress: inputs, cameras and settings from extremes.  Whatever comes
 * in, every output is finite and in range, what is repaired is the documented
 * value and is counted, and where there is a right answer results are near it.
 *
 * `make check` runs each family briefly.  `make stress` is the long form: the
 * environment's HBIL_STRESS_SECONDS is how long random settings are drawn, and
 * HBIL_STRESS_SEED (a number; 1) where drawing begins.  Every failure names
 * what was tried; case k of seed s is the first of seed s + k.
 */
#define _DEFAULT_SOURCE /* mallinfo2 */
#include "support.h"

#include <float.h>
#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <time.h>

#define WIDTH 64
#define HEIGHT 48
#define PIXELS (WIDTH * HEIGHT)

static struct {
  uint64_t seed;
  double seconds; /* 0: the short form */
} effort = {1, 0.0};

static const hbil_plane_format triple = {HBIL_FLOAT32, 3};

/* What is being tried, for the message of whatever fails. */
static char trying[1024];

#define TRY(...) snprintf(trying, sizeof trying, __VA_ARGS__)

/* Fails above the limit, and says for what. */
static void check_below(const char *what, double value, double limit) {
  if (!(value <= limit))
    print_error("trying %s\n", trying);
  check_at_most(what, value, limit);
}

/* One of the values. */
#define ANY_OF(r, values)                                                      \
  ((values)[(size_t)(random_unit(r) *                                          \
                     (double)(sizeof(values) / sizeof *(values)))])

/* ------------------------------------------------------------------------ */
/* Plans: few, since each is compiled                                        */

typedef enum plan_kind {
  PAPER,
  FILLED,
  PACKED_PAPER,
  PACKED_FILLED,
  PLANS,
  ONE_SAMPLE = PLANS, /* not among those that everything is tried with */
  ALL_PLANS
} plan_kind;

static const char *const plan_names[PLANS] = {
    "the paper's model, fp32", "light from the frame, fp32",
    "the paper's model, packed", "light from the frame, packed"};

static bool is_packed(plan_kind kind) {
  return kind == PACKED_PAPER || kind == PACKED_FILLED;
}

/* AO of one sample a side, and a picture whose inputs composite alone reads. */
static void configure_one_sample(setup *s) {
  s->config.mode = HBIL_MODE_GTAO;
  s->config.slices = s->config.steps_per_side = 1;
  s->config.near_irradiance.component = s->config.bent_normal.component =
      HBIL_NONE;
  s->config.beauty = s->config.f0 = triple;
  s->config.skip = 0;
  s->config.vector_width = 1;
  s->config.extrapolate = CL_FALSE; /* the horizons themselves */
}

static void configure(setup *s, plan_kind kind) {
  if (kind == ONE_SAMPLE) {
    configure_one_sample(s);
    return;
  }
  setup_all_outputs(s);
  s->config.f0 = triple;
  if (is_packed(kind))
    s->config.storage = HBIL_STORAGE_PACKED;
  if (kind == PAPER || kind == PACKED_PAPER) {
    s->config.far_field = HBIL_FAR_SH;
    s->config.vector_width = 1; /* as on GPUs */
    return;
  }
  s->config.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.far_field = HBIL_FAR_FRAME;
  s->config.reprojection = HBIL_REPROJECTION_MOTION;
}

static setup plans[ALL_PLANS];

/* The short form has one of each in all. */
static bool is_tried(plan_kind kind) {
  return effort.seconds > 0.0 || kind == PAPER || kind == PACKED_FILLED;
}

/* A camera's normals, as its view has them. */
static void turn_normals(setup *s) {
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

static void load_room(setup *s, uint32_t index) {
  setup_load_scene(s, SCENE_ROOM, index);
  turn_normals(s);
  for (int c = 0; c < 3; ++c)
    setup_fill(s, EXACT_F0 + c, 0.04f);
  s->frame.frame_index = index;
}

/* A plan in its first frame. */
static setup *begin(plan_kind kind) {
  setup *s = &plans[kind];
  if (!s->plan) {
    setup_init(s, WIDTH, HEIGHT);
    configure(s, kind);
    setup_start(s);
  }
  hbil_plan_reset(s->plan);
  load_room(s, 0);
  memset(s->frame.environment, 0, sizeof s->frame.environment);
  return s;
}

static void run(setup *s) {
  setup_upload(s);
  setup_run(s, hbil_enqueue_frame);
}

/* ------------------------------------------------------------------------ */
/* Finite, and in range                                                      */

static void check_finite(const char *what, const exact_planes *planes) {
  const size_t total =
      (size_t)planes->width * (size_t)planes->height * (size_t)planes->count;
  for (size_t i = 0; i < total; ++i)
    if (!isfinite(planes->values[i]))
      fail_msg("%s: value %zu of plane %zu is %g\ntrying %s", what,
               i % (total / (size_t)planes->count),
               i / (total / (size_t)planes->count), planes->values[i], trying);
}

static void check_range(const char *what, const exact_planes *planes, int first,
                        int count, double least, double most) {
  const size_t plane = (size_t)planes->width * (size_t)planes->height;
  for (size_t i = plane * (size_t)first; i < plane * (size_t)(first + count);
       ++i)
    if (!(planes->values[i] >= least && planes->values[i] <= most))
      fail_msg("%s: %.9g at pixel %zu is outside %g .. %g\ntrying %s", what,
               planes->values[i], i % plane, least, most, trying);
}

/* Largest radiance that a frame can show anywhere: what surfaces send or the
 * far field holds. */
static double brightest(setup *s) {
  double most = 0.0;
  if (s->config.mode == HBIL_MODE_HBIL) {
    exact_planes split = stage_read(s, HBIL_STAGE_SPLIT);
    if (split.count > HBIL_SPLIT_RED)
      most = largest_value(&split, HBIL_SPLIT_RED, 3);
    exact_planes_free(&split);
  }
  if (s->config.far_field == HBIL_FAR_CONSTANT)
    for (int c = 0; c < 3; ++c)
      most = fmax(most, (double)s->frame.environment[0][c]);
  return most;
}

/* Half outputs, halves and the 10 bits of packed E_near: half a step of the
 * largest value, 2^-10; otherwise sums of some hundred roundings. */
static double most_light(setup *s, image_id id, double radiance) {
  const bool coarse = s->config.storage != HBIL_STORAGE_FLOAT32 ||
                      image_format(&s->config, id)->component == HBIL_FLOAT16;
  return PI * radiance * (1.0 + (coarse ? 0x1p-9 : 1e-5));
}

/* Whether the plan gathers light: planes of E_near mean nothing where not. */
static bool gathers_light(setup *s) {
  exact_planes split = stage_read(s, HBIL_STAGE_SPLIT);
  const bool light = split.count > HBIL_SPLIT_RED;
  exact_planes_free(&split);
  return light;
}

static void check_stage(setup *s, hbil_stage stage, const char *name) {
  const bool dark =
      (stage == HBIL_STAGE_GATHERED || stage == HBIL_STAGE_RESOLVED) &&
      !gathers_light(s);
  hbil_buffer b;
  if (hbil_plan_buffer(s->plan, stage, &b) != HBIL_SUCCESS)
    return;
  exact_planes planes = stage_read(s, stage);
  const size_t plane = (size_t)planes.width * (size_t)planes.height;
  for (int p = HBIL_LIGHT_RED; dark && p < planes.count; ++p)
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
                 trying);
    }
}

static bool asks_for(setup *s, image_id id) {
  return image_format(&s->config, id)->component != HBIL_NONE;
}

/* All that can be said of any frame at all. */
static void check_sane(setup *s) {
  const bool sh = s->config.far_field == HBIL_FAR_SH;
  const double radiance = brightest(s);
  exact_planes out = outputs_read(s);
  check_finite("outputs", &out);
  check_range("ao", &out, EXACT_AO, 1, 0.0, 1.0);
  check_range("near_irradiance", &out, EXACT_NEAR_IRRADIANCE, 3, 0.0,
              most_light(s, PLANE_NEAR, radiance));
  check_range("far_irradiance", &out, EXACT_FAR_IRRADIANCE, 3, 0.0,
              sh ? INFINITY : most_light(s, PLANE_FAR, radiance));
  check_range("cone", &out, EXACT_CONE_COSINE, 1, 0.0, 1.0);
  check_range("indirect", &out, EXACT_INDIRECT, 3, 0.0, INFINITY);
  check_range("radiance", &out, EXACT_BEAUTY, 3, 0.0, INFINITY);
  if (asks_for(s, PLANE_BENT)) /* roundings; of three halves 2^-11 each */
    check_bent(&out,
               s->config.bent_normal.component == HBIL_FLOAT16 ? 1e-3 : 1e-6);
  exact_planes_free(&out);
  check_stage(s, HBIL_STAGE_SPLIT, "split");
  check_stage(s, HBIL_STAGE_GATHERED, "gathered");
  check_stage(s, HBIL_STAGE_RESOLVED, "resolved");
  check_stage(s, HBIL_STAGE_HISTORY, "history");
  hbil_statistics left_out;
  assert_success(s, hbil_plan_statistics(s->plan, s->gpu->queue, &left_out));
  if (!left_out.not_run[HBIL_PASS_REPROJECT]) /* in a first frame it is */
    check_stage(s, HBIL_STAGE_CARRIED, "carried");
}

/* ------------------------------------------------------------------------ */
/* Scale                                                                     */

/* Two frames of the room, in units of 1/scale. */
static exact_planes room_scaled(plan_kind kind, double scale) {
  setup *s = begin(kind);
  for (uint32_t i = 0; i < 2; ++i) {
    load_room(s, i);
    for (int c = 0; c < 3; ++c)
      s->frame.camera.world_from_view[4 * c + 3] *= scale;
    for (int p = 0; p < PIXELS; ++p)
      s->input[EXACT_DEPTH][p] = (float)(s->input[EXACT_DEPTH][p] * scale);
    s->frame.environment[0][0] = 1.0f;
    run(s);
  }
  check_sane(s);
  return outputs_read(s);
}

static void the_unit_of_length_does_not_matter(void **state) {
  /* powers of ten, whose depths are rounded anew */
  const double scales[] = {1e-6, 1e-3, 1e3, 1e6, 1e9};
  (void)state;
  for (plan_kind kind = 0; kind < PLANS; ++kind) {
    if (!is_tried(kind))
      continue;
    exact_planes want = room_scaled(kind, 1.0);
    for (size_t i = 0; i < sizeof scales / sizeof *scales; ++i) {
      TRY("scale %g, %s", scales[i], plan_names[kind]);
      exact_planes got = room_scaled(kind, scales[i]);
      for (image_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
        check_below(
            image_name(id),
            relative_rmse(&got, &want, image_first(id), image_channels(id)),
            id == PLANE_CONE ? 1e-3 : 1e-4);
      exact_planes_free(&got);
    }
    exact_planes_free(&want);
  }
}

/* ------------------------------------------------------------------------ */
/* What inputs hold                                                          */

/* Values of all kinds; 0 where there is nothing wrong with them. */
static const float odd_depths[] = {
    0.0f,   -0.0f, -1.0f,    NAN,   INFINITY, -INFINITY, 1e-40f, FLT_MIN,
    1e-16f, 1e-6f, 65504.0f, 1e10f, 9e14f,    1e15f,     1e20f,  FLT_MAX};
static const float odd_shares[] = {0.0f,     1.0f,  2.0f,   -1e-6f, NAN,
                                   INFINITY, 1e30f, -1e30f, 1e-30f, -0.0f};
static const float odd_light[] = {0.0f,  1e-30f,  65504.0f, 1e30f,
                                  NAN,   -1.0f,   INFINITY, -INFINITY,
                                  2e30f, FLT_MAX, 1e-40f,   -0.0f};
static const float odd_motion[] = {0.0f, NAN,      INFINITY, -INFINITY,
                                   1e9f, -FLT_MAX, 1e-40f,   FLT_MAX};
static const float odd_normals[][3] = {
    {0, 0, 0},         {NAN, 0, -1},       {INFINITY, 0, 0}, {0, 0, 1},
    {0, 0, -1e-3f},    {1e10f, 0, -1e10f}, {0, 1e-20f, 0},   {1e20f, 0, 0},
    {0, 0, -INFINITY}, {1, 0, 0},          {0, -5e-9f, 0},   {NAN, NAN, NAN}};

/* Spoils a value with some probability. */
#define SPOIL(r, share, value, values)                                         \
  do                                                                           \
    if (random_unit(r) < (share))                                              \
      (value) = ANY_OF(r, values);                                             \
  while (0)

static void spoil(setup *s, random_state *r, double share) {
  const size_t pixels = (size_t)s->config.width * s->config.height;
  for (size_t i = 0; i < pixels; ++i) {
    SPOIL(r, share, s->input[EXACT_DEPTH][i], odd_depths);
    if (random_unit(r) < share) {
      const float *n = ANY_OF(r, odd_normals);
      for (int c = 0; c < 3; ++c)
        s->input[EXACT_NORMAL + c][i] = n[c];
    }
    for (int c = 0; c < 3; ++c) {
      SPOIL(r, share, s->input[EXACT_ALBEDO + c][i], odd_shares);
      SPOIL(r, share, s->input[EXACT_F0 + c][i], odd_shares);
      SPOIL(r, share, s->input[EXACT_DIRECT + c][i], odd_light);
      SPOIL(r, share, s->input[EXACT_EMISSION + c][i], odd_light);
    }
    for (int c = 0; c < 2; ++c)
      SPOIL(r, share, s->input[EXACT_MOTION + c][i], odd_motion);
  }
}

/* --- hbil.h's rules, once more --- */

static bool repair_depth(float *d) {
  const bool bad = isnan(*d) || *d < 0.0f || (*d > 0.0f && *d < 1e-15f);
  if (bad)
    *d = 0.0f;
  return bad;
}

static bool repair_light(float *v) {
  const bool bad = !(*v >= 0.0f && *v <= 1e30f);
  if (bad)
    *v = 0.0f;
  return bad;
}

static bool repair_share(float *v) {
  const bool above = *v > 1.0f && *v <= 1e30f;
  if (above)
    *v = 1.0f;
  return above | repair_light(v);
}

/* Motion that leads out of every picture. */
static bool repair_motion(float *v) {
  const bool bad = !isfinite(*v);
  if (bad)
    *v = 1e9f;
  return bad;
}

/* Points at the eye; rounded as the kernel rounds its rays. */
static bool repair_normal(const setup *s, size_t i) {
  float *n[3];
  for (int c = 0; c < 3; ++c)
    n[c] = s->input[EXACT_NORMAL + c] + i;
  const float size = fmaf(*n[0], *n[0], fmaf(*n[1], *n[1], *n[2] * *n[2]));
  if (size >= 1e-20f && size < INFINITY)
    return false;
  const hbil_view_args v = exact_view(&s->config, &s->frame.camera);
  const size_t x = i % s->config.width, y = i / s->config.width;
  *n[0] = -((float)x + 0.5f - v.cx) * v.inv_fx;
  *n[1] = -((float)y + 0.5f - v.cy) * v.inv_fy;
  *n[2] = -1.0f;
  return true;
}

static size_t repair_planes(setup *s, int first, int count, size_t i,
                            bool (*repair)(float *)) {
  bool repaired = false;
  for (int c = 0; c < count; ++c)
    repaired |= repair(s->input[first + c] + i);
  return repaired;
}

/* Puts the documented values in, and counts. */
static hbil_sanitized repair(setup *s) {
  const size_t pixels = (size_t)s->config.width * s->config.height;
  hbil_sanitized n = {0};
  for (size_t i = 0; i < pixels; ++i) {
    n.depth += repair_planes(s, EXACT_DEPTH, 1, i, repair_depth);
    const float depth = s->input[EXACT_DEPTH][i];
    const size_t solid = depth > 0.0f && depth < 1e15f;
    n.normal += solid * repair_normal(s, i);
    n.albedo += solid * repair_planes(s, EXACT_ALBEDO, 3, i, repair_share);
    n.f0 += solid * repair_planes(s, EXACT_F0, 3, i, repair_share);
    n.direct += solid * repair_planes(s, EXACT_DIRECT, 3, i, repair_light);
    n.motion += solid * repair_planes(s, EXACT_MOTION, 2, i, repair_motion);
    n.emission += repair_planes(s, EXACT_EMISSION, 3, i, repair_light);
  }
  return n;
}

static hbil_sanitized counted(setup *s) {
  hbil_sanitized n;
  assert_success(s, hbil_plan_sanitized(s->plan, s->gpu->queue, &n));
  return n;
}

static void check_counts(const hbil_sanitized *got,
                         const hbil_sanitized *want) {
  const struct {
    const char *name;
    size_t got, want;
  } rows[] = {{"depth", got->depth, want->depth},
              {"normal", got->normal, want->normal},
              {"albedo", got->albedo, want->albedo},
              {"f0", got->f0, want->f0},
              {"direct", got->direct, want->direct},
              {"emission", got->emission, want->emission},
              {"motion", got->motion, want->motion}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i)
    if (rows[i].got != rows[i].want)
      fail_msg("%s: %zu repairs counted, %zu made\ntrying %s", rows[i].name,
               rows[i].got, rows[i].want, trying);
}

#define FRAMES 3

/* What a frame of spoiled inputs comes to; or of the repaired ones. */
static void spoiled_frames(plan_kind kind, uint64_t seed, bool repaired_before,
                           exact_planes out[FRAMES],
                           hbil_sanitized repairs[FRAMES]) {
  random_state r = {seed};
  setup *s = begin(kind);
  for (uint32_t i = 0; i < FRAMES; ++i) {
    hbil_sanitized own = {0};
    load_room(s, i);
    spoil(s, &r, i == FRAMES - 1 ? 0.01 : 0.1);
    if (repaired_before)
      own = repair(s);
    run(s);
    const hbil_sanitized found = counted(s);
    if (repaired_before) {
      const hbil_sanitized none = {0};
      check_counts(&found, &none);
      repairs[i] = own;
      if (i == 0 || s->config.reprojection != HBIL_REPROJECTION_MOTION)
        repairs[i].motion = 0;
    } else {
      repairs[i] = found;
    }
    check_sane(s);
    out[i] = outputs_read(s);
  }
}

static void what_is_repaired_is_counted_and_never_spread(void **state) {
  (void)state;
  for (plan_kind kind = 0; kind < PLANS; ++kind) {
    exact_planes got[FRAMES], want[FRAMES];
    hbil_sanitized found[FRAMES], made[FRAMES];
    if (!is_tried(kind))
      continue;
    TRY("spoiled inputs, seed %llu, %s", (unsigned long long)effort.seed,
        plan_names[kind]);
    spoiled_frames(kind, effort.seed, false, got, found);
    spoiled_frames(kind, effort.seed, true, want, made);
    for (int i = 0; i < FRAMES; ++i) {
      check_counts(&found[i], &made[i]);
      check_below("values that a repair has changed",
                  (double)count_different(&got[i], &want[i]), 0.0);
      exact_planes_free(&got[i]);
      exact_planes_free(&want[i]);
    }
  }
}

/* Of a still frame, whose inputs are those of the frame before, so are the
 * numbers; but nothing moves, and motion is not looked at. */
static void still_frames_count_what_the_frame_before_did(void **state) {
  random_state r = {effort.seed};
  setup *s = begin(PACKED_FILLED);
  (void)state;
  TRY("still frames");
  spoil(s, &r, 0.1);
  for (int c = 0; c < 2; ++c)
    setup_fill(s, EXACT_MOTION + c, 0.0f);
  run(s);
  const hbil_sanitized first = counted(s);
  assert_true(first.depth > 0 && first.emission > 0);
  s->frame.static_frame = CL_TRUE;
  for (int i = 0; i < 2; ++i) {
    run(s);
    const hbil_sanitized again = counted(s);
    check_counts(&again, &first);
  }
  s->frame.static_frame = CL_FALSE;
}

/* Without near light split reads depth and normals alone. */
static void who_reads_first_counts(void **state) {
  random_state r = {effort.seed};
  setup *s = begin(ONE_SAMPLE);
  (void)state;
  TRY("inputs that composite alone reads");
  for (int i = 0; i < 2; ++i) { /* each frame anew */
    spoil(s, &r, 0.1);
    run(s);
    const hbil_sanitized found = counted(s);
    hbil_sanitized made = repair(s);
    made.motion = 0;
    assert_true(made.albedo > 0 && made.f0 > 0);
    assert_true(made.direct > 0 && made.emission > 0);
    check_counts(&found, &made);
    check_sane(s);
  }
}

static void counts_need_a_frame(void **state) {
  setup *s = begin(ONE_SAMPLE);
  hbil_sanitized out;
  (void)state;
  const cl_command_queue queue = s->gpu->queue;
  assert_int_equal(hbil_plan_sanitized(NULL, queue, &out),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_sanitized(s->plan, NULL, &out),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_sanitized(s->plan, queue, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_sanitized(s->plan, queue, &out),
                   HBIL_INVALID_ARGUMENT);
}

/* ------------------------------------------------------------------------ */
/* Contents and cameras                                                      */

typedef enum content {
  ROOM,
  JUMBLE,  /* depths over a factor of 1e7, normals all around */
  CHECKER, /* two depths in turns, pixel by pixel */
  SPIKES,  /* a wall, single pixels far before and behind it */
  NOISE,
  AWAY, /* half of the normals face away: surfaces seen edge on */
  CONTENTS
} content;

static const char *const content_names[CONTENTS] = {
    "a room", "depths over a factor of 1e7", "a checkerboard", "spikes",
    "noise",  "normals that face away"};

static double depth_of(content kind, int x, int y, random_state *r) {
  const double u = random_unit(r);
  switch (kind) {
  case JUMBLE:
    return pow(10.0, 7.0 * u - 3.5);
  case CHECKER:
    return (x + y) % 2 ? 1.0 : 2.0;
  case SPIKES:
    return u < 0.01 ? 1e-3 : u > 0.99 ? 1e5 : 3.0;
  default:
    return 1.0 + u;
  }
}

/* A normal of any direction; one that faces the eye, if it must. */
static void random_normal(setup *s, size_t i, bool faces, random_state *r) {
  const hbil_camera *camera = &s->frame.camera;
  double n[3], ray[3] = {0.0, 0.0, 1.0};
  for (int c = 0; c < 3; ++c)
    n[c] = 2.0 * random_unit(r) - 1.0;
  ray[0] = ((double)(i % s->config.width) + 0.5 - camera->cx) / camera->fx;
  ray[1] = ((double)(i / s->config.width) + 0.5 - camera->cy) / camera->fy;
  const double sign = faces && dot(n, ray) > 0.0 ? -1.0 : 1.0;
  for (int c = 0; c < 3; ++c)
    s->input[EXACT_NORMAL + c][i] = (float)(sign * n[c]);
}

/* The camera must be set. */
static void load_content(setup *s, content kind, uint32_t index,
                         random_state *r) {
  const size_t width = s->config.width, pixels = width * s->config.height;
  const bool flat = kind == CHECKER || kind == SPIKES;
  s->frame.frame_index = index;
  for (size_t i = 0; i < pixels; ++i) {
    s->input[EXACT_DEPTH][i] =
        (float)depth_of(kind, (int)(i % width), (int)(i / width), r);
    random_normal(s, i, kind != AWAY, r);
    for (int c = 0; c < 3; ++c) {
      if (flat)
        s->input[EXACT_NORMAL + c][i] = c == 2 ? -1.0f : 0.0f;
      s->input[EXACT_ALBEDO + c][i] = (float)random_unit(r);
      s->input[EXACT_F0 + c][i] = 0.04f;
      s->input[EXACT_DIRECT + c][i] = (float)(10.0 * random_unit(r));
      s->input[EXACT_EMISSION + c][i] = random_unit(r) < 0.01 ? 5.0f : 0.0f;
    }
    for (int c = 0; c < 2; ++c)
      s->input[EXACT_MOTION + c][i] = (float)(4.0 * random_unit(r) - 2.0);
  }
}

typedef struct camera_view {
  double fov;          /* of the height, degrees */
  double off_x, off_y; /* principal point from the middle, in pictures */
  double pixel;        /* height of a pixel over its width */
} camera_view;

static void set_view(setup *s, const camera_view *v) {
  hbil_camera *camera = &s->frame.camera;
  setup_camera(s, v->fov);
  camera->fx *= v->pixel;
  camera->cx += v->off_x * s->config.width;
  camera->cy += v->off_y * s->config.height;
}

static const camera_view views[] = {
    {1.0, 0.0, 0.0, 1.0},    {10.0, 0.3, -0.2, 2.0}, {60.0, 0.0, 0.0, 1.0},
    {90.0, -2.0, 1.5, 0.25}, {120.0, 0.4, 0.0, 4.0}, {170.0, 0.0, 0.0, 1.0},
    {170.0, -0.4, 0.3, 0.5}};
#define VIEWS (sizeof views / sizeof *views)

/* ------------------------------------------------------------------------ */
/* fp32 against double, kernel by kernel                                     */

typedef enum figure_id {
  REPROJECT,
  PUSH_PULL,
  SPLIT_W,
  SPLIT_NORMAL,
  SPLIT_LIGHT,
  GATHER_AO,
  GATHER_LIGHT,
  GATHER_BENT,
  RECOMPOSE_AO,
  RECOMPOSE_LIGHT,
  RECOMPOSE_BENT,
  COMPOSITE_FAR,
  COMPOSITE_CONE,
  COMPOSITE_INDIRECT,
  COMPOSITE_RADIANCE,
  FIGURES
} figure_id;

/* limit: of the root mean square, in units of the plane's largest value.  Two
 * dozen roundings of 2^-24 are 1.4e-6; the gather takes a sample for risen or
 * not by a rounding, which moves E_near by all of its share where the last
 * accepted light counts. */
static const struct {
  const char *name;
  double limit;
} figure_kinds[FIGURES] = {
    [REPROJECT] = {"reproject: carried light", 0.0},
    [PUSH_PULL] = {"push/pull: filled light", 1e-6},
    [SPLIT_W] = {"split: inverse depth", 1e-6},
    [SPLIT_NORMAL] = {"split: normal", 1e-6},
    [SPLIT_LIGHT] = {"split: radiance", 1e-6},
    [GATHER_AO] = {"gather: AO", 1e-5},
    [GATHER_LIGHT] = {"gather: E_near", 1e-4},
    [GATHER_BENT] = {"gather: bent normal", 1e-5},
    [RECOMPOSE_AO] = {"recompose: AO", 1e-5},
    [RECOMPOSE_LIGHT] = {"recompose: E_near", 1e-5},
    [RECOMPOSE_BENT] = {"recompose: bent normal", 1e-5},
    [COMPOSITE_FAR] = {"composite: E_far", 1e-5},
    [COMPOSITE_CONE] = {"composite: cone", 1e-6},
    [COMPOSITE_INDIRECT] = {"composite: indirect", 1e-5},
    [COMPOSITE_RADIANCE] = {"composite: radiance", 1e-5},
};

/* Differences in units of the largest value that the plane has; how many are
 * above FAR_OFF. */
typedef struct figure {
  double largest, sum, squares;
  size_t count, far_off;
} figure;
#define FAR_OFF 1e-3

static void add_figure(figure *all, figure_id id, const exact_planes *got,
                       int got_first, const exact_planes *want, int want_first,
                       int count) {
  const size_t plane = (size_t)want->width * (size_t)want->height;
  const double *a = got->values + plane * (size_t)got_first;
  const double *b = want->values + plane * (size_t)want_first;
  const double most = largest_value(want, want_first, count);
  figure *f = all + id;
  for (size_t i = 0; i < plane * (size_t)count; ++i) {
    const double off = fabs(a[i] - b[i]) / (most > 0.0 ? most : 1.0);
    f->largest = fmax(f->largest, isfinite(off) ? off : INFINITY);
    f->sum += off;
    f->squares += off * off;
    f->count++;
    f->far_off += !(off <= FAR_OFF);
  }
}

/* A pass, and the stage it writes. */
static exact_planes passed(setup *s, enqueue_function *pass, hbil_stage stage) {
  setup_run(s, pass);
  return stage_read(s, stage);
}

/* Nobody needs light that is carried to the sky. */
static void clear_sky(const setup *s, exact_planes *carried) {
  for (int p = 0; p < carried->count; ++p)
    for (int i = 0; i < PIXELS; ++i)
      if (!(s->input[EXACT_DEPTH][i] > 0.0f &&
            s->input[EXACT_DEPTH][i] < 1e15f))
        carried->values[p * PIXELS + i] = 0.0;
}

static void measure_history(setup *s, const exact_planes *history,
                            figure *all) {
  exact_planes got = passed(s, hbil_enqueue_reproject, HBIL_STAGE_CARRIED);
  exact_planes want = checked_planes(WIDTH, HEIGHT, HBIL_CARRIED_PLANES);
  checked_reproject(&s->job, history, &want);
  add_figure(all, REPROJECT, &got, 0, &want, 0, HBIL_CARRIED_PLANES);
  checked_push_pull(&want);
  exact_planes_free(&got);
  got = passed(s, hbil_enqueue_push_pull, HBIL_STAGE_CARRIED);
  clear_sky(s, &got);
  clear_sky(s, &want);
  add_figure(all, PUSH_PULL, &got, 0, &want, 0, 3);
  exact_planes_free(&got);
  exact_planes_free(&want);
}

static void measure_split(setup *s, const exact_planes *carried,
                          const exact_planes *got, figure *all) {
  exact_planes want = checked_planes(WIDTH, HEIGHT, HBIL_SPLIT_PLANES);
  exact_split(&s->job, carried, &want);
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) { /* each w in units of itself */
      const double w = fabs(*exact_at(&want, HBIL_SPLIT_W, x, y));
      const double off = fabs(*exact_at(got, HBIL_SPLIT_W, x, y) /
                                  *exact_at(&want, HBIL_SPLIT_W, x, y) -
                              1.0);
      figure *f = all + SPLIT_W;
      f->largest = fmax(f->largest, off);
      f->sum += off;
      f->squares += off * off;
      f->count += w > 0.0;
    }
  add_figure(all, SPLIT_NORMAL, got, HBIL_SPLIT_NORMAL, &want,
             HBIL_SPLIT_NORMAL, 3);
  add_figure(all, SPLIT_LIGHT, got, HBIL_SPLIT_RED, &want, HBIL_SPLIT_RED, 3);
  exact_planes_free(&want);
}

/* light, bent: whether the plan has them. */
static void measure_planes(figure *all, figure_id first,
                           const exact_planes *got, const exact_planes *want,
                           bool light, bool bent) {
  add_figure(all, first, got, HBIL_LIGHT_AO, want, HBIL_LIGHT_AO, 1);
  if (light)
    add_figure(all, first + 1, got, HBIL_LIGHT_RED, want, HBIL_LIGHT_RED, 3);
  if (bent)
    add_figure(all, first + 2, got, HBIL_LIGHT_BENT, want, HBIL_LIGHT_BENT, 3);
}

static void measure_light(figure *all, figure_id first, const exact_planes *got,
                          const exact_planes *want) {
  measure_planes(all, first, got, want, true, true);
}

static void measure_composite(setup *s, const exact_planes *resolved,
                              figure *all) {
  exact_planes want = checked_planes(WIDTH, HEIGHT, EXACT_OUTPUT_PLANES);
  exact_planes history = checked_planes(WIDTH, HEIGHT, HBIL_HISTORY_PLANES);
  setup_run(s, hbil_enqueue_composite);
  exact_planes got = outputs_read(s);
  exact_composite(&s->job, resolved, &want, &history);
  add_figure(all, COMPOSITE_FAR, &got, EXACT_FAR_IRRADIANCE, &want,
             EXACT_FAR_IRRADIANCE, 3);
  add_figure(all, COMPOSITE_CONE, &got, EXACT_CONE_COSINE, &want,
             EXACT_CONE_COSINE, 1);
  add_figure(all, COMPOSITE_INDIRECT, &got, EXACT_INDIRECT, &want,
             EXACT_INDIRECT, 3);
  add_figure(all, COMPOSITE_RADIANCE, &got, EXACT_BEAUTY, &want, EXACT_BEAUTY,
             3);
  exact_planes_free(&got);
  exact_planes_free(&want);
  exact_planes_free(&history);
}

/* A frame, pass by pass: each on what the device has made of the passes before,
 * and the same in double. */
static void measure_frame(setup *s, bool has_history, figure *all) {
  exact_planes carried = {0}, split, gathered, resolved;
  setup_upload(s);
  if (has_history) {
    exact_planes history = stage_read(s, HBIL_STAGE_HISTORY);
    measure_history(s, &history, all);
    exact_planes_free(&history);
    carried = stage_read(s, HBIL_STAGE_CARRIED);
  }
  split = passed(s, hbil_enqueue_split, HBIL_STAGE_SPLIT);
  measure_split(s, has_history ? &carried : NULL, &split, all);
  exact_estimate_frame(&s->job, &split);
  gathered = passed(s, hbil_enqueue_gather, HBIL_STAGE_GATHERED);
  exact_planes want = checked_planes(WIDTH, HEIGHT, HBIL_GATHERED_PLANES);
  checked_gather(&s->job, &split, &want);
  measure_light(all, GATHER_AO, &gathered, &want);
  exact_planes_free(&want);
  resolved = passed(s, hbil_enqueue_recompose, HBIL_STAGE_RESOLVED);
  want = checked_planes(WIDTH, HEIGHT, HBIL_LIGHT_PLANES);
  exact_recompose(&s->job, &split, &gathered, &want);
  measure_light(all, RECOMPOSE_AO, &resolved, &want);
  measure_composite(s, &resolved, all);
  exact_planes_free(&want);
  exact_planes_free(&resolved);
  exact_planes_free(&gathered);
  exact_planes_free(&split);
  exact_planes_free(&carried);
  s->job.previous = s->frame.camera;
}

/* Largest and mean in units of 2^-24, a rounding of 1.  slack: times the
 * limits.
 */
static void check_figures(const figure *all, double slack) {
  for (int i = 0; i < FIGURES; ++i) {
    const figure *f = all + i;
    if (!f->count)
      continue;
    if (getenv("HBIL_TEST_VERBOSE"))
      print_message("%s | %s | %.3g | %.3g\n", trying, figure_kinds[i].name,
                    f->largest * 0x1p24, f->sum / (double)f->count * 0x1p24);
    check_below(figure_kinds[i].name, sqrt(f->squares / (double)f->count),
                figure_kinds[i].limit * slack);
  }
}

static void check_content(plan_kind kind, content what, const camera_view *v) {
  figure all[FIGURES] = {{0}};
  random_state r = {effort.seed};
  setup *s = begin(kind);
  TRY("%s, %s, seed %llu, field of view %g, off centre %g, %g, pixels 1 : %g",
      plan_names[kind], content_names[what], (unsigned long long)effort.seed,
      v ? v->fov : 0.0, v ? v->off_x : 0.0, v ? v->off_y : 0.0,
      v ? v->pixel : 1.0);
  for (uint32_t i = 0; i < 2; ++i) {
    if (what == ROOM) {
      load_room(s, i);
    } else {
      if (v)
        set_view(s, v);
      load_content(s, what, i, &r);
    }
    s->frame.environment[0][0] = s->frame.environment[2][1] = 1.0f;
    measure_frame(s, i > 0, all);
    check_sane(s);
  }
  /* roundings of a normal and its ray over HBIL_MIN_COSINE: 1e-3 of a gradient
   * where fewer digits are lost it is 1e-5 (measured: 3e-5 over all pixels) */
  check_figures(all, what == AWAY ? 10.0 : 1.0);
}

static void kernels_are_near_double(void **state) {
  (void)state;
  for (plan_kind kind = 0; kind < PACKED_PAPER; ++kind)
    for (content what = 0; what < CONTENTS && is_tried(kind); ++what)
      check_content(kind, what, NULL);
}

static void cameras_of_all_kinds_are_near_double(void **state) {
  (void)state;
  for (plan_kind kind = 0; kind < PACKED_PAPER; ++kind)
    for (size_t i = 0; i < VIEWS && is_tried(kind); ++i)
      check_content(kind, NOISE, &views[i]);
}

/* ------------------------------------------------------------------------ */
/* Planes                                                                    */

/* A plane through (0, 0, 3), tilted by so many degrees, that sends radiance 1;
 * what is behind the eye is sky. */
static void load_plane(setup *s, double tilt, double azimuth) {
  const hbil_camera *camera = &s->frame.camera;
  const size_t width = s->config.width, pixels = width * s->config.height;
  const double t = tilt * PI / 180.0;
  const double n[3] = {sin(t) * cos(azimuth), sin(t) * sin(azimuth), -cos(t)};
  for (size_t i = 0; i < pixels; ++i) {
    const double x = ((double)(i % width) + 0.5 - camera->cx) / camera->fx;
    const double y = ((double)(i / width) + 0.5 - camera->cy) / camera->fy;
    const double slope = n[0] * x + n[1] * y + n[2];
    /* surfaces seen from below 0.06 degrees are bent towards the eye */
    const bool seen = slope < -1e-3 * sqrt(x * x + y * y + 1.0);
    const double z = seen ? 3.0 * n[2] / slope : 0.0;
    s->input[EXACT_DEPTH][i] = z < 6e4 ? (float)z : 0.0f; /* halves end there */
    for (int c = 0; c < 3; ++c) {
      s->input[EXACT_NORMAL + c][i] = (float)n[c];
      s->input[EXACT_ALBEDO + c][i] = 1.0f;
      s->input[EXACT_F0 + c][i] = s->input[EXACT_EMISSION + c][i] = 0.0f;
      s->input[EXACT_DIRECT + c][i] = (float)PI;
    }
  }
}

static const double tilts[] = {0.0, 30.0, 60.0, 80.0, 85.0, 89.0, 89.9};
#define TILTS (sizeof tilts / sizeof *tilts)

/* Where the surface is, how closed it is at most, and the most light. */
typedef struct openness {
  double closed, light;
} openness;

static openness openness_of(setup *s) {
  exact_planes out = outputs_read(s);
  openness worst = {0.0, 0.0};
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      worst.closed = fmax(worst.closed, 1.0 - *exact_at(&out, EXACT_AO, x, y));
      worst.light =
          fmax(worst.light, *exact_at(&out, EXACT_NEAR_IRRADIANCE, x, y));
    }
  exact_planes_free(&out);
  return worst;
}

static void planes_are_bare_at_any_tilt(void **state) {
  (void)state;
  for (plan_kind kind = 0; kind < PLANS; ++kind)
    for (size_t i = 0; i < VIEWS * TILTS && is_tried(kind); ++i) {
      setup *s = begin(kind);
      const camera_view *v = &views[i / TILTS];
      TRY("%s, tilt %g, field of view %g, off centre %g, %g, pixels 1 : %g",
          plan_names[kind], tilts[i % TILTS], v->fov, v->off_x, v->off_y,
          v->pixel);
      set_view(s, v);
      load_plane(s, tilts[i % TILTS], 0.4 + 1.3 * (double)i);
      run(s);
      check_sane(s);
      const openness found = openness_of(s);
      /* as in test_plane.c; measured: 3.6e-7, 0 */
      check_below("1 - AO", found.closed, 1e-5);
      check_below("E_near", found.light, 1e-5);
    }
}

static void half_float_depth_makes_no_acne(void **state) {
  setup s;
  (void)state;
  setup_init(&s, WIDTH, HEIGHT);
  configure_one_sample(&s);
  s.config.slices = 2;
  s.config.steps_per_side = 8;
  s.config.storage = HBIL_STORAGE_PACKED;
  s.config.depth.component = HBIL_FLOAT16;
  setup_start(&s);
  for (size_t i = 0; i < VIEWS * TILTS; ++i) {
    const camera_view *v = &views[i / TILTS];
    TRY("half depth, tilt %g, field of view %g, off centre %g, %g, pixels 1 : "
        "%g",
        tilts[i % TILTS], v->fov, v->off_x, v->off_y, v->pixel);
    set_view(&s, v);
    load_plane(&s, tilts[i % TILTS], 0.4 + 1.3 * (double)i);
    run(&s);
    check_sane(&s);
    check_below("1 - AO", openness_of(&s).closed, 0.02);
  }
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Feedback                                                                  */

/* Light of the room's surfaces, in units of 1: mean, least, most. */
typedef struct evenness {
  double mean, least, most;
} evenness;

static evenness evenness_of(setup *s) {
  exact_planes out = outputs_read(s);
  evenness e = {0.0, INFINITY, 0.0};
  double count = 0.0;
  for (int i = 0; i < 3 * PIXELS; ++i)
    if (s->input[EXACT_DEPTH][i % PIXELS] > 0.0f) {
      const double light = (out.values[EXACT_NEAR_IRRADIANCE * PIXELS + i] +
                            out.values[EXACT_FAR_IRRADIANCE * PIXELS + i]) /
                           PI;
      e.mean += light;
      e.least = fmin(e.least, light);
      e.most = fmax(e.most, light);
      count += 1.0;
    }
  e.mean /= count;
  exact_planes_free(&out);
  return e;
}

/* A furnace without loss: albedo 1, light 1 in all directions, once.  What the
 * screen doesn't show has the frame's mean, so nothing can come in or go.
 * Packed light is off by a step of its 8 bits, 2^-7, here and there, and in the
 * mean by less; fp32 by two hundred roundings or so (measured: 2.9e-6).  The
 * mean drifts by what its roundings have in common, one of 2^-24 for each of
 * the 180 frames in between at most (measured: 6.7e-6). */
static void light_neither_grows_nor_fades(void **state) {
  (void)state;
  for (plan_kind kind = 0; kind < PLANS; ++kind) {
    if ((kind != FILLED && kind != PACKED_FILLED) || !is_tried(kind))
      continue;
    const double step = is_packed(kind) ? 0x1p-7 : 2e-5;
    setup *s = begin(kind);
    evenness early = {0};
    TRY("200 frames of albedo 1, %s", plan_names[kind]);
    for (int p = EXACT_ALBEDO; p < EXACT_MOTION + 2; ++p)
      setup_fill(s, p, p < EXACT_F0 ? 1.0f : 0.0f);
    for (int i = 0; i < 200; ++i) {
      for (int c = 0; c < 3; ++c)
        setup_fill(s, EXACT_DIRECT + c, i ? 0.0f : (float)PI);
      s->frame.frame_index = (cl_uint)i;
      run(s);
      if (i == 20)
        early = evenness_of(s);
    }
    const evenness late = evenness_of(s);
    check_below("light that was lost", 1.0 - late.least, 2.0 * step);
    check_below("light that was made", late.most - 1.0, step);
    check_below("drift of the mean", fabs(late.mean - early.mean),
                is_packed(kind) ? 0.25 * step : 180 * 0x1p-24);
  }
}

/* A single event that is kept from every frame would be 200 bytes of each. */
static void moving_on_takes_no_memory(void **state) {
  const int frames = effort.seconds > 0.0 ? 10000 : 600;
  size_t before = 0;
  setup *s = begin(PACKED_FILLED);
  (void)state;
  for (int i = 0; i < frames; ++i) {
    if (i == 100)
      before = mallinfo2().uordblks;
    s->frame.frame_index = (cl_uint)i;
    for (int c = 0; c < 3; ++c)
      s->frame.camera.world_from_view[4 * c + 3] += 0.01 * sin(0.1 * i + c);
    setup_run(s, hbil_enqueue_frame);
  }
  TRY("%d frames", frames);
  check_below("bytes that are kept",
              (double)mallinfo2().uordblks - (double)before, 65536.0);
  check_sane(s);
}

/* ------------------------------------------------------------------------ */
/* Horizons at the zenith and at the tangent plane, in long double           */

typedef long double real;

/* What is between the direction to the eye and the angle theta, whose tangent
 * is along / up: HACKING's A, for a normal of these components. */
static real measure(real nx, real ny, real along, real up) {
  const real size = sqrtl(along * along + up * up);
  const real sine = along / size, theta = atan2l(along, up);
  return nx / 2 * (theta - sine * up / size) + ny / 2 * sine * sine;
}

/* A pixel as its one slice sees it. */
typedef struct cut {
  real wo[3], r, w;
  real ud, nx, ny; /* u.D; the normal along D and wo */
  real gx, gy;     /* the plane's gradient of inverse depth */
  real b;          /* cot(theta) of no slope at all */
} cut;

static cut cut_of(const setup *s, const exact_planes *split, int x, int y,
                  float ux, float uy) {
  const hbil_camera *camera = &s->frame.camera;
  const real ray[3] = {(x + (real)0.5 - camera->cx) / camera->fx,
                       (y + (real)0.5 - camera->cy) / camera->fy, 1};
  cut c = {.w = *exact_at(split, HBIL_SPLIT_W, x, y)};
  real n[3], n_r = 0, u_wo, n_u;
  c.r = sqrtl(ray[0] * ray[0] + ray[1] * ray[1] + 1);
  for (int i = 0; i < 3; ++i) {
    n[i] = *exact_at(split, HBIL_SPLIT_NORMAL + i, x, y);
    c.wo[i] = -ray[i] / c.r;
    n_r += n[i] * ray[i];
  }
  u_wo = ux * c.wo[0] + uy * c.wo[1];
  n_u = n[0] * ux + n[1] * uy;
  c.ud = sqrtl((real)ux * ux + (real)uy * uy - u_wo * u_wo);
  c.ny = -n_r / c.r;
  c.nx = (n_u - u_wo * c.ny) / c.ud;
  c.gx = n[0] * c.w / n_r;
  c.gy = n[1] * c.w / n_r;
  c.b = u_wo / c.ud;
  return c;
}

/* AO of a pixel with one slice of one sample on each side. */
static double one_sample_ao(const setup *s, const exact_planes *split, int x,
                            int y) {
  const hbil_pattern_args pattern = exact_pattern(&s->job);
  const hbil_view_args view = exact_view(&s->config, &s->frame.camera);
  const int layer = 4 * (y % 4) + x % 4;
  float ux, uy;
  real open = 0, whole = 0;
  hbil_slice_direction(layer, 0, pattern, &ux, &uy);
  for (int side = 0; side < 2; ++side, ux = -ux, uy = -uy) {
    const cut c = cut_of(s, split, x, y, ux, uy);
    const real start = measure(c.nx, c.ny, c.ny, -c.nx);
    int dx, dy;
    hbil_sample_offset(layer, 0, 0, ux, uy, view, pattern, &dx, &dy);
    whole += start;
    if (x + dx < 0 || x + dx >= WIDTH || y + dy < 0 || y + dy >= HEIGHT) {
      open += start;
      continue;
    }
    const real ex = dx / (real)view.fx, ey = dy / (real)view.fy;
    const real e = sqrtl(ex * ex + ey * ey);
    const real w1 = *exact_at(split, HBIL_SPLIT_W, x + dx, y + dy);
    const real excess = (w1 - c.w - c.gx * ex - c.gy * ey) / e;
    /* cot(theta) is the tangent plane's, or what the sample adds to it */
    const real cot = -c.nx / c.ny + fmaxl(excess, 0) * c.r / (c.ud * c.w);
    open += measure(c.nx, c.ny, 1, cot);
  }
  return (double)(open / whole);
}

/* Walls with every fourth pixel, at random, nearer by this factor: from the
 * tangent plane, less than a rounding above it, up to the zenith. */
static const double nearer[] = {0x1p-24,  0x1p-22,  1e-6,     1e-5, 1e-4, 1e-3,
                                1e-2,     0.1,      0.5,      0.9,  0.99, 0.999,
                                1 - 1e-5, 1 - 1e-7, 1 - 1e-10};
#define NEARER (sizeof nearer / sizeof *nearer)

static void horizons_from_the_tangent_plane_to_the_zenith(void **state) {
  setup *s = begin(ONE_SAMPLE);
  random_state r = {effort.seed};
  double worst = 0.0, mean = 0.0, count = 0.0;
  (void)state;
  setup_camera(s, 60.0);
  for (size_t i = 0; i < NEARER * 3; ++i) {
    const double tilt = 40.0 * (double)(i / NEARER);
    TRY("one sample nearer by %g on a wall tilted by %g degrees",
        nearer[i % NEARER], tilt);
    load_plane(s, tilt, 0.7);
    for (int p = 0; p < PIXELS; ++p)
      if (random_unit(&r) < 0.25)
        s->input[EXACT_DEPTH][p] =
            (float)(s->input[EXACT_DEPTH][p] * (1.0 - nearer[i % NEARER]));
    run(s);
    exact_planes split = stage_read(s, HBIL_STAGE_SPLIT);
    exact_planes got = stage_read(s, HBIL_STAGE_GATHERED);
    for (int y = 0; y < HEIGHT; ++y)
      for (int x = 0; x < WIDTH; ++x) {
        if (!(*exact_at(&split, HBIL_SPLIT_W, x, y) > 0.0))
          continue;
        const double off = fabs(*exact_at(&got, HBIL_LIGHT_AO, x, y) -
                                one_sample_ao(s, &split, x, y));
        worst = fmax(worst, isfinite(off) ? off : INFINITY);
        mean += off;
        count += 1.0;
      }
    exact_planes_free(&split);
    exact_planes_free(&got);
    /* the kernel lowers the sample by 2^-22 of its inverse depth: over a pixel,
     * 1/42 of a slope here, 1e-5 of the cotangent (measured: 7.8e-6) */
    check_below("AO against long double", worst, 1e-5);
  }
  if (getenv("HBIL_TEST_VERBOSE"))
    print_message("horizons | gather: AO | %.3g | %.3g\n", worst * 0x1p24,
                  mean / count * 0x1p24);
}

/* ------------------------------------------------------------------------ */
/* Random settings                                                           */

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
  for (image_id id = 0; id < PLANE_COUNT; ++id) {
    const bool colour = id >= PLANE_ALBEDO && id <= PLANE_EMISSION;
    hbil_plane_format *format = image_format(c, id);
    *format = any_format(r, image_channels(id), colour);
    if ((colour || id >= PLANE_FIRST_OUTPUT) && maybe(r, 0.2))
      format->component = HBIL_NONE;
  }
  c->ao = (hbil_plane_format){HBIL_FLOAT32, 1}; /* so that there is an output */
  c->depth_kind = (hbil_depth_kind)below(r, 2);
  c->normal_space = (hbil_space)below(r, 2);
  c->bent_normal_space = (hbil_space)below(r, 2);
  c->direct_scale = maybe(r, 0.2) ? 1e10f : 1.0f;
  c->sky_depth = maybe(r, 0.2) ? 1e6f : INFINITY;
}

static void any_model(hbil_config *c, random_state *r) {
  const float lengths[] = {1e-6f, 0.3f, 2.0f, 1e4f, 1e12f};
  c->projection = maybe(r, 0.2) ? HBIL_PROJECTION_ORTHOGRAPHIC
                                : HBIL_PROJECTION_PERSPECTIVE;
  c->mode = (hbil_mode)(maybe(r, 0.6) ? 0 : below(r, 3));
  c->falloff = (hbil_falloff)below(r, 3);
  c->radius = maybe(r, 0.5) ? INFINITY : ANY_OF(r, lengths);
  c->thickness = maybe(r, 0.7) ? INFINITY : ANY_OF(r, lengths);
  c->relative_thickness = maybe(r, 0.6)   ? INFINITY
                          : maybe(r, 0.5) ? 0.08f
                                          : 1e-6f;
  c->facing_fade[0] = maybe(r, 0.3) ? -1.0f : (float)random_unit(r) - 0.6f;
  c->facing_fade[1] = c->facing_fade[0] == -1.0f || maybe(r, 0.3)
                          ? c->facing_fade[0]
                          : c->facing_fade[0] + 0.3f;
  c->back_facing_fallback = (hbil_back_facing_fallback)below(r, 3);
  c->gather_emission = (cl_bool)below(r, 2);
  c->reprojection = (hbil_reprojection)below(r, 3);
  c->feedback = (hbil_feedback)below(r, 2);
  c->disocclusion_threshold = maybe(r, 0.2) ? INFINITY : 0.05f;
  c->far_field = (hbil_far_field)below(r, 4);
  if (c->mode != HBIL_MODE_HBIL) {
    c->near_irradiance.component = HBIL_NONE;
    c->far_field = (hbil_far_field)below(r, 2);
  }
  if (c->mode == HBIL_MODE_HBAO)
    c->bent_normal.component = c->cone_cosine.component = HBIL_NONE;
}

static void any_sampling(hbil_config *c, random_state *r) {
  const cl_uint samples[] = {1, 3, 8, 33}, widths[] = {1, 4, 8, 16, 8, 8};
  c->slices = 1 + below(r, 4);
  c->steps_per_side = ANY_OF(r, samples);
  c->step_growth = maybe(r, 0.3) ? 0.0f : 4.0f * (float)random_unit(r);
  c->sample_grid = (hbil_sample_grid)below(r, 2);
  c->unfiltered = maybe(r, 0.2);
  c->storage = (hbil_storage)below(r, 4);
  c->vector_width = ANY_OF(r, widths);
  c->skip = maybe(r, 0.5) ? HBIL_SKIP_ALL : below(r, HBIL_SKIP_ALL + 1);
}

static void tell_settings(uint64_t seed, const hbil_config *c,
                          const char *inputs, const camera_view *v) {
  TRY("seed %llu: %s, %u x %u, projection %d mode %d falloff %d radius %g "
      "thickness %g %g "
      "facing %g %g refused %d gather_emission %d reprojection %d feedback %d "
      "disocclusion %g far_field %d, %u x %u growth %g lattice %d raw %d "
      "storage %d width %u skip %u, depth %d/%u kind %d, normal %d/%u in %d, "
      "direct_scale %g, field of view %g, off centre %g, %g, pixels 1 : %g",
      (unsigned long long)seed, inputs, c->width, c->height, (int)c->projection,
      (int)c->mode, (int)c->falloff, (double)c->radius, (double)c->thickness,
      (double)c->relative_thickness, (double)c->facing_fade[0],
      (double)c->facing_fade[1], (int)c->back_facing_fallback,
      (int)c->gather_emission, (int)c->reprojection, (int)c->feedback,
      (double)c->disocclusion_threshold, (int)c->far_field, c->slices,
      c->steps_per_side, (double)c->step_growth, (int)c->sample_grid,
      (int)c->unfiltered, (int)c->storage, c->vector_width, c->skip,
      (int)c->depth.component, c->depth.stride, (int)c->depth_kind,
      (int)c->normal.component, c->normal.stride, (int)c->normal_space,
      (double)c->direct_scale, v->fov, v->off_x, v->off_y, v->pixel);
}

/* As many planes as the reference wants; those that a plan hasn't are 0. */
static exact_planes widened(exact_planes planes, int count) {
  exact_planes wide = checked_planes(planes.width, planes.height, count);
  memcpy(wide.values, planes.values,
         sizeof(double) * (size_t)(planes.width * planes.height) *
             (size_t)(planes.count < count ? planes.count : count));
  exact_planes_free(&planes);
  return wide;
}

/* Halves end there. */
static void end_with_halves(const setup *s, exact_planes *light) {
  const size_t plane = (size_t)light->width * (size_t)light->height;
  double *values = light->values + plane * HBIL_LIGHT_RED;
  for (size_t i = 0; s->config.storage == HBIL_STORAGE_HALF && i < 3 * plane;
       ++i)
    values[i] = fmin(values[i], 65504.0);
}

/* What the gather has made of the split planes, and recompose of that, against
 * double.  10 bits of E_near are off by half of FAR_OFF, halves by a quarter;
 * packed bent normals, in steps of 1/511 however short they are, are
 * test_storage's.  By more are
 * only samples that a rounding takes for risen, sectors that it takes for
 * covered, and gradients of surfaces seen edge on, where it is 6e-8 over a
 * cosine of 1e-4: a value in a hundred may be (measured, over 56 comparisons:
 * none), or three of a tiny picture. */
static void check_near_double(setup *s) {
  figure all[FIGURES] = {{0}};
  const bool light = gathers_light(s);
  exact_planes got = stage_read(s, HBIL_STAGE_RESOLVED);
  const bool bent =
      got.count > HBIL_LIGHT_BENT && s->config.storage == HBIL_STORAGE_FLOAT32;
  exact_planes resolved = widened(got, HBIL_LIGHT_PLANES);
  exact_planes split =
      widened(stage_read(s, HBIL_STAGE_SPLIT), HBIL_SPLIT_PLANES);
  exact_planes gathered =
      widened(stage_read(s, HBIL_STAGE_GATHERED), HBIL_GATHERED_PLANES);
  exact_planes want =
      checked_planes(split.width, split.height, HBIL_GATHERED_PLANES);
  exact_estimate_frame(&s->job, &split);
  checked_gather(&s->job, &split, &want);
  end_with_halves(s, &want);
  measure_planes(all, GATHER_AO, &gathered, &want, light, bent);
  exact_recompose(&s->job, &split, &gathered, &want);
  measure_planes(all, RECOMPOSE_AO, &resolved, &want, light, bent);
  exact_planes_free(&split);
  exact_planes_free(&gathered);
  exact_planes_free(&resolved);
  exact_planes_free(&want);
  for (int i = 0; i < FIGURES; ++i) {
    if (!all[i].count)
      continue;
    if (getenv("HBIL_TEST_VERBOSE"))
      print_message("%s: %zu of %zu far off, the largest by %.3g\n",
                    figure_kinds[i].name, all[i].far_off, all[i].count,
                    all[i].largest);
    check_below(figure_kinds[i].name, (double)all[i].far_off,
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
    print_message("%s\n", trying);
  setup_start(&s);
  for (uint32_t i = 0; i < FRAMES; ++i) {
    if (what == ROOM) {
      load_room(&s, i);
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
    run(&s);
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

/* As many as there is time for: each is compiled, which takes seconds. */
static void any_settings_are_sane(void **state) {
  const double end = now() + effort.seconds;
  (void)state;
  for (uint64_t i = 0; now() < end; ++i)
    check_settings(effort.seed + i);
}

int main(void) {
  const char *seed = getenv("HBIL_STRESS_SEED");
  const char *seconds = getenv("HBIL_STRESS_SECONDS");
  if (seed)
    effort.seed = strtoull(seed, NULL, 10);
  if (seconds)
    effort.seconds = strtod(seconds, NULL);
  cmocka_set_test_filter(getenv("HBIL_STRESS_TEST"));
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_unit_of_length_does_not_matter),
      cmocka_unit_test(what_is_repaired_is_counted_and_never_spread),
      cmocka_unit_test(still_frames_count_what_the_frame_before_did),
      cmocka_unit_test(who_reads_first_counts),
      cmocka_unit_test(counts_need_a_frame),
      cmocka_unit_test(kernels_are_near_double),
      cmocka_unit_test(cameras_of_all_kinds_are_near_double),
      cmocka_unit_test(planes_are_bare_at_any_tilt),
      cmocka_unit_test(half_float_depth_makes_no_acne),
      cmocka_unit_test(light_neither_grows_nor_fades),
      cmocka_unit_test(moving_on_takes_no_memory),
      cmocka_unit_test(horizons_from_the_tangent_plane_to_the_zenith),
      cmocka_unit_test(any_settings_are_sane),
  };
  return RUN_WITH_GPU(tests);
}
