/*
 * Commands of a cache: they run in the order of the calls, among plans and
 * queues, any of them may fail, cache, plans and context go in any order, and
 * nothing is allocated by them.
 */
#define _POSIX_C_SOURCE 200809L /* nanosleep */
#include "test/support/cache.h"
#include "test/support/room.h"
#include "test/support/shim.h"

#include <time.h>

/* ------------------------------------------------------------------------ */
/* Order                                                                     */

enum { PLANS = 2, FRAMES = 6 };

/* Two plans that share a cache, and two queues that calls take turns on.  The
 * frames are so large that a command could overtake another one. */
#define WIDTH 480
#define HEIGHT 270

typedef struct order {
  setup plans[PLANS];
  hbil_cache *cache;
  hbil_view views[FRAMES];
  cl_command_queue queues[2];
  int calls;
} order;

static cl_command_queue make_queue(cl_command_queue_properties properties) {
  cl_int error;
  cl_command_queue queue = clCreateCommandQueue(
      shared_device.context, shared_device.id, properties, &error);
  /* rusticl 22.3 has no out-of-order queues */
  if (error == CL_INVALID_QUEUE_PROPERTIES)
    skip();
  assert_int_equal(error, CL_SUCCESS);
  return queue;
}

static void start(order *o) {
  const room r = room_lit();
  o->queues[0] = make_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
  o->queues[1] = make_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
  o->cache = room_cache(&shared_device);
  o->calls = 0;
  for (int i = 0; i < PLANS; ++i) {
    const double eye[3] = {0.1, 0.2 - 0.3 * i, -1.0};
    const hbil_camera camera = room_camera(eye, AHEAD, WIDTH, HEIGHT, 75.0);
    room_setup(&o->plans[i], &r, &camera, WIDTH, HEIGHT);
    o->plans[i].config.sampling.slices = 1;
    o->plans[i].config.sampling.steps_per_side = 4;
    o->plans[i].config.sampling.unfiltered = CL_TRUE;
    o->plans[i].frame.cache = o->cache;
    setup_start(&o->plans[i]);
  }
  for (int i = 0; i < FRAMES; ++i) {
    const double eye[3] = {0.2 * i - 0.5, 0.1 * i - 0.3, 0.0};
    const hbil_camera camera =
        room_camera(eye, (wall)(i % WALLS), 96, 96, 100.0);
    room lit = r;
    lit.direct[BEHIND] += (float)i;
    o->views[i] =
        room_view(&shared_device, &lit, &camera, HBIL_PROJECTION_PERSPECTIVE,
                  96, 96, HBIL_VIEW_DIRECT);
  }
}

static void stop(order *o) {
  for (int i = 0; i < PLANS; ++i)
    setup_free(&o->plans[i]);
  room_views_free(o->views, FRAMES);
  hbil_cache_destroy(o->cache);
  for (int i = 0; i < 2; ++i)
    clReleaseCommandQueue(o->queues[i]);
}

/* The queue of the next call; chained: everything before is waited for. */
static cl_command_queue next_queue(order *o, bool chained) {
  if (chained)
    assert_int_equal(clFinish(shared_device.queue), CL_SUCCESS);
  return chained ? shared_device.queue : o->queues[o->calls++ % 2];
}

/* All commands of a cache and frames of both plans; the first one waits for
 * `gate` unless that is NULL. */
