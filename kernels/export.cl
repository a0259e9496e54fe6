/*
 * export: planes of floats, which the passes have written -> an image.
 * Channels of the image that have no plane become 0, and alpha becomes 1.
 *
 * Launch: x = columns, y = rows.
 * In: `channels` planes.  Out: the image.
 */
#include "lib/import_args.h"

kernel void export_image(const hbil_image_args args, global const float *planes,
                         write_only image2d_t image) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  if (x >= args.width || y >= args.height)
    return;
  const uint at = (uint)y * args.planes.row + (uint)x;
  float value[3] = {0.0f, 0.0f, 0.0f};
  for (int c = 0; c < args.channels; ++c) {
    const float v = planes[(uint)c * args.planes.plane + at];
    value[c] = args.is_direction ? fma(0.5f, v, 0.5f)
                                 : min(max(v, -args.largest), args.largest);
  }
  write_imagef(image, (int2)(x, y),
               (float4)(value[0], value[1], value[2], 1.0f));
}
