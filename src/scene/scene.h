/*
 * Procedural, ray-traced G-buffers: the scenes of the demo, the tests and the
 * benchmark.  They need no files and no OpenCL device, and are computed in
 * double precision.
 */
#ifndef HBIL_SCENE_H
#define HBIL_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "hbil/hbil.h"

typedef enum scene_kind {
  SCENE_ROOM =
      0, /* furnished room with an open side, coloured walls and a lamp */
  SCENE_SKY = 1, /* objects on a ground plane under open sky */
  /* closed room whose lamp, behind the camera, shines at the wall there */
  SCENE_CORNER = 2,
  SCENE_KINDS = 3
} scene_kind;

/* A G-buffer.  Every plane has width*height floats, top row first, and is
 * never NULL.  All planes are 0 at sky pixels. */
typedef struct scene_frame {
  uint32_t width, height;
  hbil_projection projection;
  hbil_camera camera; /* view space as in hbil.h: x right, y down, z forward */
  float *depth;       /* planar z, world units */
  float *normal[3];   /* unit length, world space, facing the eye */
  float *position[3]; /* world space */
  float *albedo[3];
  float *direct[3];   /* irradiance from the lamps only */
  float *emission[3]; /* radiance of visible lamps */
  float *motion[2];   /* previous minus current position, pixels */
  float *storage;     /* the allocation that all planes are part of */
} scene_frame;

/*
 * Renders frame `index`; the camera and one object move from frame to frame.
 * fov is the vertical field of view in radians; 0 means the scene's default.
 * Returns 0, or -1 and a zeroed *out if memory runs out.  The caller frees the
 * frame with scene_free().
 */
int scene_render(scene_kind kind, uint32_t width, uint32_t height, double fov,
                 uint32_t index, scene_frame *out);
/*
 * Renders the same scene with an orthographic camera.  It moves in the same way
 * but has another position, from which parallel rays show the scene well.  size
 * is the picture's width in world units; 0 means the scene's default.
 */
int scene_render_orthographic(scene_kind kind, uint32_t width, uint32_t height,
                              double size, uint32_t index, scene_frame *out);
/*
 * Renders what surrounds the camera of scene_render(): one of six square
 * pictures of 90 degrees from its place, along x, -x, y, -y, z and -z of the
 * world.  Motion is 0.
 */
enum { SCENE_FACES = 6 };
int scene_render_face(scene_kind kind, uint32_t size, int face, uint32_t index,
                      scene_frame *out);
/*
 * Renders what the scene's light shines at, in frame `index`: a square picture
 * from the middle of the lamp, or along the rays of the sun in SCENE_SKY.
 * Motion is 0.
 */
int scene_render_from_light(scene_kind kind, uint32_t size, uint32_t index,
                            scene_frame *out);
/* Frees the planes and zeroes the struct.  NULL is allowed. */
void scene_free(scene_frame *frame);

/* Radiance of a clear sky that suits both scenes, RGB.  The direction is in
 * world space and may have any length.  Below the horizon it is the radiance of
 * sunlit ground. */
void scene_sky(const double direction[3], float rgb[3]);

#endif
