/*
 * The exact integral of src/exact against itself: GTAO is HBIL without light,
 * threads and masks change no value, and plans approach it with more samples.
 */
#include "test/support/stages.h"

static void start_room(setup *s, hbil_mode mode, float thickness) {
  setup_scene(s, SCENE_ROOM, 64, 36, 0);
  setup_load_view(s, SCENE_ROOM, 90.0, 0);
  setup_mode(s, mode);
  s->config.model.thickness = thickness;
  setup_start(s);
}

/* Derived: two forms of one integral.  Measured: 8.3e-16 and 2.2e-16. */
TEST(gtao_has_the_occlusion_of_hbil) {
  const exact_dense how = {.slices = 37};
  for (int dense = 0; dense < 2; ++dense) {
    setup hbil, gtao;
    exact_planes want, got;
    start_room(&hbil, HBIL_MODE_HBIL, INFINITY);
    start_room(&gtao, HBIL_MODE_GTAO, INFINITY);
    want = dense ? expected_gathered_densely(&hbil, &how)
                 : expected_gathered(&hbil);
    got = dense ? expected_gathered_densely(&gtao, &how)
                : expected_gathered(&gtao);
    check_at_most("AO", largest_error(&got, &want, HBIL_LIGHT_AO, 1), 1e-12);
    check_at_most("bent", largest_error(&got, &want, HBIL_LIGHT_BENT, 3),
                  1e-12);
    check_at_most("light", largest_value(&got, HBIL_LIGHT_RED, 3), 0.0);
    check_at_most("unknown", largest_value(&got, HBIL_LIGHT_UNKNOWN, 1), 0.0);
    assert_true(largest_value(&want, HBIL_LIGHT_RED, 3) > 0.1);
    planes_free(&want, &got);
    setup_free(&hbil);
    setup_free(&gtao);
  }
}

typedef struct progress {
  int calls, done, count;
} progress;

static void note_progress(void *user, int done, int count) {
  progress *p = user;
  assert_true(done >= p->done && done <= count);
  p->done = done;
  p->count = count;
  ++p->calls;
}

/* Every row is reported, whatever the number of threads. */
TEST(any_number_of_threads_gives_the_same) {
  const int threads[] = {1, 2, 3, 7, 50};
  const exact_dense two = {.slices = 16};
  setup s;
  exact_planes want;
  start_room(&s, HBIL_MODE_HBIL, 0.1f);
  want = expected_gathered_densely(&s, &two);
  for (int i = 0; i < 5; ++i) {
    progress seen = {0, 0, 0};
    const exact_dense how = {.slices = 16,
                             .threads = threads[i],
                             .progress = note_progress,
                             .user = &seen};
    exact_planes got = expected_gathered_densely(&s, &how);
    assert_int_equal(count_different(&got, &want), 0);
    assert_true(seen.done == 36 && seen.count == 36);
    assert_true(seen.calls > 36 / threads[i]);
    exact_planes_free(&got);
  }
  exact_planes_free(&want);
  setup_free(&s);
}

TEST(masked_pixels_stay_as_they_are) {
  unsigned char wanted[64 * 36] = {0};
  const exact_dense all = {.slices = 16};
  const exact_dense some = {.slices = 16, .mask = wanted};
  exact_planes split, want, got = checked_planes(64, 36, HBIL_LIGHT_PLANES);
  setup s;
  start_room(&s, HBIL_MODE_HBIL, INFINITY);
  split = expected_split(&s);
  want = expected_gathered_densely(&s, &all);
  for (int i = 0; i < 64 * 36; ++i) {
    wanted[i] = i % 11 == 3;
    for (int p = 0; p < HBIL_LIGHT_PLANES; ++p)
      got.values[p * 64 * 36 + i] = -7.0;
  }
  checked_gather_dense(&s.job, &split, &some, &got);
  for (int i = 0; i < 64 * 36 * HBIL_LIGHT_PLANES; ++i)
    assert_true(got.values[i] ==
                (wanted[i % (64 * 36)] ? want.values[i] : -7.0));
  planes_free(&split, &want, &got);
  setup_free(&s);
}

/* The outputs of the densest plan, without the filter. */
static exact_planes densest_frame(setup *s) {
  s->config.sampling.slices = 32;
  s->config.sampling.steps_per_side = 64;
  s->config.sampling.step_growth = 0.0f;
  s->config.sampling.unfiltered = CL_TRUE;
  setup_start(s);
  setup_run(s, hbil_enqueue_frame);
  return outputs_read(s);
}

/* Measured: AO .0035, E_near and indirect .047, which 32 slices leave. */
TEST(plans_approach_the_dense_frame) {
  const exact_dense how = {.slices = 1024, .at_centres = true};
  setup s;
  exact_state expected;
  exact_planes got;
  setup_scene(&s, SCENE_ROOM, 64, 36, 0);
  setup_all_outputs(&s);
  s.config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s.config.model.gather_emission = CL_FALSE;
  got = densest_frame(&s);
  s.config.sampling.unfiltered =
      CL_FALSE; /* has no effect on the dense frame */
  checked_state(&expected, 64, 36);
  checked_run_frame_dense(&expected, &s.job, &how);
  check_at_most("AO", relative_rmse(&got, &expected.out, EXACT_AO, 1), 0.01);
  check_at_most("E_near",
                relative_rmse(&got, &expected.out, EXACT_NEAR_IRRADIANCE, 3),
                0.08);
  check_at_most("indirect",
                relative_rmse(&got, &expected.out, EXACT_INDIRECT, 3), 0.08);
  exact_state_free(&expected);
  exact_planes_free(&got);
  setup_free(&s);
}
