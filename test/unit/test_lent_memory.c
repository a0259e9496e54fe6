/*
 * Scratch memory of the caller's: plans that live in it, alone or several in
 * one buffer, make the same bytes as plans of their own, whatever others write
 * there between two frames.
 */
#include "test/support/fixture.h"
#include "test/support/shim.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 131, HEIGHT = 67, FRAMES = 4 };

static hbil_memory memory_of(const setup *s) {
  hbil_memory memory;
  assert_success(s, hbil_plan_memory(s->device->hbil, &s->config, &memory));
  return memory;
}

static cl_mem make_scratch(const setup *s, cl_mem_flags flags, size_t bytes) {
  cl_int error;
  cl_mem buffer =
      clCreateBuffer(s->device->context, flags, bytes, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  return buffer;
}

/* Overwrites the whole buffer, as another pass of the engine would. */
static void spoil(const setup *s, cl_mem scratch, size_t bytes) {
  const cl_uint not_a_number = 0xffffffffu;
  assert_int_equal(clEnqueueFillBuffer(s->device->queue, scratch, &not_a_number,
                                       sizeof not_a_number, 0, bytes / 4 * 4, 0,
                                       NULL, NULL),
                   CL_SUCCESS);
}

/* Runs a frame with `plan` instead of the setup's. */
static exact_planes outputs_of(setup *s, hbil_plan *plan, cl_uint index) {
  hbil_plan *const own = s->plan;
  s->plan = plan;
  s->frame.frame_index = index;
  exact_planes planes = frame_outputs(s);
  s->plan = own;
  return planes;
}

static void check_same(const exact_planes *got, const exact_planes *want) {
  const size_t bytes = sizeof(double) * (size_t)want->width *
                       (size_t)want->height * EXACT_OUTPUT_PLANES;
  assert_memory_equal(got->values, want->values, bytes);
}

/* Frames of a walk, by a plan of its own and by one in lent memory, which is
 * overwritten before each frame. */
static void compare_plans(setup *s, size_t before, bool in_sub_buffer) {
  const hbil_memory memory = memory_of(s);
  const size_t bytes = before + memory.scratch;
  hbil_plan *lent;
  setup_start(s);
  cl_mem whole = make_scratch(s, CL_MEM_READ_WRITE, bytes), scratch = whole;
  if (in_sub_buffer) {
    cl_int error;
    const cl_buffer_region part = {before, memory.scratch};
    scratch = clCreateSubBuffer(whole, CL_MEM_READ_WRITE,
                                CL_BUFFER_CREATE_TYPE_REGION, &part, &error);
    assert_int_equal(error, CL_SUCCESS);
  }
  shim_start_counting();
  assert_success(
      s, hbil_plan_create_in(s->device->hbil, &s->config, scratch, &lent));
  assert_int_equal(shim_created().bytes, memory.persistent);
  for (cl_uint i = 0; i < FRAMES; ++i) {
    setup_load_scene(s, SCENE_ROOM, i);
    setup_upload(s);
    exact_planes want = outputs_of(s, s->plan, i);
    spoil(s, whole, bytes);
    exact_planes got = outputs_of(s, lent, i);
    check_same(&got, &want);
    planes_free(&want, &got);
  }
  if (scratch != whole)
    clReleaseMemObject(scratch);
  clReleaseMemObject(whole); /* the plan has its own references */
  hbil_plan_destroy(lent);
}

TEST(overwritten_memory_changes_nothing) {
  static const hbil_reprojection reprojections[] = {HBIL_REPROJECTION_CAMERA,
                                                    HBIL_REPROJECTION_MOTION,
                                                    HBIL_REPROJECTION_NONE};
  for (size_t i = 0; i < sizeof reprojections / sizeof *reprojections; ++i)
    for (cl_uint vector = 0; vector < 2; ++vector) { /* 0: the device's own */
      setup s;
      setup_every_pass(&s, reprojections[i], vector, WIDTH, HEIGHT);
      s.config.sampling.slices = s.config.sampling.slice_frames = i ? 2 : 1;
      if (i)
        s.config.model.radius = 2.0f; /* ao has its own search */
      compare_plans(&s, 0, false);
      setup_free(&s);
    }
}

TEST(floats_live_there_as_well) {
  setup s;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  setup_all_outputs(&s);
  s.config.sampling.slices = 1; /* the gather stores weights */
  compare_plans(&s, 0, false);
  setup_free(&s);
}

TEST(normals_from_depth_live_there) {
  setup s;
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, WIDTH, HEIGHT);
  s.config.inputs.normal.component = HBIL_NONE;
  compare_plans(&s, 0, false);
  setup_free(&s);
}

TEST(a_sub_buffer_will_do) {
  setup s;
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, WIDTH, HEIGHT);
  compare_plans(&s, 1 << 16, true);
  setup_free(&s);
}

