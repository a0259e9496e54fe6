/*
 * Frames that share slices: at rest their light is that of all slices, and with
 * a moving camera each pixel has what this frame's slices found and what the
 * last frames' found where the surface was, in double precision.
 */
#include "test/support/lit_frame.h"
#include "test/support/packing.h"
#include "test/support/stages.h"
#include "test/support/vectors.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "exact/camera.h"
#include "exact/input.h"

#define WIDTH 128
#define HEIGHT 54
#define FRAMES 6

/* AO, E_near and bent normals of the room, without history of light, so that
 * nothing but slices is handed on. */
static void start(setup *s, cl_uint frames, cl_uint slices) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
  s->config.sampling.slices = slices;
  s->config.sampling.steps_per_side = 6;
  s->config.sampling.unfiltered = CL_TRUE;
  s->config.inputs.motion.component = HBIL_NONE;
  s->config.sampling.slice_frames = frames;
}

static void load(setup *s, uint32_t scene) {
  setup_load_scene(s, SCENE_ROOM, scene);
  setup_upload(s);
}

/* --- a camera at rest --- */

/* Compares what is gathered with what a plan finds that always searches all
 * slices.  Derived: sums of sets take some ten more roundings.  Where only some
 * sets find an occluder, the bent normals of the others are that of a bare
 * plane. */
static void check_all_slices(setup *s, const exact_planes *want) {
  exact_planes got = stage_read(s, HBIL_STAGE_GATHERED);
  check_at_most("AO", relative_rmse(&got, want, HBIL_LIGHT_AO, 1), 1e-6);
  check_at_most("E_near", relative_rmse(&got, want, HBIL_LIGHT_RED, 3), 1e-6);
  check_at_most("bent normal", relative_rmse(&got, want, HBIL_LIGHT_BENT, 3),
                1e-3);
  exact_planes_free(&got);
}

/* Static frames search all slices.  The first one doesn't rest. */
static void check_static_frames(setup *s, const exact_planes *want) {
  hbil_statistics found;
  s->frame.static_frame = CL_TRUE;
  for (int i = 0; i < 3; ++i) {
    setup_run(s, hbil_enqueue_frame);
    check_all_slices(s, want);
    assert_success(s, hbil_plan_statistics(s->plan, s->device->queue, &found));
    assert_int_equal(found.not_run[HBIL_PASS_GATHER], i > 0);
    assert_int_equal(found.not_run[HBIL_PASS_RECOMPOSE], i > 0);
  }
  s->frame.static_frame = CL_FALSE;
}

/* A first frame searches all slices, and so have later ones all of them. */
TEST(a_camera_at_rest_has_all_slices) {
  for (cl_uint frames = 2; frames <= 4; ++frames) {
    setup all, s;
    start(&all, 1, 12);
    start(&s, frames, 12);
    setup_start(&all);
    setup_start(&s);
    setup_run(&all, hbil_enqueue_frame);
    exact_planes want = stage_read(&all, HBIL_STAGE_GATHERED);
    for (int i = 0; i < FRAMES; ++i) {
      setup_run(&s, hbil_enqueue_frame);
      check_all_slices(&s, &want);
      if (i == 3)
        check_static_frames(&s, &want);
    }
    exact_planes_free(&want);
    setup_free(&s);
    setup_free(&all);
  }
}

/* --- what frames hand on --- */

/* HBIL_STAGE_SLICES of the last frame, which is laid out as GATHERED but has
 * only the layers that are gathered. */
typedef struct sets {
  float *words;
  size_t plane, layer, row, origin;
  int values; /* of a set, and its weight */
  int step;   /* from a gathered pixel to the next */
} sets;

static bool is_half(const setup *s) {
  return s->config.sampling.resolution == HBIL_RESOLUTION_HALF;
}

