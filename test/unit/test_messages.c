/*
 * Every failure leaves a message that names what is wrong: on the context, on
 * the thread where there is none, and at the callback, which gets warnings as
 * well.
 */
#define _POSIX_C_SOURCE 200809L /* mkdtemp, setenv */
#include "hbil/hbil_stages.h"

#include "test/support/fixture.h"
#include "test/support/shim.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <unistd.h>

#define WIDTH 17
#define HEIGHT 9

static void check_message(const hbil_context *context, hbil_status status,
                          const char *function, const char *word) {
  const char *message = hbil_context_message(context);
  assert_int_equal(status, HBIL_INVALID_ARGUMENT);
  if (!strstr(message, function) || !strstr(message, word) ||
      strchr(message, '\n'))
    fail_msg("%s and %s are not both named in the message \"%s\"", function,
             word, message);
}

/* --- null arguments --- */

/* `arguments` are those of a call whose argument `name` is null. */
#define CHECK_NULL(context, function, arguments, name)                         \
  check_message((context), function arguments, #function, name)

TEST(null_arguments_of_a_context) {
  hbil_context *const context = shared_device.hbil;
  hbil_config config;
  hbil_plan *plan = NULL;
  hbil_memory memory;
  hbil_config_init(&config);
  CHECK_NULL(context, hbil_plan_memory, (context, NULL, &memory), "config");
  CHECK_NULL(context, hbil_plan_memory, (context, &config, NULL), "out");
  CHECK_NULL(context, hbil_plan_create, (context, NULL, &plan), "config");
  CHECK_NULL(context, hbil_plan_create, (context, &config, NULL), "out");
}

TEST(null_arguments_of_a_plan) {
  const hbil_context *const context = shared_device.hbil;
  const cl_command_queue queue = shared_device.queue;
  hbil_statistics statistics;
  hbil_sanitized sanitized;
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  setup_start(&s);
  const cl_event event = NULL;
  CHECK_NULL(context, hbil_enqueue_frame,
             (s.plan, NULL, &s.frame, 0, NULL, NULL), "queue");
  CHECK_NULL(context, hbil_enqueue_frame, (s.plan, queue, NULL, 0, NULL, NULL),
             "frame must");
  CHECK_NULL(context, hbil_enqueue_frame,
             (s.plan, queue, &s.frame, 1, NULL, NULL), "wait_list");
  CHECK_NULL(context, hbil_enqueue_passes,
             (s.plan, queue, &s.frame, HBIL_PASS_GATHER, HBIL_PASS_GATHER, 0,
              &event, NULL),
             "wait_list");
  CHECK_NULL(context, hbil_plan_buffer, (s.plan, HBIL_STAGE_SPLIT, NULL),
             "out");
  CHECK_NULL(context, hbil_plan_timings, (s.plan, NULL), "milliseconds");
  CHECK_NULL(context, hbil_plan_statistics, (s.plan, NULL, &statistics),
             "queue");
  CHECK_NULL(context, hbil_plan_statistics, (s.plan, queue, NULL), "out");
  CHECK_NULL(context, hbil_plan_statistics, (s.plan, queue, &statistics),
             "frame");
  CHECK_NULL(context, hbil_plan_sanitized, (s.plan, NULL, &sanitized), "queue");
  CHECK_NULL(context, hbil_plan_sanitized, (s.plan, queue, NULL), "out");
  CHECK_NULL(context, hbil_plan_sanitized, (s.plan, queue, &sanitized),
             "frame");
  setup_free(&s);
}

/* --- without a context --- */

static void *ask_in_a_thread(void *message) {
  const char *found = hbil_context_message(NULL);
  snprintf(message, 8, "%s", found);
  return NULL;
}

TEST(failures_without_a_context) {
  const cl_command_queue queue = shared_device.queue;
  hbil_context *context = NULL;
  hbil_plan *plan = NULL;
  hbil_config config;
  hbil_cache_config cache;
  hbil_view view;
  hbil_frame frame;
  hbil_buffer buffer;
  hbil_statistics statistics;
  hbil_sanitized sanitized;
  double ms[HBIL_PASS_COUNT];
  float sh[9][3];
  const float rgb[6] = {0};
  hbil_memory memory;
  hbil_config_init(&config);
  hbil_frame_init(&frame);
  hbil_cache_config_init(&cache);
  CHECK_NULL(NULL, hbil_context_create, (NULL, shared_device.id, &context),
             "context must");
  CHECK_NULL(NULL, hbil_context_create, (shared_device.context, NULL, &context),
             "device");
  CHECK_NULL(NULL, hbil_context_create,
             (shared_device.context, shared_device.id, NULL), "out");
  CHECK_NULL(NULL, hbil_context_set_callback, (NULL, NULL, NULL), "context");
  CHECK_NULL(NULL, hbil_config_use_cache, (NULL, &cache), "config");
  CHECK_NULL(NULL, hbil_config_use_cache, (&config, NULL), "cache");
  CHECK_NULL(NULL, hbil_view_from_frame_sized,
             (NULL, sizeof(hbil_view), &config, &frame), "view");
  CHECK_NULL(NULL, hbil_view_from_frame_sized,
             (&view, sizeof view, NULL, &frame), "config");
  CHECK_NULL(NULL, hbil_view_from_frame_sized,
             (&view, sizeof view, &config, NULL), "frame");
  CHECK_NULL(NULL, hbil_plan_memory, (NULL, &config, &memory), "context");
  CHECK_NULL(NULL, hbil_plan_create, (NULL, &config, &plan), "context");
  CHECK_NULL(NULL, hbil_enqueue_frame, (NULL, queue, &frame, 0, NULL, NULL),
             "plan");
  CHECK_NULL(
      NULL, hbil_enqueue_passes,
      (NULL, queue, &frame, HBIL_PASS_SPLIT, HBIL_PASS_SPLIT, 0, NULL, NULL),
      "plan");
  CHECK_NULL(NULL, hbil_plan_buffer, (NULL, HBIL_STAGE_SPLIT, &buffer), "plan");
  CHECK_NULL(NULL, hbil_plan_timings, (NULL, ms), "plan");
  CHECK_NULL(NULL, hbil_plan_statistics, (NULL, queue, &statistics), "plan");
  CHECK_NULL(NULL, hbil_plan_sanitized, (NULL, queue, &sanitized), "plan");
  CHECK_NULL(NULL, hbil_model_set, (NULL, HBIL_MODEL_PAPER), "model");
  CHECK_NULL(NULL, hbil_model_set, (&config.model, (hbil_model_name)9), "name");
  CHECK_NULL(NULL, hbil_sampling_set, (NULL, HBIL_QUALITY_FAST), "sampling");
  CHECK_NULL(NULL, hbil_sampling_set, (&config.sampling, (hbil_quality)9),
             "quality");
  CHECK_NULL(NULL, hbil_environment_from_latlong, (NULL, 2, 1, 0, NULL, sh),
             "rgb");
  CHECK_NULL(NULL, hbil_environment_from_latlong, (rgb, 2, 1, 0, NULL, NULL),
             "environment must");
  CHECK_NULL(NULL, hbil_environment_from_latlong, (rgb, 0, 1, 0, NULL, sh),
             "width");
  CHECK_NULL(NULL, hbil_environment_from_latlong, (rgb, 2, 1, 5, NULL, sh),
             "row_pitch");
}

TEST(each_thread_has_its_own) {
  pthread_t thread;
  char there[8] = "unset";
  hbil_context *context = NULL;
  hbil_context_create(NULL, NULL, &context);
  assert_int_equal(pthread_create(&thread, NULL, ask_in_a_thread, there), 0);
  pthread_join(thread, NULL);
  assert_string_equal(there, "");
  assert_string_not_equal(hbil_context_message(NULL), "");
}

TEST(a_context_keeps_its_own) {
  hbil_context *context = NULL;
  hbil_plan *plan = NULL;
  assert_int_equal(
      hbil_context_create(shared_device.context, shared_device.id, &context),
      HBIL_SUCCESS);
  hbil_plan_create(NULL, NULL, &plan);
  assert_string_equal(hbil_context_message(context), "");
  hbil_context_destroy(context);
}

/* --- the callback --- */

enum { MOST_HEARD = 8 };

typedef struct listener {
  int count;
  hbil_message_kind kind[MOST_HEARD];
  char text[MOST_HEARD][512];
} listener;

static void hear(hbil_message_kind kind, const char *message, void *user) {
  listener *l = user;
  assert_in_range(l->count, 0, MOST_HEARD - 1);
  l->kind[l->count] = kind;
  snprintf(l->text[l->count++], sizeof *l->text, "%s", message);
}

static void listen(listener *l) {
  *l = (listener){.count = 0};
  assert_int_equal(hbil_context_set_callback(shared_device.hbil, hear, l),
                   HBIL_SUCCESS);
}

static void stop_listening(void) {
  assert_int_equal(hbil_context_set_callback(shared_device.hbil, NULL, NULL),
                   HBIL_SUCCESS);
}

static void check_heard(const listener *l, int i, hbil_message_kind kind,
                        const char *part) {
  assert_true(i < l->count);
  assert_int_equal(l->kind[i], kind);
  if (!strstr(l->text[i], part))
    fail_msg("message %d: \"%s\"; expected \"%s\"", i, l->text[i], part);
}

TEST(the_callback_gets_errors) {
  hbil_config config;
  hbil_memory memory;
  listener l;
  hbil_config_init(&config);
  listen(&l);
  for (cl_uint i = 0; i < 2; ++i) {
    config.width = i; /* then the height is missing */
    assert_int_equal(hbil_plan_memory(shared_device.hbil, &config, &memory),
                     HBIL_INVALID_CONFIG);
    assert_int_equal(l.count, i + 1);
    check_heard(&l, (int)i, HBIL_MESSAGE_ERROR,
                hbil_context_message(shared_device.hbil));
  }
  stop_listening();
  hbil_plan_memory(shared_device.hbil, &config, &memory);
  assert_int_equal(l.count, 2);
}

/* PoCL's compiler also prints "1 warning generated", for which run.sh would
 * fail the test. */
static int silence_errors(void) {
  const int stderr_copy = dup(STDERR_FILENO);
  const int nowhere = open("/dev/null", O_WRONLY);
  fflush(stderr);
  assert_true(stderr_copy >= 0 && nowhere >= 0);
  assert_true(dup2(nowhere, STDERR_FILENO) >= 0);
  close(nowhere);
  return stderr_copy;
}

static void restore_errors(int stderr_copy) {
  fflush(stderr);
  dup2(stderr_copy, STDERR_FILENO);
  close(stderr_copy);
}

/* A folder with one kernel, at which the compiler has a remark. */
TEST(the_callback_gets_warnings_of_kernels) {
  char folder[] = "hbil-messages.XXXXXX", path[64];
  hbil_plan *plan = NULL;
  listener l;
  setup s;
  skip_unless_pocl(); /* rusticl 22.3 has no log of a build that succeeded */
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 1, WIDTH, HEIGHT);
  assert_non_null(mkdtemp(folder));
  snprintf(path, sizeof path, "%s/reproject.cl", folder);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  assert_true(fputs("#warning light is dim\n", file) >= 0);
  assert_int_equal(fclose(file), 0);
  setenv("HBIL_KERNEL_DIR", folder, 1);
  listen(&l);
  const int errors = silence_errors();
  const hbil_status status =
      hbil_plan_create(shared_device.hbil, &s.config, &plan);
  restore_errors(errors);
  assert_int_equal(status, HBIL_BUILD_FAILED);
  stop_listening();
  unsetenv("HBIL_KERNEL_DIR");
  assert_int_equal(remove(path), 0);
  assert_int_equal(rmdir(folder), 0);
  assert_int_equal(l.count, 3);
  check_heard(&l, 0, HBIL_MESSAGE_WARNING, "HBIL_KERNEL_DIR");
  check_heard(&l, 1, HBIL_MESSAGE_WARNING, "light is dim");
  check_heard(&l, 2, HBIL_MESSAGE_ERROR, "push_pull.cl");
  setup_free(&s);
}

