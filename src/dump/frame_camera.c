/* The camera of a frame. */
#define _POSIX_C_SOURCE 200809L
#include "dump/frame_camera.h"

#include "dump/fitted_camera.h"
#include "dump/header_camera.h"
#include "image/camera_json.h"
#include "image/error.h"
#include "image/image.h"
#include "image/window.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

char *camera_file_beside(const char *frame) {
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

void camera_file_to_hbil(const camera_file *file, hbil_camera *out) {
  hbil_camera_from_opengl(out, file->camera_to_world, file->fx, file->fy,
                          file->cx, file->cy);
}

static int from_json(const char *path, const char *from, frame_camera *out,
                     image_error *error) {
  out->from = from;
  out->placed = 1;
  return camera_read(path, &out->file, error);
}

/* A camera of which only the lens is known.  The world is its own space. */
static void from_lens(const image *header, const source_options *o,
                      frame_camera *out) {
  const image_window shown = image_display_window(header);
  for (int i = 0; i < 16; i += 5)
    out->file.camera_to_world[i] = 1;
  out->file.cx = 0.5 * shown.width;
  out->file.cy = 0.5 * shown.height;
  out->from = o->fov > 0.0f ? "--fov" : "--orthographic";
}

static int from_header(const image *header, double unit, frame_camera *out) {
  if (header_camera_read(header, unit, &out->file, &out->mirrored) != 0)
    return -1;
  out->placed = 1;
  out->from = "worldToCamera and worldToNDC in the header";
  return 0;
}

static int from_positions(const char *frame, const channel_map *map,
                          frame_camera *out, image_error *error) {
  return fitted_camera_read(frame, map, out, error) != 0 || out->from
             ? out->from ? 0 : -1
             : image_fail(error,
                          "%s: --camera positions: %s; a camera file is needed",
                          frame,
                          map->count[ROLE_POSITION] < 3
                              ? "it has no positions"
                              : "its positions tell no camera");
}

static int is_fitted(const char *override) {
  return override && strcmp(override, "positions") == 0;
}

/* Where no JSON file has the camera.  beside: the file that might have had it.
 * fitted: only positions may tell it. */
static int find(const char *frame, const char *beside, const image *header,
                const channel_map *map, int fitted, const source_options *o,
                frame_camera *out, image_error *error) {
  if (fitted)
    return from_positions(frame, map, out, error);
  if (from_header(header, o->unit > 0.0f ? (double)o->unit : 1, out) == 0)
    return 0;
  if (fitted_camera_read(frame, map, out, error) != 0)
    return -1;
  if (out->from)
    return 0;
  if (o->fov > 0.0f || o->orthographic > 0.0f) {
    from_lens(header, o, out);
    return 0;
  }
  if (header_camera_exists(header))
    return image_fail(error,
                      "%s: worldToCamera and worldToNDC in its header describe "
                      "no perspective and no orthographic camera; "
                      "--camera, --fov or --orthographic is needed",
                      frame);
  return image_fail(
      error,
      "%s: camera cannot be read: there is no such file%s; this "
      "JSON file, --camera, --fov, --orthographic, or "
      "worldToCamera and worldToNDC in the header of %s is "
      "needed",
      beside,
      map->count[ROLE_POSITION] == 3 ? ", and the positions tell none" : "",
      frame);
}

/* The lens that the user gives replaces the one that was found, if there was
 * one, which is told. */
static void choose_lens(const source_options *o, double width,
                        frame_camera *v) {
  const double half_degree = 3.14159265358979 / 360;
  camera_file *out = &v->file;
  const double x = out->fx, y = out->fy;
  if (o->fov > 0.0f)
    out->fx = out->fy = 0.5 * width / tan(half_degree * (double)o->fov);
  if (o->orthographic > 0.0f)
    out->fx = out->fy = width / (double)o->orthographic;
  if (o->fov > 0.0f || o->orthographic > 0.0f)
    out->orthographic = o->orthographic > 0.0f;
  if (x > 0.0 && (out->fx != x || out->fy != y))
    snprintf(v->lens, sizeof v->lens,
             "%s replaces the lens of the camera (%s): %.5g, %.5g pixels in "
             "place of %.5g, %.5g",
             o->fov > 0.0f ? "--fov" : "--orthographic", v->from, out->fx,
             out->fy, x, y);
}

/* The camera file of the eye that is read, FRAME.EYE.json, if it exists; else
 * FRAME.json.  malloc'd, NULL if memory runs out. */
static char *camera_beside(const char *frame, const image *header,
                           const source_options *o) {
  const char *eye = o->eye               ? o->eye
                    : header->view_count ? header->views[0]
                                         : NULL;
  char *both = camera_file_beside(frame);
  if (!both || !eye)
    return both;
  const size_t stem = strlen(both) - strlen(".json");
  char *own = malloc(stem + strlen(eye) + sizeof "..json");
  if (own)
    sprintf(own, "%.*s.%s.json", (int)stem, both, eye);
  if (own && access(own, F_OK) != 0) {
    free(own);
    return both;
  }
  free(both);
  return own;
}

/* The header's number of that name replaces what the camera file says. */
static int choose_exposure(const char *frame, const image *header,
                           const char *name, camera_file *out,
                           image_error *error) {
  size_t i = 0;
  if (!name)
    return 0;
  while (i < header->number_count && strcmp(header->numbers[i].name, name) != 0)
    i++;
  if (i == header->number_count)
    return image_fail(
        error, "%s: --exposure %s: its header has no such number; %s", frame,
        name, i ? "`hbil info` lists those that it has" : "it has none at all");
  out->exposure = header->numbers[i].value;
  return out->exposure >= CAMERA_LEAST_EXPOSURE &&
                 out->exposure <= CAMERA_MOST_EXPOSURE
             ? 0
             : image_fail(error,
                          "%s: --exposure %s: %g in its header; a factor of "
                          "1e-12 to 1e12 is needed",
                          frame, name, out->exposure);
}

int frame_camera_read(const char *frame, const image *header,
                      const channel_map *map, const char *override,
                      const source_options *options, frame_camera *out,
                      char **file, image_error *error) {
  const int fitted = is_fitted(override);
  char *json = override && !fitted ? strdup(override)
                                   : camera_beside(frame, header, options);
  memset(out, 0, sizeof *out);
  if (!json)
    return image_no_memory(error, frame);
  const int is_read = override ? !fitted : access(json, F_OK) == 0;
  const int failed =
      is_read
          ? from_json(json, override ? "--camera" : "the JSON file beside it",
                      out, error)
          : find(frame, json, header, map, fitted, options, out, error);
  if (file && is_read && !failed)
    *file = json;
  else
    free(json);
  if (failed)
    return -1;
  choose_lens(options, image_display_window(header).width, out);
  return choose_exposure(frame, header, options->exposure, &out->file, error);
}

int frame_camera_same_projection(const char *frame, const camera_file *camera,
                                 const char *of, const camera_file *first,
                                 image_error *error) {
  static const char *const kinds[] = {"a perspective", "an orthographic"};
  return camera->orthographic == first->orthographic
             ? 0
             : image_fail(
                   error,
                   "%s: has %s camera, but %s has %s one; frames with one "
                   "kind of camera are needed",
                   frame, kinds[camera->orthographic], of,
                   kinds[first->orthographic]);
}

/* Finds the window that the camera's pixels are counted in: the display window,
 * unless the camera's size is that of the data window. */
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
  return image_fail(
      error,
      "%s: %u x %u pixels, but its camera is for %u x %u; the "
      "camera of this frame is needed%s",
      frame, shown.width, shown.height, camera->width, camera->height,
      camera->width >= shown.width && camera->height >= shown.height
          ? "; for a cropped border, that is cx and cy less the "
            "pixels cropped left and above, and the picture's "
            "own resolution"
          : "");
}