static sets sets_read(setup *s) {
  hbil_buffer all, gathered;
  sets h;
  size_t size;
  assert_success(s, hbil_plan_buffer(s->plan, HBIL_STAGE_SLICES, &all));
  assert_success(s, hbil_plan_buffer(s->plan, HBIL_STAGE_GATHERED, &gathered));
  h.words = (float *)(void *)buffer_bytes(s->device, all.buffer, &size);
  h.values = (int)gathered.values - 1;
  h.plane = gathered.plane_pitch;
  h.layer = h.plane * (HBIL_PAST_SETS + (s->config.sampling.slice_frames - 1) *
                                            ((size_t)h.values + 1));
  h.step = is_half(s) ? 2 : 1;
  h.row = h.layer * (is_half(s) ? 4 : HBIL_LAYERS);
  h.origin = h.row + gathered.origin - gathered.row_pitch;
  assert_true(all.plane_pitch == size / sizeof(float) &&
              size / sizeof(float) >=
                  h.origin + h.row * (size_t)((s->config.height + 3) / 4));
  return h;
}

static double word_at(const sets *h, int plane, int x, int y) {
  const size_t i = (size_t)x, j = (size_t)y, step = (size_t)h->step;
  const size_t index = j % 4 / step * (4 / step) + i % 4 / step;
  return (double)h->words[h->origin + index * h->layer + j / 4 * h->row +
                          i / 4 + (size_t)plane * h->plane];
}

/* A plane of a set; plane h->values is its weight. */
static double of_set(const sets *h, int age, int plane, int x, int y) {
  return word_at(h, HBIL_PAST_SETS + age * (h->values + 1) + plane, x, y);
}

static void normal_at(const sets *h, int x, int y, double n[3]) {
  const float value = (float)word_at(h, HBIL_PAST_NORMAL, x, y);
  uint32_t word;
  memcpy(&word, &value, sizeof word);
  decode_normal(word, n);
}

/* --- where surfaces were --- */

typedef struct past {
  bool known, close; /* close: fp32 may decide differently */
  int x, y;          /* the gathered pixel */
} past;

static bool is_orthographic(const setup *s) {
  return s->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
}

static void to_world(const double m[16], const double v[3], double w,
                     double out[3]) {
  for (int r = 0; r < 3; ++r)
    out[r] = m[4 * r] * v[0] + m[4 * r + 1] * v[1] + m[4 * r + 2] * v[2] +
             w * m[4 * r + 3];
}

static void to_view(const double m[16], const double v[3], double w,
                    double out[3]) {
  for (int r = 0; r < 3; ++r) {
    out[r] = 0.0;
    for (int c = 0; c < 3; ++c)
      out[r] += m[4 * c + r] * (v[c] - w * m[4 * c + 3]);
  }
}

/* The slope of the ray through a position, and the point of it with that w:
 * inverse depth; orthographic, -z. */
static void slope_of(const hbil_camera *c, double x, double y, double r[3]) {
  r[0] = (x + 0.5 - c->cx) / c->fx;
  r[1] = (y + 0.5 - c->cy) / c->fy;
  r[2] = 1.0;
}

static void point_of(const setup *s, double x, double y, double w,
                     double p[3]) {
  const double z = is_orthographic(s) ? -w : 1.0 / w;
  slope_of(&s->frame.camera, x, y, p);
  for (int c = 0; c < 2; ++c)
    p[c] *= is_orthographic(s) ? 1.0 : z;
  p[2] = z;
}

/* Whether the past surface lies on the tangent plane of this one; n, z: its
 * normal and its depth there; (u, v): its place. */
static void compare_planes(const setup *s, const hbil_camera *before,
                           const double n[3], double z, double u, double v,
                           double w, past *out) {
  double at[3], here[3];
  slope_of(before, out->x, out->y, at);
  slope_of(before, u, v, here);
  double expected = dot(n, at) / (dot(n, here) * z);
  double unit = expected;
  if (is_orthographic(s)) {
    expected = (dot(n, at) - dot(n, here)) / n[2] - z;
    unit = WIDTH / before->fx;
  }
  const double off =
      fabs(w - expected) -
      (double)s->config.history.disocclusion_threshold * fabs(unit);
  out->close |= fabs(off) < 1e-3 * fabs(unit);
  out->known &= off <= 0.0;
}

