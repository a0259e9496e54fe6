/*
 * Each OpenCL call of the library fails in turn. The status and the message
 * are right, no object leaks, and contexts, plans and frames work afterwards
 * as if nothing had happened.
 */
#define _POSIX_C_SOURCE 200809L /* mkdtemp, setenv */
#include "test/support/fault.h"

#include <stdio.h>
#include <unistd.h>

/* Small: the number of calls decides how long this takes. Two rows of spans. */
#define WIDTH 40
#define HEIGHT 24

/* ------------------------------------------------------------------------ */
/* Creating and destroying                                                   */

static hbil_status make_context(void) {
  hbil_context *context = NULL;
  const hbil_status status =
      hbil_context_create(shared_device.context, shared_device.id, &context);
  assert_int_equal(context != NULL, status == HBIL_SUCCESS);
  hbil_context_destroy(context);
  return status;
}

TEST(contexts_leave_nothing) {
  for (int e = 0; e < FAULTS; ++e) {
    const long held = shim_references();
    outcome o = {0, "", HBIL_SUCCESS};
    for (int n = 1; o.failed; ++n) {
      o = ATTEMPT(n, faults[e], make_context());
      check_outcome(NULL, &o, e);
      check_held(&o, held);
    }
    assert_in_range(o.nth, 5, 100);
  }
}

/* Width 1 compiles and loads fastest; with profiling, every command has an
 * event. */
static void prepare(setup *s) {
  setup_every_pass(s, HBIL_REPROJECTION_CAMERA, 1, WIDTH, HEIGHT);
  s->config.model.radius = 2.0f; /* ao has its own search */
  s->config.execution.profiling = CL_TRUE;
}

static hbil_status make_plan(const hbil_config *config) {
  hbil_plan *plan = NULL;
  const hbil_status status =
      hbil_plan_create(shared_device.hbil, config, &plan);
  assert_int_equal(plan != NULL, status == HBIL_SUCCESS);
  hbil_plan_destroy(plan);
  return status;
}

/* The kinds take turns, since each plan loads all programs: with all of them at
 * every call this took a minute, and two under a sanitizer. */
