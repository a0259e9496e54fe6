/*
 * Probes, their filter and the light that composite takes from them match the
 * exact passes, on what the device had before.  Closed forms of that light.
 */
#include "test/support/lit_frame.h"
#include "test/support/random.h"
#include "test/support/shim.h"
#include "test/support/stages.h"

#include "exact/camera.h"
#include "exact/far_field.h"
#include "exact/input.h"

/* ------------------------------------------------------------------------ */
/* Probes and their filter                                                   */

/* Rays that end elsewhere (test_cache_rays), or whose ends another pixel of the
 * frame shows, change a probe.  Measured: 2.0 %, of probes of 32 to 128
 * rays. */
#define MOST_DIFFERENT 0.03

static void check_probes(lit_frame *l, const exact_planes *split) {
  const exact_probes got = lit_probes(&l->s, "filter_probes", 1);
  exact_probes want = lit_no_probes(&l->s);
  int valid = 0, inside = 0, different = 0, known = 0, unknown = 0, told = 0;
  exact_make_probes(&l->s.job, &l->cache, split, &want);
  for (int i = 0; i < got.count; ++i) {
    const exact_probe *p = want.probe + i;
    double off[3];
    probe_difference(got.probe + i, p, off);
    valid += p->valid;
    if (!same_place(&got, i, p)) {
      ++different;
      continue;
    }
    inside += p->valid && i / got.columns % 2;
    different += !(off[1] <= 3e-6 && off[2] <= 2e-5);
    known += p->known[0] > 0.0;
    unknown += p->unknown[0] > 0.0;
    told += p->guess[3] > 0.0;
  }
  assert_true(valid > 50 && inside > 10 && known > valid / 4 &&
              unknown > valid / 4);
  /* areas are asked where the frame is the far field */
  assert_true(l->s.config.model.far_field == HBIL_FAR_FRAME ? told > 5
                                                            : told == 0);
  check_at_most("probes that differ", different / (double)valid,
                MOST_DIFFERENT);
  exact_probes_free((exact_probes *)&got);
  exact_probes_free(&want);
}

static void check_filter(lit_frame *l) {
  const exact_probes made = lit_probes(&l->s, "filter_probes", 1);
  const exact_probes got = lit_probes(&l->s, "filter_probes", 2);
  exact_probes want = lit_no_probes(&l->s);
  double worst[3] = {0.0, 0.0, 0.0};
  exact_filter_probes(&l->s.job, &made, &want);
  for (int i = 0; i < got.count; ++i) {
    double off[3];
    assert_int_equal(got.probe[i].valid, want.probe[i].valid);
    probe_difference(got.probe + i, want.probe + i, off);
    for (int k = 0; k < 3; ++k)
      worst[k] = fmax(worst[k], off[k]);
  }
  /* measured: 2.2e-7 and 2.9e-7 */
  check_at_most("filtered: places", worst[0], 0.0);
  check_at_most("filtered: shares", worst[1], 1e-6);
  check_at_most("filtered: light", worst[2], 1e-6);
  exact_probes_free((exact_probes *)&made);
  exact_probes_free((exact_probes *)&got);
  exact_probes_free(&want);
}

/* Most of what is unseen becomes sky, all but slabs.  Then areas tell of the
 * rest, and all the less, the more rays go to the sky. */
static void see_sky(lit_frame *l) {
  const int n = (int)l->f.config.voxels;
  hbil_cache_update none = cache_bounces(0);
  size_t bytes;
  unsigned char *states = cache_read(CACHE_STATES, &bytes);
  for (size_t i = 0; i < 4 * bytes; ++i) {
    const int shift = 2 * (int)(i % 4);
    const bool unseen = (states[i / 4] >> shift & 3) == HBIL_VOXEL_UNKNOWN;
    if (unseen && (int)(i / (size_t)n % (size_t)n) % 16 < 15)
      states[i / 4] |= (unsigned char)(HBIL_VOXEL_SKY << shift);
  }
  buffer_write(&shared_device, cache_memory(CACHE_STATES), 0, bytes, states);
  free(states);
  cache_touch(&l->f);
  cache_update(&l->f, &none);
  cache_import(&l->cache);
}

static void check_making(cl_uint width, scene_kind kind,
                         hbil_projection projection, hbil_far_field far,
                         bool under_sky) {
  lit_frame l;
  lit_prepare(&l, HBIL_CACHE_METHOD_RAYS, width, kind, projection, far);
  if (under_sky)
    see_sky(&l);
  setup_start(&l.s);
  setup_run(&l.s, enqueue_split);
  setup_run(&l.s, enqueue_composite);
  exact_planes split = stage_read(&l.s, HBIL_STAGE_SPLIT);
  check_probes(&l, &split);
  check_filter(&l);
  exact_planes_free(&split);
  lit_free(&l);
}

