/*
 * What the pixels of frames decide: whether direct light contains the sky's
 * light, whether it contains that of the lamps in the pictures, and how open a
 * place is whose sky isn't shown.
 */
#include "test/support/compare.h"

#include "scene/scene.h"

enum { WIDTH = 97, HEIGHT = 54, PIXELS = WIDTH * HEIGHT };

/* A frame in host memory, and what is decided of it. */
typedef struct first {
  float depth[PIXELS], normal[3][PIXELS], direct[3][PIXELS];
  float emission[3][PIXELS];
  hbil_host_planes planes; /* point to these, planar */
  hbil_config config;
  hbil_frame frame;
  hbil_sources found;
} first;

static void point_to(hbil_host_plane *plane, float channels[3][PIXELS]) {
  for (size_t c = 0; c < 3; ++c)
    plane->channel[c] = channels[c];
}

/* Planes and settings; their contents are the caller's. */
static void start(first *f) {
  memset(&f->planes, 0, sizeof f->planes);
  f->planes.depth.channel[0] = f->depth;
  point_to(&f->planes.normal, f->normal);
  point_to(&f->planes.direct, f->direct);
  point_to(&f->planes.emission, f->emission);
  hbil_config_init(&f->config);
  f->config.width = WIDTH;
  f->config.height = HEIGHT;
  f->config.inputs.normal_space = HBIL_SPACE_WORLD;
  hbil_frame_init(&f->frame);
}

/* On the heap: the caller frees it. */
static first *frame_of(scene_kind kind) {
  first *f = malloc(sizeof *f);
  scene_frame s;
  assert_non_null(f);
  assert_int_equal(scene_render(kind, WIDTH, HEIGHT, 0.0, 0, &s), 0);
  memcpy(f->depth, s.depth, sizeof f->depth);
  for (size_t c = 0; c < 3; ++c) {
    memcpy(f->normal[c], s.normal[c], sizeof f->normal[c]);
    memcpy(f->direct[c], s.direct[c], sizeof f->direct[c]);
    memcpy(f->emission[c], s.emission[c], sizeof f->emission[c]);
  }
  start(f);
  f->frame.camera = s.camera;
  scene_free(&s);
  return f;
}

/* Decides by the frame and by all that f->found has seen. */
static void add(first *f) {
  assert_int_equal(
      hbil_config_suggest(&f->planes, &f->config, &f->frame, &f->found),
      HBIL_SUCCESS);
}

static void suggest(first *f) {
  memset(&f->found, 0, sizeof f->found);
  add(f);
}

static void scale(float channels[3][PIXELS], float by) {
  for (size_t c = 0; c < 3; ++c)
    for (int i = 0; i < PIXELS; ++i)
      channels[c][i] *= by;
}

/* Fills the surfaces' or the sky's pixels. */
static void fill(first *f, float channels[3][PIXELS], bool surfaces,
                 float value) {
  for (size_t c = 0; c < 3; ++c)
    for (int i = 0; i < PIXELS; ++i)
      if ((f->depth[i] > 0.0f) == surfaces)
        channels[c][i] = value;
}

/* ------------------------------------------------------------------------ */
/* Emission                                                                  */

TEST(lamps_in_direct_light_are_not_gathered) {
  const float factors[] = {1.0f, 3.0f};
  for (int i = 0; i < 2; ++i) {
    first *f = frame_of(SCENE_ROOM);
    scale(f->direct, factors[i]);
    suggest(f);
    assert_int_equal(f->found.lamps, HBIL_SOURCE_IN_DIRECT);
    assert_int_equal(f->config.model.gather_emission, CL_FALSE);
    free(f);
  }
}

/* Direct light that is too weak to contain the lamps', or zero, or missing. */
TEST(lamps_that_direct_light_lacks_are_gathered) {
  for (int i = 0; i < 3; ++i) {
    first *f = frame_of(SCENE_ROOM);
    scale(f->direct, i == 0 ? 0.1f : 0.0f);
    if (i == 2)
      memset(&f->planes.direct, 0, sizeof f->planes.direct);
    f->config.model.gather_emission = CL_FALSE;
    suggest(f);
    assert_int_equal(f->found.lamps, HBIL_SOURCE_NOT_IN_DIRECT);
    assert_int_equal(f->config.model.gather_emission, CL_TRUE);
    free(f);
  }
}

