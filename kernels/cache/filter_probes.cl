/*
 * filter_probes: each probe's functions become means with those around it, on
 * surfaces alike, so that a probe has the rays of up to nine.
 *
 * Launch: x = columns of probes, y = rows.  In and out: HBIL_PROBE_FLOATS
 * floats a probe.
 */
#include "lib/cache_args.h"
#include "lib/camera.clh"

/* How much a probe is like another: its place is near the other's plane, and it
 * faces the same way. */
INLINE float likeness(const hbil_view_args view, global const float *probe,
                      global const float *other) {
  const float3 p = vload3(0, probe + HBIL_PROBE_POSITION);
  const float3 n = vload3(0, probe + HBIL_PROBE_NORMAL);
  const float3 m = vload3(0, other + HBIL_PROBE_NORMAL);
  const float unit =
      ORTHOGRAPHIC ? (float)view.width * view.inv_fx : max(p.z, FLT_MIN);
  const float off = dot(vload3(0, other + HBIL_PROBE_POSITION) - p, n) /
                    (HBIL_PROBE_TOLERANCE * unit);
  const float near = 1.0f / fma(off, off, 1.0f);
  float facing = max(dot(n, m), 0.0f);
  facing *= facing;
  facing *= facing;
  return other[HBIL_PROBE_VALID] * facing * facing * near * near;
}

kernel void filter_probes(const hbil_probes_args args,
                          global const float *probes, global float *filtered) {
  const hbil_probe_grid_args grid = args.grid;
  const int column = (int)get_global_id(0), row = (int)get_global_id(1);
  if (column >= grid.columns || row >= grid.rows)
    return;
  const int number = row * grid.columns + column;
  global const float *probe = probes + HBIL_PROBE_FLOATS * number;
  global float *to = filtered + HBIL_PROBE_FLOATS * number;
  const float4 place = vload4(0, probe), normal = vload4(1, probe);
  float4 sum[5] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  float total = 0.0f;
  for (int j = max(row - 1, 0); j <= min(row + 1, grid.rows - 1); ++j)
    for (int i = max(column - 1, 0); i <= min(column + 1, grid.columns - 1);
         ++i) {
      global const float *other =
          probes + HBIL_PROBE_FLOATS * (j * grid.columns + i);
      const float weight =
          i == column && j == row ? place.w : likeness(args.view, probe, other);
      total += weight;
      for (int k = 0; k < 5; ++k)
        sum[k] += weight * vload4(2 + k, other);
    }
  const float share = total > 0.0f ? 1.0f / total : 0.0f;
  vstore4(place, 0, to);
  vstore4(normal, 1, to);
  for (int k = 0; k < 5; ++k)
    vstore4(share * sum[k], 2 + k, to);
}
