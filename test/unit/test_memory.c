/*
 * hbil_plan_memory() is what a plan takes, to the byte, and little more than
 * its planes: a shim between the library and OpenCL adds up the buffers.
 */
#include "test/support/fixture.h"
#include "test/support/shim.h"

#include <stdio.h>

/* ------------------------------------------------------------------------ */
/* Configurations                                                            */

typedef struct variant {
  const char *name;
  void (*apply)(hbil_config *);
} variant;

#define VARIANT(name, statement)                                               \
  static void name(hbil_config *c) {                                           \
    statement;                                                                 \
  }
VARIANT(as_it_is, (void)c)
VARIANT(packed, c->sampling.storage = HBIL_STORAGE_PACKED)
VARIANT(no_history, c->history.reprojection = HBIL_REPROJECTION_NONE)
VARIANT(packed_frame, (c->sampling.storage = HBIL_STORAGE_PACKED,
                       c->model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN,
                       c->model.far_field = HBIL_FAR_FRAME))
VARIANT(motion, c->history.reprojection = HBIL_REPROJECTION_MOTION)
VARIANT(radiance_carried, c->model.feedback = HBIL_FEEDBACK_RADIANCE)
VARIANT(fallback_black, c->model.back_facing_fallback = HBIL_FALLBACK_BLACK)
VARIANT(fallback_frame_mean,
        c->model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN)
VARIANT(all_accepted,
        (c->model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN,
         c->model.facing_fade[0] = c->model.facing_fade[1] = -1.0f))
VARIANT(far_constant, c->model.far_field = HBIL_FAR_CONSTANT)
VARIANT(far_sh, c->model.far_field = HBIL_FAR_SH)
VARIANT(far_frame, c->model.far_field = HBIL_FAR_FRAME)
VARIANT(radius, c->model.radius = 1.5f)
VARIANT(world_cache, c->model.cache_method = HBIL_CACHE_METHOD_RAYS)
VARIANT(many_samples, (c->sampling.slices = 7, c->sampling.steps_per_side = 33))
VARIANT(one_unfiltered_sample,
        (c->sampling.slices = c->sampling.steps_per_side = 1,
         c->sampling.unfiltered = CL_TRUE,
         c->sampling.sample_grid = HBIL_GRID_SAME_LAYER))
VARIANT(half_resolution, (c->sampling.resolution = HBIL_RESOLUTION_HALF,
                          c->sampling.steps_per_side = 3))
VARIANT(half_resolution_in_ones, (c->sampling.resolution = HBIL_RESOLUTION_HALF,
                                  c->execution.vector_width = 1))
VARIANT(thick_in_ones,
        (c->model.thickness = 0.2f, c->model.relative_thickness = 0.08f,
         c->execution.vector_width = 1, c->execution.profiling = CL_TRUE))

/* The first COMMON_VARIANTS are tried with every set of outputs, the others
 * with all outputs alone: each plan's kernels are compiled. */
static const variant variants[] = {
    {"the defaults", as_it_is},
    {"packed", packed},
    {"no history", no_history},
    {"fallback: frame mean", fallback_frame_mean},
    {"far field: sh", far_sh},
    {"far field: frame", far_frame},
    {"packed, far field and fallback from the frame", packed_frame},
    {"motion", motion},
    {"radiance carried", radiance_carried},
    {"fallback: black", fallback_black},
    {"all light accepted", all_accepted},
    {"far field: constant", far_constant},
    {"radius", radius},
    {"world cache", world_cache},
    {"many samples", many_samples},
    {"one unfiltered sample", one_unfiltered_sample},
    {"half resolution", half_resolution},
    {"half resolution, vectors of one", half_resolution_in_ones},
    {"thick, vectors of one, profiling", thick_in_ones},
};
#define VARIANTS (sizeof variants / sizeof *variants)
#define COMMON_VARIANTS 6

static void no_outputs(hbil_config *c) {
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    plane_format(c, id)->component = HBIL_NONE;
}

static void ao_alone(hbil_config *c) {
  no_outputs(c);
  c->outputs.ao = one_float;
}

static void ao_and_bent(hbil_config *c) {
  ao_alone(c);
  c->outputs.bent_normal = (hbil_plane_format){HBIL_FLOAT16, 6};
}

static void light_alone(hbil_config *c) {
  no_outputs(c);
  c->outputs.near_irradiance = (hbil_plane_format){HBIL_FLOAT16, 8};
}

static void far_alone(hbil_config *c) {
  no_outputs(c);
  c->outputs.far_irradiance = one_float;
}

