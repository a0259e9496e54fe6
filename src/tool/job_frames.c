/* Checks the frames of a job. */
#define _POSIX_C_SOURCE 200809L
#include "tool/job_frames.h"

#include "dump/read_channel_map.h"
#include "dump/settle.h"
#include "image/error.h"
#include "image/image.h"
#include "image/image_read.h"
#include "image/window.h"
#include "tool/paths.h"
#include "tool/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The library's kernels are built for the channels of the first frame. */
static int check_roles(const job *j, const job_frame *f, image_error *error) {
  const int moved = j->config.history.reprojection == HBIL_REPROJECTION_MOTION;
  const float *scale = f->map.how.motion_scale;
  for (int r = 0; r < ROLE_COUNT; r++)
    if (j->frames[0].map.count[r] && !f->map.count[r] && r != ROLE_POSITION &&
        r != ROLE_INDIRECT && r != ROLE_COVERAGE)
      return image_fail(error,
                        "%s: has no %s, which %s has; the same channels in "
                        "every frame are needed",
                        f->path, role_name((role)r), j->frames[0].path);
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
static int check_size(job *j, const job_frame *f, image_error *error) {
  const image_window *first = &j->frames[0].map.display;
  const image_window *own = &f->map.display;
  if (f == j->frames)
    j->window = f->map.data;
  j->window = image_window_union(j->window, f->map.data);
  if (j->window.width > HBIL_MAX_SIZE || j->window.height > HBIL_MAX_SIZE)
    return image_fail(error,
                      "%s: its data window makes that of all frames %u x %u "
                      "pixels; at most %d x %d are possible",
                      f->path, j->window.width, j->window.height, HBIL_MAX_SIZE,
                      HBIL_MAX_SIZE);
  if (own->width != first->width || own->height != first->height)
    return image_fail(error,
                      "%s: %u x %u pixels, but %s has %u x %u; frames of one "
                      "size are needed",
                      f->path, own->width, own->height, j->frames[0].path,
                      first->width, first->height);
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
      check_roles(j, f, error) != 0;
  f->map.held = f == j->frames ? &j->held : NULL;
  failed =
      failed ||
      frame_camera_read(f->path, &header, &f->map, s->camera, &s->source, &f->seen, &f->camera_path, error) != 0 ||
      check_size(j, f, error) != 0;
  image_free(&header);
  return failed ? -1 : 0;
}

/* Fits the cameras to the pixels that are computed.  Pixels outside the picture
 * send light into it and are not written. */
static int aim_cameras(job *j, image_error *error) {
  j->width = j->window.width;
  j->height = j->window.height;
  j->shown = image_window_common(j->window, j->frames[0].map.display);
  if (!j->shown.width)
    return image_fail(error,
                      "%s: none of its pixels lie in its display window; a "
                      "data window that overlaps it is needed",
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
      frame_camera_read(f->path, &header, &f->map, s->camera, &s->source, &f->seen, &f->camera_path, error) != 0;
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
  for (job_frame *f = j->frames; f < j->frames + j->count; f++) {
    const double near = f->map.how.near, far = f->map.how.far;
    f->map.how = first->map.how;
    f->map.how.near = near;
    f->map.how.far = far;
  }
  return 0;
}

/* This is no error: occlusion and bent cones need no light. */
static void warn_without_light(const job *j) {
  const channel_map *map = &j->frames[0].map;
  if (!j->settings->quiet && j->config.model.mode == HBIL_MODE_HBIL &&
      !map->count[ROLE_DIRECT] && !map->count[ROLE_EMISSION])
    report_note(j->frames[0].path, "warning: ",
                "no direct light and no emission; near_irradiance will be "
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
  warn_without_light(j);
  tell_fitted_camera(j);
  return aim_cameras(j, error) != 0 || read_decider(j, error) != 0 ||
                 settle_conventions(j, error) != 0
             ? -1
             : 0;
}
