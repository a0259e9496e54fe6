/*
 * Unseen light, estimated from the frame itself, in place of back-facing
 * samples and as far field: it is a mean of the surfaces' light after all
 * bounces, and adds no energy (test_kernels: it matches the exact passes).  The
 * output `unknown` is the share of the hemisphere whose light is such a guess.
 */
#include "test/support/random.h"
#include "test/support/stages.h"

static void from_the_frame(setup *s) {
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.model.far_field = HBIL_FAR_FRAME;
}

#define WIDTH 77
#define HEIGHT 45

static void start_room(setup *s) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  from_the_frame(s);
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    plane_format(&s->config, id)->component = HBIL_NONE;
}

/* One output alone, from a plan that skips whatever the others need. */
static exact_planes output_alone(plane_id id) {
  setup s;
  exact_planes out;
  start_room(&s);
  *plane_format(&s.config, id) = three_floats;
  out = first_outputs(&s);
  setup_free(&s);
  return out;
}

TEST(lights_can_be_had_alone) {
  exact_planes all, near_irradiance = output_alone(PLANE_NEAR);
  exact_planes far_irradiance = output_alone(PLANE_FAR);
  setup s;
  start_room(&s);
  setup_all_outputs(&s);
  all = first_outputs(&s);
  assert_true(largest_value(&all, EXACT_NEAR_IRRADIANCE, 3) > 0.0);
  assert_true(largest_value(&all, EXACT_FAR_IRRADIANCE, 3) > 0.0);
  assert_true(largest_error(&near_irradiance, &all, EXACT_NEAR_IRRADIANCE, 3) ==
              0.0);
  assert_true(largest_error(&far_irradiance, &all, EXACT_FAR_IRRADIANCE, 3) ==
              0.0);
  planes_free(&all, &near_irradiance, &far_irradiance);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Any G-buffer                                                              */

/* Depths over a factor of 4 and normals all around, some pixels sky; black
 * surfaces that emit `radiance`. */
static void start_random(setup *s, float radiance) {
  random_state r = {7};
  setup_init(s, WIDTH, HEIGHT);
  from_the_frame(s);
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
  s->config.inputs.direct.component = s->config.inputs.f0.component = HBIL_NONE;
  s->config.model.offscreen_light = 1.0f;
  s->config.outputs.far_irradiance = three_floats;
  s->config.outputs.cone_cosine = one_float;
  for (int c = 0; c < 3; ++c)
    setup_fill(s, EXACT_EMISSION + c, radiance);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    bool sky = random_unit(&r) < 0.1;
    s->input[EXACT_DEPTH][i] = sky ? 0.0f : (float)exp2(2.0 * random_unit(&r));
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] = (float)(2.0 * random_unit(&r) - 1.0);
  }
}

/* Smallest and largest E_far / (pi AO): the radiance that unblocked directions
 * are taken to have. */
static void estimate_range(const exact_planes *out, double range[2]) {
  size_t count = (size_t)out->width * (size_t)out->height;
  range[0] = INFINITY;
  range[1] = -INFINITY;
  for (size_t i = 0; i < 3 * count; ++i) {
    double ao = out->values[EXACT_AO * count + i % count];
    double estimate = out->values[EXACT_FAR_IRRADIANCE * count + i] / (PI * ao);
    assert_true(isfinite(out->values[EXACT_FAR_IRRADIANCE * count + i]));
    if (ao < 0.05 || out->values[EXACT_CONE_COSINE * count + i % count] == 0.0)
      continue; /* few digits; the sky */
    range[0] = fmin(range[0], estimate);
    range[1] = fmax(range[1], estimate);
  }
}

/* And AO + E_near / (2.5 pi) is 1, although back-facing samples count as
 * unseen. */
TEST(an_even_radiance_is_its_own_estimate) {
  setup s;
  double range[2], worst = 0.0;
  start_random(&s, 2.5f);
  exact_planes out = first_outputs(&s);
  estimate_range(&out, range);
  /* measured: 9.7e-7, the same sums twice with and without 2.5 */
  check_at_most("even radiance", fmax(range[1] / 2.5 - 1, 1 - range[0] / 2.5),
                1e-5);
  for (int i = 0; i < 3 * WIDTH * HEIGHT; ++i) {
    const double near = out.values[EXACT_NEAR_IRRADIANCE * WIDTH * HEIGHT + i];
    const double ao =
        out.values[EXACT_AO * WIDTH * HEIGHT + i % (WIDTH * HEIGHT)];
    worst = fmax(worst, fabs(ao + near / (2.5 * PI) - 1.0));
  }
  /* measured: 9.3e-7; the requirement is 2e-3 */
  check_at_most("furnace", worst, 1e-5);
  exact_planes_free(&out);
  setup_free(&s);
}