#ifdef HBIL_HAS_SECURE_GETENV
/* In place of the C library's: a program with other rights than its user's has
 * no such variables. */
static bool is_setuid;
char *secure_getenv(const char *name);
char *secure_getenv(const char *name) {
  return is_setuid ? NULL : getenv(name);
}

TEST(setuid_programs_have_their_own_kernels) {
  hbil_plan *plan = NULL;
  listener l;
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  setenv("HBIL_KERNEL_DIR", "/no such folder", 1);
  listen(&l);
  assert_int_equal(hbil_plan_create(shared_device.hbil, &s.config, &plan),
                   HBIL_BUILD_FAILED);
  is_setuid = true;
  const hbil_status status =
      hbil_plan_create(shared_device.hbil, &s.config, &plan);
  is_setuid = false;
  unsetenv("HBIL_KERNEL_DIR");
  stop_listening();
  assert_int_equal(status, HBIL_SUCCESS);
  assert_int_equal(l.count, 2); /* both of the first plan */
  hbil_plan_destroy(plan);
  setup_free(&s);
}
#endif

/* Frames go on without an event that only timings need. */
TEST(the_callback_gets_warnings_of_timings) {
  double ms[HBIL_PASS_COUNT];
  listener l;
  setup s;
  cl_int error;
  setup_init(&s, WIDTH, HEIGHT);
  s.config.execution.profiling = CL_TRUE;
  device_fixture profiled = shared_device;
  profiled.queue = clCreateCommandQueue(profiled.context, profiled.id,
                                        CL_QUEUE_PROFILING_ENABLE, &error);
  assert_int_equal(error, CL_SUCCESS);
  s.device = &profiled;
  setup_start(&s);
  for (int nth = 1;; ++nth) {
    listen(&l);
    shim_fail(nth, CL_OUT_OF_RESOURCES);
    const hbil_status status =
        hbil_enqueue_frame(s.plan, profiled.queue, &s.frame, 0, NULL, NULL);
    const char *failed = shim_failed();
    shim_fail(0, CL_SUCCESS);
    assert_non_null(failed);
    if (strcmp(failed, "clRetainEvent") != 0)
      continue;
    assert_int_equal(status, HBIL_SUCCESS);
    assert_int_equal(l.count, 1);
    check_heard(&l, 0, HBIL_MESSAGE_WARNING, "hbil_plan_timings()");
    break;
  }
  assert_int_equal(hbil_plan_timings(s.plan, ms), HBIL_OUT_OF_DEVICE_MEMORY);
  assert_int_equal(l.count, 2);
  check_heard(&l, 1, HBIL_MESSAGE_ERROR, "clRetainEvent");
  stop_listening();
  /* PoCL must not compile the frame's kernels when the process ends */
  assert_int_equal(clFinish(profiled.queue), CL_SUCCESS);
  setup_free(&s);
  clReleaseCommandQueue(profiled.queue);
}
