/*
 * Whole frames: sequences match the exact passes, and give the same bits
 * whichever way they are enqueued; events, wait lists, resets and timings do
 * what hbil.h says.
 */
#include "test/support/stages.h"

#include <pthread.h>

static void check_sequence(setup *s, scene_kind kind, int frames) {
  exact_state reference;
  checked_state(&reference, (int)s->config.width, (int)s->config.height);
  setup_all_outputs(s);
  setup_start(s);
  for (int i = 0; i < frames; ++i) {
    setup_load_scene(s, kind, (uint32_t)i);
    s->frame.frame_index = (cl_uint)i;
    setup_upload(s);
    setup_run(s, hbil_enqueue_frame);
    checked_run_frame(&reference, &s->job);
    check_frame_outputs(s, &reference.out);
  }
  exact_state_free(&reference);
  setup_free(s);
}

static void even_sky(setup *s) {
  s->config.model.far_field = HBIL_FAR_CONSTANT;
  for (int c = 0; c < 3; ++c)
    s->frame.environment[0][c] = 0.5f + (float)c;
}

TEST(sequences_that_follow_the_camera_match) {
  setup s;
  setup_scene(&s, SCENE_ROOM, 160, 90, 0);
  check_sequence(&s, SCENE_ROOM, 4);
  setup_scene(&s, SCENE_SKY, 17, 31, 0);
  even_sky(&s);
  check_sequence(&s, SCENE_SKY, 4);
}

TEST(sequences_that_follow_motion_match) {
  setup s;
  setup_scene(&s, SCENE_ROOM, 160, 90, 0);
  s.config.history.reprojection = HBIL_REPROJECTION_MOTION;
  s.config.model.feedback = HBIL_FEEDBACK_RADIANCE;
  check_sequence(&s, SCENE_ROOM, 4);
  setup_scene(&s, SCENE_SKY, 17, 31, 0);
  s.config.history.reprojection = HBIL_REPROJECTION_MOTION;
  even_sky(&s);
  check_sequence(&s, SCENE_SKY, 4);
}

/* ------------------------------------------------------------------------ */
/* The same bits whichever way it is enqueued                                */

#define WIDTH 64
#define HEIGHT 37

static void start_small(setup *s, device_fixture *d) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s->device = d;
  setup_all_outputs(s);
  s->config.model.far_field = HBIL_FAR_SH;
  s->frame.environment[0][1] = 1.0f;
  setup_start(s);
}

/* The last of three frames of a scene, whose depths and normals have the signs
 * of OpenGL's view space or not. */
static exact_planes last_of_three(bool signs, bool by_motion, bool rebuilt) {
  setup s;
  setup_scene(&s, SCENE_SKY, WIDTH, HEIGHT, 0);
  setup_all_outputs(&s);
  if (by_motion)
    s.config.history.reprojection = HBIL_REPROJECTION_MOTION;
  if (rebuilt)
    s.config.inputs.normal.component = HBIL_NONE;
  s.config.inputs.normal_space = HBIL_SPACE_VIEW;
  if (signs)
    s.config.inputs.depth_scale = s.config.inputs.normal_scale[1] =
        s.config.inputs.normal_scale[2] = -1.0f;
  setup_start(&s);
  for (cl_uint i = 0; i < 3; ++i) {
    setup_load_scene(&s, SCENE_SKY, i);
    for (int p = 0; signs && p < WIDTH * HEIGHT; ++p) {
      s.input[EXACT_DEPTH][p] *= -1.0f;
      s.input[EXACT_NORMAL + 1][p] *= -1.0f;
      s.input[EXACT_NORMAL + 2][p] *= -1.0f;
    }
    setup_upload(&s);
    setup_run(&s, hbil_enqueue_frame);
  }
  return last_outputs(&s);
}

TEST(signs_of_other_view_spaces_make_no_difference) {
  for (int i = 0; i < 3; ++i) {
    exact_planes want = last_of_three(false, i == 1, i == 2);
    exact_planes got = last_of_three(true, i == 1, i == 2);
    assert_int_equal(count_different(&got, &want), 0);
    planes_free(&got, &want);
  }
}

static void frame_at_once(setup *s) {
  setup_run(s, hbil_enqueue_frame);
}