static void run_sequence(order *o, cl_event gate) {
  const setup *s = &o->plans[0];
  const bool chained = !gate;
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  update.rounds = 2;
  assert_success(s, hbil_enqueue_cache_reset(o->cache, next_queue(o, chained),
                                             gate ? 1 : 0, gate ? &gate : NULL,
                                             NULL));
  for (int i = 0; i < FRAMES; ++i) {
    const setup *plan = &o->plans[i % PLANS];
    const double centre[3] = {i % 2 ? 0.25 : 0.0, 0.0, i % 3 ? 0.25 : 0.0};
    assert_success(s, hbil_enqueue_cache_move(o->cache, next_queue(o, chained),
                                              centre, 0, NULL, NULL));
    assert_success(s,
                   hbil_enqueue_cache_inject(o->cache, next_queue(o, chained),
                                             &o->views[i], 1, 0, NULL, NULL));
    assert_success(s,
                   hbil_enqueue_cache_update(o->cache, next_queue(o, chained),
                                             &update, 0, NULL, NULL));
    assert_success(s, hbil_enqueue_frame(plan->plan, next_queue(o, chained),
                                         &plan->frame, 0, NULL, NULL));
  }
  if (chained)
    assert_int_equal(clFinish(shared_device.queue), CL_SUCCESS);
}

static void unchained_commands_keep_the_order(void **state) {
  order o;
  exact_planes want[PLANS];
  (void)state;
  start(&o);
  run_sequence(&o, NULL);
  for (int i = 0; i < PLANS; ++i) {
    want[i] = outputs_read(&o.plans[i]);
    assert_true(largest_value(&want[i], EXACT_FAR_IRRADIANCE, 3) > 0.01);
  }
  assert_true(count_different(&want[0], &want[1]) > 0);
  for (int turn = 0; turn < 3; ++turn) {
    cl_int error;
    const cl_event gate = clCreateUserEvent(shared_device.context, &error);
    assert_int_equal(error, CL_SUCCESS);
    o.calls = turn; /* which queue is first */
    run_sequence(&o, gate);
    /* time for commands that don't wait for the gate, but should */
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
    assert_int_equal(clSetUserEventStatus(gate, CL_COMPLETE), CL_SUCCESS);
    for (int i = 0; i < 2; ++i)
      assert_int_equal(clFinish(o.queues[i]), CL_SUCCESS);
    clReleaseEvent(gate);
    for (int i = 0; i < PLANS; ++i) {
      exact_planes got = outputs_read(&o.plans[i]);
      assert_int_equal(count_different(&got, &want[i]), 0);
      exact_planes_free(&got);
    }
  }
  for (int i = 0; i < PLANS; ++i)
    exact_planes_free(&want[i]);
  stop(&o);
}

/* ------------------------------------------------------------------------ */
/* Lifetimes                                                                 */

/* Frames and a cache's commands are under way on an out-of-order queue when
 * everything that they use is destroyed, in every order. */
static void cache_plan_and_context_go_in_any_order(void **state) {
  static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  (void)state;
  for (int i = 0; i < 12; ++i) {
    const long before = shim_references();
    const room r = room_lit();
    const double eye[3] = {0.1, 0.2, -1.0};
    const hbil_camera camera =
        room_camera(eye, AHEAD, ROOM_WIDTH, ROOM_HEIGHT, 75.0);
    device_fixture own = shared_device;
    cl_event event = NULL;
    setup s;
    assert_int_equal(hbil_context_create(own.context, own.id, &own.hbil),
                     HBIL_SUCCESS);
    own.queue = make_queue(i < 6 ? CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE : 0);
    room_setup(&s, &r, &camera, ROOM_WIDTH, ROOM_HEIGHT);
    s.config.sampling.slices = 1;
    s.config.sampling.steps_per_side = 4;
    s.config.sampling.unfiltered = CL_TRUE;
    s.device = &own;
    setup_start(&s);
    hbil_cache *cache = s.frame.cache = room_cache(&own);
    hbil_view view = cache_view(&s, HBIL_VIEW_DIRECT);
    assert_int_equal(
        hbil_enqueue_cache_inject(cache, own.queue, &view, 1, 0, NULL, NULL),
        HBIL_SUCCESS);
    assert_int_equal(
        hbil_enqueue_cache_update(cache, own.queue, NULL, 0, NULL, NULL),
        HBIL_SUCCESS);
    assert_int_equal(
        hbil_enqueue_frame(s.plan, own.queue, &s.frame, 0, NULL, &event),
        HBIL_SUCCESS);
    for (int k = 0; k < 3; ++k)
      switch (orders[i % 6][k]) {
      case 0:
        hbil_cache_destroy(cache);
        break;
      case 1:
        hbil_plan_destroy(s.plan);
        s.plan = NULL;
        break;
      default:
        hbil_context_destroy(own.hbil);
      }
    clReleaseCommandQueue(own.queue);
    assert_int_equal(clWaitForEvents(1, &event), CL_SUCCESS);
    clReleaseEvent(event);
    setup_free(&s);
    assert_int_equal(shim_references(), before);
  }
}