/* Where everything emits, emitters tell. */
TEST(lamps_all_over_are_understood) {
  for (int i = 0; i < 2; ++i) {
    first *f = frame_of(SCENE_ROOM);
    fill(f, f->emission, true, 1.0f);
    fill(f, f->direct, true, i ? 0.0f : 5.0f);
    suggest(f);
    assert_int_equal(f->found.lamps,
                     i ? HBIL_SOURCE_NOT_IN_DIRECT : HBIL_SOURCE_IN_DIRECT);
    free(f);
  }
}

TEST(without_lamps_nothing_is_gathered) {
  for (int i = 0; i < 3; ++i) {
    first *f = frame_of(i ? SCENE_SKY : SCENE_ROOM);
    scale(f->emission, 0.0f);
    if (i == 1) /* a sky is no lamp */
      fill(f, f->emission, false, 1.0f);
    if (i == 2)
      memset(&f->planes.emission, 0, sizeof f->planes.emission);
    suggest(f);
    assert_int_equal(f->found.lamps, HBIL_SOURCE_NOT_SEEN);
    assert_int_equal(f->config.model.gather_emission, CL_FALSE);
    free(f);
  }
}

TEST(missing_normals_are_taken_from_depth) {
  const float dimmed[] = {1.0f, 1e-3f};
  for (int i = 0; i < 2; ++i) {
    first *f = frame_of(SCENE_ROOM);
    scale(f->direct, dimmed[i]);
    suggest(f);
    const hbil_source lamps = f->found.lamps;
    assert_int_equal(lamps,
                     i ? HBIL_SOURCE_NOT_IN_DIRECT : HBIL_SOURCE_IN_DIRECT);
    memset(&f->planes.normal, 0, sizeof f->planes.normal);
    suggest(f);
    assert_int_equal(f->found.lamps, lamps);
    assert_int_equal(f->config.model.far_field, HBIL_FAR_FRAME);
    free(f);
  }
}

/* ------------------------------------------------------------------------ */
/* A sky that the picture does not show                                      */

/* Gives the rows from `from` up to `to`, of 100, this normal in view space. */
static void lean(first *f, int from, int to, float x, float y, float z) {
  const float n[3] = {x, y, z};
  for (int i = 0; i < PIXELS; ++i)
    for (size_t c = 0; c < 3; ++c)
      if (100 * (i / WIDTH) >= from * HEIGHT && 100 * (i / WIDTH) < to * HEIGHT)
        f->normal[c][i] = n[c];
}

/* An evenly lit ground in the lower half, a wall at the same depth above it,
 * and no lamps. */
static first *open_place(void) {
  first *f = calloc(1, sizeof *f);
  assert_non_null(f);
  start(f);
  f->config.inputs.normal_space = HBIL_SPACE_VIEW;
  f->frame.camera.fx = f->frame.camera.fy = WIDTH / 2.0;
  f->frame.camera.cx = WIDTH / 2.0;
  f->frame.camera.cy = 0.3 * HEIGHT; /* the horizon */
  for (int p = 0; p < PIXELS; ++p)
    f->depth[p] = 1.0f;
  fill(f, f->direct, true, 2.0f);
  lean(f, 0, 50, 0.0f, 0.0f, -1.0f);
  lean(f, 50, 100, 0.0f, -1.0f, 0.0f);
  return f;
}

static void check_share(first *f, hbil_place place, double share,
                        double tolerance) {
  assert_int_equal(f->found.sky, HBIL_SOURCE_NOT_SEEN);
  assert_int_equal(f->found.place, place);
  assert_int_equal(f->config.model.far_field, HBIL_FAR_FRAME);
  check_at_most("sky_share", fabs((double)f->frame.sky_share - share),
                tolerance);
}

/* Light in every shadow is in the open, black shadows are not, and a few are
 * still in the open. */
