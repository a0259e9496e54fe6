/* Pictures that are no perspective: fisheyes and panoramas. */
#include "dump/camera_fit.h"
#include "dump/eigen.h"
#include "dump/matrix3.h"

#include <math.h>
#include <string.h>

/* Pictures fit a kind of projection if nine tenths of the pixels look in its
 * directions within so many radians, half a pixel of a 4K panorama's hundred.
 */
static const double fits = 0.03;

/* Of errors: the value that nine tenths don't exceed, counted in steps. */
typedef struct spread {
  size_t within, all;
} spread;

static void add_error(spread *s, double error) {
  s->within += fabs(error) < fits;
  s->all++;
}

static int is_narrow(const spread *s) {
  return s->all >= 50 && (double)s->within > 0.9 * (double)s->all;
}

/* The eye from distances along the rays: |p - e| = d, which is linear in e and
 * in |e|^2.  Returns 0 if the depths are no distances from one point. */
static int find_eye(const fit_points *p, double eye[3]) {
  double sum[25] = {0}, v[EIGEN_MOST], off = 0.0;
  double middle[3] = {0};
  size_t count = 0;
  for (size_t i = 0; i < p->count; i++)
    for (int c = 0; c < 3; c++)
      middle[c] += p->list[i].at[c] / (double)p->count;
  for (size_t i = 0; i < p->count; i++) {
    const fit_point *q = &p->list[i];
    double e[5] = {1, 0, 0, 0, 0};
    if (!(q->depth > 0.0) || q->depth > 1e9)
      continue;
    for (int c = 0; c < 3; c++) {
      e[1 + c] = q->at[c] - middle[c];
      e[4] += e[1 + c] * e[1 + c];
    }
    e[4] -= q->depth * q->depth;
    for (int a = 0; a < 5; a++)
      for (int b = 0; b < 5; b++)
        sum[5 * a + b] += e[a] * e[b];
    count++;
  }
  if (count < 50 || eigen_smallest(sum, 5, v) < 1e-9 || !(fabs(v[4]) > 0.0))
    return 0;
  for (int c = 0; c < 3; c++)
    eye[c] = middle[c] - 0.5 * v[1 + c] / v[4];
  for (size_t i = 0; i < p->count; i++) {
    double to[3];
    for (int c = 0; c < 3; c++)
      to[c] = p->list[i].at[c] - eye[c];
    if (p->list[i].depth > 0.0 && p->list[i].depth < 1e9)
      off += fabs(sqrt(matrix3_dot(to, to)) / p->list[i].depth - 1.0) /
             (double)count;
  }
  return off < 0.02;
}

static void direction(const fit_point *p, const double eye[3], double out[3]) {
  for (int c = 0; c < 3; c++)
    out[c] = p->at[c] - eye[c];
  const double length = sqrt(matrix3_dot(out, out));
  for (int c = 0; c < 3; c++)
    out[c] /= length;
}

/* Whether the tangents of the angles are proportional to the distances, as in a
 * perspective. */
static int is_perspective(const fit_points *p, const double eye[3],
                          const double axis[3], double length) {
  double sum = 0.0, square = 0.0, u[3];
  spread off = {0, 0};
  for (int pass = 0; pass < 2; pass++)
    for (size_t i = 0; i < p->count; i++) {
      const double r =
          hypot(p->list[i].x - 0.5 * p->width, p->list[i].y - 0.5 * p->height);
      direction(&p->list[i], eye, u);
      const double cosine = matrix3_dot(u, axis) / length;
      const double tangent = sqrt(fmax(0.0, 1.0 - cosine * cosine)) / cosine;
      if (pass)
        add_error(&off, atan(tangent) - atan(sum / square * r));
      else if (cosine > 0.0) {
        sum += r * tangent;
        square += r * r;
      }
    }
  return is_narrow(&off);
}

/* Angles from the direction of the picture's middle are a smooth function of
 * the distance from it (k r + l r^3), in all directions the same. */
static int is_fisheye(const fit_points *p, const double eye[3]) {
  const double size = 0.5 * fmax(p->width, p->height);
  double axis[3] = {0}, a = 0, b = 0, c = 0, x = 0, y = 0, u[3];
  spread off = {0, 0};
  for (size_t i = 0; i < p->count; i++)
    if (hypot(p->list[i].x - 0.5 * p->width, p->list[i].y - 0.5 * p->height) <
        0.1 * size) {
      direction(&p->list[i], eye, u);
      for (int k = 0; k < 3; k++)
        axis[k] += u[k];
    }
  const double length = sqrt(matrix3_dot(axis, axis));
  if (!(length > 0.0) || is_perspective(p, eye, axis, length))
    return 0;
  for (int pass = 0; pass < 2; pass++) {
    const double det = a * c - b * b;
    for (size_t i = 0; i < p->count; i++) {
      const double r =
          hypot(p->list[i].x - 0.5 * p->width, p->list[i].y - 0.5 * p->height) /
          size;
      direction(&p->list[i], eye, u);
      const double angle =
          acos(fmax(-1.0, fmin(1.0, matrix3_dot(u, axis) / length)));
      if (pass)
        add_error(&off, angle - (c * x - b * y) / det * r -
                            (a * y - b * x) / det * r * r * r);
      else {
        a += r * r;
        b += r * r * r * r;
        c += r * r * r * r * r * r;
        x += r * angle;
        y += r * r * r * angle;
      }
    }
  }
  return is_narrow(&off);
}

/* The middle row is a great circle, and elevation above it grows evenly with
 * the rows. */
static int is_panorama(const fit_points *p, const double eye[3]) {
  double sum[9] = {0}, up[EIGEN_MOST], u[3];
  double top = 0.0, share = 0.0;
  spread off = {0, 0};
  for (size_t i = 0; i < p->count; i++)
    if (fabs(p->list[i].y - 0.5 * p->height) < 0.02 * p->height) {
      direction(&p->list[i], eye, u);
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
          sum[3 * a + b] += u[a] * u[b];
    }
  eigen_smallest(sum, 3, up);
  for (int pass = 0; pass < 2; pass++)
    for (size_t i = 0; i < p->count; i++) {
      const double y = p->list[i].y / p->height - 0.5;
      direction(&p->list[i], eye, u);
      const double elevation = asin(fmax(-1.0, fmin(1.0, matrix3_dot(u, up))));
      if (pass)
        add_error(&off, elevation - top / share * y);
      else {
        top += y * elevation;
        share += y * y;
      }
    }
  return is_narrow(&off);
}

const char *camera_fit_name_projection(const fit_points *p,
                                       const double eye[3]) {
  double at[3];
  memcpy(at, eye, sizeof at);
  if (!find_eye(p, at))
    memcpy(at, eye, sizeof at);
  return is_panorama(p, at)  ? "a panorama"
         : is_fisheye(p, at) ? "a fisheye"
                             : NULL;
}