static void gtao(hbil_config *c) {
  ao_and_bent(c);
  c->model.mode = HBIL_MODE_GTAO;
}

static void hbao(hbil_config *c) {
  ao_alone(c);
  c->model.mode = HBIL_MODE_HBAO;
}

static const variant outputs[] = {
    {"all outputs", as_it_is},
    {"AO alone", ao_alone},
    {"AO and bent", ao_and_bent},
    {"E_near alone", light_alone},
    {"E_far alone", far_alone},
    {"GTAO", gtao},
    {"HBAO", hbao},
};
#define OUTPUTS (sizeof outputs / sizeof *outputs)

static const int sizes[][2] = {{1, 1},  {3, 5},    {17, 9},
                               {64, 1}, {131, 67}, {320, 180}};
#define SIZES (sizeof sizes / sizeof *sizes)

/* ------------------------------------------------------------------------ */
/* Announced memory                                                          */

/* Creates a plan and compares; false if the library rejects the settings. */
static bool check_plan(const hbil_config *config, const char *what,
                       const char *how) {
  hbil_plan *plan = NULL;
  hbil_memory memory;
  const hbil_status status =
      hbil_plan_memory(shared_device.hbil, config, &memory);
  if (status == HBIL_INVALID_CONFIG)
    return false; /* a far field that the mode lacks */
  assert_int_equal(status, HBIL_SUCCESS);
  const size_t announced = memory.persistent + memory.scratch;
  shim_start_counting();
  assert_int_equal(hbil_plan_create(shared_device.hbil, config, &plan),
                   HBIL_SUCCESS);
  if (shim_created().bytes != announced)
    fail_msg("%ux%u, %s, %s: %zu bytes in %d buffers, %zu are announced",
             (unsigned)config->width, (unsigned)config->height, what, how,
             shim_created().bytes, shim_created().count, announced);
  assert_true(shim_created().count > 0);
  hbil_plan_destroy(plan);
  return true;
}

static void prepare(setup *s, int width, int height) {
  setup_init(s, width, height);
  setup_all_outputs(s);
}

TEST_WITHOUT_KERNELS(every_setting_takes_the_announced_memory) {
  int checked = 0;
  for (size_t o = 0; o < OUTPUTS; ++o)
    for (size_t v = 0; v < (o ? COMMON_VARIANTS : VARIANTS); ++v) {
      setup s;
      prepare(&s, 33, 18);
      outputs[o].apply(&s.config);
      variants[v].apply(&s.config);
      checked += check_plan(&s.config, outputs[o].name, variants[v].name);
      setup_free(&s);
    }
  /* GTAO has no far field of the frame, HBAO none of SH either */
  assert_int_equal(checked,
                   (int)(VARIANTS + (OUTPUTS - 1) * COMMON_VARIANTS) - 3);
}

TEST_WITHOUT_KERNELS(every_size_takes_the_announced_memory) {
  for (size_t i = 0; i < SIZES; ++i)
    for (size_t o = 0; o < 2; ++o) { /* all outputs, AO alone */
      setup s;
      prepare(&s, sizes[i][0], sizes[i][1]);
      outputs[o].apply(&s.config);
      assert_true(check_plan(&s.config, outputs[o].name, "the defaults"));
      setup_free(&s);
    }
}

/* The tool's model, which needs every pass and every buffer. */
static void use_everything(setup *s) {
  prepare(s, 64, 36);
  s->config.model.relative_thickness = 0.08f;
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.model.far_field = HBIL_FAR_FRAME;
}

TEST(frames_create_no_buffers) {
  setup s;
  use_everything(&s);
  setup_start(&s);
  shim_start_counting();
  for (cl_uint i = 0; i < 4; ++i) {
    s.frame.frame_index = i;
    setup_run(&s, hbil_enqueue_frame);
  }
  hbil_plan_reset(s.plan);
  setup_run(&s, hbil_enqueue_frame);
  assert_int_equal(shim_created().count, 0);
  setup_free(&s);
}

TEST(the_query_creates_no_buffers) {
  setup s;
  use_everything(&s);
  shim_start_counting();
  assert_true(setup_memory(&s) > 0);
  assert_int_equal(shim_created().count, 0);
  setup_free(&s);
}

