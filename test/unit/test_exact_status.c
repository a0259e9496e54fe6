/*
 * The exact integral returns its errors: every allocation of a sequence may
 * fail, and arguments that make no sense are rejected.  Linked with
 * --wrap=calloc, the one way in which src/exact allocates.
 */
#include <stdlib.h>
#include <string.h>

#include "exact/cache.h"
#include "exact/passes.h"
#include "test/support/tests.h"

enum { WIDTH = 20, HEIGHT = 12, NEVER = -1 };

static int allocations_left = NEVER; /* before one fails */

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);

void *__wrap_calloc(size_t count, size_t size) {
  if (allocations_left == 0)
    return NULL;
  if (allocations_left > 0)
    allocations_left--;
  return __real_calloc(count, size);
}

/* A plane that faces the camera, in direct light. */
typedef struct fixture {
  hbil_config config;
  float depth[WIDTH * HEIGHT], minus_one[WIDTH * HEIGHT], zero[WIDTH * HEIGHT];
  exact_frame frame;
} fixture;

static void fixture_init(fixture *f, hbil_reprojection reprojection) {
  memset(f, 0, sizeof(*f));
  hbil_config_init(&f->config);
  f->config.width = WIDTH;
  f->config.height = HEIGHT;
  f->config.history.reprojection = reprojection;
  f->config.model.relative_thickness = 0.1f;
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    f->depth[i] = 3.0f;
    f->minus_one[i] = -1.0f;
  }
  f->frame.config = &f->config;
  f->frame.camera.fx = f->frame.camera.fy = 20.0;
  f->frame.camera.cx = 0.5 * WIDTH;
  f->frame.camera.cy = 0.5 * HEIGHT;
  for (int i = 0; i < 16; i += 5)
    f->frame.camera.world_from_view[i] = 1.0;
  f->frame.input[EXACT_DEPTH] = f->depth;
  f->frame.input[EXACT_NORMAL] = f->frame.input[EXACT_NORMAL + 1] = f->zero;
  f->frame.input[EXACT_NORMAL + 2] = f->minus_one;
  f->frame.input[EXACT_MOTION] = f->frame.input[EXACT_MOTION + 1] = f->zero;
}

/* Two frames, the second one with history. */
static exact_status run_sequence(fixture *f, const exact_dense *how) {
  exact_state state;
  exact_status status = exact_state_create(&state, WIDTH, HEIGHT);
  for (int i = 0; i < 2 && status == EXACT_SUCCESS; ++i)
    status = how ? exact_run_frame_dense(&state, &f->frame, how)
                 : exact_run_frame(&state, &f->frame);
  exact_state_free(&state);
  return status;
}

/* Whichever allocation fails, the status tells, until none does. */
static void check_allocations(hbil_reprojection reprojection,
                              const exact_dense *how) {
  exact_status status = EXACT_OUT_OF_MEMORY;
  fixture f;
  fixture_init(&f, reprojection);
  int count = 0;
  for (; status != EXACT_SUCCESS; ++count) {
    allocations_left = count;
    status = run_sequence(&f, how);
    allocations_left = NEVER;
    assert_true(status == EXACT_SUCCESS || status == EXACT_OUT_OF_MEMORY);
  }
  assert_true(count > 10);
}

TEST(every_failed_allocation_is_a_status) {
  const exact_dense how = {.slices = 2, .threads = 2};
  for (int r = HBIL_REPROJECTION_NONE; r <= HBIL_REPROJECTION_MOTION; ++r) {
    check_allocations((hbil_reprojection)r, NULL);
    check_allocations((hbil_reprojection)r, &how);
  }
}

/* A cache whose move fails stays as it was. */
TEST(a_cache_without_memory_is_a_status) {
  const double away[3] = {3.0, 0.0, 0.0};
  hbil_cache_config config;
  exact_cache cache;
  exact_probes probes;
  fixture f;
  fixture_init(&f, HBIL_REPROJECTION_NONE);
  hbil_cache_config_init(&config);
  config.voxels = 16;
  config.voxel_size = 0.5;
  allocations_left = 0;
  assert_int_equal(exact_cache_create(&cache, &config), EXACT_OUT_OF_MEMORY);
  exact_cache_free(&cache);
  assert_int_equal(exact_probes_create(&probes, &f.config),
                   EXACT_OUT_OF_MEMORY);
  exact_probes_free(&probes);
  allocations_left = 1;
  assert_int_equal(exact_cache_create(&cache, &config), EXACT_SUCCESS);
  cache.all[0].state = HBIL_VOXEL_EMPTY;
  assert_int_equal(exact_cache_move(&cache, away), EXACT_OUT_OF_MEMORY);
  assert_int_equal(cache.middle[0], 0);
  assert_int_equal(cache.all[0].state, HBIL_VOXEL_EMPTY);
  allocations_left = NEVER;
  exact_cache_free(&cache);
}

TEST(sizes_out_of_range_are_rejected) {
  exact_planes planes;
  exact_state empty;
  assert_int_equal(exact_planes_create(&planes, 0, 1, 1), EXACT_BAD_ARGUMENT);
  assert_int_equal(exact_planes_create(&planes, 1, -1, 1), EXACT_BAD_ARGUMENT);
  assert_int_equal(exact_planes_create(&planes, 1, 1, 0), EXACT_BAD_ARGUMENT);
  assert_int_equal(exact_planes_create(&planes, INT32_MAX, INT32_MAX, 1),
                   EXACT_OUT_OF_MEMORY);
  assert_null(planes.values);
  assert_int_equal(exact_state_create(&empty, 0, 0), EXACT_BAD_ARGUMENT);
  exact_state_free(&empty);
}

TEST(frames_that_do_not_fit_are_rejected) {
  const exact_dense none = {.slices = 0};
  fixture f;
  fixture_init(&f, HBIL_REPROJECTION_NONE);
  assert_int_equal(run_sequence(&f, &none), EXACT_BAD_ARGUMENT);
  f.frame.input[EXACT_DIRECT + 1] = f.zero; /* green alone */
  assert_int_equal(run_sequence(&f, NULL), EXACT_BAD_ARGUMENT);
  fixture_init(&f, HBIL_REPROJECTION_NONE);
  f.frame.input[EXACT_DEPTH] = NULL;
  assert_int_equal(run_sequence(&f, NULL), EXACT_BAD_ARGUMENT);
  fixture_init(&f, HBIL_REPROJECTION_MOTION);
  f.frame.input[EXACT_MOTION] = NULL;
  assert_int_equal(run_sequence(&f, NULL), EXACT_BAD_ARGUMENT);
  fixture_init(&f, HBIL_REPROJECTION_NONE);
  f.config.width = WIDTH + 1;
  assert_int_equal(run_sequence(&f, NULL), EXACT_BAD_ARGUMENT);
}

int main(void) {
  return tests_run();
}
