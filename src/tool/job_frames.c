/* Checks the frames and the views of a job. */
#define _POSIX_C_SOURCE 200809L
#include "tool/job_frames.h"

#include "dump/read_channel_map.h"
#include "dump/read_gbuffer.h"
#include "dump/settle.h"
#include "image/image.h"
#include "image/image_read.h"
#include "image/window.h"
#include "tool/paths.h"
#include "tool/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* Frames                                                                    */

static int check_motion(const job *j, const job_frame *f, image_error *error) {
  const int moved = j->config.history.reprojection == HBIL_REPROJECTION_MOTION;
  const float *scale = f->map.how.motion_scale;
  if (moved && !f->map.count[ROLE_MOTION])
    return image_fail(error,
                      "%s: has no motion vectors; Vector.{X,Y} (Blender's "
                      "Vector pass), motion.{X,Y} or another --reprojection "
                      "is needed",
                      f->path);
  if (moved && scale[0] == 0.0f && scale[1] == 0.0f)
    return image_fail(error,
                      "%s: the unit of its motion vectors is unknown (%s); "
                      "--motion-scale X,Y is needed",
                      f->path, source_table[f->map.kind].about);
  return 0;
}

/* The data windows of frames may differ, but not the picture. */
static int add_window(job *j, const job_frame *f, image_error *error) {
  if (f == j->frames)
    j->window = f->map.data;
  j->window = image_window_union(j->window, f->map.data);
  if (j->window.width > HBIL_MAX_SIZE || j->window.height > HBIL_MAX_SIZE)
    return image_fail(error,
                      "%s: its data window makes that of all frames %u x %u "
                      "pixels; at most %d x %d are possible",
                      f->path, j->window.width, j->window.height, HBIL_MAX_SIZE,
                      HBIL_MAX_SIZE);
  return 0;
}

static int check_header(job *j, job_frame *f, image_error *error) {
  const process_settings *s = j->settings;
  image header;
  if (image_read_header(f->path, &header, error) != 0)
    return -1;
  int failed =
      channel_map_read(f->path, &header, &s->source, &f->map, error) != 0 ||
      channel_map_check(&f->map, f->path, error) != 0 ||
      channel_map_follows(&f->map, f->path, &j->frames[0].map,
                          j->frames[0].path, error) != 0 ||
      check_motion(j, f, error) != 0;
  f->map.held = f == j->frames ? &j->held : NULL;
  failed = failed ||
           frame_camera_read(f->path, &header, &f->map, s->camera, &s->source,
                             &f->seen, &f->camera_path, error) != 0 ||
           add_window(j, f, error) != 0;
  image_free(&header);
  return failed ? -1 : 0;
}

/* What the results show: the picture, or the part of it that is asked for. */
static int find_display(job *j, image_error *error) {
  const float *c = j->settings->crop;
  const image_window *all = &j->frames[0].map.display;
  int fits = c[2] >= 1.0f && c[3] >= 1.0f;
  j->display = *all;
  if (c[0] == 0.0f && c[1] == 0.0f && c[2] == 0.0f && c[3] == 0.0f)
    return 0;
  for (int i = 0; i < 2; i++)
    fits = fits && c[i] >= 0.0f && c[i] == floorf(c[i]) &&
           c[2 + i] == floorf(c[2 + i]) &&
           c[i] + c[2 + i] <= (float)(i ? all->height : all->width);
  if (!fits)
    return image_fail(error,
                      "--crop %g,%g,%g,%g: no part of %s, whose picture has "
                      "%u x %u pixels; x and y of the first pixel, width and "
                      "height are needed",
                      (double)c[0], (double)c[1], (double)c[2], (double)c[3],
                      j->frames[0].path, all->width, all->height);
  j->display = (image_window){.x = all->x + (int32_t)c[0],
                              .y = all->y + (int32_t)c[1],
                              .width = (uint32_t)c[2],
                              .height = (uint32_t)c[3]};
  return 0;
}

/* Fits the cameras to the pixels that are computed.  Pixels outside the picture
 * send light into it and are not written. */
static int aim_cameras(job *j, image_error *error) {
  j->width = j->window.width;
  j->height = j->window.height;
  if (find_display(j, error) != 0)
    return -1;
  j->shown = image_window_common(j->window, j->display);
  if (!j->shown.width)
    return image_fail(error,
                      "%s: none of its pixels lie in its display window, or "
                      "in what --crop takes of it; a data window that overlaps "
                      "it is needed",
                      j->frames[0].path);
  for (job_frame *f = j->frames; f < j->frames + j->count; f++) {
    f->map.window = j->window;
    if (frame_camera_aim(f->path, &f->seen, &f->map, &f->camera, error) != 0 ||
        frame_camera_same_projection(f->path, &f->camera, j->frames[0].path,
                                     &j->frames[0].camera, error) != 0)
      return -1;
  }
  return 0;
}