TEST(plans_leave_nothing) {
  setup s;
  prepare(&s);
  const long held = shim_references();
  outcome o = {0, "", HBIL_SUCCESS};
  for (int n = 1; o.failed; ++n) {
    const int e = n % FAULTS;
    o = ATTEMPT(n, faults[e], make_plan(&s.config));
    check_outcome(shared_device.hbil, &o, e);
    check_held(&o, held);
  }
  assert_in_range(o.nth, 40, 1000);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Frames                                                                    */

/* Two plans that run the same frames: one never fails, the other one is made
 * to. */
typedef struct step {
  device_fixture profiled;
  setup plain, faulty;
} step;

static void start_step(step *t) {
  cl_int error;
  t->profiled = shared_device;
  t->profiled.queue =
      clCreateCommandQueue(shared_device.context, shared_device.id,
                           CL_QUEUE_PROFILING_ENABLE, &error);
  assert_int_equal(error, CL_SUCCESS);
  prepare(&t->plain);
  prepare(&t->faulty);
  t->plain.device = t->faulty.device = &t->profiled;
  setup_start(&t->plain);
  setup_start(&t->faulty);
}

static void free_step(step *t) {
  clFinish(t->profiled.queue);
  setup_free(&t->plain);
  setup_free(&t->faulty);
  clReleaseCommandQueue(t->profiled.queue);
}

/* The inputs of a frame, to both. */
static void load(step *t, int index) {
  setup *from = &t->plain, *to = &t->faulty;
  setup_load_scene(from, SCENE_ROOM, (uint32_t)index);
  to->frame.camera = from->frame.camera;
  for (int i = 0; i < EXACT_INPUT_PLANES; ++i)
    memcpy(to->input[i], from->input[i], WIDTH * HEIGHT * sizeof(float));
  setup_upload(from);
  setup_upload(to);
}

static hbil_status frame(setup *s) {
  cl_event event = NULL;
  const hbil_status status =
      hbil_enqueue_frame(s->plan, s->device->queue, &s->frame, 0, NULL, &event);
  assert_int_equal(event != NULL, status == HBIL_SUCCESS);
  if (event)
    clReleaseEvent(event);
  return status;
}

static void check_same(const outcome *o, step *t) {
  exact_planes want = outputs_read(&t->plain), got = outputs_read(&t->faulty);
  if (count_different(&got, &want))
    fail_msg("call %d, %s: other bits than without the failure", o->nth,
             o->failed ? o->failed : "none");
  planes_free(&want, &got);
}

/* After a failed frame, the same frame again gives the light and the history
 * of the plan that never failed. No reference leaks, except that an event may
 * be missing that could not be retained. */
TEST(frames_can_be_repeated) {
  const long before = shim_references();
  bool holes = false;
  long held = 0;
  step t;
  start_step(&t);
  load(&t, 0);
  setup_run(&t.plain, hbil_enqueue_frame);
  setup_run(&t.faulty, hbil_enqueue_frame);
  for (int e = 0; e < MEMORY_FAULTS; ++e) {
    outcome o = {0, "", HBIL_SUCCESS};
    for (int n = 1; o.failed; ++n) {
      hbil_statistics skipped;
      load(&t, n % 2 ? 3 : 0);
      setup_run(&t.plain, hbil_enqueue_frame);
      o = ATTEMPT(n, faults[e], frame(&t.faulty));
      check_outcome(shared_device.hbil, &o, e);
      if (o.status != HBIL_SUCCESS)
        setup_run(&t.faulty, hbil_enqueue_frame);
      check_same(&o, &t);
      held = held ? held : shim_references();
      check_held(&o, held - (o.failed && !strcmp(o.failed, "clRetainEvent")));
      assert_success(&t.plain, hbil_plan_statistics(
                                   t.plain.plan, t.profiled.queue, &skipped));
      holes = holes || !skipped.not_run[HBIL_PASS_PUSH_PULL];
    }
    assert_in_range(o.nth, 200, 5000);
  }
  assert_true(holes);
  free_step(&t);
  assert_int_equal(shim_references(), before);
}

/* Whichever call of a frame failed, destroying the plan releases everything. */
TEST(plans_end_after_failures) {
  const long before = shim_references();
  outcome o = {0, "", HBIL_SUCCESS};
  step t;
  for (int n = 1; o.failed; n += 29) { /* a prime: all kinds of calls */
    start_step(&t);
    load(&t, 0);
    setup_run(&t.faulty, hbil_enqueue_frame);
    o = ATTEMPT(n, CL_OUT_OF_RESOURCES, frame(&t.faulty));
    free_step(&t);
    check_held(&o, before);
  }
}

/* A static frame after a failed one is not a repetition of the failed one, but
 * of the frame before it. */
TEST(static_frames_do_not_stand_on_failures) {
  outcome o = {0, "", HBIL_SUCCESS};
  step t;
  start_step(&t);
  for (int n = 1; o.failed; ++n) {
    load(&t, 0);
    t.plain.frame.static_frame = t.faulty.frame.static_frame =
        o.status != HBIL_SUCCESS;
    setup_run(&t.plain, hbil_enqueue_frame);
    setup_run(&t.faulty, hbil_enqueue_frame);
    check_same(&o, &t);
    load(&t, 3);
    t.plain.frame.static_frame = t.faulty.frame.static_frame = CL_FALSE;
    o = ATTEMPT(n, CL_OUT_OF_RESOURCES, frame(&t.faulty));
    if (o.status == HBIL_SUCCESS)
      setup_run(&t.plain, hbil_enqueue_frame);
  }
  assert_in_range(o.nth, 200, 5000);
  free_step(&t);
}

/* ------------------------------------------------------------------------ */
/* Frames whose planes are images                                            */

static const plane_id shown[] = {PLANE_NEAR, PLANE_AO, PLANE_BEAUTY};
enum { SHOWN = 3, LANES = 4 };

/* Two plans that read the same images: one never fails. */
typedef struct image_step {
  setup s; /* has the inputs' values, and no plan */
  hbil_plan *plain, *faulty;
  hbil_frame frame; /* without outputs */
  cl_mem shown[2][SHOWN];
} image_step;

static cl_mem new_image(void) {
  const cl_image_format format = {CL_RGBA, CL_FLOAT};
  const cl_image_desc desc = {.image_type = CL_MEM_OBJECT_IMAGE2D,
                              .image_width = WIDTH,
                              .image_height = HEIGHT};
  cl_int error;
  const cl_mem image = clCreateImage(shared_device.context, CL_MEM_READ_WRITE,
                                     &format, &desc, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  return image;
}

static const size_t corner[3] = {0, 0, 0}, whole[3] = {WIDTH, HEIGHT, 1};

static void start_images(image_step *t) {
  prepare(&t->s);
  setup_no_outputs(&t->s);
  t->s.config.execution.profiling = CL_FALSE;
  t->s.config.sampling.slices = t->s.config.sampling.slice_frames = 2;
  t->frame = t->s.frame;
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id)
    if (plane_format(&t->s.config, id)->component != HBIL_NONE) {
      *plane_format(&t->s.config, id) = (hbil_plane_format){HBIL_IMAGE, 0};
      plane_slot(&t->frame, id)->buffer = new_image();
    }
  for (int i = 0; i < SHOWN; ++i) {
    *plane_format(&t->s.config, shown[i]) = (hbil_plane_format){HBIL_IMAGE, 0};
    t->shown[0][i] = new_image();
    t->shown[1][i] = new_image();
  }
  assert_success(&t->s,
                 hbil_plan_create(shared_device.hbil, &t->s.config, &t->plain));
  assert_success(
      &t->s, hbil_plan_create(shared_device.hbil, &t->s.config, &t->faulty));
}

static void free_images(image_step *t) {
  hbil_plan_destroy(t->plain);
  hbil_plan_destroy(t->faulty);
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id)
    if (plane_slot(&t->frame, id)->buffer)
      clReleaseMemObject(plane_slot(&t->frame, id)->buffer);
  for (int i = 0; i < 2 * SHOWN; ++i)
    clReleaseMemObject(t->shown[i / SHOWN][i % SHOWN]);
  setup_free(&t->s);
}

