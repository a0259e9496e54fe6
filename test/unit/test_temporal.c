/*
 * The temporal filter matches the same filter in double precision while camera
 * and surfaces move; with a history of one frame it does nothing, and it takes
 * exactly the memory of its two buffers.
 */
#include "test/support/history.h"
#include "test/support/shim.h"
#include "test/support/vectors.h"

#define FRAMES 6

/* ------------------------------------------------------------------------ */
/* Off                                                                       */

/* With a history of one frame the whole filter runs, and a moving sequence has
 * the bits of a plan without it. */
static void a_history_of_one_frame_changes_nothing(void **state) {
  setup off, one;
  (void)state;
  averaging_init(&off, WIDTH, HEIGHT, 0);
  averaging_init(&one, WIDTH, HEIGHT, 1);
  setup_start(&off);
  setup_start(&one);
  for (int i = 0; i < 3; ++i) {
    averaging_load(&off, (uint32_t)i, (cl_uint)i);
    averaging_load(&one, (uint32_t)i, (cl_uint)i);
    setup_run(&off, hbil_enqueue_frame);
    setup_run(&one, hbil_enqueue_frame);
    exact_planes want = outputs_read(&off), got = outputs_read(&one);
    same_bits(&got, &want);
    exact_planes_free(&want);
    exact_planes_free(&got);
  }
  setup_free(&one);
  setup_free(&off);
}

/* Two buffers, each with an inverse depth, a normal, a number and seven planes
 * of light, and with two rows and two vectors (32) before and behind; rows are
 * padded to 64. */
static void the_filter_takes_two_buffers(void **state) {
  setup s;
  size_t off, on, made;
  hbil_buffer buffer;
  (void)state;
  averaging_init(&s, WIDTH, HEIGHT, 0);
  off = setup_memory(&s);
  setup_start(&s);
  assert_int_equal(
      hbil_plan_buffer(s.plan, HBIL_STAGE_TEMPORAL_HISTORY, &buffer),
      HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(s.device->hbil),
                         "TEMPORAL_HISTORY (history.max_frames"));
  setup_run(&s, enqueue_temporal); /* nothing to do, and no error */
  setup_free(&s);
  averaging_init(&s, WIDTH, HEIGHT, 8);
  shim_start_counting();
  on = setup_memory(&s);
  assert_success(&s, hbil_plan_create(s.device->hbil, &s.config, &s.plan));
  made = shim_created().bytes;
  assert_int_equal(on - off, 2 * 4 * (10 * 128 * HEIGHT + 2 * (2 * 128 + 32)));
  assert_int_equal(on, made);
  assert_success(
      &s, hbil_plan_buffer(s.plan, HBIL_STAGE_TEMPORAL_HISTORY, &buffer));
  assert_int_equal(buffer.values, 10);
  hbil_plan_destroy(s.plan);
  s.plan = NULL;
  setup_free(&s);
}