/* The exact estimate too, for normals that no pixel has. */
TEST(the_exact_estimate_is_even) {
  setup s;
  exact_planes split, gathered;
  random_state r = {9};
  double worst = 0.0;
  start_random(&s, 2.5f);
  setup_start(&s);
  split = checked_planes(WIDTH, HEIGHT, HBIL_SPLIT_PLANES);
  gathered = checked_planes(WIDTH, HEIGHT, HBIL_GATHERED_PLANES);
  exact_split(&s.job, NULL, &split);
  checked_gather(&s.job, &split, &gathered);
  exact_estimate_frame(&s.job, &split, &gathered);
  for (int i = 0; i < 1000; ++i) {
    double z = 2.0 * random_unit(&r) - 1.0, angle = 2.0 * PI * random_unit(&r);
    double side = sqrt(1.0 - z * z);
    const double n[3] = {side * cos(angle), side * sin(angle), z};
    double light = exact_frame_radiance(&s.job, i % 3, n);
    worst = fmax(worst, fabs(light / 2.5 - 1.0));
  }
  /* one rounding of 2.5 to float, and of pi; measured: 2.8e-8 */
  check_at_most("reference", worst, 1e-7);
  planes_free(&gathered, &split);
  setup_free(&s);
}

/* Every weight is positive, so nothing unseen is brighter than the brightest
 * surfel nor darker than the darkest. */
TEST(estimates_are_means) {
  setup s;
  exact_planes out;
  random_state r = {11};
  double range[2];
  start_random(&s, 1.0f);
  for (int p = EXACT_EMISSION; p < EXACT_EMISSION + 3; ++p)
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
      s.input[p][i] = random_unit(&r) < 0.02 ? 1e4f : 1.0f;
  out = first_outputs(&s);
  estimate_range(&out, range);
  assert_true(range[1] > 10.0); /* the spikes are in it */
  check_at_most("above the largest", range[1] - 1e4, 0.0);
  check_at_most("below the smallest", 1.0 - range[0], 0.0);
  exact_planes_free(&out);
  setup_free(&s);
}

/* Whether the estimate uses a pixel. */
static bool is_used(int x, int y) {
  return hbil_estimate_uses(x / 4 / HBIL_ESTIMATE_BLOCK, y);
}

/* Sky at all pixels, or at those that the estimate uses. */
static void check_without_surfels(bool all) {
  setup s;
  exact_planes out;
  int used = 0;
  start_random(&s, 1.0f);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    used += is_used(i % WIDTH, i / WIDTH);
    if (all || is_used(i % WIDTH, i / WIDTH))
      s.input[EXACT_DEPTH][i] = 0.0f;
  }
  /* an eighth, and what the borders add */
  assert_true(used > WIDTH * HEIGHT / 9 && used < WIDTH * HEIGHT / 5);
  out = first_outputs(&s);
  for (int i = 0; i < WIDTH * HEIGHT * EXACT_OUTPUT_PLANES; ++i)
    assert_true(isfinite(out.values[i]));
  /* the frame sends nothing; a pixel itself sees 1 at most */
  assert_true(largest_value(&out, EXACT_FAR_IRRADIANCE, 3) <= (all ? 0.0 : PI));
  exact_planes_free(&out);
  setup_free(&s);
}

TEST(without_surfels_there_is_no_light) {
  check_without_surfels(true);
  check_without_surfels(false);
}

/* ------------------------------------------------------------------------ */
/* Energy                                                                    */

#define ALBEDO 0.8
#define BOUNCES 200

/* Distance along a ray to the box [-2,3] x [-1,2] x [-1,4] from inside it, and
 * the face's normal. */
