/*
 * HBIL's relatives, GTAO and HBAO: kernels against the reference, the reference
 * against HBIL's, and both against walls, rings and planes whose openness is
 * known.
 */
#include "test/support/stages.h"
#include "test/support/vectors.h"

#include <stdio.h>

/* A mode and the outputs it can have. */
static void set_mode(setup *s, hbil_mode mode) {
  s->config.mode = mode;
  if (mode != HBIL_MODE_HBIL)
    s->config.near_irradiance.component = HBIL_NONE;
  if (mode == HBIL_MODE_HBAO)
    s->config.bent_normal.component = s->config.cone_cosine.component =
        HBIL_NONE;
}

static exact_planes split_of(const setup *s) {
  exact_planes split = checked_planes((int)s->config.width,
                                      (int)s->config.height, HBIL_SPLIT_PLANES);
  exact_split(&s->job, NULL, &split);
  return split;
}

static exact_planes gathered_by_reference(const setup *s) {
  exact_planes split = split_of(s);
  exact_planes out =
      checked_planes(split.width, split.height, HBIL_GATHERED_PLANES);
  checked_gather(&s->job, &split, &out);
  exact_planes_free(&split);
  return out;
}

static exact_planes gathered_densely(const setup *s, const exact_dense *how) {
  exact_planes split = split_of(s);
  exact_planes out =
      checked_planes(split.width, split.height, HBIL_GATHERED_PLANES);
  checked_gather_dense(&s->job, &split, how, &out);
  exact_planes_free(&split);
  return out;
}

/* Ray of a pixel of a square image `size` wide. */
static void ray_at(const setup *s, int x, int y, double ray[3]) {
  const hbil_camera *camera = &s->frame.camera;
  ray[0] = (x + 0.5 - camera->cx) / camera->fx;
  ray[1] = (y + 0.5 - camera->cy) / camera->fy;
  ray[2] = 1.0;
}

/* ------------------------------------------------------------------------ */
/* Kernels against the reference                                             */

/* Relative RMSE.  Measured: AO 1.2e-7, bent 3.0e-7; with sectors, whose mean
 * direction is a quotient of differences, bent 1.2e-5. */
#define AO_LIMIT 1e-6
#define BENT_LIMIT 1e-5
#define SECTORS_BENT_LIMIT 5e-5

/* Where the last bit of fp32 takes an angle across a sector's border, a pixel
 * is off by sectors of its own (of any size: a half-slice seen at a grazing
 * angle has little A): counted, and left out of what is compared. */
static void forget_moved_sectors(exact_planes *got, const exact_planes *want) {
  int count = 0;
  for (int i = 0; i < got->width * got->height; ++i) {
    int x = i % got->width, y = i / got->width;
    if (fabs(*exact_at(got, HBIL_LIGHT_AO, x, y) -
             *exact_at(want, HBIL_LIGHT_AO, x, y)) < 1e-5)
      continue;
    ++count;
    for (int p = 0; p < got->count; ++p)
      *exact_at(got, p, x, y) = *exact_at(want, p, x, y);
  }
  check_at_most("pixels with a sector moved", count,
                got->width * got->height / 1000.0);
}

static bool has_sectors(const hbil_config *c) {
  return !isinf(c->thickness) || !isinf(c->relative_thickness);
}

static void check_kernel(setup *s) {
  exact_planes got, want;
  setup_start(s);
  got = stage_gathered(s);
  want = gathered_by_reference(s);
  if (has_sectors(&s->config))
    forget_moved_sectors(&got, &want);
  check_at_most("AO", relative_rmse(&got, &want, HBIL_LIGHT_AO, 1), AO_LIMIT);
  if (s->config.mode != HBIL_MODE_HBAO)
    check_at_most("bent", relative_rmse(&got, &want, HBIL_LIGHT_BENT, 3),
                  has_sectors(&s->config) ? SECTORS_BENT_LIMIT : BENT_LIMIT);
  exact_planes_free(&got);
  exact_planes_free(&want);
  setup_free(s);
}

static void check_view(hbil_mode mode, hbil_falloff falloff, int i) {
  const float radii[] = {INFINITY, 2.0f, 0.5f};
  const double fov[] = {30.0, 60.0, 90.0, 120.0};
  const cl_uint widths[] = {1, 4, 8, 16};
  setup s;
  setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 97, 54, 0);
  setup_load_view(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, fov[i % 4], 0);
  set_mode(&s, mode);
  s.config.falloff = falloff;
  s.config.radius = radii[i % 3];
  s.config.vector_width = widths[i / 3 % 4];
  s.config.slices = 1 + (cl_uint)i % 3;
  s.config.steps_per_side = i & 2 ? 8 : 21;
  s.config.sample_grid =
      i & 4 ? HBIL_GRID_SAME_LAYER : HBIL_GRID_FULL_RESOLUTION;
  s.frame.frame_index = (cl_uint)i;
  check_kernel(&s);
}

static void gtao_matches(void **state) {
  (void)state;
  for (int i = 0; i < 12; ++i)
    check_view(HBIL_MODE_GTAO, HBIL_FALLOFF_LINEAR, i);
}