TEST(probes_match) {
  static const cl_uint widths[] = {1, 4, 8, 16};
  for (int i = 0; i < 4; ++i)
    check_making(widths[i], i & 1 ? SCENE_SKY : SCENE_ROOM,
                 HBIL_PROJECTION_PERSPECTIVE,
                 i == 1 ? HBIL_FAR_SH : HBIL_FAR_FRAME, i == 2);
  for (int i = 0; i < 2; ++i)
    check_making(8, SCENE_ROOM, HBIL_PROJECTION_ORTHOGRAPHIC,
                 i ? HBIL_FAR_CONSTANT : HBIL_FAR_NONE, false);
}

/* ------------------------------------------------------------------------ */
/* Their history                                                             */

static void run_to_probes(lit_frame *l) {
  setup_run(&l->s, enqueue_split);
  setup_run(&l->s, enqueue_composite);
}

/* least_followed: the share of the valid probes that have a past. */
static void check_history(lit_frame *l, const hbil_camera *before,
                          double least_followed) {
  const exact_probes made = lit_probes(&l->s, "follow_probes", 1);
  const exact_probes past = lit_probes(&l->s, "follow_probes", 2);
  const exact_probes got = lit_probes(&l->s, "follow_probes", 3);
  exact_probes want = lit_no_probes(&l->s);
  double worst = 0.0;
  int valid = 0, followed = 0, different = 0;
  exact_follow_probes(&l->s.job, before, &made, &past, &want);
  for (int i = 0; i < got.count; ++i) {
    const exact_probe *p = got.probe + i;
    double off[3];
    assert_int_equal(p->valid, want.probe[i].valid);
    if (!p->valid)
      continue;
    probe_difference(p, want.probe + i, off);
    assert_true(off[0] == 0.0);
    valid++;
    followed += p->frames > 1.0;
    /* a place may be rounded to another 256th of a pixel */
    if (fabs(p->frames - want.probe[i].frames) > 1e-3 || off[2] > 5e-5)
      different++;
    else
      worst = fmax(worst, fmax(off[1], off[2]));
  }
  assert_true(followed >= least_followed * valid);
  check_at_most("probes with another past", different / (double)valid, 0.01);
  /* measured: 2.0e-5 */
  check_at_most("followed", worst, 5e-5);
  exact_probes_free((exact_probes *)&made);
  exact_probes_free((exact_probes *)&past);
  exact_probes_free((exact_probes *)&got);
  exact_probes_free(&want);
}

static void check_following(hbil_projection projection, bool turned) {
  lit_frame l;
  lit_prepare(&l, HBIL_CACHE_METHOD_RAYS, 8, SCENE_ROOM, projection,
              HBIL_FAR_FRAME);
  setup_start(&l.s);
  run_to_probes(&l);
  for (int i = 0; i < 3; ++i) {
    const hbil_camera before = l.s.frame.camera;
    double *m = l.s.frame.camera.world_from_view;
    if (turned) {
      /* a degree about the camera's y, and some millimetres */
      const double c = cos(0.017), s = sin(0.017);
      for (int r = 0; r < 3; ++r) {
        const double x = m[4 * r], z = m[4 * r + 2];
        m[4 * r] = c * x - s * z;
        m[4 * r + 2] = s * x + c * z;
        m[4 * r + 3] += 0.004 * (r + 1);
      }
      l.s.job.camera = l.s.frame.camera;
    }
    run_to_probes(&l);
    check_history(&l, &before, turned ? 0.5 : 1.0);
  }
  lit_free(&l);
}

TEST(probes_are_followed) {
  for (int i = 0; i < 4; ++i)
    check_following(i & 1 ? HBIL_PROJECTION_ORTHOGRAPHIC
                          : HBIL_PROJECTION_PERSPECTIVE,
                    i & 2);
}

/* ------------------------------------------------------------------------ */
/* The light that the last frame hands on                                    */

/* Multiplies handed-on light by what it has fallen to; see lit_fallen(). */
static void dim(const lit_frame *l, const float ratios[HBIL_CACHE_REGIONS],
                exact_planes *carried) {
  for (int y = 0; y < LIT_HEIGHT; ++y)
    for (int x = 0; x < LIT_WIDTH; ++x)
      for (int c = 0; c < 3; ++c)
        *exact_at(carried, HBIL_CARRIED_RED + c, x, y) *=
            lit_fallen(l, ratios, x, y);
}

