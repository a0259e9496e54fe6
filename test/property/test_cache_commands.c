/*
 * Commands of a cache: they run in the order of the calls, among plans and
 * queues, cache, plans and context go in any order, and nothing is allocated by
 * them.
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
  hbil_cache_update update = cache_bounces(2);
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

TEST(unchained_commands_keep_the_order) {
  order o;
  exact_planes want[PLANS];
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
TEST(cache_plan_and_context_go_in_any_order) {
  static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
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
TEST(plans_outlive_their_cache) {
  room_scene t;
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

TEST(a_default_cache_takes_48_mib_at_most) {
  hbil_cache_config config;
  size_t bytes = 0;
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
TEST(too_large_caches_are_rejected) {
  const hbil_cache_config config = room_cache_config();
  const cl_ulong most = 65536;
  hbil_cache *cache = (hbil_cache *)&config;
  size_t bytes = 77;
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

TEST(commands_create_no_buffers) {
  const double centre[3] = {0.25, 0.0, 0.0};
  room_scene t;
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