static void load_images(image_step *t, int index) {
  static float texels[WIDTH * HEIGHT][LANES];
  setup_load_scene(&t->s, SCENE_ROOM, (uint32_t)index);
  t->frame.camera = t->s.frame.camera;
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id) {
    if (!plane_slot(&t->frame, id)->buffer)
      continue;
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      for (int c = 0; c < plane_channels(id); ++c)
        texels[i][c] = t->s.input[plane_first(id) + c][i];
    assert_int_equal(clEnqueueWriteImage(
                         shared_device.queue, plane_slot(&t->frame, id)->buffer,
                         CL_TRUE, corner, whole, 0, 0, texels, 0, NULL, NULL),
                     CL_SUCCESS);
  }
}

static hbil_status image_frame(image_step *t, bool faulty,
                               enqueue_function *pass) {
  for (int i = 0; i < SHOWN; ++i)
    plane_slot(&t->frame, shown[i])->buffer = t->shown[faulty][i];
  return pass(faulty ? t->faulty : t->plain, shared_device.queue, &t->frame, 0,
              NULL, NULL);
}

static void check_same_images(const outcome *o, const image_step *t) {
  static float texels[2][WIDTH * HEIGHT][LANES];
  for (int i = 0; i < SHOWN; ++i) {
    for (int k = 0; k < 2; ++k)
      assert_int_equal(clEnqueueReadImage(shared_device.queue, t->shown[k][i],
                                          CL_TRUE, corner, whole, 0, 0,
                                          texels[k], 0, NULL, NULL),
                       CL_SUCCESS);
    if (memcmp(texels[0], texels[1], sizeof texels[0]))
      fail_msg("call %d, %s: other bits in %s than without the failure", o->nth,
               o->failed ? o->failed : "none", plane_name(shown[i]));
  }
}

/* Images are written after the pass that writes the history: what was carried
 * over and averaged is still that of the frame before if this fails. */
TEST(frames_of_images_can_be_repeated) {
  const long before = shim_references();
  outcome o = {0, "", HBIL_SUCCESS};
  image_step t;
  start_images(&t);
  for (int n = 1; o.failed; ++n) {
    load_images(&t, n % 2 ? 3 : 0);
    assert_success(&t.s, image_frame(&t, false, hbil_enqueue_frame));
    o = ATTEMPT(n, faults[0], image_frame(&t, true, hbil_enqueue_frame));
    check_outcome(shared_device.hbil, &o, 0);
    if (o.status != HBIL_SUCCESS)
      assert_success(&t.s, image_frame(&t, true, hbil_enqueue_frame));
    check_same_images(&o, &t);
  }
  assert_in_range(o.nth, 150, 5000);
  free_images(&t);
  assert_int_equal(shim_references(), before);
}

