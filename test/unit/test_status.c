/*
 * Wrong configurations, frames and arguments are rejected by name, before
 * anything is enqueued.
 */
#include "hbil/hbil_stages.h"

#include "test/support/fixture.h"

#define WIDTH 17
#define HEIGHT 9

static void start(setup *s) {
  setup_init(s, WIDTH, HEIGHT);
  setup_all_outputs(s);
  s->config.outputs.glossy = three_floats;
  setup_start(s);
}

TEST(every_status_has_its_own_sentence) {
  for (int i = HBIL_SUCCESS; i <= HBIL_OPENCL_ERROR; ++i) {
    assert_non_null(hbil_status_string((hbil_status)i));
    assert_true(strlen(hbil_status_string((hbil_status)i)) > 3);
    for (int j = HBIL_SUCCESS; j < i; ++j)
      assert_string_not_equal(hbil_status_string((hbil_status)i),
                              hbil_status_string((hbil_status)j));
  }
  assert_non_null(hbil_status_string((hbil_status)12345));
}

TEST(every_pass_has_a_name) {
  assert_string_equal(hbil_pass_name(HBIL_PASS_REPROJECT), "reproject");
  assert_string_equal(hbil_pass_name(HBIL_PASS_PUSH_PULL), "push_pull");
  assert_string_equal(hbil_pass_name(HBIL_PASS_SPLIT), "split");
  assert_string_equal(hbil_pass_name(HBIL_PASS_GATHER), "gather");
  assert_string_equal(hbil_pass_name(HBIL_PASS_RECOMPOSE), "recompose");
  assert_string_equal(hbil_pass_name(HBIL_PASS_COMPOSITE), "composite");
  assert_null(hbil_pass_name(HBIL_PASS_COUNT));
}

TEST(version_is_the_headers) {
  assert_string_equal(hbil_version(), "0.1.0");
}

TEST(defaults_are_those_of_the_header) {
  hbil_config c;
  memset(&c, 0x5a, sizeof(c));
  hbil_config_init(&c);
  assert_int_equal(c.struct_size, sizeof(c));
  assert_true(c.width == 0 && c.height == 0);
  assert_true(c.inputs.depth.component == HBIL_NONE);
  assert_true(isinf(c.inputs.sky_depth) && isinf(c.model.radius));
  assert_true(isinf(c.model.ao_radius) &&
              isinf(c.model.near_relative_thickness));
  assert_true(c.inputs.direct_scale == 1.0f);
  assert_true(c.sampling.slices == 4 && c.sampling.steps_per_side == 40 &&
              c.sampling.step_growth == 3.0f && c.sampling.slice_frames == 0);
  assert_true(c.sampling.sample_grid == HBIL_GRID_FULL_RESOLUTION);
  assert_true(c.sampling.resolution == HBIL_RESOLUTION_AUTO);
  assert_true(isinf(c.model.thickness) && c.model.relative_thickness == 0.06f);
  assert_true(c.model.facing_fade[0] == -1.0f &&
              c.model.facing_fade[1] == -1.0f);
  assert_true(c.model.back_facing_fallback == HBIL_FALLBACK_FRAME_MEAN);
  assert_true(c.model.gather_emission == CL_TRUE &&
              c.model.extrapolate == CL_TRUE);
  assert_true(c.history.reprojection == HBIL_REPROJECTION_CAMERA);
  assert_true(c.model.feedback == HBIL_FEEDBACK_IRRADIANCE);
  assert_true(c.history.disocclusion_threshold == 0.05f);
  assert_true(c.model.far_field == HBIL_FAR_AUTO);
  assert_true(c.inputs.depth_scale == 1.0f && c.inputs.normal_scale[0] == 1.0f);
  assert_true(c.inputs.normal_scale[1] == 1.0f &&
              c.inputs.normal_scale[2] == 1.0f);
  assert_true(!c.sampling.unfiltered && c.execution.vector_width == 0 &&
              !c.execution.profiling);
  assert_true(c.sampling.storage == HBIL_STORAGE_PACKED);
}