/* A plan goes on without a cache that was destroyed. */
static void plans_outlive_their_cache(void **state) {
  room_scene t;
  (void)state;
  room_start(&t);
  hbil_cache_destroy(t.s.frame.cache);
  t.s.frame.cache = NULL;
  exact_planes without = room_outputs(&t.s);
  assert_true(count_different(&without, &t.want) > 0);
  t.s.frame.cache = room_cache(&shared_device);
  room_inject(&shared_device, t.s.frame.cache, t.views, WALLS, 1);
  room_same_bits(&t.s, &t.want, "a second cache");
  exact_planes_free(&without);
  room_stop(&t);
}

/* ------------------------------------------------------------------------ */
/* Memory                                                                    */

static void caches_take_the_announced_memory(void **state) {
  static const cl_uint voxels[] = {16, 32, 64, 128};
  (void)state;
  shim_skip_builds(true);
  for (size_t i = 0; i < sizeof voxels / sizeof *voxels; ++i)
    for (cl_uint levels = 1; levels <= 4; ++levels) {
      hbil_cache_config config = room_cache_config();
      hbil_cache *cache;
      size_t bytes = 0;
      config.voxels = voxels[i];
      config.levels = levels;
      shim_start_counting();
      assert_int_equal(hbil_cache_memory(shared_device.hbil, &config, &bytes),
                       HBIL_SUCCESS);
      assert_int_equal(shim_created().count, 0);
      assert_int_equal(hbil_cache_create(shared_device.hbil, &config, &cache),
                       HBIL_SUCCESS);
      assert_int_equal(shim_created().bytes, bytes);
      assert_true(shim_created().count > 0);
      hbil_cache_destroy(cache);
    }
  shim_skip_builds(false);
}

static void a_default_cache_takes_48_mib_at_most(void **state) {
  hbil_cache_config config;
  size_t bytes = 0;
  (void)state;
  hbil_cache_config_init(&config);
  config.voxel_size = 0.1;
  config.inputs.normal = three_floats;
  config.inputs.depth = one_float;
  assert_int_equal(hbil_cache_memory(shared_device.hbil, &config, &bytes),
                   HBIL_SUCCESS);
  check_at_most("memory, MiB", (double)bytes / 1048576.0, 48.0);
  assert_true(bytes > 64 * 64 * 64);
}

/* What a device can't hold, the query rejects in the same words. */
static void too_large_caches_are_rejected(void **state) {
  const hbil_cache_config config = room_cache_config();
  const cl_ulong most = 65536;
  hbil_cache *cache = (hbil_cache *)&config;
  size_t bytes = 77;
  (void)state;
  shim_answer(CL_DEVICE_MAX_MEM_ALLOC_SIZE, &most, sizeof most);
  const hbil_status asked =
      hbil_cache_memory(shared_device.hbil, &config, &bytes);
  const hbil_status made =
      hbil_cache_create(shared_device.hbil, &config, &cache);
  shim_answer(0, NULL, 0);
  room_rejected(asked, HBIL_OUT_OF_DEVICE_MEMORY, "voxels");
  assert_int_equal(made, HBIL_OUT_OF_DEVICE_MEMORY);
  assert_null(cache);
}

