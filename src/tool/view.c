/*
 * Where a frame was seen from: a JSON file, the header's matrices, or options.
 *
 * Renderers agree on what worldToCamera and worldToNDC are, and on little else:
 * matrices for columns or for rows, z forwards or backwards, left- or
 * right-handed worlds, pictures of -1..1 or 0..1, y up or down.  All of that
 * shows in the two together, but that a camera's x runs right and its y up, and
 * that of parallel rays the picture's own z grows with the distance.
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

/* Whether its last row is one of a matrix for columns that divides by nothing.
 */
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

/* Scales and centre of a projection from camera space, which divides by k and
 * has the picture's middle in column `moved` of its first two rows. */
static int read_lens(const double p[16], double k, int moved,
                     image_window shown, camera_file *out) {
  const double w = shown.width, h = shown.height;
  const double sx = fabs(p[0] / k), sy = fabs(p[5] / k);
  const double x = p[moved] / k, y = p[4 + moved] / k;
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

/* forwards is the sign of z in front of the camera. */
static int read_perspective(const double p[16], image_window shown,
                            camera_file *out, double *forwards) {
  const double k = p[14];
  if (!(fabs(p[15]) <= 1e-4 * fabs(k)) || !(k != 0.0))
    return -1; /* parallel, or no projection at all */
  *forwards = k > 0 ? 1 : -1;
  return read_lens(p, k, 2, shown, out);
}

/* Parallel rays: each axis of the camera is one of the picture.  Its third
 * grows with the distance, which alone tells where forwards is. */
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

/* The matrices of a header, both for columns, and what comes of them. */
typedef struct header_camera {
  double camera[16], ndc[16];
  double back[16], scale; /* the camera's inverse but for its scale */
  double projection[16];  /* from camera space */
  double forwards;
} header_camera;

static void turn_layout(header_camera *c) {
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
    turn_layout(c);
  return project(c) != 0
             ? -1
             : read_perspective(c->projection, shown, out, &c->forwards);
}

/* Of both layouts the one that makes a camera of them, since nothing is divided
 * by, which would tell.  Where both do, that for rows, which is OpenEXR's. */
static int find_parallel(header_camera *c, image_window shown, double unit,
                         camera_file *out) {
  turn_layout(c);
  for (int layout = 0; layout < 2; layout++, turn_layout(c)) {
    if (!is_affine(c->camera) || project(c) != 0 ||
        read_parallel(c->projection, shown, out, &c->forwards) != 0)
      continue;
    out->orthographic = 1;
    out->fx *= c->scale / unit; /* of a unit of the camera's */
    out->fy *= c->scale / unit;
    return 0;
  }
  turn_layout(c);
  return -1;
}

static int from_header(const image *header, double unit, view *out) {
  const image_window shown = image_display_window(header);
  header_camera c;
  if (!header->matrices.has_camera || !header->matrices.has_ndc)
    return -1;
  memcpy(c.camera, header->matrices.world_to_camera, sizeof c.camera);
  memcpy(c.ndc, header->matrices.world_to_ndc, sizeof c.ndc);
  if (find_parallel(&c, shown, unit, &out->file) != 0 &&
      find_perspective(&c, shown, &out->file) != 0)
    return -1;
  double *m = out->file.camera_to_world;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++)
      m[4 * i + j] = c.back[4 * i + j] * c.scale * (j == 2 ? -c.forwards : 1);
    m[4 * i + 3] = c.back[4 * i + 3] * unit;
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

/* A lens alone: the world is the camera's own space. */
static void from_nothing(const image *header, const source_options *o,
                         view *out) {
  const image_window shown = image_display_window(header);
  for (int i = 0; i < 16; i += 5)
    out->file.camera_to_world[i] = 1;
  out->file.cx = 0.5 * shown.width;
  out->file.cy = 0.5 * shown.height;
  out->from = o->fov > 0.0f ? "--fov" : "--orthographic";
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
  if (o->fov > 0.0f || o->orthographic > 0.0f) {
    from_nothing(header, o, out);
    return 0;
  }
  if (header->matrices.has_camera && header->matrices.has_ndc)
    return image_fail(error,
                      "%s: worldToCamera and worldToNDC in its header are no "
                      "perspective and no orthographic camera's; --camera, "
                      "--fov or --orthographic is needed if it is one",
                      frame);
  return image_fail(error,
                    "%s: camera cannot be read: there is no such file; this "
                    "JSON file, --camera, --fov, --orthographic, or "
                    "worldToCamera and worldToNDC in the header of %s is "
                    "needed",
                    beside, frame);
}

/* What the user says of it goes before what was found. */
static void choose_lens(const source_options *o, double width,
                        camera_file *out) {
  const double half_degree = 3.14159265358979 / 360;
  if (o->fov > 0.0f)
    out->fx = out->fy = 0.5 * width / tan(half_degree * (double)o->fov);
  if (o->orthographic > 0.0f)
    out->fx = out->fy = width / (double)o->orthographic;
  if (o->fov > 0.0f || o->orthographic > 0.0f)
    out->orthographic = o->orthographic > 0.0f;
}

int view_read(const char *frame, const image *header, const char *override,
              const source_options *options, view *out, image_error *error) {
  char *beside = gbuffer_camera_name(frame);
  memset(out, 0, sizeof *out);
  if (!beside)
    return image_no_memory(error, frame);
  const int failed = find(frame, beside, header, override, options, out, error);
  free(beside);
  if (failed)
    return -1;
  choose_lens(options, image_display_window(header).width, &out->file);
  return 0;
}

int view_same_projection(const char *frame, const camera_file *camera,
                         const char *of, const camera_file *first,
                         image_error *error) {
  static const char *const kinds[] = {"a perspective", "an orthographic"};
  return camera->orthographic == first->orthographic
             ? 0
             : image_fail(error,
                          "%s: has %s camera, but %s has %s one; frames of one "
                          "kind are needed",
                          frame, kinds[camera->orthographic], of,
                          kinds[first->orthographic]);
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

/* Whether depth between the clipping planes can be told from them. */
static int has_planes(const channel_map *map) {
  return map->projection == HBIL_PROJECTION_ORTHOGRAPHIC
             ? map->how.far > 0.0 && isfinite(map->how.far)
             : map->how.near > 0.0;
}

/* What conversions need to know of the camera. */
static int check_needs(const char *frame, const view *v, const channel_map *map,
                       image_error *error) {
  const conventions *how = &map->how;
  if ((how->depth == DEPTH_DEVICE || how->depth == DEPTH_REVERSED) &&
      !has_planes(map))
    return image_fail(
        error,
        "%s: --depth %s: the clipping planes are not known, or "
        "no %s camera's; --clip NEAR,FAR is needed%s",
        frame, depth_words[how->depth],
        map->projection == HBIL_PROJECTION_ORTHOGRAPHIC ? "orthographic"
                                                        : "perspective",
        map->projection == HBIL_PROJECTION_ORTHOGRAPHIC ? ", FAR finite"
                                                        : ", NEAR above 0");
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
  map->projection = out->orthographic ? HBIL_PROJECTION_ORTHOGRAPHIC
                                      : HBIL_PROJECTION_PERSPECTIVE;
  if (!(map->how.far > 0.0)) {
    map->how.near = out->near;
    map->how.far = out->far;
  }
  gbuffer_hbil_camera(out, &map->camera);
  return check_needs(frame, v, map, error);
}
