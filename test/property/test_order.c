/*
 * The commands of a plan run in the order of the calls: frames and passes that
 * nobody chains give the bits of chained ones, on out-of-order queues and on
 * queues that alternate.
 *
 * The first command of a sequence waits for an event that the test sets when
 * everything is enqueued.  So no call may wait on the host, and commands that
 * wait for nothing would run before those that they need.
 */
#define _POSIX_C_SOURCE 200809L /* nanosleep */
#include "test/support/fixture.h"
#include "test/support/shim.h"

#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

/* Long enough for a frame to overtake another one. */
#define WIDTH 640
#define HEIGHT 360
enum { FRAMES = 6, QUEUES = 2 };

static const cl_command_queue_properties out_of_order =
    CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE;

/* A plan, and the queues that its calls take turns on. */
typedef struct order {
  setup s;
  cl_command_queue queues[QUEUES];
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

static void start(order *o, cl_command_queue_properties first,
                  cl_command_queue_properties second) {
  setup_every_pass(&o->s, HBIL_REPROJECTION_CAMERA, 0, WIDTH, HEIGHT);
  o->s.config.sampling.slices = o->s.config.sampling.slice_frames = 2;
  setup_start(&o->s);
  o->queues[0] = make_queue(first);
  o->queues[1] = make_queue(second);
}

static void finish_queues(const order *o) {
  for (int i = 0; i < QUEUES; ++i)
    assert_int_equal(clFinish(o->queues[i]), CL_SUCCESS);
}

static void stop(order *o) {
  setup_free(&o->s);
  for (int i = 0; i < QUEUES; ++i)
    clReleaseCommandQueue(o->queues[i]);
}

static cl_event make_gate(void) {
  cl_int error;
  const cl_event gate = clCreateUserEvent(shared_device.context, &error);
  assert_int_equal(error, CL_SUCCESS);
  return gate;
}

/* Opens a gate and waits for all that is behind it. */
static void open_gate(const order *o, cl_event gate) {
  /* time for commands that don't wait for the gate, but should: a frame takes
   * less than a quarter of this */
  nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
  assert_int_equal(clSetUserEventStatus(gate, CL_COMPLETE), CL_SUCCESS);
  finish_queues(o);
  clReleaseEvent(gate);
}

/* --- sequences --- */

static enqueue_function *const whole_frame[] = {hbil_enqueue_frame};

/* A sequence from its first frame on.  The inputs stay, so each frame adds a
 * bounce of light, and turns the pattern. */
static exact_planes chained_frames(order *o) {
  hbil_plan_reset(o->s.plan);
  for (cl_uint i = 0; i < FRAMES; ++i) {
    o->s.frame.frame_index = i;
    setup_run(&o->s, hbil_enqueue_frame);
  }
  return outputs_read(&o->s);
}

/* The same unchained: `count` calls for each frame, of which the very first one
 * waits for the gate. */
static void unchained(order *o, enqueue_function *const *calls, int count) {
  const cl_event gate = make_gate();
  hbil_plan_reset(o->s.plan);
  for (int i = 0; i < FRAMES * count; ++i) {
    o->s.frame.frame_index = (cl_uint)(i / count);
    assert_success(&o->s, calls[i % count](o->s.plan, o->queues[i % QUEUES],
                                           &o->s.frame, i == 0,
                                           i ? NULL : &gate, NULL));
  }
  open_gate(o, gate);
}

static void check_outputs(order *o, const exact_planes *want) {
  exact_planes got = outputs_read(&o->s);
  assert_int_equal(count_different(&got, want), 0);
  exact_planes_free(&got);
}

static void check_unchained(order *o, enqueue_function *const *calls,
                            int count) {
  exact_planes want = chained_frames(o);
  assert_true(largest_value(&want, 0, want.count) > 0.0);
  unchained(o, calls, count);
  check_outputs(o, &want);
  exact_planes_free(&want);
}

static void check_queues(cl_command_queue_properties first,
                         cl_command_queue_properties second) {
  order o;
  start(&o, first, second);
  check_unchained(&o, whole_frame, 1);
  check_unchained(&o, passes, PASSES);
  stop(&o);
}

TEST(an_out_of_order_queue_keeps_the_order) {
  order o;
  start(&o, out_of_order, 0);
  const cl_command_queue other = o.queues[1];
  o.queues[1] = o.queues[0];
  check_unchained(&o, whole_frame, 1);
  check_unchained(&o, passes, PASSES);
  o.queues[1] = other;
  stop(&o);
}

TEST(two_in_order_queues_keep_the_order) {
  check_queues(0, 0);
}

TEST(queues_of_both_kinds_keep_the_order) {
  check_queues(0, out_of_order);
}

TEST(two_out_of_order_queues_keep_the_order) {
  check_queues(out_of_order, out_of_order);
}

/* --- wait lists and events --- */

static void run_first(order *o, cl_uint count, const cl_event *list,
                      cl_event *event) {
  assert_success(&o->s, hbil_enqueue_frame(o->s.plan, o->queues[0], &o->s.frame,
                                           count, list, event));
}

static cl_int state_of(cl_event event) {
  cl_int state = CL_QUEUED;
  assert_int_equal(clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS,
                                  sizeof state, &state, NULL),
                   CL_SUCCESS);
  return state;
}

