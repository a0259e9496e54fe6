/* Where a sequence goes to another place. */
#include "tool/job_cuts.h"

#include "image/error.h"
#include "tool/extent.h"
#include "tool/frame_numbers.h"
#include "tool/report.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A step of the camera this many times as long as those before and after it may
 * be a cut, and what the frames show decides.  Cameras that begin to move, or
 * speed up, have long steps on one side. */
static const double longest_step = 8.0;

/* It is a cut if the voxels of both sides together would be so many times as
 * wide as the wider ones of the two.  The levels of a cache are powers of two
 * apart, so below that little is gained, and what one side knows of the other
 * is lost. */
static const double wider_voxels = 1.5;

/* ------------------------------------------------------------------------ */
/* The list of places                                                        */

static int start_list(job *j, image_error *error) {
  j->places = malloc((size_t)j->count * sizeof *j->places);
  if (!j->places)
    return image_no_memory(error, j->frames[0].path);
  j->places[0] = (job_place){0, j->count};
  j->place_count = 1;
  return 0;
}

/* The last place ends before this frame, with which another one begins. */
static void cut_before(job *j, int frame) {
  job_place *last = &j->places[j->place_count - 1];
  last->count = frame - last->first;
  last[1] = (job_place){frame, j->count - frame};
  j->place_count++;
}

/* ------------------------------------------------------------------------ */
/* Cuts that are given                                                       */

/* The last number in a file's name; -1: there is none. */
static long number_of(const job_frame *f) {
  const char *name = strrchr(f->stem, '/') + 1;
  const char *end = name + strlen(name);
  while (end > name && !isdigit((unsigned char)end[-1]))
    end--;
  const char *digits = end;
  while (digits > name && isdigit((unsigned char)digits[-1]))
    digits--;
  return digits < end && end - digits <= FRAME_DIGITS ? atol(digits) : -1;
}

/* The frame with this number; j->count: there is none. */
static int frame_of(const job *j, unsigned number) {
  int i = 0;
  while (i < j->count && number_of(&j->frames[i]) != (long)number)
    i++;
  return i;
}

/* Whether a cut has no meaning for a part of a sequence (--frames), which lies
 * before it, or begins with it or behind it. */
static int is_of_another_chunk(const job *j, unsigned number) {
  return j->settings->is_part &&
         ((long)number <= number_of(&j->frames[0]) ||
          (long)number > number_of(&j->frames[j->count - 1]));
}

/* Cuts before all of these frames. */
static int cut_at(job *j, const frame_numbers *asked, image_error *error) {
  const char *text = j->settings->cuts;
  for (size_t i = 0; i < asked->count; i++) {
    if (is_of_another_chunk(j, asked->values[i]))
      continue;
    const int frame = frame_of(j, asked->values[i]);
    if (frame == j->count)
      return image_fail(error, "--cuts %s: no frame has the number %u", text,
                        asked->values[i]);
    if (frame <= j->places[j->place_count - 1].first)
      return image_fail(error,
                        "--cuts %s: frame %u doesn't come behind the first one "
                        "of the place before; others are needed, in the order "
                        "of the frames",
                        text, asked->values[i]);
    cut_before(j, frame);
  }
  return 0;
}

static int cut_where_told(job *j, image_error *error) {
  const char *text = j->settings->cuts;
  frame_numbers asked = {0};
  if (j->settings->view_count || j->settings->light_view_count)
    return image_fail(error,
                      "--cuts %s: not with views, which show one place; a job "
                      "for each place is needed",
                      text);
  const int failed =
      frame_numbers_read(text, &asked, NULL) != 0
          ? image_fail(error,
                       "--cuts %s: none, or numbers of frames with which a "
                       "place begins, such as 7,120, are needed",
                       text)
          : cut_at(j, &asked, error);
  frame_numbers_free(&asked);
  return failed;
}

/* ------------------------------------------------------------------------ */
/* Cuts that are found                                                       */

/* How far the camera goes to this frame; 0 where there is none before. */
static double step_to(const job *j, int frame) {
  if (frame < 1 || frame >= j->count)
    return 0.0;
  const double *a = j->frames[frame - 1].map.camera.world_from_view;
  const double *b = j->frames[frame].map.camera.world_from_view;
  return hypot(hypot(a[3] - b[3], a[7] - b[7]), a[11] - b[11]);
}

/* The first frame from `from` on that the camera leaps to. */
static int next_leap(const job *j, int from) {
  while (from < j->count &&
         !(step_to(j, from) >
           longest_step * fmax(step_to(j, from - 1), step_to(j, from + 1))))
    from++;
  return from;
}

/* The width of voxels for frames from `first` to before `end`. */
static int measure(const job *j, int first, int end, double *out,
                   image_error *error) {
  const size_t count = (size_t)(end - first);
  extent_picture *frames = malloc(count * sizeof *frames);
  hbil_cache_config config;
  hbil_cache_config_init(&config);
  if (!frames)
    return image_no_memory(error, j->frames[first].path);
  for (size_t i = 0; i < count; i++) {
    const job_frame *f = &j->frames[first + (int)i];
    frames[i] = (extent_picture){f->path, &f->map};
  }
  const int failed = extent_choose(frames, count, NULL, 0, &config, error);
  free(frames);
  *out = config.voxel_size;
  return failed;
}

static int cut_where_seen(job *j, image_error *error) {
  double before, behind, both;
  int frame = next_leap(j, 1);
  if (j->count < 3 || frame == j->count)
    return 0;
  if (measure(j, 0, frame, &before, error) != 0)
    return -1;
  while (frame < j->count) {
    const int end = next_leap(j, frame + 1);
    const int first = j->places[j->place_count - 1].first;
    if (measure(j, frame, end, &behind, error) != 0 ||
        measure(j, first, end, &both, error) != 0)
      return -1;
    if (both >= wider_voxels * fmax(before, behind)) {
      cut_before(j, frame);
      before = behind;
    } else {
      before = both;
    }
    frame = end;
  }
  return 0;
}

/* Whether all that is known is in the frames, and a cache is possible. */
static int looks_for_cuts(const job *j) {
  const process_settings *s = j->settings;
  return !s->exact && !s->paper && !settings_without_cache(s) &&
         j->config.model.mode == HBIL_MODE_HBIL && !s->view_count &&
         !s->light_view_count && !s->cache_load && !s->cache_save &&
         !j->decider;
}

/* "hbil: frame_0007.exr: another place, 118 units away; it has a radiance cache
 * of its own (--cuts)" */
static void tell(const job *j) {
  char text[128];
  for (int i = 1; i < j->place_count; i++) {
    const int frame = j->places[i].first;
    snprintf(text, sizeof text,
             "a cut: another place, %.3g units away, which has a radiance "
             "cache of its own (--cuts)",
             step_to(j, frame));
    report_note(j->frames[frame].path, "", text);
  }
}

int job_cuts_find(job *j, image_error *error) {
  const char *given = j->settings->cuts;
  if (start_list(j, error) != 0 ||
      (given && strcmp(given, "none") != 0 && cut_where_told(j, error) != 0) ||
      (!given && looks_for_cuts(j) && cut_where_seen(j, error) != 0))
    return -1;
  if (!j->settings->quiet)
    tell(j);
  return 0;
}