static void too_long_histories_are_rejected(void **state) {
  setup s;
  hbil_memory memory;
  (void)state;
  averaging_init(&s, WIDTH, HEIGHT, 1025);
  assert_int_equal(hbil_plan_memory(s.device->hbil, &s.config, &memory),
                   HBIL_INVALID_CONFIG);
  assert_non_null(strstr(hbil_context_message(s.device->hbil),
                         "history.max_frames: 1025 is outside 0 .. 1024"));
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Anything that moves, against the filter once more in double               */

/* Where a surface was, and what is expected there. */
typedef struct past {
  bool known;
  double u, v, z, n[3];
} past;

static double snapped(double v) {
  return floor(256.0 * v + 0.5) / 256.0;
}

/* m: world_from_view. */
static void to_camera(const double m[16], const double world[3],
                      double view[3]) {
  for (int r = 0; r < 3; ++r) {
    view[r] = 0.0;
    for (int c = 0; c < 3; ++c)
      view[r] += m[4 * c + r] * (world[c] - m[4 * c + 3]);
  }
}

static void ray_of(const hbil_camera *c, double x, double y, double r[3]) {
  r[0] = (x + 0.5 - c->cx) / c->fx;
  r[1] = (y + 0.5 - c->cy) / c->fy;
  r[2] = 1.0;
}

static bool is_orthographic(const setup *s) {
  return s->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
}

/* The point of a pixel with that w: inverse depth; orthographic, -z. */
static void point_of(const setup *s, const hbil_camera *c, double x, double y,
                     double w, double p[3]) {
  const double z = is_orthographic(s) ? -w : 1.0 / w;
  ray_of(c, x, y, p);
  p[0] *= is_orthographic(s) ? 1.0 : z;
  p[1] *= is_orthographic(s) ? 1.0 : z;
  p[2] = z;
}

static past find_past(const setup *s, const hbil_camera *before,
                      const exact_planes *split, int x, int y) {
  const hbil_camera *now = &s->frame.camera;
  const double *m = now->world_from_view;
  const double w = *exact_at(split, HBIL_SPLIT_W, x, y);
  double point[3], world[3], p[3], tip[3];
  past then = {.known = is_orthographic(s) ? w > -1e29 : w > 0.0};
  if (!then.known)
    return then;
  point_of(s, now, x, y, w, point);
  for (int i = 0; i < 3; ++i) {
    world[i] = tip[i] = m[4 * i + 3];
    for (int c = 0; c < 3; ++c) {
      world[i] += m[4 * i + c] * point[c];
      tip[i] += m[4 * i + c] *
                (point[c] + *exact_at(split, HBIL_SPLIT_NORMAL + c, x, y));
    }
  }
  to_camera(before->world_from_view, world, p);
  to_camera(before->world_from_view, tip, then.n);
  for (int c = 0; c < 3; ++c)
    then.n[c] -= p[c];
  then.z = p[2];
  if (s->config.history.reprojection == HBIL_REPROJECTION_MOTION) {
    then.u = x + s->input[EXACT_MOTION][y * WIDTH + x];
    then.v = y + s->input[EXACT_MOTION + 1][y * WIDTH + x];
  } else {
    const double spread = is_orthographic(s) ? 1.0 : p[2];
    then.u = before->fx * p[0] / spread + before->cx - 0.5;
    then.v = before->fy * p[1] / spread + before->cy - 0.5;
  }
  then.u = snapped(then.u);
  then.v = snapped(then.v);
  then.known = then.z > 0.0 && then.u > -1.0 && then.u < WIDTH &&
               then.v > -1.0 && then.v < HEIGHT;
  return then;
}

/* What the history holds for a pixel: the number of frames, and their light.
 * close: fp32 may decide differently here. */
typedef struct recalled {
  double frames, total, light[HBIL_LIGHT_PLANES];
  double least[HBIL_LIGHT_PLANES], most[HBIL_LIGHT_PLANES];
  bool close;
} recalled;

static void add_tap(const setup *s, const hbil_camera *before, const past *then,
                    const history *h, int x, int y, double weight,
                    recalled *out) {
  double at[3], here[3], n[3];
  if (x < 0 || y < 0 || x >= WIDTH || y >= HEIGHT || weight == 0.0)
    return;
  const double w = history_value(h, HISTORY_W, x, y);
  if (!(is_orthographic(s) || w > 0.0) ||
      !(history_value(h, HISTORY_FRAMES, x, y) > 0.0))
    return;
  ray_of(before, x, y, at);
  ray_of(before, then->u, then->v, here);
  history_normal(h, x, y, n);
  /* of the plane through the expected point */
  double expected = dot(then->n, at) / (dot(then->n, here) * then->z);
  double unit = expected;
  if (is_orthographic(s)) {
    expected = (dot(then->n, at) - dot(then->n, here)) / then->n[2] - then->z;
    unit = WIDTH / before->fx;
  }
  const double off = fabs(w - expected) -
                     s->config.history.disocclusion_threshold * fabs(unit);
  const double turn = 1.0 - dot(n, then->n) - HBIL_TURN_TOLERANCE;
  /* fp32 on planes seen edge on */
  out->close |= fabs(off) < 1e-3 * fabs(unit) || fabs(turn) < 1e-4;
  if (unit <= 0.0 || off > 0.0 || turn >= 0.0)
    return;
  out->frames += weight * history_value(h, HISTORY_FRAMES, x, y);
  for (int p = 0; p < HBIL_LIGHT_PLANES; ++p) {
    const double light = history_value(h, HISTORY_LIGHT + p, x, y);
    out->light[p] += weight * light;
    if (out->total == 0.0 || light < out->least[p])
      out->least[p] = light;
    if (out->total == 0.0 || light > out->most[p])
      out->most[p] = light;
  }
  out->total += weight;
}

static recalled recall(const setup *s, const hbil_camera *before,
                       const past *then, const history *h) {
  recalled out = {.frames = 0.0};
  if (!then->known)
    return out;
  const double left = floor(then->u), top = floor(then->v);
  const double a = then->u - left, b = then->v - top;
  for (int t = 0; t < 4; ++t)
    add_tap(s, before, then, h, (int)left + (t & 1), (int)top + (t >> 1),
            (t & 1 ? a : 1.0 - a) * (t >> 1 ? b : 1.0 - b), &out);
  for (int p = 0; p < HBIL_LIGHT_PLANES && out.total > 0.0; ++p)
    out.light[p] /= out.total;
  return out;
}

/* What a moving sequence had. */
typedef struct tally {
  int close, fresh, found;
} tally;

/* Outputs are the new history.  Only the bent normal is normalized, which costs
 * four roundings. */
static void check_shown(const exact_planes *got, const history *anew, int x,
                        int y) {
  double bent[3];
  for (int p = 0; p < HBIL_LIGHT_BENT; ++p)
    assert_true(*exact_at(got, p, x, y) ==
                history_value(anew, HISTORY_LIGHT + p, x, y));
  for (int c = 0; c < 3; ++c)
    bent[c] = history_value(anew, HISTORY_LIGHT + HBIL_LIGHT_BENT + c, x, y);
  if (dot(bent, bent) < 1e-12)
    return;
  normalize(bent);
  for (int c = 0; c < 3; ++c)
    assert_true(fabs(*exact_at(got, HBIL_LIGHT_BENT + c, x, y) - bent[c]) <
                3e-7);
}

/* fresh: RESOLVED before the filter, got: after it; anew: the new history. */
static void check_pixel(const setup *s, const recalled *r,
                        const exact_planes *fresh, const exact_planes *got,
                        const history *anew, int x, int y, tally *t) {
  const double most = s->config.history.max_frames;
  const double n = fmin(r->frames + 1.0, most);
  if (r->close) {
    t->close++;
    return;
  }
  if (r->total == 0.0) {
    for (int p = 0; p < HBIL_LIGHT_PLANES; ++p)
      if (*exact_at(got, p, x, y) != *exact_at(fresh, p, x, y))
        fail_msg("(%d, %d): a new surface has plane %d of another", x, y, p);
    t->fresh++;
    return;
  }
  t->found++;
  check_shown(got, anew, x, y);
  /* A position may be snapped to the neighbouring 1/256 of a pixel, in x and
   * in y; sums of four are in fp32. */
  const double places = 2.0 / 256.0;
  const double frames = history_value(anew, HISTORY_FRAMES, x, y);
  if (fabs(frames - n) > places * most + 1e-5 * n)
    fail_msg("(%d, %d): %g frames instead of %g", x, y, frames, n);
  for (int p = 0; p < HBIL_LIGHT_PLANES; ++p) {
    const double f = *exact_at(fresh, p, x, y);
    const double want = r->light[p] + (f - r->light[p]) / n;
    const double off =
        fabs(history_value(anew, HISTORY_LIGHT + p, x, y) - want);
    const double range = r->most[p] - r->least[p] + fabs(f - r->light[p]) / n;
    if (off > places * range * fmax(1.0, 1.0 / r->total) + 1e-5)
      fail_msg("(%d, %d): plane %d is off by %g, a range of %g", x, y, p, off,
               range);
  }
}

/* Some pixels lose their history: their number of frames becomes 0, whatever
 * light they have. */
static void forget_some(setup *s, history *h) {
  const float none = 0.0f, light = 100.0f;
  size_t size;
  free(buffer_bytes(s->device, h->at.buffer, &size));
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = y % 7; x < WIDTH; x += 7) {
      memcpy(h->bytes + history_offset(h, HISTORY_FRAMES, x, y), &none,
             sizeof none);
      memcpy(h->bytes + history_offset(h, HISTORY_LIGHT, x, y), &light,
             sizeof light);
    }
  assert_int_equal(clEnqueueWriteBuffer(s->device->queue, h->at.buffer, CL_TRUE,
                                        0, size, h->bytes, 0, NULL, NULL),
                   CL_SUCCESS);
}

