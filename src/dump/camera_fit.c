/* The camera that a frame's positions tell. */
#include "dump/camera_fit.h"

#include "dump/eigen.h"
#include "dump/matrix3.h"
#include "image/quantile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Fewer points than these tell no camera. */
enum { FIT_LEAST = 50, ROUNDS = 8 };

/* Points farther off than so many times the median are left out. */
static const double outlier = 4.0;

void camera_fit_points(const gbuffer *g, fit_points *out) {
  const float *coverage = gbuffer_plane(g, ROLE_COVERAGE, 0);
  const float *depth = gbuffer_plane(g, ROLE_DEPTH, 0);
  const size_t width = g->planes.width, pixels = gbuffer_pixels(g);
  /* a prime number of steps in a row, so that columns differ */
  const size_t step = pixels / FIT_POINTS + 1;
  memset(out, 0, sizeof *out);
  out->width = g->planes.width;
  out->height = g->planes.height;
  for (size_t i = 0; i < pixels && out->count < FIT_POINTS;
       i += step + (i / width) % 2) {
    fit_point p = {.x = (double)(i % width) + 0.5,
                   .y = (double)(i / width) + 0.5};
    int some = 0;
    for (size_t c = 0; c < 3; c++) {
      p.at[c] = (double)gbuffer_plane(g, ROLE_POSITION, c)[i];
      some |= p.at[c] != 0.0;
    }
    p.depth = depth ? (double)depth[i] * g->map.how.unit : 0.0;
    if (some && fabs(p.at[0]) + fabs(p.at[1]) + fabs(p.at[2]) < 1e9 &&
        (!coverage || coverage[i] > 0.999f))
      out->list[out->count++] = p;
  }
}

/* The value that this share of the points does not exceed; infinite if there
 * are none, or no memory. */
static double percentile(const double *values, size_t count, double share) {
  double *sorted = malloc(sizeof *sorted * (count + 1));
  if (!sorted || !count)
    return free(sorted), INFINITY;
  memcpy(sorted, values, count * sizeof *sorted);
  const double out = quantile(sorted, count, share);
  free(sorted);
  return out;
}

/* ------------------------------------------------------------------------ */
/* A projection of any kind                                                  */

/* Rows of a matrix from (x, y, z, 1) to pixels times a divisor, the last row.
 * Points are shifted and scaled first, for the sake of precision. */
typedef struct projection {
  double row[3][4];
} projection;

static double distance_of(const projection *m, const fit_point *p) {
  double v[3];
  for (int r = 0; r < 3; r++)
    v[r] = matrix3_dot(m->row[r], p->at) + m->row[r][3];
  return hypot(v[0] / v[2] - p->x, v[1] / v[2] - p->y);
}

typedef struct scaling {
  double middle[3], size;
} scaling;

static scaling scaling_of(const fit_points *p) {
  scaling s = {.size = 0.0};
  for (size_t i = 0; i < p->count; i++)
    for (int c = 0; c < 3; c++)
      s.middle[c] += p->list[i].at[c] / (double)p->count;
  for (size_t i = 0; i < p->count; i++)
    for (int c = 0; c < 3; c++)
      s.size += fabs(p->list[i].at[c] - s.middle[c]) / (double)p->count;
  if (!(s.size > 0.0))
    s.size = 1.0;
  return s;
}

/* Least squares over the points with used[i].  affine: the divisor is 1.
 * Returns 0 if the points don't decide. */
