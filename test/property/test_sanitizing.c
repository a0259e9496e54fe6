/*
 * Inputs that are not valid are replaced by the values that hbil.h documents,
 * are counted, and change nothing beyond their own pixel.
 */
#include "test/support/contents.h"
#include "test/support/stress.h"

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

/* Replaces what is not valid by the documented values, and counts it. */
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
  assert_success(s, hbil_plan_sanitized(s->plan, s->device->queue, &n));
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
               rows[i].got, rows[i].want, stress_case);
}

#define FRAMES 3

/* Runs frames of spoiled inputs, or of the same inputs with the documented
 * replacements. */
static void spoiled_frames(plan_kind kind, uint64_t seed, bool repaired_before,
                           exact_planes out[FRAMES],
                           hbil_sanitized repairs[FRAMES]) {
  random_state r = {seed};
  setup *s = stress_begin(kind);
  for (uint32_t i = 0; i < FRAMES; ++i) {
    hbil_sanitized own = {0};
    stress_load_room(s, i);
    spoil(s, &r, i == FRAMES - 1 ? 0.01 : 0.1);
    if (repaired_before)
      own = repair(s);
    stress_run(s);
    const hbil_sanitized found = counted(s);
    if (repaired_before) {
      const hbil_sanitized none = {0};
      check_counts(&found, &none);
      repairs[i] = own;
      if (i == 0 || s->config.history.reprojection != HBIL_REPROJECTION_MOTION)
        repairs[i].motion = 0;
    } else {
      repairs[i] = found;
    }
    check_sane(s);
    out[i] = outputs_read(s);
  }
}

TEST(spoiled_inputs_equal_repaired_ones) {
  for (plan_kind kind = 0; kind < PLANS; ++kind) {
    exact_planes got[FRAMES], want[FRAMES];
    hbil_sanitized found[FRAMES], made[FRAMES];
    if (!stress_tries(kind))
      continue;
    STRESS_CASE("spoiled inputs, seed %llu, %s",
                (unsigned long long)stress_effort.seed,
                stress_plan_names[kind]);
    spoiled_frames(kind, stress_effort.seed, false, got, found);
    spoiled_frames(kind, stress_effort.seed, true, want, made);
    for (int i = 0; i < FRAMES; ++i) {
      check_counts(&found[i], &made[i]);
      check_case("values that a repair has changed",
                 (double)count_different(&got[i], &want[i]), 0.0);
      planes_free(&got[i], &want[i]);
    }
  }
}

/* A static frame has the inputs of the frame before, and its counts.  Motion is
 * not read. */
TEST(static_frames_repeat_the_counts) {
  random_state r = {stress_effort.seed};
  setup *s = stress_begin(PACKED_ESTIMATE);
  STRESS_CASE("static frames");
  spoil(s, &r, 0.1);
  for (int c = 0; c < 2; ++c)
    setup_fill(s, EXACT_MOTION + c, 0.0f);
  stress_run(s);
  const hbil_sanitized first = counted(s);
  assert_true(first.depth > 0 && first.emission > 0);
  s->frame.static_frame = CL_TRUE;
  for (int i = 0; i < 2; ++i) {
    stress_run(s);
    const hbil_sanitized again = counted(s);
    check_counts(&again, &first);
  }
  s->frame.static_frame = CL_FALSE;
}

/* Without near light, split reads depth and normals alone, and composite reads
 * the other inputs. */
TEST(the_first_reader_counts) {
  random_state r = {stress_effort.seed};
  setup *s = stress_begin(ONE_SAMPLE);
  STRESS_CASE("inputs that composite alone reads");
  for (int i = 0; i < 2; ++i) { /* each frame anew */
    spoil(s, &r, 0.1);
    stress_run(s);
    const hbil_sanitized found = counted(s);
    hbil_sanitized made = repair(s);
    made.motion = 0;
    assert_true(made.albedo > 0 && made.f0 > 0);
    assert_true(made.direct > 0 && made.emission > 0);
    check_counts(&found, &made);
    check_sane(s);
  }
}

/* The number of surfaces whose normal's cosine with the ray is above `most`. */
static size_t facing_away(const setup *s, double most) {
  const hbil_view_args v = exact_view(&s->config, &s->frame.camera);
  size_t count = 0;
  for (size_t i = 0; i < PIXELS; ++i) {
    const double ray[3] = {((double)(i % WIDTH) + 0.5 - v.cx) / v.fx,
                           ((double)(i / WIDTH) + 0.5 - v.cy) / v.fy, 1.0};
    double along = 0.0, ray2 = 0.0, normal2 = 0.0;
    for (int c = 0; c < 3; ++c) {
      const double n = s->input[EXACT_NORMAL + c][i];
      along += n * ray[c];
      ray2 += ray[c] * ray[c];
      normal2 += n * n;
    }
    count +=
        s->input[EXACT_DEPTH][i] > 0.0f && along > most * sqrt(ray2 * normal2);
  }
  return count;
}

TEST(normals_that_face_away_are_counted) {
  for (plan_kind kind = 0; kind < PLANS; ++kind) {
    setup *s = stress_begin(kind);
    STRESS_CASE("normals that face away, %s", stress_plan_names[kind]);
    size_t found[2];
    for (int flipped = 0; flipped < 2; ++flipped) {
      for (int i = 0; flipped && i < PIXELS; ++i) /* rows from the other end */
        s->input[EXACT_NORMAL + 1][i] *= -1.0f;
      stress_run(s);
      const hbil_sanitized all = counted(s), none = {0};
      check_counts(&all, &none);
      found[flipped] = all.facing_away;
      assert_in_range(found[flipped], facing_away(s, 0.2 + 1e-5),
                      facing_away(s, 0.2 - 1e-5));
    }
    assert_true(found[1] > PIXELS / 10 && found[1] > 2 * found[0]);
  }
}

TEST(counts_need_a_frame) {
  setup *s = stress_begin(ONE_SAMPLE);
  hbil_sanitized out;
  const cl_command_queue queue = s->device->queue;
  assert_int_equal(hbil_plan_sanitized(NULL, queue, &out),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_sanitized(s->plan, NULL, &out),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_sanitized(s->plan, queue, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_sanitized(s->plan, queue, &out),
                   HBIL_INVALID_ARGUMENT);
}