/* A frame, pass by pass.  before: camera of the last one; NULL: the first. */
static void check_frame(setup *s, const hbil_camera *before, tally *t) {
  history old = {.bytes = NULL}, anew;
  if (before) {
    old = history_read(s);
    forget_some(s, &old);
  }
  for (size_t i = 0; i < PASSES_BEFORE_FILTER; ++i)
    setup_run(s, passes_before_filter[i]);
  exact_planes split = stage_read(s, HBIL_STAGE_SPLIT);
  exact_planes fresh = stage_read(s, HBIL_STAGE_RESOLVED);
  setup_run(s, enqueue_temporal);
  exact_planes got = stage_read(s, HBIL_STAGE_RESOLVED);
  setup_run(s, enqueue_composite);
  anew = history_read(s);
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      recalled r = {.frames = 0.0};
      if (before) {
        const past then = find_past(s, before, &split, x, y);
        r = recall(s, before, &then, &old);
      }
      check_pixel(s, &r, &fresh, &got, &anew, x, y, t);
    }
  free(old.bytes);
  free(anew.bytes);
  exact_planes_free(&split);
  exact_planes_free(&fresh);
  exact_planes_free(&got);
}

/* The camera moves, and a ball. */
static void check_moving(hbil_reprojection reprojection,
                         hbil_projection projection, cl_uint width) {
  hbil_camera before;
  tally t = {0, 0, 0};
  setup s;
  averaging_init(&s, WIDTH, HEIGHT, MOST);
  s.config.history.reprojection = reprojection;
  s.config.inputs.projection = projection;
  s.config.inputs.motion.component =
      reprojection == HBIL_REPROJECTION_MOTION ? HBIL_FLOAT32 : HBIL_NONE;
  s.config.execution.vector_width = width;
  setup_start(&s);
  for (int i = 0; i < FRAMES; ++i) {
    averaging_load(&s, (uint32_t)i, (cl_uint)i);
    check_frame(&s, i ? &before : NULL, &t);
    before = s.frame.camera;
  }
  /* measured: 0.12 % close */
  check_at_most("share of close decisions", (double)t.close / (PIXELS * FRAMES),
                0.01);
  assert_true(t.fresh > PIXELS && t.found > 4 * PIXELS);
  setup_free(&s);
}

