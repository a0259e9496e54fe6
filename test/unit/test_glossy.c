/*
 * Glossy light beside what test_kernels compares: the lobe's integral is what
 * quadrature gives, and the probes and the join of frames with a radiance cache
 * match the exact passes.
 */
#include "exact/glossy.h"
#include "exact/lobe.h"
#include "test/support/lit_frame.h"
#include "test/support/random.h"
#include "test/support/shim.h"
#include "test/support/stages.h"

#include <math.h>

#define WIDTH 77
#define HEIGHT 45

static const cl_uint widths[] = {1, 4, 8, 16};

static void ask_for_glossy(setup *s, float roughness) {
  s->config.outputs.glossy = three_floats;
  s->config.model.roughness = roughness;
}

/* ------------------------------------------------------------------------ */
/* The lobe                                                                  */

/* The lobe at an angle of a half-slice, times its solid angle. */
static double lobe_at(const half_slice *h, double t) {
  const vec3 w = vec_add(vec_scale(sin(t), h->along), cos(t), h->wo);
  const double cosine = vec_dot(w, exact_reflected(h->point->normal, h->wo));
  return sin(t) / pow(1.0 + h->lobe * (1.0 - cosine), 2.0);
}

static double quadrature(const half_slice *h, double end) {
  enum { STEPS = 20000 }; /* of Simpson's rule */
  double sum = lobe_at(h, 0.0) + lobe_at(h, end);
  for (int i = 1; i < STEPS; ++i)
    sum += (i & 1 ? 4.0 : 2.0) * lobe_at(h, end * i / STEPS);
  return sum * end / (3.0 * STEPS);
}

TEST(the_integral_is_that_of_quadrature) {
  static const float roughness[] = {0.3f, 0.45f, 0.7f, 1.0f};
  hbil_config c;
  double worst = 0.0;
  hbil_config_init(&c);
  for (int i = 0; i < 4 * 5 * 8 * 4; ++i) {
    double n[3];
    const double psi = (i / 20 % 8) * PI / 4.0 + 0.1;
    tilted_normal(0.02 + 0.37 * (i / 4 % 5), 0.7, n);
    const surface point = {.is = true,
                           .ray = {0.3, -0.2, 1.0},
                           .normal = vec_normalize(vec(n[0], n[1], n[2]))};
    half_slice h = exact_half_slice(&point, cos(psi), sin(psi), false, false);
    if (h.ny < 0.05)
      continue;
    c.model.roughness = roughness[i % 4];
    h.lobe = exact_lobe(&c, h.ny);
    const angle end = {.theta = h.start.theta * (1 + i / 160) / 4.0};
    const double got = exact_lobe_integral(&h, end);
    worst = fmax(worst, fabs(got - quadrature(&h, end.theta)));
  }
  check_at_most("lobe integral", worst, 1e-9);
}

/* It is GGX's density of microfacets at half the angle from R. */
TEST(the_lobe_is_ggx_seen_from_above) {
  hbil_config c;
  hbil_config_init(&c);
  for (int i = 3; i <= 10; ++i) {
    c.model.roughness = 0.1f * (float)i;
    const double a2 = pow((double)c.model.roughness, 4.0);
    const double k = exact_lobe(&c, 1.0);
    for (int t = 0; t < 10; ++t) {
      const double cosine = cos(0.3 * t), m2 = 0.5 * (1.0 + cosine);
      const double ggx = pow(a2 / (m2 * (a2 - 1.0) + 1.0), 2.0);
      assert_true(fabs(1.0 / pow(1.0 + k * (1.0 - cosine), 2.0) - ggx) < 1e-12);
    }
  }
}

/* ------------------------------------------------------------------------ */
/* The radiance cache                                                        */