/* The same if composite was enqueued by itself, and is enqueued again. */
TEST(composite_to_images_can_be_repeated) {
  outcome o = {0, "", HBIL_SUCCESS};
  image_step t;
  start_images(&t);
  for (int n = 1; o.failed; ++n) {
    load_images(&t, n % 2 ? 3 : 0);
    assert_success(&t.s, image_frame(&t, false, hbil_enqueue_frame));
    for (int i = 0; i < PASSES - 1; ++i)
      assert_success(&t.s, image_frame(&t, true, passes[i]));
    o = ATTEMPT(n, faults[0], image_frame(&t, true, enqueue_composite));
    check_outcome(shared_device.hbil, &o, 0);
    if (o.status != HBIL_SUCCESS)
      assert_success(&t.s, image_frame(&t, true, hbil_enqueue_frame));
    check_same_images(&o, &t);
  }
  assert_in_range(o.nth, 30, 5000);
  free_images(&t);
}

/* ------------------------------------------------------------------------ */
/* What is told afterwards                                                   */

typedef hbil_status question(step *t);

static hbil_status ask_timings(step *t) {
  double ms[HBIL_PASS_COUNT];
  return hbil_plan_timings(t->faulty.plan, ms);
}

static hbil_status ask_skipped(step *t) {
  hbil_statistics skipped;
  return hbil_plan_statistics(t->faulty.plan, t->profiled.queue, &skipped);
}

TEST(questions_can_be_asked_again) {
  static question *const questions[] = {ask_timings, ask_skipped};
  step t;
  start_step(&t);
  setup_run(&t.faulty, hbil_enqueue_frame);
  for (size_t q = 0; q < sizeof questions / sizeof *questions; ++q)
    for (int e = 0; e < FAULTS; ++e) {
      const long held = shim_references();
      outcome o = {0, "", HBIL_SUCCESS};
      for (int n = 1; o.failed; ++n) {
        o = ATTEMPT(n, faults[e], questions[q](&t));
        check_outcome(shared_device.hbil, &o, e);
        check_held(&o, held);
      }
      assert_in_range(o.nth, 3, 500);
    }
  free_step(&t);
}

TEST(lost_events_are_told) {
  outcome o = {0, "", HBIL_SUCCESS};
  step t;
  start_step(&t);
  for (int n = 1; !o.failed || strcmp(o.failed, "clRetainEvent"); ++n)
    o = ATTEMPT(n, CL_OUT_OF_RESOURCES, frame(&t.faulty));
  assert_int_equal(o.status, HBIL_SUCCESS);
  assert_int_equal(ask_timings(&t), HBIL_OUT_OF_DEVICE_MEMORY);
  assert_success(&t.faulty, frame(&t.faulty));
  assert_success(&t.faulty, ask_timings(&t));
  free_step(&t);
}

/* ------------------------------------------------------------------------ */
/* Kernels that don't compile                                                */

static void write_text(const char *folder, const char *name, const char *text) {
  char path[256];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  assert_true(fputs(text, file) >= 0);
  assert_int_equal(fclose(file), 0);
}

static void remove_text(const char *folder, const char *name) {
  char path[256];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  assert_int_equal(remove(path), 0);
}

/* The message has the compiler's log, unless asking for the log fails. */
TEST(a_failed_build_is_told) {
  static const char *const files[] = {"shared.h", "common.clh", "reproject.cl"};
  char folder[] = "hbil-faults.XXXXXX";
  outcome o = {0, "", HBIL_SUCCESS};
  setup s;
  prepare(&s);
  assert_non_null(mkdtemp(folder));
  for (int i = 0; i < 3; ++i)
    write_text(folder, files[i], i < 2 ? "\n" : "\n#error light is off\n");
  setenv("HBIL_KERNEL_DIR", folder, 1);
  const long held = shim_references();
  for (int n = 1; o.failed; ++n) {
    hbil_plan *plan = NULL;
    o = ATTEMPT(n, CL_INVALID_OPERATION,
                hbil_plan_create(shared_device.hbil, &s.config, &plan));
    const char *message = hbil_context_message(shared_device.hbil);
    assert_null(plan);
    check_held(&o, held);
    if (n <= 3)
      continue; /* clGetDeviceInfo twice, clCreateProgramWithSource */
    assert_int_equal(o.status, HBIL_BUILD_FAILED);
    assert_non_null(strstr(message, "reproject.cl"));
    if (!o.failed) {
      assert_non_null(strstr(message, "CL_BUILD_PROGRAM_FAILURE"));
      assert_non_null(strstr(message, "light is off"));
    }
  }
  unsetenv("HBIL_KERNEL_DIR");
  for (int i = 0; i < 3; ++i)
    remove_text(folder, files[i]);
  assert_int_equal(rmdir(folder), 0);
  setup_free(&s);
}