TEST(models_set_what_the_header_says) {
  hbil_config paper, again;
  hbil_config_init(&paper);
  hbil_config_init(&again);
  assert_int_equal(hbil_model_set(&paper.model, HBIL_MODEL_PAPER),
                   HBIL_SUCCESS);
  assert_true(isinf(paper.model.thickness) &&
              isinf(paper.model.relative_thickness));
  assert_true(paper.model.facing_fade[0] == -0.1f &&
              paper.model.facing_fade[1] == 0.0f);
  assert_true(paper.model.back_facing_fallback == HBIL_FALLBACK_LAST_ACCEPTED);
  assert_true(paper.model.feedback == HBIL_FEEDBACK_RADIANCE &&
              !paper.model.extrapolate);
  /* the default takes all of it back */
  assert_int_equal(hbil_model_set(&paper.model, HBIL_MODEL_DEFAULT),
                   HBIL_SUCCESS);
  assert_memory_equal(&paper, &again, sizeof paper);
  assert_int_equal(hbil_model_set(NULL, HBIL_MODEL_PAPER),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_model_set(&paper.model, (hbil_model_name)3),
                   HBIL_INVALID_ARGUMENT);
}

/* ------------------------------------------------------------------------ */
/* Configurations                                                            */

static const char *spoil_config(hbil_config *c, int which) {
  SPOIL("width", c->width = 0);
  SPOIL("width", c->width = 16385);
  SPOIL("height", c->height = 0);
  SPOIL("slices", c->sampling.slices = 0);
  SPOIL("slices", c->sampling.slices = 33);
  SPOIL("steps_per_side", c->sampling.steps_per_side = 0);
  SPOIL("steps_per_side", c->sampling.steps_per_side = 257);
  SPOIL("radius", c->model.radius = NAN);
  SPOIL("radius", c->model.radius = 0.0f);
  SPOIL("radius", c->model.radius = -1.0f);
  SPOIL("ao_radius", c->model.ao_radius = NAN);
  SPOIL("ao_radius", c->model.ao_radius = 0.0f);
  SPOIL("near_relative_thickness", c->model.near_relative_thickness = NAN);
  SPOIL("near_relative_thickness", c->model.near_relative_thickness = -1.0f);
  SPOIL("thickness", c->model.thickness = -0.1f);
  SPOIL("thickness", c->model.thickness = NAN);
  SPOIL("relative_thickness", c->model.relative_thickness = 0.0f);
  SPOIL("relative_thickness", c->model.relative_thickness = NAN);
  SPOIL("mode", c->model.mode = (hbil_mode)3);
  SPOIL("falloff", c->model.falloff = (hbil_falloff)3);
  SPOIL("facing_fade",
        (c->model.facing_fade[0] = 0.5f, c->model.facing_fade[1] = 0.25f));
  SPOIL("facing_fade", c->model.facing_fade[1] = NAN);
  SPOIL("facing_fade", c->model.facing_fade[1] = 2.0f);
  SPOIL("step_growth", c->sampling.step_growth = NAN);
  SPOIL("step_growth", c->sampling.step_growth = -0.5f);
  SPOIL("step_growth", c->sampling.step_growth = 65.0f);
  SPOIL("extrapolate", c->model.extrapolate = 2);
  SPOIL("roughness", c->model.roughness = 0.299f);
  SPOIL("roughness", c->model.roughness = 1.01f);
  SPOIL("roughness", c->model.roughness = NAN);
  SPOIL("glossy", (c->outputs.glossy = c->outputs.beauty,
                   c->model.cache_method = HBIL_CACHE_METHOD_LPV));
  SPOIL("glossy", (c->outputs.glossy = c->outputs.beauty,
                   c->outputs.near_irradiance.component = HBIL_NONE,
                   c->outputs.unknown.component = HBIL_NONE,
                   c->model.mode = HBIL_MODE_GTAO));
  SPOIL("cache_method", c->model.cache_method = (hbil_cache_method)5);
  SPOIL("ao_bounces", c->model.ao_bounces = (hbil_ao_bounces)3);
  SPOIL("disocclusion_threshold", c->history.disocclusion_threshold = 0.0f);
  SPOIL("disocclusion_threshold", c->history.disocclusion_threshold = NAN);
  SPOIL("depth", c->inputs.depth.component = HBIL_NONE);
  SPOIL("normal", (c->inputs.normal.component = HBIL_NONE,
                   c->inputs.depth.component = HBIL_FLOAT16));
  SPOIL("albedo", c->inputs.albedo.pixel_pitch = 8);
  SPOIL("albedo", c->inputs.albedo.pixel_pitch = 13);
  SPOIL("depth.pixel_pitch: 6 bytes; must be 4 .. 256, a multiple of 4",
        c->inputs.depth.pixel_pitch = 6);
  SPOIL("direct", c->inputs.direct.component = (hbil_component)99);
  SPOIL("ao", c->outputs.ao.component = HBIL_UNORM8);
  SPOIL("motion", (c->history.reprojection = HBIL_REPROJECTION_MOTION,
                   c->inputs.motion.component = HBIL_NONE));
  SPOIL("sampling.resolution", c->sampling.resolution = (hbil_resolution)3);
  SPOIL("sampling.resolution", (c->sampling.resolution = HBIL_RESOLUTION_HALF,
                                c->sampling.unfiltered = CL_TRUE));
  SPOIL("sample_grid", c->sampling.sample_grid = (hbil_sample_grid)7);
  SPOIL("back_facing_fallback",
        c->model.back_facing_fallback = (hbil_back_facing_fallback)7);
  SPOIL("model.far_field: 7; must be one of hbil_far_field",
        c->model.far_field = (hbil_far_field)7);
  SPOIL("feedback", c->model.feedback = (hbil_feedback)7);
  SPOIL("sampling.storage: -1; must be one of hbil_storage",
        c->sampling.storage = (hbil_storage)-1);
  SPOIL("storage", c->sampling.storage = (hbil_storage)4);
  SPOIL("vector_width", c->execution.vector_width = 3);
  SPOIL("depth_scale", c->inputs.depth_scale = 0.0f);
  SPOIL("depth_scale", c->inputs.depth_scale = NAN);
  SPOIL("normal_scale[1]", c->inputs.normal_scale[1] = 0.0f);
  SPOIL("normal_scale[2]", c->inputs.normal_scale[2] = -INFINITY);
  SPOIL("struct_size", c->struct_size -= 8);
  SPOIL("struct_size", c->struct_size += 8);
  return NULL;
}

