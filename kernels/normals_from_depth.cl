/*
 * normals_from_depth: rebuilds normals, in view space and of any length, for
 * callers who have none.
 *
 * On a plane, w (lib/camera.clh) is affine in pixel coordinates, so its
 * gradient (a, b) per unit of ray slope gives the plane: with the pixel's ray
 * (rx, ry, 1) the normal is along (a, b, w - a rx - b ry), and along (a, b, 1)
 * in orthographic views (doc/method.md, section 21).
 *
 * Launch: x = groups of HBIL_WIDTH pixels of a row, y = rows.
 * In: the caller's depth.  Out: three planes, 0 at the sky.
 */
#include "lib/depth.clh"
#include "lib/import_args.h"
#include "lib/surface_slope.clh"

/* The vectors that hold the neighbours to one side. */
#define BESIDE ((SLOPE_REACH + HBIL_WIDTH - 1) / HBIL_WIDTH)

/* w of the pixels from (x, y) on, x a multiple of HBIL_WIDTH; HBIL_NOTHING at
 * the sky and outside the picture. */
INLINE realv w_of_pixels(const hbil_normals_args args,
                         global const void *buffer, int x, int y) {
  const hbil_view_args view = args.view;
  if (x < 0 || x >= view.width || y < 0 || y >= view.height)
    return HBIL_NOTHING;
  const realv depth =
      stored_depth(buffer, args.depth, args.decode, x, y, view.width - x);
  const realv z =
      planar_depth(depth, ray_x(view, x, 1), ray_y(view, y), args.decode);
  return select((realv)HBIL_NOTHING, w_of_depth(depth, z, args.decode),
                z > 0.0f);
}

kernel void normals_from_depth(const hbil_normals_args args,
                               global const void *depth,
                               global float *normals) {
  const hbil_view_args view = args.view;
  const int x = (int)get_global_id(0) * HBIL_WIDTH;
  const int y = (int)get_global_id(1);
  if (x >= view.width || y >= view.height)
    return;
  float row[(2 * BESIDE + 1) * HBIL_WIDTH];
  realv across[2 * SLOPE_REACH + 1], down[2 * SLOPE_REACH + 1];
#pragma unroll
  for (int i = -BESIDE; i <= BESIDE; ++i)
    STOREV(w_of_pixels(args, depth, x + i * HBIL_WIDTH, y),
           row + (BESIDE + i) * HBIL_WIDTH);
#pragma unroll
  for (int i = -SLOPE_REACH; i <= SLOPE_REACH; ++i) {
    across[SLOPE_REACH + i] = LOADV(row + BESIDE * HBIL_WIDTH + i);
    down[SLOPE_REACH + i] =
        i ? w_of_pixels(args, depth, x, y + i) : across[SLOPE_REACH];
  }
  /* Where an axis has no neighbour, the plane is at right angles to the ray as
   * seen along that axis.  In orthographic views rx and ry are 0. */
  const realv w = across[SLOPE_REACH], rx = ray_x(view, x, 1);
  const float ry = ray_y(view, y);
  const realv eye = w / fma(rx, rx, (realv)fma(ry, ry, 1.0f));
  const realv a = slope_along(across, eye * rx * view.inv_fx) * view.fx;
  const realv b = slope_along(down, eye * ry * view.inv_fy) * view.fy;
  const realv c =
      ORTHOGRAPHIC ? (realv)1.0f : fma(-a, rx, fma(-b, (realv)ry, w));
  /* The largest component becomes 1, so that no scale is too small or too large
   * for the length of a normal. */
  const realv inverse = -1.0f / max(fabs(a), max(fabs(b), fabs(c)));
  const realv n[3] = {a * inverse, b * inverse, c * inverse};
  global float *to = normals + (uint)y * args.planes.row + (uint)x;
#pragma unroll
  for (int i = 0; i < 3; ++i)
    STREAMV(select((realv)0.0f, n[i], w > SKY),
            to + (uint)i * args.planes.plane);
}
