/*
 * What a cache takes from saved bytes.  A hash finds damage, but whoever makes
 * a file can make its hash, too.  The kernels trust voxels: a normal that is
 * not a number would make the light of a whole frame one.
 */
#include "voxel_repair.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "lib/cache_args.h"
#include "shared.h"

/* The limits are beyond all that injections and bounces make, and rounding. */

/* Radiance of a surface: its emission, and 1/pi of its direct light. */
#define MOST_SENT (2.0f * HBIL_BRIGHTEST)
/* The series of all bounces is at most 20 times the first one (bounce.cl). */
#define MOST_INDIRECT (50.0f * HBIL_BRIGHTEST)
/* Means of unit normals; inject.cl stores none whose square is below 1e-4. */
#define LEAST_NORMAL 0.9e-4f
#define MOST_NORMAL 1.1f
/* Means of reflectances up to 1, with their roundings. */
#define MOST_REFLECTANCE 1.001f
/* In voxels of the finest level: the half diagonal of a voxel of the coarsest
 * one is .87 x 8. */
#define MOST_OFFSET 8.0f

/* Not-a-numbers are never inside. */
static bool is_inside(float value, float least, float most) {
  return value >= least && value <= most;
}

static void repair_plane(float *voxel) {
  const float *n = voxel + HBIL_VOXEL_NORMAL;
  const float length2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  if (!is_inside(length2, LEAST_NORMAL, MOST_NORMAL)) {
    const float up[3] = {0.0f, 0.0f, 1.0f};
    memcpy(voxel + HBIL_VOXEL_NORMAL, up, sizeof up);
  }
  if (!is_inside(voxel[HBIL_VOXEL_OFFSET], -MOST_OFFSET, MOST_OFFSET))
    voxel[HBIL_VOXEL_OFFSET] = 0.0f;
}

static void repair_light(float *light, float most) {
  for (int c = 0; c < 3; ++c)
    if (!is_inside(light[c], 0.0f, most))
      light[c] = 0.0f;
}

/* HBIL_VOXEL_BEFORE */
static bool is_light_before(float value) {
  cl_uint bits;
  memcpy(&bits, &value, sizeof bits);
  return value == 0.0f || value == -1.0f ||
         (is_inside(value, 0.99f * HBIL_VOXEL_LEAST_LIGHT, 3.0f * MOST_SENT) &&
          bits & HBIL_VOXEL_MOMENT_VIEWS);
}

static void repair_voxel(float *voxel) {
  static const float zero[HBIL_VOXEL_FLOATS] = {0};
  float *reflectance = voxel + HBIL_VOXEL_REFLECTANCE;
  /* most voxels are empty */
  if (!memcmp(voxel, zero, sizeof zero))
    return;
  repair_plane(voxel);
  for (int c = 0; c < 3; ++c)
    if (!is_inside(reflectance[c], 0.0f, MOST_REFLECTANCE))
      reflectance[c] = reflectance[c] > 1.0f ? 1.0f : 0.0f;
  if (!is_inside(voxel[HBIL_VOXEL_WEIGHT], 0.0f, HBIL_CACHE_MOST_VIEWS))
    voxel[HBIL_VOXEL_WEIGHT] = 0.0f;
  if (!is_inside(voxel[HBIL_VOXEL_LIGHT_WEIGHT], -HBIL_CACHE_MOST_VIEWS,
                 HBIL_CACHE_MOST_VIEWS))
    voxel[HBIL_VOXEL_LIGHT_WEIGHT] = 0.0f;
  repair_light(voxel + HBIL_VOXEL_SENT, MOST_SENT);
  repair_light(voxel + HBIL_VOXEL_INDIRECT, MOST_INDIRECT);
  if (!is_light_before(voxel[HBIL_VOXEL_BEFORE]))
    voxel[HBIL_VOXEL_BEFORE] = 0.0f;
}

void voxels_repair(float *voxels, size_t count) {
  for (size_t i = 0; i < count; ++i)
    repair_voxel(voxels + i * HBIL_VOXEL_FLOATS);
}