/* Whether the clipping planes suffice to compute depths between them. */
static int can_use_clipping_planes(const channel_map *map) {
  return map->projection == HBIL_PROJECTION_ORTHOGRAPHIC
             ? map->how.far > 0.0 && isfinite(map->how.far)
             : map->how.near > 0.0;
}

/* How far before the far plane the sky begins, as a share of it.  EEVEE stores
 * 1000.07 for a plane at 1000. */
static const double before_far = 1e-3;

static void clip_sky(conventions *how) {
  const double far = how->far * (1.0 - before_far) / how->unit;
  if (how->clips && how->far > 0.0 && far < (double)how->sky_depth)
    how->sky_depth = (float)far;
}

/* Whether all that conversions need to know about the camera is known. */
static int check_needs(const char *frame, const frame_camera *v,
                       const channel_map *map, image_error *error) {
  const conventions *how = &map->how;
  if ((how->depth == DEPTH_DEVICE || how->depth == DEPTH_REVERSED) &&
      !can_use_clipping_planes(map))
    return image_fail(
        error,
        "%s: --depth %s: the clipping planes are unknown or "
        "impossible for %s camera; --clip NEAR,FAR is needed%s",
        frame, depth_words[how->depth],
        map->projection == HBIL_PROJECTION_ORTHOGRAPHIC ? "an orthographic"
                                                        : "a perspective",
        map->projection == HBIL_PROJECTION_ORTHOGRAPHIC ? ", FAR finite"
                                                        : ", NEAR above 0");
  if (!v->placed && how->normals == SPACE_WORLD && !how->from_depth)
    return image_fail(error,
                      "%s: its normals are in world space, and nothing tells "
                      "how the camera is turned; a camera file, or --normals "
                      "camera if they are in camera space, is needed",
                      frame);
  if (!v->placed && how->depth == DEPTH_POSITION &&
      how->positions == SPACE_WORLD)
    return image_fail(error,
                      "%s: depth comes from positions in world space, and "
                      "the camera's place is unknown; a camera file is needed",
                      frame);
  return 0;
}

int frame_camera_aim(const char *frame, const frame_camera *v, channel_map *map,
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
  map->exposure = v->file.exposure;
  map->projection = out->orthographic ? HBIL_PROJECTION_ORTHOGRAPHIC
                                      : HBIL_PROJECTION_PERSPECTIVE;
  if (!(map->how.far > 0.0)) {
    map->how.near = out->near;
    map->how.far = out->far;
  }
  clip_sky(&map->how);
  camera_file_to_hbil(out, &map->camera);
  return check_needs(frame, v, map, error);
}
