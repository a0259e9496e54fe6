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

static const hbil_format triple = {HBIL_FLOAT32, 3};

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
  PLANS
} plan_kind;

static const char *const plan_names[PLANS] = {
    "the paper's model, fp32", "light from the frame, fp32",
    "the paper's model, packed", "light from the frame, packed"};

static bool is_packed(plan_kind kind) {
  return kind >= PACKED_PAPER;
}

static void configure(setup *s, plan_kind kind) {
  setup_all_outputs(s);
  s->config.f0 = triple;
  if (is_packed(kind))
    s->config.storage = HBIL_STORAGE_PACKED;
  if (kind == PAPER || kind == PACKED_PAPER) {
    s->config.far_field = HBIL_FAR_SH;
    return;
  }
  s->config.refused = HBIL_REFUSED_FRAME;
  s->config.far_field = HBIL_FAR_FRAME;
  s->config.reprojection = HBIL_REPROJECTION_MOTION;
}

static setup plans[PLANS];

/* A camera's normals, as its view has them. */
static void turn_normals(setup *s) {
  const double *m = s->frame.camera.world_from_view;
  const size_t pixels = (size_t)s->config.width * s->config.height;
  for (size_t i = 0; i < pixels; ++i) {
    double n[3];
    for (int c = 0; c < 3; ++c)
      n[c] = m[c] * (double)s->input[REF_NORMAL][i] +
             m[4 + c] * (double)s->input[REF_NORMAL + 1][i] +
             m[8 + c] * (double)s->input[REF_NORMAL + 2][i];
    for (int c = 0; c < 3; ++c)
      s->input[REF_NORMAL + c][i] = (float)n[c];
  }
}

static void load_room(setup *s, uint32_t index) {
  setup_load_scene(s, SCENE_ROOM, index);
  turn_normals(s);
  for (int c = 0; c < 3; ++c)
    setup_fill(s, REF_F0 + c, 0.04f);
  s->frame.index = index;
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

static void check_finite(const char *what, const ref_planes *planes) {
  const size_t total =
      (size_t)planes->width * (size_t)planes->height * (size_t)planes->count;
  for (size_t i = 0; i < total; ++i)
    if (!isfinite(planes->values[i]))
      fail_msg("%s: value %zu of plane %zu is %g\ntrying %s", what,
               i % (total / (size_t)planes->count),
               i / (total / (size_t)planes->count), planes->values[i], trying);
}

static void check_range(const char *what, const ref_planes *planes, int first,
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
    ref_planes split = stage_read(s, HBIL_STAGE_SPLIT);
    if (split.count > HBIL_SPLIT_RED)
      most = largest_value(&split, HBIL_SPLIT_RED, 3);
    ref_planes_free(&split);
  }
  if (s->config.far_field == HBIL_FAR_CONSTANT)
    for (int c = 0; c < 3; ++c)
      most = fmax(most, (double)s->frame.environment[0][c]);
  return most;
}

/* Half outputs and the 10 bits of packed E_near: half a step of the largest
 * value, 2^-10; otherwise sums of some hundred roundings. */
static double slack(const setup *s) {
  return s->config.storage == HBIL_STORAGE_PACKED ||
                 s->config.near_light.component == HBIL_FLOAT16
             ? 0x1p-9
             : 1e-5;
}

static void check_stage(setup *s, hbil_stage stage, const char *name) {
  hbil_buffer b;
  if (hbil_plan_buffer(s->plan, stage, &b) != HBIL_SUCCESS)
    return;
  ref_planes planes = stage_read(s, stage);
  check_finite(name, &planes);
  ref_planes_free(&planes);
}