/* fallen: the factors that this frame finds; NULL: light has not fallen. */
static void check_handed_on(lit_frame *l, const float *fallen) {
  const bool is_static = l->s.frame.static_frame;
  const int red = is_static ? HBIL_HISTORY_RED : HBIL_CARRIED_RED;
  exact_planes light =
      stage_read(&l->s, is_static ? HBIL_STAGE_HISTORY : HBIL_STAGE_CARRIED);
  exact_planes carried, want;
  int compared = 0, lit = 0;
  double worst = 0.0, largest = 0.0;
  assert_int_equal(
      exact_planes_create(&carried, LIT_WIDTH, LIT_HEIGHT, HBIL_CARRIED_PLANES),
      EXACT_SUCCESS);
  assert_int_equal(
      exact_planes_create(&want, LIT_WIDTH, LIT_HEIGHT, HBIL_SPLIT_PLANES),
      EXACT_SUCCESS);
  for (int y = 0; y < LIT_HEIGHT; ++y)
    for (int x = 0; x < LIT_WIDTH; ++x) {
      for (int c = 0; c < 3; ++c)
        *exact_at(&carried, HBIL_CARRIED_RED + c, x, y) =
            *exact_at(&light, red + c, x, y);
      *exact_at(&carried, HBIL_CARRIED_WEIGHT, x, y) = 1.0;
    }
  if (fallen)
    dim(l, fallen, &carried);
  exact_split(&l->s.job, &carried, &want);
  setup_run(&l->s, enqueue_split);
  exact_planes got = stage_read(&l->s, HBIL_STAGE_SPLIT);
  for (int y = 0; y < LIT_HEIGHT; ++y)
    for (int x = 0; x < LIT_WIDTH; ++x)
      for (int c = 0; c < 3; ++c) {
        const double w = *exact_at(&want, HBIL_SPLIT_RED + c, x, y);
        if (isnan(w) || exact_is_sky(&l->s.job, x, y))
          continue;
        largest = fmax(largest, w);
        worst =
            fmax(worst, fabs(*exact_at(&got, HBIL_SPLIT_RED + c, x, y) - w));
        lit += *exact_at(&light, red + c, x, y) > 0.01;
        ++compared;
      }
  assert_true(compared > LIT_WIDTH * LIT_HEIGHT && lit > compared / 4);
  check_at_most("handed on", worst / largest, 2e-6); /* as split's radiance */
  planes_free(&light, &carried, &want, &got);
}

static void check_falling(cl_uint width, hbil_projection projection,
                          bool is_static) {
  float ratios[HBIL_CACHE_REGIONS];
  lit_frame l;
  lit_draw_factors(9, ratios);
  lit_prepare(&l, HBIL_CACHE_METHOD_RAYS, width, SCENE_ROOM, projection,
              HBIL_FAR_FRAME);
  l.s.config.sampling.storage = HBIL_STORAGE_FLOAT32;
  setup_start(&l.s);
  setup_run(&l.s, hbil_enqueue_frame);
  l.s.frame.static_frame = is_static;
  hbil_cache_update none = cache_bounces(0);
  for (int i = 0; i < 4; ++i) {
    /* Frames behind an update; behind none; behind one more, without new views;
     * behind a reset. */
    if (i != 1)
      lit_fall(&l, ratios);
    if (i == 2)
      cache_update(&l.f, &none);
    if (i == 3)
      assert_success(&l.s, hbil_enqueue_cache_reset(
                               l.f.cache, shared_device.queue, 0, NULL, NULL));
    setup_run(&l.s, enqueue_reproject);
    setup_run(&l.s, enqueue_push_pull);
    check_handed_on(&l, i ? NULL : ratios);
    setup_run(&l.s, enqueue_gather);
    setup_run(&l.s, enqueue_recompose);
    setup_run(&l.s, enqueue_composite);
  }
  lit_free(&l);
}

TEST(handed_on_light_falls) {
  static const cl_uint widths[] = {1, 4, 8, 16};
  for (int i = 0; i < 4; ++i)
    check_falling(widths[i],
                  i == 2 ? HBIL_PROJECTION_ORTHOGRAPHIC
                         : HBIL_PROJECTION_PERSPECTIVE,
                  i == 3);
}

/* ------------------------------------------------------------------------ */
/* The light of probes in composite                                          */

/* Functions whose means are far from 0, with colours of their own.  Every
 * eleventh probe is of no surface, every thirteenth knows nothing, and at the
 * picture's first corner none tells anything. */