static void assert_rejected(hbil_status got, hbil_status want,
                            const char *field) {
  const char *message = hbil_context_message(shared_device.hbil);
  if (got != want)
    fail_msg("%s: status %d, expected %d", field, (int)got, (int)want);
  if (!strstr(message, field))
    fail_msg("%s is not named in the message \"%s\"", field, message);
}

TEST(bad_configurations_are_rejected_by_name) {
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  setup_all_outputs(&s);
  for (int i = 0;; ++i) {
    hbil_config c = s.config;
    hbil_plan *plan = (hbil_plan *)&c;
    hbil_memory memory;
    const char *field = spoil_config(&c, i);
    if (!field)
      break;
    assert_rejected(hbil_plan_memory(shared_device.hbil, &c, &memory),
                    HBIL_INVALID_CONFIG, field);
    assert_rejected(hbil_plan_create(shared_device.hbil, &c, &plan),
                    HBIL_INVALID_CONFIG, field);
    assert_null(plan);
  }
  setup_free(&s);
}

static void assert_bad(const hbil_config *config, const char *field) {
  hbil_plan *plan = NULL;
  assert_rejected(hbil_plan_create(shared_device.hbil, config, &plan),
                  HBIL_INVALID_CONFIG, field);
  assert_null(plan);
}

/* A mode reads no radiance, or has no bent cone. */
TEST(what_a_mode_lacks_is_rejected) {
  static const struct {
    hbil_mode mode;
    plane_id output; /* PLANE_FIRST_OUTPUT..; else the far field */
    hbil_far_field far_field;
  } lacks[] = {
      {HBIL_MODE_GTAO, PLANE_NEAR, 0},   {HBIL_MODE_GTAO, PLANE_UNKNOWN, 0},
      {HBIL_MODE_GTAO, PLANE_GLOSSY, 0}, {HBIL_MODE_GTAO, 0, HBIL_FAR_FRAME},
      {HBIL_MODE_HBAO, PLANE_NEAR, 0},   {HBIL_MODE_HBAO, PLANE_UNKNOWN, 0},
      {HBIL_MODE_HBAO, PLANE_BENT, 0},   {HBIL_MODE_HBAO, PLANE_CONE, 0},
      {HBIL_MODE_HBAO, PLANE_ERROR, 0},  {HBIL_MODE_HBAO, 0, HBIL_FAR_FRAME},
      {HBIL_MODE_HBAO, 0, HBIL_FAR_SH}};
  for (size_t i = 0; i < sizeof lacks / sizeof *lacks; ++i) {
    setup s;
    setup_init(&s, WIDTH, HEIGHT);
    setup_no_outputs(&s);
    s.config.outputs.ao = s.config.outputs.far_irradiance = three_floats;
    s.config.model.mode = lacks[i].mode;
    s.config.model.far_field = lacks[i].far_field;
    if (lacks[i].output)
      *plane_format(&s.config, lacks[i].output) = three_floats;
    assert_bad(&s.config,
               lacks[i].output ? plane_name(lacks[i].output) : "far_field");
    setup_free(&s);
  }
}

