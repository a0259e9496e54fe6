/* Checks that colours are linear and that direct light is direct light. */
#include "dump/check_colours.h"

#include <math.h>

/*
 * Whether the values come from eight bits a channel, which are sRGB by all
 * habits.  Nearly all of them are then multiples of 1/255, and many different
 * ones occur.  Of other values one in seven is a multiple to the 0.07 that half
 * floats leave.
 */
static int is_eight_bit(const surface_points *s, role r) {
  const gbuffer *g = s->g;
  unsigned char seen[256] = {0};
  size_t values = 0, whole = 0;
  int levels = 0;
  for (size_t c = 0; c < g->map.count[r]; c++) {
    const float *v = gbuffer_plane(g, r, c);
    for (size_t i = 0; i < gbuffer_pixels(g); i = surface_next(s, i)) {
      const double parts = (double)v[i] * 255.0;
      if (!(parts >= 8.0 && parts <= 255.5))
        continue;
      values++;
      whole += fabs(parts - round(parts)) < 0.07;
      seen[(int)round(parts)] = 1;
    }
  }
  for (int i = 0; i < 256; i++)
    levels += seen[i];
  return levels >= 32 && (double)whole > 0.99 * (double)values;
}

/* Whether the sky has direct light.  A pass of diffuse light is black there. */
static int lights_sky(const surface_points *s) {
  const size_t width = s->g->planes.width;
  size_t sky = 0, with_light = 0;
  for (size_t i = 0; i < gbuffer_pixels(s->g); i = surface_next(s, i)) {
    if (surface_depth(s, i % width, i / width) > 0.0)
      continue;
    sky++;
    for (size_t c = 0; c < s->g->map.count[ROLE_DIRECT]; c++)
      if (gbuffer_plane(s->g, ROLE_DIRECT, c)[i] > 0.0f) {
        with_light++;
        break;
      }
  }
  return sky > surface_looks(s) / 100 && with_light > sky / 2;
}

/* Whether a surface's pixel reflects light diffusely, and sends no light. */
static int reflects(const gbuffer *g, size_t i, float least) {
  float albedo = g->map.count[ROLE_ALBEDO] ? 0.0f : 1.0f, emission = 0.0f;
  for (size_t c = 0; c < 3; c++) {
    const float *a = gbuffer_plane(g, ROLE_ALBEDO, c);
    const float *e = gbuffer_plane(g, ROLE_EMISSION, c);
    albedo = a ? fmaxf(albedo, a[i]) : albedo;
    emission = e ? fmaxf(emission, e[i]) : emission;
  }
  return albedo > least && !(emission > 0.0f);
}

static int is_covered(const gbuffer *g, size_t i) {
  const float *coverage = gbuffer_plane(g, ROLE_COVERAGE, 0);
  return !coverage || coverage[i] > 0.999f;
}

/* Says once that metal and glass, which have no diffuse albedo, come out black.
 */
static void check_black(const surface_points *s, findings *out) {
  const gbuffer *g = s->g;
  const size_t width = g->planes.width;
  size_t surfaces = 0, black = 0;
  for (size_t i = 0; i < gbuffer_pixels(g); i = surface_next(s, i))
    if (surface_depth(s, i % width, i / width) > 0.0 && is_covered(g, i)) {
      float emission = 0.0f;
      for (size_t c = 0; c < g->map.count[ROLE_EMISSION]; c++)
        emission = fmaxf(emission, gbuffer_plane(g, ROLE_EMISSION, c)[i]);
      surfaces++;
      black += !(emission > 0.0f) && !reflects(g, i, 1e-3f);
    }
  const int replaced =
      g->map.count[ROLE_PICTURE] && g->map.count[ROLE_INDIRECT];
  if (black > surfaces / 100 && !replaced)
    findings_add(out,
                 "%.0f %% of the surfaces have no diffuse albedo, as metal and "
                 "glass, and are black in beauty: add the renderer's glossy "
                 "and transmission passes to it, or put its picture and its "
                 "diffuse indirect light into the file (--beauty)",
                 100.0 * (double)black / (double)surfaces);
}

/* Whether no surface is dark.  Direct light leaves a part of nearly every place
 * in the dark, and all light together none.  Under a sky there is no
 * difference.
 */
static int lights_everything(const surface_points *s) {
  const gbuffer *g = s->g;
  const size_t width = g->planes.width;
  double roots = 0.0;
  size_t surfaces = 0, dark = 0, sky = 0;
  for (int pass = 0; pass < 2; pass++) {
    const double root = surfaces ? roots / (double)surfaces : 0.0;
    for (size_t i = 0; i < gbuffer_pixels(g); i = surface_next(s, i)) {
      double light = 0.0;
      if (!(surface_depth(s, i % width, i / width) > 0.0)) {
        sky += !pass;
        continue;
      }
      if (!is_covered(g, i) || !reflects(g, i, 0.02f))
        continue;
      for (size_t c = 0; c < g->map.count[ROLE_DIRECT]; c++)
        light += (double)fmaxf(0.0f, gbuffer_plane(g, ROLE_DIRECT, c)[i]);
      /* a hundredth of the typical light is dark */
      dark += pass && light < 0.01 * root * root;
      surfaces += !pass;
      roots += pass ? 0.0 : sqrt(light);
    }
  }
  return roots > 0.0 && 20 * sky < surface_looks(s) && 500 * dark < surfaces;
}

void check_colours(const surface_points *s, int is_lit, findings *out) {
  static const role roles[] = {ROLE_ALBEDO, ROLE_DIRECT};
  const channel_map *map = &s->g->map;
  for (size_t k = 0; k < 2; k++)
    if (!map->gamma[roles[k]] && is_eight_bit(s, roles[k]))
      findings_add(
          out,
          "%s has whole parts of 255, as pictures with eight bits a channel "
          "have, which are gamma-encoded%s",
          role_name(roles[k]),
          roles[k] == ROLE_ALBEDO || !map->floats[roles[k]]
              ? ": --colours srgb"
              : " and end at 1: write the renderer's own floats");
  if (is_lit && map->count[ROLE_ALBEDO])
    check_black(s, out);
  if (map->how.shows_sources && lights_everything(s))
    findings_add(
        out, "no surface is dark in direct light, as in a finished picture, "
             "whose indirect light would count twice: if it is that of "
             "another integrator than `direct`, --map direct= leaves it out");
  if (map->is_beauty || lights_sky(s))
    findings_add(
        out, "direct light is that of a finished picture, whose indirect light "
             "would count twice: --map direct= with a pass of direct diffuse "
             "light, or with nothing");
}
