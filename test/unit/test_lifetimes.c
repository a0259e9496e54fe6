/*
 * Contexts and plans are destroyed in any order, also while commands are under
 * way: nothing leaks, and a plan works without the handle of its context. Child
 * processes leave all of it alone.
 * test_valgrind and test_sanitize see what is used after it was freed.
 */
#define _POSIX_C_SOURCE 200809L /* fork() */
#include "hbil/hbil_stages.h"

#include "test/support/fixture.h"
#include "test/support/shim.h"

#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

#define WIDTH 40
#define HEIGHT 24
enum { PLANS = 3 };

typedef struct family {
  hbil_context *context;
  hbil_plan *plans[PLANS];
  long before; /* references that were held before there was one */
} family;

static void start(family *f) {
  setup s;
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 1, WIDTH, HEIGHT);
  f->before = shim_references();
  assert_int_equal(
      hbil_context_create(shared_device.context, shared_device.id, &f->context),
      HBIL_SUCCESS);
  for (int i = 0; i < PLANS; ++i)
    if (hbil_plan_create(f->context, &s.config, &f->plans[i]) != HBIL_SUCCESS)
      fail_msg("%s", hbil_context_message(f->context));
  setup_free(&s);
}

/* What 0 to PLANS stand for: the plans, and then the context. */
static void destroy(family *f, int which) {
  if (which == PLANS)
    hbil_context_destroy(f->context);
  else
    hbil_plan_destroy(f->plans[which]);
}

TEST_WITHOUT_KERNELS(any_order_is_safe) {
  for (int context_at = 0; context_at <= PLANS; ++context_at) {
    family f;
    start(&f);
    for (int i = 0, plan = PLANS; i <= PLANS; ++i) {
      assert_true(shim_references() > f.before);
      destroy(&f, i == context_at ? PLANS : --plan);
    }
    assert_int_equal(shim_references(), f.before);
  }
}

TEST_WITHOUT_KERNELS(a_failed_plan_keeps_no_context) {
  family f;
  start(&f);
  hbil_config config;
  hbil_config_init(&config); /* no size */
  hbil_plan *plan = NULL;
  assert_int_equal(hbil_plan_create(f.context, &config, &plan),
                   HBIL_INVALID_CONFIG);
  assert_null(plan);
  for (int i = 0; i <= PLANS; ++i)
    destroy(&f, i);
  assert_int_equal(shim_references(), f.before);
}

static void note(hbil_message_kind kind, const char *message, void *user) {
  assert_int_equal(kind, HBIL_MESSAGE_ERROR);
  assert_non_null(strstr(message, "stage"));
  ++*(int *)user;
}

TEST_WITHOUT_KERNELS(a_plan_fails_without_its_context) {
  family f;
  hbil_buffer buffer;
  int count = 0;
  start(&f);
  assert_int_equal(hbil_context_set_callback(f.context, note, &count),
                   HBIL_SUCCESS);
  destroy(&f, PLANS);
  for (int i = 0; i < PLANS; ++i) {
    assert_int_equal(hbil_plan_buffer(f.plans[i], (hbil_stage)99, &buffer),
                     HBIL_INVALID_ARGUMENT);
    assert_int_equal(hbil_plan_buffer(f.plans[i], HBIL_STAGE_SPLIT, &buffer),
                     HBIL_SUCCESS);
    destroy(&f, i);
  }
  assert_int_equal(count, PLANS);
  assert_int_equal(shim_references(), f.before);
}

/* Frames without a context, and the plan and the queue go while they are under
 * way. */
TEST(frames_outlive_context_and_plan) {
  const long before = shim_references();
  cl_command_queue_properties kinds = 0;
  /* rusticl 22.3 has no out-of-order queues */
  clGetDeviceInfo(shared_device.id, CL_DEVICE_QUEUE_PROPERTIES, sizeof kinds,
                  &kinds, NULL);
  const int last = kinds & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE ? 1 : 0;
  for (int out_of_order = 0; out_of_order <= last; ++out_of_order) {
    setup s;
    cl_int error;
    cl_event event = NULL;
    device_fixture own = shared_device;
    setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 1, WIDTH, HEIGHT);
    s.device = &own;
    assert_int_equal(hbil_context_create(own.context, own.id, &own.hbil),
                     HBIL_SUCCESS);
    setup_start(&s);
    own.queue = clCreateCommandQueue(
        own.context, own.id,
        out_of_order ? CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE : 0, &error);
    assert_int_equal(error, CL_SUCCESS);
    hbil_context_destroy(own.hbil);
    for (int i = 0; i < 3; ++i)
      assert_int_equal(hbil_enqueue_frame(s.plan, own.queue, &s.frame, 0, NULL,
                                          i < 2 ? NULL : &event),
                       HBIL_SUCCESS);
    clReleaseCommandQueue(own.queue);
    hbil_plan_destroy(s.plan);
    s.plan = NULL;
    assert_int_equal(clWaitForEvents(1, &event), CL_SUCCESS);
    clReleaseEvent(event);
    setup_free(&s);
    assert_int_equal(shim_references(), before);
  }
}

/* ------------------------------------------------------------------------ */
/* Processes                                                                 */

/* A child that leaves the parent's objects alone, at every moment between two
 * frames. */
TEST(frames_are_not_disturbed_by_children) {
  exact_planes out[2];
  for (int forks = 0; forks < 2; ++forks) {
    setup s;
    setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 1, WIDTH, HEIGHT);
    setup_start(&s);
    for (int i = 0; i < 3; ++i) {
      const pid_t child = forks ? fork() : 0;
      if (forks && child == 0) {
        hbil_config config;
        hbil_config_init(&config);
        _exit(hbil_status_string(HBIL_SUCCESS)[0] == '\0');
      }
      setup_run(&s, hbil_enqueue_frame);
      int status = 0;
      if (forks)
        assert_int_equal(waitpid(child, &status, 0), child);
      assert_int_equal(status, 0);
    }
    out[forks] = outputs_read(&s);
    setup_free(&s);
  }
  assert_int_equal(count_different(&out[0], &out[1]), 0);
  planes_free(&out[0], &out[1]);
}

/* The status of a child that was there before OpenCL was called, and had a
 * context and plans of its own. */
static int first_child;
TEST(early_children_have_contexts_of_their_own) {
  assert_true(WIFEXITED(first_child));
  assert_int_equal(WEXITSTATUS(first_child), 0);
}

int main(int argc, char **argv) {
  const pid_t child = fork();
  if (child == 0) { /* its results are no results of this process */
    if (!freopen("/dev/null", "w", stdout))
      return 1;
    cmocka_set_test_filter("any_order_is_safe");
    return run_with_device();
  }
  waitpid(child, &first_child, 0);
  if (argc > 1) /* names of tests to leave out, as a pattern */
    cmocka_set_skip_filter(argv[1]);
  return run_with_device();
}