static int solve(const fit_points *p, const unsigned char *used, int affine,
                 projection *out) {
  const size_t n = affine ? 9 : 12;
  const scaling s = scaling_of(p);
  const double half = 0.5 * p->width, tall = 0.5 * p->height;
  double sum[EIGEN_MOST * EIGEN_MOST] = {0}, v[EIGEN_MOST];
  for (size_t i = 0; i < p->count; i++)
    for (int axis = 0; used[i] && axis < 2; axis++) {
      const fit_point *q = &p->list[i];
      const double at = axis ? (q->y - tall) / half : (q->x - half) / half;
      double e[EIGEN_MOST] = {0}, w[4] = {0, 0, 0, 1};
      for (int c = 0; c < 3; c++)
        w[c] = (q->at[c] - s.middle[c]) / s.size;
      for (int c = 0; c < 4; c++)
        e[4 * axis + c] = w[c];
      for (int c = 0; c < 4 && !affine; c++)
        e[8 + c] = -at * w[c];
      if (affine)
        e[8] = -at;
      for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < n; b++)
          sum[a * n + b] += e[a] * e[b];
    }
  /* flat scenes leave the rounding of floats, squared */
  if (eigen_smallest(sum, n, v) < 1e-9)
    return 0;
  double m[3][4] = {{0}};
  memcpy(m, v, sizeof *m * 2);
  for (int c = 0; c < 4; c++)
    m[2][c] = affine ? (c == 3 ? v[8] : 0.0) : v[8 + c];
  for (int r = 0; r < 3; r++) {
    double shift = 0.0;
    for (int c = 0; c < 3; c++) {
      m[r][c] /= s.size;
      shift += m[r][c] * s.middle[c];
    }
    m[r][3] -= shift;
  }
  for (int c = 0; c < 4; c++) {
    out->row[0][c] = half * (m[0][c] + m[2][c]);
    out->row[1][c] = half * m[1][c] + tall * m[2][c];
    out->row[2][c] = m[2][c];
  }
  return 1;
}

/* Repeats it without the points that are too far off.  Returns the error in
 * pixels of nine tenths of the points; infinite if there is no solution. */
static double solve_robustly(const fit_points *p, int affine, projection *out) {
  static const double share = 0.9;
  unsigned char used[FIT_POINTS];
  double off[FIT_POINTS];
  memset(used, 1, sizeof used);
  for (int round = 0; round < ROUNDS; round++) {
    if (!solve(p, used, affine, out))
      return INFINITY;
    for (size_t i = 0; i < p->count; i++)
      off[i] = distance_of(out, &p->list[i]);
    const double most = outlier * percentile(off, p->count, 0.5) + 1e-3;
    for (size_t i = 0; i < p->count; i++)
      used[i] = off[i] <= most;
  }
  return percentile(off, p->count, share);
}

/* ------------------------------------------------------------------------ */
/* A camera                                                                  */

static void place(camera_file *out, const double right[3], const double down[3],
                  const double ahead[3], const double eye[3]) {
  for (int r = 0; r < 3; r++) {
    out->camera_to_world[4 * r] = right[r];
    out->camera_to_world[4 * r + 1] = -down[r];
    out->camera_to_world[4 * r + 2] = -ahead[r];
    out->camera_to_world[4 * r + 3] = eye[r];
  }
  out->camera_to_world[15] = 1;
}