TEST(light_in_shadows_tells_a_hidden_sky) {
  /* of 100 squares, black ones */
  const struct {
    int black;
    double share;
  } cases[] = {{0, 0.9}, {4, 0.9}, {7, 0.45}, {10, 0.0}, {50, 0.0}};
  for (int i = 0; i < 5; ++i) {
    first *f = open_place();
    for (int p = 0; p < PIXELS; ++p) {
      const int square = p / WIDTH / 2 * (WIDTH / 2) + p % WIDTH / 2;
      for (size_t c = 0; c < 3; ++c)
        f->direct[c][p] *= square % 100 < cases[i].black ? 0.0f : 1.0f;
    }
    suggest(f);
    /* 91 of 1296 squares are .0702; 0.9f is 2.4e-8 below 0.9 */
    check_share(f, cases[i].share > 0.0 ? HBIL_PLACE_OPEN : HBIL_PLACE_DARK,
                cases[i].share, cases[i].black == 7 ? 0.01 : 1e-7);
    free(f);
  }
}

/* Without light at all, every shadow is black. */
TEST(a_place_without_light_is_dark) {
  first *f = open_place();
  scale(f->direct, 0.0f);
  suggest(f);
  check_share(f, HBIL_PLACE_DARK, 0.0, 0.0);
  free(f);
}

/* 16 rows of surfaces are looked at, so shares of rows are right to 1/16. */
TEST(ground_is_in_the_open) {
  for (int i = 0; i < 3; ++i) {
    const int rows[] = {15, 50, 70};
    first *f = open_place();
    lean(f, 0, 100, 0.0f, 0.0f, -1.0f);
    lean(f, 100 - rows[i], 100, 0.0f, -1.0f, 0.0f);
    suggest(f);
    check_share(f, i ? HBIL_PLACE_OPEN : HBIL_PLACE_NO_GROUND, i ? 0.9 : 0.0,
                1e-7);
    free(f);
  }
}

TEST(a_ceiling_encloses) {
  first *f = open_place();
  lean(f, 0, 10, 0.0f, 1.0f, 0.0f);
  suggest(f);
  check_share(f, HBIL_PLACE_ENCLOSED, 0.0, 0.0);
  free(f);
}

/* Two walls that face each other are a room; two that face apart, as the
 * outside of a house has them, are not. */
TEST(walls_that_face_each_other_enclose) {
  for (int apart = 0; apart < 2; ++apart) {
    first *f = open_place();
    for (int i = 0; i < PIXELS / 2; ++i) {
      const int left = i % WIDTH < WIDTH / 2;
      f->normal[0][i] = left != apart ? 1.0f : -1.0f;
      f->normal[2][i] = -2.0f;
    }
    suggest(f);
    check_share(f, apart ? HBIL_PLACE_OPEN : HBIL_PLACE_ENCLOSED,
                apart ? 0.9 : 0.0, 1e-7);
    free(f);
  }
}

/* Up is an axis of the world: seen by a camera that pitches by 40 degrees, and
 * turned by 30, ground is ground, and a wall that leans in the picture is none.
 */
TEST(up_is_an_axis_of_the_world) {
  const double a = 40.0 * 3.14159265358979 / 180.0, b = a * 0.75;
  /* right, down and ahead, with z up */
  const double rows[3][3] = {{cos(b), -sin(a) * sin(b), cos(a) * sin(b)},
                             {-sin(b), -sin(a) * cos(b), cos(a) * cos(b)},
                             {0.0, -cos(a), -sin(a)}};
  for (int wall = 0; wall < 2; ++wall) {
    first *f = open_place();
    f->config.inputs.normal_space = HBIL_SPACE_WORLD;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        f->frame.camera.world_from_view[4 * r + c] = rows[r][c];
    if (wall) /* towards the camera */
      lean(f, 0, 100, (float)-sin(b), (float)-cos(b), 0.0f);
    else
      lean(f, 0, 100, 0.0f, 0.0f, 1.0f);
    suggest(f);
    check_share(f, wall ? HBIL_PLACE_NO_GROUND : HBIL_PLACE_OPEN,
                wall ? 0.0 : 0.9, 1e-7);
    free(f);
  }
}