/* A second frame waits for its own wait list and for the first frame, and its
 * event follows both. */
TEST(wait_lists_are_followed_as_well) {
  order o;
  cl_event gates[3], event = NULL;
  start(&o, out_of_order, 0);
  for (int opened_last = 0; opened_last < 3; ++opened_last) {
    for (int i = 0; i < 3; ++i)
      gates[i] = make_gate();
    run_first(&o, 1, gates, NULL);
    run_first(&o, 2, gates + 1, &event);
    for (int i = 1; i < 3; ++i)
      clSetUserEventStatus(gates[(opened_last + i) % 3], CL_COMPLETE);
    assert_int_equal(clFlush(o.queues[0]), CL_SUCCESS);
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
    assert_true(state_of(event) > CL_COMPLETE);
    clSetUserEventStatus(gates[opened_last], CL_COMPLETE);
    assert_int_equal(clWaitForEvents(1, &event), CL_SUCCESS);
    clReleaseEvent(event);
    for (int i = 0; i < 3; ++i)
      clReleaseEvent(gates[i]);
  }
  finish_queues(&o);
  stop(&o);
}

/* A call on the in-order queue of the last one makes no event that nobody
 * asked for, nor does it take a reference. */
TEST(an_in_order_queue_costs_nothing) {
  order o;
  start(&o, 0, 0);
  run_first(&o, 0, NULL, NULL);
  const long held = shim_references(), made = shim_events_made();
  run_first(&o, 0, NULL, NULL);
  assert_int_equal(shim_references(), held);
  assert_int_equal(shim_events_made(), made);
  finish_queues(&o);
  stop(&o);
}

/* The caller may release a queue that the plan goes on to wait for. */
TEST(queues_may_be_released) {
  const long before = shim_references();
  order o;
  start(&o, 0, out_of_order);
  exact_planes want = chained_frames(&o);
  hbil_plan_reset(o.s.plan);
  for (cl_uint i = 0; i < FRAMES; ++i) {
    const bool last = i == FRAMES - 1;
    const cl_command_queue queue =
        last ? o.queues[0] : make_queue(i % 2 ? out_of_order : 0);
    o.s.frame.frame_index = i;
    assert_success(
        &o.s, hbil_enqueue_frame(o.s.plan, queue, &o.s.frame, 0, NULL, NULL));
    if (!last)
      clReleaseCommandQueue(queue);
  }
  finish_queues(&o);
  check_outputs(&o, &want);
  exact_planes_free(&want);
  stop(&o);
  assert_int_equal(shim_references(), before);
}

/* --- failures --- */

/* Enqueues a sequence behind a gate.  Call `nth` of its second frame fails; if
 * the frame does, too, it is enqueued anew. */
typedef struct attempt {
  const char *failed; /* name of the call; NULL: there are fewer */
  int calls;          /* of the attempt, up to the one that failed */
} attempt;

static attempt fail_second_frame(order *o, int nth, bool with_event) {
  const cl_event gate = make_gate();
  attempt made = {NULL, 0};
  hbil_plan_reset(o->s.plan);
  for (cl_uint i = 0; i < FRAMES; ++i) {
    const cl_command_queue queue = o->queues[i % QUEUES];
    cl_event event = NULL, *const wanted = with_event ? &event : NULL;
    o->s.frame.frame_index = i;
    shim_fail(i == 1 ? nth : 0, CL_OUT_OF_RESOURCES);
    hbil_status status = hbil_enqueue_frame(o->s.plan, queue, &o->s.frame,
                                            i == 0, i ? NULL : &gate, wanted);
    if (i == 1)
      made = (attempt){shim_failed(), nth - shim_remaining()};
    shim_fail(0, CL_SUCCESS);
    if (status != HBIL_SUCCESS)
      status =
          hbil_enqueue_frame(o->s.plan, queue, &o->s.frame, 0, NULL, wanted);
    assert_success(&o->s, status);
    if (event)
      clReleaseEvent(event);
  }
  open_gate(o, gate);
  return made;
}

