/*
 * Exposure that differs from frame to frame: light is as it would be had it
 * always been so.  Factors are powers of two, so that nothing is rounded
 * differently and all bits but the exponent are the same.
 */
#include "test/support/room.h"

enum { FRAMES = 5 };
static const float steady[FRAMES] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
static const float jumping[FRAMES] = {0.0f, 8.0f, 0.25f, 0.25f, 1024.0f};

static float factor(float exposure) {
  return exposure > 0.0f ? exposure : 1.0f;
}

static room lit(float exposure) {
  room r = room_lit();
  r.roofless = true;
  for (int w = 0; w < WALLS; ++w) {
    r.direct[w] *= factor(exposure);
    r.emission[w] *= factor(exposure);
  }
  return r;
}

/* Some light from all sides, more from one. */
static void set_environment(float exposure, float environment[9][3]) {
  for (int c = 0; c < 3; ++c) {
    environment[0][c] = 0.5f * factor(exposure);
    environment[2][c] = 0.25f * factor(exposure);
  }
}

/* A view to the side and above, which the frame doesn't have, and bounces. */
static void see(hbil_cache *cache, float exposure, hbil_view_light light) {
  const room r = lit(exposure);
  const hbil_camera camera = room_camera(room_middle, LEFT, 32, 32, 120.0);
  hbil_cache_update update;
  hbil_view view = room_view(&shared_device, &r, &camera,
                             HBIL_PROJECTION_PERSPECTIVE, 32, 32, light);
  view.exposure = exposure;
  hbil_cache_update_init(&update);
  update.far_field = HBIL_FAR_SH;
  update.exposure = exposure;
  set_environment(exposure, update.environment);
  assert_int_equal(hbil_enqueue_cache_inject(cache, shared_device.queue, &view,
                                             1, 0, NULL, NULL),
                   HBIL_SUCCESS);
  assert_int_equal(hbil_enqueue_cache_update(cache, shared_device.queue,
                                             &update, 0, NULL, NULL),
                   HBIL_SUCCESS);
  assert_int_equal(clFinish(shared_device.queue), CL_SUCCESS);
  room_view_free(&view);
}

static hbil_cache *new_cache(hbil_cache_method method) {
  hbil_cache_config config = room_cache_config();
  hbil_cache *cache = NULL;
  config.method = method;
  assert_int_equal(hbil_cache_create(shared_device.hbil, &config, &cache),
                   HBIL_SUCCESS);
  return cache;
}

static void run(setup *s, const float exposure[FRAMES], hbil_view_light light,
                exact_planes out[FRAMES]) {
  hbil_plan_reset(s->plan);
  s->frame.cache = new_cache(s->config.model.cache_method);
  for (int i = 0; i < FRAMES; ++i) {
    const double eye[3] = {0.05 * i, 0.2, -0.9};
    const hbil_camera camera =
        room_camera(eye, AHEAD, ROOM_WIDTH, ROOM_HEIGHT, 75.0);
    const room r = lit(exposure[i]);
    see(s->frame.cache, exposure[i], light);
    room_load(s, &r, &camera);
    s->frame.exposure = exposure[i];
    s->frame.frame_index = (cl_uint)i;
    set_environment(exposure[i], s->frame.environment);
    setup_upload(s);
    out[i] = room_outputs(s);
  }
  hbil_cache_destroy(s->frame.cache);
}

static bool is_light(int plane) {
  return plane < EXACT_AO ||
         (plane >= EXACT_INDIRECT && plane < EXACT_BEAUTY + 3) ||
         plane == EXACT_ERROR_ESTIMATE + 1 ||
         (plane >= EXACT_GLOSSY && plane < EXACT_GLOSSY + 3);
}

/* The largest difference of an output from `want` times the exposure, relative
 * to the largest value. */
