/*
 * What is decided from the first frame's pixels: whether direct light contains
 * the sky's light, and whether it contains that of the lamps in the picture.
 */
#include "test/support/compare.h"

#include <stdio.h>

#include "scene/scene.h"
#include "dump/light_sources.h"

#define WIDTH 97
#define HEIGHT 54

static void add_role(gbuffer *g, role r, const float *const *channels,
                     size_t count) {
  g->map.count[r] = count;
  for (size_t c = 0; c < count; ++c) {
    image_plane *plane;
    snprintf(g->map.names[r][c], sizeof g->map.names[r][c], "role%d.%d", (int)r,
             (int)c);
    plane = image_add(&g->planes, g->map.names[r][c]);
    assert_non_null(plane);
    memcpy(plane->pixels, channels[c], WIDTH * HEIGHT * sizeof(float));
  }
}

/* A frame as the tool reads it. */
static gbuffer frame_of(scene_kind kind, hbil_config *config,
                        hbil_camera *camera) {
  scene_frame s;
  gbuffer g = {.planes = {.width = WIDTH, .height = HEIGHT}};
  assert_int_equal(scene_render(kind, WIDTH, HEIGHT, 0.0, 0, &s), 0);
  channel_map_init(&g.map, DUMP_PLAIN);
  add_role(&g, ROLE_DEPTH, (const float *const[]){s.depth}, 1);
  add_role(&g, ROLE_NORMAL,
           (const float *const[]){s.normal[0], s.normal[1], s.normal[2]}, 3);
  add_role(&g, ROLE_DIRECT,
           (const float *const[]){s.direct[0], s.direct[1], s.direct[2]}, 3);
  add_role(&g, ROLE_EMISSION,
           (const float *const[]){s.emission[0], s.emission[1], s.emission[2]},
           3);
  *camera = s.camera;
  scene_free(&s);
  hbil_config_init(config);
  channel_map_configure(&g.map, config);
  return g;
}

static float *plane_of(gbuffer *g, role r, size_t c) {
  return image_find(&g->planes, g->map.names[r][c])->pixels;
}

static void scale(gbuffer *g, role r, float by) {
  for (size_t c = 0; c < 3; ++c)
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      plane_of(g, r, c)[i] *= by;
}

/* Fills the surfaces' or the sky's pixels. */
static void fill(gbuffer *g, role r, bool surfaces, float value) {
  const float *depth = plane_of(g, ROLE_DEPTH, 0);
  for (size_t c = 0; c < 3; ++c)
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      if ((depth[i] > 0.0f) == surfaces)
        plane_of(g, r, c)[i] = value;
}

/* ------------------------------------------------------------------------ */
/* Emission                                                                  */

static bool gathers(gbuffer *g, hbil_config *config, const hbil_camera *camera,
                    const char **reason) {
  emission_choose(g, camera, config, reason);
  return config->model.gather_emission != 0;
}

static void lamps_in_direct_light_are_not_gathered(void **state) {
  const float factors[] = {1.0f, 3.0f};
  (void)state;
  for (int i = 0; i < 2; ++i) {
    hbil_config config;
    hbil_camera camera;
    const char *reason;
    gbuffer g = frame_of(SCENE_ROOM, &config, &camera);
    scale(&g, ROLE_DIRECT, factors[i]);
    assert_false(gathers(&g, &config, &camera, &reason));
    assert_non_null(reason);
    gbuffer_free(&g);
  }
}

/* Direct light that is too weak to contain the lamps', or zero, or missing. */
static void lamps_that_direct_light_lacks_are_gathered(void **state) {
  (void)state;
  for (int i = 0; i < 3; ++i) {
    hbil_config config;
    hbil_camera camera;
    const char *reason;
    gbuffer g = frame_of(SCENE_ROOM, &config, &camera);
    scale(&g, ROLE_DIRECT, i == 0 ? 0.1f : 0.0f);
    if (i == 2)
      g.map.count[ROLE_DIRECT] = 0;
    assert_true(gathers(&g, &config, &camera, &reason));
    assert_non_null(reason);
    gbuffer_free(&g);
  }
}

static void without_lamps_there_is_nothing_to_say(void **state) {
  (void)state;
  for (int i = 0; i < 2; ++i) {
    hbil_config config;
    hbil_camera camera;
    const char *reason;
    gbuffer g = frame_of(i ? SCENE_SKY : SCENE_ROOM, &config, &camera);
    scale(&g, ROLE_EMISSION, 0.0f);
    if (i) /* a sky is no lamp */
      fill(&g, ROLE_EMISSION, false, 1.0f);
    assert_false(gathers(&g, &config, &camera, &reason));
    assert_null(reason);
    gbuffer_free(&g);
  }
}

/* ------------------------------------------------------------------------ */
/* Parallel rays                                                             */

/* A valley of two slopes of 45 degrees, seen from above by PIXELS pixels to a
 * unit: its left side shines, its right side has `share` of the light that it
 * receives from there in closed form, patch by patch. */
enum { PIXELS = 10, MIDDLE = 48 };

static void valley_point(int i, double out[3]) {
  out[0] = (i % WIDTH + 0.5 - (MIDDLE + 0.5)) / PIXELS;
  out[1] = (i / WIDTH + 0.5) / PIXELS;
  out[2] = 10.0 - fabs(out[0]);
}