static void frame_out_of_order(setup *s) {
  cl_int error;
  cl_event event = NULL;
  cl_command_queue queue =
      clCreateCommandQueue(s->device->context, s->device->id,
                           CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &error);
  assert_int_equal(error, CL_SUCCESS);
  assert_success(
      s, hbil_enqueue_frame(s->plan, queue, &s->frame, 0, NULL, &event));
  assert_int_equal(clWaitForEvents(1, &event), CL_SUCCESS);
  clReleaseEvent(event);
  clReleaseCommandQueue(queue);
}

/* Outputs of the third frame. */
static exact_planes third_frame(device_fixture *d, void (*enqueue)(setup *)) {
  setup s;
  start_small(&s, d);
  for (uint32_t i = 0; i < 3; ++i) {
    setup_load_scene(&s, SCENE_ROOM, i);
    setup_upload(&s);
    enqueue(&s);
  }
  return last_outputs(&s);
}

TEST(an_out_of_order_queue_gives_the_same_bits) {
  exact_planes want = third_frame(&shared_device, frame_at_once);
  exact_planes got = third_frame(&shared_device, frame_out_of_order);
  assert_int_equal(count_different(&got, &want), 0);
  planes_free(&want, &got);
}

/* A thread's own context, plan and queue. */
static void *third_frame_alone(void *out) {
  device_fixture own = device_open();
  *(exact_planes *)out = third_frame(&own, frame_at_once);
  device_close(&own);
  return NULL;
}

TEST(two_threads_at_once_do_not_disturb_each_other) {
  exact_planes want = third_frame(&shared_device, frame_at_once);
  for (int round = 0; round < 4; ++round) {
    pthread_t thread[2];
    exact_planes got[2];
    for (int i = 0; i < 2; ++i)
      assert_int_equal(
          pthread_create(&thread[i], NULL, third_frame_alone, &got[i]), 0);
    for (int i = 0; i < 2; ++i) {
      assert_int_equal(pthread_join(thread[i], NULL), 0);
      assert_int_equal(count_different(&got[i], &want), 0);
      exact_planes_free(&got[i]);
    }
  }
  exact_planes_free(&want);
}

/* ------------------------------------------------------------------------ */
/* Events                                                                    */

static cl_int status_of(cl_event event) {
  cl_int status = CL_COMPLETE;
  assert_int_equal(clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS,
                                  sizeof(status), &status, NULL),
                   CL_SUCCESS);
  return status;
}

/* A pass that waits for a user event does not end before it. */
static void check_waits(setup *s, enqueue_function *pass) {
  cl_int error;
  cl_event gate = clCreateUserEvent(s->device->context, &error), done = NULL;
  assert_int_equal(error, CL_SUCCESS);
  assert_success(s,
                 pass(s->plan, s->device->queue, &s->frame, 1, &gate, &done));
  assert_int_equal(clFlush(s->device->queue), CL_SUCCESS);
  assert_int_not_equal(status_of(done), CL_COMPLETE);
  assert_int_equal(clSetUserEventStatus(gate, CL_COMPLETE), CL_SUCCESS);
  assert_int_equal(clWaitForEvents(1, &done), CL_SUCCESS);
  assert_int_equal(status_of(done), CL_COMPLETE);
  clReleaseEvent(gate);
  clReleaseEvent(done);
}

