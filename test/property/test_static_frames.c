/*
 * Static frames: a caller's statement that nothing has moved saves passes,
 * without changing a bit in the first 32 frames.  Later ones come to rest.
 */
#include "test/support/pair.h"
#include "test/support/random.h"

#include <math.h>

static void endless(setup *s) {
  pair_wall(s);
}

static void ao_alone(setup *s, hbil_mode mode) {
  pair_wall(s);
  s->config.model.mode = mode;
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT; ++i)
    if (i != PLANE_AO)
      plane_format(&s->config, (plane_id)i)->component = HBIL_NONE;
}

static void gtao(setup *s) {
  ao_alone(s, HBIL_MODE_GTAO);
}

static void room_with_history(setup *s) {
  pair_wall(s);
  s->config.history.reprojection = HBIL_REPROJECTION_CAMERA;
  s->config.model.far_field = HBIL_FAR_FRAME;
}

/* Two frames of a moving camera, then static ones.  Each is the same as in a
 * plan that isn't told that they are static.  Returns the first static frame in
 * which nothing was gathered, 0 if there is none. */
static int static_frames(prepare_function *prepare, int frames) {
  int settled = 0;
  setup told, plain;
  prepare(&told);
  prepare(&plain);
  setup_start(&told);
  setup_start(&plain);
  for (int i = 0; i < 2 + frames; ++i) {
    if (i < 2) {
      setup_load_scene(&told, SCENE_ROOM, (uint32_t)i);
      setup_load_scene(&plain, SCENE_ROOM, (uint32_t)i);
    }
    told.frame.static_frame = i >= 2;
    for (int c = 0; c < 2 && i == 2; ++c) {
      setup_fill(&told, EXACT_MOTION + c, 0.0f);
      setup_fill(&plain, EXACT_MOTION + c, 0.0f);
    }
    run_frame(&told);
    run_frame(&plain);
    assert_same_outputs(&told, &plain);
    const hbil_statistics found = statistics_of(&told);
    if (i >= 2) {
      assert_true(found.not_run[HBIL_PASS_REPROJECT]);
      assert_true(found.not_run[HBIL_PASS_PUSH_PULL]);
      assert_false(found.not_run[HBIL_PASS_COMPOSITE]);
      assert_int_equal(found.not_run[HBIL_PASS_GATHER],
                       found.not_run[HBIL_PASS_RECOMPOSE]);
    }
    if (!settled && found.not_run[HBIL_PASS_GATHER])
      settled = i - 1;
  }
  setup_free(&told);
  setup_free(&plain);
  return settled;
}

static void carried_radiance(setup *s) {
  pair_wall(s);
  s->config.history.reprojection = HBIL_REPROJECTION_MOTION;
  s->config.model.feedback = HBIL_FEEDBACK_RADIANCE;
  s->config.sampling.storage = HBIL_STORAGE_FLOAT32;
}

TEST(static_frames_are_the_same) {
  /* in this room, packed light settles to the last bit */
  assert_in_range(static_frames(room_with_history, 40), 2, 39);
  static_frames(carried_radiance, 3);
  /* at once where no light is carried over */
  assert_int_equal(static_frames(endless, 2), 1);
  assert_int_equal(static_frames(gtao, 2), 1);
}

/* --- light that would never settle --- */

static void room_of_floats(setup *s) {
  room_with_history(s);
  s->config.sampling.storage = HBIL_STORAGE_FLOAT32;
}

/* Albedo of 0.7 to 1, different in each pixel, under light of that share.  With
 * packed light about one seed in two hundred never settles if light may fall by
 * a rounding: this one, without a brighter frame before.  With floats none
 * does. */
enum { SEED = 190 };

static void load_bright_surfaces(setup *s, uint64_t seed, float share) {
  random_state random = {seed};
  setup_load_scene(s, SCENE_ROOM, 0);
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
      s->input[EXACT_ALBEDO + c][i] = (float)(0.7 + 0.3 * random_unit(&random));
      s->input[EXACT_DIRECT + c][i] *= share;
    }
}

/* By how much near light differs at most, relative to what it is. */
static double largest_difference(setup *told, setup *plain) {
  exact_planes one = outputs_read(told), two = outputs_read(plain);
  double largest = 0.0;
  for (int c = 0; c < 3; ++c) {
    const size_t plane = (size_t)(EXACT_NEAR_IRRADIANCE + c) * WIDTH * HEIGHT;
    for (size_t i = plane; i < plane + WIDTH * HEIGHT; ++i) {
      const double off = fabs(one.values[i] - two.values[i]);
      assert_true(isfinite(off));
      if (off > 0.0)
        largest = fmax(largest, off / fabs(two.values[i]));
    }
  }
  planes_free(&one, &two);
  return largest;
}

