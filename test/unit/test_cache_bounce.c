/*
 * Light between the cache's surfaces matches the exact passes, on what the
 * device had before: what voxels send, its mean, and rounds of bounces.
 */
#include "test/support/cache.h"
#include "test/support/packing.h"
#include "test/support/shim.h"

/* --- what voxels send, and the mean --- */

static void check_radiance(const exact_cache *cache) {
  double worst = 0.0;
  for (size_t i = 0; i < exact_cache_count(cache); ++i) {
    const exact_place place = exact_cache_place(cache, i);
    const exact_voxel *got = exact_cache_at(cache, &place);
    exact_voxel want = *got;
    if (got->state != HBIL_VOXEL_SURFACE)
      continue;
    exact_cache_publish(&want);
    const double *l = want.radiance;
    const double unit = packed_unit(fmax(l[0], fmax(l[1], l[2])), 8);
    for (int c = 0; c < 3 && unit > 0.0; ++c)
      worst = fmax(worst, fabs(got->radiance[c] - l[c]) / unit);
  }
  /* derived: half a step of a mantissa, and a few roundings of what is 255
   * steps at most */
  check_at_most("radiance, in steps", worst, 0.5 + 1e-4);
}

static exact_cache_mean read_mean(void) {
  float *means = cache_read(CACHE_MEANS, NULL);
  exact_cache_mean mean = {{0.0, 0.0, 0.0}, (double)means[3]};
  for (int c = 0; c < 3; ++c)
    mean.radiance[c] = (double)means[c];
  free(means);
  return mean;
}

static void check_mean(const exact_cache *cache) {
  const exact_cache_mean got = read_mean(), want = exact_cache_mean_of(cache);
  /* measured: 8e-8; sums of a few thousand voxels in 64 parts */
  for (int c = 0; c < 3; ++c)
    check_at_most("mean", fabs(got.radiance[c] / want.radiance[c] - 1.0), 5e-7);
  check_at_most("mean unlit part", fabs(got.unlit - want.unlit), 5e-7);
}

/* --- rounds --- */

/* Rays that end elsewhere than the exact ones change a voxel, and of those
 * there are 1.9e-4 (test_cache_rays). */
#define MOST_DIFFERENT(rays) (6e-4 * (rays))

static bool agrees(const exact_voxel *got, const exact_voxel *want) {
  for (int c = 0; c < 3; ++c) {
    const int k = HBIL_VOXEL_INDIRECT + c;
    if (!(fabs(got->value[k] - want->value[k]) <=
          1e-5 * fmax(want->value[k], 1e-2)))
      return false;
  }
  /* a code is half a step of 254 off at most */
  return (got->unlit < 0.0) == (want->unlit < 0.0) &&
         fabs(got->unlit - want->unlit) <= 0.5 / 254.0 + 1e-5;
}

/* Everything but indirect light and the unlit part is as before, and so are
 * voxels that the round leaves out. */
static void check_rest(const exact_voxel *got, const exact_voxel *want) {
  assert_int_equal(got->state, want->state);
  for (int k = 0; k < HBIL_VOXEL_FLOATS; ++k)
    if (k < HBIL_VOXEL_INDIRECT || k == HBIL_VOXEL_ROUNDS)
      assert_true(got->value[k] == want->value[k]);
}

static void check_round(cache_fixture *f, exact_cache *cache,
                        const hbil_cache_update *update) {
  exact_cache want = checked_cache(f), before = checked_cache(f);
  hbil_cache_bounce_args args;
  int surfaces = 0, different = 0;
  memcpy(before.middle, cache->middle, sizeof before.middle);
  memcpy(want.middle, cache->middle, sizeof want.middle);
  cache_import(&before);
  cache_import(&want);
  const exact_cache_mean mean = read_mean();
  cache_update(f, update);
  shim_argument("bounce", 0, sizeof args, &args);
  cache_import(cache);
  exact_cache_bounce(&before, update, (double)f->config.unseen_light,
                     args.round, &mean, &want);
  for (size_t i = 0; i < exact_cache_count(cache); ++i) {
    const exact_place place = exact_cache_place(cache, i);
    const exact_voxel *to = exact_cache_at(&want, &place);
    const exact_voxel *got = exact_cache_at(cache, &place);
    if (to->state != HBIL_VOXEL_SURFACE)
      continue;
    check_rest(got, to);
    surfaces += i % update->share == args.round % update->share;
    different += !agrees(got, to);
  }
  assert_true(surfaces > 300);
  check_at_most("voxels that differ", different / (double)surfaces,
                MOST_DIFFERENT(update->rays));
  check_radiance(cache);
  check_mean(cache);
  exact_cache_free(&want);
  exact_cache_free(&before);
}

/* A clear sky above, with some of every order. */
static void set_environment(hbil_cache_update *update) {
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      update->environment[i][c] =
          i ? 0.15f * (float)((5 * i + 3 * c) % 7 - 3) : 1.0f + 0.5f * (float)c;
}

static void check_rounds(cl_uint width, scene_kind kind, hbil_view_light light,
                         hbil_far_field far, int rounds) {
  cache_fixture f;
  setup s;
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  cache_prepare(&f, width);
  exact_cache cache = checked_cache(&f);
  cache_fill(&f, &cache, kind, light, &s);
  update.rounds = 0;
  cache_update(&f, &update);
  cache_import(&cache);
  check_radiance(&cache);
  check_mean(&cache);
  update.rounds = 1;
  update.far_field = far;
  set_environment(&update);
  for (int i = 0; i < rounds; ++i) {
    update.rays = i == 1 ? 5 : 16;
    update.share = i == 2 ? 3 : 1;
    check_round(&f, &cache, &update);
  }
  setup_free(&s);
  cache_free(&f);
  exact_cache_free(&cache);
}

static void rounds_match_at_every_width(void **state) {
  static const cl_uint widths[] = {1, 4, 8, 16};
  (void)state;
  for (int i = 0; i < 4; ++i)
    check_rounds(widths[i], SCENE_ROOM, HBIL_VIEW_DIRECT, HBIL_FAR_NONE, 3);
}

static void rounds_match_with_every_far_field(void **state) {
  (void)state;
  for (int far = HBIL_FAR_CONSTANT; far <= HBIL_FAR_FRAME; ++far)
    check_rounds(8, SCENE_SKY, HBIL_VIEW_DIRECT, (hbil_far_field)far, 6);
}

static void finished_radiance_is_sent_as_it_is(void **state) {
  (void)state;
  check_rounds(8, SCENE_ROOM, HBIL_VIEW_FINISHED, HBIL_FAR_NONE, 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rounds_match_at_every_width),
      cmocka_unit_test(rounds_match_with_every_far_field),
      cmocka_unit_test(finished_radiance_is_sent_as_it_is)};
  return RUN_WITH_DEVICE(tests);
}
