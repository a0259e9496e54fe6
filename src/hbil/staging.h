/* Staged planes: inputs and outputs that the passes don't read or write where
 * the caller has them.  A staged plane has a buffer of the plan's, planar and
 * of floats, which the passes take for the caller's plane.  The pass `import`
 * fills those of inputs, and `export` copies outputs from there.  Staged are
 * images, and normals that are rebuilt from depth. */
#ifndef HBIL_STAGING_H
#define HBIL_STAGING_H

#include "context.h"
#include "planes.h"

/* Sets of planes, a bit for each. */
typedef struct staging {
  unsigned planes; /* all that are staged */
  unsigned images; /* those that are the caller's images */
} staging;

/* Finds the staged planes of a checked configuration and gives them the format
 * that the passes see.  Fails if there are images and the device has none. */
hbil_status stage_planes(hbil_context *context, hbil_config *config,
                         staging *out);

/* How kernels read and write components of a type.  rounding: as in
 * component_kind. */
typedef struct texel_type {
  cl_channel_type type;
  bool is_unorm;
  float largest; /* the largest value that can be written */
  float rounding;
} texel_type;

/* NULL: kernels can't read such images as floats. */
const texel_type *texel_type_of(const cl_image_format *format);

/* That the size and the format of an image suit that plane. */
hbil_status check_image(hbil_context *context, const hbil_config *config,
                        const staging *staged, int plane, cl_mem image);

#endif
