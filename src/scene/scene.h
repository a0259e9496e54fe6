/*
 * A procedural, ray-traced G-buffer: the scenes that the demo, the tests and
 * the bench stand on.  Needs no files and no GPU; double precision inside.
 */
#ifndef HBIL_SCENE_H
#define HBIL_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "hbil/hbil.h"

typedef enum scene_kind {
  SCENE_ROOM = 0, /* furnished room with an open side, coloured walls, lamp */
  SCENE_SKY = 1,  /* objects on a ground plane under open sky */
  SCENE_KINDS = 2
} scene_kind;

/* All planes: width*height floats each, top row first, NULL-free. Sky pixels:
 * depth 0, everything else 0. */
typedef struct scene_frame {
  uint32_t width, height;
  hbil_projection projection;
  hbil_camera camera; /* hbil's convention: x right, y down, z forward */
  float *depth;       /* planar z; sky: 0 */
  float *normal[3];   /* unit, world space, facing the eye */
  float *position[3]; /* world space */
  float *albedo[3];
  float *direct[3];   /* irradiance of the lamps (and nothing else) */
  float *emission[3]; /* radiance of visible lamps */
  float *motion[2];   /* previous - current pixel position, x right, y down */
  float *storage;     /* the one allocation behind all planes */
} scene_frame;

/*
 * Renders frame `index` (the camera moves with it; one object moves as well).
 * fov: vertical field of view in radians (0: the scene's own).
 * Returns 0, or -1 when out of memory (then *out is zeroed).
 */
int scene_render(scene_kind kind, uint32_t width, uint32_t height, double fov,
                 uint32_t index, scene_frame *out);
/*
 * The same through an orthographic camera, which moves likewise but stands
 * where parallel rays show the scene well. size: world units across the
 * picture's width (0: the scene's own).
 */
int scene_render_orthographic(scene_kind kind, uint32_t width, uint32_t height,
                              double size, uint32_t index, scene_frame *out);
void scene_free(scene_frame *frame);

/* Radiance of a clear sky that suits both scenes, in a world direction of any
 * length; below the horizon, that of sunlit ground. */
void scene_sky(const double direction[3], float rgb[3]);

#endif
