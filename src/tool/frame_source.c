/* Reads the frames of a job. */
#define _POSIX_C_SOURCE 200809L
#include "tool/frame_source.h"

#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"
#include "image/clock.h"
#include "image/exr_read.h"
#include "tool/job_camera.h"
#include "tool/report.h"

#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* The first frame                                                           */

/* The roles of a frame, a bit mask, that the computation uses. */
static unsigned frame_roles(const job *j) {
  const unsigned always = 1u << ROLE_DEPTH | 1u << ROLE_NORMAL |
                          1u << ROLE_ALBEDO | 1u << ROLE_DIRECT |
                          1u << ROLE_EMISSION | 1u << ROLE_BACKGROUND;
  const int moved = j->config.history.reprojection == HBIL_REPROJECTION_MOTION;
  const unsigned picture =
      1u << ROLE_PICTURE | 1u << ROLE_ALPHA | 1u << ROLE_INDIRECT;
  return always | (moved ? 1u << ROLE_MOTION : 0u) |
         (j->replaces ? picture : 0u);
}

/* Takes the way to the file's planes, which nobody else reads from now on. */
static void adopt(first_frame *f, job *j) {
  f->job = j;
  f->map = j->frames[0].map;
  j->frames[0].map.held = NULL;
  j->held.is_last = 1;
}

static int read_adopted(first_frame *f, image_error *error) {
  const unsigned roles = frame_roles(f->job) | 1u << ROLE_POSITION;
  const double start = seconds_now();
  f->failed =
      gbuffer_read(f->job->frames[0].path, &f->map, roles, &f->g, error);
  f->is_read = !f->failed;
  f->seconds = seconds_now() - start;
  return f->failed;
}

int first_frame_read(first_frame *f, job *j, image_error *error) {
  adopt(f, j);
  return read_adopted(f, error);
}

static void *read_and_check(void *user) {
  first_frame *f = user;
  const job_frame *frame = &f->job->frames[0];
  if (!f->is_read && read_adopted(f, &f->error) != 0)
    return NULL;
  if (f->job->settings->quiet)
    return NULL;
  frame_check_run(&f->g, &f->job->config, &frame->map.camera, &f->check);
  f->is_checked = 1;
  return NULL;
}

void first_frame_begin(first_frame *f, job *j) {
  if (!f->is_read)
    adopt(f, j);
  f->runs = pthread_create(&f->thread, NULL, read_and_check, f) == 0;
}

static void wait_for(first_frame *f) {
  if (f->runs)
    pthread_join(f->thread, NULL);
  f->runs = 0;
}

/* Waits for the thread and hands the frame over, which the caller frees, and
 * what the check found; *checked: whether there was one.  Returns 1 for a
 * frame, 0 if the frame has to be read, or -1 with `error` filled. */
static int first_frame_take(first_frame *f, gbuffer *out, frame_check *check,
                            int *checked, image_error *error) {
  wait_for(f);
  *checked = f->is_checked;
  if (f->failed) {
    *error = f->error;
    return -1;
  }
  if (!f->is_read)
    return 0;
  *out = f->g;
  *check = f->check;
  memset(&f->g, 0, sizeof f->g);
  f->is_read = f->is_checked = 0;
  return 1;
}

void first_frame_free(first_frame *f) {
  wait_for(f);
  if (f->is_read)
    gbuffer_free(&f->g);
  f->is_read = 0;
}

/* ------------------------------------------------------------------------ */
/* All frames                                                                */

static void report_findings(const char *path, const findings *found) {
  for (int i = 0; i < found->count; i++) {
    progress_line_begin();
    report_note(path, "warning: ", found->text[i]);
    progress_line_end();
  }
}

int first_frame_tell(first_frame *f, image_error *error) {
  wait_for(f);
  if (f->failed) {
    *error = f->error;
    return -1;
  }
  if (f->is_checked)
    report_findings(f->job->frames[0].path, &f->check.found);
  return 0;
}

/* check: of this frame; NULL: it isn't checked yet. */
static void warn(frame_source *s, const job_frame *f, const gbuffer *g,
                 const frame_check *check) {
  frame_check own;
  if (s->job->settings->quiet || s->warned)
    return;
  if (!check)
    frame_check_run(g, &s->job->config, &f->map.camera, &own);
  const findings *found = check ? &check->found : &own.found;
  report_findings(f->path, found);
  s->warned = found->count > 0;
}

static int is_zero(const gbuffer *g, role r) {
  for (size_t c = 0; c < g->map.count[r]; c++)
    for (size_t i = 0; i < gbuffer_pixels(g); i++)
      if (gbuffer_plane(g, r, c)[i] != 0.0f)
        return 0;
  return 1;
}