static void plant_probes(lit_frame *l, exact_probes *probes) {
  random_state r = {5};
  cl_mem buffer;
  const int count = probes->count;
  float *values = calloc((size_t)count * HBIL_PROBE_FLOATS, sizeof *values);
  assert_non_null(values);
  for (int i = 0; i < count; ++i) {
    float *v = values + HBIL_PROBE_FLOATS * i;
    exact_probe *p = probes->probe + i;
    p->valid = p->valid && i % 11 != 0;
    const bool none = i / probes->columns < 3 && i % probes->columns < 3;
    for (int k = 0; k < 4; ++k) {
      const double known =
          k ? 0.4 * random_unit(&r) - 0.2 : 0.3 + 0.5 * random_unit(&r);
      const double unknown =
          k ? 0.3 * random_unit(&r) - 0.15 : 0.2 + 0.3 * random_unit(&r);
      p->known[k] = none || i % 13 == 0 ? 0.0 : (double)(float)known;
      p->unknown[k] = none ? 0.0 : (double)(float)unknown;
      for (int c = 0; c < 3; ++c)
        p->light[c][k] =
            (double)(float)(p->known[k] * (1.0 + c) * random_unit(&r));
    }
    /* radiance that is told of a part of the unknown rays */
    for (int k = 3; k >= 0; --k)
      p->guess[k] = (double)(float)((k < 3 ? p->guess[3] : p->unknown[0]) *
                                    (k < 3 ? 1.0 + k : 1.0) * random_unit(&r));
    v[HBIL_PROBE_VALID] = p->valid;
    const double place[6] = {p->place.x,  p->place.y,  p->place.z,
                             p->normal.x, p->normal.y, p->normal.z};
    for (int c = 0; c < 3; ++c) {
      v[HBIL_PROBE_POSITION + c] = (float)place[c];
      v[HBIL_PROBE_NORMAL + c] = (float)place[3 + c];
    }
    for (int k = 0; k < 4; ++k) {
      v[HBIL_PROBE_KNOWN + k] = (float)p->known[k];
      v[HBIL_PROBE_UNKNOWN + k] = (float)p->unknown[k];
      v[HBIL_PROBE_GUESS + k] = (float)p->guess[k];
      for (int c = 0; c < 3; ++c)
        v[HBIL_PROBE_LIGHT + 4 * c + k] = (float)p->light[c][k];
    }
  }
  /* that which the next frame writes */
  shim_argument("follow_probes", 2, sizeof buffer, &buffer);
  buffer_write(&l->device, buffer, 0,
               sizeof *values * HBIL_PROBE_FLOATS * (size_t)count, values);
  free(values);
}

/* Light of a real gather, but some pixels are all open or all closed. */
static void plant_ao(lit_frame *l, exact_planes *resolved) {
  for (int i = 0; i < LIT_WIDTH * LIT_HEIGHT; i += 17)
    if (l->s.input[EXACT_DEPTH][i] > 0.0f)
      *exact_at(resolved, HBIL_LIGHT_AO, i % LIT_WIDTH, i / LIT_WIDTH) = i % 2;
  stage_write(&l->s, HBIL_STAGE_RESOLVED, resolved);
}

/* Derived: some thirty roundings, of which few are of the largest values.
 * Measured: 4.2e-7 */
static void check_outputs(const exact_planes *got, const exact_planes *want) {
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id) {
    const int first = plane_first(id), count = plane_channels(id);
    check_at_most(plane_name(id), largest_error(got, want, first, count),
                  3e-6 * largest_value(want, first, count));
  }
}

/* Composite alone runs, on probes of the test. */
static void check_join(cl_uint width, hbil_far_field far,
                       hbil_projection projection, bool planted) {
  lit_frame l;
  lit_prepare(&l, HBIL_CACHE_METHOD_RAYS, width, SCENE_SKY, projection, far);
  setup_start(&l.s);
  setup_run(&l.s, enqueue_split);
  setup_run(&l.s, enqueue_gather);
  setup_run(&l.s, enqueue_recompose);
  exact_planes split = stage_read(&l.s, HBIL_STAGE_SPLIT);
  exact_planes gathered = stage_read(&l.s, HBIL_STAGE_GATHERED);
  exact_planes resolved = stage_read(&l.s, HBIL_STAGE_RESOLVED);
  exact_planes want =
      checked_planes(LIT_WIDTH, LIT_HEIGHT, EXACT_OUTPUT_PLANES);
  exact_planes history =
      checked_planes(LIT_WIDTH, LIT_HEIGHT, HBIL_HISTORY_PLANES);
  plant_ao(&l, &resolved);
  setup_run(&l.s, enqueue_composite);
  exact_probes probes = lit_probes(&l.s, "composite", 19);
  if (planted) {
    plant_probes(&l, &probes);
    shim_launch_only("composite");
    setup_run(&l.s, enqueue_composite);
    shim_launch_only(NULL);
  }
  exact_planes got = outputs_read(&l.s);
  exact_estimate_frame(&l.s.job, &split, &gathered);
  l.s.job.probes = &probes;
  exact_composite(&l.s.job, &resolved, &want, &history);
  check_outputs(&got, &want);
  exact_probes_free(&probes);
  planes_free(&split, &gathered, &resolved, &want, &history, &got);
  lit_free(&l);
}