static past find_past(const setup *s, const hbil_camera *before,
                      const exact_planes *split, const sets *old, int x,
                      int y) {
  const double *now = s->frame.camera.world_from_view;
  const double w = *exact_at(split, HBIL_SPLIT_W, x, y);
  double point[3], normal[3], world[3], p[3], n[3], m[3];
  past out = {.known = false};
  point_of(s, x, y, w, point);
  for (int c = 0; c < 3; ++c)
    normal[c] = *exact_at(split, HBIL_SPLIT_NORMAL + c, x, y);
  to_world(now, point, 1.0, world);
  to_view(before->world_from_view, world, 1.0, p);
  to_world(now, normal, 0.0, world);
  to_view(before->world_from_view, world, 0.0, n);
  const double spread = is_orthographic(s) ? 1.0 : p[2];
  double u = before->fx * p[0] / spread + before->cx - 0.5;
  double v = before->fy * p[1] / spread + before->cy - 0.5;
  if (s->config.history.reprojection == HBIL_REPROJECTION_MOTION) {
    u = x + (double)s->input[EXACT_MOTION][y * WIDTH + x];
    v = y + (double)s->input[EXACT_MOTION + 1][y * WIDTH + x];
  }
  if (!(p[2] > 0.0 && u > -0.5 && u < WIDTH - 0.5 && v > -0.5 &&
        v < HEIGHT - 0.5))
    return out;
  const double step = old->step, i = u / step + 0.5, j = v / step + 0.5;
  out.x = old->step * (int)fmin(floor(i), ceil(WIDTH / step) - 1.0);
  out.y = old->step * (int)fmin(floor(j), ceil(HEIGHT / step) - 1.0);
  out.close = fabs(i - nearbyint(i)) < 1e-3 || fabs(j - nearbyint(j)) < 1e-3;
  const double then = word_at(old, HBIL_PAST_W, out.x, out.y);
  out.known = is_orthographic(s) ? then > -1e29 : then > 0.0;
  if (!out.known)
    return out;
  normal_at(old, out.x, out.y, m);
  const double turn = 1.0 - dot(m, n) - HBIL_TURN_TOLERANCE;
  out.close |= fabs(turn) < 1e-4;
  out.known &= turn < 0.0;
  compare_planes(s, before, n, p[2], u, v, then, &out);
  return out;
}

/* --- frames that move --- */

/* What a moving sequence had: pixels whose slices came from several frames, all
 * from this one, and this frame's alone; those that fp32 decides. */
typedef struct tally {
  int joined, whole, single, close;
} tally;

/* A frame before and after the gather; every: what all slices find. */
typedef struct step {
  setup *s;
  const hbil_camera *before;
  exact_planes split, got, every;
  sets old, anew;
} step;

/* A plane of an older set in this frame's view. */
static double brought(const step *t, const past *then, int age, int plane) {
  double bent[3], world[3], here[3];
  if (plane < HBIL_LIGHT_BENT || plane >= HBIL_LIGHT_PLANES)
    return of_set(&t->old, age - 1, plane, then->x, then->y);
  for (int c = 0; c < 3; ++c)
    bent[c] = of_set(&t->old, age - 1, HBIL_LIGHT_BENT + c, then->x, then->y);
  to_world(t->before->world_from_view, bent, 0.0, world);
  to_view(t->s->frame.camera.world_from_view, world, 0.0, here);
  return here[plane - HBIL_LIGHT_BENT];
}

/* Whether a pixel has a set of that age. */
static bool has_set(const step *t, const past *then, int age) {
  return age == 0 ||
         (then->known && brought(t, then, age, t->anew.values) > 0.0);
}

static int frames_of(const step *t) {
  return (int)t->s->config.sampling.slice_frames;
}

/* The light of the sets that a pixel has, in double precision. */
static double join(const step *t, const past *then, int plane, int x, int y) {
  const bool bent = plane >= HBIL_LIGHT_BENT;
  const int last = t->anew.values;
  double sum = 0.0, total = 0.0;
  for (int age = 0; age < frames_of(t); ++age)
    if (has_set(t, then, age)) {
      const double weight = bent  ? 1.0
                            : age ? brought(t, then, age, last)
                                  : of_set(&t->anew, 0, last, x, y);
      sum += weight * (age ? brought(t, then, age, plane)
                           : of_set(&t->anew, 0, plane, x, y));
      total += weight;
    }
  return sum / (bent ? frames_of(t) : total);
}

static bool near(double got, double want) {
  return fabs(got - want) <= 2e-5 * (1.0 + fabs(want));
}