TEST(wait_lists_are_honoured) {
  setup s;
  start_small(&s, &shared_device);
  for (int round = 0; round < 2; ++round) { /* without and with a history */
    for (int i = 0; i < PASSES; ++i)
      check_waits(&s, passes[i]);
    check_waits(&s, hbil_enqueue_frame);
  }
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Histories                                                                 */

TEST(a_reset_plan_begins_anew) {
  setup s;
  exact_planes first, again, second;
  start_small(&s, &shared_device);
  first = frame_outputs(&s);
  second = frame_outputs(&s);
  hbil_plan_reset(s.plan);
  again = frame_outputs(&s);
  assert_int_equal(count_different(&again, &first), 0);
  assert_true(count_different(&second, &first) > 0); /* another bounce */
  planes_free(&first, &second, &again);
  setup_free(&s);
}

static void copy_stage(setup *from, setup *to, hbil_stage stage) {
  hbil_buffer a, b;
  size_t size;
  assert_success(from, hbil_plan_buffer(from->plan, stage, &a));
  assert_success(to, hbil_plan_buffer(to->plan, stage, &b));
  unsigned char *bytes = buffer_bytes(from->device, a.buffer, &size);
  buffer_write(to->device, b.buffer, 0, size, bytes);
  free(bytes);
}

/* Runs two frames, the second one twice if `still` (then it has three bounces,
 * and searched all slices), and gives the end to another plan.  Both then have
 * the same third frame. */
static void adopt_history(setup s[2], bool still) {
  for (int i = 0; i < 2; ++i) {
    setup_every_pass(&s[i], HBIL_REPROJECTION_CAMERA, 0, 64, 48);
    s[i].config.sampling.slices = s[i].config.sampling.slice_frames = 2;
    setup_start(&s[i]);
  }
  for (uint32_t frame = 0; frame < 2; ++frame) {
    setup_load_scene(&s[0], SCENE_ROOM, frame);
    s[0].frame.frame_index = frame;
    setup_upload(&s[0]);
    assert_int_equal(setup_bounces(&s[0]), frame);
    setup_run(&s[0], hbil_enqueue_frame);
  }
  s[0].frame.static_frame = CL_TRUE;
  if (still)
    setup_run(&s[0], hbil_enqueue_frame);
  s[0].frame.static_frame = CL_FALSE;
  hbil_last_frame last;
  assert_success(&s[0], hbil_plan_last_frame(s[0].plan, &last));
  assert_memory_equal(&last.camera, &s[0].frame.camera, sizeof last.camera);
  assert_int_equal(last.has_slices, still ? CL_FALSE : CL_TRUE);
  assert_int_equal(last.has_probes, CL_FALSE);
  copy_stage(&s[0], &s[1], HBIL_STAGE_HISTORY);
  copy_stage(&s[0], &s[1], HBIL_STAGE_SLICES);
  assert_success(&s[1], hbil_plan_adopt_history(s[1].plan, &last));
  for (int i = 0; i < 2; ++i) {
    setup_load_scene(&s[i], SCENE_ROOM, 2);
    s[i].frame.frame_index = 2;
    setup_upload(&s[i]);
    setup_run(&s[i], hbil_enqueue_frame);
  }
}

TEST(another_plan_adopts_a_history) {
  for (int still = 0; still < 2; ++still) {
    setup s[2];
    adopt_history(s, still);
    exact_planes want = outputs_read(&s[0]), got = outputs_read(&s[1]);
    assert_int_equal(count_different(&got, &want), 0);
    assert_int_equal(setup_bounces(&s[1]), still ? 4 : 3);
    planes_free(&want, &got);
    for (int i = 0; i < 2; ++i)
      setup_free(&s[i]);
  }
}

TEST(a_history_is_checked) {
  setup s;
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, 8, 8);
  setup_start(&s);
  hbil_last_frame none = {.bounces = 1};
  assert_int_equal(hbil_plan_adopt_history(NULL, &none), HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_adopt_history(s.plan, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_adopt_history(s.plan, &none), HBIL_INVALID_FRAME);
  assert_int_equal(setup_bounces(&s), 0);
  assert_success(&s, hbil_plan_last_frame(s.plan, &none)); /* no frame yet */
  assert_success(&s, hbil_plan_adopt_history(s.plan, &none));
  assert_int_equal(setup_bounces(&s), 0);
  assert_int_equal(hbil_plan_last_frame(NULL, &none), HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_last_frame(s.plan, NULL), HBIL_INVALID_ARGUMENT);
  setup_free(&s);
}

TEST(timings_are_told_pass_by_pass) {
  setup s;
  device_fixture profiled = shared_device;
  double ms[HBIL_PASS_COUNT];
  cl_int error;
  profiled.queue = clCreateCommandQueue(shared_device.context, shared_device.id,
                                        CL_QUEUE_PROFILING_ENABLE, &error);
  assert_int_equal(error, CL_SUCCESS);
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.device = &profiled;
  s.config.execution.profiling = CL_TRUE;
  setup_all_outputs(&s);
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  assert_success(&s, hbil_plan_timings(s.plan, ms));
  assert_true(ms[HBIL_PASS_REPROJECT] == 0.0 && ms[HBIL_PASS_PUSH_PULL] == 0.0);
  setup_run(&s, hbil_enqueue_frame);
  assert_success(&s, hbil_plan_timings(s.plan, ms));
  /* all planes are buffers */
  for (int i = 0; i < HBIL_PASS_COUNT; ++i)
    assert_true(i > HBIL_PASS_COMPOSITE ? ms[i] == 0.0
                                        : ms[i] > 0.0 && ms[i] < 1e5);
  setup_free(&s);
  clReleaseCommandQueue(profiled.queue);
}