/* Near light has the bounces that ao_bounces stands in for.  What needs no near
 * light may have them in any mode. */
TEST(bounces_of_far_light_need_a_plan_without_near_light) {
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id) {
    const bool near_light = id == PLANE_NEAR || id == PLANE_INDIRECT ||
                            id == PLANE_BEAUTY || id == PLANE_GLOSSY;
    setup s;
    hbil_memory memory;
    setup_init(&s, WIDTH, HEIGHT);
    setup_no_outputs(&s);
    *plane_format(&s.config, id) = three_floats;
    s.config.model.far_field = HBIL_FAR_CONSTANT;
    s.config.model.ao_bounces = HBIL_AO_BOUNCES_PAPER;
    if (near_light)
      assert_bad(&s.config, "ao_bounces");
    else
      assert_success(&s,
                     hbil_plan_memory(shared_device.hbil, &s.config, &memory));
    s.config.model.far_field = HBIL_FAR_FRAME;
    if (id == PLANE_FAR || id == PLANE_UNKNOWN)
      assert_bad(&s.config, "ao_bounces");
    setup_free(&s);
  }
}

TEST(presets_set_the_sampling_alone) {
  for (int q = 0; q <= HBIL_QUALITY_REFERENCE; ++q) {
    setup s;
    hbil_config before;
    hbil_memory memory;
    setup_init(&s, WIDTH, HEIGHT);
    setup_all_outputs(&s);
    before = s.config;
    assert_int_equal(hbil_sampling_set(&s.config.sampling, (hbil_quality)q),
                     HBIL_SUCCESS);
    assert_int_equal(hbil_plan_memory(shared_device.hbil, &s.config, &memory),
                     HBIL_SUCCESS);
    assert_non_null(hbil_quality_name((hbil_quality)q));
    before.sampling.slices = s.config.sampling.slices;
    before.sampling.steps_per_side = s.config.sampling.steps_per_side;
    before.sampling.step_growth = s.config.sampling.step_growth;
    before.sampling.sample_grid = s.config.sampling.sample_grid;
    before.sampling.resolution = s.config.sampling.resolution;
    before.sampling.unfiltered = s.config.sampling.unfiltered;
    before.sampling.storage = s.config.sampling.storage;
    before.sampling.slice_frames = s.config.sampling.slice_frames;
    assert_memory_equal(&before, &s.config, sizeof before);
    setup_free(&s);
  }
}

static size_t bytes_at(setup *s, hbil_resolution resolution) {
  hbil_memory memory;
  s->config.sampling.resolution = resolution;
  assert_int_equal(hbil_plan_memory(shared_device.hbil, &s->config, &memory),
                   HBIL_SUCCESS);
  return memory.persistent + memory.scratch;
}

/* The tables of steps differ in size, so the memory tells what a plan does. */
TEST(large_pictures_are_gathered_at_half_resolution) {
  const int heights[] = {499, 500};
  for (int i = 0; i < 2; ++i) {
    setup s;
    setup_init(&s, 800, heights[i]);
    setup_all_outputs(&s);
    const hbil_resolution want =
        i ? HBIL_RESOLUTION_HALF : HBIL_RESOLUTION_FULL;
    const size_t half = bytes_at(&s, HBIL_RESOLUTION_HALF);
    const size_t full = bytes_at(&s, HBIL_RESOLUTION_FULL);
    assert_int_equal(hbil_config_resolution(&s.config), HBIL_RESOLUTION_FULL);
    assert_true(half != full);
    assert_int_equal(bytes_at(&s, HBIL_RESOLUTION_AUTO), i ? half : full);
    assert_int_equal(hbil_config_resolution(&s.config), want);
    s.config.sampling.unfiltered = CL_TRUE;
    assert_int_equal(hbil_config_resolution(&s.config), HBIL_RESOLUTION_FULL);
    setup_free(&s);
  }
  assert_int_equal(hbil_config_resolution(NULL), HBIL_RESOLUTION_AUTO);
}

