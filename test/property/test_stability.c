/*
 * Results don't depend on the unit of length, planes hide nothing through any
 * camera, light in a closed room neither grows nor fades over many frames, and
 * a long sequence takes no memory.
 */
#define _DEFAULT_SOURCE /* mallinfo2 */
#include "test/support/contents.h"
#include "test/support/stress.h"

#include <malloc.h>

/* ------------------------------------------------------------------------ */
/* Scale                                                                     */

/* Two frames of the room, in units of 1/scale. */
static exact_planes room_scaled(plan_kind kind, double scale) {
  setup *s = stress_begin(kind);
  for (uint32_t i = 0; i < 2; ++i) {
    stress_load_room(s, i);
    for (int c = 0; c < 3; ++c)
      s->frame.camera.world_from_view[4 * c + 3] *= scale;
    for (int p = 0; p < PIXELS; ++p)
      s->input[EXACT_DEPTH][p] = (float)(s->input[EXACT_DEPTH][p] * scale);
    s->frame.environment[0][0] = 1.0f;
    stress_run(s);
  }
  check_sane(s);
  return outputs_read(s);
}

TEST(the_unit_of_length_does_not_matter) {
  /* powers of ten, whose depths are rounded anew */
  const double scales[] = {1e-6, 1e-3, 1e3, 1e6, 1e9};
  for (plan_kind kind = 0; kind < PLANS; ++kind) {
    if (!stress_tries(kind))
      continue;
    exact_planes want = room_scaled(kind, 1.0);
    for (size_t i = 0; i < sizeof scales / sizeof *scales; ++i) {
      STRESS_CASE("scale %g, %s", scales[i], stress_plan_names[kind]);
      exact_planes got = room_scaled(kind, scales[i]);
      for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
        check_case(
            plane_name(id),
            relative_rmse(&got, &want, plane_first(id), plane_channels(id)),
            id == PLANE_CONE ? 1e-3 : 1e-4);
      exact_planes_free(&got);
    }
    exact_planes_free(&want);
  }
}

/* ------------------------------------------------------------------------ */
/* Planes                                                                    */

static const double tilts[] = {0.0, 30.0, 60.0, 80.0, 85.0, 89.0, 89.9};
#define TILTS (sizeof tilts / sizeof *tilts)

/* The largest occlusion of the surface, and the most light. */
typedef struct openness {
  double closed, light;
} openness;

static openness openness_of(setup *s) {
  exact_planes out = outputs_read(s);
  openness worst = {0.0, 0.0};
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      worst.closed = fmax(worst.closed, 1.0 - *exact_at(&out, EXACT_AO, x, y));
      worst.light =
          fmax(worst.light, *exact_at(&out, EXACT_NEAR_IRRADIANCE, x, y));
    }
  exact_planes_free(&out);
  return worst;
}

TEST(planes_hide_nothing_at_any_tilt) {
  for (plan_kind kind = 0; kind < PLANS; ++kind)
    for (size_t i = 0; i < VIEWS * TILTS && stress_tries(kind); ++i) {
      setup *s = stress_begin(kind);
      const camera_view *v = &views[i / TILTS];
      STRESS_CASE(
          "%s, tilt %g, field of view %g, off centre %g, %g, pixels 1 : %g",
          stress_plan_names[kind], tilts[i % TILTS], v->fov, v->off_x, v->off_y,
          v->pixel);
      set_view(s, v);
      load_plane(s, tilts[i % TILTS], 0.4 + 1.3 * (double)i);
      stress_run(s);
      check_sane(s);
      const openness found = openness_of(s);
      /* as in test_plane.c; measured: 3.6e-7, 0 */
      check_case("1 - AO", found.closed, 1e-5);
      check_case("E_near", found.light, 1e-5);
    }
}