static double box_depth(const double ray[3], double normal[3]) {
  const double low[3] = {-2, -1, -1}, high[3] = {3, 2, 4};
  double nearest = INFINITY;
  for (int c = 0; c < 3; ++c) {
    double t =
        ray[c] == 0.0 ? INFINITY : (ray[c] > 0.0 ? high : low)[c] / ray[c];
    if (t >= nearest)
      continue;
    nearest = t;
    for (int i = 0; i < 3; ++i)
      normal[i] = i != c ? 0.0 : ray[c] > 0.0 ? -1.0 : 1.0;
  }
  return nearest;
}

/* The box, seen from inside. */
static void load_box(setup *s) {
  setup_camera(s, 100.0);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    double ray[3], normal[3];
    setup_ray(s, i % WIDTH, i / WIDTH, ray);
    s->input[EXACT_DEPTH][i] = (float)box_depth(ray, normal);
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] = (float)normal[c];
  }
}

/* A lamp shines on a part of the back wall and on a part of the left one.  No
 * face of a box faces away from another: only a facing fade above 0 leaves
 * light to the fallback. */
static void start_box(setup *s, hbil_feedback feedback, float facing) {
  setup_init(s, WIDTH, HEIGHT);
  setup_all_outputs(s);
  from_the_frame(s);
  load_box(s);
  s->config.model.feedback = feedback;
  s->config.model.facing_fade[0] = fminf(facing, -0.1f);
  s->config.model.facing_fade[1] = facing;
  s->config.inputs.emission.component = HBIL_NONE;
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    double ray[3];
    setup_ray(s, i % WIDTH, i / WIDTH, ray);
    const double depth = (double)s->input[EXACT_DEPTH][i];
    const bool lit = depth * ray[0] < -0.5 && depth * ray[1] < 1.0;
    for (int c = 0; c < 3; ++c) {
      s->input[EXACT_ALBEDO + c][i] = (float)ALBEDO;
      s->input[EXACT_DIRECT + c][i] = lit ? 1.0f : 0.0f;
    }
  }
  setup_start(s);
}

/* Sums over the picture: of light that is guessed, and of all. */
typedef struct totals {
  double far, all;
} totals;

static totals totals_of(const exact_planes *out) {
  totals t = {0.0, 0.0};
  for (int i = 0; i < 3 * WIDTH * HEIGHT; ++i) {
    t.far += out->values[EXACT_FAR_IRRADIANCE * WIDTH * HEIGHT + i];
    t.all += out->values[EXACT_INDIRECT * WIDTH * HEIGHT + i];
  }
  return t;
}

/*
 * Near, unknown and open shares of a hemisphere add up to 1, and unseen light
 * is a mean of surfaces' light after all bounces.  So nothing is brighter than
 * the geometric series of the albedo.  What is guessed is there from the first
 * frame on, and nothing grows in two hundred.
 */
static void check_energy(hbil_feedback feedback, float facing) {
  /* roundings of 6e-8, a hundred of them, added up over the series */
  const double slack = 3e-5, direct = ALBEDO / PI;
  totals first = {0.0, 0.0}, tenth = first, last = first;
  setup s;
  start_box(&s, feedback, facing);
  for (int i = 0; i < BOUNCES; ++i) {
    exact_planes out = frame_outputs(&s);
    assert_true(largest_value(&out, EXACT_BEAUTY, 3) <=
                direct / (1.0 - ALBEDO) * (1.0 + slack));
    last = totals_of(&out);
    first = i == 0 ? last : first;
    tenth = i == 9 ? last : tenth;
    exact_planes_free(&out);
  }
  /* Measured: .011, .011 and .002.  Dumps, which reflect less, stay within 1 %
   * (hbil-bench truth). */
  check_at_most("all light after the tenth frame",
                fabs(last.all / tenth.all - 1.0), 1.5e-2);
  /* Measured: .12; the lamp's light is far from even after one bounce, of which
   * near light knows .33.  Dumps: .02 and less (hbil-bench truth).  Light that
   * back-facing samples block is guessed bounce by bounce. */
  if (facing <= -1.0f)
    check_at_most("guessed light after the first",
                  fabs(first.far / last.far - 1.0), 0.15);
  setup_free(&s);
}

TEST(light_does_not_grow_from_frame_to_frame) {
  check_energy(HBIL_FEEDBACK_IRRADIANCE, -1.0f);
  check_energy(HBIL_FEEDBACK_RADIANCE, -1.0f);
  check_energy(HBIL_FEEDBACK_IRRADIANCE, 0.9f);
}

