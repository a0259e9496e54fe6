/*
 * What surfaces of an area of the radiance cache send on average, by the side
 * that they face: light of rays that end in what no view has seen.
 */
#include <math.h>
#include <string.h>

#include "exact/cache.h"

int exact_cache_areas_across(const exact_cache *cache, int step) {
  const int beyond = step < cache->levels ? 0 : step - cache->levels + 1;
  return cache->voxels / HBIL_AREA_VOXELS >> beyond;
}

/* Adds a surface to what faces along +x -x +y -y +z -z. */
static void add_surface(const exact_voxel *voxel, double sum[6][4]) {
  const vec3 n = vec_normalize(vec(voxel->value[HBIL_VOXEL_NORMAL],
                                   voxel->value[HBIL_VOXEL_NORMAL + 1],
                                   voxel->value[HBIL_VOXEL_NORMAL + 2]));
  const double cosine[6] = {n.x, -n.x, n.y, -n.y, n.z, -n.z};
  for (int i = 0; i < 6; ++i) {
    const double weight = fmax(0.0, cosine[i]);
    for (int c = 0; c < 3; ++c)
      sum[i][c] += weight * voxel->radiance[c];
    sum[i][3] += weight;
  }
}

void exact_cache_area(const exact_cache *cache, int step, const int area[3],
                      double sum[6][4]) {
  const int level = step < cache->levels ? step : cache->levels - 1;
  const int size = HBIL_AREA_VOXELS << (step - level);
  memset(sum, 0, 24 * sizeof(double));
  for (int i = 0; i < size * size * size; ++i) {
    const int at[3] = {i % size, i / size % size, i / size / size};
    exact_place place = {.level = level};
    for (int k = 0; k < 3; ++k)
      place.cell[k] = size * area[k] + at[k] - cache->voxels / 2;
    const exact_voxel *voxel = exact_cache_at(cache, &place);
    if (voxel->state == HBIL_VOXEL_SURFACE)
      add_surface(voxel, sum);
  }
}

bool exact_cache_local_light(const exact_cache *cache, vec3 p, vec3 d,
                             double light[3]) {
  const double at[3] = {p.x, p.y, p.z}, way[3] = {d.x, d.y, d.z};
  for (int step = 0;; ++step) {
    const int across = exact_cache_areas_across(cache, step);
    const double size = ldexp(HBIL_AREA_VOXELS, step);
    double sum[6][4], facing[4] = {0.0, 0.0, 0.0, 0.0};
    bool inside = true;
    int area[3];
    if (across < 1)
      return false;
    for (int k = 0; k < 3; ++k) {
      inside = inside && fabs(at[k]) < 0.5 * size * across;
      /* just below the border the sum may round up to it */
      area[k] = (int)fmin(floor(at[k] / size + 0.5 * across), across - 1);
    }
    if (!inside)
      continue;
    exact_cache_area(cache, step, area, sum);
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 4; ++c)
        facing[c] += fabs(way[k]) * sum[2 * k + (way[k] > 0.0)][c];
    if (!(facing[3] >= (double)HBIL_AREA_LEAST))
      continue;
    for (int c = 0; c < 3; ++c)
      light[c] = facing[c] / facing[3];
    return true;
  }
}
