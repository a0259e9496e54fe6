/* Reads the frames of a job. */
#include "tool/frame_source.h"

#include "dump/frame_check.h"
#include "dump/read_gbuffer.h"
#include "dump/surface_points.h"
#include "image/error.h"
#include "image/exr_read.h"
#include "image/image.h"
#include "tool/progress.h"
#include "tool/report.h"

#include <stdlib.h>
#include <string.h>

/* check: of this frame; NULL: it isn't checked yet. */
static void warn(frame_source *s, const job_frame *f, const gbuffer *g,
                 const frame_check *check) {
  frame_check own;
  if (s->job->settings->quiet || s->warned)
    return;
  if (!check)
    frame_check_run(g, &s->job->config, &f->map.camera, &own);
  const findings *found = check ? &check->found : &own.found;
  for (int i = 0; i < found->count; i++) {
    progress_line_begin();
    report_note(f->path, "warning: ", found->text[i]);
    progress_line_end();
  }
  s->warned = found->count > 0;
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
  return 0;
}

int frame_source_read(frame_source *s, size_t item, gbuffer *out,
                      image_error *error) {
  if (take_or_read(s, item, out, error) != 0)
    return -1;
  if (s->job->settings->exact) /* knows no depth buffers */
    surface_depths_make_planar(out);
  return 0;
}

int frame_source_read_copied(const frame_source *s, size_t item, image *out,
                             image_error *error) {
  const char *path = s->job->frames[item].path;
  image header, layers = {0};
  if (exr_read_header(path, &header, error) != 0)
    return -1;
  const char **names = calloc(header.count + 1, sizeof *names);
  size_t count = 0;
  int failed = !names || layers_image(s->job->layers, 0, 0, &layers) != 0
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