/* What a failed frame had enqueued is waited for, too. */
static void check_failures(cl_command_queue_properties first,
                           cl_command_queue_properties second) {
  attempt made = {"", 0};
  order o;
  start(&o, first, second);
  exact_planes want = chained_frames(&o);
  /* the first calls are those that make the order, the others launch */
  for (int nth = 1; made.failed; nth += nth < 10 ? 1 : 23) {
    made = fail_second_frame(&o, nth, false);
    check_outputs(&o, &want);
  }
  assert_in_range(made.calls, 150, 1000);
  exact_planes_free(&want);
  stop(&o);
}

TEST(failed_frames_keep_the_order) {
  check_failures(out_of_order, out_of_order);
  check_failures(0, 0);
}

/* The plan has an event of its own on an out-of-order queue.  Without it, the
 * next call waits for the whole queue. */
TEST(an_event_that_is_not_retained_keeps_the_order) {
  order o;
  start(&o, out_of_order, out_of_order);
  exact_planes want = chained_frames(&o);
  /* from the last call backwards */
  int nth = fail_second_frame(&o, INT_MAX, true).calls;
  while (nth &&
         strcmp(fail_second_frame(&o, nth, true).failed, "clRetainEvent"))
    --nth;
  assert_int_not_equal(nth, 0);
  check_outputs(&o, &want);
  exact_planes_free(&want);
  stop(&o);
}

/* --- figures --- */

typedef struct opener {
  cl_event gate;
  atomic_bool opened;
} opener;

static void *open_later(void *data) {
  opener *later = data;
  nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
  later->opened = true;
  clSetUserEventStatus(later->gate, CL_COMPLETE);
  return NULL;
}

typedef void question(order *o, void *figures);

static void ask_statistics(order *o, void *figures) {
  assert_success(&o->s, hbil_plan_statistics(o->s.plan, o->queues[1], figures));
}

static void ask_sanitized(order *o, void *figures) {
  assert_success(&o->s, hbil_plan_sanitized(o->s.plan, o->queues[1], figures));
}

/* Asks for the figures of a frame that doesn't begin before something else on
 * the device is done: the answer must not come earlier. */
static void ask_early(order *o, question *ask, void *figures) {
  opener later = {.gate = make_gate()};
  pthread_t thread;
  run_first(o, 1, &later.gate, NULL);
  assert_int_equal(pthread_create(&thread, NULL, open_later, &later), 0);
  ask(o, figures);
  assert_true(later.opened);
  pthread_join(thread, NULL);
  clReleaseEvent(later.gate);
}

static void check_figures(cl_command_queue_properties first,
                          cl_command_queue_properties second) {
  hbil_statistics early, late;
  hbil_sanitized early_count, late_count;
  order o;
  start(&o, first, second);
  for (int i = 0; i < WIDTH; ++i) /* something to count */
    o.s.input[EXACT_ALBEDO][i] = NAN;
  setup_upload(&o.s);
  ask_early(&o, ask_statistics, &early);
  ask_early(&o, ask_sanitized, &early_count);
  finish_queues(&o);
  ask_statistics(&o, &late);
  ask_sanitized(&o, &late_count);
  assert_true(early.all.pixels == WIDTH * HEIGHT);
  assert_true(early.all.spans == late.all.spans);
  assert_int_equal(early_count.albedo, WIDTH);
  assert_memory_equal(&early_count, &late_count, sizeof early_count);
  stop(&o);
}

TEST(figures_wait_for_the_frame) {
  check_figures(0, 0);
  check_figures(out_of_order, out_of_order);
  check_figures(out_of_order, 0);
}

/* Timings of a frame whose passes were on two queues. */
TEST(timings_are_of_both_queues) {
  const cl_command_queue_properties profiling = CL_QUEUE_PROFILING_ENABLE;
  double ms[HBIL_PASS_COUNT];
  order o;
  setup_every_pass(&o.s, HBIL_REPROJECTION_CAMERA, 0, WIDTH, HEIGHT);
  o.s.config.execution.profiling = CL_TRUE;
  setup_start(&o.s);
  o.queues[0] = make_queue(profiling);
  o.queues[1] = make_queue(profiling | out_of_order);
  for (int i = 0; i < 2 * PASSES; ++i)
    assert_success(&o.s, passes[i % PASSES](o.s.plan, o.queues[i % QUEUES],
                                            &o.s.frame, 0, NULL, NULL));
  assert_success(&o.s, hbil_plan_timings(o.s.plan, ms));
  for (int i = 0; i < PASSES; ++i)
    assert_true(ms[i] > 0.0);
  stop(&o);
}
