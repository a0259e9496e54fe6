/*
 * Commands of a cache and frames, for each method: the same bits in every run
 * and with work-groups of any shape, nothing outside of buffers, the announced
 * memory, moves, resets, saved caches, frames of a pixel, OpenCL calls that
 * fail, and what is rejected.
 */
#include "test/support/cache.h"
#include "test/support/fault.h"
#include "test/support/room.h"

static const hbil_cache_method first_method = HBIL_CACHE_METHOD_RAYS,
                               last_method = HBIL_CACHE_METHOD_RSM;

/* A frame of a lit room, a cache of the method, and the room's views. */
typedef struct scene {
  hbil_cache_method method;
  setup s; /* s.frame.cache is the cache */
  hbil_view views[WALLS];
} scene;

static hbil_cache_config config_for(hbil_cache_method method) {
  hbil_cache_config config = room_cache_config();
  config.method = method;
  return config;
}

static hbil_cache *cache_for(hbil_cache_method method) {
  const hbil_cache_config config = config_for(method);
  hbil_cache *cache = NULL;
  if (hbil_cache_create(shared_device.hbil, &config, &cache) != HBIL_SUCCESS)
    fail_msg("%s", hbil_context_message(shared_device.hbil));
  return cache;
}

static void start(scene *t, hbil_cache_method method, int width, int height) {
  const double eye[3] = {0.1, 0.2, -1.0};
  const room r = room_lit();
  const hbil_camera camera = room_camera(eye, AHEAD, width, height, 75.0);
  t->method = method;
  room_setup(&t->s, &r, &camera, width, height);
  t->s.config.model.cache_method = method;
  t->s.config.sampling.slices = 1;
  t->s.config.sampling.steps_per_side = 4;
  t->s.config.sampling.unfiltered = CL_TRUE;
  setup_start(&t->s);
  t->s.frame.cache = cache_for(method);
  room_views(&shared_device, &r, room_middle, 32, HBIL_VIEW_DIRECT, t->views);
}

static void stop(scene *t) {
  room_views_free(t->views, WALLS);
  hbil_cache_destroy(t->s.frame.cache);
  setup_free(&t->s);
}