/* Two sizes in turn, each frame over the other plan's remains. */
TEST(plans_share_one_buffer) {
  setup s[2];
  hbil_plan *lent[2];
  size_t bytes = 0;
  for (int i = 0; i < 2; ++i) {
    setup_every_pass(&s[i], HBIL_REPROJECTION_CAMERA, 0, WIDTH << i,
                     HEIGHT + 20 * i);
    setup_start(&s[i]);
    if (memory_of(&s[i]).scratch > bytes)
      bytes = memory_of(&s[i]).scratch;
  }
  cl_mem scratch = make_scratch(&s[0], CL_MEM_READ_WRITE, bytes);
  for (int i = 0; i < 2; ++i)
    assert_success(&s[i], hbil_plan_create_in(s[i].device->hbil, &s[i].config,
                                              scratch, &lent[i]));
  clReleaseMemObject(scratch);
  for (cl_uint frame = 0; frame < FRAMES; ++frame)
    for (int i = 0; i < 2; ++i) {
      exact_planes want = outputs_of(&s[i], s[i].plan, frame);
      exact_planes got = outputs_of(&s[i], lent[i], frame);
      check_same(&got, &want);
      planes_free(&want, &got);
    }
  for (int i = 0; i < 2; ++i) {
    hbil_plan_destroy(lent[i]);
    setup_free(&s[i]);
  }
}

/* Other passes may be at work there at the time. */
TEST(creating_a_plan_writes_nothing) {
  setup s;
  hbil_plan *plan;
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, WIDTH, HEIGHT);
  s.config.inputs.normal.component = HBIL_NONE;
  const size_t bytes = memory_of(&s).scratch;
  unsigned char *seen = malloc(bytes);
  cl_mem scratch = make_scratch(&s, CL_MEM_READ_WRITE, bytes);
  assert_non_null(seen);
  spoil(&s, scratch, bytes);
  clFinish(s.device->queue);
  assert_success(
      &s, hbil_plan_create_in(s.device->hbil, &s.config, scratch, &plan));
  hbil_plan_destroy(plan);
  assert_int_equal(clEnqueueReadBuffer(s.device->queue, scratch, CL_TRUE, 0,
                                       bytes, seen, 0, NULL, NULL),
                   CL_SUCCESS);
  for (size_t i = 0; i < bytes / 4 * 4; ++i)
    assert_int_equal(seen[i], 0xff);
  clReleaseMemObject(scratch);
  free(seen);
  setup_free(&s);
}

/* A static frame reads what its last one left in scratch memory, which nobody
 * has used since. */
TEST(static_frames_rest_there) {
  setup s;
  hbil_plan *lent;
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, WIDTH, HEIGHT);
  setup_start(&s);
  cl_mem scratch = make_scratch(&s, CL_MEM_READ_WRITE, memory_of(&s).scratch);
  assert_success(
      &s, hbil_plan_create_in(s.device->hbil, &s.config, scratch, &lent));
  for (int i = 0; i < FRAMES; ++i) {
    s.frame.static_frame = i > 0;
    exact_planes want = outputs_of(&s, s.plan, 0);
    exact_planes got = outputs_of(&s, lent, 0);
    check_same(&got, &want);
    planes_free(&want, &got);
  }
  hbil_plan_destroy(lent);
  clReleaseMemObject(scratch);
  setup_free(&s);
}

/* --- what is rejected --- */

static void check_rejected(setup *s, cl_mem scratch, const char *words) {
  hbil_plan *plan = (hbil_plan *)s;
  assert_int_equal(
      hbil_plan_create_in(s->device->hbil, &s->config, scratch, &plan),
      HBIL_INVALID_ARGUMENT);
  assert_null(plan);
  if (!strstr(hbil_context_message(s->device->hbil), words))
    fail_msg("\"%s\" instead of \"%s\"", hbil_context_message(s->device->hbil),
             words);
  if (scratch)
    clReleaseMemObject(scratch);
}

TEST(unfit_memory_is_rejected) {
  setup s;
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, WIDTH, HEIGHT);
  const size_t bytes = memory_of(&s).scratch;
  check_rejected(&s, NULL, "scratch");
  check_rejected(&s, make_scratch(&s, CL_MEM_READ_WRITE, bytes - 1),
                 "hbil_plan_memory() asks for ");
  check_rejected(&s, make_scratch(&s, CL_MEM_READ_ONLY, bytes),
                 "must be CL_MEM_READ_WRITE");
  setup_free(&s);
}

TEST(planes_in_scratch_memory_are_rejected) {
  setup s;
  hbil_plan *lent;
  setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, WIDTH, HEIGHT);
  setup_start(&s);
  const size_t scratch_bytes = memory_of(&s).scratch;
  const size_t plane = sizeof(float) * WIDTH * HEIGHT;
  cl_mem scratch =
      make_scratch(&s, CL_MEM_READ_WRITE, scratch_bytes + 4 * plane);
  assert_success(
      &s, hbil_plan_create_in(s.device->hbil, &s.config, scratch, &lent));
  const hbil_plane depth = s.frame.depth;
  s.frame.depth.buffer = scratch;
  s.frame.depth.offset = 0;
  assert_int_equal(
      hbil_enqueue_frame(lent, s.device->queue, &s.frame, 0, NULL, NULL),
      HBIL_INVALID_FRAME);
  assert_non_null(strstr(hbil_context_message(s.device->hbil),
                         "depth: lies in the plan's scratch memory"));
  s.frame.depth.offset = (scratch_bytes + 3) / 4 * 4; /* just behind it */
  assert_success(
      &s, hbil_enqueue_frame(lent, s.device->queue, &s.frame, 0, NULL, NULL));
  clFinish(s.device->queue);
  s.frame.depth = depth;
  hbil_plan_destroy(lent);
  clReleaseMemObject(scratch);
  setup_free(&s);
}
