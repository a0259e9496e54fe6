/*
 * The program's figure for how much of the light is a guess: a mean over the
 * surfaces of all written pixels, whatever stands for the sky.
 */
#include "test/support/compare.h"

#include "tool/unknown.h"

#include <math.h>
#include <string.h>

/* Computed pixels, with a border of one that isn't written. */
enum { WIDTH = 5, HEIGHT = 4, PIXELS = WIDTH * HEIGHT };

/* Three written pixels of one row: sky, and two surfaces. */
enum { FIRST = WIDTH + 1, SKY = FIRST, HALF = FIRST + 1, QUARTER = FIRST + 2 };

static const job cropped = {.window = {-1, -1, WIDTH, HEIGHT},
                            .shown = {0, 0, WIDTH - 2, 1},
                            .width = WIDTH,
                            .height = HEIGHT};

/* All surfaces but one, which is `sky`. */
static gbuffer depths_of(float surface, float sky) {
  gbuffer g;
  memset(&g, 0, sizeof g);
  channel_map_init(&g.map, DUMP_PLAIN);
  g.map.how = conventions_as_stored();
  g.map.count[ROLE_DEPTH] = 1;
  strcpy(g.map.names[ROLE_DEPTH][0], "Z");
  g.planes.width = WIDTH;
  g.planes.height = HEIGHT;
  image_plane *depth = image_add(&g.planes, "Z");
  assert_non_null(depth);
  for (int i = 0; i < PIXELS; ++i)
    depth->pixels[i] = i == SKY ? sky : surface;
  return g;
}

/* 1 where nothing is written, which must not count. */
static void fill_share(float share[PIXELS]) {
  for (int i = 0; i < PIXELS; ++i)
    share[i] = 1.0f;
  share[SKY] = 0.0f;
  share[HALF] = 0.5f;
  share[QUARTER] = 0.25f;
}

static void check_mean(gbuffer *g) {
  float share[PIXELS];
  timing_row row = {0};
  fill_share(share);
  unknown_measure(&cropped, g, share, &row);
  assert_int_equal(row.surfaces, 2);
  assert_true(row.unknown == 0.375);
  gbuffer_free(g);
}

TEST(only_written_surfaces_count) {
  gbuffer g = depths_of(1.0f, 0.0f);
  check_mean(&g);
  g = depths_of(1.0f, NAN);
  check_mean(&g);
  g = depths_of(-2.0f, 3.0f);
  g.map.how.backwards = 1;
  check_mean(&g);
  g = depths_of(50.0f, 1e9f);
  g.map.how.unit = 0.01;
  g.map.how.sky_depth = 1e9f;
  check_mean(&g);
}

TEST(without_the_layer_nothing_is_measured) {
  timing_row row = {.surfaces = 7, .unknown = 0.5};
  gbuffer g = depths_of(1.0f, 0.0f);
  unknown_measure(&cropped, &g, NULL, &row);
  assert_true(row.surfaces == 0 && row.unknown == 0.0);
  gbuffer_free(&g);
}

/* Each surface has the same weight; frames that weren't computed have none. */
TEST(frames_weigh_as_much_as_they_show) {
  const timing_row rows[] = {{.surfaces = 100, .unknown = 0.25},
                             {.surfaces = 0, .unknown = 0.0},
                             {.surfaces = 300, .unknown = 0.75}};
  size_t surfaces;
  assert_true(unknown_mean(rows, 3, &surfaces) == 0.625);
  assert_int_equal(surfaces, 400);
  assert_true(unknown_mean(rows + 1, 1, &surfaces) == 0.0);
  assert_int_equal(surfaces, 0);
}

/* Which settings leave light to a guess, and which layers show it. */
TEST(the_layer_is_asked_for_where_light_is_a_guess) {
  const unsigned ao = 1u << LAYER_AO, indirect = 1u << LAYER_INDIRECT;
  hbil_config c;
  hbil_config_init(&c);
  assert_false(layers_show_guesses(indirect, &c));
  c.model.far_field = HBIL_FAR_FRAME;
  assert_true(layers_show_guesses(indirect | ao, &c));
  assert_false(layers_show_guesses(ao, &c));
  c.model.far_field = HBIL_FAR_SH;
  c.model.facing_fade[1] = 0.0f;
  assert_true(layers_show_guesses(indirect, &c));
  c.model.back_facing_fallback = HBIL_FALLBACK_BLACK;
  assert_false(layers_show_guesses(indirect, &c));
  c.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  c.model.mode = HBIL_MODE_GTAO;
  assert_false(layers_show_guesses(indirect, &c));
}

int main(void) {
  return tests_run();
}
