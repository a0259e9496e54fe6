/* The views of a job. */
#include "tool/views.h"

#include "dump/read_channel_map.h"
#include "dump/read_gbuffer.h"
#include "dump/settle.h"
#include "image/image_read.h"
#include "tool/job_frames.h"
#include "tool/report.h"

#include <stdlib.h>
#include <string.h>

/* What the cache reads of a view as it reads the frames: one set of formats. */
static int check_conventions(const job *j, const job_frame *v,
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
static int check_roles(const job *j, const job_frame *v, image_error *error) {
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

static int read_header(const job *j, job_frame *v, image_error *error) {
  const source_options *source = &j->settings->source;
  image header;
  if (image_read_header(v->path, &header, error) != 0)
    return -1;
  int failed =
      channel_map_read(v->path, &header, source, &v->map, error) != 0 ||
      check_roles(j, v, error) != 0 ||
      frame_camera_read(v->path, &header, &v->map, NULL, source, &v->seen, &v->camera_path, error) != 0;
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
static int settle(const job *j, job_frame *v, image_error *error) {
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
  if (read_header(j, v, error) != 0)
    return -1;
  v->map.window = v->map.data;
  if (frame_camera_aim(v->path, &v->seen, &v->map, &v->camera, error) != 0 ||
      settle(j, v, error) != 0)
    return -1;
  if (v->seen.fitted && !j->settings->quiet)
    report_note(v->path, "", "its camera is fitted to the positions");
  return check_conventions(j, v, error);
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