static void tell_fitted_camera(const job *j) {
  const job_frame *first = j->frames;
  const camera_file *c = &first->seen.file;
  char text[160];
  if (j->settings->quiet || !first->seen.fitted)
    return;
  snprintf(text, sizeof text,
           "the camera is fitted to the positions%s: %s %.5g, %.5g pixels",
           j->settings->camera ? "" : ", as no file has it",
           c->orthographic ? "orthographic, a unit is" : "focal lengths", c->fx,
           c->fy);
  report_note(first->path, "", text);
}

/* What of the first frame's file is left out or read otherwise than it says. */
static void tell_reading(const job *j) {
  const job_frame *first = j->frames;
  const channel_map *map = &first->map;
  char text[512];
  int floats = 0;
  if (j->settings->quiet)
    return;
  for (int r = 0; r < ROLE_COUNT; r++) {
    floats |= role_is_colour((role)r) && map->count[r] && map->floats[r];
    snprintf(text, sizeof text,
             "%s is left out, because its layer has no channel %s; all "
             "channels of it, or --map %s=LAYER, are needed",
             role_name((role)r), map->lacks[r], role_name((role)r));
    if (*map->lacks[r])
      report_note(first->path, "warning: ", text);
  }
  if (j->settings->source.gamma > 0 && floats)
    report_note(
        first->path, "",
        map->count[ROLE_ALBEDO] && map->floats[ROLE_ALBEDO]
            ? "--colours srgb: albedo of floats is taken as sRGB, though "
              "linear is usual, and light in floats as linear"
            : "--colours srgb: light in floats is taken as linear");
  if (*first->seen.lens)
    report_note(first->path, "", first->seen.lens);
}

/* Reads the frame that decides, if it isn't the first one. */
static int read_decider(job *j, image_error *error) {
  const process_settings *s = j->settings;
  image header;
  if (!s->decide_by)
    return 0;
  j->decider = calloc(1, sizeof *j->decider);
  if (!j->decider)
    return image_no_memory(error, s->decide_by);
  job_frame *f = j->decider;
  f->path = s->decide_by;
  if (image_read_header(f->path, &header, error) != 0)
    return -1;
  int failed =
      channel_map_read(f->path, &header, &s->source, &f->map, error) != 0 ||
      channel_map_check(&f->map, f->path, error) != 0 ||
      frame_camera_read(f->path, &header, &f->map, s->camera, &s->source,
                        &f->seen, &f->camera_path, error) != 0;
  f->map.window = f->map.data;
  if (!failed && f->map.kind != j->frames[0].map.kind)
    failed =
        image_fail(error,
                   "--decide-by %s: is read as %s, but %s as %s; a frame "
                   "of the sequence is needed",
                   f->path, source_table[f->map.kind].word, j->frames[0].path,
                   source_table[j->frames[0].map.kind].word);
  if (!failed)
    failed = frame_camera_aim(f->path, &f->seen, &f->map, &f->camera, error);
  image_free(&header);
  return failed ? -1 : 0;
}

/* The first frame's pixels decide the conventions of all. */
static int settle_conventions(job *j, image_error *error) {
  job_frame *first = job_first(j);
  findings found;
  if (conventions_settle(first->path, &first->map, &found, error) != 0)
    return -1;
  for (int i = 0; !j->settings->quiet && i < found.count; i++)
    report_note(first->path, "", found.text[i]);
  for (job_frame *f = j->frames; f < j->frames + j->count; f++)
    channel_map_read_alike(&f->map, &first->map);
  return 0;
}

/* This is no error: occlusion and bent cones need no light, and emission may be
 * all that there is. */
static void warn_without_light(const job *j) {
  const channel_map *map = &j->frames[0].map;
  if (j->settings->quiet || j->config.model.mode != HBIL_MODE_HBIL ||
      map->count[ROLE_DIRECT])
    return;
  report_note(j->frames[0].path, "warning: ",
              map->count[ROLE_EMISSION]
                  ? "no direct light; emission alone lights the frame (hbil "
                    "info lists channels that aren't used)"
                  : "no direct light and no emission; near_irradiance will be "
                    "black");
}

int job_frames_check(job *j, char *const *files, image_error *error) {
  for (int i = 0; i < j->count; i++) {
    job_frame *f = &j->frames[i];
    f->path = files[i];
    f->stem = path_stem_in(j->settings->output, f->path);
    if (!f->stem)
      return image_no_memory(error, f->path);
    if (check_header(j, f, error) != 0)
      return -1;
  }
  tell_reading(j);
  warn_without_light(j);
  tell_fitted_camera(j);
  return aim_cameras(j, error) != 0 || read_decider(j, error) != 0 ||
                 settle_conventions(j, error) != 0
             ? -1
             : 0;
}

/* ------------------------------------------------------------------------ */
/* Views: pictures of the place, for the radiance cache                      */