/* Warns of a second frame without motion under a camera that has moved since
 * the first one.  Blender writes that with motion blur. */
static void check_motion(const frame_source *s, const gbuffer *g) {
  const job *j = s->job;
  const hbil_camera *two[] = {&j->frames[0].map.camera,
                              &j->frames[1].map.camera};
  const camera_path path = {two, 2, j->config.inputs.projection, j->width,
                            j->height};
  if (j->settings->quiet || !g->map.count[ROLE_MOTION] ||
      !is_zero(g, ROLE_MOTION) ||
      camera_motion_find(&path, job_camera_depths(g)).kind != CAMERA_MOVES)
    return;
  progress_line_begin();
  report_note(j->frames[1].path, "warning: ",
              "its motion vectors are all 0 though the camera moves, as with "
              "motion blur in Blender: render without it, or take "
              "--reprojection camera");
  progress_line_end();
}

/* Takes what has been read already, or reads the frame. */
static int take_or_read(frame_source *s, size_t item, gbuffer *out,
                        image_error *error) {
  const job_frame *f = &s->job->frames[item];
  /* positions only check depth and camera, once */
  const unsigned roles =
      frame_roles(s->job) | (item ? 0u : 1u << ROLE_POSITION);
  frame_check check;
  int checked = 0;
  const int taken =
      item ? 0 : first_frame_take(s->first, out, &check, &checked, error);
  if (taken < 0 ||
      (!taken && gbuffer_read(f->path, &f->map, roles, out, error) != 0))
    return -1;
  warn(s, f, out, checked ? &check : NULL);
  if (item == 1)
    check_motion(s, out);
  return 0;
}

/* Nobody else needs the positions of the first frame. */
static void drop_positions(gbuffer *g) {
  for (size_t c = 0; c < g->map.count[ROLE_POSITION]; c++) {
    image_plane *plane = image_find(&g->planes, g->map.names[ROLE_POSITION][c]);
    if (plane && !plane->is_lent) {
      free(plane->pixels);
      plane->pixels = NULL;
    }
  }
  g->map.count[ROLE_POSITION] = 0;
}

int frame_source_read_learnt(const job *j, const job_frame *f, int is_view,
                             unsigned roles, gbuffer *out, image_error *error) {
  const int is_checked = !j->settings->quiet && is_view;
  const unsigned more = is_checked ? 1u << ROLE_POSITION : 0u;
  frame_check check;
  if (gbuffer_read(f->path, &f->map, roles | more, out, error) != 0)
    return -1;
  if (!is_checked)
    return 0;
  frame_check_run(out, NULL, &f->map.camera, &check);
  if (f->map.projection == HBIL_PROJECTION_ORTHOGRAPHIC &&
      j->frames[0].map.projection == HBIL_PROJECTION_PERSPECTIVE)
    findings_add(&check.found,
                 "its rays are parallel; if it is a picture from the sun, it "
                 "shows lit surfaces alone and makes places too bright: leave "
                 "it out, or compare --far rsm --light-view");
  report_findings(f->path, &check.found);
  drop_positions(out);
  return 0;
}

size_t frame_source_bytes(const job *j, size_t item) {
  return gbuffer_read_bytes(&j->frames[item].map, frame_roles(j));
}

int frame_source_read(frame_source *s, size_t item, image_memory *memory,
                      gbuffer *out, image_error *error) {
  image_memory_empty(memory, frame_source_bytes(s->job, item));
  image_memory_select(memory);
  const int failed = take_or_read(s, item, out, error);
  if (!failed) {
    drop_positions(out);
    image_memory_move(&out->planes);
    gbuffer_index(out);
  }
  image_memory_select(NULL);
  if (!failed && s->job->settings->exact) /* knows no depth buffers */
    surface_depths_make_planar(out);
  return failed;
}

int frame_source_read_copied(const frame_source *s, size_t item, image *out,
                             image_error *error) {
  const char *path = s->job->frames[item].path;
  image header, layers = {0};
  if (exr_read_header(path, &header, error) != 0)
    return -1;
  const char **names = calloc(header.count + 1, sizeof *names);
  size_t count = 0;
  int failed = !names || layers_image(s->job->layers, 0, 0, 0, &layers) != 0
                   ? image_no_memory(error, path)
                   : 0;
  for (size_t i = 0; !failed && i < header.count; i++)
    if (!image_find(&layers, header.planes[i].name))
      names[count++] = header.planes[i].name;
  if (!failed)
    failed = exr_read_as_is(path, names, count, out, error);
  if (!failed) { /* the names of channels mean views as in the frame */
    out->view_count = header.view_count;
    memcpy(out->views, header.views, sizeof out->views);
  }
  free(names);
  image_free(&layers);
  image_free(&header);
  return failed;
}
