/*
 * hbil_plan_memory() is what a plan takes: a shim in front of OpenCL adds up
 * what is asked for.
 */
#include "test/support/fixture.h"
#include "test/support/shim.h"

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
VARIANT(packed, c->storage = HBIL_STORAGE_PACKED)
VARIANT(no_history, c->reprojection = HBIL_REPROJECTION_NONE)
VARIANT(packed_frame, (c->storage = HBIL_STORAGE_PACKED,
                       c->back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN,
                       c->far_field = HBIL_FAR_FRAME))
VARIANT(motion, c->reprojection = HBIL_REPROJECTION_MOTION)
VARIANT(radiance_carried, c->feedback = HBIL_FEEDBACK_RADIANCE)
VARIANT(refused_black, c->back_facing_fallback = HBIL_FALLBACK_BLACK)
VARIANT(refused_frame, c->back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN)
VARIANT(none_refused, (c->back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN,
                       c->facing_fade[0] = c->facing_fade[1] = -1.0f))
VARIANT(far_constant, c->far_field = HBIL_FAR_CONSTANT)
VARIANT(far_sh, c->far_field = HBIL_FAR_SH)
VARIANT(far_frame, c->far_field = HBIL_FAR_FRAME)
VARIANT(radius, c->radius = 1.5f)
VARIANT(many_samples, (c->slices = 7, c->steps_per_side = 33))
VARIANT(one_raw_sample,
        (c->slices = c->steps_per_side = 1, c->unfiltered = CL_TRUE,
         c->sample_grid = HBIL_GRID_SAME_LAYER))
VARIANT(horizon_cache_bytes,
        (c->horizon_cache_bytes = SIZE_MAX, c->steps_per_side = 3))
VARIANT(few_form_factors,
        (c->horizon_cache_bytes = 1 << 16, c->steps_per_side = 1))
VARIANT(thick_in_ones, (c->thickness = 0.2f, c->relative_thickness = 0.08f,
                        c->vector_width = 1, c->profiling = CL_TRUE))

/* Those that every set of outputs is tried with come first: each plan is built,
 * which takes its time. */
static const variant variants[] = {
    {"the defaults", as_it_is},
    {"packed", packed},
    {"no history", no_history},
    {"refused: frame", refused_frame},
    {"far field: sh", far_sh},
    {"far field: frame", far_frame},
    {"packed, far field and refused: frame", packed_frame},
    {"motion", motion},
    {"radiance carried", radiance_carried},
    {"refused: black", refused_black},
    {"none refused", none_refused},
    {"far field: constant", far_constant},
    {"radius", radius},
    {"many samples", many_samples},
    {"one raw sample", one_raw_sample},
    {"form factors", horizon_cache_bytes},
    {"form factors of some rows", few_form_factors},
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
  c->ao = one_float;
}

static void ao_and_bent(hbil_config *c) {
  ao_alone(c);
  c->bent_normal = (hbil_plane_format){HBIL_FLOAT16, 3};
}

static void light_alone(hbil_config *c) {
  no_outputs(c);
  c->near_irradiance = (hbil_plane_format){HBIL_FLOAT16, 4};
}

static void far_alone(hbil_config *c) {
  no_outputs(c);
  c->far_irradiance = one_float;
}

static void gtao(hbil_config *c) {
  ao_and_bent(c);
  c->mode = HBIL_MODE_GTAO;
}