static double worst(const exact_planes *got, const exact_planes *want,
                    float exposure) {
  double most = 0.0;
  for (int p = 0; p < want->count; ++p) {
    const double scale = is_light(p) ? (double)factor(exposure) : 1.0;
    double largest = 0.0, off = 0.0;
    for (int y = 0; y < want->height; ++y)
      for (int x = 0; x < want->width; ++x) {
        const double w = scale * *exact_at(want, p, x, y);
        largest = fmax(largest, fabs(w));
        off = fmax(off, fabs(*exact_at(got, p, x, y) - w));
      }
    most = fmax(most, largest > 0.0 ? off / largest : off);
  }
  return most;
}

static void check(hbil_feedback feedback, hbil_far_field far_field,
                  hbil_cache_method method, hbil_view_light light,
                  cl_uint slice_frames) {
  const room r = room_lit();
  const double eye[3] = {0.0, 0.2, -0.9};
  const hbil_camera camera =
      room_camera(eye, AHEAD, ROOM_WIDTH, ROOM_HEIGHT, 75.0);
  exact_planes want[FRAMES], got[FRAMES];
  setup s;
  room_setup(&s, &r, &camera, ROOM_WIDTH, ROOM_HEIGHT);
  setup_all_outputs(&s);
  if (method == HBIL_CACHE_METHOD_RAYS) /* others have no glossy light */
    s.config.outputs.glossy = s.config.outputs.indirect;
  s.config.model.feedback = feedback;
  s.config.model.far_field = far_field;
  s.config.model.cache_method = method;
  s.config.history.reprojection = HBIL_REPROJECTION_CAMERA;
  s.config.sampling.slice_frames = slice_frames;
  s.config.sampling.slices = 2;
  s.config.sampling.steps_per_side = 6;
  setup_start(&s);
  run(&s, steady, light, want);
  run(&s, jumping, light, got);
  for (int i = 0; i < FRAMES; ++i)
    check_at_most("difference", worst(&got[i], &want[i], jumping[i]), 1e-6);
  /* the history and the cache are there */
  assert_true(largest_value(&want[1], EXACT_FAR_IRRADIANCE, 3) > 0.01);
  assert_true(worst(&want[1], &want[0], 1.0f) > 0.01);
  for (int i = 0; i < FRAMES; ++i)
    planes_free(&want[i], &got[i]);
  setup_free(&s);
}

TEST(light_is_as_if_it_had_always_been_so) {
  check(HBIL_FEEDBACK_IRRADIANCE, HBIL_FAR_SH, HBIL_CACHE_METHOD_RAYS,
        HBIL_VIEW_DIRECT, 1);
  check(HBIL_FEEDBACK_RADIANCE, HBIL_FAR_FRAME, HBIL_CACHE_METHOD_CONES,
        HBIL_VIEW_FINISHED, 2);
}

TEST(exposures_out_of_range_are_rejected) {
  static const float wrong[] = {-1.0f, 1e-13f, 1e13f, NAN, INFINITY};
  room_scene t;
  room_start(&t);
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    hbil_cache_update update;
    hbil_cache_update_init(&update);
    update.exposure = wrong[i];
    room_rejected(hbil_enqueue_cache_update(t.s.frame.cache, t.s.device->queue,
                                            &update, 0, NULL, NULL),
                  HBIL_INVALID_ARGUMENT, "exposure");
    t.views[0].exposure = wrong[i];
    room_rejected(room_try(&t, t.views, 1, NULL), HBIL_INVALID_FRAME,
                  "exposure");
    t.s.frame.exposure = wrong[i];
    room_rejected(hbil_enqueue_frame(t.s.plan, t.s.device->queue, &t.s.frame, 0,
                                     NULL, NULL),
                  HBIL_INVALID_FRAME, "exposure");
  }
  t.s.frame.exposure = 2.0f;
  t.s.frame.static_frame = CL_TRUE;
  room_rejected(hbil_enqueue_frame(t.s.plan, t.s.device->queue, &t.s.frame, 0,
                                   NULL, NULL),
                HBIL_INVALID_FRAME, "exposure");
  room_stop(&t);
}
