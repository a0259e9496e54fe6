/* The camera that a renderer stores in the header of its file. */
#include "dump/header_camera.h"

#include "image/camera_json.h"
#include "image/image.h"
#include "image/window.h"

#include <math.h>
#include <string.h>

static void transpose(double m[16]) {
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < i; j++) {
      const double swapped = m[4 * i + j];
      m[4 * i + j] = m[4 * j + i];
      m[4 * j + i] = swapped;
    }
}

/* The largest component of a vector, without its sign. */
static double largest(const double v[3]) {
  return fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
}

/* 0 for parallel vectors, up to 1 for others. */
static double off_parallel(const double a[3], const double b[3]) {
  const double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                       a[0] * b[1] - a[1] * b[0]};
  return largest(c) / fmax(largest(a) * largest(b), 1e-30);
}

/* Whether the matrices multiply column vectors.  A perspective divides by the
 * distance along the camera's axis, so the row (or column) that gives the
 * divisor is parallel to the one that gives the camera's z. */
static int for_columns(const double camera[16], const double ndc[16]) {
  const double axis_row[3] = {camera[8], camera[9], camera[10]};
  const double axis_column[3] = {camera[2], camera[6], camera[10]};
  const double row[3] = {ndc[12], ndc[13], ndc[14]};
  const double column[3] = {ndc[3], ndc[7], ndc[11]};
  if (largest(row) <= 1e-12 || largest(column) <= 1e-12)
    return largest(row) > largest(column);
  return off_parallel(axis_row, row) < off_parallel(axis_column, column);
}

/* Whether a matrix for column vectors divides by a constant. */
static int is_affine(const double m[16]) {
  const double row[3] = {m[12], m[13], m[14]};
  return largest(row) <= 1e-4 * fabs(m[15]);
}

static void multiply(const double a[16], const double b[16], double out[16]) {
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++) {
      double sum = 0;
      for (int k = 0; k < 4; k++)
        sum += a[4 * i + k] * b[4 * k + j];
      out[4 * i + j] = sum;
    }
}

static double determinant(const double m[16]) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) -
         m[1] * (m[4] * m[10] - m[6] * m[8]) +
         m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/* The inverse of a rotation (mirrored or not) with a uniform scale and a
 * translation.  The inverse's rotation is without the scale.  -1 if the matrix
 * is of another kind. */
static int invert(const double m[16], double scale, double out[16]) {
  const double scale2 = scale * scale;
  memset(out, 0, 16 * sizeof *out);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double product = 0;
      for (int k = 0; k < 3; k++)
        product += m[4 * i + k] * m[4 * j + k] / scale2;
      if (!(fabs(product - (i == j)) <= 1e-3)) /* as for JSON's matrices */
        return -1;
      out[4 * i + j] = m[4 * j + i] / scale2;
      out[4 * i + 3] -= m[4 * j + i] * m[4 * j + 3] / scale2;
    }
  out[15] = 1;
  return 0;
}

/* Reads focal lengths and centre of a projection from camera space.  It divides
 * by k, and column `moved` of its first two rows holds the picture's middle. */
static int read_lens(const double p[16], double k, int moved,
                     image_window shown, camera_file *out) {
  const double w = shown.width, h = shown.height;
  const double sx = fabs(p[0] / k), sy = fabs(p[5] / k);
  const double x = p[moved] / k, y = p[4 + moved] / k;
  const int unit = fabs(x - 0.5) + fabs(y - 0.5) < fabs(x) + fabs(y);
  const double size = unit ? 1 : 0.5, middle = unit ? 0.5 : 0;
  out->fx = sx * size * w;
  out->fy = sy * size * h;
  /* pbrt gives one scale for both axes, which is that of the shorter side */
  if (fabs(sx / sy - 1) < 0.01 && fabs(out->fx / out->fy - 1) > 0.01)
    out->fx = out->fy = sx * size * fmin(w, h);
  out->cx = w / 2 + (x - middle) * out->fx / sx;
  out->cy = h / 2 + (p[5] > 0 ? -1 : 1) * (y - middle) * out->fy / sy;
  return isfinite(out->fx + out->fy + out->cx + out->cy) && out->fx > 0 &&
                 out->fy > 0
             ? 0
             : -1;
}