static void commands_create_no_buffers(void **state) {
  const double centre[3] = {0.25, 0.0, 0.0};
  room_scene t;
  (void)state;
  room_start(&t);
  shim_start_counting();
  room_inject(&shared_device, t.s.frame.cache, t.views, WALLS, 2);
  assert_success(&t.s,
                 hbil_enqueue_cache_move(t.s.frame.cache, shared_device.queue,
                                         centre, 0, NULL, NULL));
  setup_run(&t.s, hbil_enqueue_frame);
  (void)room_statistics(&shared_device, t.s.frame.cache);
  assert_success(&t.s,
                 hbil_enqueue_cache_reset(t.s.frame.cache, shared_device.queue,
                                          0, NULL, NULL));
  assert_int_equal(clFinish(shared_device.queue), CL_SUCCESS);
  assert_int_equal(shim_created().count, 0);
  room_stop(&t);
}

/* No byte outside of the cache's buffers is written. */
static void nothing_is_written_outside_of_buffers(void **state) {
  const double places[2][3] = {{0.5, -0.25, 0.75}, {0.0, 0.0, 0.0}};
  room_scene t;
  (void)state;
  shim_guard_buffers(true);
  room_start(&t);
  for (int i = 0; i < 2; ++i) {
    assert_success(&t.s,
                   hbil_enqueue_cache_move(t.s.frame.cache, shared_device.queue,
                                           places[i], 0, NULL, NULL));
    room_inject(&shared_device, t.s.frame.cache, t.views, WALLS, 2);
    setup_run(&t.s, hbil_enqueue_frame);
  }
  assert_int_equal(shim_overwritten(shared_device.queue), 0);
  shim_guard_buffers(false);
  room_stop(&t);
}

/* ------------------------------------------------------------------------ */
/* Failures                                                                  */

static const cl_int errors[] = {CL_OUT_OF_RESOURCES, CL_OUT_OF_HOST_MEMORY};
static const hbil_status statuses[] = {HBIL_OUT_OF_DEVICE_MEMORY,
                                       HBIL_OUT_OF_HOST_MEMORY};
static const char *const names[] = {"CL_OUT_OF_RESOURCES",
                                    "CL_OUT_OF_HOST_MEMORY"};
enum { ERRORS = 2 };

/* Checks status and message of an attempt in which call `nth` failed; false: it
 * made fewer calls.  A failed release can't be repaired. */
static bool check_attempt(hbil_status status, int nth, int e) {
  const char *failed = shim_failed();
  const char *message = hbil_context_message(shared_device.hbil);
  shim_fail(0, CL_SUCCESS);
  const bool ignored = !failed || !strncmp(failed, "clRelease", 9) ||
                       !strcmp(failed, "clRetainEvent");
  const hbil_status want = ignored ? HBIL_SUCCESS : statuses[e];
  if (status != want)
    fail_msg("call %d, %s: \"%s\", expected \"%s\"", nth,
             failed ? failed : "none", hbil_status_string(status),
             hbil_status_string(want));
  if (!ignored && !strstr(message, names[e]))
    fail_msg("call %d, %s: %s is not named in the message \"%s\"", nth, failed,
             names[e], message);
  return failed != NULL;
}

static hbil_status make_cache(void) {
  const hbil_cache_config config = room_cache_config();
  hbil_cache *cache = NULL;
  const hbil_status status =
      hbil_cache_create(shared_device.hbil, &config, &cache);
  assert_int_equal(cache != NULL, status == HBIL_SUCCESS);
  hbil_cache_destroy(cache);
  return status;
}

static void failed_caches_leave_nothing(void **state) {
  (void)state;
  for (int e = 0; e < ERRORS; ++e) {
    const long held = shim_references();
    int n = 0;
    bool failed = true;
    while (failed) {
      shim_fail(++n, errors[e]);
      const hbil_status status = make_cache();
      failed = check_attempt(status, n, e);
      assert_int_equal(shim_references(), held);
    }
    assert_in_range(n, 40, 2000);
  }
}