static void cross(const double a[3], const double b[3], double out[3]) {
  for (int c = 0; c < 3; c++)
    out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

/* Takes out of v what is along the unit vector n, makes v one, and returns its
 * length. */
static double straighten(double v[3], const double n[3]) {
  const double along = matrix3_dot(v, n);
  for (int c = 0; c < 3; c++)
    v[c] -= along * n[c];
  const double length = sqrt(matrix3_dot(v, v));
  for (int c = 0; c < 3; c++)
    v[c] /= length;
  return length;
}

/* The point that the projection sends to 0, 0, 0. */
static void find_eye(const projection *m, double out[3]) {
  double c[3][3];
  for (int r = 0; r < 3; r++)
    cross(m->row[(r + 1) % 3], m->row[(r + 2) % 3], c[r]);
  const double determinant = matrix3_dot(m->row[0], c[0]);
  for (int k = 0; k < 3; k++)
    out[k] = -(c[0][k] * m->row[0][3] + c[1][k] * m->row[1][3] +
               c[2][k] * m->row[2][3]) /
             determinant;
}

/* Surfaces lie in front of the camera, where the divisor is positive. */
static void face_surfaces(const fit_points *p, projection *m) {
  size_t behind = 0;
  for (size_t i = 0; i < p->count; i++)
    behind += matrix3_dot(m->row[2], p->list[i].at) + m->row[2][3] < 0.0;
  for (int r = 0; 2 * behind > p->count && r < 3; r++)
    for (int c = 0; c < 4; c++)
      m->row[r][c] = -m->row[r][c];
}

static void read_perspective(const fit_points *p, projection m,
                             camera_file *out) {
  double eye[3], ahead[3], right[3], down[3], turned[3];
  face_surfaces(p, &m);
  find_eye(&m, eye);
  memcpy(ahead, m.row[2], sizeof ahead);
  const double scale = sqrt(matrix3_dot(ahead, ahead));
  for (int c = 0; c < 3; c++) {
    ahead[c] /= scale;
    right[c] = m.row[0][c] / scale;
    down[c] = m.row[1][c] / scale;
  }
  out->cx = matrix3_dot(right, ahead);
  out->cy = matrix3_dot(down, ahead);
  out->fx = straighten(right, ahead);
  cross(ahead, right, turned);
  out->fy = fabs(matrix3_dot(down, turned));
  /* mirrored worlds are told by the sign, see camera_fit_find() */
  const double sign = matrix3_dot(down, turned) < 0.0 ? -1.0 : 1.0;
  for (int c = 0; c < 3; c++)
    down[c] = sign * turned[c];
  place(out, right, down, ahead, eye);
}

/* The camera stands in front of the nearest surface, or where depth says. */
static void read_orthographic(const fit_points *p, const projection *m,
                              camera_file *out) {
  double right[3], down[3], ahead[3], eye[3] = {0}, nearest = INFINITY;
  double away[FIT_POINTS];
  const double k = m->row[2][3];
  size_t count = 0;
  for (int c = 0; c < 3; c++) {
    right[c] = m->row[0][c] / k;
    down[c] = m->row[1][c] / k;
  }
  out->orthographic = 1;
  out->fx = sqrt(matrix3_dot(right, right));
  for (int c = 0; c < 3; c++)
    right[c] /= out->fx;
  out->fy = straighten(down, right);
  cross(right, down, ahead);
  for (size_t i = 0; i < p->count; i++) {
    const double along = matrix3_dot(ahead, p->list[i].at);
    nearest = fmin(nearest, along);
    if (p->list[i].depth > 0.0)
      away[count++] = along - p->list[i].depth;
  }
  out->cx = 0.5 * p->width;
  out->cy = 0.5 * p->height;
  const double x = (out->cx - m->row[0][3] / k) / out->fx;
  const double y = (out->cy - m->row[1][3] / k) / out->fy;
  const double z =
      count ? percentile(away, count, 0.5) : nearest - p->width / out->fx;
  for (int c = 0; c < 3; c++)
    eye[c] = x * right[c] + y * down[c] + z * ahead[c];
  place(out, right, down, ahead, eye);
}

double camera_fit_error(const fit_points *p, const camera_file *camera) {
  const double *m = camera->camera_to_world;
  double off[FIT_POINTS];
  for (size_t i = 0; i < p->count; i++) {
    double v[3] = {0};
    for (int c = 0; c < 3; c++)
      for (int r = 0; r < 3; r++)
        v[c] += m[4 * r + c] * (p->list[i].at[r] - m[4 * r + 3]);
    const double by = camera->orthographic ? 1.0 : -v[2];
    off[i] = by > 0.0
                 ? hypot(camera->cx + camera->fx * v[0] / by - p->list[i].x,
                         camera->cy - camera->fy * v[1] / by - p->list[i].y)
                 : 1e6; /* behind the camera */
  }
  return percentile(off, p->count, 0.9);
}

static double determinant_of(const double m[16]) {
  const double x[3] = {m[0], m[4], m[8]}, y[3] = {m[1], m[5], m[9]};
  const double z[3] = {m[2], m[6], m[10]};
  double across[3];
  cross(x, y, across);
  return matrix3_dot(across, z);
}

camera_fit camera_fit_find(const fit_points *p) {
  camera_fit f = {.error = INFINITY};
  projection m, affine;
  if (p->count < FIT_LEAST)
    return f;
  const double parallel = solve_robustly(p, 1, &affine);
  const double error = solve_robustly(p, 0, &m);
  if (!(fmin(parallel, error) < CAMERA_FITS))
    return f;
  /* a perspective has more unknowns, and explains parallel rays nearly as well
   */
  if (parallel < 1.1 * error + 0.05)
    read_orthographic(p, &affine, &f.camera);
  else
    read_perspective(p, m, &f.camera);
  f.mirrored = determinant_of(f.camera.camera_to_world) < 0.0;
  f.camera.width = p->width;
  f.camera.height = p->height;
  f.error = camera_fit_error(p, &f.camera);
  f.found = isfinite(f.error) && f.error < CAMERA_FITS;
  for (int c = 0; c < 4 && f.mirrored; c++)
    f.camera.camera_to_world[8 + c] = -f.camera.camera_to_world[8 + c];
  return f;
}
