/*
 * bounds: what the gather can leave out.
 *
 * For cells of 64x64 pixels, blocks of 256x256 and the whole picture, the
 * kernels compute the largest inverse depth, and whether there is light.  From
 * these a span of the gather knows that nothing in its reach rises above its
 * tangent planes, or that nothing there sends light (gather/skip.clh).  A cell
 * counts as dark if at least a quarter of the groups are dark of which it is
 * made; in kernels of single pixels, a quarter of its row blocks, each of which
 * is dark by the same rule.  With fewer, asking every sample whether it sends
 * light costs as much as it saves.
 *
 * For each block they compute in which of the quadrants around it there is
 * light.  Half-slices in the other quadrants gather no light.
 *
 * In: what split notes about groups of pixels.  Out: grids of pairs of words
 * (shared.h); quadrants.  In a static frame whose light has not changed, the
 * kernels return at once.
 */
#include "lib/quadrants.clh"

/* Launch: x, y = cells of the coarse grid. */
kernel void bound_cells(const hbil_bound_cells_args args, global uint *bounds,
                        global const uint *flags) {
  const hbil_grid_args fine = args.fine, coarse = args.coarse;
  const int across = args.across, down = args.down;
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  if (x >= coarse.width || y >= coarse.height ||
      (args.is_static && !flags[HBIL_FLAG_CHANGED]))
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
kernel void bound_quadrants(const hbil_bound_quadrants_args args,
                            global uint *bounds, global const uint *flags) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  const hbil_grid_args blocks = args.bounds.block;
  if (x >= blocks.width || y >= blocks.height ||
      (args.is_static && !flags[HBIL_FLAG_CHANGED]))
    return;
  uint quadrants = 0u;
  for (int j = 0; j < blocks.height; ++j)
    for (int i = 0; i < blocks.width; ++i)
      if (bounds[blocks.offset + 2u * (uint)(j * blocks.width + i) + 1u] &
          HBIL_SOME_LIT)
        quadrants |= hbil_quadrants(x, y, i, j);
  bounds[args.bounds.quadrants + (uint)(y * blocks.width + x)] = quadrants;
}
