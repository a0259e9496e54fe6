/*
 * clear: layers that hold nothing, padding included; once per plan.  A program
 * of its own, since it is the same for all plans.
 *
 * Launch: x = rows of layers, from the one above to the one below.
 * Out: split planes.
 */
kernel void clear_layers(global float *layers, const hbil_layer_args layout) {
  const int at = (int)get_global_id(0);
  if (at >= HBIL_LAYERS * (layout.height + 2) || get_global_id(1) > 0)
    return;
  layers += (uint)(at / HBIL_LAYERS) * layout.row +
            (uint)(at % HBIL_LAYERS) * layout.layer;
  for (uint x = 0; x < layout.layer; ++x)
    layers[x] = x < layout.row_extent ? HBIL_NOTHING : 0.0f;
}