/* What lies behind the surfaces lies beside the picture, too. */
TEST(nothing_behind_is_nothing_around) {
  for (int i = 0; i < 2; ++i) {
    first *f = open_place();
    int empty = 0;
    lean(f, 0, 100, 0.0f, 0.0f, -1.0f); /* no ground */
    for (int p = 0; p < PIXELS / (i ? 1 : 5); ++p, ++empty)
      f->depth[p] = 0.0f;
    suggest(f);
    check_share(f, HBIL_PLACE_EMPTY, fmin(1.5 * empty / PIXELS, 0.9), 1e-7);
    free(f);
  }
}

/* ------------------------------------------------------------------------ */
/* Several pictures                                                          */

/* A ceiling counts in whatever frame it is, and ground as its mean. */
TEST(each_picture_of_a_place_counts) {
  first *f = open_place();
  suggest(f);
  add(f);
  check_share(f, HBIL_PLACE_OPEN, 0.9, 1e-7);
  lean(f, 0, 10, 0.0f, 1.0f, 0.0f);
  add(f);
  check_share(f, HBIL_PLACE_ENCLOSED, 0.0, 0.0);
  lean(f, 0, 10, 0.0f, 0.0f, -1.0f);
  add(f);
  check_share(f, HBIL_PLACE_ENCLOSED, 0.0, 0.0);
  free(f);
}

/* A sky, or lamps, that one of the frames shows are known in all, and pictures
 * may have other sizes. */
TEST(what_one_picture_shows_is_known) {
  first *plain = open_place(), *f = frame_of(SCENE_SKY);
  first *room = frame_of(SCENE_ROOM);
  fill(f, f->emission, true, 0.0f);
  fill(f, f->emission, false, 4.0f);
  fill(f, f->direct, true, 6.0f);
  scale(room->direct, 0.0f);
  suggest(plain);
  f->found = plain->found;
  f->config.height = HEIGHT / 2;
  add(f);
  assert_int_equal(f->found.sky, HBIL_SOURCE_IN_DIRECT);
  assert_int_equal(f->found.lamps, HBIL_SOURCE_NOT_SEEN);
  plain->found = f->found;
  add(plain);
  assert_int_equal(plain->found.sky, HBIL_SOURCE_IN_DIRECT);
  assert_int_equal(plain->found.place, HBIL_PLACE_SKY_SEEN);
  assert_int_equal(plain->config.model.far_field, HBIL_FAR_FRAME);
  check_at_most("sky_share", (double)plain->frame.sky_share, 0.0);
  for (int c = 0; c < 3; ++c)
    check_at_most("sky", fabs((double)plain->frame.environment[0][c] - 4.0),
                  1e-5);
  room->found = plain->found;
  add(room);
  plain->found = room->found;
  add(plain);
  assert_int_equal(plain->found.lamps, HBIL_SOURCE_NOT_IN_DIRECT);
  assert_int_equal(plain->config.model.gather_emission, CL_TRUE);
  free(room);
  free(f);
  free(plain);
}

/* ------------------------------------------------------------------------ */
/* Parallel rays                                                             */

/* A valley of two slopes of 45 degrees, seen from above by PER_UNIT pixels to a
 * unit: its left side shines, its right side has `share` of the light that it
 * receives from there in closed form, patch by patch. */
enum { PER_UNIT = 10, MIDDLE = 48 };

static void valley_point(int i, double out[3]) {
  out[0] = (i % WIDTH + 0.5 - (MIDDLE + 0.5)) / PER_UNIT;
  out[1] = (i / WIDTH + 0.5) / PER_UNIT;
  out[2] = 10.0 - fabs(out[0]);
}

