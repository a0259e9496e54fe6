/* Vectors of three doubles. */
#ifndef HBIL_EXACT_VECTOR_H
#define HBIL_EXACT_VECTOR_H

#include <math.h>

#define PI 3.14159265358979323846

typedef struct vec3 {
  double x, y, z;
} vec3;

static inline vec3 vec(double x, double y, double z) {
  const vec3 v = {x, y, z};
  return v;
}

static inline double vec_dot(vec3 a, vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* a + s b */
static inline vec3 vec_add(vec3 a, double s, vec3 b) {
  return vec(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}

static inline vec3 vec_scale(double s, vec3 a) {
  return vec(s * a.x, s * a.y, s * a.z);
}

static inline double vec_length(vec3 a) {
  return sqrt(vec_dot(a, a));
}

static inline vec3 vec_normalize(vec3 a) {
  return vec_scale(1.0 / vec_length(a), a);
}

static inline double clamp(double v, double low, double high) {
  return v < low ? low : v > high ? high : v;
}

#endif
