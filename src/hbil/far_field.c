/* Far light: spherical harmonics of order 2. */
#include "far_field.h"

#include "camera.h"
#include "checks.h"
#include "context.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Constants of the real orthonormal basis, in hbil_frame's order. */
static const double basis[9] = {
    0.28209479177387814, 0.48860251190291992, 0.48860251190291992,
    0.48860251190291992, 1.0925484305920792,  1.0925484305920792,
    0.31539156525252005, 1.0925484305920792,  0.54627421529603959};

static void evaluate(const double d[3], double out[9]) {
  const double x = d[0], y = d[1], z = d[2];
  const double polynomial[9] = {
      1, y, z, x, x * y, y * z, 3 * z * z - 1, z * x, x * x - y * y};
  for (int i = 0; i < 9; ++i)
    out[i] = basis[i] * polynomial[i];
}

hbil_environment_args far_field_args(const hbil_config *config,
                                     const float environment[9][3]) {
  hbil_environment_args args;
  memset(&args, 0, sizeof args);
  if (config->model.far_field == HBIL_FAR_CONSTANT ||
      config->model.far_field == HBIL_FAR_FRAME)
    for (int c = 0; c < 3; ++c)
      args.channel[c].sh[0] = environment[0][c];
  if (config->model.far_field == HBIL_FAR_SH)
    for (int i = 0; i < 9; ++i) {
      /* irradiance of order l over a full hemisphere, per unit of radiance
       * (Ramamoorthi and Hanrahan 2001) */
      const double order = i == 0 ? pi : i < 4 ? 2 * pi / 3 : pi / 4;
      for (int c = 0; c < 3; ++c)
        args.channel[c].sh[i] = (float)(order * basis[i] * environment[i][c]);
    }
  return args;
}

void remove_exposure(float exposure, float environment[9][3]) {
  const float per_exposure = 1.0f / light_exposure(exposure);
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      environment[i][c] *= per_exposure;
}

hbil_environment_args far_radiance_args(hbil_far_field far_field,
                                        const float environment[9][3]) {
  hbil_environment_args args;
  memset(&args, 0, sizeof args);
  for (int c = 0; c < 3; ++c) {
    if (far_field == HBIL_FAR_CONSTANT)
      args.channel[c].sh[0] = environment[0][c];
    for (int i = 0; far_field == HBIL_FAR_SH && i < 9; ++i)
      args.channel[c].sh[i] = (float)(basis[i] * (double)environment[i][c]);
  }
  return args;
}

/* The world direction of a map's texel, `v`, `u` in [0,1]. */
static void direction(double u, double v, const float *world_from_map,
                      double out[3]) {
  const double azimuth = (0.5 - u) * 2 * pi;
  const double map[3] = {sin(pi * v) * cos(azimuth), sin(pi * v) * sin(azimuth),
                         cos(pi * v)};
  for (int r = 0; r < 3; ++r) {
    out[r] = world_from_map ? 0 : map[r];
    for (int c = 0; world_from_map && c < 3; ++c)
      out[r] += (double)world_from_map[3 * r + c] * map[c];
  }
}

static hbil_status check_rotation(const float world_from_map[9]) {
  double m[16] = {[15] = 1};
  for (int i = 0; i < 9; ++i)
    m[4 * (i / 3) + i % 3] = (double)world_from_map[i];
  char text[RIGID_ERROR_SIZE];
  const char *error = rigid_error(m, text);
  return error ? fail(NULL, HBIL_INVALID_ARGUMENT,
                      "hbil_environment_from_latlong: world_from_map: not a "
                      "rotation, mirrored or not: %s",
                      error)
               : HBIL_SUCCESS;
}

hbil_status hbil_environment_from_latlong(const float *rgb, size_t width,
                                          size_t height, size_t row_pitch,
                                          const float world_from_map[9],
                                          float environment[9][3]) {
  if (!rgb || !environment)
    return fail_null(NULL, __func__, rgb ? "environment" : "rgb");
  const size_t pixel = 3 * sizeof *rgb;
  const size_t row_size = width <= SIZE_MAX / pixel ? width * pixel : 0;
  if (row_pitch == 0)
    row_pitch = row_size;
  if (!row_size || !height || height > SIZE_MAX / row_pitch)
    return fail(NULL, HBIL_INVALID_ARGUMENT,
                "hbil_environment_from_latlong: width, height: %zu, %zu; a map "
                "has at least one pixel, and at most %zu bytes",
                width, height, SIZE_MAX);
  if (row_pitch < row_size || row_pitch % sizeof *rgb)
    return fail(NULL, HBIL_INVALID_ARGUMENT,
                "hbil_environment_from_latlong: row_pitch: %zu; must be a "
                "multiple of %zu bytes, and at least the %zu of a row",
                row_pitch, sizeof *rgb, row_size);
  const hbil_status status =
      world_from_map ? check_rotation(world_from_map) : HBIL_SUCCESS;
  if (status != HBIL_SUCCESS)
    return status;
  double sum[9][3] = {{0}};
  for (size_t y = 0; y < height; ++y) {
    const float *row = rgb + y * (row_pitch / sizeof *rgb);
    /* exact area of a texel of this row on the sphere */
    const double area = 2 * pi / (double)width *
                        (cos(pi * (double)y / (double)height) -
                         cos(pi * (double)(y + 1) / (double)height));
    for (size_t x = 0; x < width; ++x) {
      double d[3], value[9];
      direction(((double)x + 0.5) / (double)width,
                ((double)y + 0.5) / (double)height, world_from_map, d);
      evaluate(d, value);
      for (int c = 0; c < 3; ++c) {
        const double light = (double)row[3 * x + (size_t)c];
        if (!(light >= 0) || isinf(light))
          continue; /* NaN, negative, infinite: no light */
        for (int i = 0; i < 9; ++i)
          sum[i][c] += area * light * value[i];
      }
    }
  }
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      environment[i][c] = (float)sum[i][c];
  return HBIL_SUCCESS;
}