/* One call of each kind, from a reset on; the first failure ends it. */
static hbil_status every_command(room_scene *t, cl_command_queue queue,
                                 void *bytes) {
  static const double away[3] = {0.25, 0.0, 0.0};
  hbil_cache *cache = t->s.frame.cache;
  hbil_cache_counts n;
  hbil_cache_update update;
  cl_event event = NULL;
  hbil_cache_update_init(&update);
  hbil_status status =
      hbil_enqueue_cache_move(cache, queue, room_middle, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_reset(cache, queue, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_inject(cache, queue, t->views + BEHIND, 1, 0,
                                       NULL, &event);
  if (event)
    clReleaseEvent(event);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_update(cache, queue, &update, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_move(cache, queue, away, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_cache_statistics(cache, queue, &n);
  if (status == HBIL_SUCCESS)
    status = hbil_cache_save(cache, queue, bytes, hbil_cache_size(cache));
  if (status == HBIL_SUCCESS)
    status = hbil_cache_load(cache, queue, bytes, hbil_cache_size(cache));
  update.rounds = 0;
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_cache_update(cache, queue, &update, 0, NULL, NULL);
  if (status == HBIL_SUCCESS)
    status = hbil_enqueue_frame(t->s.plan, queue, &t->s.frame, 0, NULL, NULL);
  return status;
}

/* After a failure, the same commands from a reset on give the same bits, and no
 * reference leaks but that of an event that could not be released. */
static void check_failures(cl_command_queue queue, int step) {
  room_scene t;
  room_start(&t);
  void *bytes = malloc(hbil_cache_size(t.s.frame.cache));
  assert_non_null(bytes);
  assert_success(&t.s, every_command(&t, queue, bytes));
  assert_int_equal(clFinish(queue), CL_SUCCESS);
  exact_planes want = outputs_read(&t.s);
  assert_true(largest_value(&want, EXACT_FAR_IRRADIANCE, 3) > 0.01);
  assert_success(&t.s, every_command(&t, queue, bytes));
  assert_int_equal(clFinish(queue), CL_SUCCESS);
  const long held = shim_references();
  int n = 1 - step;
  for (bool failed = true; failed;) {
    const int e = (n += step) % ERRORS;
    shim_fail(n, errors[e]);
    const hbil_status status = every_command(&t, queue, bytes);
    failed = check_attempt(status, n, e);
    assert_success(&t.s, every_command(&t, queue, bytes));
    assert_int_equal(clFinish(queue), CL_SUCCESS);
    exact_planes got = outputs_read(&t.s);
    if (count_different(&got, &want))
      fail_msg("call %d: other bits than without the failure", n);
    exact_planes_free(&got);
    assert_int_equal(shim_references(), held);
  }
  assert_in_range(n, 100, 5000);
  exact_planes_free(&want);
  free(bytes);
  room_stop(&t);
}

static void failed_commands_can_be_repeated(void **state) {
  (void)state;
  check_failures(shared_device.queue, 1);
}

static void failed_commands_of_any_order_can_be_repeated(void **state) {
  cl_command_queue queue = make_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
  (void)state;
  check_failures(queue, 5); /* all kinds of calls */
  clReleaseCommandQueue(queue);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(unchained_commands_keep_the_order),
      cmocka_unit_test(cache_plan_and_context_go_in_any_order),
      cmocka_unit_test(plans_outlive_their_cache),
      cmocka_unit_test(caches_take_the_announced_memory),
      cmocka_unit_test(a_default_cache_takes_48_mib_at_most),
      cmocka_unit_test(too_large_caches_are_rejected),
      cmocka_unit_test(commands_create_no_buffers),
      cmocka_unit_test(nothing_is_written_outside_of_buffers),
      cmocka_unit_test(failed_caches_leave_nothing),
      cmocka_unit_test(failed_commands_can_be_repeated),
      cmocka_unit_test(failed_commands_of_any_order_can_be_repeated)};
  return RUN_WITH_DEVICE(tests);
}
