/*
 * Packed storage changes frames by less than the noise of any sampling: every
 * output stays within a limit of the same frame in FLOAT32 and of the exact
 * passes in double precision.
 */
#include "test/support/stages.h"

#define WIDTH 160
#define HEIGHT 90

/* Root of the mean squared difference over the mean. */
static double rmse_over_mean(const exact_planes *got, const exact_planes *want,
                             plane_id id) {
  size_t plane = (size_t)want->width * (size_t)want->height;
  size_t total = plane * (size_t)plane_channels(id);
  size_t start = plane * (size_t)plane_first(id);
  double off = 0.0, sum = 0.0;
  for (size_t i = start; i < start + total; ++i) {
    double d = got->values[i] - want->values[i];
    off += d * d;
    sum += fabs(want->values[i]);
  }
  if (!isfinite(off))
    return INFINITY;
  return sqrt(off * (double)total) / sum;
}

/* Measured, the worst of these frames: AO 2.7e-5, E_near 2.1e-3; the others
 * follow from them.  The bent normal is left out: where nothing is open, its
 * word has no direction. */
static const struct {
  plane_id id;
  double limit;
} limits[] = {{PLANE_AO, 1e-4},         {PLANE_NEAR, 2.2e-3},
              {PLANE_FAR, 2.2e-3},      {PLANE_CONE, 1e-4},
              {PLANE_INDIRECT, 2.2e-3}, {PLANE_BEAUTY, 2.2e-3}};
#define LIMITS (sizeof(limits) / sizeof(*limits))

/* Updates the largest deviation of each output. */
static void compare_frames(const exact_planes *got, const exact_planes *want,
                           double worst[LIMITS]) {
  for (size_t i = 0; i < LIMITS; ++i)
    worst[i] = fmax(worst[i], rmse_over_mean(got, want, limits[i].id));
}

static void start_frames(setup *s, scene_kind kind, bool unseen_estimated,
                         hbil_storage storage) {
  setup_scene(s, kind, WIDTH, HEIGHT, 0);
  setup_all_outputs(s);
  s->config.sampling.storage = storage;
  s->config.model.far_field = HBIL_FAR_CONSTANT;
  for (int c = 0; c < 3 && !unseen_estimated; ++c)
    s->frame.environment[0][c] = 0.5f + (float)c;
  if (unseen_estimated) {
    s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
    s->config.model.far_field = HBIL_FAR_FRAME;
  }
  setup_start(s);
}

static exact_planes frame(setup *s, scene_kind kind, uint32_t index) {
  setup_load_scene(s, kind, index);
  s->frame.frame_index = index;
  setup_upload(s);
  setup_run(s, hbil_enqueue_frame);
  return outputs_read(s);
}

/* Three frames, against FLOAT32 and against the exact passes. */
static void check_frames(scene_kind kind, bool unseen_estimated) {
  setup plain, packed;
  exact_state expected;
  double worst[LIMITS] = {0.0};
  start_frames(&plain, kind, unseen_estimated, HBIL_STORAGE_FLOAT32);
  start_frames(&packed, kind, unseen_estimated, HBIL_STORAGE_PACKED);
  checked_state(&expected, WIDTH, HEIGHT);
  for (uint32_t i = 0; i < 3; ++i) {
    exact_planes want = frame(&plain, kind, i), got = frame(&packed, kind, i);
    checked_run_frame(&expected, &plain.job);
    compare_frames(&got, &want, worst);
    compare_frames(&got, &expected.out, worst);
    planes_free(&want, &got);
  }
  exact_state_free(&expected);
  setup_free(&plain);
  setup_free(&packed);
  for (size_t i = 0; i < LIMITS; ++i)
    check_at_most(plane_name(limits[i].id), worst[i], limits[i].limit);
}

TEST(frames_of_a_room_stay_near) {
  check_frames(SCENE_ROOM, false);
}

TEST(frames_under_a_sky_stay_near) {
  check_frames(SCENE_SKY, false);
}

TEST(frames_with_estimated_light_stay_near) {
  check_frames(SCENE_ROOM, true);
  check_frames(SCENE_SKY, true);
}