static void hbao_matches_with_every_falloff(void **state) {
  (void)state;
  for (int i = 0; i < 12; ++i)
    check_view(HBIL_MODE_HBAO, (hbil_falloff)(i / 4), i);
  for (int i = 1; i < 12; i += 3) /* limited by 2 */
    check_view(HBIL_MODE_HBAO, (hbil_falloff)(i % 2), i);
}

static void occluders_with_an_end_match(void **state) {
  const float thickness[][2] = {
      {INFINITY, 0.08f}, {0.1f, INFINITY}, {0.02f, 0.5f}};
  (void)state;
  for (int i = 0; i < 12; ++i) {
    setup s;
    setup_scene(&s, i & 1 ? SCENE_SKY : SCENE_ROOM, 97, 54, 0);
    set_mode(&s, i & 2 ? HBIL_MODE_GTAO : HBIL_MODE_HBAO);
    s.config.thickness = thickness[i % 3][0];
    s.config.relative_thickness = thickness[i % 3][1];
    s.config.radius = i & 4 ? 1.0f : INFINITY;
    s.config.falloff = (hbil_falloff)(i / 4);
    s.config.vector_width = i & 8 ? 1 : 8;
    check_kernel(&s);
  }
}

static void half_float_depth_matches(void **state) {
  (void)state;
  for (int i = 0; i < 2; ++i) {
    setup s;
    setup_scene(&s, SCENE_ROOM, 97, 54, 0);
    set_mode(&s, i ? HBIL_MODE_HBAO : HBIL_MODE_GTAO);
    s.config.depth.component = HBIL_FLOAT16;
    check_kernel(&s);
  }
}

/* Everything a mode can put out. */
static void set_outputs(setup *s, hbil_mode mode) {
  s->config.far_irradiance = s->config.indirect = s->config.beauty =
      three_floats;
  s->config.ao = s->config.cone_cosine = one_float;
  s->config.bent_normal = three_floats;
  set_mode(s, mode);
}

/* Limits as in test_frame. */
static void check_frames(hbil_mode mode, hbil_far_field far_field,
                         hbil_feedback feedback) {
  setup s;
  exact_state reference;
  setup_scene(&s, SCENE_SKY, 97, 54, 0);
  checked_state(&reference, 97, 54);
  set_outputs(&s, mode);
  s.config.far_field = far_field;
  s.config.feedback = feedback;
  s.config.back_facing_fallback =
      HBIL_FALLBACK_FRAME_MEAN; /* of no consequence without light */
  for (int i = 0; i < (far_field == HBIL_FAR_SH ? 9 : 1); ++i)
    for (int c = 0; c < 3; ++c)
      s.frame.environment[i][c] = i ? 0.1f * (float)(i % 3) : 1.0f + (float)c;
  setup_start(&s);
  for (int i = 0; i < 3; ++i) {
    setup_load_scene(&s, SCENE_SKY, (uint32_t)i);
    s.frame.frame_index = (cl_uint)i;
    setup_upload(&s);
    setup_run(&s, hbil_enqueue_frame);
    checked_run_frame(&reference, &s.job);
    check_frame_outputs(&s, &reference.out);
  }
  exact_state_free(&reference);
  setup_free(&s);
}

static void whole_frames_match(void **state) {
  (void)state;
  check_frames(HBIL_MODE_GTAO, HBIL_FAR_CONSTANT, HBIL_FEEDBACK_IRRADIANCE);
  check_frames(HBIL_MODE_GTAO, HBIL_FAR_SH, HBIL_FEEDBACK_RADIANCE);
  check_frames(HBIL_MODE_GTAO, HBIL_FAR_NONE, HBIL_FEEDBACK_IRRADIANCE);
  check_frames(HBIL_MODE_HBAO, HBIL_FAR_CONSTANT, HBIL_FEEDBACK_RADIANCE);
  check_frames(HBIL_MODE_HBAO, HBIL_FAR_NONE, HBIL_FEEDBACK_IRRADIANCE);
}

/* ------------------------------------------------------------------------ */
/* The reference against itself                                              */

static void start_room(setup *s, hbil_mode mode, float thickness) {
  setup_scene(s, SCENE_ROOM, 64, 36, 0);
  setup_load_view(s, SCENE_ROOM, 90.0, 0);
  set_mode(s, mode);
  s->config.thickness = thickness;
  setup_start(s);
}

