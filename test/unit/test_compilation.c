/*
 * Nothing is compiled after a plan was made: PoCL compiles a kernel at its
 * first launch, in variants by the size and the offset of the launch, and
 * stores each variant in a file.  The tests count these files in a cache of
 * their own, which is empty at first.
 */
#define _POSIX_C_SOURCE 200112L /* setenv */
#include "test/support/fixture.h"
#include "test/support/folder.h"
#include "test/support/cache.h"
#include "test/support/room.h"

static char cache[MOST_PATH];

static int count_variants(void) {
  return folder_count(cache, ".so");
}

/* A first frame, one of another camera, static ones, a reset, and a frame in
 * single passes. */
static void run_frames(setup *s) {
  setup_run(s, hbil_enqueue_frame);
  setup_load_scene(s, SCENE_ROOM, 1);
  setup_upload(s);
  setup_run(s, hbil_enqueue_frame);
  s->frame.static_frame = CL_TRUE;
  for (int i = 0; i < 3; ++i)
    setup_run(s, hbil_enqueue_frame);
  s->frame.static_frame = CL_FALSE;
  hbil_plan_reset(s->plan);
  setup_run(s, hbil_enqueue_frame);
  for (int i = 0; i < PASSES; ++i)
    setup_run(s, passes[i]);
}

static void check(setup *s) {
  const int before = count_variants();
  setup_start_compiled(s);
  const int created = count_variants();
  assert_true(created > before);
  run_frames(s);
  assert_int_equal(count_variants(), created);
  setup_free(s);
}

TEST(vectors_by_the_camera) {
  setup s;
  skip_unless_pocl();
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, 40, 24);
  check(&s);
}

TEST(motion_with_shared_slices) {
  setup s;
  skip_unless_pocl();
  setup_every_pass(&s, HBIL_REPROJECTION_MOTION, 0, 40, 24);
  s.config.sampling.slices = s.config.sampling.slice_frames = 2;
  check(&s);
}

/* Only composite writes AO, so only composite is compiled for another format of
 * it. */
TEST(passes_share_what_they_do_not_read) {
  setup s;
  skip_unless_pocl();
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, 40, 24);
  s.config.outputs.ao.component = HBIL_FLOAT32;
  setup_start_compiled(&s);
  setup_free(&s);
  const int before = count_variants();
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, 40, 24);
  s.config.outputs.ao.component = HBIL_FLOAT16;
  setup_start_compiled(&s);
  setup_free(&s);
  assert_int_equal(count_variants(), before + 1);
}

/* The kernels of GPUs, in a picture of more columns than one work-group. */
TEST(vectors_of_one) {
  setup s;
  skip_unless_pocl();
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 1, 70, 11);
  s.config.execution.skip &= ~(cl_uint)HBIL_SKIP_HOLES;
  check(&s);
}

/* Every command of a cache, with views of both projections, and a frame. */
TEST(caches_and_their_frames) {
  const double away[3] = {1.0, 0.0, 0.0}, elsewhere[3] = {100.0, 0.0, 0.0};
  const room r = room_lit();
  const hbil_camera camera =
      room_camera(room_middle, AHEAD, ROOM_WIDTH, ROOM_HEIGHT, 75.0);
  setup s;
  skip_unless_pocl();
  room_setup(&s, &r, &camera, ROOM_WIDTH, ROOM_HEIGHT);
  setup_start_compiled(&s);
  s.frame.cache = room_cache(s.device);
  const int created = count_variants();
  hbil_view views[2] = {cache_view(&s, HBIL_VIEW_DIRECT),
                        cache_view(&s, HBIL_VIEW_DIRECT)};
  views[1].projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  for (int i = 0; i < 3; ++i) {
    room_inject(s.device, s.frame.cache, views, 2, (cl_uint)i);
    setup_run(&s, hbil_enqueue_frame);
    assert_success(&s, hbil_enqueue_cache_move(s.frame.cache, s.device->queue,
                                               i ? elsewhere : away, 0, NULL,
                                               NULL));
    setup_run(&s, hbil_enqueue_frame);
  }
  assert_success(&s, hbil_enqueue_cache_reset(s.frame.cache, s.device->queue, 0,
                                              NULL, NULL));
  (void)room_statistics(s.device, s.frame.cache);
  hbil_cache_destroy(s.frame.cache);
  s.frame.cache = NULL;
  setup_run(&s, hbil_enqueue_frame);
  assert_int_equal(count_variants(), created);
  setup_free(&s);
}

int main(void) {
  folder_make(cache);
  setenv("POCL_CACHE_DIR", cache, 1);
  const int failures = run_with_device();
  folder_remove(cache);
  return failures;
}
