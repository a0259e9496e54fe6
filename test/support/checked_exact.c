/* The functions of src/exact that can fail, for tests. */
#include "test/support/checked_exact.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void check(const char *what, exact_status status) {
  if (status != EXACT_SUCCESS)
    fail_msg("%s: %s", what, exact_status_text(status));
}

exact_planes checked_planes(int width, int height, int count) {
  exact_planes planes;
  check("exact_planes_create",
        exact_planes_create(&planes, width, height, count));
  return planes;
}

void planes_free_all(exact_planes *const *list) {
  for (; *list; ++list)
    exact_planes_free(*list);
}

void checked_reproject(const exact_frame *frame, const exact_planes *history,
                       exact_planes *carried) {
  check("exact_reproject", exact_reproject(frame, history, carried));
}

void checked_push_pull(exact_planes *carried) {
  check("exact_push_pull", exact_push_pull(carried));
}

void checked_gather(const exact_frame *frame, const exact_planes *split,
                    exact_planes *gathered) {
  check("exact_gather", exact_gather(frame, split, gathered));
}

void checked_gather_dense(const exact_frame *frame, const exact_planes *split,
                          const exact_dense *how, exact_planes *gathered) {
  check("exact_gather_dense", exact_gather_dense(frame, split, how, gathered));
}

void checked_state(exact_state *state, int width, int height) {
  check("exact_state_create", exact_state_create(state, width, height));
}

void checked_run_frame(exact_state *state, exact_frame *frame) {
  check("exact_run_frame", exact_run_frame(state, frame));
}

void checked_run_frame_dense(exact_state *state, exact_frame *frame,
                             const exact_dense *how) {
  check("exact_run_frame_dense", exact_run_frame_dense(state, frame, how));
}
