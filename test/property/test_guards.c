/*
 * Kernels write nothing outside of their buffers, and what a buffer holds
 * before the first frame doesn't matter.
 */
#include "test/support/fixture.h"
#include "test/support/shim.h"

#define FRAMES 5

static const int sizes[][2] = {{1, 1}, {3, 5}, {67, 35}};
#define SIZES (sizeof sizes / sizeof *sizes)

/* The room, another view of it, and that three times more as static frames. */
static void run_frame(setup *s, int i) {
  s->frame.static_frame = i > 1;
  if (!s->frame.static_frame) {
    setup_load_scene(s, SCENE_ROOM, 3 * (uint32_t)i);
    setup_upload(s);
  }
  setup_run(s, hbil_enqueue_frame);
}

static void check_size(hbil_reprojection reprojection, cl_uint vector_width,
                       int width, int height) {
  setup plain, guarded;
  setup_every_pass(&plain, reprojection, vector_width, width, height);
  setup_every_pass(&guarded, reprojection, vector_width, width, height);
  plain.config.outputs.glossy = guarded.config.outputs.glossy = three_floats;
  if (reprojection == HBIL_REPROJECTION_MOTION) /* ao has its own search */
    plain.config.model.radius = guarded.config.model.radius = 2.0f;
  setup_start_compiled(&plain);
  shim_guard_buffers(true);
  setup_start_compiled(&guarded);
  shim_guard_buffers(false);
  for (int i = 0; i < FRAMES; ++i) {
    run_frame(&plain, i);
    run_frame(&guarded, i);
    exact_planes want = outputs_read(&plain), got = outputs_read(&guarded);
    assert_int_equal(count_different(&got, &want), 0);
    assert_int_equal(shim_overwritten(guarded.device->queue), 0);
    planes_free(&want, &got);
  }
  setup_free(&plain);
  setup_free(&guarded);
}

TEST(vectors_stay_inside) {
  for (size_t i = 0; i < SIZES; ++i)
    check_size(HBIL_REPROJECTION_CAMERA, 0, sizes[i][0], sizes[i][1]);
}

TEST(single_pixels_stay_inside) {
  for (size_t i = 0; i < SIZES; ++i)
    check_size(HBIL_REPROJECTION_CAMERA, 1, sizes[i][0], sizes[i][1]);
}

TEST(motion_stays_inside) {
  for (size_t i = 0; i < SIZES; ++i)
    check_size(HBIL_REPROJECTION_MOTION, 0, sizes[i][0], sizes[i][1]);
}
