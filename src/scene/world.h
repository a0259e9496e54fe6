/*
 * What stands in the scenes, and where, frame by frame.  World: metres, z up.
 */
#ifndef HBIL_WORLD_H
#define HBIL_WORLD_H

#include <stdint.h>

#include "scene.h"
#include "shape.h"

enum { WORLD_SHAPES = 32 };

/* A rectangle that shines from its front: the lamp, or a far-away sun. */
typedef struct world_light {
  vec3 centre;
  vec3 u, v; /* from the centre to the middles of two sides */
  vec3 normal;
  vec3 radiance;
} world_light;

/* Every frame of a scene has the same shapes in the same order. */
typedef struct world {
  shape shapes[WORLD_SHAPES];
  int count;
  world_light light;
  vec3 eye;
  vec3 right, down, forward; /* of the camera */
  double fov;                /* vertical, radians */
  double size;               /* across an orthographic picture */
} world;

void world_build(scene_kind kind, hbil_projection projection, uint32_t index,
                 world *out);

#endif