/* Derived: two forms of one integral.  Measured: 8.3e-16 and 2.2e-16. */
static void gtao_s_form_is_hbil_s(void **state) {
  const exact_dense how = {.slices = 37};
  (void)state;
  for (int dense = 0; dense < 2; ++dense) {
    setup hbil, gtao;
    exact_planes want, got;
    start_room(&hbil, HBIL_MODE_HBIL, INFINITY);
    start_room(&gtao, HBIL_MODE_GTAO, INFINITY);
    want = dense ? gathered_densely(&hbil, &how) : gathered_by_reference(&hbil);
    got = dense ? gathered_densely(&gtao, &how) : gathered_by_reference(&gtao);
    check_at_most("AO", largest_error(&got, &want, HBIL_LIGHT_AO, 1), 1e-12);
    check_at_most("bent", largest_error(&got, &want, HBIL_LIGHT_BENT, 3),
                  1e-12);
    check_at_most("light", largest_value(&got, HBIL_LIGHT_RED, 3), 0.0);
    check_at_most("unknown", largest_value(&got, HBIL_LIGHT_UNKNOWN, 1), 0.0);
    assert_true(largest_value(&want, HBIL_LIGHT_RED, 3) > 0.1);
    exact_planes_free(&want);
    exact_planes_free(&got);
    setup_free(&hbil);
    setup_free(&gtao);
  }
}

typedef struct progress {
  int calls, done, count;
} progress;

static void note_progress(void *user, int done, int count) {
  progress *p = user;
  assert_true(done >= p->done && done <= count);
  p->done = done;
  p->count = count;
  ++p->calls;
}

/* Threads change nothing, and tell of every row. */
static void any_number_of_threads_gives_the_same(void **state) {
  const int threads[] = {1, 2, 3, 7, 50};
  const exact_dense two = {.slices = 16};
  setup s;
  exact_planes want;
  (void)state;
  start_room(&s, HBIL_MODE_HBIL, 0.1f);
  want = gathered_densely(&s, &two);
  for (int i = 0; i < 5; ++i) {
    progress seen = {0, 0, 0};
    const exact_dense how = {.slices = 16,
                             .threads = threads[i],
                             .progress = note_progress,
                             .user = &seen};
    exact_planes got = gathered_densely(&s, &how);
    assert_int_equal(count_different(&got, &want), 0);
    assert_true(seen.done == 36 && seen.count == 36);
    assert_true(seen.calls > 36 / threads[i]);
    exact_planes_free(&got);
  }
  exact_planes_free(&want);
  setup_free(&s);
}

/* Pixels that are not wanted keep their values. */
static void unwanted_pixels_are_left_alone(void **state) {
  unsigned char wanted[64 * 36] = {0};
  const exact_dense all = {.slices = 16};
  const exact_dense some = {.slices = 16, .mask = wanted};
  exact_planes split, want, got = checked_planes(64, 36, HBIL_LIGHT_PLANES);
  setup s;
  (void)state;
  start_room(&s, HBIL_MODE_HBIL, INFINITY);
  split = split_of(&s);
  want = gathered_densely(&s, &all);
  for (int i = 0; i < 64 * 36; ++i) {
    wanted[i] = i % 11 == 3;
    for (int p = 0; p < HBIL_LIGHT_PLANES; ++p)
      got.values[p * 64 * 36 + i] = -7.0;
  }
  checked_gather_dense(&s.job, &split, &some, &got);
  for (int i = 0; i < 64 * 36 * HBIL_LIGHT_PLANES; ++i)
    assert_true(got.values[i] ==
                (wanted[i % (64 * 36)] ? want.values[i] : -7.0));
  exact_planes_free(&split);
  exact_planes_free(&want);
  exact_planes_free(&got);
  setup_free(&s);
}

/* A frame's outputs by the plan's densest settings, without a filter. */
static exact_planes densest_frame(setup *s) {
  s->config.slices = 32;
  s->config.steps_per_side = 64;
  s->config.step_growth = 0.0f;
  s->config.unfiltered = CL_TRUE;
  setup_start(s);
  setup_run(s, hbil_enqueue_frame);
  return outputs_read(s);
}

/*
 * Measured: AO .0035, E_near and indirect .047: what 32 slices miss.
 */
static void dense_frames_are_what_plans_approach(void **state) {
  const exact_dense how = {.slices = 1024};
  setup s;
  exact_state reference;
  exact_planes got;
  (void)state;
  setup_scene(&s, SCENE_ROOM, 64, 36, 0);
  setup_all_outputs(&s);
  s.config.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s.config.gather_emission = CL_FALSE;
  got = densest_frame(&s);
  s.config.unfiltered = CL_FALSE; /* the dense frame must not care */
  checked_state(&reference, 64, 36);
  checked_run_frame_dense(&reference, &s.job, &how);
  check_at_most("AO", relative_rmse(&got, &reference.out, EXACT_AO, 1), 0.01);
  check_at_most("E_near",
                relative_rmse(&got, &reference.out, EXACT_NEAR_IRRADIANCE, 3),
                0.08);
  check_at_most("indirect",
                relative_rmse(&got, &reference.out, EXACT_INDIRECT, 3), 0.08);
  exact_state_free(&reference);
  exact_planes_free(&got);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Bare planes                                                               */

/* Largest deviations from AO 1 and from the normal. */
typedef struct deviation {
  double ao, bent;
} deviation;

#define PLANE_WIDTH 80
#define PLANE_HEIGHT 45

static void set_plane(setup *s, const double normal[3]) {
  for (int i = 0; i < PLANE_WIDTH * PLANE_HEIGHT; ++i) {
    double ray[3], slope;
    ray_at(s, i % PLANE_WIDTH, i / PLANE_WIDTH, ray);
    slope = dot(normal, ray);
    s->input[EXACT_DEPTH][i] =
        slope < -1e-4 ? (float)(3.0 * normal[2] / slope) : 0.0f;
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] = (float)normal[c];
  }
}