TEST(unknown_presets_are_rejected) {
  hbil_config c;
  hbil_config_init(&c);
  assert_int_equal(hbil_sampling_set(&c.sampling, (hbil_quality)4),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_sampling_set(NULL, HBIL_QUALITY_FAST),
                   HBIL_INVALID_ARGUMENT);
  assert_null(hbil_quality_name((hbil_quality)4));
  assert_int_equal(c.sampling.steps_per_side, 40);
}

/* ------------------------------------------------------------------------ */
/* Frames                                                                    */

static const char *spoil_frame(setup *s, int which) {
  hbil_frame *f = &s->frame;
  SPOIL("depth", f->depth.buffer = NULL);
  SPOIL("normal", f->normal.buffer = NULL);
  SPOIL("beauty", f->beauty.buffer = NULL);
  SPOIL("bent_normal", f->bent_normal.buffer = NULL);
  SPOIL("depth", f->depth.offset = s->bytes[PLANE_DEPTH] / 4 * 4);
  SPOIL("normal", f->normal.buffer = f->depth.buffer);
  SPOIL("albedo", f->albedo.row_pitch = 1 << 20);
  SPOIL("albedo.row_pitch: 16 bytes are less than a row of 17 pixels, which "
        "has 204",
        f->albedo.row_pitch = 16);
  SPOIL("motion", f->motion.plane_pitch = 1 << 20);
  SPOIL("depth", f->depth.offset = SIZE_MAX - 3);
  SPOIL("depth: offset 2, row_pitch 0, plane_pitch 0; must be multiples of 4",
        f->depth.offset = 2);
  SPOIL("normal", f->normal.row_pitch = WIDTH * 12 + 2);
  SPOIL("fx", f->camera.fx = 0.0);
  SPOIL("fy", f->camera.fy = -1.0);
  SPOIL("fx", f->camera.fx = 1e39); /* no float */
  SPOIL("fy", f->camera.fy = 1e-300);
  SPOIL("cx", f->camera.cx = NAN);
  SPOIL("cy", f->camera.cy = -1e39);
  SPOIL("world_from_view", f->camera.world_from_view[0] = 1.5);
  SPOIL("world_from_view", f->camera.world_from_view[1] = 0.5);
  SPOIL("world_from_view", f->camera.world_from_view[3] = NAN);
  SPOIL("world_from_view[11]", f->camera.world_from_view[11] = 1e300);
  SPOIL("camera", memset(&f->camera, 0, sizeof(f->camera)));
  SPOIL("static_frame", f->static_frame = 2);
  SPOIL("struct_size", f->struct_size -= 8);
  SPOIL("struct_size", f->struct_size += 8);
  return NULL;
}

TEST(bad_frames_are_rejected_by_name) {
  setup s;
  start(&s);
  for (int i = 0;; ++i) {
    hbil_frame good = s.frame;
    cl_event event = NULL;
    hbil_status status;
    const char *field = spoil_frame(&s, i);
    if (!field)
      break;
    status = hbil_enqueue_frame(s.plan, shared_device.queue, &s.frame, 0, NULL,
                                &event);
    assert_rejected(status, HBIL_INVALID_FRAME, field);
    assert_null(event);
    s.frame = good;
  }
  setup_free(&s);
}