static void hbao(hbil_config *c) {
  ao_alone(c);
  c->mode = HBIL_MODE_HBAO;
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
/* What is announced is what is made                                         */

/* A plan as announced; false where the library refuses the settings. */
static bool check_plan(const hbil_config *config, const char *what,
                       const char *how) {
  hbil_plan *plan = NULL;
  size_t announced = 0;
  const hbil_status status =
      hbil_plan_memory(shared_device.hbil, config, &announced);
  if (status == HBIL_INVALID_CONFIG)
    return false; /* a far field that the mode has no use for */
  assert_int_equal(status, HBIL_SUCCESS);
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

static void every_setting_takes_what_is_announced(void **state) {
  int checked = 0;
  (void)state;
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

static void every_size_takes_what_is_announced(void **state) {
  (void)state;
  for (size_t i = 0; i < SIZES; ++i)
    for (size_t o = 0; o < 2; ++o) { /* all outputs, AO alone */
      setup s;
      prepare(&s, sizes[i][0], sizes[i][1]);
      outputs[o].apply(&s.config);
      assert_true(check_plan(&s.config, outputs[o].name, "the defaults"));
      setup_free(&s);
    }
}

/* The tool's model, in which everything there is is needed. */
static void use_all(setup *s) {
  prepare(s, 64, 36);
  s->config.relative_thickness = 0.08f;
  s->config.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.far_field = HBIL_FAR_FRAME;
}

static void frames_make_no_buffers(void **state) {
  setup s;
  (void)state;
  use_all(&s);
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

static void the_query_makes_no_buffers(void **state) {
  setup s;
  size_t bytes = 0;
  (void)state;
  use_all(&s);
  shim_start_counting();
  assert_int_equal(hbil_plan_memory(shared_device.hbil, &s.config, &bytes),
                   HBIL_SUCCESS);
  assert_true(bytes > 0);
  assert_int_equal(shim_created().count, 0);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Little more than the planes                                               */

/* Words of 32 bits a pixel, as the header has them beside hbil_plan_buffer()
 * and hbil_storage; not asked of the plan, which reads some of them off
 * its buffers. */
typedef struct plane_counts {
  double history, carried, scatter, split, gathered, resolved;
} plane_counts;

/* The carried light has a pyramid above it, a third as large. */
static double sum_of(const plane_counts *p) {
  return p->history + p->carried * 4.0 / 3.0 + p->scatter + p->split +
         p->gathered + p->resolved;
}

static void check_planes(const hbil_config *config, plane_counts counts) {
  const double pixels = (double)config->width * config->height;
  hbil_plan *plan;
  shim_start_counting();
  assert_int_equal(hbil_plan_create(shared_device.hbil, config, &plan),
                   HBIL_SUCCESS);
  hbil_plan_destroy(plan);
  check_at_most("memory over the planes",
                (double)shim_created().bytes / (4.0 * sum_of(&counts) * pixels),
                1.25);
}

static void padding_is_at_most_a_quarter(void **state) {
  setup s;
  (void)state;
  prepare(&s, 1280, 720);
  check_planes(&s.config, (plane_counts){4, 4, 2, 7, 7, 7});
  s.config.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s.config.far_field = HBIL_FAR_FRAME;
  s.config.steps_per_side = 48;
  check_planes(&s.config, (plane_counts){4, 4, 2, 7, 8, 7});
  s.config.reprojection = HBIL_REPROJECTION_NONE;
  check_planes(&s.config, (plane_counts){0, 0, 0, 7, 8, 7});
  ao_alone(&s.config);
  s.config.far_field = HBIL_FAR_NONE;
  check_planes(&s.config, (plane_counts){0, 0, 0, 4, 1, 1});
  setup_free(&s);
}

static void packed_padding_is_at_most_a_quarter(void **state) {
  setup s;
  (void)state;
  prepare(&s, 1280, 720);
  s.config.storage = HBIL_STORAGE_PACKED;
  check_planes(&s.config, (plane_counts){4, 4, 2, 3, 3, 7});
  s.config.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s.config.far_field = HBIL_FAR_FRAME;
  s.config.reprojection = HBIL_REPROJECTION_NONE;
  check_planes(&s.config, (plane_counts){0, 0, 0, 3, 3, 7});
  ao_alone(&s.config);
  s.config.far_field = HBIL_FAR_NONE;
  check_planes(&s.config, (plane_counts){0, 0, 0, 2, 1, 1});
  setup_free(&s);
}

static void half_padding_is_at_most_a_quarter(void **state) {
  setup s;
  (void)state;
  prepare(&s, 1280, 720);
  s.config.storage = HBIL_STORAGE_HALF;
  s.config.reprojection = HBIL_REPROJECTION_NONE;
  check_planes(&s.config, (plane_counts){0, 0, 0, 4, 4, 7});
  light_alone(&s.config);
  check_planes(&s.config, (plane_counts){0, 0, 0, 4, 3, 4});
  setup_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_setting_takes_what_is_announced),
      cmocka_unit_test(every_size_takes_what_is_announced),
      cmocka_unit_test(frames_make_no_buffers),
      cmocka_unit_test(the_query_makes_no_buffers),
      cmocka_unit_test(padding_is_at_most_a_quarter),
      cmocka_unit_test(packed_padding_is_at_most_a_quarter),
      cmocka_unit_test(half_padding_is_at_most_a_quarter)};
  return RUN_WITH_DEVICE(tests);
}