/* All that makes a cache know the room; the first failure ends it. */
static hbil_status show(const scene *t) {
  hbil_cache *cache = t->s.frame.cache;
  const cl_command_queue queue = shared_device.queue;
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  hbil_status status =
      hbil_enqueue_cache_inject(cache, queue, t->views, WALLS, 0, NULL, NULL);
  if (status == HBIL_SUCCESS && t->method == HBIL_CACHE_METHOD_RSM)
    status = hbil_enqueue_cache_light_views(cache, queue, t->views + BEHIND, 2,
                                            0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_update(cache, queue, &update, 0, NULL, NULL);
  return status;
}

static exact_planes lit_outputs(scene *t) {
  assert_success(&t->s, show(t));
  exact_planes out = room_outputs(&t->s);
  assert_true(largest_value(&out, EXACT_FAR_IRRADIANCE, 3) > 0.01);
  return out;
}

static void reset(const scene *t) {
  assert_success(&t->s,
                 hbil_enqueue_cache_reset(t->s.frame.cache, shared_device.queue,
                                          0, NULL, NULL));
}

static void move(const scene *t, double x) {
  const double centre[3] = {x, 0.0, -x};
  assert_success(&t->s,
                 hbil_enqueue_cache_move(t->s.frame.cache, shared_device.queue,
                                         centre, 0, NULL, NULL));
}

/* ------------------------------------------------------------------------ */
/* The same bits                                                             */

TEST(every_run_has_the_same_bits) {
  static const size_t groups[][2] = {{1, 1}, {3, 2}, {7, 5}};
  for (hbil_cache_method p = first_method; p <= last_method; ++p) {
    scene t;
    start(&t, p, 97, 61);
    exact_planes want = lit_outputs(&t);
    for (int i = 0; i < 4; ++i) {
      reset(&t);
      if (i)
        shim_use_groups(groups[i - 1]);
      assert_success(&t.s, show(&t));
      room_same_bits(&t.s, &want, "another run");
      shim_use_groups(NULL);
    }
    exact_planes_free(&want);
    stop(&t);
  }
}

/* What a cache has forgotten, it doesn't show: not after its creation, nor
 * after a reset.  Cones and rays then change nothing; the other two know no
 * unseen places, and have no light. */
TEST(an_empty_cache_tells_nothing) {
  for (hbil_cache_method p = first_method; p <= last_method; ++p) {
    scene t;
    shim_guard_buffers(true); /* what isn't written is no number */
    start(&t, p, 97, 61);
    shim_guard_buffers(false);
    hbil_cache *cache = t.s.frame.cache;
    exact_planes first = room_outputs(&t.s);
    t.s.frame.cache = NULL;
    if (p <= HBIL_CACHE_METHOD_CONES)
      room_same_bits(&t.s, &first, "without a cache");
    t.s.frame.cache = cache;
    exact_planes lit = lit_outputs(&t);
    assert_true(count_different(&lit, &first) > 0);
    reset(&t);
    room_same_bits(&t.s, &first, "after a reset");
    planes_free(&first, &lit);
    stop(&t);
  }
}

/* A frame behind a move has what a frame behind a move and an update has, if
 * light doesn't spread from cell to cell. */
TEST(moves_leave_the_world_in_its_place) {
  for (hbil_cache_method p = first_method; p <= last_method; ++p) {
    hbil_cache_update update = cache_bounces(0);
    scene t;
    start(&t, p, 97, 61);
    exact_planes before = lit_outputs(&t);
    move(&t, 0.5);
    exact_planes moved = room_outputs(&t.s);
    assert_success(&t.s, hbil_enqueue_cache_update(t.s.frame.cache,
                                                   shared_device.queue, &update,
                                                   0, NULL, NULL));
    if (p != HBIL_CACHE_METHOD_LPV)
      room_same_bits(&t.s, &moved, "an update after a move");
    /* back again, from nothing */
    move(&t, 0.0);
    reset(&t);
    assert_success(&t.s, show(&t));
    room_same_bits(&t.s, &before, "there and back");
    planes_free(&before, &moved);
    stop(&t);
  }
}

/* Whatever a cache held before, a saved one replaces it. */
TEST(loaded_caches_have_no_past) {
  for (hbil_cache_method p = first_method; p <= HBIL_CACHE_METHOD_LPV; ++p) {
    scene t;
    start(&t, p, 97, 61);
    exact_planes lit = lit_outputs(&t);
    hbil_cache *cache = t.s.frame.cache;
    const size_t size = hbil_cache_size(cache);
    void *bytes = malloc(size);
    assert_non_null(bytes);
    assert_success(&t.s,
                   hbil_cache_save(cache, shared_device.queue, bytes, size));
    /* another place, and much light there */
    move(&t, 1.5);
    assert_success(&t.s, show(&t));
    assert_success(&t.s,
                   hbil_cache_load(cache, shared_device.queue, bytes, size));
    exact_planes got = room_outputs(&t.s);
    t.s.frame.cache = cache_for(p);
    assert_success(&t.s, hbil_cache_load(t.s.frame.cache, shared_device.queue,
                                         bytes, size));
    room_same_bits(&t.s, &got, "loaded into another cache");
    hbil_cache_destroy(cache);
    if (p != HBIL_CACHE_METHOD_LPV)
      room_same_bits(&t.s, &lit, "loaded");
    free(bytes);
    planes_free(&lit, &got);
    stop(&t);
  }
}

/* ------------------------------------------------------------------------ */
/* Memory                                                                    */

static void check_memory(hbil_cache_config *config) {
  const hbil_cache_method method = config->method;
  hbil_cache *cache;
  size_t bytes = 0, bare = 0;
  config->method = HBIL_CACHE_METHOD_RAYS;
  assert_int_equal(hbil_cache_memory(shared_device.hbil, config, &bare),
                   HBIL_SUCCESS);
  config->method = method;
  shim_start_counting();
  assert_int_equal(hbil_cache_memory(shared_device.hbil, config, &bytes),
                   HBIL_SUCCESS);
  assert_int_equal(shim_created().count, 0);
  assert_int_equal(hbil_cache_create(shared_device.hbil, config, &cache),
                   HBIL_SUCCESS);
  assert_int_equal(shim_created().bytes, bytes);
  assert_true(shim_created().count > 0);
  assert_int_equal(bytes > bare, method != HBIL_CACHE_METHOD_RAYS);
  hbil_cache_destroy(cache);
}

TEST(caches_take_the_announced_memory) {
  shim_skip_builds(true);
  for (hbil_cache_method p = first_method; p <= last_method; ++p)
    for (cl_uint levels = 1; levels <= 4; ++levels)
      for (cl_uint voxels = 16; voxels <= (p == first_method ? 128u : 32u);
           voxels *= 2) {
        hbil_cache_config config = room_cache_config();
        config.voxels = voxels;
        config.levels = levels;
        config.method = p;
        check_memory(&config);
      }
  shim_skip_builds(false);
}

TEST(nothing_is_written_outside_of_buffers) {
  static const int sizes[][2] = {{1, 1}, {97, 61}};
  for (hbil_cache_method p = first_method; p <= last_method; ++p)
    for (int i = 0; i < 2; ++i) {
      scene t;
      shim_guard_buffers(true);
      start(&t, p, sizes[i][0], sizes[i][1]);
      assert_success(&t.s, show(&t));
      move(&t, 0.5);
      assert_success(&t.s, show(&t));
      move(&t, 0.0);
      assert_success(&t.s, show(&t));
      exact_planes out = room_outputs(&t.s);
      for (size_t k = 0; k < count_values(&out); ++k)
        assert_true(isfinite(out.values[k]));
      assert_int_equal(shim_overwritten(shared_device.queue), 0);
      shim_guard_buffers(false);
      exact_planes_free(&out);
      stop(&t);
    }
}

/* ------------------------------------------------------------------------ */
/* Failures                                                                  */

static hbil_status make_cache(hbil_cache_method method) {
  const hbil_cache_config config = config_for(method);
  hbil_cache *cache = NULL;
  const hbil_status status =
      hbil_cache_create(shared_device.hbil, &config, &cache);
  assert_int_equal(cache != NULL, status == HBIL_SUCCESS);
  hbil_cache_destroy(cache);
  return status;
}

TEST(failed_caches_leave_nothing) {
  for (hbil_cache_method p = first_method; p <= last_method; ++p) {
    const long held = shim_references();
    outcome o = {0, "", HBIL_SUCCESS};
    for (int n = 1; o.failed; ++n)
      /* both faults of each call where nothing else is built, else in turn */
      for (int e = 0; e < (p == first_method ? MEMORY_FAULTS : 1); ++e) {
        const int fault = (n + e) % MEMORY_FAULTS;
        o = ATTEMPT(n, faults[fault], make_cache(p));
        check_outcome(shared_device.hbil, &o, fault);
        check_held(&o, held);
      }
    assert_in_range(o.nth, 40, 2000);
  }
}

/* One command of each kind, from a reset on; the first failure ends it. */
static hbil_status every_command(scene *t, cl_command_queue queue,
                                 void *bytes) {
  static const double away[3] = {0.25, 0.0, 0.0};
  hbil_cache *cache = t->s.frame.cache;
  const size_t size = hbil_cache_size(cache);
  /* rays need the light behind the camera, others all that lies around it */
  const cl_uint first = t->method == HBIL_CACHE_METHOD_RAYS ? BEHIND : 0;
  hbil_cache_counts n;
  hbil_cache_update update;
  cl_event event = NULL;
  hbil_cache_update_init(&update);
  hbil_status status =
      hbil_enqueue_cache_move(cache, queue, room_middle, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_reset(cache, queue, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_inject(cache, queue, t->views + first,
                                       WALLS - first, 0, NULL, &event);
  if (event)
    clReleaseEvent(event);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_update(cache, queue, &update, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_move(cache, queue, away, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_cache_statistics(cache, queue, &n);
  if (status == HBIL_SUCCESS)
    status = hbil_cache_save(cache, queue, bytes, size);
  if (status == HBIL_SUCCESS)
    status = hbil_cache_load(cache, queue, bytes, size);
  if (status == HBIL_SUCCESS && t->method == HBIL_CACHE_METHOD_RSM)
    status = hbil_enqueue_cache_light_views(cache, queue, t->views + BEHIND, 2,
                                            0, NULL, NULL);
  update.bounces = 0;
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_update(cache, queue, &update, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_frame(t->s.plan, queue, &t->s.frame, 0, NULL, NULL);
  return status;
}

static exact_planes light_of_commands(scene *t, cl_command_queue queue,
                                      void *bytes) {
  assert_success(&t->s, every_command(t, queue, bytes));
  assert_int_equal(clFinish(queue), CL_SUCCESS);
  return outputs_read(&t->s);
}

/* After a failure, the same commands from a reset on give the same bits, and no
 * reference leaks but that of an event that could not be released.  step: every
 * so many calls fail. */
static void check_failures(hbil_cache_method method, cl_command_queue queue,
                           int step) {
  scene t;
  start(&t, method, ROOM_WIDTH, ROOM_HEIGHT);
  void *bytes = malloc(hbil_cache_size(t.s.frame.cache));
  assert_non_null(bytes);
  exact_planes want = light_of_commands(&t, queue, bytes);
  assert_true(largest_value(&want, EXACT_FAR_IRRADIANCE, 3) > 0.01);
  exact_planes again = light_of_commands(&t, queue, bytes);
  const long held = shim_references();
  outcome o = {1 - step, "", HBIL_SUCCESS};
  while (o.failed) {
    const int n = o.nth + step, fault = n / step % MEMORY_FAULTS;
    o = ATTEMPT(n, faults[fault], every_command(&t, queue, bytes));
    check_outcome(shared_device.hbil, &o, fault);
    exact_planes got = light_of_commands(&t, queue, bytes);
    if (count_different(&got, &want))
      fail_msg("call %d: other bits than without the failure", n);
    exact_planes_free(&got);
    check_held(&o, held);
  }
  assert_in_range(o.nth, 100, 5000);
  planes_free(&again, &want);
  free(bytes);
  stop(&t);
}

TEST(failed_commands_can_be_repeated) {
  for (hbil_cache_method p = first_method; p <= last_method; ++p)
    check_failures(p, shared_device.queue, p == first_method ? 2 : 5);
}

TEST(failed_commands_of_any_order_can_be_repeated) {
  cl_int error;
  cl_command_queue queue =
      clCreateCommandQueue(shared_device.context, shared_device.id,
                           CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &error);
  /* rusticl 22.3 has no out-of-order queues */
  if (error == CL_INVALID_QUEUE_PROPERTIES)
    skip();
  assert_int_equal(error, CL_SUCCESS);
  check_failures(first_method, queue, 5); /* all kinds of calls */
  clReleaseCommandQueue(queue);
}

/* ------------------------------------------------------------------------ */
/* What is rejected                                                          */

TEST(bad_arguments_are_rejected_by_name) {
  scene t;
  start(&t, HBIL_CACHE_METHOD_RSM, 97, 61);
  hbil_cache *cache = t.s.frame.cache;
  const cl_command_queue queue = shared_device.queue;
  exact_planes want = lit_outputs(&t);
  room_rejected(
      hbil_enqueue_cache_light_views(cache, queue, t.views, 5, 0, NULL, NULL),
      HBIL_INVALID_ARGUMENT, "count");
  room_rejected(
      hbil_enqueue_cache_light_views(cache, queue, NULL, 1, 0, NULL, NULL),
      HBIL_INVALID_ARGUMENT, "views");
  room_rejected(
      hbil_enqueue_cache_light_views(cache, NULL, t.views, 1, 0, NULL, NULL),
      HBIL_INVALID_ARGUMENT, "queue");
  room_rejected(
      hbil_enqueue_cache_light_views(cache, queue, t.views, 1, 1, NULL, NULL),
      HBIL_INVALID_ARGUMENT, "wait");
  assert_int_equal(
      hbil_enqueue_cache_light_views(NULL, queue, t.views, 1, 0, NULL, NULL),
      HBIL_INVALID_ARGUMENT);
  /* a queue of another context */
  cl_int error;
  cl_context other =
      clCreateContext(NULL, 1, &shared_device.id, NULL, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  cl_command_queue foreign =
      clCreateCommandQueue(other, shared_device.id, 0, &error);
  assert_int_equal(error, CL_SUCCESS);
  room_rejected(
      hbil_enqueue_cache_light_views(cache, foreign, t.views, 1, 0, NULL, NULL),
      HBIL_INVALID_ARGUMENT, "queue");
  clReleaseCommandQueue(foreign);
  clReleaseContext(other);
  hbil_view views[2] = {t.views[0], t.views[1]};
  views[1].width = 0;
  room_rejected(
      hbil_enqueue_cache_light_views(cache, queue, views, 2, 0, NULL, NULL),
      HBIL_INVALID_FRAME, "width");
  views[1] = t.views[1];
  views[1].direct.buffer = NULL;
  room_rejected(
      hbil_enqueue_cache_light_views(cache, queue, views, 2, 0, NULL, NULL),
      HBIL_INVALID_FRAME, "direct");
  views[1] = t.views[1];
  views[1].camera.fx = NAN;
  room_rejected(
      hbil_enqueue_cache_light_views(cache, queue, views, 2, 0, NULL, NULL),
      HBIL_INVALID_FRAME, "camera");
  /* none of these has changed the light */
  room_same_bits(&t.s, &want, "after rejected views");
  /* no view at all is allowed, and takes the light away */
  assert_success(&t.s, hbil_enqueue_cache_light_views(cache, queue, NULL, 0, 0,
                                                      NULL, NULL));
  exact_planes dark = room_outputs(&t.s);
  assert_true(largest_value(&dark, EXACT_FAR_IRRADIANCE, 3) == 0.0);
  planes_free(&dark, &want);
  stop(&t);
}

TEST(plans_need_their_method_in_the_cache) {
  static const char *const names[] = {
      [HBIL_CACHE_METHOD_RAYS] = "HBIL_CACHE_METHOD_RAYS",
      [HBIL_CACHE_METHOD_CONES] = "HBIL_CACHE_METHOD_CONES",
      [HBIL_CACHE_METHOD_LPV] = "HBIL_CACHE_METHOD_LPV",
      [HBIL_CACHE_METHOD_RSM] = "HBIL_CACHE_METHOD_RSM"};
  shim_skip_builds(true);
  for (hbil_cache_method p = first_method; p <= last_method; ++p)
    for (hbil_cache_method q = first_method; q <= last_method; ++q) {
      scene t;
      if (q == p || p == HBIL_CACHE_METHOD_RAYS)
        continue;
      start(&t, p, 8, 8);
      hbil_cache *own = t.s.frame.cache;
      hbil_cache *other = t.s.frame.cache = cache_for(q);
      room_rejected(hbil_enqueue_frame(t.s.plan, shared_device.queue,
                                       &t.s.frame, 0, NULL, NULL),
                    HBIL_INVALID_FRAME, names[q]);
      assert_non_null(
          strstr(hbil_context_message(shared_device.hbil), names[p]));
      if (q != HBIL_CACHE_METHOD_RSM)
        room_rejected(hbil_enqueue_cache_light_views(other, shared_device.queue,
                                                     t.views, 1, 0, NULL, NULL),
                      HBIL_INVALID_ARGUMENT, names[q]);
      t.s.frame.cache = own;
      hbil_cache_destroy(other);
      stop(&t);
    }
  shim_skip_builds(false);
}

TEST(bad_settings_are_rejected_by_name) {
  static const int unknown[] = {-1, HBIL_CACHE_METHOD_NONE,
                                HBIL_CACHE_METHOD_RSM + 1};
  for (int i = 0; i < 3; ++i) {
    hbil_cache_config config = room_cache_config();
    hbil_cache *cache = (hbil_cache *)&config;
    size_t bytes = 77;
    config.method = (hbil_cache_method)unknown[i];
    room_rejected(hbil_cache_create(shared_device.hbil, &config, &cache),
                  HBIL_INVALID_CONFIG, "method");
    assert_null(cache);
    room_rejected(hbil_cache_memory(shared_device.hbil, &config, &bytes),
                  HBIL_INVALID_CONFIG, "method");
    assert_int_equal(bytes, 77);
  }
  hbil_cache *cache = cache_for(HBIL_CACHE_METHOD_LPV);
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  assert_int_equal(update.steps, 16);
  update.steps = 1025;
  room_rejected(hbil_enqueue_cache_update(cache, shared_device.queue, &update,
                                          0, NULL, NULL),
                HBIL_INVALID_ARGUMENT, "steps");
  hbil_cache_destroy(cache);
  setup s;
  hbil_plan *plan = NULL;
  setup_init(&s, 8, 8);
  s.config.model.cache_method = (hbil_cache_method)(last_method + 1);
  room_rejected(hbil_plan_create(shared_device.hbil, &s.config, &plan),
                HBIL_INVALID_CONFIG, "model.cache_method");
  assert_null(plan);
  setup_free(&s);
}
