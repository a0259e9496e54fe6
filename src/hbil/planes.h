/* The caller's planes: their names, formats and places in the public structs.
 */
#ifndef HBIL_PLANES_H
#define HBIL_PLANES_H

#include <stdbool.h>

#include "hbil/hbil.h"
#include "names.h"
#include "plane_list.h"
#include "shared.h"

/* A set of planes has a bit for each. */
#define PLANE_BIT(plane) (1u << (plane))
#define INPUT_PLANES (PLANE_BIT(PLANE_FIRST_OUTPUT) - 1)

typedef struct plane_kind {
  const char *name;   /* as in hbil_config and hbil_frame */
  const char *define; /* prefix of its build defines */
  cl_uint channels;   /* of normals: of HBIL_NORMAL_XYZ */
  size_t format_at;   /* offset in hbil_config */
  size_t plane_at;    /* offset in hbil_frame */
} plane_kind;
extern const plane_kind plane_kinds[PLANE_COUNT];

/* The roundings of two values of a type, as the gather counts them (gather.c):
 * each is half a step of 2v-1, of which n bits have 2^n-1 in 2 (SNORM: 2 less),
 * and a half's are 2^-11 of itself each. */
#define ROUNDING_OF_BITS(n) (2.0f / (float)(1u << (n)))
#define ROUNDING_OF_HALF 0x1p-10f

enum { COMPONENT_COUNT = HBIL_SRGB8 + 1 };
typedef struct component_kind {
  const char *name;
  const char *type; /* in kernels/lib/components.clh */
  size_t size;      /* bytes; 1 for HBIL_NONE */
  bool is_word;     /* holds all channels of a pixel */
  float rounding;   /* of depths and normals; 0: no more than a float's */
} component_kind;
extern const component_kind component_kinds[COMPONENT_COUNT];

/* The components that a plane can have: the bit 1 << component for each. */
unsigned plane_components_allowed(const hbil_config *config, int plane);

/* Components of a pixel: the channels, or 1 for words that hold all of them. */
cl_uint plane_components(const hbil_config *config, int plane);

const hbil_plane_format *plane_format(const hbil_config *config, int plane);
const hbil_plane *frame_plane(const hbil_frame *frame, int plane);

/* Components from a pixel to the next: pixel_pitch, or its default. */
cl_uint format_stride(const hbil_config *config, int plane);

/* Bytes of a component; 1 for HBIL_NONE. */
size_t component_size(hbil_component component);

/* How the bytes of a plane lie behind its offset: in images (one for each
 * channel of planar formats, else one), each of rows, each of pixels, each of
 * some adjacent bytes. */
typedef struct plane_shape {
  size_t images, image; /* count, and bytes from one to the next */
  size_t rows, row;
  size_t pixels, pixel;
  size_t run; /* bytes of a pixel */
} plane_shape;
plane_shape plane_shape_of(const hbil_config *config, int plane,
                           const hbil_plane *given);

/* Bytes from the first to the last one of a row, and of the whole plane. */
size_t plane_row_extent(const plane_shape *shape);
size_t plane_extent(const plane_shape *shape);

/* A plane as a kernel takes it: its buffer, null where the plan has no format
 * for it, and its place in components. */
cl_mem plane_bind(const hbil_config *config, const hbil_frame *frame, int plane,
                  hbil_external_plane_args *args);

/* The rounding of a normal whose components have this one. */
float normal_rounding(const hbil_config *config, float component);

/* How kernels read the depth input of a frame. */
hbil_depth_args depth_args(const hbil_config *config, const hbil_frame *frame);

#endif
