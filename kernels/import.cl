/*
 * import: an image -> planes of floats, which the passes read in its place.
 *
 * Launch: x = columns, y = rows.
 * In: the image; texels are read as they are, without a filter.  Out:
 * `channels` planes.
 */
#include "lib/import_args.h"

kernel void import_image(const hbil_image_args args, read_only image2d_t image,
                         global float *planes) {
  const int x = (int)get_global_id(0), y = (int)get_global_id(1);
  if (x >= args.width || y >= args.height)
    return;
  const float4 texel = read_imagef(image, (int2)(x, y));
  const float value[4] = {texel.x, texel.y, texel.z, texel.w};
  global float *to = planes + (uint)y * args.planes.row + (uint)x;
  for (int c = 0; c < args.channels; ++c)
    to[(uint)c * args.planes.plane] =
        args.is_direction ? fma(2.0f, value[c], -1.0f) : value[c];
}
