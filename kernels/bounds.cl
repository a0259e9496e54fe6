/*
 * bounds: what the gather may leave out.  For cells of 64x64 pixels, blocks of
 * 256x256 and the whole picture: the largest inverse depth, and whether there
 * is light.  From it a span of pixels knows that nothing in its reach stands
 * above its tangent planes, or that nothing there shines (gather.cl).  Dark is
 * what has a quarter of dark parts at least: to ask every sample whether it
 * shines takes as long as it spares where one in four does not.  From each
 * block, in which quadrants of the picture there is light: half-slices that
 * lie in others have none.
 *
 * In: what split says of groups of pixels.  Out: grids of pairs of words
 * (hbil_shared.h); quadrants.
 * In a still frame whose light has not changed the kernel leaves at once.
 */

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
  uint lit = 0u, dark = 0u, all = 0u;
  for (int j = y * down; j < min((y + 1) * down, fine.height); ++j)
    for (int i = x * across; i < min((x + 1) * across, fine.width); ++i) {
      global const uint *from =
          bounds + fine.offset + 2u * (uint)(j * fine.width + i);
      nearest = max(nearest, as_float(from[0]));
      lit |= from[1] & HBIL_SOME_LIT;
      dark += (from[1] & HBIL_SOME_DARK) / HBIL_SOME_DARK;
      ++all;
    }
  bounds += coarse.offset + 2u * (uint)(y * coarse.width + x);
  bounds[0] = as_uint(nearest);
  bounds[1] = lit | (4u * dark >= all ? HBIL_SOME_DARK : 0u);
}

/* Launch: x, y = blocks. */
kernel void bound_quadrants(const hbil_bounds_args b, global uint *bounds,
                            global const uint *flags, const int still) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  const hbil_grid_args blocks = b.block;
  if (x >= blocks.width || y >= blocks.height ||
      (still && !flags[HBIL_FLAG_CHANGED]))
    return;
  uint quadrants = 0u;
  for (int j = 0; j < blocks.height; ++j)
    for (int i = 0; i < blocks.width; ++i)
      if (bounds[blocks.offset + 2u * (uint)(j * blocks.width + i) + 1u] &
          HBIL_SOME_LIT)
        quadrants |= hbil_quadrants(x, y, i, j);
  bounds[b.quadrants + (uint)(y * blocks.width + x)] = quadrants;
}