static bool is_joined(const step *t, const past *then, int x, int y) {
  const int last = t->anew.values;
  double whole = of_set(&t->anew, 0, last, x, y);
  bool same = true;
  for (int p = 0; p < HBIL_LIGHT_PLANES; ++p)
    same &= near(*exact_at(&t->got, p, x, y), join(t, then, p, x, y));
  for (int age = 1; age < frames_of(t); ++age)
    whole += has_set(t, then, age) ? brought(t, then, age, last) : 0.0;
  same &= near(*exact_at(&t->got, HBIL_LIGHT_WEIGHT, x, y),
               whole / t->s->config.sampling.slices);
  /* younger sets are handed on */
  for (int age = 1; age + 1 < frames_of(t); ++age)
    for (int p = 0; p <= last; ++p)
      same &= has_set(t, then, age) ? near(of_set(&t->anew, age, p, x, y),
                                           brought(t, then, age, p))
                                    : of_set(&t->anew, age, last, x, y) == 0.0;
  return same;
}

/* Bent normals differ (see above), and so does light that two plans carry over.
 */
static bool is_whole(const step *t, int x, int y) {
  const bool carried =
      t->s->config.history.reprojection != HBIL_REPROJECTION_NONE;
  bool same = true;
  for (int p = 0; p < (carried ? HBIL_LIGHT_RED : HBIL_LIGHT_BENT); ++p)
    same &= near(*exact_at(&t->got, p, x, y), *exact_at(&t->every, p, x, y));
  return same;
}

static void check_pixel(const step *t, int x, int y, tally *sum) {
  past then = {.known = false};
  if (t->before)
    then = find_past(t->s, t->before, &t->split, &t->old, x, y);
  if (then.close)
    sum->close++;
  else if (is_joined(t, &then, x, y))
    *(then.known ? &sum->joined : &sum->single) += 1;
  else if (is_whole(t, x, y))
    sum->whole++;
  else
    fail_msg("(%d, %d): AO %g is of no known slices", x, y,
             *exact_at(&t->got, HBIL_LIGHT_AO, x, y));
}

static void check_frame(setup *s, setup *all, const hbil_camera *before,
                        tally *sum) {
  step t = {.s = s, .before = before};
  if (before)
    t.old = sets_read(s);
  setup_run(all, hbil_enqueue_frame);
  setup_run(s, hbil_enqueue_frame);
  t.split = stage_read(s, HBIL_STAGE_SPLIT);
  t.got = stage_read(s, HBIL_STAGE_GATHERED);
  t.every = stage_read(all, HBIL_STAGE_GATHERED);
  t.anew = sets_read(s);
  for (int y = 0; y < HEIGHT; y += t.anew.step)
    for (int x = 0; x < WIDTH; x += t.anew.step)
      if (exact_is_surface(&s->config, *exact_at(&t.split, HBIL_SPLIT_W, x, y)))
        check_pixel(&t, x, y, sum);
  if (before)
    free(t.old.words);
  free(t.anew.words);
  planes_free(&t.split, &t.got, &t.every);
}

static void check_moving(hbil_reprojection reprojection,
                         hbil_projection projection, cl_uint width,
                         cl_uint frames, hbil_resolution resolution) {
  hbil_camera before;
  tally sum = {0, 0, 0, 0};
  setup s[2];
  for (int i = 0; i < 2; ++i) {
    start(&s[i], i ? 1 : frames, frames);
    s[i].config.history.reprojection = reprojection;
    s[i].config.inputs.projection = projection;
    s[i].config.inputs.motion.component =
        reprojection == HBIL_REPROJECTION_MOTION ? HBIL_FLOAT32 : HBIL_NONE;
    s[i].config.execution.vector_width = width;
    s[i].config.sampling.resolution = resolution;
    s[i].config.sampling.unfiltered =
        resolution == HBIL_RESOLUTION_FULL ? CL_TRUE : CL_FALSE;
    setup_start(&s[i]);
  }
  for (int i = 0; i < FRAMES; ++i) {
    for (int k = 0; k < 2; ++k)
      load(&s[k], (uint32_t)i);
    check_frame(&s[0], &s[1], i ? &before : NULL, &sum);
    before = s[0].frame.camera;
  }
  const int count =
      WIDTH * HEIGHT * FRAMES / (resolution == HBIL_RESOLUTION_HALF ? 4 : 1);
  check_at_most("share of close decisions", (double)sum.close / count, 0.02);
  check_at_most("share of pixels from this frame alone",
                (double)sum.single / count, 0.1);
  assert_in_range(sum.joined, count / 2, count);
  assert_in_range(sum.whole, count / FRAMES / 2, count / 2);
  for (int i = 0; i < 2; ++i)
    setup_free(&s[i]);
}