static double bent_error(const exact_planes *got, const double normal[3], int x,
                         int y) {
  double bent[3], off[3];
  for (int c = 0; c < 3; ++c)
    bent[c] = *exact_at(got, HBIL_LIGHT_BENT + c, x, y);
  normalize(bent);
  add(bent, -1.0, normal, off);
  return isfinite(dot(off, off)) ? sqrt(dot(off, off)) : INFINITY;
}

static void add_plane(setup *s, const double normal[3], deviation *worst) {
  exact_planes got;
  set_plane(s, normal);
  setup_upload(s);
  got = stage_gathered(s);
  for (int i = 0; i < PLANE_WIDTH * PLANE_HEIGHT; ++i) {
    int x = i % PLANE_WIDTH, y = i / PLANE_WIDTH;
    double ao = *exact_at(&got, HBIL_LIGHT_AO, x, y);
    if (!(s->input[EXACT_DEPTH][i] > 0.0f))
      continue;
    worst->ao = fmax(worst->ao, fabs(ao - 1.0));
    if (s->config.mode == HBIL_MODE_GTAO)
      worst->bent = fmax(worst->bent, bent_error(&got, normal, x, y));
  }
  exact_planes_free(&got);
}

static void check_planes(hbil_mode mode, float radius, float thickness) {
  const double degrees[] = {0, 10, 30, 45, 60, 75, 80, 85};
  deviation worst = {0.0, 0.0};
  setup s;
  setup_init(&s, PLANE_WIDTH, PLANE_HEIGHT);
  set_mode(&s, mode);
  s.config.radius = radius;
  s.config.thickness = thickness;
  setup_start(&s);
  for (int i = 0; i < 48; ++i) {
    double tilt = degrees[i % 8] * PI / 180.0, azimuth = 0.4 + 1.3 * (i / 8);
    double normal[3] = {sin(tilt) * cos(azimuth), sin(tilt) * sin(azimuth),
                        -cos(tilt)};
    setup_camera(&s, i & 8 ? 60.0 : 110.0);
    add_plane(&s, normal, &worst);
  }
  /* measured: 1.2e-7, 4.8e-5; see test_plane */
  check_at_most("AO", worst.ao, 1e-5);
  check_at_most("bent", worst.bent, 5e-4);
  setup_free(&s);
}

static void planes_are_bare(void **state) {
  (void)state;
  check_planes(HBIL_MODE_GTAO, INFINITY, INFINITY);
  check_planes(HBIL_MODE_GTAO, 1.0f, INFINITY);
  check_planes(HBIL_MODE_HBAO, INFINITY, INFINITY);
  check_planes(HBIL_MODE_HBAO, 1.0f, INFINITY);
  check_planes(HBIL_MODE_HBAO, 1.0f, 0.1f);
}

/* ------------------------------------------------------------------------ */
/* A floor and an endless wall                                               */

#define SIDE 144

/*
 * The camera looks straight down on the floor z = 1; the wall x = 0.3 rises
 * towards it and leaves the frame at slope 1.  What the screen shows of it is a
 * trapezoid, and each point of the floor sees all of that and nothing else:
 * GTAO's AO is 1 - its view factor (Lambert's sum over the edges), HBAO's is
 * 1 - its solid angle / (2 pi), both exact, whatever slices are about.
 */
#define WALL_AT 0.3

static const double trapezoid[4][3] = {{WALL_AT, -1.0, 1.0},
                                       {WALL_AT, 1.0, 1.0},
                                       {WALL_AT, WALL_AT, WALL_AT},
                                       {WALL_AT, -WALL_AT, WALL_AT}};

static void towards(const double corners[4][3], const double point[3],
                    double to[4][3]) {
  for (int i = 0; i < 4; ++i) {
    add(corners[i], -1.0, point, to[i]);
    normalize(to[i]);
  }
}

static double view_factor(const double corners[4][3], const double point[3]) {
  double to[4][3], sum = 0.0;
  towards(corners, point, to);
  for (int i = 0; i < 4; ++i) {
    double axis[3], size;
    cross(to[i], to[(i + 1) % 4], axis);
    size = sqrt(dot(axis, axis));
    if (size > 0.0)
      sum -= atan2(size, dot(to[i], to[(i + 1) % 4])) * axis[2] / size;
  }
  return fabs(sum) / (2.0 * PI);
}

