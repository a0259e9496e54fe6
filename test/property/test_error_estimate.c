/*
 * The output error_estimate bounds the error of AO and of E_near at 95 % of the
 * pixels of a room, and is not much larger than it has to be; the exact
 * integral is the truth.
 */
#include "test/support/stages.h"

#define WIDTH 160
#define HEIGHT 96
#define PIXELS (WIDTH * HEIGHT)

static const float thicknesses[] = {INFINITY, 0.06f};
enum { THICKNESSES = sizeof thicknesses / sizeof *thicknesses };

/* Only surfaces send light: with the lamp, 32 slices would not be exact. */
static void prepare(setup *s, float thickness) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s->config.model.gather_emission = CL_FALSE;
  s->config.model.relative_thickness = thickness;
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
}

/* 32 slices are within .001 of AO and .01 of E_near of 256. */
static int make_exact(void **state) {
  static exact_state expected[THICKNESSES];
  const exact_dense how = {.slices = 32};
  for (int i = 0; i < THICKNESSES; ++i) {
    setup s;
    prepare(&s, thicknesses[i]);
    setup_start(&s);
    checked_state(&expected[i], WIDTH, HEIGHT);
    checked_run_frame_dense(&expected[i], &s.job, &how);
    setup_free(&s);
  }
  *state = expected;
  return 0;
}

static int free_exact(void **state) {
  exact_state *expected = *state;
  for (int i = 0; i < THICKNESSES; ++i)
    exact_state_free(&expected[i]);
  return 0;
}

static double mean_light(const exact_planes *p, const float *depth) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < PIXELS; ++i)
    for (int c = 0; c < 3 && depth[i] > 0.0f; ++c, ++count)
      sum += p->values[(EXACT_NEAR_IRRADIANCE + c) * PIXELS + i];
  return sum / count;
}

/* Largest error of a pixel's `count` planes from `first` on. */
static double error_of(const exact_planes *a, const exact_planes *b, int first,
                       int count, int i) {
  double most = 0.0;
  for (int c = first; c < first + count; ++c)
    most =
        fmax(most, fabs(a->values[c * PIXELS + i] - b->values[c * PIXELS + i]));
  return most;
}

/* At most 5 % of the surfaces' pixels have larger errors than estimated; what
 * the filter can't tell from rounding, 1e-3, is allowed.  If more than 95 % had
 * less than a twentieth, the bound would be too wide to be of use. */
static void check_estimates(setup *s, const exact_planes *want) {
  exact_planes got = outputs_read(s);
  const double *estimate = got.values + EXACT_ERROR_ESTIMATE * PIXELS;
  const double mean = mean_light(want, s->input[EXACT_DEPTH]);
  int count = 0, ao = 0, light = 0, tiny_ao = 0, tiny_light = 0;
  for (int i = 0; i < PIXELS; ++i) {
    if (!(s->input[EXACT_DEPTH][i] > 0.0f)) {
      assert_true(estimate[i] == 0.0 && estimate[PIXELS + i] == 0.0);
      continue;
    }
    ++count;
    const double of_ao = estimate[i], of_light = estimate[PIXELS + i];
    const double off = error_of(&got, want, EXACT_AO, 1, i);
    const double light_off = error_of(&got, want, EXACT_NEAR_IRRADIANCE, 3, i);
    ao += off > of_ao + 1e-3;
    light += light_off > of_light + 1e-3 * mean;
    tiny_ao += off <= of_ao / 20.0;
    tiny_light += light_off <= of_light / 20.0;
  }
  check_at_most("AO beyond its estimate", (double)ao / count, 0.05);
  check_at_most("E_near beyond its estimate", (double)light / count, 0.05);
  check_at_most("AO within a twentieth of its estimate",
                (double)tiny_ao / count, 0.95);
  /* a single slice at half resolution needs much more in other scenes */
  if (s->config.sampling.slices > 1 ||
      s->config.sampling.resolution == HBIL_RESOLUTION_FULL)
    check_at_most("E_near within a twentieth of its estimate",
                  (double)tiny_light / count, 0.95);
  exact_planes_free(&got);
}

static void check_sampling(float thickness, hbil_resolution resolution,
                           cl_uint slices, cl_uint steps,
                           const exact_planes *want) {
  setup s;
  prepare(&s, thickness);
  s.config.sampling.slices = slices;
  s.config.sampling.steps_per_side = steps;
  s.config.sampling.resolution = resolution;
  s.config.outputs.error_estimate = one_float;
  setup_start(&s);
  setup_run(&s, hbil_enqueue_frame);
  check_estimates(&s, want);
  setup_free(&s);
}

static void check_resolution(const exact_state *expected,
                             hbil_resolution resolution) {
  for (int i = 0; i < THICKNESSES; ++i)
    for (cl_uint slices = 1; slices <= 3; ++slices)
      for (cl_uint steps = 4; steps <= 64; steps *= 2)
        check_sampling(thicknesses[i], resolution, slices, steps,
                       &expected[i].out);
}

TEST(errors_are_within_their_estimates) {
  check_resolution(*state, HBIL_RESOLUTION_FULL);
}

TEST(errors_are_within_their_estimates_at_half_resolution) {
  check_resolution(*state, HBIL_RESOLUTION_HALF);
}

/* The outputs of a frame whose light is multiplied by 2^exponent. */
static exact_planes bright_frame(int exponent) {
  setup s;
  setup_scene(&s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s.config.history.reprojection = HBIL_REPROJECTION_NONE;
  s.config.outputs.error_estimate = one_float;
  for (int i = 0; i < PIXELS; ++i)
    for (int c = 0; c < 3; ++c) {
      s.input[EXACT_DIRECT + c][i] =
          ldexpf(s.input[EXACT_DIRECT + c][i], exponent);
      s.input[EXACT_EMISSION + c][i] =
          ldexpf(s.input[EXACT_EMISSION + c][i], exponent);
    }
  exact_planes out = first_outputs(&s);
  setup_free(&s);
  return out;
}

/* The squares of light of 2e19 and more are not finite floats, those of 1e-19
 * and less are 0, and a neighbourhood may have both kinds of light. */
TEST(bright_light_has_estimates_in_proportion) {
  static const int exponents[] = {20, 49, 52, 55, 64, 80, 94};
  exact_planes dim = bright_frame(0);
  const double *want = dim.values + EXACT_ERROR_ESTIMATE * PIXELS;
  double mean = 0.0;
  for (int i = PIXELS; i < 2 * PIXELS; ++i)
    mean += want[i] / PIXELS;
  assert_true(mean > 1e-3);
  for (size_t k = 0; k < sizeof exponents / sizeof *exponents; ++k) {
    exact_planes bright = bright_frame(exponents[k]);
    const double *got = bright.values + EXACT_ERROR_ESTIMATE * PIXELS;
    double most = 0.0;
    for (int i = 0; i < 2 * PIXELS; ++i) {
      const double scaled = i < PIXELS ? got[i] : ldexp(got[i], -exponents[k]);
      if (!isfinite(got[i]))
        fail_msg("light of 2^%d: value %d is %g", exponents[k], i, got[i]);
      most = fmax(most, fabs(scaled - want[i]) / mean);
    }
    /* differences of squares: see errors_of() */
    check_at_most("change of the estimate over its mean", most, 0x1p-9);
    exact_planes_free(&bright);
  }
  exact_planes_free(&dim);
}

int main(void) {
  shared_device = device_open();
  return device_finish(tests_run_with(make_exact, free_exact));
}
