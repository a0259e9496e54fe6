/*
 * bounds: what the gather may leave out.  For cells of 64x64 pixels, blocks of
 * 256x256 and the whole picture: the largest inverse depth, and whether there
 * is light.  From it a strip of pixels knows that nothing in its reach stands
 * above its tangent planes, or that nothing there shines (gather.cl).
 *
 * Builds: ORTHOGRAPHIC, GATHER_RADIANCE, STORAGE.
 * In: split planes.  Out: grids of pairs of words (hbil_shared.h).
 * In a still frame whose light has not changed both kernels leave at once.
 */

/* Launch: x = cells across, y = rows of the layers: 4 rows of pixels. */
kernel void bound_rows(const hbil_layer_args in, global const float *split,
                       const hbil_bounds_args grids, global uint *bounds,
                       global const uint *flags, const int still) {
  const int cell = (int)get_global_id(0), y = (int)get_global_id(1);
  if (cell >= grids.row.width || y >= grids.row.height ||
      (still && !flags[HBIL_FLAG_CHANGED]))
    return;
  realv nearest = HBIL_NOTHING;
  intv lit = 0, dark = 0;
  split += in.origin + (uint)y * in.row + (uint)(cell * HBIL_CELL);
  for (int layer = 0; layer < HBIL_LAYERS; ++layer)
    for (int x = 0; x < HBIL_CELL; x += HBIL_WIDTH) {
      global const float *here = split + (uint)layer * in.layer + (uint)x;
      const realv w = LOADV(here);
      nearest = max(nearest, w);
#if GATHER_RADIANCE
      const intv shines = shining(here, in.plane);
      lit |= shines;
      dark |= (w > SKY) & !shines;
#endif
    }
  bounds += grids.row.offset + 2u * (uint)(y * grids.row.width + cell);
  bounds[0] = as_uint(lanes_max(nearest));
  bounds[1] =
      (ANY(lit) ? HBIL_SOME_LIT : 0u) | (ANY(dark) ? HBIL_SOME_DARK : 0u);
}

/* Launch: x, y = cells of the coarser grid, each of across x down finer ones.
 */
kernel void bound_cells(const hbil_grid_args fine, const hbil_grid_args coarse,
                        const int across, const int down, global uint *bounds,
                        global const uint *flags, const int still) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  if (x >= coarse.width || y >= coarse.height ||
      (still && !flags[HBIL_FLAG_CHANGED]))
    return;
  float nearest = HBIL_NOTHING;
  uint light = 0u;
  for (int j = y * down; j < min((y + 1) * down, fine.height); ++j)
    for (int i = x * across; i < min((x + 1) * across, fine.width); ++i) {
      global const uint *from =
          bounds + fine.offset + 2u * (uint)(j * fine.width + i);
      nearest = max(nearest, as_float(from[0]));
      light |= from[1];
    }
  bounds += coarse.offset + 2u * (uint)(y * coarse.width + x);
  bounds[0] = as_uint(nearest);
  bounds[1] = light;
}
