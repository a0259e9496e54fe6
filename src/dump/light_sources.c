/* Lamps and sky in a picture of direct light. */
#include "dump/light_sources.h"

#include "dump/surface_points.h"
#include "image/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Pixels from a source that its filtered picture may reach: renderers' filters
 * have radii of at most 2 pixels. */
enum { REACH = 2 };

/* Coverage below which a pixel shows something behind its surface, too. */
static const float whole = 0.999f;

/* What a pixel shows. */
typedef enum content { SURFACE = 0, SOURCE, MIXTURE } content;

static float brightest(const gbuffer *g, size_t i) {
  float most = 0.0f;
  for (size_t c = 0; c < g->map.count[ROLE_DIRECT]; c++)
    most = fmaxf(most, gbuffer_plane(g, ROLE_DIRECT, c)[i]);
  return most;
}

/* Radiance over albedo, the largest channel; infinite where nothing reflects,
 * so that any radiance is emitted. */
static float brightest_light(const gbuffer *g, size_t i) {
  float most = 0.0f;
  for (size_t c = 0; c < g->map.count[ROLE_DIRECT]; c++) {
    const float *albedo = gbuffer_plane(g, ROLE_ALBEDO, c);
    const float radiance = gbuffer_plane(g, ROLE_DIRECT, c)[i];
    if (radiance > 0.0f)
      most = fmaxf(most, radiance / (albedo ? albedo[i] : 1.0f));
  }
  return most;
}

static float coverage_of(const gbuffer *g, size_t i) {
  const float *coverage = gbuffer_plane(g, ROLE_COVERAGE, 0);
  return coverage ? coverage[i] : 1.0f;
}

/* ------------------------------------------------------------------------ */
/* Neighbours                                                                */

/* The pixels within REACH of pixel i, as a range of columns and rows. */
typedef struct block {
  size_t left, right, top, bottom;
} block;

static block around(const gbuffer *g, size_t i) {
  const size_t width = g->planes.width, height = g->planes.height;
  const size_t x = i % width, y = i / width;
  return (block){
      x < REACH ? 0 : x - REACH, x + REACH >= width ? width - 1 : x + REACH,
      y < REACH ? 0 : y - REACH, y + REACH >= height ? height - 1 : y + REACH};
}

static int is_near_source(const gbuffer *g, const unsigned char *shown,
                          size_t i) {
  const block b = around(g, i);
  for (size_t y = b.top; y <= b.bottom; y++)
    for (size_t x = b.left; x <= b.right; x++)
      if (shown[y * g->planes.width + x] == SOURCE)
        return 1;
  return 0;
}

/* The mean of a plane over those neighbours that show nothing but a surface; 0
 * without any. */
static float mean_around(const gbuffer *g, const unsigned char *shown,
                         const float *plane, size_t i) {
  const block b = around(g, i);
  double sum = 0.0;
  size_t count = 0;
  for (size_t y = b.top; y <= b.bottom; y++)
    for (size_t x = b.left; x <= b.right; x++) {
      const size_t at = y * g->planes.width + x;
      if (shown[at] == SURFACE) {
        sum += (double)plane[at];
        count++;
      }
    }
  return count ? (float)(sum / (double)count) : 0.0f;
}

/* ------------------------------------------------------------------------ */
/* Taking sources out of direct light                                        */

/* Where there is no coverage, edges may show what is behind them. */
static void classify(const gbuffer *g, unsigned char *shown) {
  const surface_points s = surface_points_of(g, &g->map.camera);
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const float lamps_from = g->map.how.lamps_from;
  for (size_t i = 0; i < gbuffer_pixels(g); i++) {
    const int surface = surface_is_shown(&s, depth[i]);
    const float light = surface ? brightest_light(g, i) : 0.0f;
    const int lamp = isinf(light) || (lamps_from > 0.0f && light >= lamps_from);
    shown[i] = lamp || (!surface && brightest(g, i) > 0.0f) ? SOURCE : SURFACE;
  }
  for (size_t i = 0; i < gbuffer_pixels(g); i++) {
    const int edge = !g->map.count[ROLE_COVERAGE] || lamps_from > 0.0f ||
                     coverage_of(g, i) < whole;
    if (shown[i] == SURFACE && edge && is_near_source(g, shown, i))
      shown[i] = surface_is_shown(&s, depth[i]) ? MIXTURE : SURFACE;
  }
}

/* The albedo is already divided by the coverage. */
static float irradiance(const gbuffer *g, size_t c, size_t i) {
  const float *albedo = gbuffer_plane(g, ROLE_ALBEDO, c);
  const float *direct = gbuffer_plane(g, ROLE_DIRECT, c);
  const float a = (albedo ? albedo[i] : 1.0f) *
                  (g->map.how.premultiplied ? coverage_of(g, i) : 1.0f);
  return a > 0.0f ? direct[i] / a : 0.0f;
}

static void split_channel(gbuffer *g, const unsigned char *shown, size_t c,
                          float *emission) {
  float *direct = gbuffer_plane(g, ROLE_DIRECT, c);
  for (size_t i = 0; i < gbuffer_pixels(g); i++) {
    emission[i] = shown[i] == SOURCE ? direct[i] : 0.0f;
    direct[i] = shown[i] == SURFACE ? irradiance(g, c, i) : 0.0f;
  }
  for (size_t i = 0; i < gbuffer_pixels(g); i++)
    if (shown[i] == MIXTURE)
      direct[i] = mean_around(g, shown, direct, i);
}

int light_sources_split(gbuffer *g) {
  unsigned char *shown = calloc(gbuffer_pixels(g), sizeof *shown);
  if (!shown)
    return -1;
  classify(g, shown);
  for (size_t c = 0; c < 3; c++) {
    char *name = g->map.names[ROLE_EMISSION][c];
    snprintf(name, sizeof g->map.names[ROLE_EMISSION][c], "%s.%zu",
             role_name(ROLE_EMISSION), c);
    const image_plane *added = image_add(&g->planes, name);
    if (!added) {
      free(shown);
      return -1;
    }
    split_channel(g, shown, c, added->pixels);
  }
  g->map.count[ROLE_EMISSION] = 3;
  free(shown);
  return 0;
}
