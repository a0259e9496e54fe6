/*
 * A plan that follows another one: its next frame reprojects the other's light,
 * whatever size that has, as the exact pass does, and of one size with the bits
 * that the other itself would have given.
 */
#include "test/support/stages.h"

#include <float.h>
#include <string.h>

typedef struct size {
  int width, height;
} size;

/* --- one size --- */

static void load(setup *s, uint32_t frame) {
  setup_load_scene(s, SCENE_ROOM, frame);
  setup_upload(s);
}

TEST(plans_of_one_size_have_the_same_bits) {
  setup s[2];
  for (int i = 0; i < 2; ++i) {
    setup_every_pass(&s[i], HBIL_REPROJECTION_CAMERA, 0, 64, 48);
    setup_start(&s[i]);
  }
  for (uint32_t frame = 0; frame < 2; ++frame) {
    load(&s[0], frame);
    setup_run(&s[0], hbil_enqueue_frame);
  }
  /* a plan with frames of its own, which it no longer has */
  load(&s[1], 7);
  setup_run(&s[1], hbil_enqueue_frame);
  assert_success(&s[1], hbil_plan_follow(s[1].plan, s[0].plan));
  assert_int_equal(setup_bounces(&s[1]), 2);
  load(&s[1], 2);
  s[1].frame.static_frame = CL_TRUE; /* there is no last frame of its own */
  setup_run(&s[1], hbil_enqueue_frame);
  s[1].frame.static_frame = CL_FALSE;
  load(&s[0], 2);
  setup_run(&s[0], hbil_enqueue_frame);
  for (uint32_t frame = 3; frame < 5; ++frame) {
    exact_planes want = outputs_read(&s[0]), got = outputs_read(&s[1]);
    assert_int_equal(count_different(&got, &want), 0);
    planes_free(&want, &got);
    assert_int_equal(setup_bounces(&s[1]), frame);
    for (int i = 0; i < 2; ++i) { /* each goes on by itself */
      load(&s[i], frame);
      setup_run(&s[i], hbil_enqueue_frame);
    }
  }
  for (int i = 0; i < 2; ++i)
    setup_free(&s[i]);
}

/* --- other sizes --- */

/* Light that differs from pixel to pixel, at the depths of the frame. */
static void plant_history(setup *s) {
  exact_planes history = checked_planes(
      (int)s->config.width, (int)s->config.height, HBIL_HISTORY_PLANES);
  const size_t pixels = setup_pixels(s);
  for (size_t i = 0; i < pixels; ++i) {
    const float z = s->input[EXACT_DEPTH][i];
    history.values[i] = z > 0.0f && z < FLT_MAX ? 1.0 / (double)z : -1.0;
    for (size_t c = 0; c < 3; ++c)
      history.values[(1 + c) * pixels + i] =
          (double)((i * 7 + c * 3) % 64) / 16.0;
  }
  stage_write(s, HBIL_STAGE_HISTORY, &history);
  exact_planes_free(&history);
  const hbil_last_frame last = {.camera = s->frame.camera, .bounces = 3};
  assert_success(s, hbil_plan_adopt_history(s->plan, &last));
}

static void start(setup *s, size of, hbil_reprojection how,
                  hbil_storage storage, uint32_t frame) {
  setup_every_pass(s, how, 0, of.width, of.height);
  s->config.sampling.storage = storage;
  setup_load_scene(s, SCENE_ROOM, frame);
  setup_start(s);
}

