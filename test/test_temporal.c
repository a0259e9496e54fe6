/*
 * The filter over frames: a mean of what each surface was given, no ghosts, and
 * nothing of it where it is not asked for.
 */
#include "shim.h"

#include <math.h>
#include <stdio.h>

/* Rows without padding: what lies left of one is the end of another. */
#define WIDTH 128
#define HEIGHT 54
#define PIXELS (WIDTH * HEIGHT)
#define FRAMES 6

/* AO, E_near and bent normals of the room, as cheap as can be: recompose's
 * filter takes longest to compile.  Light is not carried over, so a frame is
 * what it is without those before it. */
static void init(setup *s, int width, int height, cl_uint temporal) {
  setup_scene(s, SCENE_ROOM, width, height, 0);
  s->config.reprojection = HBIL_REPROJECTION_NONE;
  s->config.slices = 1;
  s->config.steps_per_side = 6;
  s->config.unfiltered = CL_TRUE;
  s->config.motion.component = HBIL_NONE;
  s->config.max_history_frames = temporal;
}

static void load(setup *s, uint32_t scene, cl_uint index) {
  setup_load_scene(s, SCENE_ROOM, scene);
  s->frame.frame_index = index;
  setup_upload(s);
}

static void same_bits(const exact_planes *got, const exact_planes *want) {
  assert_int_equal(count_different(got, want), 0);
}

static size_t size_of(const exact_planes *p) {
  return (size_t)p->width * (size_t)p->height * (size_t)p->count;
}

/* ------------------------------------------------------------------------ */
/* Off                                                                       */

/* A frame that counts alone goes through all of the filter: with the cap at 1
 * even a moving sequence has the bits of a plan without it. */
