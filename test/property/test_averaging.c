/*
 * Averaging over frames: static frames give the mean of single ones and less
 * noise, surfaces that were not there begin anew, and values that are no
 * numbers never enter the history.
 */
#include "test/support/history.h"
#include "test/support/shim.h"

#include <stdio.h>

#define FRAMES 6

/* ------------------------------------------------------------------------ */
/* A camera that stands still                                                */

/* Outputs of frames on their own, with patterns rotated by their index. */
static void singles(exact_planes *out, int count) {
  setup s;
  averaging_init(&s, WIDTH, HEIGHT, 0);
  setup_start(&s);
  for (int i = 0; i < count; ++i) {
    s.frame.frame_index = (cl_uint)i;
    setup_run(&s, hbil_enqueue_frame);
    out[i] = outputs_read(&s);
  }
  setup_free(&s);
}

/* The n-th frame's weight is 1/n, and 1/most from frame `most` on. */
static void add_frame(exact_planes *mean, const exact_planes *frame, int n) {
  for (size_t i = 0; i < count_values(mean); ++i)
    mean->values[i] += (frame->values[i] - mean->values[i]) / n;
}

/* AO and E_near alone, since a mean of bent normals isn't a unit vector.
 * Limit: three fp32 roundings a frame. */
static void check_mean(const exact_planes *got, const exact_planes *want) {
  check_at_most("E_near", relative_rmse(got, want, EXACT_NEAR_IRRADIANCE, 3),
                1e-6);
  check_at_most("AO", relative_rmse(got, want, EXACT_AO, 1), 1e-6);
}

static void static_frames_are_averaged(void **state) {
  exact_planes single[FRAMES], mean = checked_planes(WIDTH, HEIGHT, 17);
  setup said, unsaid;
  (void)state;
  singles(single, FRAMES);
  averaging_init(&said, WIDTH, HEIGHT, MOST);
  averaging_init(&unsaid, WIDTH, HEIGHT, MOST);
  setup_start(&said);
  setup_start(&unsaid);
  for (int i = 0; i < FRAMES; ++i) {
    said.frame.frame_index = unsaid.frame.frame_index = (cl_uint)i;
    said.frame.static_frame = CL_TRUE; /* of no account in the first */
    setup_run(&said, hbil_enqueue_frame);
    setup_run(&unsaid, hbil_enqueue_frame);
    exact_planes got = outputs_read(&said), other = outputs_read(&unsaid);
    add_frame(&mean, &single[i], i < MOST ? i + 1 : MOST);
    check_mean(&got, &mean);
    same_bits(&other, &got);
    exact_planes_free(&got);
    exact_planes_free(&other);
    exact_planes_free(&single[i]);
  }
  exact_planes_free(&mean);
  setup_free(&unsaid);
  setup_free(&said);
}

static double squared_error(const exact_planes *got, const exact_planes *want) {
  const double e = relative_rmse(got, want, EXACT_AO, 1);
  return e * e;
}

/*
 * The error of AO with 1 x 32 samples, without the filter. The average of 64
 * frames has only bias left, from finite samples and from a ratio of sums.
 * Errors above that are noise of the pattern. The mean over N independent
 * patterns would have 1/N of that noise, and a low-discrepancy rotation must
 * do no worse. Measured: 0.23, 0.085, 0.015 and 0.004 for 2, 4, 8 and 16
 * frames.
 */