/* A camera that moves, also by single pixels and at half resolution; motion
 * vectors; an orthographic camera. */
TEST(what_moves_is_followed) {
  check_moving(HBIL_REPROJECTION_NONE, HBIL_PROJECTION_PERSPECTIVE, 0, 3,
               HBIL_RESOLUTION_FULL);
  check_moving(HBIL_REPROJECTION_NONE, HBIL_PROJECTION_PERSPECTIVE, 1, 2,
               HBIL_RESOLUTION_FULL);
  check_moving(HBIL_REPROJECTION_NONE, HBIL_PROJECTION_PERSPECTIVE, 0, 2,
               HBIL_RESOLUTION_HALF);
  check_moving(HBIL_REPROJECTION_MOTION, HBIL_PROJECTION_PERSPECTIVE, 0, 2,
               HBIL_RESOLUTION_FULL);
  check_moving(HBIL_REPROJECTION_NONE, HBIL_PROJECTION_ORTHOGRAPHIC, 0, 4,
               HBIL_RESOLUTION_FULL);
}

/* --- how many frames share them --- */

TEST(two_frames_share_where_they_can) {
  assert_int_equal(hbil_config_slice_frames(NULL), 0);
  hbil_config c;
  hbil_config_init(&c);
  assert_int_equal(hbil_config_slice_frames(&c), 2);
  c.sampling.slices = 3;
  assert_int_equal(hbil_config_slice_frames(&c), 1);
  c.sampling.slice_frames = 3;
  assert_int_equal(hbil_config_slice_frames(&c), 3);
  hbil_config_init(&c);
  c.sampling.unfiltered = CL_TRUE;
  assert_int_equal(hbil_config_slice_frames(&c), 1);
  hbil_config_init(&c);
  c.history.reprojection = HBIL_REPROJECTION_NONE;
  assert_int_equal(hbil_config_slice_frames(&c), 1);
  c.sampling.slice_frames = 4;
  assert_int_equal(hbil_config_slice_frames(&c), 4);
  c.outputs.glossy.component = HBIL_FLOAT32;
  assert_int_equal(hbil_config_slice_frames(&c), 1);
}

/* --- light that has fallen --- */

/* The last frame's light of a pixel at rest falls; AO doesn't.  Returns whether
 * that makes a difference to it. */
static bool check_fallen(const sets *old, const sets *anew,
                         const exact_planes *got, double ratio, int x, int y) {
  const double w0 = of_set(anew, 0, anew->values, x, y);
  const double w1 = of_set(old, 0, old->values, x, y);
  double most = 0.0;
  if (!(w1 > 0.0))
    return false;
  for (int p = 0; p < HBIL_LIGHT_BENT; ++p) {
    const double left = p < HBIL_LIGHT_RED ? 1.0 : ratio;
    const double now = w0 * of_set(anew, 0, p, x, y);
    const double then = w1 * of_set(old, 0, p, x, y);
    const double want = (now + left * then) / (w0 + w1);
    if (!near(*exact_at(got, p, x, y), want))
      fail_msg("(%d, %d), plane %d: %g, not %g", x, y, p,
               *exact_at(got, p, x, y), want);
    most = fmax(most, (1.0 - left) * then / (w0 + w1));
  }
  return most > 1e-3;
}

/* Runs a frame whose last one's light has fallen by these factors; NULL: it
 * hasn't.  Returns in how many pixels that makes a difference. */
static int check_next(lit_frame *l, const float *ratios) {
  int fallen = 0;
  sets old = sets_read(&l->s);
  setup_run(&l->s, hbil_enqueue_frame);
  sets anew = sets_read(&l->s);
  exact_planes got = stage_read(&l->s, HBIL_STAGE_GATHERED);
  for (int y = 0; y < LIT_HEIGHT; y += anew.step)
    for (int x = 0; x < LIT_WIDTH; x += anew.step) {
      const double ratio = ratios ? lit_fallen(l, ratios, x, y) : 1.0;
      if (!isnan(ratio) && !exact_is_sky(&l->s.job, x, y))
        fallen += check_fallen(&old, &anew, &got, ratio, x, y);
    }
  free(old.words);
  free(anew.words);
  exact_planes_free(&got);
  return fallen;
}