/* The glossy probes in an argument of a kernel; the caller frees. */
static exact_glossy_probe *probes_on_device(lit_frame *l, const char *kernel,
                                            cl_uint index, size_t count) {
  cl_mem buffer;
  exact_glossy_probe *probes = calloc(count, sizeof *probes);
  assert_non_null(probes);
  shim_argument(kernel, index, sizeof buffer, &buffer);
  float *values = (float *)(void *)buffer_bytes(&l->device, buffer, NULL);
  for (size_t i = 0; i < count; ++i) {
    const float *v = values + HBIL_GLOSSY_PROBE_FLOATS * i;
    const float *axis = v + HBIL_GLOSSY_PROBE_AXIS;
    probes[i].axis = vec((double)axis[0], (double)axis[1], (double)axis[2]);
    probes[i].known = (double)v[HBIL_GLOSSY_PROBE_KNOWN];
    probes[i].unknown = (double)v[HBIL_GLOSSY_PROBE_UNKNOWN];
    for (int c = 0; c < 3; ++c)
      probes[i].light[c] = (double)v[HBIL_GLOSSY_PROBE_LIGHT + c];
  }
  free(values);
  return probes;
}

/* As in test_cache_probes: rays that end elsewhere by a rounding change a
 * probe. */
#define MOST_DIFFERENT 0.03

static void check_probes(lit_frame *l, const exact_planes *split,
                         const exact_probes *probes,
                         const exact_glossy_probe *got) {
  const int count = probes->count;
  int valid = 0, different = 0, known = 0;
  exact_glossy_probe *want = calloc((size_t)count, sizeof *want);
  assert_non_null(want);
  exact_make_glossy_probes(&l->s.job, &l->cache, split, probes, want);
  for (int i = 0; i < count; ++i) {
    double off = fmax(fabs(got[i].known - want[i].known),
                      fabs(got[i].unknown - want[i].unknown));
    for (int c = 0; c < 3; ++c)
      off = fmax(off, fabs(got[i].light[c] - want[i].light[c]) / 7.0);
    valid += probes->probe[i].valid;
    known += want[i].known > 0.0;
    different += !(off <= 3e-6);
    assert_true(vec_length(vec_add(got[i].axis, -1.0, want[i].axis)) <= 3e-6);
  }
  assert_true(valid > 50 && known > valid / 4);
  check_at_most("probes that differ", different / (double)valid,
                MOST_DIFFERENT);
  free(want);
}

static void check_cached_frame(cl_uint width, hbil_far_field far,
                               hbil_projection projection) {
  lit_frame l;
  lit_prepare(&l, HBIL_CACHE_METHOD_RAYS, width, SCENE_SKY, projection, far);
  ask_for_glossy(&l.s, 0.5f);
  /* the filter, whose light is read from the device, takes longest to compile
   */
  l.s.config.sampling.unfiltered = CL_TRUE;
  setup_start(&l.s);
  setup_run(&l.s, hbil_enqueue_frame);
  exact_planes split = stage_read(&l.s, HBIL_STAGE_SPLIT);
  exact_planes gathered = stage_read(&l.s, HBIL_STAGE_GATHERED);
  exact_planes resolved = stage_read(&l.s, HBIL_STAGE_RESOLVED);
  exact_planes got = outputs_read(&l.s);
  exact_planes want =
      checked_planes(LIT_WIDTH, LIT_HEIGHT, EXACT_OUTPUT_PLANES);
  exact_probes probes = lit_probes(&l.s, "composite", 19);
  exact_glossy_probe *glossy =
      probes_on_device(&l, "probe_glossy", 5, (size_t)probes.count);
  check_probes(&l, &split, &probes, glossy);
  exact_estimate_frame(&l.s.job, &split, &gathered);
  l.s.job.probes = &probes;
  exact_glossy(&l.s.job, &split, &resolved, glossy, &want);
  assert_true(largest_value(&want, EXACT_GLOSSY, 3) > 0.1);
  /* Derived: some thirty roundings, and those of the lobe's 1 - cosine, of
   * 2^-24, times k of 75. */
  check_at_most("glossy", largest_error(&got, &want, EXACT_GLOSSY, 3),
                2e-5 * largest_value(&want, EXACT_GLOSSY, 3));
  free(glossy);
  exact_probes_free(&probes);
  planes_free(&split, &gathered, &resolved, &want, &got);
  lit_free(&l);
}

TEST(cached_frames_match) {
  for (int i = 0; i < 4; ++i)
    check_cached_frame(widths[i], (hbil_far_field)(3 - i),
                       HBIL_PROJECTION_PERSPECTIVE);
  check_cached_frame(8, HBIL_FAR_CONSTANT, HBIL_PROJECTION_ORTHOGRAPHIC);
}