/* Of a triangle's unit directions (van Oosterom and Strackee 1983). */
static double solid_angle(const double a[3], const double b[3],
                          const double c[3]) {
  double bc[3];
  cross(b, c, bc);
  return 2.0 * atan2(fabs(dot(a, bc)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
}

static double share_of_hemisphere(const double corners[4][3],
                                  const double point[3]) {
  double to[4][3];
  towards(corners, point, to);
  return (solid_angle(to[0], to[1], to[2]) + solid_angle(to[0], to[2], to[3])) /
         (2.0 * PI);
}

static double wall_s_share(hbil_mode mode, const double corners[4][3],
                           const double point[3]) {
  return mode == HBIL_MODE_HBAO ? share_of_hemisphere(corners, point)
                                : view_factor(corners, point);
}

/* A wall without end hides half of everything: a quarter of a sphere, and by
 * symmetry half of the cosine. */
static void known_shares_are_right(void **state) {
  const double far = 1e6, point[3] = {0.1, -0.2, 1.0};
  const double wall[4][3] = {{WALL_AT, -far, 1.0},
                             {WALL_AT, far, 1.0},
                             {WALL_AT, far, 1.0 - far},
                             {WALL_AT, -far, 1.0 - far}};
  (void)state;
  check_at_most("view factor", fabs(view_factor(wall, point) - 0.5), 1e-5);
  check_at_most("solid angle", fabs(share_of_hemisphere(wall, point) - 0.5),
                1e-5);
}

static void set_wall(setup *s) {
  for (int i = 0; i < SIDE * SIDE; ++i) {
    double ray[3];
    bool wall;
    ray_at(s, i % SIDE, i / SIDE, ray);
    wall = ray[0] > WALL_AT;
    s->input[EXACT_DEPTH][i] = wall ? (float)(WALL_AT / ray[0]) : 1.0f;
    s->input[EXACT_NORMAL][i] = wall ? -1.0f : 0.0f;
    s->input[EXACT_NORMAL + 2][i] = wall ? 0.0f : -1.0f;
  }
}

static void start_wall(setup *s, hbil_mode mode, float thickness) {
  setup_init(s, SIDE, SIDE);
  setup_camera(s, 90.0);
  set_mode(s, mode);
  s->config.thickness = thickness;
  s->config.slices = 32;
  s->config.steps_per_side = SIDE;
  s->config.step_growth = 0.0f;
  set_wall(s);
  setup_start(s);
}

/* Every 7th pixel. */
static const unsigned char *some_pixels(void) {
  static unsigned char wanted[SIDE * SIDE];
  for (int i = 0; i < SIDE * SIDE; i += 7)
    wanted[i] = 1;
  return wanted;
}

/* Root mean square over the floor. */
static double wall_error(const setup *s, const exact_planes *got) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < SIDE * SIDE; i += 7) {
    double point[3], off;
    ray_at(s, i % SIDE, i / SIDE, point);
    if (point[0] > WALL_AT)
      continue;
    off = *exact_at(got, HBIL_LIGHT_AO, i % SIDE, i / SIDE) - 1.0 +
          wall_s_share(s->config.mode, trapezoid, point);
    sum += off * off;
    ++count;
  }
  assert_true(count > SIDE * SIDE / 14);
  return sqrt(sum / count);
}

static void walls_hide_what_the_screen_shows_of_them(void **state) {
  const exact_dense how = {.slices = 256, .mask = some_pixels()};
  (void)state;
  for (hbil_mode mode = HBIL_MODE_HBIL; mode <= HBIL_MODE_HBAO; ++mode) {
    setup s;
    exact_planes dense, kernel;
    start_wall(&s, mode, INFINITY);
    dense = gathered_densely(&s, &how);
    kernel = stage_gathered_mean(&s, 4);
    /* Measured: 6.5e-3, HBAO 5.5e-3: next to the wall a pixel of it spans many
     * degrees.  Slices weighed alike would be off by several times as much. */
    check_at_most("dense", wall_error(&s, &dense), 8e-3);
    check_at_most("kernel", wall_error(&s, &kernel), 8e-3);
    exact_planes_free(&dense);
    exact_planes_free(&kernel);
    setup_free(&s);
  }
}

/* The stretches of occluders that reach far beyond the floor are the horizon:
 * seen from above, nothing passes behind the wall. */
static void endless_stretches_are_the_horizon(void **state) {
  const exact_dense how = {.slices = 32, .mask = some_pixels()};
  (void)state;
  for (hbil_mode mode = HBIL_MODE_HBIL; mode <= HBIL_MODE_HBAO; ++mode) {
    setup endless, thick;
    exact_planes want, got;
    start_wall(&endless, mode, INFINITY);
    start_wall(&thick, mode, 1e9f);
    want = gathered_densely(&endless, &how);
    got = gathered_densely(&thick, &how);
    check_at_most("AO", largest_error(&got, &want, HBIL_LIGHT_AO, 1), 1e-6);
    check_at_most("bent", largest_error(&got, &want, HBIL_LIGHT_BENT, 3), 1e-6);
    exact_planes_free(&want);
    exact_planes_free(&got);
    setup_free(&endless);
    setup_free(&thick);
  }
}

/* ------------------------------------------------------------------------ */
/* A wall within a radius                                                    */

