/* Decides by the pixels of a first frame what its names left unsure. */
#include "dump/settle.h"

#include "dump/lamps.h"
#include "dump/normal_fit.h"
#include "dump/read_gbuffer.h"
#include "image/error.h"

#include <math.h>
#include <string.h>

/* Two values that renderers store where there is no surface: the largest half
 * float, or a very large number. */
static const float largest_half = 65504.0f, very_far = 1e9f;

/* If all depths are negative, they count backwards. */
static void settle_sky(const gbuffer *stored, conventions *how, findings *out) {
  const float *depth = gbuffer_plane(stored, ROLE_DEPTH, 0);
  float low = INFINITY, high = -INFINITY;
  const size_t pixels = (size_t)stored->planes.width * stored->planes.height;
  if (!depth || how->depth == DEPTH_DEVICE || how->depth == DEPTH_REVERSED)
    return;
  for (size_t i = 0; i < pixels; i++)
    if (isfinite(depth[i])) {
      low = fminf(low, depth[i]);
      high = fmaxf(high, depth[i]);
    }
  how->backwards = low < 0.0f && high <= 0.0f;
  const float most = how->backwards ? -low : high;
  if (how->backwards)
    findings_add(out, "depth counts backwards, all of it being negative");
  if (most == largest_half || most >= very_far) {
    how->sky_depth = most == largest_half ? most : very_far;
    findings_add(out, "depths of %g are sky (--sky-depth)", (double)most);
  }
}

static void settle_encoding(const gbuffer *stored, conventions *how,
                            findings *out) {
  const size_t pixels = (size_t)stored->planes.width * stored->planes.height;
  size_t encoded = 0, some = 0;
  for (size_t i = 0; i < pixels; i++) {
    double n[3];
    for (size_t c = 0; c < 3; c++)
      n[c] = (double)gbuffer_plane(stored, ROLE_NORMAL, c)[i];
    some += matrix3_dot(n, n) > 0.0;
    encoded += normal_looks_encoded(n);
  }
  how->encoded = some > 0 && encoded > some / 10 * 9;
  if (how->encoded)
    findings_add(out, "normals are stored as (n+1)/2 (--normals)");
}

/* Decides which kind of depth the normals fit and in which space they are. */
static int settle_fit(const char *path, channel_map *map, findings *out,
                      image_error *error) {
  gbuffer g;
  if (gbuffer_read(path, map, 1u << ROLE_DEPTH | 1u << ROLE_NORMAL, &g,
                   error) != 0)
    return -1;
  const surface_points s = surface_points_of(&g, &map->camera);
  const normal_fit f = normal_fit_measure(&s);
  const matrix3 as_told = surface_view_from_normals(&s);
  const matrix3 camera = normal_fit_view_if(&f, SPACE_CAMERA, 0);
  if (map->how.unsure & UNSURE_NORMALS && map->how.normals == SPACE_WORLD &&
      map->how.flips == 0 && f.count >= NORMAL_FIT_LEAST &&
      normal_fit_cosine(&f, &f.planar, &camera) >
          normal_fit_cosine(&f, &f.planar, &as_told) + 0.1) {
    map->how.normals = SPACE_CAMERA;
    findings_add(out, "normals are in camera space, where they fit the depth "
                      "(--normals)");
  }
  const matrix3 h = map->how.normals == g.map.how.normals ? as_told : camera;
  if (map->how.unsure & UNSURE_DEPTH && map->how.depth == DEPTH_PLANAR &&
      f.count >= NORMAL_FIT_LEAST && normal_fit_is_other_depth(&f, &h)) {
    map->how.depth = DEPTH_RAY;
    findings_add(out, "depth is the distance from the eye, as which it fits "
                      "the normals (--depth)");
  }
  gbuffer_free(&g);
  return 0;
}

/* Decides which pixels of direct light show lamps, and tells what else is seen
 * in it. */
static int settle_lamps(const char *path, channel_map *map, findings *out,
                        image_error *error) {
  const unsigned roles = 1u << ROLE_DEPTH | 1u << ROLE_NORMAL |
                         1u << ROLE_ALBEDO | 1u << ROLE_DIRECT |
                         1u << ROLE_COVERAGE;
  channel_map shown = *map;
  gbuffer g;
  shown.how.shows_sources = 0;
  shown.how.direct = DIRECT_LIGHT; /* radiance as it is */
  shown.count[ROLE_EMISSION] = 0;
  if (gbuffer_read(path, &shown, roles, &g, error) != 0)
    return -1;
  map->how.lamps_from = lamps_find(&g);
  if (map->how.lamps_from > 0.0f)
    findings_add(out,
                 "direct light shows lamps, which are taken out of it "
                 "(hide_emitters leaves them out; --map emission= takes them "
                 "for lit surfaces)");
  gbuffer_free(&g);
  return 0;
}

int conventions_settle(const char *path, channel_map *map, findings *out,
                       image_error *error) {
  const unsigned unsure = map->how.unsure;
  gbuffer stored;
  memset(out, 0, sizeof *out);
  for (size_t i = 0; i < sizeof map->picked / sizeof *map->picked; i++)
    if (map->picked[i][0])
      findings_add(out, "%s", map->picked[i]);
  if (!unsure)
    return 0;
  if (gbuffer_read_as_stored(path, map, 1u << ROLE_DEPTH | 1u << ROLE_NORMAL,
                             &stored, error) != 0)
    return -1;
  if (unsure & UNSURE_SKY)
    settle_sky(&stored, &map->how, out);
  if (unsure & UNSURE_NORMALS)
    settle_encoding(&stored, &map->how, out);
  gbuffer_free(&stored);
  if (unsure & (UNSURE_DEPTH | UNSURE_NORMALS) &&
      settle_fit(path, map, out, error) != 0)
    return -1;
  return unsure & UNSURE_LAMPS ? settle_lamps(path, map, out, error) : 0;
}
