/*
 * Whether a frame's normals fit its depth.
 *
 * The gradients of the depth give normals of their own.  Let A be the sum over
 * pixels of g n^T, with g the gradient's unit normal in view space and n that
 * of the file.  If an orthogonal matrix H brought the file's normals into view
 * space, the mean cosine between both would be trace(H^T A) / count, and the
 * best H of all is the orthogonal factor of A.  So one pass over the pixels
 * tells how well any other space, flipped axes or another camera would fit.  A
 * second matrix, of gradients of the other kind of depth, tells planar depth
 * from the distance from the eye.
 */
#ifndef HBIL_DUMP_NORMAL_FIT_H
#define HBIL_DUMP_NORMAL_FIT_H

#include "dump/surface_points.h"

typedef struct normal_fit {
  surface_points s;
  matrix3 planar; /* A, for depth as it was taken */
  matrix3 other;  /* A, for the other kind of depth (surface_point()) */
  double count;   /* pixels that were measured */
} normal_fit;

/* Fewer pixels than these say nothing. */
enum { NORMAL_FIT_LEAST = 200 };

/* Measures some 100 x 100 pixels of a frame with depth and normals. */
normal_fit normal_fit_measure(const surface_points *s);

/* The mean cosine if h brought the file's normals into view space. */
double normal_fit_cosine(const normal_fit *f, const matrix3 *sum,
                         const matrix3 *h);

/* What brings the frame's converted normals into view space if they are in that
 * space and those axes are flipped. */
matrix3 normal_fit_view_if(const normal_fit *f, dump_space space,
                           unsigned flips);

/* Whether the other kind of depth fits the normals much better. */
int normal_fit_is_other_depth(const normal_fit *f, const matrix3 *h);

/* Whether n has unit length if it is stored as (n + 1) / 2, and not if it is
 * stored as it is. */
int normal_looks_encoded(const double n[3]);

#endif