/*
 * A point whose normal is its view direction, on a floor, and a wall at
 * distance d that stands upright on it: then slices are planes through the
 * normal.  In azimuth phi the wall is met at rho = d/cos phi and followed up to
 * the elevation h where it leaves the radius, cos h = rho/R; at an elevation e
 * it is r = rho/cos e away.  So HBAO blocks, per azimuth,
 *   int_0^h W(r) cos e de = sin h - k rho h/R   with W = 1 - k r/R,
 * k = 1 (linear), 1/3 (soft), 0 (none).
 *
 * All azimuths together are closed in polar coordinates about the *wall's*
 * normal: what is within R is half of a cap of half-angle m, cos m = c = d/R,
 * at r = d/cos t, so that
 *   blocked = pi int_0^m (1 - k c/cos t) sin t dt = pi (1 - c + k c ln c)
 *   HBAO: AO = 1 - (1 - c + k c ln c)/2
 * and weighted by the cosine of the floor, sin t sin p,
 *   GTAO: AO = 1 - (1/pi) int_0^m sin^2 t dt int_0^pi sin p dp
 *            = 1 - (m - sin m cos m)/pi.
 */
typedef struct corner {
  int size, x, y; /* a square picture, the point's pixel */
  double azimuth; /* of the wall */
  double distance;
} corner;

/* The eye is this far from the point. */
#define EYE 1.5

static double share_of_falloff(hbil_falloff falloff) {
  return falloff == HBIL_FALLOFF_LINEAR ? 1.0
         : falloff == HBIL_FALLOFF_SOFT ? 1.0 / 3.0
                                        : 0.0;
}

static double corner_ao(const hbil_config *config, double distance) {
  double c = distance / (double)config->radius, m = acos(c);
  if (config->mode != HBIL_MODE_HBAO)
    return 1.0 - (m - sin(m) * cos(m)) / PI;
  return 1.0 - (1.0 - c + share_of_falloff(config->falloff) * c * log(c)) / 2.0;
}

/* The same, azimuth by azimuth. */
static double corner_by_azimuth(const hbil_config *config, double distance) {
  const int steps = 100000;
  double c = distance / (double)config->radius, m = acos(c), sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    double rho = c / cos(((i + 0.5) / steps * 2.0 - 1.0) * m), h = acos(rho);
    sum += sin(h) - share_of_falloff(config->falloff) * rho * h;
  }
  return 1.0 - sum * 2.0 * m / steps / (2.0 * PI);
}

/* Axes: up from the floor, towards the wall, along it. */
static void corner_axes(const setup *s, const corner *k, double up[3],
                        double wall[3], double along[3]) {
  double x[3] = {cos(k->azimuth), sin(k->azimuth), 0.0};
  ray_at(s, k->x, k->y, up);
  normalize(up);
  for (int c = 0; c < 3; ++c)
    up[c] = -up[c];
  add(x, -dot(x, up), up, wall);
  normalize(wall);
  cross(up, wall, along);
}

static void set_corner(setup *s, const corner *k) {
  double up[3], wall[3], along[3];
  corner_axes(s, k, up, wall, along);
  for (int i = 0; i < k->size * k->size; ++i) {
    double ray[3], floor_w, wall_w;
    ray_at(s, i % k->size, i / k->size, ray);
    floor_w = -dot(up, ray) / EYE; /* up.P = -EYE on the floor */
    wall_w = dot(wall, ray) / k->distance;
    s->input[EXACT_DEPTH][i] = fmax(floor_w, wall_w) > 1e-6
                                   ? (float)(1.0 / fmax(floor_w, wall_w))
                                   : 0.0f;
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] =
          (float)(wall_w > floor_w ? -wall[c] : up[c]);
  }
}

/* The closed form holds where the screen shows all of the wall within R. */
static void assert_in_view(const setup *s, const corner *k) {
  double up[3], wall[3], along[3], radius = (double)s->config.radius;
  double arc = sqrt(radius * radius - k->distance * k->distance);
  corner_axes(s, k, up, wall, along);
  for (int i = 0; i <= 64; ++i) {
    double p[3] = {0.0, 0.0, 0.0};
    add(p, -EYE + arc * sin(i * PI / 64), up, p);
    add(p, arc * cos(i * PI / 64), along, p);
    add(p, k->distance, wall, p);
    assert_true(p[2] > 0.0);
    assert_true(fabs(p[0] / p[2] * s->frame.camera.fx) < k->size / 2.0 - 1.0);
    assert_true(fabs(p[1] / p[2] * s->frame.camera.fy) < k->size / 2.0 - 1.0);
  }
}

static void start_corner(setup *s, const corner *k, hbil_mode mode,
                         hbil_falloff falloff) {
  setup_init(s, k->size, k->size);
  setup_camera(s, 110.0);
  set_mode(s, mode);
  s->config.falloff = falloff;
  s->config.radius = 1.0f;
  s->config.slices = 32;
  s->config.steps_per_side = 192;
  s->config.step_growth = 0.0f;
  set_corner(s, k);
  assert_in_view(s, k);
  setup_start(s);
}