static void check_falling(cl_uint width, hbil_projection projection,
                          hbil_reprojection reprojection) {
  float ratios[HBIL_CACHE_REGIONS];
  hbil_last_frame last;
  lit_frame l;
  lit_draw_factors(11, ratios);
  lit_prepare(&l, HBIL_CACHE_METHOD_RAYS, width, SCENE_ROOM, projection,
              HBIL_FAR_FRAME);
  l.s.config.sampling.storage = HBIL_STORAGE_FLOAT32;
  l.s.config.sampling.slices = 4;
  l.s.config.sampling.slice_frames = 2;
  l.s.config.history.reprojection = reprojection;
  l.s.config.inputs.motion.component = HBIL_NONE;
  setup_start(&l.s);
  setup_run(&l.s, hbil_enqueue_frame);
  setup_run(&l.s, hbil_enqueue_frame);
  lit_fall(&l, ratios);
  assert_true(check_next(&l, ratios) > LIT_WIDTH * LIT_HEIGHT / 8);
  /* a frame behind no update */
  assert_true(check_next(&l, NULL) == 0);
  /* a job that is resumed behind an update, and its next frame */
  assert_success(&l.s, hbil_plan_last_frame(l.s.plan, &last));
  assert_success(&l.s, hbil_plan_adopt_history(l.s.plan, &last));
  assert_true(check_next(&l, ratios) > LIT_WIDTH * LIT_HEIGHT / 8);
  assert_true(check_next(&l, NULL) == 0);
  lit_free(&l);
}

TEST(light_of_the_last_slices_falls) {
  static const cl_uint widths[] = {1, 4, 8, 16};
  for (int i = 0; i < 4; ++i)
    check_falling(widths[i],
                  i == 2 ? HBIL_PROJECTION_ORTHOGRAPHIC
                         : HBIL_PROJECTION_PERSPECTIVE,
                  i == 3 ? HBIL_REPROJECTION_NONE : HBIL_REPROJECTION_CAMERA);
}

/* A gather that shares slices follows them by motion vectors; another one asks
 * for none. */
TEST(only_shared_slices_need_motion) {
  for (cl_uint frames = 1; frames <= 2; ++frames) {
    setup s;
    start(&s, frames, 2);
    s.config.history.reprojection = HBIL_REPROJECTION_MOTION;
    s.config.inputs.motion.component = HBIL_FLOAT32;
    setup_start(&s);
    setup_run(&s, hbil_enqueue_frame);
    s.frame.motion.buffer = NULL;
    const hbil_status status =
        hbil_enqueue_passes(s.plan, s.device->queue, &s.frame, HBIL_PASS_GATHER,
                            HBIL_PASS_GATHER, 0, NULL, NULL);
    assert_int_equal(status, frames == 1 ? HBIL_SUCCESS : HBIL_INVALID_FRAME);
    if (frames == 2)
      assert_non_null(strstr(hbil_context_message(s.device->hbil), "motion"));
    setup_free(&s);
  }
}

/* --- what can't be --- */

TEST(numbers_that_do_not_fit_are_rejected) {
  hbil_memory memory;
  hbil_buffer none;
  setup s;
  start(&s, 5, 5);
  assert_int_equal(hbil_plan_memory(s.device->hbil, &s.config, &memory),
                   HBIL_INVALID_CONFIG);
  assert_non_null(strstr(hbil_context_message(s.device->hbil),
                         "sampling.slice_frames: 5 is outside 0 .. 4"));
  s.config.sampling.slice_frames = 2;
  assert_int_equal(hbil_plan_memory(s.device->hbil, &s.config, &memory),
                   HBIL_INVALID_CONFIG);
  assert_non_null(strstr(hbil_context_message(s.device->hbil),
                         "sampling.slices, 5, must be a multiple"));
  s.config.sampling.slice_frames = 1;
  setup_start(&s);
  assert_int_equal(hbil_plan_buffer(s.plan, HBIL_STAGE_SLICES, &none),
                   HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(s.device->hbil),
                         "SLICES (sampling.slice_frames"));
  setup_free(&s);
}
