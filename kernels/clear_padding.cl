/*
 * clear_padding: the padding of layers.
 *
 * Launch: x = rows of layers, from the one above the first to the one below the
 * last.  Out: split or gathered planes.  What the picture's pixels have may
 * change as well: the last row and the last column of each layer.
 */
#include "shared.h"

/* Columns from `from` on. */
static void clear_columns(global float *plane, uint from, uint to,
                          float value) {
  for (uint x = from; x < to; ++x)
    plane[x] = value;
}

kernel void clear_padding(const hbil_clear_args args, global float *layers) {
  const hbil_layer_args l = args.layers;
  const int at = (int)get_global_id(0), y = at / HBIL_LAYERS;
  if (at >= HBIL_LAYERS * (l.height + 2) || get_global_id(1) > 0)
    return;
  /* the last row of some layers is not in the picture */
  const bool all = y == 0 || y >= l.height;
  global float *row =
      layers + (uint)y * l.row + (uint)(at % HBIL_LAYERS) * l.layer;
  /* the last column of some layers isn't, either */
  const uint last = args.span + (uint)max(l.width - 1, 0);
  for (uint plane = 0; plane < l.layer; plane += l.plane) {
    const float value = plane ? 0.0f : args.nothing;
    clear_columns(row + plane, 0, all ? l.row_extent : args.span, value);
    if (!all)
      clear_columns(row + plane, last, l.row_extent, value);
  }
}
