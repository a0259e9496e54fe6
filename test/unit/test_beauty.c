/*
 * The layer beauty of `--beauty replace`, pixel by pixel: the frame's picture
 * without its diffuse indirect light, in the light that was computed.
 */
#include "test/support/compare.h"

#include "tool/beauty.h"
#include "tool/layers.h"

#include <math.h>
#include <string.h>

enum { PIXELS = 6 };

/* What a pixel's three channels have, in the same way. */
typedef struct pixel {
  float picture, albedo, theirs, ours, coverage, wanted;
} pixel;

static const pixel pixels[PIXELS] = {
    {2.0f, 0.5f, 1.0f, 3.0f, 1.0f, 3.0f}, /* brighter by .5 (3 - 1) */
    {2.0f, 0.5f, 3.0f, 1.0f, 1.0f, 1.0f},
    {2.0f, 0.0f, 1.0f, 3.0f, 1.0f, 2.0f},      /* a mirror stays */
    {0.1f, 0.5f, 1.0f, 0.0f, 1.0f, 0.0f},      /* noise, not below black */
    {-0.25f, 0.5f, 1.0f, 0.0f, 1.0f, -0.25f},  /* but for colours that are */
    {2.0f, 0.5f, INFINITY, 3.0f, 1.0f, 2.0f}}; /* nothing is known */

static void add(gbuffer *g, role r) {
  g->map.count[r] = role_channels(r);
  for (size_t c = 0; c < role_channels(r); ++c) {
    char *name = g->map.names[r][c];
    snprintf(name, sizeof g->map.names[r][c], "%s.%zu", role_name(r), c);
    assert_non_null(image_add(&g->planes, name));
  }
}

static gbuffer frame_of(const pixel *p, int premultiplied) {
  static const role roles[] = {ROLE_PICTURE, ROLE_ALBEDO, ROLE_INDIRECT,
                               ROLE_COVERAGE, ROLE_ALPHA};
  gbuffer g;
  memset(&g, 0, sizeof g);
  channel_map_init(&g.map, DUMP_PLAIN);
  g.map.how.premultiplied = premultiplied;
  g.planes.width = PIXELS;
  g.planes.height = 1;
  for (size_t i = 0; i < sizeof roles / sizeof *roles; ++i)
    add(&g, roles[i]);
  gbuffer_index(&g);
  for (size_t i = 0; i < PIXELS; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      gbuffer_plane(&g, ROLE_PICTURE, c)[i] = p[i].picture;
      gbuffer_plane(&g, ROLE_ALBEDO, c)[i] = p[i].albedo;
      gbuffer_plane(&g, ROLE_INDIRECT, c)[i] = p[i].theirs;
    }
    gbuffer_plane(&g, ROLE_COVERAGE, 0)[i] = p[i].coverage;
    gbuffer_plane(&g, ROLE_ALPHA, 0)[i] = (float)i / PIXELS;
  }
  return g;
}

static void check(const pixel *p, int premultiplied, unsigned layers,
                  unsigned hidden_layers) {
  gbuffer g = frame_of(p, premultiplied);
  image result, hidden;
  assert_int_equal(layers_image(layers, 0, PIXELS, 1, &result), 0);
  assert_int_equal(layers_image(hidden_layers, 0, PIXELS, 1, &hidden), 0);
  for (size_t c = 0; c < 3; ++c)
    for (size_t i = 0; i < PIXELS; ++i)
      layers_plane_of(&result, &hidden, LAYER_INDIRECT, c)[i] = p[i].ours;
  beauty_replace(&g, &hidden, &result);
  for (size_t c = 0; c < 3; ++c)
    for (size_t i = 0; i < PIXELS; ++i)
      assert_true(layers_plane(&result, LAYER_BEAUTY, c)[i] == p[i].wanted);
  const float *alpha = layers_plane(&result, LAYER_ALPHA, 0);
  assert_int_equal(alpha != NULL, layers >> LAYER_ALPHA & 1);
  for (size_t i = 0; alpha && i < PIXELS; ++i)
    assert_true(alpha[i] == (float)i / PIXELS);
  image_free(&hidden);
  image_free(&result);
  gbuffer_free(&g);
}

TEST(light_is_replaced) {
  const unsigned beauty = 1u << LAYER_BEAUTY, light = 1u << LAYER_INDIRECT;
  check(pixels, 0, beauty, light);
  check(pixels, 0, beauty | light, 0);
  check(pixels, 0, beauty | 1u << LAYER_ALPHA, light);
}

/* Such a picture has the share of the light that surfaces have of the pixel. */
TEST(premultiplied_albedo_counts_by_coverage) {
  pixel half[PIXELS];
  memcpy(half, pixels, sizeof half);
  for (size_t i = 0; i < PIXELS; ++i)
    half[i].coverage = 0.5f;
  half[0].wanted = 2.5f;
  half[1].wanted = 1.5f;
  check(half, 1, 1u << LAYER_BEAUTY, 1u << LAYER_INDIRECT);
}

int main(void) {
  return tests_run();
}