/* What the cache reads of a view as it reads the frames: one set of formats. */
static int check_view_conventions(const job *j, const job_frame *v,
                                  image_error *error) {
  hbil_config frames, views;
  hbil_config_init(&frames);
  hbil_config_init(&views);
  channel_map_configure(&j->frames[0].map, &frames);
  channel_map_configure(&v->map, &views);
  const hbil_inputs *a = &frames.inputs, *b = &views.inputs;
  const char *what = a->depth_kind != b->depth_kind       ? "kind of depth"
                     : a->normal_space != b->normal_space ? "space of normals"
                     : a->direct_scale != b->direct_scale
                         ? "unit of direct light"
                     : a->depth_scale != b->depth_scale ||
                             a->normal_scale[0] != b->normal_scale[0] ||
                             a->normal_scale[1] != b->normal_scale[1] ||
                             a->normal_scale[2] != b->normal_scale[2]
                         ? "direction of axes"
                         : NULL;
  if (!what && v->seen.mirrored == j->frames[0].seen.mirrored)
    return 0;
  return image_fail(error,
                    "%s: another %s than that of %s; a view of the same "
                    "renderer and conventions is needed",
                    v->path, what ? what : "handedness", j->frames[0].path);
}

/* Whether the view has all that the cache reads. */
static int check_view_roles(const job *j, const job_frame *v,
                            image_error *error) {
  const size_t *const count = v->map.count;
  const int finished = j->settings->view_light == HBIL_VIEW_FINISHED;
  if (channel_map_check(&v->map, v->path, error) != 0)
    return -1;
  if (finished && !(count[ROLE_DIRECT] && count[ROLE_INDIRECT]))
    return image_fail(error,
                      "%s: no %s light; --view-light radiance needs direct and "
                      "indirect light (Blender's DiffDir and DiffInd)",
                      v->path, count[ROLE_DIRECT] ? "indirect" : "direct");
  if (!count[ROLE_DIRECT] && !count[ROLE_EMISSION])
    return image_fail(error,
                      "%s: no direct light and no emission; a view needs one "
                      "of them",
                      v->path);
  return 0;
}

/* A file of --camera is that of the frames, but all positions tell cameras. */
static const char *camera_of_view(const job *j, const job_frame *v) {
  const char *camera = j->settings->camera;
  return camera && strcmp(camera, "positions") == 0 &&
                 v->map.count[ROLE_POSITION]
             ? camera
             : NULL;
}

static int read_view_header(const job *j, job_frame *v, image_error *error) {
  const source_options *source = &j->settings->source;
  image header;
  if (image_read_header(v->path, &header, error) != 0)
    return -1;
  int failed =
      channel_map_read(v->path, &header, source, &v->map, error) != 0 ||
      check_view_roles(j, v, error) != 0 ||
      frame_camera_read(v->path, &header, &v->map, camera_of_view(j, v), source,
                        &v->seen, &v->camera_path, error) != 0;
  image_free(&header);
  if (!failed && !v->seen.placed)
    failed = image_fail(error,
                        "%s: the place of its camera is unknown (%s); a view "
                        "needs FILE.json beside it, or a camera in its header",
                        v->path, v->seen.from);
  return failed ? -1 : 0;
}

/* What the first frame's pixels have decided counts for views of the same
 * renderer, too, since a view may show too little to decide it. */
static int settle_view(const job *j, job_frame *v, image_error *error) {
  const conventions *first = &j->frames[0].map.how;
  conventions *how = &v->map.how;
  findings found;
  if (v->map.kind == j->frames[0].map.kind) {
    how->normals = first->normals;
    how->encoded = first->encoded;
    how->backwards = first->backwards;
    how->sky_depth = first->sky_depth;
    how->lamps_from = first->lamps_from;
    if (how->depth == DEPTH_PLANAR && first->depth == DEPTH_RAY)
      how->depth = DEPTH_RAY;
  }
  return conventions_settle(v->path, &v->map, &found, error);
}

static int check_view(job *j, job_frame *v, image_error *error) {
  if (read_view_header(j, v, error) != 0)
    return -1;
  v->map.window = v->map.data;
  if (frame_camera_aim(v->path, &v->seen, &v->map, &v->camera, error) != 0 ||
      settle_view(j, v, error) != 0)
    return -1;
  if (v->seen.fitted && !j->settings->quiet)
    report_note(v->path, "", "its camera is fitted to the positions");
  return check_view_conventions(j, v, error);
}

/* Checks so many files, and appends them to a list. */
static int check_views(job *j, char *const *files, unsigned count,
                       job_frame **list, int *done, image_error *error) {
  if (!count)
    return 0;
  *list = calloc(count, sizeof **list);
  if (!*list)
    return image_no_memory(error, files[0]);
  for (; *done < (int)count; ++*done) {
    job_frame *v = &(*list)[*done];
    v->path = files[*done];
    if (check_view(j, v, error) != 0) {
      ++*done; /* counted, so that job_free() frees it */
      return -1;
    }
  }
  return 0;
}

int views_check(job *j, image_error *error) {
  const process_settings *s = j->settings;
  return check_views(j, s->views, s->view_count, &j->views, &j->view_count,
                     error) != 0 ||
                 check_views(j, s->light_views, s->light_view_count, &j->lights,
                             &j->light_count, error) != 0
             ? -1
             : 0;
}