static void a_moving_camera_is_followed(void **state) {
  (void)state;
  check_moving(HBIL_REPROJECTION_NONE, HBIL_PROJECTION_PERSPECTIVE, 0);
}

static void single_pixels_follow_a_moving_camera(void **state) {
  (void)state;
  check_moving(HBIL_REPROJECTION_NONE, HBIL_PROJECTION_PERSPECTIVE, 1);
}

static void motion_vectors_are_followed(void **state) {
  (void)state;
  check_moving(HBIL_REPROJECTION_MOTION, HBIL_PROJECTION_PERSPECTIVE, 0);
}

static void an_orthographic_camera_is_followed(void **state) {
  (void)state;
  check_moving(HBIL_REPROJECTION_NONE, HBIL_PROJECTION_ORTHOGRAPHIC, 0);
}

/* Without carried light, the filter is the only reader of motion vectors. */
static void invalid_motion_is_counted_once(void **state) {
  hbil_sanitized repaired;
  setup s;
  (void)state;
  averaging_init(&s, WIDTH, HEIGHT, 8);
  s.config.model.mode = HBIL_MODE_GTAO;
  s.config.outputs.near_irradiance.component = HBIL_NONE;
  s.config.history.reprojection = HBIL_REPROJECTION_MOTION;
  s.config.inputs.motion = one_float;
  setup_start(&s);
  s.input[EXACT_MOTION][20 * WIDTH + 30] = NAN;
  s.input[EXACT_MOTION + 1][20 * WIDTH + 40] = INFINITY;
  setup_upload(&s);
  for (int i = 0; i < 3; ++i) {
    setup_run(&s, hbil_enqueue_frame);
    assert_success(&s, hbil_plan_sanitized(s.plan, s.device->queue, &repaired));
    assert_int_equal(repaired.motion, i ? 2 : 0);
  }
  setup_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_history_of_one_frame_changes_nothing),
      cmocka_unit_test(the_filter_takes_two_buffers),
      cmocka_unit_test(too_long_histories_are_rejected),
      cmocka_unit_test(a_moving_camera_is_followed),
      cmocka_unit_test(single_pixels_follow_a_moving_camera),
      cmocka_unit_test(motion_vectors_are_followed),
      cmocka_unit_test(an_orthographic_camera_is_followed),
      cmocka_unit_test(invalid_motion_is_counted_once)};
  return RUN_WITH_DEVICE(tests);
}