static double dense_ao(const setup *s, int size, int x, int y) {
  unsigned char *wanted = calloc((size_t)(size * size), 1);
  const exact_dense how = {.slices = 512, .mask = wanted};
  exact_planes got;
  double ao;
  assert_non_null(wanted);
  wanted[y * size + x] = 1;
  got = gathered_densely(s, &how);
  ao = *exact_at(&got, HBIL_LIGHT_AO, x, y);
  exact_planes_free(&got);
  free(wanted);
  return ao;
}

static void check_corner(const corner *k, hbil_mode mode, hbil_falloff falloff,
                         double limit) {
  setup s;
  double want;
  start_corner(&s, k, mode, falloff);
  want = corner_ao(&s.config, k->distance);
  if (mode == HBIL_MODE_HBAO)
    check_at_most("by azimuth",
                  fabs(corner_by_azimuth(&s.config, k->distance) - want), 1e-6);
  check_at_most("dense", fabs(dense_ao(&s, k->size, k->x, k->y) - want), limit);
  if (k->size < 256) { /* a plan's samples cross all of it */
    exact_planes got = stage_gathered_mean(&s, 4);
    check_at_most("kernel",
                  fabs(*exact_at(&got, HBIL_LIGHT_AO, k->x, k->y) - want),
                  limit);
    exact_planes_free(&got);
  }
  setup_free(&s);
}

static void check_corners(const corner *k, double limit) {
  check_corner(k, HBIL_MODE_GTAO, HBIL_FALLOFF_LINEAR, limit);
  check_corner(k, HBIL_MODE_HBAO, HBIL_FALLOFF_LINEAR, limit);
  check_corner(k, HBIL_MODE_HBAO, HBIL_FALLOFF_SOFT, limit);
  check_corner(k, HBIL_MODE_HBAO, HBIL_FALLOFF_NONE, limit);
}

/*
 * In the middle, and askew, where slices weigh differently.  Samples lie in
 * pixels' centres, so horizons end up to a pixel early and W is that of an
 * interval's far end: errors are of a pixel's size.  Measured: 5.4e-3 at most
 * with 193 pixels a side, a quarter of that with 769.
 */
static void walls_within_a_radius_hide_what_they_should(void **state) {
  (void)state;
  for (int scale = 1; scale <= 4; scale *= 4) {
    const int size = 192 * scale + 1, middle = 96 * scale;
    const corner centre = {size, middle, middle, 0.3, 0.3};
    const corner off = {size, middle + 30 * scale, middle - 20 * scale, 2.6,
                        0.6};
    check_corners(&centre, 6e-3 / scale);
    check_corners(&off, 6e-3 / scale);
  }
}

/* ------------------------------------------------------------------------ */
/* A ring that floats                                                        */

#define RING 513

/*
 * Above the floor z = 2 hangs a ring at z = 1, seen between the slopes 0.3 and
 * 0.6, a quarter of its depth thick.  A sample at slope s covers the angles
 * from tan = s (its front, 1 above the floor) to tan = 1.25 s / 0.75 (its back,
 * at z = 1.25), so the ring covers those from tan a = 0.3 to tan b = 1; beside
 * it, on both sides, the point in the middle looks past it.
 *   AO (cosine) = 1 - (sin^2 b - sin^2 a), E_near/pi the rest under radiance 1
 *   AO (HBAO)   = 1 - (cos a - cos b),     bent = AO n by symmetry
 */
static void set_ring(setup *s) {
  for (int i = 0; i < RING * RING; ++i) {
    double ray[3], slope;
    bool ring;
    ray_at(s, i % RING, i / RING, ray);
    slope = sqrt(ray[0] * ray[0] + ray[1] * ray[1]);
    ring = slope > 0.3 && slope < 0.6;
    s->input[EXACT_DEPTH][i] = ring ? 1.0f : 2.0f;
    s->input[EXACT_NORMAL + 2][i] = -1.0f;
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_DIRECT + c][i] = ring ? (float)PI : 0.0f;
  }
}

static void start_ring(setup *s, hbil_mode mode) {
  setup_init(s, RING, RING);
  setup_camera(s, 90.0);
  set_mode(s, mode);
  s->config.albedo.component = s->config.emission.component = HBIL_NONE;
  s->config.relative_thickness = 0.25f;
  s->config.facing_fade[0] = s->config.facing_fade[1] = -1.0f;
  set_ring(s);
  setup_start(s);
}

/* The outermost pixels of a line are half a step inside the ring's edges in the
 * mean, and over all directions a step is this many pixels. */
static double mean_step(void) {
  return 4.0 / PI * log(1.0 + sqrt(2.0));
}

static double ring_share(hbil_mode mode) {
  double inside = mean_step() / RING; /* a pixel is 2/RING wide */
  double a = atan(0.3 + inside), b = atan((0.6 - inside) * 1.25 / 0.75);
  return mode == HBIL_MODE_HBAO ? cos(a) - cos(b)
                                : pow(sin(b), 2.0) - pow(sin(a), 2.0);
}

static double middle_value(const exact_planes *p, int plane) {
  return *exact_at(p, plane, RING / 2, RING / 2);
}

/* measured: 1.5e-4 */
#define RING_LIMIT 5e-4