static double valley_light(int receiver) {
  double sum = 0.0, p[3], q[3];
  valley_point(receiver, p);
  for (int i = 0; i < PIXELS; ++i) {
    if (i % WIDTH >= MIDDLE)
      continue;
    valley_point(i, q);
    const double d[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    const double r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    /* normals (-1, 0, -1) and (1, 0, -1) over sqrt(2), whose projections'
     * product is half of this; a pixel's patch is sqrt(2) / PER_UNIT^2 */
    const double cosines = 0.5 * (-d[0] - d[2]) * (-d[0] + d[2]) / r2;
    sum += fmax(cosines, 0.0) * sqrt(2.0) / (PER_UNIT * PER_UNIT * r2);
  }
  return sum;
}

static first *valley(double share) {
  first *f = calloc(1, sizeof *f);
  assert_non_null(f);
  for (int i = 0; i < PIXELS; ++i) {
    const int side = (i % WIDTH > MIDDLE) - (i % WIDTH < MIDDLE);
    double p[3];
    valley_point(i, p);
    f->depth[i] = (float)p[2];
    f->normal[0][i] = (float)-side;
    f->normal[2][i] = -1.0f;
    f->emission[0][i] = side < 0 ? 1.0f : 0.0f;
    f->direct[0][i] = side > 0 ? (float)(share * valley_light(i)) : 0.0f;
  }
  start(f);
  f->planes.direct.channel[1] = f->planes.direct.channel[2] = NULL; /* grey */
  f->planes.emission.channel[1] = f->planes.emission.channel[2] = NULL;
  f->config.inputs.normal_space = HBIL_SPACE_VIEW;
  f->config.inputs.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  f->frame.camera =
      (hbil_camera){.fx = PER_UNIT, .fy = PER_UNIT, .cx = MIDDLE + 0.5};
  return f;
}

/* The decision is at half of the lamps' light. Taking 512 of the lamp's
 * patches and every third receiver is right to a tenth. */
TEST(parallel_rays_see_patches_of_one_size) {
  const double shares[] = {0.45, 0.55};
  for (int i = 0; i < 2; ++i) {
    first *f = valley(shares[i]);
    suggest(f);
    assert_int_equal(f->config.model.gather_emission, i == 0);
    /* the same in OpenGL's view space, in quarters of a unit */
    f->config.inputs.depth_scale = -4.0f;
    f->config.inputs.normal_scale[1] = f->config.inputs.normal_scale[2] = -1.0f;
    for (int k = 0; k < PIXELS; ++k) {
      f->depth[k] *= -0.25f;
      f->normal[2][k] *= -1.0f;
    }
    suggest(f);
    assert_int_equal(f->config.model.gather_emission, i == 0);
    for (int k = 0; k < PIXELS; ++k)
      f->depth[k] *= -4.0f;
    /* the same as a depth buffer with planes at 1 and 21 */
    f->config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
    f->frame.hardware_depth[0] = -1.0 / 20.0;
    f->frame.hardware_depth[1] = 1.0 / 20.0;
    for (int k = 0; k < PIXELS; ++k)
      f->depth[k] = (f->depth[k] - 1.0f) / 20.0f;
    suggest(f);
    assert_int_equal(f->config.model.gather_emission, i == 0);
    assert_int_equal(f->found.sky, HBIL_SOURCE_NOT_SEEN);
    free(f);
  }
}

/* ------------------------------------------------------------------------ */
/* The sky                                                                   */

/* Checks the far field of a frame under an even sky, lit by `direct`
 * (irradiance). */
static void check_under(float sky, float direct, hbil_source found,
                        hbil_far_field far) {
  first *f = frame_of(SCENE_SKY);
  scale(f->emission, 0.0f);
  fill(f, f->emission, false, sky);
  fill(f, f->direct, true, direct);
  f->frame.environment[0][1] = 3.0f;
  suggest(f);
  assert_int_equal(f->found.sky, found);
  assert_int_equal(f->config.model.far_field, far);
  for (int c = 0; c < 3; ++c)
    check_at_most("sky", fabs((double)f->frame.environment[0][c] - (double)sky),
                  1e-5);
  free(f);
}

TEST(a_sky_in_direct_light_is_told_to_the_estimate) {
  check_under(4.0f, 6.0f, HBIL_SOURCE_IN_DIRECT, HBIL_FAR_FRAME);
}

TEST(a_sky_that_direct_light_lacks_is_far_light) {
  check_under(4.0f, 0.1f, HBIL_SOURCE_NOT_IN_DIRECT, HBIL_FAR_CONSTANT);
}

TEST(an_unlit_sky_says_nothing) {
  check_under(0.0f, 6.0f, HBIL_SOURCE_NOT_SEEN, HBIL_FAR_FRAME);
}

/* ------------------------------------------------------------------------ */
/* What the caller hands in                                                  */

static bool gathers_at(first *f, double direct_scale) {
  f->config.inputs.direct_scale = (float)direct_scale;
  suggest(f);
  return f->config.model.gather_emission == CL_TRUE;
}

/* The direct_scale at which the decision about the lamps changes. */
static double turning_point(first *f) {
  double low = 0.0, high = 1.0;
  assert_true(gathers_at(f, low) && !gathers_at(f, high));
  while (high - low > 1e-5 * high) {
    const double middle = 0.5 * (low + high);
    *(gathers_at(f, middle) ? &low : &high) = middle;
  }
  return low;
}

/* Radiance with its albedo tells what irradiance tells, also where surfaces are
 * white because there is no albedo. */
TEST(radiance_tells_the_same) {
  static float albedo[3][PIXELS];
  first *f = frame_of(SCENE_ROOM);
  const double turns = turning_point(f);
  f->config.inputs.direct_kind = HBIL_DIRECT_RADIANCE;
  check_at_most("white", fabs(turning_point(f) * PI / turns - 1.0), 1e-4);
  point_to(&f->planes.albedo, albedo);
  for (int i = 0; i < PIXELS; ++i)
    for (int c = 0; c < 3; ++c) {
      albedo[c][i] = 0.1f + 0.2f * (float)((i + c) % 4);
      f->direct[c][i] *= albedo[c][i];
    }
  check_at_most("albedo", fabs(turning_point(f) * PI / turns - 1.0), 1e-4);
  free(f);
}

/* Interleaved planes with gaps, whose depths are distances from the eye, mean
 * the same as planar ones. */
TEST(layout_and_kind_of_depth_change_nothing) {
  enum { STRIDE = 4, PITCH = STRIDE * WIDTH + 3 };
  static float packed[3][HEIGHT * PITCH];
  first *f = frame_of(SCENE_ROOM);
  const hbil_camera *camera = &f->frame.camera;
  const double turns = turning_point(f);
  for (int i = 0; i < PIXELS; ++i) {
    const int x = i % WIDTH, y = i / WIDTH, at = y * PITCH + x * STRIDE;
    const double right = (x + 0.5 - camera->cx) / camera->fx;
    const double down = (y + 0.5 - camera->cy) / camera->fy;
    packed[0][at + 3] =
        f->depth[i] * (float)sqrt(right * right + down * down + 1.0);
    for (int c = 0; c < 3; ++c) {
      packed[0][at + c] = f->normal[c][i];
      packed[1][at + c] = f->direct[c][i];
      packed[2][at + c] = f->emission[c][i];
    }
  }
  hbil_host_plane *planes[] = {&f->planes.normal, &f->planes.direct,
                               &f->planes.emission, &f->planes.depth};
  for (int i = 0; i < 4; ++i) {
    planes[i]->pixel_pitch = STRIDE * sizeof(float);
    planes[i]->row_pitch = PITCH * sizeof(float);
    for (int c = 0; c < 3; ++c)
      planes[i]->channel[c] = packed[i % 3] + (i == 3 ? 3 : c);
  }
  f->config.inputs.depth_kind = HBIL_DEPTH_RAY;
  /* 1e-4: above the search's precision and the rounding of the depths */
  assert_true(gathers_at(f, turns * (1.0 - 1e-4)));
  assert_false(gathers_at(f, turns * (1.0 + 1e-4)));
  /* a reversed depth buffer whose far plane is at infinity */
  f->config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
  f->planes.depth = (hbil_host_plane){.channel = {f->depth}};
  f->frame.hardware_depth[1] = (double)0.1f;
  for (int i = 0; i < PIXELS; ++i)
    f->depth[i] = f->depth[i] > 0.0f ? 0.1f / f->depth[i] : 0.0f;
  assert_true(gathers_at(f, turns * (1.0 - 1e-4)));
  assert_false(gathers_at(f, turns * (1.0 + 1e-4)));
  /* such a difference would be seen */
  f->config.inputs.depth_kind = HBIL_DEPTH_PLANAR;
  assert_true(fabs(turning_point(f) / turns - 1.0) > 1e-3);
  free(f);
}

TEST(other_modes_look_at_nothing) {
  const hbil_mode modes[] = {HBIL_MODE_GTAO, HBIL_MODE_HBAO};
  const hbil_host_planes none = {0};
  for (int i = 0; i < 2; ++i) {
    hbil_config config;
    hbil_frame frame;
    hbil_config_init(&config);
    hbil_frame_init(&frame);
    config.model.mode = modes[i];
    config.model.far_field = HBIL_FAR_FRAME;
    assert_int_equal(hbil_config_suggest(&none, &config, &frame, NULL),
                     HBIL_SUCCESS);
    assert_int_equal(config.model.far_field, HBIL_FAR_NONE);
    assert_int_equal(config.model.gather_emission, CL_FALSE);
  }
}

/* Makes one thing wrong.  Returns the status for it; HBIL_SUCCESS behind the
 * last one. */
static hbil_status damage(first *f, int what) {
  switch (what) {
  case 0:
    f->planes.depth.channel[0] = NULL;
    return HBIL_INVALID_ARGUMENT;
  case 1:
    f->planes.normal.channel[2] = NULL;
    return HBIL_INVALID_ARGUMENT;
  case 2:
    f->planes.direct.channel[0] = NULL;
    return HBIL_INVALID_ARGUMENT;
  case 3:
    f->planes.normal.row_pitch = 4;
    return HBIL_INVALID_ARGUMENT;
  case 4:
    f->planes.emission.row_pitch = WIDTH * sizeof(float) - 4;
    return HBIL_INVALID_ARGUMENT;
  case 5:
    f->planes.emission.row_pitch = WIDTH * sizeof(float) + 2;
    return HBIL_INVALID_ARGUMENT;
  case 6:
    f->config.width = 0;
    return HBIL_INVALID_CONFIG;
  case 7:
    f->config.height = HBIL_MAX_SIZE + 1;
    return HBIL_INVALID_CONFIG;
  case 8:
    f->frame.camera.fx = 0.0;
    return HBIL_INVALID_FRAME;
  case 9:
    f->frame.camera.fy = (double)NAN;
    return HBIL_INVALID_FRAME;
  case 10:
    f->config.inputs.depth_kind = HBIL_DEPTH_HARDWARE; /* B is 0 */
    return HBIL_INVALID_FRAME;
  case 11:
    f->config.inputs.depth_kind = (hbil_depth_kind)3;
    return HBIL_INVALID_CONFIG;
  default:
    return HBIL_SUCCESS;
  }
}

TEST(what_cannot_be_read_is_rejected) {
  static const char *const told[] = {"depth.channel[0]", "normal.channel[2]",
                                     "direct.channel[0]", "row_pitch 4; must"};
  first *good = frame_of(SCENE_ROOM), *bad = malloc(sizeof *bad);
  hbil_status status = HBIL_INVALID_ARGUMENT;
  assert_non_null(bad);
  for (int i = 0; status != HBIL_SUCCESS; ++i) {
    *bad = *good;
    status = damage(bad, i);
    const hbil_config config = bad->config;
    const hbil_frame frame = bad->frame;
    assert_int_equal(
        hbil_config_suggest(&bad->planes, &bad->config, &bad->frame, NULL),
        status);
    if (status != HBIL_SUCCESS) {
      assert_non_null(strstr(hbil_context_message(NULL),
                             i < 4 ? told[i] : "hbil_config_suggest"));
      assert_memory_equal(&bad->config, &config, sizeof config);
      assert_memory_equal(&bad->frame, &frame, sizeof frame);
    }
  }
  assert_int_equal(hbil_config_suggest(NULL, &good->config, &good->frame, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_config_suggest(&good->planes, NULL, &good->frame, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(
      hbil_config_suggest(&good->planes, &good->config, NULL, NULL),
      HBIL_INVALID_ARGUMENT);
  free(bad);
  free(good);
}

int main(void) {
  return tests_run();
}
