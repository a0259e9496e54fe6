/*
 * Where a frame was seen from: a JSON file, the header's matrices, or options.
 *
 * Renderers agree on what worldToCamera and worldToNDC are, and on little else:
 * matrices for columns or for rows, z forwards or backwards, left- or
 * right-handed worlds, pictures of -1..1 or 0..1, y up or down.  All of that
 * shows in the two together, but that a camera's x runs right and its y up.
 */
#define _POSIX_C_SOURCE 200809L
#include "tool/tool.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

char *gbuffer_camera_name(const char *frame) {
  const char *slash = strrchr(frame, '/');
  const char *dot = strrchr(slash ? slash : frame, '.');
  const size_t stem = dot ? (size_t)(dot - frame) : strlen(frame);
  char *name = malloc(stem + sizeof ".json");
  if (name) {
    memcpy(name, frame, stem);
    strcpy(name + stem, ".json");
  }
  return name;
}

void gbuffer_hbil_camera(const camera_file *file, hbil_camera *out) {
  hbil_camera_from_opengl(out, file->camera_to_world, file->fx, file->fy,
                          file->cx, file->cy);
}

/* ------------------------------------------------------------------------ */
/* Matrices of a header                                                      */

static void transpose(double m[16]) {
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < i; j++) {
      const double kept = m[4 * i + j];
      m[4 * i + j] = m[4 * j + i];
      m[4 * j + i] = kept;
    }
}

/* Largest of three components, or of what is left of it beside a direction. */
static double largest(const double v[3]) {
  return fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
}

static double off_parallel(const double a[3], const double b[3]) {
  const double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                       a[0] * b[1] - a[1] * b[0]};
  return largest(c) / fmax(largest(a) * largest(b), 1e-30);
}

/* Whether matrices are for columns: what a perspective divides by is the
 * distance along the camera's axis, its third row then. */
static int for_columns(const double camera[16], const double ndc[16]) {
  const double axis_row[3] = {camera[8], camera[9], camera[10]};
  const double axis_column[3] = {camera[2], camera[6], camera[10]};
  const double row[3] = {ndc[12], ndc[13], ndc[14]};
  const double column[3] = {ndc[3], ndc[7], ndc[11]};
  if (largest(row) <= 1e-12 || largest(column) <= 1e-12)
    return largest(row) > largest(column);
  return off_parallel(axis_row, row) < off_parallel(axis_column, column);
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

/* The inverse of a rotation, mirrored or not, with a uniform scale and a
 * translation; scale is taken out of its rotation. */
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

/* Focal lengths and centre of a projection from camera space; forwards is the
 * sign of z in front of the camera. */
static int read_lens(const double p[16], image_window shown, camera_file *out,
                     double *forwards) {
  const double k = p[14], w = shown.width, h = shown.height;
  if (!(fabs(p[15]) <= 1e-4 * fabs(k)) || !(k != 0.0))
    return -1; /* parallel, or no projection at all */
  *forwards = k > 0 ? 1 : -1;
  const double sx = fabs(p[0] / k), sy = fabs(p[5] / k);
  const double x = p[2] / k, y = p[6] / k;
  const int unit = fabs(x - 0.5) + fabs(y - 0.5) < fabs(x) + fabs(y);
  const double size = unit ? 1 : 0.5, middle = unit ? 0.5 : 0;
  out->fx = sx * size * w;
  out->fy = sy * size * h;
  /* one scale for both axes of a picture that isn't square: that of its
   * shorter side (pbrt) */
  if (fabs(sx / sy - 1) < 0.01 && fabs(out->fx / out->fy - 1) > 0.01)
    out->fx = out->fy = sx * size * fmin(w, h);
  out->cx = w / 2 + (x - middle) * out->fx / sx;
  out->cy = h / 2 + (p[5] > 0 ? -1 : 1) * (y - middle) * out->fy / sy;
  return isfinite(out->fx + out->fy + out->cx + out->cy) && out->fx > 0 &&
                 out->fy > 0
             ? 0
             : -1;
}

static int from_header(const image *header, double unit, view *out) {
  double camera[16], ndc[16], back[16], projection[16], forwards;
  if (!header->matrices.has_camera || !header->matrices.has_ndc)
    return -1;
  memcpy(camera, header->matrices.world_to_camera, sizeof camera);
  memcpy(ndc, header->matrices.world_to_ndc, sizeof ndc);
  if (!for_columns(camera, ndc)) {
    transpose(camera);
    transpose(ndc);
  }
  const double scale = cbrt(fabs(determinant(camera)));
  if (!(scale > 0) || invert(camera, scale, back) != 0)
    return -1;
  multiply(ndc, back, projection);
  if (read_lens(projection, image_display_window(header), &out->file,
                &forwards) != 0)
    return -1;
  double *m = out->file.camera_to_world;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++)
      m[4 * i + j] = back[4 * i + j] * scale * (j == 2 ? -forwards : 1);
    m[4 * i + 3] = back[4 * i + 3] * unit;
  }
  m[15] = 1;
  out->mirrored = determinant(m) < 0;
  for (int j = 0; j < 4 && out->mirrored; j++)
    m[8 + j] = -m[8 + j];
  out->placed = 1;
  out->from = "worldToCamera and worldToNDC in the header";
  return 0;
}

