/*
 * filter_probes: averages each probe's functions with those of the probes
 * around it on the same surface, so that it has the rays of up to sixty-one.
 *
 * Launch: x = columns of probes, y = lines.  In and out: HBIL_PROBE_FLOATS
 * floats a probe.
 */
#include "lib/probe_grid.clh"
#include "lib/probe_likeness.clh"

/* The weight of a probe that is so many cells away. */
INLINE float tent(float columns, float rows) {
  const float reach = 1.0f / (float)HBIL_PROBE_TILE;
  return max(1.0f - reach * fabs(columns), 0.0f) *
         max(1.0f - reach * fabs(rows), 0.0f);
}

kernel void filter_probes(const hbil_probes_args args,
                          global const float *probes, global float *filtered) {
  const hbil_probe_grid_args grid = args.grid;
  const int column = (int)get_global_id(0), line = (int)get_global_id(1);
  if (!has_probe(grid, column, line))
    return;
  const int reach = HBIL_PROBE_TILE - 1;
  const uint number = probe_number(grid, column, line);
  global const float *probe = probes + HBIL_PROBE_FLOATS * number;
  global float *to = filtered + HBIL_PROBE_FLOATS * number;
  const float4 place = vload4(0, probe), normal = vload4(1, probe);
  const int first = place.w > 0.0f ? max(line - 2 * reach - 1, 0) : grid.lines;
  float4 sum[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  float total = 0.0f;
  for (int j = first; j <= min(line + 2 * reach + 1, grid.lines - 1); ++j) {
    const float shift =
        0.5f * (float)(is_inside_cell(j) - is_inside_cell(line));
    for (int i = max(column - reach - (shift > 0.0f), 0);
         i <= min(column + reach + (shift < 0.0f), grid.columns - 1); ++i) {
      global const float *other =
          probes + HBIL_PROBE_FLOATS * probe_number(grid, i, j);
      if (!(other[HBIL_PROBE_VALID] > 0.0f))
        continue;
      /* the probe itself counts, whatever its normal */
      const float alike = i == column && j == line
                              ? 1.0f
                              : likeness(args.view, place.xyz, normal.xyz,
                                         vload3(0, other + HBIL_PROBE_POSITION),
                                         vload3(0, other + HBIL_PROBE_NORMAL));
      const float weight =
          alike * tent((float)(i - column) + shift, 0.5f * (float)(j - line));
      total += weight;
      for (int k = 0; k < 6; ++k)
        sum[k] += weight * vload4(2 + k, other);
    }
  }
  const float share = total > 0.0f ? 1.0f / total : 0.0f;
  vstore4(place, 0, to);
  vstore4(normal, 1, to);
  for (int k = 0; k < 6; ++k)
    vstore4(share * sum[k], 2 + k, to);
}