/* Light that would go up and down by a rounding for ever stops, and then
 * differs little from what it would be.  before: how bright a frame before the
 * static ones is, relative to them; least: the frames that it takes at least.
 */
static void settles(prepare_function *prepare, float before, int least,
                    double tolerance) {
  enum { FRAMES = 160, MOVING = 2 };
  setup told, plain;
  prepare(&told);
  prepare(&plain);
  setup_start(&told);
  setup_start(&plain);
  int settled = 0;
  for (int i = 0; !settled && i < FRAMES; ++i) {
    if (i < MOVING) {
      load_bright_surfaces(&told, SEED, i == 0 ? before : 1.0f);
      load_bright_surfaces(&plain, SEED, i == 0 ? before : 1.0f);
    }
    told.frame.static_frame = i >= MOVING;
    run_frame(&told);
    run_frame(&plain);
    if (i >= MOVING && statistics_of(&told).not_run[HBIL_PASS_GATHER])
      settled = i - MOVING + 1;
    if (i < MOVING + HBIL_EXACT_STATIC_FRAMES)
      assert_same_outputs(&told, &plain);
  }
  assert_in_range(settled, least, FRAMES);
  check_at_most("light at rest", largest_difference(&told, &plain), tolerance);
  setup_free(&told);
  setup_free(&plain);
}

TEST(light_settles) {
  settles(room_with_history, 1.0f, HBIL_EXACT_STATIC_FRAMES + 1, 0x1p-9);
  settles(room_of_floats, 1.0f, 1, 2e-6);
  settles(room_with_history, 10.0f, 1, 0x1p-9);
  settles(room_of_floats, 10.0f, 1, 2e-5);
}

/* A stripe of light. */
static void light_in_a_stripe(setup *s) {
  setup_load_scene(s, SCENE_ROOM, 0);
  for (int c = 0; c < 3; ++c) {
    setup_fill(s, EXACT_EMISSION + c, 0.0f);
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      s->input[EXACT_DIRECT + c][i] =
          i % WIDTH >= 175 && i % WIDTH < 190 ? 9.0f : 0.0f;
  }
}

/* A lamp is switched on although the caller says that nothing changes.  The
 * light is right nevertheless. */
TEST(light_may_arrive_late) {
  pair p;
  pair_start(&p, room_with_history, HBIL_SKIP_STATIC);
  for (int i = 0; i < 4; ++i) {
    light_in_a_stripe(&p.with);
    p.without.frame.camera = p.with.frame.camera;
    for (int c = 0; i < 2 && c < 3; ++c)
      setup_fill(&p.with, EXACT_DIRECT + c, 0.0f);
    p.with.frame.static_frame = i > 0;
    const hbil_statistics found = pair_compare(&p);
    assert_int_equal(found.not_run[HBIL_PASS_GATHER], i == 1);
  }
  pair_free(&p);
}

TEST(static_frames_are_checked) {
  setup s;
  room_with_history(&s);
  setup_start(&s);
  setup_load_scene(&s, SCENE_ROOM, 0);
  s.frame.static_frame = CL_TRUE; /* the first frame has none before it */
  run_frame(&s);
  assert_false(statistics_of(&s).not_run[HBIL_PASS_SPLIT]);
  s.frame.frame_index = 1;
  assert_int_equal(
      hbil_enqueue_frame(s.plan, s.device->queue, &s.frame, 0, NULL, NULL),
      HBIL_INVALID_FRAME);
  assert_non_null(strstr(hbil_context_message(s.device->hbil), "frame_index"));
  s.frame.frame_index = 0;
  s.frame.camera.fx *= 1.5;
  assert_int_equal(
      hbil_enqueue_frame(s.plan, s.device->queue, &s.frame, 0, NULL, NULL),
      HBIL_INVALID_FRAME);
  assert_non_null(strstr(hbil_context_message(s.device->hbil), "camera"));
  /* after a reset there is no frame before it, either */
  hbil_plan_reset(s.plan);
  run_frame(&s);
  assert_false(statistics_of(&s).not_run[HBIL_PASS_SPLIT]);
  setup_free(&s);
}
