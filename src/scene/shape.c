#include "shape.h"

#include <stddef.h>

static vec3 turn_in(const shape *s, vec3 d) {
  return vec(vec_dot(s->axis[0], d), vec_dot(s->axis[1], d),
             vec_dot(s->axis[2], d));
}

static vec3 turn_out(const shape *s, vec3 d) {
  return vec_add(
      vec_scale(s->axis[0], d.x),
      vec_add(vec_scale(s->axis[1], d.y), vec_scale(s->axis[2], d.z)));
}

vec3 shape_local(const shape *s, vec3 world) {
  return turn_in(s, vec_sub(world, s->centre));
}

vec3 shape_world(const shape *s, vec3 local) {
  return vec_add(s->centre, turn_out(s, local));
}

double shape_bound(const shape *s) {
  if (s->kind == SHAPE_SPHERE)
    return s->half.x;
  if (s->kind == SHAPE_RECTANGLE)
    return hypot(s->half.x, s->half.y);
  return sqrt(vec_dot(s->half, s->half));
}

static bool sphere_hit(const shape *s, vec3 origin, vec3 direction, double *t,
                       vec3 *normal) {
  vec3 o = vec_sub(origin, s->centre);
  double a = vec_dot(direction, direction), b = vec_dot(o, direction);
  /* The discriminant comes from the distance between centre and ray, because
   * this form loses no digits if the origin is far away. */
  vec3 nearest = vec_sub(o, vec_scale(direction, b / a));
  double r = s->half.x, q = (r * r - vec_dot(nearest, nearest)) / a;
  if (q < 0.0)
    return false;
  double root = sqrt(q), hit = -b / a - root;
  if (hit <= 0.0)
    hit = -b / a + root;
  if (hit <= 0.0 || hit >= *t)
    return false;
  *t = hit;
  if (normal != NULL)
    *normal = vec_unit(vec_add(o, vec_scale(direction, hit)));
  return true;
}

static bool rectangle_hit(const shape *s, vec3 origin, vec3 direction,
                          double *t, vec3 *normal) {
  vec3 o = vec_sub(origin, s->centre);
  double hit = -vec_dot(s->axis[2], o) / vec_dot(s->axis[2], direction);
  if (!(hit > 0.0 && hit < *t)) /* false for NaN, which parallel rays give */
    return false;
  vec3 p = vec_add(o, vec_scale(direction, hit));
  if (fabs(vec_dot(s->axis[0], p)) > s->half.x ||
      fabs(vec_dot(s->axis[1], p)) > s->half.y)
    return false;
  *t = hit;
  if (normal != NULL)
    *normal = s->axis[2];
  return true;
}

/* Narrows the range [enter, leave] of t to the slab |o + t d| <= half.  axis[0]
 * is set to `number` if this slab determines the entry, axis[1] if it
 * determines the exit. */
static void clip_slab(double o, double d, double half, int number,
                      double range[2], int axis[2]) {
  if (d == 0.0) {
    if (fabs(o) > half)
      range[1] = -HUGE_VAL;
    return;
  }
  double inverse = 1.0 / d, side = d > 0.0 ? half : -half;
  double enter = (-side - o) * inverse, leave = (side - o) * inverse;
  if (enter > range[0]) {
    range[0] = enter;
    axis[0] = number;
  }
  if (leave < range[1]) {
    range[1] = leave;
    axis[1] = number;
  }
}

static bool box_hit(const shape *s, vec3 origin, vec3 direction, double *t,
                    vec3 *normal) {
  vec3 o = shape_local(s, origin), d = turn_in(s, direction);
  double range[2] = {-HUGE_VAL, HUGE_VAL};
  int axis[2] = {0, 0};
  clip_slab(o.x, d.x, s->half.x, 0, range, axis);
  clip_slab(o.y, d.y, s->half.y, 1, range, axis);
  clip_slab(o.z, d.z, s->half.z, 2, range, axis);
  if (range[0] > range[1])
    return false;
  int side = range[0] > 0.0 ? 0 : 1; /* 1: the ray starts inside */
  if (range[side] <= 0.0 || range[side] >= *t)
    return false;
  *t = range[side];
  if (normal != NULL)
    *normal = s->axis[axis[side]];
  return true;
}

bool shape_hit(const shape *s, vec3 origin, vec3 direction, double *t,
               vec3 *normal) {
  switch (s->kind) {
  case SHAPE_BOX:
    return box_hit(s, origin, direction, t, normal);
  case SHAPE_SPHERE:
    return sphere_hit(s, origin, direction, t, normal);
  case SHAPE_RECTANGLE:
    return rectangle_hit(s, origin, direction, t, normal);
  }
  return false;
}

static bool odd(double cells) {
  return fmod(floor(cells), 2.0) != 0.0;
}

vec3 shape_albedo(const shape *s, vec3 local) {
  bool second = false;
  if (s->pattern == PATTERN_CHECKER)
    second = odd(local.x / s->period) != odd(local.y / s->period);
  else if (s->pattern == PATTERN_STRIPES && s->kind == SHAPE_SPHERE)
    second = odd(atan2(local.y, local.x) / s->period);
  else if (s->pattern == PATTERN_STRIPES)
    second = odd(local.z / s->period);
  return s->albedo[second];
}