TEST(light_of_probes_matches) {
  static const cl_uint widths[] = {1, 4, 8, 16};
  for (int i = 0; i < 4; ++i)
    check_join(widths[i], (hbil_far_field)(3 - i), HBIL_PROJECTION_PERSPECTIVE,
               true);
  check_join(8, HBIL_FAR_FRAME, HBIL_PROJECTION_PERSPECTIVE, false);
  check_join(8, HBIL_FAR_FRAME, HBIL_PROJECTION_ORTHOGRAPHIC, true);
}

/* ------------------------------------------------------------------------ */
/* Closed forms                                                              */

/* The cosine-weighted integrals of 1 and of the direction over a cone about b,
 * over pi, are the open share and the open share times the mean direction. */
TEST(the_mean_direction_is_that_of_a_cone) {
  enum { POLAR = 2000, AZIMUTHS = 64 };
  const vec3 b = vec_normalize(vec(0.3, -0.7, 0.4));
  double worst = 0.0;
  for (int k = 0; k <= 20; ++k) {
    const double t = k / 20.0, ao = 1.0 - t * t;
    double sum[4] = {0.0, 0.0, 0.0, 0.0}, mean[4];
    for (int i = 0; i < POLAR * AZIMUTHS && k < 20; ++i) {
      /* equal steps of the height are equal solid angles */
      const double z = t + (1.0 - t) * (i / AZIMUTHS + 0.5) / POLAR;
      const vec3 w =
          exact_about_normal(b, z, (i % AZIMUTHS) / (double)AZIMUTHS);
      const double share = 2.0 * (1.0 - t) * z / (POLAR * AZIMUTHS);
      const double f[4] = {1.0, w.x, w.y, w.z};
      for (int c = 0; c < 4; ++c)
        sum[c] += share * f[c];
    }
    exact_open_mean(ao, b, mean);
    for (int c = 0; c < 4; ++c)
      worst = fmax(worst, fabs(ao * mean[c] - sum[c]));
  }
  /* the middles of steps of the height: measured 3.4e-8 */
  check_at_most("open mean", worst, 1e-7);
}

/* An even field that all is known of sends pi AO L, whatever the directions. */
TEST(an_even_known_field_sends_pi_ao_l) {
  const double colour[3] = {0.5, 2.0, 7.0};
  for (int far = HBIL_FAR_NONE; far <= HBIL_FAR_FRAME; ++far) {
    setup s;
    exact_probes probes;
    double worst = 0.0;
    setup_scene(&s, SCENE_ROOM, 45, 31, 0);
    setup_all_outputs(&s);
    s.config.model.far_field = (hbil_far_field)far;
    lit_environment(&s);
    shim_skip_builds(true);
    setup_start(&s);
    shim_skip_builds(false);
    assert_int_equal(exact_probes_create(&probes, &s.config), EXACT_SUCCESS);
    for (int i = 0; i < probes.count; ++i) {
      exact_probe *p = probes.probe + i;
      p->valid = true;
      p->place = vec(0.1 * i, 0.0, 1.0 + i);
      p->normal = vec(0.0, 0.0, -1.0);
      p->known[0] = 1.0;
      for (int c = 0; c < 3; ++c)
        p->light[c][0] = colour[c];
    }
    s.job.probes = &probes;
    for (int i = 0; i < 45 * 31; ++i) {
      const double ao = (i % 11) / 10.0;
      const vec3 bent = vec_normalize(vec(i % 5 - 2.0, i % 7 - 3.0, -1.0));
      if (!(s.input[EXACT_DEPTH][i] > 0.0f))
        continue;
      const exact_probe_light cached =
          exact_light_of_probes(&s.job, i % 45, i / 45, ao, bent);
      for (int c = 0; c < 3; ++c)
        worst = fmax(worst, fabs(exact_far_irradiance(&s.job, c, i % 45, i / 45,
                                                      ao, bent, 1.0, &cached) /
                                     (PI * colour[c]) -
                                 ao));
    }
    check_at_most("even field", worst, 1e-14);
    exact_probes_free(&probes);
    setup_free(&s);
  }
}