static void noise_falls_with_the_frames(void **state) {
  const exact_dense how = {.slices = 256};
  exact_state expected;
  double error[65], noise;
  setup s;
  (void)state;
  averaging_init(&s, WIDTH, HEIGHT, 64);
  s.config.sampling.steps_per_side = 32;
  setup_start(&s);
  checked_state(&expected, WIDTH, HEIGHT);
  checked_run_frame_dense(&expected, &s.job, &how);
  for (int n = 1; n <= 64; ++n) {
    s.frame.frame_index = (cl_uint)n;
    setup_run(&s, hbil_enqueue_frame);
    exact_planes got = outputs_read(&s);
    error[n] = squared_error(&got, &expected.out);
    exact_planes_free(&got);
  }
  noise = error[1] - error[64];
  for (int n = 2; n <= 16; n *= 2) {
    char what[32];
    snprintf(what, sizeof what, "noise of %d frames", n);
    check_at_most(what, (error[n] - error[64]) / noise, 1.0 / n);
  }
  exact_state_free(&expected);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Surfaces that were not there                                              */

/* A wall at depth 4, with a patch from column `left` on. */
static void set_wall(setup *s, int left, float depth, float tilt) {
  setup_camera(s, 60.0);
  s->config.inputs.normal_space = HBIL_SPACE_VIEW;
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      const int i = y * WIDTH + x;
      const bool patch = x >= left && x < left + 20 && y >= 10 && y < 40;
      s->input[EXACT_DEPTH][i] = patch ? depth : 4.0f;
      s->input[EXACT_NORMAL][i] = patch ? tilt : 0.0f;
      s->input[EXACT_NORMAL + 1][i] = 0.0f;
      s->input[EXACT_NORMAL + 2][i] = -1.0f;
      for (int c = 0; c < 3; ++c)
        s->input[EXACT_DIRECT + c][i] = (float)(1 + c + x % 7);
    }
  setup_upload(s);
}

/* Whether the patch that begins at column `left` covers a pixel. */
static bool in_patch(int left, int x, int y) {
  return x >= left && x < left + 20 && y >= 10 && y < 40;
}

/* Runs the frame that is loaded, in `s` after another frame and in `alone` as
 * the first. Where `changed`, both have the same bits; elsewhere `s` averages
 * two frames. */
static void check_anew(setup *s, setup *alone, bool (*changed)(int x, int y)) {
  s->frame.frame_index = alone->frame.frame_index = 1;
  hbil_plan_reset(alone->plan);
  setup_run(s, hbil_enqueue_frame);
  setup_run(alone, hbil_enqueue_frame);
  exact_planes got = outputs_read(s), want = outputs_read(alone);
  history h = history_read(s);
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      const bool anew = changed(x, y);
      assert_true(history_value(&h, HISTORY_FRAMES, x, y) ==
                  (anew ? 1.0 : 2.0));
      for (int p = 0; p < EXACT_OUTPUT_PLANES && anew; ++p)
        assert_true(*exact_at(&got, p, x, y) == *exact_at(&want, p, x, y));
    }
  free(h.bytes);
  exact_planes_free(&got);
  exact_planes_free(&want);
}

static bool moved_patch(int x, int y) {
  return in_patch(20, x, y) != in_patch(28, x, y);
}

static bool first_patch(int x, int y) {
  return in_patch(20, x, y);
}

static void new_surfaces_begin_anew(void **state) {
  setup s, alone;
  (void)state;
  averaging_init(&s, WIDTH, HEIGHT, 8);
  averaging_init(&alone, WIDTH, HEIGHT, 8);
  s.config.inputs.normal_space = alone.config.inputs.normal_space =
      HBIL_SPACE_VIEW;
  setup_start(&s);
  setup_start(&alone);
  /* from, and to: left column, depth, tilt */
  static const struct {
    int left[2];
    float depth[2], tilt[2];
    bool (*changed)(int x, int y);
  } cases[] = {
      /* moves aside, and uncovers new surface */
      {{20, 28}, {2.0f, 2.0f}, {0.0f, 0.0f}, moved_patch},
      /* depth changes by 6 %, where 5 % are allowed, towards the eye and away
       */
      {{20, 20}, {4.0f, 3.76f}, {0.0f, 0.0f}, first_patch},
      {{20, 20}, {3.76f, 4.0f}, {0.0f, 0.0f}, first_patch},
      /* turns by 40 degrees, where 33 are allowed */
      {{20, 20}, {2.0f, 2.0f}, {0.0f, 0.8391f}, first_patch},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    hbil_plan_reset(s.plan);
    s.frame.frame_index = 0;
    set_wall(&s, cases[i].left[0], cases[i].depth[0], cases[i].tilt[0]);
    setup_run(&s, hbil_enqueue_frame);
    set_wall(&s, cases[i].left[1], cases[i].depth[1], cases[i].tilt[1]);
    set_wall(&alone, cases[i].left[1], cases[i].depth[1], cases[i].tilt[1]);
    check_anew(&s, &alone, cases[i].changed);
  }
  setup_free(&alone);
  setup_free(&s);
}