static double valley_light(int receiver) {
  double sum = 0.0, p[3], q[3];
  valley_point(receiver, p);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    if (i % WIDTH >= MIDDLE)
      continue;
    valley_point(i, q);
    const double d[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    const double r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    /* normals (-1, 0, -1) and (1, 0, -1) over sqrt(2), whose projections'
     * product is half of this; a pixel's patch is sqrt(2) / PIXELS^2 */
    const double cosines = 0.5 * (-d[0] - d[2]) * (-d[0] + d[2]) / r2;
    sum += fmax(cosines, 0.0) * sqrt(2.0) / (PIXELS * PIXELS * r2);
  }
  return sum;
}

static gbuffer valley(double share, hbil_config *config, hbil_camera *camera) {
  gbuffer g = {.planes = {.width = WIDTH, .height = HEIGHT}};
  float depth[WIDTH * HEIGHT], left[WIDTH * HEIGHT], up[WIDTH * HEIGHT];
  float direct[WIDTH * HEIGHT], emission[WIDTH * HEIGHT];
  float zero[WIDTH * HEIGHT] = {0};
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    const int side = (i % WIDTH > MIDDLE) - (i % WIDTH < MIDDLE);
    double p[3];
    valley_point(i, p);
    depth[i] = (float)p[2];
    left[i] = (float)-side;
    up[i] = -1.0f;
    emission[i] = side < 0 ? 1.0f : 0.0f;
    direct[i] = side > 0 ? (float)(share * valley_light(i)) : 0.0f;
  }
  channel_map_init(&g.map, DUMP_PLAIN);
  g.map.how.normals = SPACE_CAMERA;
  g.map.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  add_role(&g, ROLE_DEPTH, (const float *const[]){depth}, 1);
  add_role(&g, ROLE_NORMAL, (const float *const[]){left, zero, up}, 3);
  add_role(&g, ROLE_DIRECT, (const float *const[]){direct}, 1);
  add_role(&g, ROLE_EMISSION, (const float *const[]){emission}, 1);
  *camera = (hbil_camera){.fx = PIXELS, .fy = PIXELS, .cx = MIDDLE + 0.5};
  hbil_config_init(config);
  channel_map_configure(&g.map, config);
  return g;
}

/* The decision is at half of the lamps' light. Taking 512 of the lamp's
 * patches and every third receiver is right to a tenth. */
static void parallel_rays_see_patches_of_one_size(void **state) {
  const double shares[] = {0.45, 0.55};
  (void)state;
  for (int i = 0; i < 2; ++i) {
    hbil_config config;
    hbil_camera camera;
    const char *reason;
    gbuffer g = valley(shares[i], &config, &camera);
    assert_int_equal(config.inputs.projection, HBIL_PROJECTION_ORTHOGRAPHIC);
    assert_int_equal(gathers(&g, &config, &camera, &reason), i == 0);
    gbuffer_free(&g);
  }
}

/* ------------------------------------------------------------------------ */
/* The sky                                                                   */

/* Far field of a frame under an even sky, lit by `direct` (irradiance). */
static hbil_far_field under(float sky, float direct, float environment[9][3]) {
  hbil_config config;
  hbil_camera camera;
  const char *reason = NULL;
  gbuffer g = frame_of(SCENE_SKY, &config, &camera);
  memset(environment, 0, 9 * sizeof *environment);
  scale(&g, ROLE_EMISSION, 0.0f);
  fill(&g, ROLE_EMISSION, false, sky);
  fill(&g, ROLE_DIRECT, true, direct);
  far_field_choose(&g, &config, environment, &reason);
  assert_non_null(reason);
  gbuffer_free(&g);
  return config.model.far_field;
}

static void a_sky_in_direct_light_is_told_to_the_estimate(void **state) {
  float environment[9][3];
  (void)state;
  assert_int_equal(under(4.0f, 6.0f, environment), HBIL_FAR_FRAME);
  for (int c = 0; c < 3; ++c)
    check_at_most("sky", fabs((double)environment[0][c] - 4.0), 1e-5);
}

static void a_sky_that_direct_light_lacks_is_far_light(void **state) {
  float environment[9][3];
  (void)state;
  assert_int_equal(under(4.0f, 0.1f, environment), HBIL_FAR_CONSTANT);
  for (int c = 0; c < 3; ++c)
    check_at_most("sky", fabs((double)environment[0][c] - 4.0), 1e-5);
}

static void an_unlit_sky_says_nothing(void **state) {
  float environment[9][3];
  (void)state;
  assert_int_equal(under(0.0f, 6.0f, environment), HBIL_FAR_FRAME);
  for (int c = 0; c < 3; ++c)
    assert_true(environment[0][c] <= 0.0f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(lamps_in_direct_light_are_not_gathered),
      cmocka_unit_test(lamps_that_direct_light_lacks_are_gathered),
      cmocka_unit_test(without_lamps_there_is_nothing_to_say),
      cmocka_unit_test(parallel_rays_see_patches_of_one_size),
      cmocka_unit_test(a_sky_in_direct_light_is_told_to_the_estimate),
      cmocka_unit_test(a_sky_that_direct_light_lacks_is_far_light),
      cmocka_unit_test(an_unlit_sky_says_nothing)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
