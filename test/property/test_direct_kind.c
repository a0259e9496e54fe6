/*
 * Direct light as the radiance that surfaces reflect of it: frames and caches
 * get the light that irradiance gives them, and black surfaces are unlit.
 */
#include "test/support/room.h"

enum { FRAMES = 3 };

static room lit(hbil_direct_kind kind) {
  room r = room_lit();
  r.roofless = true;
  r.direct[AHEAD] = 0.4f;
  for (int w = 0; w < WALLS && kind == HBIL_DIRECT_RADIANCE; ++w)
    r.direct[w] *= r.albedo / (float)PI;
  return r;
}

/* Other albedos in every third pixel, and black ones among these, whose
 * radiance must not count. */
static void change_albedo(setup *s, hbil_direct_kind kind) {
  for (size_t i = 0; i < setup_pixels(s); ++i)
    for (int c = 0; c < 3 && i % 3 == 0; ++c) {
      float *albedo = &s->input[EXACT_ALBEDO + c][i];
      float *direct = &s->input[EXACT_DIRECT + c][i];
      const float other = i % 7 ? 0.1f + 0.3f * (float)c : 0.0f;
      if (kind == HBIL_DIRECT_RADIANCE)
        *direct = other > 0.0f ? *direct * other / *albedo : 0.3f;
      else if (other == 0.0f)
        *direct = 0.0f;
      *albedo = other;
    }
}

static void see(setup *s, hbil_direct_kind kind) {
  const room r = lit(kind);
  hbil_view views[WALLS];
  room_views(s->device, &r, room_middle, 24, HBIL_VIEW_DIRECT, views);
  room_inject(s->device, s->frame.cache, views, WALLS, 4);
  room_views_free(views, WALLS);
}

static void run(hbil_direct_kind kind, hbil_feedback feedback,
                exact_planes out[FRAMES]) {
  const double eye[3] = {0.0, 0.2, -0.9};
  const hbil_camera camera =
      room_camera(eye, AHEAD, ROOM_WIDTH, ROOM_HEIGHT, 75.0);
  const room r = lit(kind);
  hbil_cache_config views = room_cache_config();
  setup s;
  room_setup(&s, &r, &camera, ROOM_WIDTH, ROOM_HEIGHT);
  setup_all_outputs(&s);
  s.config.outputs.glossy = s.config.outputs.indirect;
  s.config.model.feedback = feedback;
  s.config.history.reprojection = HBIL_REPROJECTION_CAMERA;
  s.config.model.far_field = HBIL_FAR_FRAME;
  s.config.sampling.storage = HBIL_STORAGE_FLOAT32;
  s.config.sampling.slices = 2;
  s.config.sampling.steps_per_side = 6;
  s.config.inputs.direct_kind = views.inputs.direct_kind = kind;
  setup_start(&s);
  assert_int_equal(hbil_cache_create(s.device->hbil, &views, &s.frame.cache),
                   HBIL_SUCCESS);
  see(&s, kind);
  for (int c = 0; c < 3; ++c)
    s.frame.environment[0][c] = 0.2f;
  room_load(&s, &r, &camera);
  change_albedo(&s, kind);
  setup_upload(&s);
  for (int i = 0; i < FRAMES; ++i)
    out[i] = room_outputs(&s);
  hbil_cache_destroy(s.frame.cache);
  setup_free(&s);
}

static void check(hbil_feedback feedback) {
  exact_planes want[FRAMES], got[FRAMES];
  run(HBIL_DIRECT_IRRADIANCE, feedback, want);
  run(HBIL_DIRECT_RADIANCE, feedback, got);
  for (int i = 0; i < FRAMES; ++i) {
    assert_true(largest_value(&want[i], EXACT_FAR_IRRADIANCE, 3) > 0.01);
    check_at_most("light",
                  largest_error(&got[i], &want[i], 0, want[i].count) /
                      largest_value(&want[i], EXACT_BEAUTY, 3),
                  1e-5);
    planes_free(&want[i], &got[i]);
  }
}

TEST(radiance_lights_as_irradiance_does) {
  check(HBIL_FEEDBACK_IRRADIANCE);
  check(HBIL_FEEDBACK_RADIANCE);
}

/* Without albedo, surfaces are white. */
TEST(without_albedo_surfaces_are_white) {
  exact_planes out[2];
  for (int kind = 0; kind < 2; ++kind) {
    setup s;
    setup_scene(&s, SCENE_ROOM, 40, 24, 0);
    s.config.inputs.albedo.component = HBIL_NONE;
    s.config.inputs.direct_kind = (hbil_direct_kind)kind;
    s.config.inputs.direct_scale = kind ? 1.0f : (float)PI;
    setup_start(&s);
    setup_run(&s, hbil_enqueue_frame);
    out[kind] = outputs_read(&s);
    setup_free(&s);
  }
  check_at_most("indirect", relative_rmse(&out[1], &out[0], EXACT_INDIRECT, 3),
                1e-5);
  planes_free(&out[0], &out[1]);
}

TEST(an_unknown_kind_is_rejected) {
  hbil_plan *plan = NULL;
  setup s;
  setup_scene(&s, SCENE_ROOM, 40, 24, 0);
  s.config.inputs.direct_kind = (hbil_direct_kind)2;
  room_rejected(hbil_plan_create(s.device->hbil, &s.config, &plan),
                HBIL_INVALID_CONFIG, "inputs.direct_kind");
  setup_free(&s);
}
