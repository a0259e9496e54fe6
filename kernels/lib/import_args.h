/*
 * import_args: arguments of the kernels that bring the caller's inputs into
 * planes of floats, and outputs out of them.
 */
#ifndef HBIL_IMPORT_ARGS_H
#define HBIL_IMPORT_ARGS_H

#include "shared.h"

/* An image and the plan's planes of floats (import.cl, export.cl).
 * is_direction: the image holds (v+1)/2 of each component v of a unit vector.
 * largest: the largest value that the image takes; export only. */
typedef struct hbil_image_args {
  hbil_plane_args planes;
  hbil_int width, height, channels;
  hbil_int is_direction;
  hbil_float largest;
} hbil_image_args;
HBIL_ASSERT_LAYOUT(hbil_image_args, largest, 6, 7)

/* normals_from_depth.cl */
typedef struct hbil_normals_args {
  hbil_view_args view;
  hbil_plane_args planes; /* of the normals */
  hbil_external_plane_args depth;
  hbil_depth_args decode;
} hbil_normals_args;
HBIL_ASSERT_LAYOUT(hbil_normals_args, decode, 14, 18)

#endif