static void of_one_frame_is_off(void **state) {
  setup off, one;
  (void)state;
  init(&off, WIDTH, HEIGHT, 0);
  init(&one, WIDTH, HEIGHT, 1);
  setup_start(&off);
  setup_start(&one);
  for (int i = 0; i < 3; ++i) {
    load(&off, (uint32_t)i, (cl_uint)i);
    load(&one, (uint32_t)i, (cl_uint)i);
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

/* Two buffers, each with a place, a normal, a number and the seven planes of
 * light, two rows and two vectors (32) before and behind; rows are padded
 * to 64. */
static void memory_is_two_frames_more(void **state) {
  setup s;
  size_t off, on, made;
  hbil_buffer buffer;
  (void)state;
  init(&s, WIDTH, HEIGHT, 0);
  assert_success(&s, hbil_plan_memory(s.gpu->hbil, &s.config, &off));
  setup_start(&s);
  assert_int_equal(
      hbil_plan_buffer(s.plan, HBIL_STAGE_TEMPORAL_HISTORY, &buffer),
      HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(s.gpu->hbil), "temporal"));
  setup_run(&s, hbil_enqueue_temporal); /* nothing to do, and no error */
  setup_free(&s);
  init(&s, WIDTH, HEIGHT, 8);
  shim_start_counting();
  assert_success(&s, hbil_plan_memory(s.gpu->hbil, &s.config, &on));
  assert_success(&s, hbil_plan_create(s.gpu->hbil, &s.config, &s.plan));
  made = shim_made().bytes;
  assert_int_equal(on - off, 2 * 4 * (10 * 128 * HEIGHT + 2 * (2 * 128 + 32)));
  assert_int_equal(on, made);
  assert_success(
      &s, hbil_plan_buffer(s.plan, HBIL_STAGE_TEMPORAL_HISTORY, &buffer));
  assert_int_equal(buffer.values, 10);
  hbil_plan_destroy(s.plan);
  s.plan = NULL;
  setup_free(&s);
}

static void a_range_is_refused(void **state) {
  setup s;
  size_t bytes;
  (void)state;
  init(&s, WIDTH, HEIGHT, 1025);
  assert_int_equal(hbil_plan_memory(s.gpu->hbil, &s.config, &bytes),
                   HBIL_INVALID_CONFIG);
  assert_non_null(strstr(hbil_context_message(s.gpu->hbil),
                         "temporal: 1025 is outside 0 .. 1024"));
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* A camera that stands still                                                */

/* What single frames give, whose patterns are turned by their index. */
static void singles(exact_planes *out, int count) {
  setup s;
  init(&s, WIDTH, HEIGHT, 0);
  setup_start(&s);
  for (int i = 0; i < count; ++i) {
    s.frame.frame_index = (cl_uint)i;
    setup_run(&s, hbil_enqueue_frame);
    out[i] = outputs_read(&s);
  }
  setup_free(&s);
}

/* Each frame has a share: 1/n, and 1/most from frame `most` on. */
static void add_frame(exact_planes *mean, const exact_planes *frame, int n) {
  for (size_t i = 0; i < size_of(mean); ++i)
    mean->values[i] += (frame->values[i] - mean->values[i]) / n;
}

/* Of AO and E_near; a mean of bent normals is not of unit length.  Limit: three
 * roundings of fp32 a frame. */
static void check_mean(const exact_planes *got, const exact_planes *want) {
  check_at_most("E_near", relative_rmse(got, want, EXACT_NEAR_IRRADIANCE, 3),
                1e-6);
  check_at_most("AO", relative_rmse(got, want, EXACT_AO, 1), 1e-6);
}

#define MOST 4

static void still_frames_are_averaged(void **state) {
  exact_planes single[FRAMES], mean = checked_planes(WIDTH, HEIGHT, 17);
  setup said, unsaid;
  (void)state;
  singles(single, FRAMES);
  init(&said, WIDTH, HEIGHT, MOST);
  init(&unsaid, WIDTH, HEIGHT, MOST);
  setup_start(&said);
  setup_start(&unsaid);
  for (int i = 0; i < FRAMES; ++i) {
    said.frame.frame_index = unsaid.frame.frame_index = (cl_uint)i;
    said.frame.static_frame = CL_TRUE; /* of no account in the first */
    setup_run(&said, hbil_enqueue_frame);
    setup_run(&unsaid, hbil_enqueue_frame);
    exact_planes got = outputs_read(&said), other = outputs_read(&unsaid);
    add_frame(&mean, &single[i], i < MOST ? i + 1 : MOST);
    check_mean(&got, &mean);
    same_bits(&other, &got);
    exact_planes_free(&got);
    exact_planes_free(&other);
    exact_planes_free(&single[i]);
  }
  exact_planes_free(&mean);
  setup_free(&unsaid);
  setup_free(&said);
}

static double squared_error(const exact_planes *got, const exact_planes *want) {
  const double e = relative_rmse(got, want, EXACT_AO, 1);
  return e * e;
}

/*
 * Of AO with 1 x 32, of single pixels.  What is left when everything is
 * averaged (64 frames here) is bias: finite samples, a ratio of sums.  What is
 * above that is noise of the pattern; of independent patterns the mean of N
 * would have 1/N of it.  Turned by a sequence of low discrepancy, a mean is no
 * worse than that.  Measured: 0.23, 0.085, 0.015 and 0.004 for 2, 4, 8 and 16.
 */
static void noise_falls_with_the_frames(void **state) {
  const exact_dense how = {.slices = 256};
  exact_state exact;
  double error[65], noise;
  setup s;
  (void)state;
  init(&s, WIDTH, HEIGHT, 64);
  s.config.steps_per_side = 32;
  setup_start(&s);
  checked_state(&exact, WIDTH, HEIGHT);
  checked_run_frame_dense(&exact, &s.job, &how);
  for (int n = 1; n <= 64; ++n) {
    s.frame.frame_index = (cl_uint)n;
    setup_run(&s, hbil_enqueue_frame);
    exact_planes got = outputs_read(&s);
    error[n] = squared_error(&got, &exact.out);
    exact_planes_free(&got);
  }
  noise = error[1] - error[64];
  for (int n = 2; n <= 16; n *= 2) {
    char what[32];
    snprintf(what, sizeof what, "noise of %d frames", n);
    check_at_most(what, (error[n] - error[64]) / noise, 1.0 / n);
  }
  exact_state_free(&exact);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Anything that moves, against the filter once more in double               */

enum { KEPT_W, KEPT_NORMAL, KEPT_FRAMES, KEPT_LIGHT };

/* The plan's kept planes, as words. */
typedef struct kept {
  hbil_buffer at;
  unsigned char *bytes;
} kept;

static kept kept_read(setup *s) {
  kept k = {.bytes = NULL};
  size_t size;
  assert_success(s,
                 hbil_plan_buffer(s->plan, HBIL_STAGE_TEMPORAL_HISTORY, &k.at));
  k.bytes = buffer_bytes(s, k.at.buffer, &size);
  return k;
}

static size_t kept_place(const kept *k, int p, int x, int y) {
  return 4 * (k->at.origin + (size_t)p * k->at.plane_pitch +
              (size_t)y * k->at.row_pitch + (size_t)x);
}

static double kept_value(const kept *k, int p, int x, int y) {
  float value;
  memcpy(&value, k->bytes + kept_place(k, p, x, y), sizeof value);
  return (double)value;
}

static void kept_normal(const kept *k, int x, int y, double n[3]) {
  uint32_t word;
  memcpy(&word, k->bytes + kept_place(k, KEPT_NORMAL, x, y), sizeof word);
  decode_normal(word, n);
}

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
  return s->config.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
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
  if (s->config.reprojection == HBIL_REPROJECTION_MOTION) {
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

/* A pixel of the mean: how many frames, and the light before it is blended.
 * close: a decision that fp32 may take otherwise. */
typedef struct recalled {
  double frames, total, light[HBIL_LIGHT_PLANES];
  double least[HBIL_LIGHT_PLANES], most[HBIL_LIGHT_PLANES];
  bool close;
} recalled;

static void add_tap(const setup *s, const hbil_camera *before, const past *then,
                    const kept *k, int x, int y, double weight, recalled *out) {
  double at[3], here[3], n[3];
  if (x < 0 || y < 0 || x >= WIDTH || y >= HEIGHT || weight == 0.0)
    return;
  const double w = kept_value(k, KEPT_W, x, y);
  if (!(is_orthographic(s) || w > 0.0) ||
      !(kept_value(k, KEPT_FRAMES, x, y) > 0.0))
    return;
  ray_of(before, x, y, at);
  ray_of(before, then->u, then->v, here);
  kept_normal(k, x, y, n);
  /* of the plane through the expected point */
  double expected = dot(then->n, at) / (dot(then->n, here) * then->z);
  double unit = expected;
  if (is_orthographic(s)) {
    expected = (dot(then->n, at) - dot(then->n, here)) / then->n[2] - then->z;
    unit = WIDTH / before->fx;
  }
  const double off =
      fabs(w - expected) - s->config.disocclusion_threshold * fabs(unit);
  const double turn = 1.0 - dot(n, then->n) - HBIL_TURN_TOLERANCE;
  /* fp32 on planes seen edge on */
  out->close |= fabs(off) < 1e-3 * fabs(unit) || fabs(turn) < 1e-4;
  if (unit <= 0.0 || off > 0.0 || turn >= 0.0)
    return;
  out->frames += weight * kept_value(k, KEPT_FRAMES, x, y);
  for (int p = 0; p < HBIL_LIGHT_PLANES; ++p) {
    const double light = kept_value(k, KEPT_LIGHT + p, x, y);
    out->light[p] += weight * light;
    if (out->total == 0.0 || light < out->least[p])
      out->least[p] = light;
    if (out->total == 0.0 || light > out->most[p])
      out->most[p] = light;
  }
  out->total += weight;
}

static recalled recall(const setup *s, const hbil_camera *before,
                       const past *then, const kept *k) {
  recalled out = {.frames = 0.0};
  if (!then->known)
    return out;
  const double left = floor(then->u), top = floor(then->v);
  const double a = then->u - left, b = then->v - top;
  for (int t = 0; t < 4; ++t)
    add_tap(s, before, then, k, (int)left + (t & 1), (int)top + (t >> 1),
            (t & 1 ? a : 1.0 - a) * (t >> 1 ? b : 1.0 - b), &out);
  for (int p = 0; p < HBIL_LIGHT_PLANES && out.total > 0.0; ++p)
    out.light[p] /= out.total;
  return out;
}

/* What a moving sequence had. */
typedef struct tally {
  int close, fresh, found;
} tally;

/* What is shown is what is kept, but for the bent normal's length; that is off
 * by four roundings. */
static void check_shown(const exact_planes *got, const kept *anew, int x,
                        int y) {
  double bent[3];
  for (int p = 0; p < HBIL_LIGHT_BENT; ++p)
    assert_true(*exact_at(got, p, x, y) ==
                kept_value(anew, KEPT_LIGHT + p, x, y));
  for (int c = 0; c < 3; ++c)
    bent[c] = kept_value(anew, KEPT_LIGHT + HBIL_LIGHT_BENT + c, x, y);
  if (dot(bent, bent) < 1e-12)
    return;
  normalize(bent);
  for (int c = 0; c < 3; ++c)
    assert_true(fabs(*exact_at(got, HBIL_LIGHT_BENT + c, x, y) - bent[c]) <
                3e-7);
}

/* fresh: RESOLVED before the filter, got: after it; anew: kept by it. */
static void check_pixel(const setup *s, const recalled *r,
                        const exact_planes *fresh, const exact_planes *got,
                        const kept *anew, int x, int y, tally *t) {
  const double most = s->config.max_history_frames;
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
  /* A place may be snapped to the next 1/256 of a pixel, in x and in y; sums of
   * four in fp32. */
  const double places = 2.0 / 256.0;
  const double frames = kept_value(anew, KEPT_FRAMES, x, y);
  if (fabs(frames - n) > places * most + 1e-5 * n)
    fail_msg("(%d, %d): %g frames instead of %g", x, y, frames, n);
  for (int p = 0; p < HBIL_LIGHT_PLANES; ++p) {
    const double f = *exact_at(fresh, p, x, y);
    const double want = r->light[p] + (f - r->light[p]) / n;
    const double off = fabs(kept_value(anew, KEPT_LIGHT + p, x, y) - want);
    const double range = r->most[p] - r->least[p] + fabs(f - r->light[p]) / n;
    if (off > places * range * fmax(1.0, 1.0 / r->total) + 1e-5)
      fail_msg("(%d, %d): plane %d is off by %g, a range of %g", x, y, p, off,
               range);
  }
}

static enqueue_function *const until_recompose[] = {
    hbil_enqueue_reproject, hbil_enqueue_push_pull, hbil_enqueue_split,
    hbil_enqueue_gather, hbil_enqueue_recompose};

/* Of some pixels nothing is known, whatever light stands there. */
static void forget_some(setup *s, kept *k) {
  const float none = 0.0f, light = 100.0f;
  size_t size;
  free(buffer_bytes(s, k->at.buffer, &size));
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = y % 7; x < WIDTH; x += 7) {
      memcpy(k->bytes + kept_place(k, KEPT_FRAMES, x, y), &none, sizeof none);
      memcpy(k->bytes + kept_place(k, KEPT_LIGHT, x, y), &light, sizeof light);
    }
  assert_int_equal(clEnqueueWriteBuffer(s->gpu->queue, k->at.buffer, CL_TRUE, 0,
                                        size, k->bytes, 0, NULL, NULL),
                   CL_SUCCESS);
}

/* A frame, pass by pass.  before: camera of the last one; NULL: the first. */
static void check_frame(setup *s, const hbil_camera *before, tally *t) {
  kept old = {.bytes = NULL}, anew;
  if (before) {
    old = kept_read(s);
    forget_some(s, &old);
  }
  for (size_t i = 0; i < sizeof until_recompose / sizeof *until_recompose; ++i)
    setup_run(s, until_recompose[i]);
  exact_planes split = stage_read(s, HBIL_STAGE_SPLIT);
  exact_planes fresh = stage_read(s, HBIL_STAGE_RESOLVED);
  setup_run(s, hbil_enqueue_temporal);
  exact_planes got = stage_read(s, HBIL_STAGE_RESOLVED);
  setup_run(s, hbil_enqueue_composite);
  anew = kept_read(s);
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
  init(&s, WIDTH, HEIGHT, MOST);
  s.config.reprojection = reprojection;
  s.config.projection = projection;
  s.config.motion.component =
      reprojection == HBIL_REPROJECTION_MOTION ? HBIL_FLOAT32 : HBIL_NONE;
  s.config.vector_width = width;
  setup_start(&s);
  for (int i = 0; i < FRAMES; ++i) {
    load(&s, (uint32_t)i, (cl_uint)i);
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

static void pixel_by_pixel_as_well(void **state) {
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

/* ------------------------------------------------------------------------ */
/* Surfaces that were not there                                              */

/* A wall at depth 4, with a patch from column `left` on. */
static void set_wall(setup *s, int left, float depth, float tilt) {
  setup_camera(s, 60.0);
  s->config.normal_space = HBIL_SPACE_VIEW;
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      const int i = y * WIDTH + x;
      const bool patch = x >= left && x < left + 20 && y >= 10 && y < 40;
      s->input[EXACT_DEPTH][i] = patch ? depth : 4.0f;
      s->input[EXACT_NORMAL][i] = patch ? tilt : 0.0f;
      s->input[EXACT_NORMAL + 1][i] = 0.0f;
      s->input[EXACT_NORMAL + 2][i] = -1.0f;
      for (int c = 0; c < 3; ++c)
        s->input[EXACT_DIRECT + c][i] = (float)(1 + c + x % 7);
    }
  setup_upload(s);
}

/* Pixels that are in the patch now or were before. */
static bool in_patch(int left, int x, int y) {
  return x >= left && x < left + 20 && y >= 10 && y < 40;
}

/* Runs the frame that is set, and one that was not preceded by another; where
 * `changed` they have the same bits, elsewhere two frames are counted. */
static void check_anew(setup *s, setup *alone, bool (*changed)(int x, int y)) {
  s->frame.frame_index = alone->frame.frame_index = 1;
  hbil_plan_reset(alone->plan);
  setup_run(s, hbil_enqueue_frame);
  setup_run(alone, hbil_enqueue_frame);
  exact_planes got = outputs_read(s), want = outputs_read(alone);
  kept k = kept_read(s);
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      const bool anew = changed(x, y);
      assert_true(kept_value(&k, KEPT_FRAMES, x, y) == (anew ? 1.0 : 2.0));
      for (int p = 0; p < EXACT_OUTPUT_PLANES && anew; ++p)
        assert_true(*exact_at(&got, p, x, y) == *exact_at(&want, p, x, y));
    }
  free(k.bytes);
  exact_planes_free(&got);
  exact_planes_free(&want);
}

static bool moved_patch(int x, int y) {
  return in_patch(20, x, y) != in_patch(28, x, y);
}

static bool first_patch(int x, int y) {
  return in_patch(20, x, y);
}

static void what_was_not_there_begins_anew(void **state) {
  setup s, alone;
  (void)state;
  init(&s, WIDTH, HEIGHT, 8);
  init(&alone, WIDTH, HEIGHT, 8);
  s.config.normal_space = alone.config.normal_space = HBIL_SPACE_VIEW;
  setup_start(&s);
  setup_start(&alone);
  /* from, and to: left column, depth, tilt */
  static const struct {
    int left[2];
    float depth[2], tilt[2];
    bool (*changed)(int x, int y);
  } cases[] = {
      /* moves aside; what it uncovers is new, too */
      {{20, 28}, {2.0f, 2.0f}, {0.0f, 0.0f}, moved_patch},
      /* a step of 6 %, where 5 % are allowed, forth and back */
      {{20, 20}, {4.0f, 3.76f}, {0.0f, 0.0f}, first_patch},
      {{20, 20}, {3.76f, 4.0f}, {0.0f, 0.0f}, first_patch},
      /* turns by 40 degrees, where 33 are allowed */
      {{20, 20}, {2.0f, 2.0f}, {0.0f, 0.8391f}, first_patch},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    hbil_plan_reset(s.plan);
    s.frame.frame_index = 0;
    set_wall(&s, cases[i].left[0], cases[i].depth[0], cases[i].tilt[0]);
    setup_run(&s, hbil_enqueue_frame);
    set_wall(&s, cases[i].left[1], cases[i].depth[1], cases[i].tilt[1]);
    set_wall(&alone, cases[i].left[1], cases[i].depth[1], cases[i].tilt[1]);
    check_anew(&s, &alone, cases[i].changed);
  }
  setup_free(&alone);
  setup_free(&s);
}

/* A wall that fills the picture, seen from half a pixel aside: at one border,
 * a row or a column, half of what is looked for lies outside. */
static void borders_are_no_neighbours(void **state) {
  static const int moves[][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  setup s;
  (void)state;
  init(&s, WIDTH, HEIGHT, 8);
  s.config.normal_space = HBIL_SPACE_VIEW;
  setup_start(&s);
  for (size_t i = 0; i < sizeof moves / sizeof *moves; ++i) {
    const int dx = moves[i][0], dy = moves[i][1];
    hbil_plan_reset(s.plan);
    set_wall(&s, 0, 4.0f, 0.0f);
    setup_run(&s, hbil_enqueue_frame);
    s.frame.camera.world_from_view[3] = dx * 0.5 * 4.0 / s.frame.camera.fx;
    s.frame.camera.world_from_view[7] = dy * 0.5 * 4.0 / s.frame.camera.fy;
    setup_run(&s, hbil_enqueue_frame);
    kept k = kept_read(&s);
    for (int y = 0; y < HEIGHT; ++y)
      for (int x = 0; x < WIDTH; ++x) {
        const int to_x = x + dx, to_y = y + dy;
        const bool inside =
            to_x >= 0 && to_x < WIDTH && to_y >= 0 && to_y < HEIGHT;
        assert_true(kept_value(&k, KEPT_FRAMES, x, y) == (inside ? 2.0 : 1.5));
      }
    free(k.bytes);
  }
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* No numbers                                                                */

/* One in a kept plane begins its pixel anew, and no other; the place of the
 * normal holds any word. */
static void what_is_no_number_is_dropped(void **state) {
  static const float bad[] = {NAN, INFINITY, -INFINITY};
  setup s;
  (void)state;
  init(&s, WIDTH, HEIGHT, 8);
  setup_start(&s);
  for (size_t b = 0; b < 3; ++b)
    for (int p = 0; p < 10; ++p) {
      if (p == KEPT_NORMAL || (p == KEPT_FRAMES && b == 1))
        continue;
      hbil_plan_reset(s.plan);
      setup_run(&s, hbil_enqueue_frame);
      kept k = kept_read(&s);
      memcpy(k.bytes + kept_place(&k, p, 30, 20), &bad[b], sizeof(float));
      assert_int_equal(clEnqueueWriteBuffer(s.gpu->queue, k.at.buffer, CL_TRUE,
                                            kept_place(&k, p, 30, 20),
                                            sizeof(float), &bad[b], 0, NULL,
                                            NULL),
                       CL_SUCCESS);
      free(k.bytes);
      setup_run(&s, hbil_enqueue_frame);
      k = kept_read(&s);
      for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
          const bool solid = s.input[EXACT_DEPTH][y * WIDTH + x] > 0.0f;
          const double n = kept_value(&k, KEPT_FRAMES, x, y);
          assert_true(n == (!solid ? 0.0 : x == 30 && y == 20 ? 1.0 : 2.0));
          for (int q = KEPT_LIGHT; q < 10; ++q)
            assert_true(isfinite(kept_value(&k, q, x, y)));
        }
      free(k.bytes);
    }
  setup_free(&s);
}

/* What a frame shows that is no number is shown in that frame alone. */
static void no_number_of_a_frame_is_kept(void **state) {
  setup s;
  (void)state;
  init(&s, WIDTH, HEIGHT, 8);
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  for (size_t i = 0; i < sizeof until_recompose / sizeof *until_recompose; ++i)
    setup_run(&s, until_recompose[i]);
  exact_planes fresh = stage_read(&s, HBIL_STAGE_RESOLVED);
  *exact_at(&fresh, HBIL_LIGHT_RED, 30, 20) = NAN;
  stage_write(&s, HBIL_STAGE_RESOLVED, &fresh);
  exact_planes_free(&fresh);
  setup_run(&s, hbil_enqueue_temporal);
  setup_run(&s, hbil_enqueue_composite);
  kept k = kept_read(&s);
  assert_true(kept_value(&k, KEPT_FRAMES, 30, 20) == 0.0);
  free(k.bytes);
  exact_planes got = outputs_read(&s);
  assert_true(isnan(*exact_at(&got, EXACT_NEAR_IRRADIANCE, 30, 20)));
  exact_planes_free(&got);
  setup_run(&s, hbil_enqueue_frame);
  got = outputs_read(&s);
  for (size_t i = 0; i < size_of(&got); ++i)
    assert_true(isfinite(got.values[i]));
  exact_planes_free(&got);
  k = kept_read(&s);
  assert_true(kept_value(&k, KEPT_FRAMES, 30, 20) == 1.0);
  assert_true(kept_value(&k, KEPT_FRAMES, 31, 20) == 3.0);
  free(k.bytes);
  setup_free(&s);
}

/* Where no light is carried over nobody else looks at motion vectors. */
static void motion_is_counted_once(void **state) {
  hbil_sanitized repaired;
  setup s;
  (void)state;
  init(&s, WIDTH, HEIGHT, 8);
  s.config.mode = HBIL_MODE_GTAO;
  s.config.near_irradiance.component = HBIL_NONE;
  s.config.reprojection = HBIL_REPROJECTION_MOTION;
  s.config.motion = (hbil_plane_format){HBIL_FLOAT32, 1};
  setup_start(&s);
  s.input[EXACT_MOTION][20 * WIDTH + 30] = NAN;
  s.input[EXACT_MOTION + 1][20 * WIDTH + 40] = INFINITY;
  setup_upload(&s);
  for (int i = 0; i < 3; ++i) {
    setup_run(&s, hbil_enqueue_frame);
    assert_success(&s, hbil_plan_sanitized(s.plan, s.gpu->queue, &repaired));
    assert_int_equal(repaired.motion, i ? 2 : 0);
  }
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* The same bits                                                             */

static void run_moving(setup *s, int from, int to) {
  for (int i = from; i < to; ++i) {
    load(s, (uint32_t)i, (cl_uint)i);
    setup_run(s, hbil_enqueue_frame);
  }
}

/* Again; in other work-groups; in buffers full of not-a-numbers, whose guards
 * nobody touches; after a frame that was broken off. */
static void runs_have_the_same_bits(void **state) {
  static const size_t groups[2] = {5, 3};
  setup s, guarded;
  (void)state;
  init(&s, WIDTH, HEIGHT, MOST);
  setup_start(&s);
  run_moving(&s, 0, 4);
  exact_planes want = outputs_read(&s), got;
  for (int way = 0; way < 3; ++way) {
    hbil_plan_reset(s.plan);
    shim_use_groups(way == 1 ? groups : NULL);
    run_moving(&s, 0, 3);
    if (way == 2) {
      load(&s, 11, 7);
      for (size_t i = 0; i < 5; ++i)
        setup_run(&s, until_recompose[i]);
      setup_run(&s, hbil_enqueue_temporal);
    }
    run_moving(&s, 3, 4);
    got = outputs_read(&s);
    same_bits(&got, &want);
    exact_planes_free(&got);
  }
  shim_use_groups(NULL);
  init(&guarded, WIDTH, HEIGHT, MOST);
  shim_guard_buffers(true);
  setup_start(&guarded);
  shim_guard_buffers(false);
  run_moving(&guarded, 0, 4);
  got = outputs_read(&guarded);
  same_bits(&got, &want);
  assert_int_equal(shim_trespasses(guarded.gpu->queue), 0);
  exact_planes_free(&got);
  exact_planes_free(&want);
  setup_free(&guarded);
  setup_free(&s);
}

static void small_images_stay_inside(void **state) {
  static const int sizes[][2] = {{1, 1}, {3, 5}, {67, 35}};
  (void)state;
  for (size_t i = 0; i < 3; ++i) {
    setup s;
    init(&s, sizes[i][0], sizes[i][1], MOST);
    shim_guard_buffers(true);
    setup_start(&s);
    shim_guard_buffers(false);
    run_moving(&s, 0, 3);
    exact_planes got = outputs_read(&s);
    for (size_t v = 0; v < size_of(&got); ++v)
      assert_true(isfinite(got.values[v]));
    assert_int_equal(shim_trespasses(s.gpu->queue), 0);
    exact_planes_free(&got);
    setup_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(of_one_frame_is_off),
      cmocka_unit_test(memory_is_two_frames_more),
      cmocka_unit_test(a_range_is_refused),
      cmocka_unit_test(still_frames_are_averaged),
      cmocka_unit_test(noise_falls_with_the_frames),
      cmocka_unit_test(a_moving_camera_is_followed),
      cmocka_unit_test(pixel_by_pixel_as_well),
      cmocka_unit_test(motion_vectors_are_followed),
      cmocka_unit_test(an_orthographic_camera_is_followed),
      cmocka_unit_test(what_was_not_there_begins_anew),
      cmocka_unit_test(borders_are_no_neighbours),
      cmocka_unit_test(what_is_no_number_is_dropped),
      cmocka_unit_test(no_number_of_a_frame_is_kept),
      cmocka_unit_test(motion_is_counted_once),
      cmocka_unit_test(runs_have_the_same_bits),
      cmocka_unit_test(small_images_stay_inside)};
  return RUN_WITH_GPU(tests);
}