static void check_bent(const ref_planes *out, double tolerance) {
  for (int y = 0; y < out->height; ++y)
    for (int x = 0; x < out->width; ++x) {
      double size = 0.0;
      for (int c = 0; c < 3; ++c)
        size += pow(*ref_at(out, REF_BENT + c, x, y), 2.0);
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
  const double light = brightest(s) * PI * (1.0 + slack(s));
  ref_planes out = outputs_read(s);
  check_finite("outputs", &out);
  check_range("ao", &out, REF_AO, 1, 0.0, 1.0);
  check_range("near_light", &out, REF_NEAR, 3, 0.0, light);
  check_range("far_light", &out, REF_FAR, 3, 0.0, sh ? INFINITY : light);
  check_range("cone", &out, REF_CONE, 1, 0.0, 1.0);
  check_range("indirect", &out, REF_INDIRECT, 3, 0.0, INFINITY);
  check_range("radiance", &out, REF_RADIANCE, 3, 0.0, INFINITY);
  if (asks_for(s, IMAGE_BENT)) /* roundings; of three halves 2^-11 each */
    check_bent(&out, s->config.bent.component == HBIL_FLOAT16 ? 1e-3 : 1e-6);
  ref_planes_free(&out);
  check_stage(s, HBIL_STAGE_SPLIT, "split");
  check_stage(s, HBIL_STAGE_GATHERED, "gathered");
  check_stage(s, HBIL_STAGE_RESOLVED, "resolved");
  check_stage(s, HBIL_STAGE_HISTORY, "history");
  check_stage(s, HBIL_STAGE_CARRIED, "carried");
}

/* ------------------------------------------------------------------------ */
/* Scale                                                                     */

/* Two frames of the room, in units of 1/scale. */
static ref_planes room_scaled(plan_kind kind, double scale) {
  setup *s = begin(kind);
  for (uint32_t i = 0; i < 2; ++i) {
    load_room(s, i);
    for (int c = 0; c < 3; ++c)
      s->frame.camera.world_from_view[4 * c + 3] *= scale;
    for (int p = 0; p < PIXELS; ++p)
      s->input[REF_DEPTH][p] = (float)(s->input[REF_DEPTH][p] * scale);
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
    ref_planes want = room_scaled(kind, 1.0);
    for (size_t i = 0; i < sizeof scales / sizeof *scales; ++i) {
      TRY("scale %g, %s", scales[i], plan_names[kind]);
      ref_planes got = room_scaled(kind, scales[i]);
      for (image_id id = IMAGE_FIRST_OUTPUT; id < IMAGE_COUNT; ++id)
        check_below(
            image_name(id),
            relative_rmse(&got, &want, image_first(id), image_channels(id)),
            id == IMAGE_CONE ? 1e-3 : 1e-4);
      ref_planes_free(&got);
    }
    ref_planes_free(&want);
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
    SPOIL(r, share, s->input[REF_DEPTH][i], odd_depths);
    if (random_unit(r) < share) {
      const float *n = ANY_OF(r, odd_normals);
      for (int c = 0; c < 3; ++c)
        s->input[REF_NORMAL + c][i] = n[c];
    }
    for (int c = 0; c < 3; ++c) {
      SPOIL(r, share, s->input[REF_ALBEDO + c][i], odd_shares);
      SPOIL(r, share, s->input[REF_F0 + c][i], odd_shares);
      SPOIL(r, share, s->input[REF_DIRECT + c][i], odd_light);
      SPOIL(r, share, s->input[REF_EMISSION + c][i], odd_light);
    }
    for (int c = 0; c < 2; ++c)
      SPOIL(r, share, s->input[REF_MOTION + c][i], odd_motion);
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
    n[c] = s->input[REF_NORMAL + c] + i;
  const float size = fmaf(*n[0], *n[0], fmaf(*n[1], *n[1], *n[2] * *n[2]));
  if (size >= 1e-20f && size < INFINITY)
    return false;
  const hbil_view_args v = ref_view(&s->config, &s->frame.camera);
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
static hbil_repaired repair(setup *s) {
  const size_t pixels = (size_t)s->config.width * s->config.height;
  hbil_repaired n = {0};
  for (size_t i = 0; i < pixels; ++i) {
    n.depth += repair_planes(s, REF_DEPTH, 1, i, repair_depth);
    const float depth = s->input[REF_DEPTH][i];
    const size_t solid = depth > 0.0f && depth < 1e15f;
    n.normal += solid * repair_normal(s, i);
    n.albedo += solid * repair_planes(s, REF_ALBEDO, 3, i, repair_share);
    n.f0 += solid * repair_planes(s, REF_F0, 3, i, repair_share);
    n.direct += solid * repair_planes(s, REF_DIRECT, 3, i, repair_light);
    n.motion += solid * repair_planes(s, REF_MOTION, 2, i, repair_motion);
    n.emission += repair_planes(s, REF_EMISSION, 3, i, repair_light);
  }
  return n;
}

static hbil_repaired counted(setup *s) {
  hbil_repaired n;
  assert_success(s, hbil_plan_repaired(s->plan, s->gpu->queue, &n));
  return n;
}

static void check_counts(const hbil_repaired *got, const hbil_repaired *want) {
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
                           ref_planes out[FRAMES],
                           hbil_repaired repairs[FRAMES]) {
  random_state r = {seed};
  setup *s = begin(kind);
  for (uint32_t i = 0; i < FRAMES; ++i) {
    hbil_repaired own = {0};
    load_room(s, i);
    spoil(s, &r, i == FRAMES - 1 ? 0.01 : 0.1);
    if (repaired_before)
      own = repair(s);
    run(s);
    const hbil_repaired found = counted(s);
    if (repaired_before) {
      const hbil_repaired none = {0};
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
    ref_planes got[FRAMES], want[FRAMES];
    hbil_repaired found[FRAMES], made[FRAMES];
    TRY("spoiled inputs, seed %llu, %s", (unsigned long long)effort.seed,
        plan_names[kind]);
    spoiled_frames(kind, effort.seed, false, got, found);
    spoiled_frames(kind, effort.seed, true, want, made);
    for (int i = 0; i < FRAMES; ++i) {
      check_counts(&found[i], &made[i]);
      check_below("values that a repair has changed",
                  (double)count_different(&got[i], &want[i]), 0.0);
      ref_planes_free(&got[i]);
      ref_planes_free(&want[i]);
    }
  }
}

int main(void) {
  const char *seed = getenv("HBIL_STRESS_SEED");
  const char *seconds = getenv("HBIL_STRESS_SECONDS");
  if (seed)
    effort.seed = strtoull(seed, NULL, 10);
  if (seconds)
    effort.seconds = strtod(seconds, NULL);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_unit_of_length_does_not_matter),
      cmocka_unit_test(what_is_repaired_is_counted_and_never_spread),
  };
  return RUN_WITH_GPU(tests);
}