static void light_passes_behind_rings(void **state) {
  unsigned char *wanted = calloc(RING * RING, 1);
  const exact_dense how = {.slices = 512, .mask = wanted};
  (void)state;
  assert_non_null(wanted);
  wanted[RING / 2 * RING + RING / 2] = 1;
  for (hbil_mode mode = HBIL_MODE_HBIL; mode <= HBIL_MODE_HBAO; ++mode) {
    setup s;
    exact_planes got;
    double share = ring_share(mode), ao;
    start_ring(&s, mode);
    got = gathered_densely(&s, &how);
    ao = middle_value(&got, HBIL_LIGHT_AO);
    check_at_most("AO", fabs(ao - 1.0 + share), RING_LIMIT);
    if (mode != HBIL_MODE_HBAO)
      check_at_most("bent", fabs(middle_value(&got, HBIL_LIGHT_BENT + 2) + ao),
                    1e-9);
    if (mode == HBIL_MODE_HBIL)
      check_at_most("E_near/pi",
                    fabs(middle_value(&got, HBIL_LIGHT_RED) / PI - share),
                    RING_LIMIT);
    exact_planes_free(&got);
    setup_free(&s);
  }
  free(wanted);
}

/* ------------------------------------------------------------------------ */
/* What modes refuse                                                         */

static void assert_refused(const hbil_config *config, const char *field) {
  hbil_plan *plan = NULL;
  assert_int_equal(hbil_plan_create(shared_device.hbil, config, &plan),
                   HBIL_INVALID_CONFIG);
  assert_null(plan);
  assert_non_null(strstr(hbil_context_message(shared_device.hbil), field));
}

static hbil_config ao_alone(hbil_mode mode) {
  hbil_config c;
  hbil_config_init(&c);
  c.width = c.height = 16;
  c.depth = c.ao = one_float;
  c.normal = three_floats;
  c.mode = mode;
  return c;
}

static void modes_refuse_what_they_cannot_have(void **state) {
  (void)state;
  for (hbil_mode mode = HBIL_MODE_GTAO; mode <= HBIL_MODE_HBAO; ++mode) {
    hbil_config c = ao_alone(mode);
    c.near_irradiance = three_floats;
    assert_refused(&c, "near_irradiance");
    c = ao_alone(mode);
    c.far_field = HBIL_FAR_FRAME;
    assert_refused(&c, "far_field");
  }
}

static void hbao_refuses_what_needs_a_bent_cone(void **state) {
  hbil_config c = ao_alone(HBIL_MODE_HBAO);
  (void)state;
  c.bent_normal = three_floats;
  assert_refused(&c, "bent_normal");
  c = ao_alone(HBIL_MODE_HBAO);
  c.cone_cosine = one_float;
  assert_refused(&c, "cone_cosine");
  c = ao_alone(HBIL_MODE_HBAO);
  c.far_field = HBIL_FAR_SH;
  c.far_irradiance = three_floats;
  assert_refused(&c, "far_field");
}

static void unknown_modes_and_falloffs_are_refused(void **state) {
  hbil_config c = ao_alone((hbil_mode)3);
  (void)state;
  assert_refused(&c, "mode");
  c = ao_alone(HBIL_MODE_HBAO);
  c.falloff = (hbil_falloff)3;
  assert_refused(&c, "falloff");
}

static void modes_take_what_they_can_have(void **state) {
  (void)state;
  for (int i = 0; i < 2; ++i) {
    setup s;
    setup_init(&s, 16, 16);
    set_outputs(&s, i ? HBIL_MODE_HBAO : HBIL_MODE_GTAO);
    s.config.far_field = i ? HBIL_FAR_CONSTANT : HBIL_FAR_SH;
    setup_start(&s); /* must succeed */
    setup_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(gtao_matches),
      cmocka_unit_test(hbao_matches_with_every_falloff),
      cmocka_unit_test(occluders_with_an_end_match),
      cmocka_unit_test(half_float_depth_matches),
      cmocka_unit_test(whole_frames_match),
      cmocka_unit_test(gtao_s_form_is_hbil_s),
      cmocka_unit_test(any_number_of_threads_gives_the_same),
      cmocka_unit_test(unwanted_pixels_are_left_alone),
      cmocka_unit_test(dense_frames_are_what_plans_approach),
      cmocka_unit_test(planes_are_bare),
      cmocka_unit_test(known_shares_are_right),
      cmocka_unit_test(walls_hide_what_the_screen_shows_of_them),
      cmocka_unit_test(endless_stretches_are_the_horizon),
      cmocka_unit_test(walls_within_a_radius_hide_what_they_should),
      cmocka_unit_test(light_passes_behind_rings),
      cmocka_unit_test(modes_refuse_what_they_cannot_have),
      cmocka_unit_test(hbao_refuses_what_needs_a_bent_cone),
      cmocka_unit_test(unknown_modes_and_falloffs_are_refused),
      cmocka_unit_test(modes_take_what_they_can_have)};
  return RUN_WITH_DEVICE(tests);
}
