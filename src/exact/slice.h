/* Half a slice of the hemisphere, its angles and their measure. */
#ifndef HBIL_EXACT_SLICE_H
#define HBIL_EXACT_SLICE_H

#include "exact/surface.h"

/* An angle from the direction to the eye, and what is needed of it. */
typedef struct angle {
  double theta, sine, cosine;
  double arc; /* theta - sine cosine */
} angle;

/* One half-slice of a pixel.  u: direction in the image plane, unit, z = 0. */
typedef struct half_slice {
  const surface *point;
  vec3 u, wo, along; /* wo: to the eye; along: D, perpendicular to it */
  double nx, ny;     /* the normal's components along D and wo */
  double weight;     /* J: slices are not equally spaced about wo */
  bool uniform;      /* directions count alike (HBAO), not by their cosine */
  /* The excess of the tangent plane over the surface (exact/march.c): 0 where
   * the shading normal is the surface's own. */
  double tangent;
  angle start;  /* of the tangent plane */
  double whole; /* measure up to it */
  double lobe;  /* k of exact/lobe.h */
} half_slice;

/* `point` is pointed at, not copied. */
half_slice exact_half_slice(const surface *point, double ux, double uy,
                            bool uniform, bool equal_weights);

/* A(a): the measure of the angles from wo to a. */
static inline double exact_measure(const half_slice *h, angle a) {
  if (h->uniform)
    return 1.0 - a.cosine;
  return h->nx / 2.0 * a.arc + h->ny / 2.0 * a.sine * a.sine;
}
/* The integral of direction times solid angle over the same angles, per unit of
 * azimuth: the unnormalized bent normal. */
vec3 exact_bent_integral(const half_slice *h, angle a);
/* The angle of a point `distance` along u, in units of the ray's slope, whose w
 * is `excess` times that above the surface. */
angle exact_horizon(const half_slice *h, double distance, double excess);

#endif
