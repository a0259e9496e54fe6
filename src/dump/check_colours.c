/* Checks that colours are linear and that direct light is direct light. */
#include "dump/check_colours.h"

#include <math.h>

/*
 * Whether the values come from eight bits a channel, which are sRGB by all
 * habits.  Nearly all of them are then multiples of 1/255, and many different
 * ones occur.  Of other values one in seven is a multiple to the 0.07 that half
 * floats leave.
 */
static int is_eight_bit(const gbuffer *g, role r) {
  const size_t pixels = (size_t)g->planes.width * g->planes.height;
  unsigned char seen[256] = {0};
  size_t values = 0, whole = 0;
  int levels = 0;
  for (size_t c = 0; c < g->map.count[r]; c++) {
    const float *v = gbuffer_plane(g, r, c);
    for (size_t i = 0; i < pixels; i++) {
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
  const size_t pixels = width * s->g->planes.height;
  size_t sky = 0, with_light = 0;
  for (size_t i = 0; i < pixels; i++) {
    if (surface_depth(s, i % width, i / width) > 0.0)
      continue;
    sky++;
    for (size_t c = 0; c < s->g->map.count[ROLE_DIRECT]; c++)
      if (gbuffer_plane(s->g, ROLE_DIRECT, c)[i] > 0.0f) {
        with_light++;
        break;
      }
  }
  return sky > pixels / 100 && with_light > sky / 2;
}

void check_colours(const surface_points *s, findings *out) {
  static const role roles[] = {ROLE_ALBEDO, ROLE_DIRECT};
  const channel_map *map = &s->g->map;
  for (size_t k = 0; k < 2; k++)
    if (!map->gamma[roles[k]] && is_eight_bit(s->g, roles[k]))
      findings_add(
          out,
          "%s has whole parts of 255, as pictures with eight bits a channel "
          "have, which are gamma-encoded: --colours srgb",
          role_name(roles[k]));
  if (map->is_beauty || lights_sky(s))
    findings_add(
        out, "direct light is that of a finished picture, whose indirect light "
             "would count twice: --map direct= with a pass of direct diffuse "
             "light, or with nothing");
}