TEST(rejected_frames_write_nothing) {
  setup s;
  exact_planes out;
  start(&s);
  s.frame.camera.fx = -1.0;
  assert_int_equal(
      hbil_enqueue_frame(s.plan, shared_device.queue, &s.frame, 0, NULL, NULL),
      HBIL_INVALID_FRAME);
  assert_int_equal(clFinish(shared_device.queue), CL_SUCCESS);
  out = outputs_read(&s); /* canaries are not-a-numbers */
  for (int i = 0; i < out.width * out.height * out.count; ++i)
    assert_true(isnan(out.values[i]));
  exact_planes_free(&out);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Null and malformed arguments                                              */

TEST(null_arguments_are_rejected) {
  setup s;
  hbil_plan *plan = NULL;
  hbil_context *context = NULL;
  hbil_buffer buffer;
  hbil_memory memory;
  double times[HBIL_PASS_COUNT];
  float sh[9][3];
  start(&s);
  assert_int_equal(hbil_context_create(NULL, shared_device.id, &context),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_context_create(shared_device.context, NULL, &context),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(
      hbil_context_create(shared_device.context, shared_device.id, NULL),
      HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_memory(shared_device.hbil, NULL, &memory),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_memory(shared_device.hbil, &s.config, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_memory(NULL, &s.config, &memory),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_create(shared_device.hbil, NULL, &plan),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_create(shared_device.hbil, &s.config, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_create(NULL, &s.config, &plan),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_buffer(NULL, HBIL_STAGE_SPLIT, &buffer),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_buffer(s.plan, HBIL_STAGE_SPLIT, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_int_equal(hbil_plan_buffer(s.plan, (hbil_stage)99, &buffer),
                   HBIL_INVALID_ARGUMENT);
  assert_int_not_equal(hbil_plan_timings(s.plan, NULL), HBIL_SUCCESS);
  assert_int_not_equal(hbil_plan_timings(s.plan, times), HBIL_SUCCESS);
  assert_int_equal(hbil_environment_from_latlong(NULL, 4, 2, 0, NULL, sh),
                   HBIL_INVALID_ARGUMENT);
  hbil_plan_destroy(NULL);
  hbil_context_destroy(NULL);
  setup_free(&s);
}

TEST(every_pass_checks_its_arguments) {
  setup s;
  start(&s);
  for (int i = 0; i <= PASSES; ++i) {
    enqueue_function *const call = i ? passes[i - 1] : hbil_enqueue_frame;
    assert_int_equal(call(NULL, shared_device.queue, &s.frame, 0, NULL, NULL),
                     HBIL_INVALID_ARGUMENT);
    assert_int_equal(call(s.plan, NULL, &s.frame, 0, NULL, NULL),
                     HBIL_INVALID_ARGUMENT);
    assert_int_equal(call(s.plan, shared_device.queue, NULL, 0, NULL, NULL),
                     HBIL_INVALID_ARGUMENT);
    assert_int_equal(call(s.plan, shared_device.queue, &s.frame, 1, NULL, NULL),
                     HBIL_INVALID_ARGUMENT);
  }
  setup_free(&s);
}

TEST(passes_are_a_range) {
  static const int wrong[][2] = {{HBIL_PASS_GATHER, HBIL_PASS_SPLIT},
                                 {HBIL_PASS_SPLIT, HBIL_PASS_IMPORT},
                                 {HBIL_PASS_EXPORT, HBIL_PASS_EXPORT},
                                 {-1, HBIL_PASS_SPLIT},
                                 {HBIL_PASS_SPLIT, HBIL_PASS_COUNT}};
  setup s;
  start(&s);
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
    assert_int_equal(hbil_enqueue_passes(s.plan, shared_device.queue, &s.frame,
                                         (hbil_pass)wrong[i][0],
                                         (hbil_pass)wrong[i][1], 0, NULL, NULL),
                     HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(shared_device.hbil), "first"));
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Memory                                                                    */

TEST(announced_memory_covers_the_buffers) {
  setup s;
  cl_mem seen[5];
  size_t sum = 0;
  hbil_memory memory;
  int count = 0;
  start(&s);
  assert_success(&s, hbil_plan_memory(shared_device.hbil, &s.config, &memory));
  for (int stage = HBIL_STAGE_HISTORY; stage <= HBIL_STAGE_RESOLVED; ++stage) {
    hbil_buffer b;
    size_t size;
    bool again = false;
    assert_success(&s, hbil_plan_buffer(s.plan, (hbil_stage)stage, &b));
    for (int i = 0; i < count; ++i)
      again = again || seen[i] == b.buffer;
    if (again)
      continue;
    seen[count++] = b.buffer;
    assert_int_equal(
        clGetMemObjectInfo(b.buffer, CL_MEM_SIZE, sizeof(size), &size, NULL),
        CL_SUCCESS);
    assert_true(size >= sizeof(float) * b.values * WIDTH * HEIGHT);
    sum += size;
  }
  assert_true(memory.persistent + memory.scratch >= sum);
  setup_free(&s);
}
