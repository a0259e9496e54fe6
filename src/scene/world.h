/*
 * The shapes, lights and cameras of the scenes, frame by frame.  The world is
 * in metres, with z up.
 */
#ifndef HBIL_WORLD_H
#define HBIL_WORLD_H

#include <stdint.h>

#include "scene.h"
#include "shape.h"

enum { WORLD_SHAPES = 32 };

/* A rectangle that emits light from its front: a lamp, or a distant sun. */
typedef struct world_light {
  vec3 centre;
  vec3 u, v; /* from the centre to the middles of two sides */
  vec3 normal;
  vec3 radiance;
} world_light;

/* One frame.  All frames of a scene have the same shapes in the same order. */
typedef struct world {
  shape shapes[WORLD_SHAPES];
  int count;
  world_light light;
  vec3 eye;
  vec3 right, down, forward; /* of the camera */
  double fov;                /* vertical, radians */
  double size;               /* width of an orthographic picture, metres */
} world;

/* Turns the camera along x, -x, y, -y, z or -z, with 90 degrees each way. */
void world_face(world *w, int face);

/* Puts the camera into the middle of the lamp; or, for an orthographic picture,
 * far above the middle of the scene, where it looks along the sun's rays. */
void world_from_light(world *w, hbil_projection projection);

/* Builds frame `index` of a scene. */
void world_build(scene_kind kind, hbil_projection projection, uint32_t index,
                 world *out);

#endif
