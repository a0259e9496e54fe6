/*
 * clear: layers that hold "no surface" everywhere, padding included; once per
 * plan.  A program of its own, since it is the same for all plans.
 *
 * Launch: x = rows of layers, from the one above the first to the one below the
 * last.  Out: split planes.
 */
#include "shared.h"

kernel void clear_layers(const hbil_clear_args args, global float *layers) {
  const int at = (int)get_global_id(0);
  if (at >= HBIL_LAYERS * (args.layers.height + 2) || get_global_id(1) > 0)
    return;
  layers += (uint)(at / HBIL_LAYERS) * args.layers.row +
            (uint)(at % HBIL_LAYERS) * args.layers.layer;
  for (uint x = 0; x < args.layers.layer; ++x)
    layers[x] = x < args.layers.row_extent ? HBIL_NOTHING : 0.0f;
}