/* What a plan can't have, the query rejects as well, in the same words. */
TEST(the_query_rejects_what_create_rejects) {
  setup s;
  hbil_memory memory;
  char message[256];
  hbil_plan *plan = NULL;
  use_everything(&s);
  for (cl_ulong most = 4096; most; most = most < 65536 ? 65536 : 0) {
    shim_answer(CL_DEVICE_MAX_MEM_ALLOC_SIZE, &most, sizeof most);
    assert_int_equal(hbil_plan_memory(shared_device.hbil, &s.config, &memory),
                     HBIL_OUT_OF_DEVICE_MEMORY);
    snprintf(message, sizeof message, "%s",
             hbil_context_message(shared_device.hbil));
    assert_non_null(strstr(message, "64 x 36 pixels need a buffer of "));
    assert_int_equal(hbil_plan_create(shared_device.hbil, &s.config, &plan),
                     HBIL_OUT_OF_DEVICE_MEMORY);
    assert_string_equal(hbil_context_message(shared_device.hbil), message);
  }
  shim_answer(0, NULL, 0);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Little more than the planes                                               */

/* Words of 32 bits a pixel, as hbil.h states them beside hbil_plan_buffer() and
 * hbil_storage.  The plan isn't asked: it derives some of them from its
 * buffers. */
typedef struct plane_counts {
  double history, carried, split, gathered, resolved;
} plane_counts;

/* The pyramid of the carried light is a third of it. */
static double sum_of(const plane_counts *p) {
  return p->history + p->carried * 4.0 / 3.0 + p->split + p->gathered +
         p->resolved;
}

static bool device_is_cpu(void) {
  cl_device_type type = 0;
  assert_int_equal(clGetDeviceInfo(shared_device.id, CL_DEVICE_TYPE,
                                   sizeof type, &type, NULL),
                   CL_SUCCESS);
  return (type & CL_DEVICE_TYPE_CPU) != 0;
}

/* Whether plans for the tests' device have kernels of vectors. */
static bool device_has_vectors(void) {
  cl_uint width = 1;
  assert_int_equal(clGetDeviceInfo(shared_device.id,
                                   CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT,
                                   sizeof width, &width, NULL),
                   CL_SUCCESS);
  return device_is_cpu() && width >= 4;
}

/* Without vectors, what is noted of spans, two bytes, and of the bounds of
 * groups of four vectors, two words, takes a word a pixel. */
static void check_planes(const hbil_config *config, plane_counts counts) {
  const double pixels = (double)config->width * config->height;
  const double notes = device_has_vectors() ? 0.0 : 1.0;
  hbil_plan *plan;
  shim_start_counting();
  assert_int_equal(hbil_plan_create(shared_device.hbil, config, &plan),
                   HBIL_SUCCESS);
  hbil_plan_destroy(plan);
  check_at_most("memory over the planes",
                (double)shim_created().bytes /
                    (4.0 * (sum_of(&counts) + notes) * pixels),
                1.25);
}

TEST_WITHOUT_KERNELS(padding_is_at_most_a_quarter) {
  setup s;
  prepare(&s, 1280, 720);
  check_planes(&s.config, (plane_counts){4, 4, 7, 7, 9});
  s.config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s.config.model.far_field = HBIL_FAR_FRAME;
  s.config.sampling.steps_per_side = 48;
  check_planes(&s.config, (plane_counts){4, 4, 7, 8, 9});
  s.config.history.reprojection = HBIL_REPROJECTION_NONE;
  check_planes(&s.config, (plane_counts){0, 0, 7, 8, 9});
  ao_alone(&s.config);
  s.config.model.far_field = HBIL_FAR_NONE;
  check_planes(&s.config, (plane_counts){0, 0, 4, 1, 1});
  setup_free(&s);
}

TEST_WITHOUT_KERNELS(packed_padding_is_at_most_a_quarter) {
  setup s;
  prepare(&s, 1280, 720);
  s.config.sampling.storage = HBIL_STORAGE_PACKED;
  check_planes(&s.config, (plane_counts){2, 2, 3, 3, 9});
  s.config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s.config.model.far_field = HBIL_FAR_FRAME;
  s.config.history.reprojection = HBIL_REPROJECTION_NONE;
  check_planes(&s.config, (plane_counts){0, 0, 3, 3, 9});
  ao_alone(&s.config);
  s.config.model.far_field = HBIL_FAR_NONE;
  check_planes(&s.config, (plane_counts){0, 0, 2, 1, 1});
  setup_free(&s);
}

static size_t memory_with(hbil_mode mode, hbil_far_field far_field) {
  setup s;
  setup_init(&s, 160, 90);
  setup_mode(&s, mode);
  s.config.outputs.far_irradiance = three_floats;
  s.config.model.far_field = far_field;
  const size_t bytes = setup_memory(&s);
  setup_free(&s);
  return bytes;
}

/* HBIL_FAR_AUTO is the frame's estimate, which has planes of its own, where
 * there is light, and none where there is occlusion alone. */
TEST(the_default_far_field_depends_on_the_mode) {
  const size_t none = memory_with(HBIL_MODE_HBIL, HBIL_FAR_NONE);
  assert_true(memory_with(HBIL_MODE_HBIL, HBIL_FAR_FRAME) > none);
  assert_int_equal(memory_with(HBIL_MODE_HBIL, HBIL_FAR_AUTO),
                   memory_with(HBIL_MODE_HBIL, HBIL_FAR_FRAME));
  assert_int_equal(memory_with(HBIL_MODE_GTAO, HBIL_FAR_AUTO),
                   memory_with(HBIL_MODE_GTAO, HBIL_FAR_NONE));
}

/* A column of pixels: what bounds its memory are three vectors in each row of
 * each plane of 16 layers, two planes to split and one gathered, in a quarter
 * of the rows; and four vectors in each row of the plane of resolved AO.  A
 * twentieth more is for the rest: rows around the layers, states, bounds. */
TEST(narrow_pictures_take_little_memory) {
  static const cl_uint widths[] = {1, 4, 8, 16};
  for (size_t i = 0; i < sizeof widths / sizeof *widths; ++i) {
    setup s;
    /* spans of single pixels have four, as many as there are in a layer */
    const size_t vector = widths[i] == 1 ? 4 : widths[i];
    prepare(&s, 1, 16384);
    s.config.sampling.storage = HBIL_STORAGE_PACKED;
    s.config.execution.vector_width = widths[i];
    ao_alone(&s.config);
    s.config.model.far_field = HBIL_FAR_NONE;
    check_at_most(
        "memory of a column over its vectors",
        (double)setup_memory(&s) /
            (double)(sizeof(float) * vector * 16384 * (3 * 3 * 16 / 4 + 4)),
        1.05);
    setup_free(&s);
  }
}

/* ------------------------------------------------------------------------ */
/* Huge pages                                                                */

/* Whether plans for the tests' device have buffers on huge pages. */
static bool gives_huge_pages(void) {
#ifdef __linux__
  return device_is_cpu();
#else
  return false;
#endif
}

/* The split of 1280 x 720 pixels is large enough, and nothing of 33 x 18. */
TEST_WITHOUT_KERNELS(large_buffers_of_cpus_are_freed_with_their_plan) {
  setup s;
  hbil_plan *plan;
  for (int large = 0; large < 2; ++large) {
    prepare(&s, large ? 1280 : 33, large ? 720 : 18);
    shim_start_counting();
    assert_int_equal(hbil_plan_create(shared_device.hbil, &s.config, &plan),
                     HBIL_SUCCESS);
    const int hosted = shim_created().hosted;
    assert_true(hosted == 0 || (large && hosted < shim_created().count));
    assert_true(hosted > 0 || !large || !gives_huge_pages());
    assert_int_equal(shim_destructors(), hosted);
    hbil_plan_destroy(plan);
    assert_int_equal(shim_destructors(), 0);
    setup_free(&s);
  }
}

/* Each call of OpenCL that creating a plan makes fails once.  If one that is
 * about huge pages fails, the plan must do without; and nothing may leak. */
TEST_WITHOUT_KERNELS(plans_do_without_huge_pages) {
  setup s;
  hbil_plan *plan;
  int managed = 0;
  if (!gives_huge_pages())
    skip();
  prepare(&s, 1280, 720);
  const long references = shim_references();
  for (int call = 1;; ++call) {
    plan = NULL;
    shim_fail(call, CL_OUT_OF_RESOURCES);
    const hbil_status status =
        hbil_plan_create(shared_device.hbil, &s.config, &plan);
    const char *failed = shim_failed();
    shim_fail(0, CL_SUCCESS);
    managed += failed && status == HBIL_SUCCESS &&
               !strcmp(failed, "clSetMemObjectDestructorCallback");
    if (failed && status != HBIL_SUCCESS)
      assert_string_not_equal(failed, "clSetMemObjectDestructorCallback");
    if (plan)
      hbil_plan_destroy(plan);
    assert_int_equal(shim_destructors(), 0);
    assert_int_equal(shim_references(), references);
    if (!failed)
      break;
  }
  assert_true(managed > 0);
  setup_free(&s);
}
