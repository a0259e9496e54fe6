/* The first frame of a job. */
#define _POSIX_C_SOURCE 200809L
#include "tool/first_frame.h"

#include "dump/read_gbuffer.h"
#include "image/clock.h"

#include <string.h>

unsigned frame_roles(const job *j) {
  const unsigned always = 1u << ROLE_DEPTH | 1u << ROLE_NORMAL |
                          1u << ROLE_ALBEDO | 1u << ROLE_DIRECT |
                          1u << ROLE_EMISSION | 1u << ROLE_BACKGROUND;
  const int moved = j->config.history.reprojection == HBIL_REPROJECTION_MOTION;
  return always | (moved ? 1u << ROLE_MOTION : 0u);
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

int first_frame_take(first_frame *f, gbuffer *out, frame_check *check,
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