/* ------------------------------------------------------------------------ */
/* All together                                                              */

static int from_json(const char *path, const char *from, view *out,
                     image_error *error) {
  out->from = from;
  out->placed = 1;
  return camera_read(path, &out->file, error);
}

/* --fov alone: the world is the camera's own space. */
static void from_nothing(const image *header, view *out) {
  const image_window shown = image_display_window(header);
  for (int i = 0; i < 16; i += 5)
    out->file.camera_to_world[i] = 1;
  out->file.cx = 0.5 * shown.width;
  out->file.cy = 0.5 * shown.height;
  out->from = "--fov";
}

static int find(const char *frame, const char *beside, const image *header,
                const char *override, const source_options *o, view *out,
                image_error *error) {
  if (override)
    return from_json(override, "--camera", out, error);
  if (access(beside, F_OK) == 0)
    return from_json(beside, "the JSON file beside it", out, error);
  if (from_header(header, o->unit > 0.0f ? (double)o->unit : 1, out) == 0)
    return 0;
  if (o->fov > 0.0f) {
    from_nothing(header, out);
    return 0;
  }
  if (header->matrices.has_camera && header->matrices.has_ndc)
    return image_fail(error,
                      "%s: worldToCamera and worldToNDC in its header are no "
                      "perspective camera's, the only kind that can be lit; "
                      "--camera or --fov is needed if it is one",
                      frame);
  return image_fail(error,
                    "%s: camera cannot be read: there is no such file; this "
                    "JSON file, --camera, --fov, or worldToCamera and "
                    "worldToNDC in the header of %s is needed",
                    beside, frame);
}

int view_read(const char *frame, const image *header, const char *override,
              const source_options *options, view *out, image_error *error) {
  const double half_degree = 3.14159265358979 / 360;
  char *beside = gbuffer_camera_name(frame);
  memset(out, 0, sizeof *out);
  if (!beside)
    return image_no_memory(error, frame);
  const int failed = find(frame, beside, header, override, options, out, error);
  free(beside);
  if (failed)
    return -1;
  if (options->fov > 0.0f)
    out->file.fx = out->file.fy = 0.5 * image_display_window(header).width /
                                  tan(half_degree * (double)options->fov);
  return 0;
}

/* The window that the camera's pixels are counted in: what is seen, unless its
 * size says that it is for all pixels there are. */
static int find_window(const char *frame, const channel_map *map,
                       const camera_file *camera, image_window *out,
                       image_error *error) {
  const image_window shown = map->display, whole = map->data;
  *out = shown;
  if (!camera->width ||
      (camera->width == shown.width && camera->height == shown.height))
    return 0;
  *out = whole;
  if (camera->width == whole.width && camera->height == whole.height)
    return 0;
  return image_fail(error,
                    "%s: %u x %u pixels, but its camera is for %u x %u; the "
                    "camera of this frame is needed",
                    frame, shown.width, shown.height, camera->width,
                    camera->height);
}

/* What conversions need to know of the camera. */
static int check_needs(const char *frame, const view *v, const channel_map *map,
                       image_error *error) {
  const conventions *how = &map->how;
  if ((how->depth == DEPTH_DEVICE || how->depth == DEPTH_REVERSED) &&
      !(how->near > 0.0))
    return image_fail(error,
                      "%s: --depth %s: the clipping planes are not known; "
                      "--clip NEAR,FAR is needed",
                      frame, depth_words[how->depth]);
  if (!v->placed && how->normals == SPACE_WORLD)
    return image_fail(error,
                      "%s: its normals are in world space, and nothing tells "
                      "how the camera is turned; a camera file, or --normals "
                      "camera if they are not, is needed",
                      frame);
  if (!v->placed && how->depth == DEPTH_POSITION &&
      how->positions == SPACE_WORLD)
    return image_fail(error,
                      "%s: depth is to be taken from positions in world "
                      "space, and nothing tells where the camera is; a camera "
                      "file is needed",
                      frame);
  return 0;
}

int view_aim(const char *frame, const view *v, channel_map *map,
             camera_file *out, image_error *error) {
  image_window window;
  *out = v->file;
  if (find_window(frame, map, out, &window, error) != 0)
    return -1;
  out->cx += (double)window.x - (double)map->window.x;
  out->cy += (double)window.y - (double)map->window.y;
  out->width = map->window.width;
  out->height = map->window.height;
  map->mirrored = v->mirrored;
  if (!(map->how.near > 0.0)) {
    map->how.near = out->near;
    map->how.far = out->far;
  }
  gbuffer_hbil_camera(out, &map->camera);
  return check_needs(frame, v, map, error);
}