/* Surfaces that reflect 0.6 and emit 0.4, everywhere: the radiance is 1 after
 * all bounces, and a first frame's guess has it. */
TEST(a_furnace_is_closed_in_the_first_frame) {
  setup s;
  exact_planes out;
  double range[2];
  start_random(&s, 0.4f);
  for (int c = 0; c < 3; ++c)
    setup_fill(&s, EXACT_ALBEDO + c, 0.6f);
  /* near light must not contain guessed light */
  s.config.model.facing_fade[0] = s.config.model.facing_fade[1] = -1.0f;
  out = first_outputs(&s);
  estimate_range(&out, range);
  check_at_most("furnace", fmax(range[1] - 1.0, 1.0 - range[0]), 1e-5);
  exact_planes_free(&out);
  setup_free(&s);
}

/* One pixel of a million times the light of all others counts as at most
 * HBIL_UNSEEN_SPIKE parts of the picture. */
TEST(a_bright_pixel_does_not_light_everything) {
  setup s;
  exact_planes dark, bright;
  double range[2][2];
  int at = WIDTH * HEIGHT / 2;
  start_random(&s, 1.0f);
  s.config.model.radius = 1e-3f; /* and does not light its neighbours */
  setup_start(&s);
  while (!is_used(at % WIDTH, at / WIDTH) || s.input[EXACT_DEPTH][at] == 0.0f)
    ++at;
  dark = frame_outputs(&s);
  for (int c = 0; c < 3; ++c)
    s.input[EXACT_EMISSION + c][at] = 1e6f;
  setup_upload(&s);
  bright = frame_outputs(&s);
  estimate_range(&dark, range[0]);
  estimate_range(&bright, range[1]);
  assert_true(range[1][1] > 1.01 * range[0][1]); /* it is seen */
  /* measured: .79; surfaces that all face the eye hardly face each other, so
   * one that does weighs up to ten times as much.  A plain mean: 2,500 and
   * more. */
  check_at_most("brighter", range[1][1] / range[0][1] - 1.0, 1.0);
  planes_free(&dark, &bright);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* The output `unknown`: the share of the hemisphere whose light is a guess  */

/* A room with both kinds of guesses: its open directions, and what furniture
 * that faces away blocks. */
static void guess_unknown(setup *s, hbil_far_field far) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.model.far_field = far;
  s->config.outputs.unknown = one_float;
}

/* The share that back-facing samples block is left alone where the far field is
 * known, and the open share comes on top where it is not. */
TEST(other_far_fields_leave_back_faces_alone) {
  exact_planes behind[HBIL_FAR_FRAME + 1];
  for (hbil_far_field far = HBIL_FAR_NONE; far <= HBIL_FAR_FRAME; ++far) {
    setup s;
    guess_unknown(&s, far);
    behind[far] = first_outputs(&s);
    exact_planes resolved = stage_read(&s, HBIL_STAGE_RESOLVED);
    assert_true(largest_value(&behind[far], EXACT_UNKNOWN, 1) > 0.1);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
      const int x = i % WIDTH, y = i / WIDTH;
      const bool solid = s.input[EXACT_DEPTH][i] > 0.0f;
      const double open =
          far == HBIL_FAR_FRAME ? *exact_at(&resolved, HBIL_LIGHT_AO, x, y) : 0;
      const double want =
          open + *exact_at(&behind[HBIL_FAR_NONE], EXACT_UNKNOWN, x, y);
      /* derived: a rounding of the sum */
      assert_true(fabs(*exact_at(&behind[far], EXACT_UNKNOWN, x, y) -
                       (solid ? want : 0.0)) <= 1e-7);
    }
    exact_planes_free(&resolved);
    setup_free(&s);
  }
  for (hbil_far_field far = HBIL_FAR_NONE; far <= HBIL_FAR_FRAME; ++far)
    exact_planes_free(&behind[far]);
}

/* Light that nobody guesses: all samples count, or the fallback is another. */
TEST(without_a_guess_it_is_zero) {
  for (int i = 0; i < 3; ++i) {
    setup s;
    guess_unknown(&s, i == 2 ? HBIL_FAR_CONSTANT : HBIL_FAR_NONE);
    if (i == 1)
      s.config.model.back_facing_fallback = HBIL_FALLBACK_BLACK;
    else
      s.config.model.facing_fade[0] = s.config.model.facing_fade[1] = -1.0f;
    exact_planes out = first_outputs(&s);
    assert_true(largest_value(&out, EXACT_UNKNOWN, 1) == 0.0);
    exact_planes_free(&out);
    setup_free(&s);
  }
}

