/*
 * filter_probes: each probe's functions become means with those around it, on
 * surfaces alike, so that a probe has the rays of up to twenty-five.
 *
 * Launch: x = columns of probes, y = rows.  In and out: HBIL_PROBE_FLOATS
 * floats a probe.
 */
#include "lib/probe_likeness.clh"

/* The weight of a probe that is so far away in the grid. */
INLINE float tent(int columns, int rows) {
  const float reach = 1.0f / (float)HBIL_PROBE_TILE;
  return (1.0f - reach * (float)abs(columns)) *
         (1.0f - reach * (float)abs(rows));
}

kernel void filter_probes(const hbil_probes_args args,
                          global const float *probes, global float *filtered) {
  const hbil_probe_grid_args grid = args.grid;
  const int column = (int)get_global_id(0), row = (int)get_global_id(1);
  if (column >= grid.columns || row >= grid.rows)
    return;
  const int reach = HBIL_PROBE_TILE - 1;
  const int number = row * grid.columns + column;
  global const float *probe = probes + HBIL_PROBE_FLOATS * number;
  global float *to = filtered + HBIL_PROBE_FLOATS * number;
  const float4 place = vload4(0, probe), normal = vload4(1, probe);
  float4 sum[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  float total = 0.0f;
  for (int j = max(row - reach, 0); j <= min(row + reach, grid.rows - 1); ++j)
    for (int i = max(column - reach, 0);
         i <= min(column + reach, grid.columns - 1); ++i) {
      global const float *other =
          probes + HBIL_PROBE_FLOATS * (j * grid.columns + i);
      /* the probe itself counts, whatever its normal */
      const float alike = i == column && j == row
                              ? 1.0f
                              : likeness(args.view, place.xyz, normal.xyz,
                                         vload3(0, other + HBIL_PROBE_POSITION),
                                         vload3(0, other + HBIL_PROBE_NORMAL));
      const float weight =
          other[HBIL_PROBE_VALID] * alike * tent(i - column, j - row);
      total += weight;
      for (int k = 0; k < 6; ++k)
        sum[k] += weight * vload4(2 + k, other);
    }
  const float share = total > 0.0f ? 1.0f / total : 0.0f;
  vstore4(place, 0, to);
  vstore4(normal, 1, to);
  for (int k = 0; k < 6; ++k)
    vstore4(share * sum[k], 2 + k, to);
}
