/* How large a place is. */
#include "tool/extent.h"

#include "dump/gbuffer.h"
#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"
#include "image/quantile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Distances from a centre. */
typedef struct extent {
  double centre[3];
  double *distances; /* owned */
  size_t count, room;
} extent;

/* Pixels of a picture, about, that are looked at, and frames at most. */
enum { LOOKS = 4096, FRAMES_MEASURED = 8 };

/* All but this share of the surfaces lie inside, since single far ones would
 * make voxels too wide for all others. */
static const double most_surfaces = 0.995;

static int make_room(extent *e, size_t more) {
  if (e->count + more <= e->room)
    return 0;
  const size_t room = 2 * (e->count + more);
  double *grown = realloc(e->distances, room * sizeof *grown);
  if (!grown)
    return -1;
  e->distances = grown;
  e->room = room;
  return 0;
}

/* Writes the places of a picture's surfaces in the world to `out`, some
 * thousand of them, and returns how many.  step: between the pixels that are
 * looked at. */
static size_t find_places(const gbuffer *g, size_t step, double (*out)[3]) {
  const hbil_camera *camera = &g->map.camera;
  const surface_points points = surface_points_of(g, camera);
  const double *m = camera->world_from_view;
  size_t count = 0;
  for (size_t y = step / 2; y < g->planes.height; y += step)
    for (size_t x = step / 2; x < g->planes.width; x += step) {
      double p[3], sum = 0.0;
      if (!(surface_depth(&points, x, y) > 0.0))
        continue;
      surface_point(&points, x, y, 0, p);
      for (int r = 0; r < 3; r++) {
        out[count][r] = m[4 * r] * p[0] + m[4 * r + 1] * p[1] +
                        m[4 * r + 2] * p[2] + m[4 * r + 3];
        sum += out[count][r];
      }
      count += isfinite(sum) ? 1u : 0u;
    }
  return count;
}

int extent_places(const extent_picture *p, double (**out)[3], size_t *count,
                  image_error *error) {
  gbuffer g;
  *out = NULL;
  if (gbuffer_read(p->path, p->map, 1u << ROLE_DEPTH, &g, error) != 0)
    return -1;
  const size_t step =
      (size_t)fmax(1.0, sqrt((double)gbuffer_pixels(&g) / LOOKS));
  *out = malloc((g.planes.width / step + 1) * (g.planes.height / step + 1) *
                sizeof **out);
  if (*out)
    *count = find_places(&g, step, *out);
  gbuffer_free(&g);
  return *out ? 0 : image_no_memory(error, p->path);
}

/* Half the width of a cube about the centre that holds nearly all surfaces; 0:
 * there are none. */
static double extent_radius(extent *e) {
  return e->count ? quantile(e->distances, e->count, most_surfaces) : 0.0;
}

static void extent_free(extent *e) {
  free(e->distances);
  e->distances = NULL;
  e->count = e->room = 0;
}

/* ------------------------------------------------------------------------ */
/* The extent of a cache                                                     */

/* Adds what a picture shows. */
static int measure(extent *e, const extent_picture *p, image_error *error) {
  double(*places)[3];
  size_t count;
  if (extent_places(p, &places, &count, error) != 0)
    return -1;
  const int failed =
      make_room(e, count) != 0 ? image_no_memory(error, p->path) : 0;
  for (size_t i = 0; i < count && !failed; i++) {
    double farthest = 0.0;
    for (int r = 0; r < 3; r++)
      farthest = fmax(farthest, fabs(places[i][r] - e->centre[r]));
    e->distances[e->count++] = farthest;
  }
  free(places);
  return failed;
}

static void find_centre(const extent_picture *frames, size_t count,
                        double out[3]) {
  for (int r = 0; r < 3; r++) {
    out[r] = 0.0;
    for (size_t i = 0; i < count; i++)
      out[r] +=
          frames[i].map->camera.world_from_view[4 * r + 3] / (double)count;
  }
}

/* The width of a voxel of the first level so that the last level reaches so
 * far.  Two of its voxels remain at each side, for the rounding of the middle.
 * Without any surface the size doesn't matter.  The limits are those of
 * hbil_cache_config. */
static double voxel_size(double radius, const hbil_cache_config *config) {
  const double widest = radius / (0.5 * config->voxels - 2.0);
  const double size = ldexp(widest, 1 - (int)config->levels);
  return radius > 0.0 ? fmin(fmax(size, 1e-6), 1e6) : 1.0;
}

int extent_choose(const extent_picture *frames, size_t count,
                  const extent_picture *views, size_t view_count,
                  hbil_cache_config *config, image_error *error) {
  extent e = {.count = 0};
  const size_t step = (count + FRAMES_MEASURED - 1) / FRAMES_MEASURED;
  int failed = 0;
  find_centre(frames, count, e.centre);
  for (size_t i = 0; i < count && !failed; i += step)
    failed = measure(&e, &frames[i], error);
  for (size_t i = 0; i < view_count && !failed; i++)
    failed = measure(&e, &views[i], error);
  const double radius = extent_radius(&e);
  extent_free(&e);
  if (failed)
    return -1;
  memcpy(config->centre, e.centre, sizeof e.centre);
  config->voxel_size = voxel_size(radius, config);
  return 0;
}