/* All of the box has radiance 1. */
static void white_box(setup *s, hbil_back_facing_fallback fallback) {
  setup_init(s, WIDTH, HEIGHT);
  load_box(s);
  s->config.outputs.unknown = one_float;
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
  s->config.inputs.albedo.component = s->config.inputs.direct.component =
      HBIL_NONE;
  s->config.model.back_facing_fallback = fallback;
  s->config.model.far_field = HBIL_FAR_FRAME;
  s->config.model.facing_fade[1] = 0.9f; /* no face of a box faces away */
  for (int c = 0; c < 3; ++c)
    setup_fill(s, EXACT_EMISSION + c, 1.0f);
}

/* A black fallback leaves of the light what the screen shows: E_near / pi is
 * the share of the hemisphere that it comes from.  In a closed box the rest is
 * a guess. */
TEST(in_a_closed_box_all_is_known_or_unknown) {
  setup guessing, black;
  double worst = 0.0, behind = 0.0;
  white_box(&guessing, HBIL_FALLBACK_FRAME_MEAN);
  white_box(&black, HBIL_FALLBACK_BLACK);
  exact_planes guess = first_outputs(&guessing), known = first_outputs(&black);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    const int x = i % WIDTH, y = i / WIDTH;
    const double unknown = *exact_at(&guess, EXACT_UNKNOWN, x, y);
    const double shown = *exact_at(&known, EXACT_NEAR_IRRADIANCE, x, y) / PI;
    worst = fmax(worst, fabs(unknown + shown - 1.0));
    behind = fmax(behind, unknown - *exact_at(&guess, EXACT_AO, x, y));
  }
  assert_true(behind > 0.1); /* both parts are there */
  /* measured: 2.9e-7, as in the white furnace of test_estimate */
  check_at_most("known + unknown", worst, 1e-5);
  planes_free(&guess, &known);
  setup_free(&guessing);
  setup_free(&black);
}

static cl_uint resolved_values(const hbil_config *config) {
  hbil_plan *plan;
  hbil_buffer resolved;
  assert_int_equal(hbil_plan_create(shared_device.hbil, config, &plan),
                   HBIL_SUCCESS);
  assert_int_equal(hbil_plan_buffer(plan, HBIL_STAGE_RESOLVED, &resolved),
                   HBIL_SUCCESS);
  hbil_plan_destroy(plan);
  return resolved.values;
}

/* A plane of its own is for the share behind back faces, and only if it can be
 * something else than 0. */
TEST(plans_without_it_store_nothing) {
  setup s;
  guess_unknown(&s, HBIL_FAR_FRAME);
  assert_int_equal(resolved_values(&s.config), HBIL_LIGHT_PLANES + 1);
  s.config.outputs.unknown.component = HBIL_NONE;
  const size_t without = setup_memory(&s);
  assert_int_equal(resolved_values(&s.config), HBIL_LIGHT_PLANES);
  s.config.outputs.unknown = one_float;
  assert_true(setup_memory(&s) > without);
  s.config.model.facing_fade[0] = s.config.model.facing_fade[1] = -1.0f;
  const size_t with = setup_memory(&s);
  assert_int_equal(resolved_values(&s.config), HBIL_LIGHT_PLANES);
  s.config.outputs.unknown.component = HBIL_NONE;
  assert_int_equal(setup_memory(&s), with);
  setup_free(&s);
}

/* Alone it is the same as with other outputs. */
TEST(it_can_be_had_alone) {
  for (int i = 0; i < 2; ++i) {
    setup s, alone;
    guess_unknown(&s, i ? HBIL_FAR_FRAME : HBIL_FAR_NONE);
    setup_all_outputs(&s);
    guess_unknown(&alone, i ? HBIL_FAR_FRAME : HBIL_FAR_NONE);
    setup_no_outputs(&alone);
    alone.config.outputs.unknown = one_float;
    exact_planes want = first_outputs(&s), got = first_outputs(&alone);
    assert_true(largest_error(&got, &want, EXACT_UNKNOWN, 1) == 0.0);
    planes_free(&want, &got);
    setup_free(&s);
    setup_free(&alone);
  }
}