TEST(half_float_depth_hides_little) {
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  stress_one_sample(&s);
  s.config.sampling.slices = 2;
  s.config.sampling.steps_per_side = 8;
  s.config.sampling.storage = HBIL_STORAGE_PACKED;
  s.config.inputs.depth.component = HBIL_FLOAT16;
  setup_start(&s);
  for (size_t i = 0; i < VIEWS * TILTS; ++i) {
    const camera_view *v = &views[i / TILTS];
    STRESS_CASE(
        "half depth, tilt %g, field of view %g, off centre %g, %g, pixels 1 : "
        "%g",
        tilts[i % TILTS], v->fov, v->off_x, v->off_y, v->pixel);
    set_view(&s, v);
    load_plane(&s, tilts[i % TILTS], 0.4 + 1.3 * (double)i);
    stress_run(&s);
    check_sane(&s);
    check_case("1 - AO", openness_of(&s).closed, 0.02);
  }
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Feedback                                                                  */

/* Light of the room's surfaces, in units of 1: mean, least, most. */
typedef struct evenness {
  double mean, least, most;
} evenness;

static evenness evenness_of(setup *s) {
  exact_planes out = outputs_read(s);
  evenness e = {0.0, INFINITY, 0.0};
  double count = 0.0;
  for (int i = 0; i < 3 * PIXELS; ++i)
    if (s->input[EXACT_DEPTH][i % PIXELS] > 0.0f) {
      const double light = (out.values[EXACT_NEAR_IRRADIANCE * PIXELS + i] +
                            out.values[EXACT_FAR_IRRADIANCE * PIXELS + i]) /
                           PI;
      e.mean += light;
      e.least = fmin(e.least, light);
      e.most = fmax(e.most, light);
      count += 1.0;
    }
  e.mean /= count;
  exact_planes_free(&out);
  return e;
}

/* A furnace: surfaces that reflect 7/8 have the radiance 1 if direct light
 * gives the rest. Unseen surfaces have the frame's mean after all bounces,
 * which is 1, so light neither enters nor leaves. Near light starts at the
 * direct light's 1/8 and needs some hundred bounces to get there: (7/8)^128 =
 * 2^-24. Packed light is off by up to a step of its 8 bits, 2^-7, and by less
 * on average; fp32 by about two hundred roundings (measured: 5.8e-7). The mean
 * can drift by one rounding of 2^-24 in each of the 70 frames in between
 * (measured: 2.5e-9). */
TEST(light_neither_grows_nor_fades) {
  for (plan_kind kind = 0; kind < PLANS; ++kind) {
    if ((kind != PLAIN_ESTIMATE && kind != PACKED_ESTIMATE) ||
        !stress_tries(kind))
      continue;
    const double step = stress_is_packed(kind) ? 0x1p-7 : 2e-5;
    setup *s = stress_begin(kind);
    evenness early = {0};
    STRESS_CASE("200 frames of a furnace, %s", stress_plan_names[kind]);
    for (int p = EXACT_ALBEDO; p < EXACT_MOTION + 2; ++p)
      setup_fill(s, p, p < EXACT_F0 ? 0.875f : 0.0f);
    for (int c = 0; c < 3; ++c)
      setup_fill(s, EXACT_DIRECT + c, (float)(PI / 7.0));
    for (int i = 0; i < 200; ++i) {
      s->frame.frame_index = (cl_uint)i;
      stress_run(s);
      if (i == 130)
        early = evenness_of(s);
    }
    const evenness late = evenness_of(s);
    check_case("light that was lost", 1.0 - late.least, 2.0 * step);
    check_case("light that was made", late.most - 1.0, step);
    check_case("drift of the mean", fabs(late.mean - early.mean),
               stress_is_packed(kind) ? 0.25 * step : 70 * 0x1p-24);
  }
}

/* A single event that is never released would take 200 bytes in each frame. */
TEST(long_sequences_take_no_memory) {
  const int frames = stress_effort.seconds > 0.0 ? 10000 : 600;
  size_t before = 0;
  setup *s = stress_begin(PACKED_ESTIMATE);
  for (int i = 0; i < frames; ++i) {
    if (i == 100)
      before = mallinfo2().uordblks;
    s->frame.frame_index = (cl_uint)i;
    for (int c = 0; c < 3; ++c)
      s->frame.camera.world_from_view[4 * c + 3] += 0.01 * sin(0.1 * i + c);
    setup_run(s, hbil_enqueue_frame);
  }
  STRESS_CASE("%d frames", frames);
  check_case("bytes that stay allocated",
             (double)mallinfo2().uordblks - (double)before, 65536.0);
  check_sane(s);
}