/* A wall fills the picture, and the camera moves by half a pixel. At one
 * border, half of the history of a row or column lies outside the picture. */
static void beyond_the_border_there_is_no_history(void **state) {
  static const int moves[][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  setup s;
  (void)state;
  averaging_init(&s, WIDTH, HEIGHT, 8);
  s.config.inputs.normal_space = HBIL_SPACE_VIEW;
  setup_start(&s);
  for (size_t i = 0; i < sizeof moves / sizeof *moves; ++i) {
    const int dx = moves[i][0], dy = moves[i][1];
    hbil_plan_reset(s.plan);
    set_wall(&s, 0, 4.0f, 0.0f);
    setup_run(&s, hbil_enqueue_frame);
    s.frame.camera.world_from_view[3] = dx * 0.5 * 4.0 / s.frame.camera.fx;
    s.frame.camera.world_from_view[7] = dy * 0.5 * 4.0 / s.frame.camera.fy;
    setup_run(&s, hbil_enqueue_frame);
    history h = history_read(&s);
    for (int y = 0; y < HEIGHT; ++y)
      for (int x = 0; x < WIDTH; ++x) {
        const int to_x = x + dx, to_y = y + dy;
        const bool inside =
            to_x >= 0 && to_x < WIDTH && to_y >= 0 && to_y < HEIGHT;
        assert_true(history_value(&h, HISTORY_FRAMES, x, y) ==
                    (inside ? 2.0 : 1.5));
      }
    free(h.bytes);
  }
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* No numbers                                                                */

/* An invalid value in the history makes its own pixel begin anew, and no other.
 * The normal's plane is left out: any word is a valid normal. */
static void invalid_history_is_dropped(void **state) {
  static const float bad[] = {NAN, INFINITY, -INFINITY};
  setup s;
  (void)state;
  averaging_init(&s, WIDTH, HEIGHT, 8);
  setup_start(&s);
  for (size_t b = 0; b < 3; ++b)
    for (int p = 0; p < 10; ++p) {
      if (p == HISTORY_NORMAL || (p == HISTORY_FRAMES && b == 1))
        continue;
      hbil_plan_reset(s.plan);
      setup_run(&s, hbil_enqueue_frame);
      history h = history_read(&s);
      memcpy(h.bytes + history_offset(&h, p, 30, 20), &bad[b], sizeof(float));
      assert_int_equal(
          clEnqueueWriteBuffer(s.device->queue, h.at.buffer, CL_TRUE,
                               history_offset(&h, p, 30, 20), sizeof(float),
                               &bad[b], 0, NULL, NULL),
          CL_SUCCESS);
      free(h.bytes);
      setup_run(&s, hbil_enqueue_frame);
      h = history_read(&s);
      for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
          const bool solid = s.input[EXACT_DEPTH][y * WIDTH + x] > 0.0f;
          const double n = history_value(&h, HISTORY_FRAMES, x, y);
          assert_true(n == (!solid ? 0.0 : x == 30 && y == 20 ? 1.0 : 2.0));
          for (int q = HISTORY_LIGHT; q < 10; ++q)
            assert_true(isfinite(history_value(&h, q, x, y)));
        }
      free(h.bytes);
    }
  setup_free(&s);
}

/* A value that is no number appears in its own frame alone. */
static void invalid_light_does_not_enter_the_history(void **state) {
  setup s;
  (void)state;
  averaging_init(&s, WIDTH, HEIGHT, 8);
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  for (size_t i = 0; i < PASSES_BEFORE_FILTER; ++i)
    setup_run(&s, passes_before_filter[i]);
  exact_planes fresh = stage_read(&s, HBIL_STAGE_RESOLVED);
  *exact_at(&fresh, HBIL_LIGHT_RED, 30, 20) = NAN;
  stage_write(&s, HBIL_STAGE_RESOLVED, &fresh);
  exact_planes_free(&fresh);
  setup_run(&s, enqueue_temporal);
  setup_run(&s, enqueue_composite);
  history h = history_read(&s);
  assert_true(history_value(&h, HISTORY_FRAMES, 30, 20) == 0.0);
  free(h.bytes);
  exact_planes got = outputs_read(&s);
  assert_true(isnan(*exact_at(&got, EXACT_NEAR_IRRADIANCE, 30, 20)));
  exact_planes_free(&got);
  setup_run(&s, hbil_enqueue_frame);
  got = outputs_read(&s);
  for (size_t i = 0; i < count_values(&got); ++i)
    assert_true(isfinite(got.values[i]));
  exact_planes_free(&got);
  h = history_read(&s);
  assert_true(history_value(&h, HISTORY_FRAMES, 30, 20) == 1.0);
  assert_true(history_value(&h, HISTORY_FRAMES, 31, 20) == 3.0);
  free(h.bytes);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* The same bits                                                             */

static void run_moving(setup *s, int from, int to) {
  for (int i = from; i < to; ++i) {
    averaging_load(s, (uint32_t)i, (cl_uint)i);
    setup_run(s, hbil_enqueue_frame);
  }
}

/* The same sequence once more; in other work-groups; after a frame that was
 * not finished; and in guarded buffers that begin full of not-a-numbers. */
static void runs_have_the_same_bits(void **state) {
  static const size_t groups[2] = {5, 3};
  setup s, guarded;
  (void)state;
  averaging_init(&s, WIDTH, HEIGHT, MOST);
  setup_start(&s);
  run_moving(&s, 0, 4);
  exact_planes want = outputs_read(&s), got;
  for (int way = 0; way < 3; ++way) {
    hbil_plan_reset(s.plan);
    shim_use_groups(way == 1 ? groups : NULL);
    run_moving(&s, 0, 3);
    if (way == 2) {
      averaging_load(&s, 11, 7);
      for (size_t i = 0; i < 5; ++i)
        setup_run(&s, passes_before_filter[i]);
      setup_run(&s, enqueue_temporal);
    }
    run_moving(&s, 3, 4);
    got = outputs_read(&s);
    same_bits(&got, &want);
    exact_planes_free(&got);
  }
  shim_use_groups(NULL);
  averaging_init(&guarded, WIDTH, HEIGHT, MOST);
  shim_guard_buffers(true);
  setup_start(&guarded);
  shim_guard_buffers(false);
  run_moving(&guarded, 0, 4);
  got = outputs_read(&guarded);
  same_bits(&got, &want);
  assert_int_equal(shim_overwritten(guarded.device->queue), 0);
  exact_planes_free(&got);
  exact_planes_free(&want);
  setup_free(&guarded);
  setup_free(&s);
}

static void small_pictures_stay_inside_their_buffers(void **state) {
  static const int sizes[][2] = {{1, 1}, {3, 5}, {67, 35}};
  (void)state;
  for (size_t i = 0; i < 3; ++i) {
    setup s;
    averaging_init(&s, sizes[i][0], sizes[i][1], MOST);
    shim_guard_buffers(true);
    setup_start(&s);
    shim_guard_buffers(false);
    run_moving(&s, 0, 3);
    exact_planes got = outputs_read(&s);
    for (size_t v = 0; v < count_values(&got); ++v)
      assert_true(isfinite(got.values[v]));
    assert_int_equal(shim_overwritten(s.device->queue), 0);
    exact_planes_free(&got);
    setup_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(static_frames_are_averaged),
      cmocka_unit_test(noise_falls_with_the_frames),
      cmocka_unit_test(new_surfaces_begin_anew),
      cmocka_unit_test(beyond_the_border_there_is_no_history),
      cmocka_unit_test(invalid_history_is_dropped),
      cmocka_unit_test(invalid_light_does_not_enter_the_history),
      cmocka_unit_test(runs_have_the_same_bits),
      cmocka_unit_test(small_pictures_stay_inside_their_buffers)};
  return RUN_WITH_DEVICE(tests);
}
