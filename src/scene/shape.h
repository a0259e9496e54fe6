/*
 * Intersections of rays with rotated boxes, spheres and rectangles, in double
 * precision.
 */
#ifndef HBIL_SHAPE_H
#define HBIL_SHAPE_H

#include <math.h>
#include <stdbool.h>

typedef struct vec3 {
  double x, y, z;
} vec3;

static inline vec3 vec(double x, double y, double z) {
  return (vec3){x, y, z};
}
static inline vec3 vec_add(vec3 a, vec3 b) {
  return vec(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline vec3 vec_sub(vec3 a, vec3 b) {
  return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline vec3 vec_scale(vec3 a, double s) {
  return vec(a.x * s, a.y * s, a.z * s);
}
static inline double vec_dot(vec3 a, vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline vec3 vec_cross(vec3 a, vec3 b) {
  return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z,
             a.x * b.y - a.y * b.x);
}
static inline vec3 vec_unit(vec3 a) {
  return vec_scale(a, 1.0 / sqrt(vec_dot(a, a)));
}

typedef enum shape_kind {
  SHAPE_BOX,      /* half: the three half extents */
  SHAPE_SPHERE,   /* half.x: the radius */
  SHAPE_RECTANGLE /* in its own x,y plane; half.z is not used */
} shape_kind;

typedef enum shape_pattern {
  PATTERN_PLAIN,   /* albedo[0] */
  PATTERN_CHECKER, /* squares of albedo[0] and albedo[1] in x, y */
  PATTERN_STRIPES  /* along z; on spheres along the longitude */
} shape_pattern;

typedef struct shape {
  shape_kind kind;
  vec3 centre;
  vec3 axis[3]; /* the shape's x, y, z in the world; unit, right-handed */
  vec3 half;
  shape_pattern pattern;
  double period; /* of the pattern: metres, radians on spheres */
  vec3 albedo[2];
  vec3 emission;
  bool casts; /* shadows; false for shapes that enclose the scene */
} shape;

/*
 * Whether the ray origin + t direction meets the shape at some t in (0, *t). If
 * so, *t becomes the smallest such t, and *normal, unless NULL, the unit normal
 * there, which may point to either side.  direction may have any length.
 */
bool shape_hit(const shape *s, vec3 origin, vec3 direction, double *t,
               vec3 *normal);

/* Transform a point from the world to the shape's coordinates, and back. */
vec3 shape_local(const shape *s, vec3 world);
vec3 shape_world(const shape *s, vec3 local);

/* Radius of the sphere around the centre that contains the shape. */
double shape_bound(const shape *s);

/* Albedo at a point of the surface, given in the shape's coordinates. */
vec3 shape_albedo(const shape *s, vec3 local);

#endif