/* forwards: the sign of z in front of the camera. */
static int read_perspective(const double p[16], image_window shown,
                            camera_file *out, double *forwards) {
  const double k = p[14];
  if (!(fabs(p[15]) <= 1e-4 * fabs(k)) || !(k != 0.0))
    return -1; /* parallel, or no projection at all */
  *forwards = k > 0 ? 1 : -1;
  return read_lens(p, k, 2, shown, out);
}

/* With parallel rays, each axis of the camera is an axis of the picture.  Only
 * the third, which grows with the distance, tells where forward is. */
static int read_parallel(const double p[16], image_window shown,
                         camera_file *out, double *forwards) {
  const double k = p[15], x = fabs(p[0]), y = fabs(p[5]);
  const double skew =
      fmax(fmax(fabs(p[1]), fabs(p[2])), fmax(fabs(p[4]), fabs(p[6])));
  if (!is_affine(p) || !(k != 0.0) || !(p[10] != 0.0) ||
      !(skew <= 1e-3 * fmin(x, y)))
    return -1; /* oblique, or no projection at all */
  *forwards = p[10] / k > 0 ? 1 : -1;
  return read_lens(p, k, 3, shown, out);
}

/* The two matrices, for column vectors, and what follows from them. */
typedef struct header_camera {
  double camera[16], ndc[16];
  double back[16], scale; /* the camera's inverse without its scale */
  double projection[16];  /* from camera space */
  double forwards;        /* the sign of z in front of the camera */
} header_camera;

static void transpose_both(header_camera *c) {
  transpose(c->camera);
  transpose(c->ndc);
}

static int project(header_camera *c) {
  c->scale = cbrt(fabs(determinant(c->camera)));
  if (!(c->scale > 0) || invert(c->camera, c->scale, c->back) != 0)
    return -1;
  multiply(c->ndc, c->back, c->projection);
  return 0;
}

static int find_perspective(header_camera *c, image_window shown,
                            camera_file *out) {
  if (!for_columns(c->camera, c->ndc))
    transpose_both(c);
  return project(c) != 0
             ? -1
             : read_perspective(c->projection, shown, out, &c->forwards);
}

/* Nothing is divided by the depth here that would tell rows from columns, so
 * both layouts are tried.  If both make a camera, rows win: OpenEXR uses them.
 */
static int find_parallel(header_camera *c, image_window shown, double unit,
                         camera_file *out) {
  transpose_both(c);
  for (int layout = 0; layout < 2; layout++, transpose_both(c)) {
    if (!is_affine(c->camera) || project(c) != 0 ||
        read_parallel(c->projection, shown, out, &c->forwards) != 0)
      continue;
    out->orthographic = 1;
    out->fx *= c->scale / unit; /* pixels in a camera unit */
    out->fy *= c->scale / unit;
    return 0;
  }
  transpose_both(c);
  return -1;
}

int header_camera_exists(const image *header) {
  return header->matrices.has_camera && header->matrices.has_ndc;
}

int header_camera_read(const image *header, double unit, camera_file *out,
                       int *mirrored) {
  const image_window shown = image_display_window(header);
  header_camera c;
  if (!header_camera_exists(header))
    return -1;
  memcpy(c.camera, header->matrices.world_to_camera, sizeof c.camera);
  memcpy(c.ndc, header->matrices.world_to_ndc, sizeof c.ndc);
  if (find_parallel(&c, shown, unit, out) != 0 &&
      find_perspective(&c, shown, out) != 0)
    return -1;
  double *m = out->camera_to_world;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++)
      m[4 * i + j] = c.back[4 * i + j] * c.scale * (j == 2 ? -c.forwards : 1);
    m[4 * i + 3] = c.back[4 * i + 3] * unit;
  }
  m[15] = 1;
  *mirrored = determinant(m) < 0;
  for (int j = 0; j < 4 && *mirrored; j++)
    m[8 + j] = -m[8 + j];
  return 0;
}