static void check_sizes(size before, size now, hbil_reprojection how,
                        hbil_storage storage) {
  setup last, s, between;
  start(&last, before, how, storage, 0);
  start(&s, now, how, storage, 1);
  plant_history(&last);
  assert_success(&s, hbil_plan_follow(s.plan, last.plan));
  exact_planes history = stage_read(&last, HBIL_STAGE_HISTORY);
  if (how == HBIL_REPROJECTION_CAMERA) { /* by way of another, and back again */
    start(&between, now, how, storage, 1);
    assert_success(&s, hbil_plan_follow(between.plan, s.plan));
    assert_success(&s, hbil_plan_follow(last.plan, between.plan));
    assert_success(&s, hbil_plan_follow(s.plan, between.plan));
    setup_free(&between);
  }
  hbil_plan_destroy(last.plan), last.plan = NULL; /* s still has its light */
  setup_run(&s, enqueue_reproject);
  exact_planes got = stage_read(&s, HBIL_STAGE_CARRIED);
  exact_planes want =
      checked_planes(now.width, now.height, HBIL_CARRIED_PLANES);
  s.job.previous = last.frame.camera;
  checked_reproject(&s.job, &history, &want);
  assert_int_equal(count_different(&got, &want), 0);
  int found = 0;
  for (int y = 0; y < now.height; ++y)
    for (int x = 0; x < now.width; ++x)
      found += *exact_at(&got, HBIL_CARRIED_WEIGHT, x, y) > 0.0;
  /* at the fewest, where a pixel's neighbours are at other depths */
  assert_in_range(found, now.width * now.height / 2, now.width * now.height);
  planes_free(&history, &got, &want);
  setup_free(&s);
  setup_free(&last);
}

TEST(other_sizes_match) {
  static const size sizes[][2] = {
      {{64, 48}, {41, 31}}, {{41, 31}, {64, 48}}, {{99, 75}, {64, 48}}};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
    for (int how = HBIL_REPROJECTION_CAMERA; how <= HBIL_REPROJECTION_MOTION;
         ++how)
      check_sizes(sizes[i][0], sizes[i][1], (hbil_reprojection)how,
                  i ? HBIL_STORAGE_PACKED : HBIL_STORAGE_FLOAT32);
}

/* Sizes that change to and fro: light goes on bouncing. */
TEST(frames_alternate_between_sizes) {
  static const size sizes[] = {{64, 48}, {48, 36}};
  setup s[2];
  for (int i = 0; i < 2; ++i)
    start(&s[i], sizes[i], HBIL_REPROJECTION_CAMERA, HBIL_STORAGE_PACKED, 0);
  for (uint32_t frame = 0; frame < 6; ++frame) {
    setup *now = &s[frame % 2];
    load(now, frame);
    if (frame)
      assert_success(now, hbil_plan_follow(now->plan, s[(frame + 1) % 2].plan));
    setup_run(now, hbil_enqueue_frame);
    assert_int_equal(setup_bounces(now), frame + 1);
  }
  for (int i = 0; i < 2; ++i)
    setup_free(&s[i]);
}

/* --- what is wrong --- */

TEST(plans_that_cannot_follow_stay) {
  const size one = {16, 8}, other = {8, 16};
  setup s, last, floats, none;
  start(&s, one, HBIL_REPROJECTION_CAMERA, HBIL_STORAGE_PACKED, 0);
  start(&last, other, HBIL_REPROJECTION_CAMERA, HBIL_STORAGE_PACKED, 0);
  start(&floats, one, HBIL_REPROJECTION_CAMERA, HBIL_STORAGE_FLOAT32, 0);
  start(&none, one, HBIL_REPROJECTION_NONE, HBIL_STORAGE_PACKED, 0);
  assert_int_equal(hbil_plan_follow(NULL, s.plan), HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_follow(s.plan, NULL), HBIL_INVALID_ARGUMENT);
  plant_history(&s);
  plant_history(&last);
  assert_int_equal(hbil_plan_follow(s.plan, floats.plan),
                   HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(s.device->hbil),
                         "last: a plan of other sampling.storage"));
  assert_int_equal(hbil_plan_follow(s.plan, none.plan), HBIL_INVALID_ARGUMENT);
  assert_int_equal(setup_bounces(&s), 3);
  assert_success(&s, hbil_plan_follow(s.plan, s.plan)); /* its own */
  assert_int_equal(setup_bounces(&s), 3);
  assert_success(&s, hbil_plan_follow(s.plan, last.plan));
  assert_success(&s, hbil_plan_follow(s.plan, s.plan)); /* goes on so */
  assert_int_equal(setup_bounces(&s), 3);
  /* a plan without frames is followed by a first one */
  hbil_plan_reset(last.plan);
  assert_success(&s, hbil_plan_follow(s.plan, last.plan));
  assert_int_equal(setup_bounces(&s), 0);
  setup_free(&none);
  setup_free(&floats);
  setup_free(&last);
  setup_free(&s);
}
