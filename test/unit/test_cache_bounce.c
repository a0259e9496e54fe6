/*
 * Light between the cache's surfaces matches the exact passes, on what the
 * device had before: what voxels send, its mean, and bounces.
 */
#include "test/support/cache.h"
#include "test/support/packing.h"
#include "test/support/random.h"
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
    exact_cache_update_radiance(&want);
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

/* --- bounces --- */

/* Shares of rays that end elsewhere than the exact ones and so change their
 * voxel, at most: 1.9e-4 of them do (test_cache_rays), or 6e-4 in a crowd of
 * surfaces, where each ray passes by many. */
#define FEW_RAYS 6e-4
#define CROWDED_RAYS 1.2e-3

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
 * voxels that the update leaves out. */
static void check_rest(const exact_voxel *got, const exact_voxel *want) {
  assert_int_equal(got->state, want->state);
  for (int k = 0; k < HBIL_VOXEL_INDIRECT; ++k)
    assert_true(got->value[k] == want->value[k]);
}

/* An update of one round.  Returns its phase.  most: voxels that may differ, as
 * a share. */
static int check_round(cache_fixture *f, exact_cache *cache,
                       const hbil_cache_update *update, double most) {
  exact_cache want = checked_cache(f), before = checked_cache(f);
  hbil_cache_list_args args;
  int surfaces = 0, different = 0;
  memcpy(before.middle, cache->middle, sizeof before.middle);
  memcpy(want.middle, cache->middle, sizeof want.middle);
  cache_import(&before);
  cache_import(&want);
  const exact_cache_mean mean = read_mean();
  cache_update(f, update);
  shim_argument("list_parts", 0, sizeof args, &args);
  cache_import(cache);
  exact_cache_bounce(&before, update, (double)f->config.unseen_light,
                     (uint32_t)args.phase, &mean, &want);
  for (size_t i = 0; i < exact_cache_count(cache); ++i) {
    const exact_place place = exact_cache_place(cache, i);
    const exact_voxel *to = exact_cache_at(&want, &place);
    const exact_voxel *got = exact_cache_at(cache, &place);
    if (to->state != HBIL_VOXEL_SURFACE)
      continue;
    check_rest(got, to);
    surfaces += i % update->phases == (size_t)args.phase;
    different += !agrees(got, to);
  }
  assert_true(surfaces > 300);
  check_at_most("voxels that differ", different / (double)surfaces, most);
  check_radiance(cache);
  check_mean(cache);
  exact_cache_free(&want);
  exact_cache_free(&before);
  return args.phase;
}

/* A clear sky above, with some of every order. */
static void set_environment(hbil_cache_update *update) {
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      update->environment[i][c] =
          i ? 0.15f * (float)((5 * i + 3 * c) % 7 - 3) : 1.0f + 0.5f * (float)c;
}

/* A cache that two views have filled, before any bounce. */
static exact_cache filled(cache_fixture *f, cl_uint width, scene_kind kind,
                          hbil_view_light light, setup *s) {
  hbil_cache_update none;
  hbil_cache_update_init(&none);
  cache_prepare(f, width);
  exact_cache cache = checked_cache(f);
  cache_fill(f, &cache, kind, light, s);
  none.bounces = 0;
  cache_update(f, &none);
  cache_import(&cache);
  check_radiance(&cache);
  check_mean(&cache);
  return cache;
}

/* An update of all voxels, and three of a third of them each. */
static void check_rounds(cl_uint width, scene_kind kind, hbil_view_light light,
                         hbil_far_field far) {
  cache_fixture f;
  setup s;
  hbil_cache_update update;
  int phases = 0;
  hbil_cache_update_init(&update);
  exact_cache cache = filled(&f, width, kind, light, &s);
  update.bounces = 1;
  update.far_field = far;
  set_environment(&update);
  for (int i = 0; i < 4; ++i) {
    update.phases = i ? 3 : 1;
    const int phase =
        check_round(&f, &cache, &update, FEW_RAYS * HBIL_CACHE_RAYS);
    phases |= i ? 1 << phase : 0;
  }
  assert_int_equal(phases, 7);
  cache_end(&f, &s, &cache);
}

TEST(rounds_match_at_every_width) {
  static const cl_uint widths[] = {1, 4, 8, 16};
  for (int i = 0; i < 4; ++i)
    check_rounds(widths[i], SCENE_ROOM, HBIL_VIEW_DIRECT, HBIL_FAR_NONE);
}

TEST(rounds_match_with_every_far_field) {
  for (int far = HBIL_FAR_CONSTANT; far <= HBIL_FAR_FRAME; ++far)
    check_rounds(8, SCENE_SKY, HBIL_VIEW_DIRECT, (hbil_far_field)far);
}

TEST(finished_radiance_is_sent_as_it_is) {
  check_rounds(8, SCENE_ROOM, HBIL_VIEW_FINISHED, HBIL_FAR_NONE);
}

/* --- light that has changed --- */

/* What views since the last update have shown dims what they haven't, region by
 * region, as the exact pass does it. */
static void check_change(cl_uint width, float factor, double part, int views,
                         bool dims) {
  cache_fixture f;
  setup s;
  hbil_cache_update none = cache_bounces(0);
  int dimmed = 0, seen = 0;
  double worst = 0.0;
  exact_cache cache = filled(&f, width, SCENE_ROOM, HBIL_VIEW_DIRECT, &s);
  cache_inject(&f, &s, HBIL_VIEW_DIRECT);
  cache_update(&f, &none);
  for (int k = 0; k < 3; ++k)
    for (size_t i = 0; i < setup_pixels(&s); ++i)
      if ((double)(i % s.config.width) < part * (double)s.config.width) {
        s.input[EXACT_DIRECT + k][i] *= factor;
        s.input[EXACT_EMISSION + k][i] *= factor;
      }
  setup_upload(&s);
  for (int i = 0; i < views; ++i)
    cache_inject(&f, &s, HBIL_VIEW_DIRECT);
  cache_import(&cache);
  exact_cache want = checked_cache(&f);
  memcpy(want.middle, cache.middle, sizeof want.middle);
  cache_import(&want);
  exact_cache_follow_change(&want);
  cache_update(&f, &none);
  exact_cache got = checked_cache(&f);
  memcpy(got.middle, cache.middle, sizeof got.middle);
  cache_import(&got);
  for (size_t i = 0; i < exact_cache_count(&want); ++i) {
    const exact_place place = exact_cache_place(&want, i);
    const exact_voxel *w = exact_cache_at(&want, &place);
    const double *before = exact_cache_at(&cache, &place)->value;
    const double *v = exact_cache_at(&got, &place)->value;
    if (w->state != HBIL_VOXEL_SURFACE)
      continue;
    double light;
    seen += before[HBIL_VOXEL_BEFORE] != 0.0;
    if (before[HBIL_VOXEL_BEFORE] > 0.0)
      assert_int_equal(exact_voxel_before(before[HBIL_VOXEL_BEFORE], &light),
                       views < (int)HBIL_VOXEL_MOMENT_VIEWS
                           ? views
                           : (int)HBIL_VOXEL_MOMENT_VIEWS);
    dimmed += v[HBIL_VOXEL_SENT] < before[HBIL_VOXEL_SENT];
    for (int c = 0; c < HBIL_VOXEL_FLOATS; ++c)
      worst = fmax(worst, fabs(v[c] - w->value[c]) / fmax(fabs(v[c]), 1e-3));
  }
  /* a factor is a quotient of sums over some hundred voxels */
  check_at_most("dimmed light, relative", worst, 1e-5);
  assert_true(seen > 300);
  if (dims ? dimmed <= 50 : dimmed > 0)
    fail_msg("%d dimmed: %g of all by %g, %d views", dimmed, part,
             (double)factor, views);
  exact_cache_free(&got);
  exact_cache_free(&want);
  cache_end(&f, &s, &cache);
}

TEST(what_is_not_seen_follows_what_is) {
  for (int views = 1; views <= 3; ++views) {
    check_change(8, 0.0f, 1.0, views, true); /* nothing is left of what was */
    check_change(8, 0.0f, 0.95, views, true);
    check_change(8, 0.0f, 0.3, views, false); /* a patch of sun */
    check_change(8, 0.4f, 1.0, views, true);
    check_change(1, 0.4f, 1.0, views, true);
    check_change(8, 0.7f, 1.0, views, true); /* means have fallen as well */
    check_change(1, 0.7f, 1.0, views, true);
    check_change(8, 0.95f, 1.0, views, false); /* noise */
    check_change(8, 3.0f, 1.0, views, false);
  }
  check_change(8, 0.4f, 1.0, 40, true); /* more than are counted */
  check_change(8, 0.95f, 1.0, 40, false);
}

/* --- what is told --- */

static void forget(cache_fixture *f, const hbil_cache_change *change) {
  assert_int_equal(hbil_enqueue_cache_forget(f->cache, shared_device.queue,
                                             change, 0, NULL, NULL),
                   HBIL_SUCCESS);
}

/* Inside the box the kernel does what the exact pass does, to a rounding; what
 * is outside stays to the last bit. */
static void check_forgotten(hbil_view_light kind, float surfaces, float light,
                            double half) {
  cache_fixture f;
  setup s;
  int faded = 0, gone = 0, same = 0;
  exact_cache cache = filled(&f, 8, SCENE_ROOM, kind, &s);
  cache_inject(&f, &s, kind); /* whose light is compared with that before */
  cache_import(&cache);
  exact_cache want = checked_cache(&f), got = checked_cache(&f);
  memcpy(want.middle, cache.middle, sizeof want.middle);
  memcpy(got.middle, cache.middle, sizeof got.middle);
  cache_import(&want);
  hbil_cache_change change;
  hbil_cache_change_init(&change);
  change.surfaces = surfaces;
  change.light = light;
  const vec3 middle = exact_cache_to_world(&want, vec(0.3, 0.2, 0.1));
  const double at[3] = {middle.x, middle.y, middle.z};
  for (int i = 0; i < 3 && half > 0.0; ++i) {
    change.low[i] = at[i] - (i + 1) * half * f.config.voxel_size;
    change.high[i] = at[i] + 2.0 * half * f.config.voxel_size;
  }
  exact_cache_forget(&want, &change);
  forget(&f, &change);
  cache_import(&got);
  for (size_t i = 0; i < exact_cache_count(&want); ++i) {
    const exact_place place = exact_cache_place(&want, i);
    const exact_voxel *was = exact_cache_at(&cache, &place);
    const exact_voxel *w = exact_cache_at(&want, &place);
    const exact_voxel *v = exact_cache_at(&got, &place);
    assert_int_equal(v->state, w->state);
    for (int c = 0; c < HBIL_VOXEL_FLOATS; ++c)
      if (v->state == HBIL_VOXEL_SURFACE &&
          (v->value[c] != was->value[c] || c == HBIL_VOXEL_BEFORE))
        assert_true(fabs(v->value[c] - w->value[c]) <=
                    2e-7 * fabs(was->value[c]));
    /* finished radiance stays finished */
    if (v->state == HBIL_VOXEL_SURFACE)
      assert_int_equal(v->value[HBIL_VOXEL_LIGHT_WEIGHT] < 0.0,
                       was->value[HBIL_VOXEL_LIGHT_WEIGHT] < 0.0);
    gone += was->state == HBIL_VOXEL_SURFACE && v->state != was->state;
    if (v->state == HBIL_VOXEL_SURFACE && was->value[HBIL_VOXEL_WEIGHT] > 0.0)
      *(v->value[HBIL_VOXEL_WEIGHT] < was->value[HBIL_VOXEL_WEIGHT] ? &faded
                                                                    : &same) +=
          1;
  }
  assert_true(surfaces < 1.0f ? gone == 0 : gone > 50);
  assert_true(surfaces < 1.0f ? faded > 50 : faded == 0);
  assert_true(half > 0.0 ? same > 50 : same == 0);
  exact_cache_free(&got);
  exact_cache_free(&want);
  cache_end(&f, &s, &cache);
}

TEST(what_is_told_is_forgotten) {
  check_forgotten(HBIL_VIEW_DIRECT, 0.25f, 0.6f, 5.0);
  check_forgotten(HBIL_VIEW_DIRECT, 1.0f, 0.0f, 5.0);
  check_forgotten(HBIL_VIEW_FINISHED, 0.5f, 1.0f, 0.0); /* everywhere */
  check_forgotten(HBIL_VIEW_DIRECT, 1.0f, 1.0f, 0.0);
}

/* --- several bounces --- */

/* The voxels' bytes; ends all else. */
static float *take_voxels(cache_fixture *f, setup *s, exact_cache *cache,
                          size_t *bytes) {
  float *voxels = cache_read(CACHE_VOXELS, bytes);
  setup_free(s);
  cache_free(f);
  exact_cache_free(cache);
  return voxels;
}

/* What so many bounces in each of some updates leave: the voxels' bytes. */
static float *after_bounces(cl_uint bounces, int updates, size_t *bytes) {
  cache_fixture f;
  setup s;
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  exact_cache cache = filled(&f, 4, SCENE_SKY, HBIL_VIEW_DIRECT, &s);
  update.far_field = HBIL_FAR_FRAME;
  set_environment(&update);
  update.bounces = bounces;
  for (int i = 0; i < updates; ++i)
    cache_update(&f, &update);
  return take_voxels(&f, &s, &cache, bytes);
}

/* The rays of an update serve all its bounces. */
TEST(rounds_are_like_updates) {
  size_t bytes;
  float *one = after_bounces(1, 1, &bytes),
        *three = after_bounces(1, 3, &bytes);
  float *at_once = after_bounces(3, 1, &bytes);
  assert_memory_equal(at_once, three, bytes);
  assert_true(memcmp(one, three, bytes) != 0);
  free(one);
  free(three);
  free(at_once);
}

/* --- work that is left out --- */

/* Where voxels are a part of all in after_updates(). */
enum { PART = 30 };

/* Updates, with injections of the same view before the first `views` of them.
 * all: each does all its work.  Returns what voxels hold. */
static float *after_updates(int updates, int views, hbil_far_field far,
                            bool all, size_t *bytes) {
  cache_fixture f;
  setup s;
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  exact_cache cache = filled(&f, 8, SCENE_SKY, HBIL_VIEW_DIRECT, &s);
  set_environment(&update);
  for (int i = 0; i < updates; ++i) {
    if (i < views)
      cache_inject(&f, &s, HBIL_VIEW_DIRECT);
    if (all)
      cache_touch(&f);
    /* another environment, which a single update has no bounces of; and a part
     * of the voxels, behind an update without bounces and before one */
    update.far_field = i < updates / 2 ? HBIL_FAR_CONSTANT : far;
    const bool is_part = i == PART - 6 || i == PART;
    const bool is_dark = i == updates / 2 || i == PART - 6 || i == PART + 1;
    update.bounces = is_dark ? 0 : 1 + (cl_uint)i % 4;
    update.phases = is_part ? 3 : 1;
    cache_update(&f, &update);
  }
  return take_voxels(&f, &s, &cache, bytes);
}

TEST(what_is_left_out_changes_nothing) {
  static const hbil_far_field far[] = {HBIL_FAR_CONSTANT, HBIL_FAR_FRAME};
  size_t bytes;
  for (int views = 0; views < 4; views += 3)
    for (int i = 0; i < 2; ++i) {
      float *some = after_updates(40, views, far[i], false, &bytes);
      float *all = after_updates(40, views, far[i], true, &bytes);
      assert_memory_equal(some, all, bytes);
      free(some);
      free(all);
    }
}

/* Adds to the indirect light of all voxels behind the library's back, which the
 * next bounce would replace.  Returns the bytes. */
static float *spoil(size_t *bytes) {
  float *voxels = cache_read(CACHE_VOXELS, bytes);
  for (size_t i = 0; i < *bytes / sizeof *voxels; i += HBIL_VOXEL_FLOATS)
    voxels[i + HBIL_VOXEL_INDIRECT] += 1.0f;
  buffer_write(&shared_device, cache_memory(CACHE_VOXELS), 0, *bytes, voxels);
  return voxels;
}

/* Whether an update computes nothing. */
static bool rests(cache_fixture *f, const hbil_cache_update *update) {
  size_t bytes;
  float *before = spoil(&bytes);
  cache_update(f, update);
  float *after = cache_read(CACHE_VOXELS, &bytes);
  const bool same = !memcmp(before, after, bytes);
  free(before);
  free(after);
  return same;
}

/* Light at rest is left alone, until something changes. */
TEST(light_comes_to_rest) {
  cache_fixture f;
  setup s;
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  exact_cache cache = filled(&f, 8, SCENE_ROOM, HBIL_VIEW_DIRECT, &s);
  assert_false(rests(&f, &update));
  for (int i = 0; i < 30; ++i)
    cache_update(&f, &update);
  assert_true(rests(&f, &update));
  update.far_field = HBIL_FAR_CONSTANT;
  set_environment(&update);
  update.bounces = 0; /* that environment hasn't arrived with this */
  assert_true(rests(&f, &update));
  update.bounces = 4;
  assert_false(rests(&f, &update));
  for (int i = 0; i < 30; ++i)
    cache_update(&f, &update);
  assert_true(rests(&f, &update));
  cache_inject(&f, &s, HBIL_VIEW_DIRECT);
  assert_false(rests(&f, &update));
  cache_end(&f, &s, &cache);
}

/* --- rays in turn --- */

/* The list of the last update, its hits, and its turn. */
typedef struct traced {
  uint32_t *list, *hits;
  hbil_cache_trace_args args;
} traced;

static uint32_t *argument_bytes(cl_uint index) {
  size_t size;
  cl_mem buffer;
  shim_argument("trace_rays", index, sizeof buffer, &buffer);
  return (uint32_t *)buffer_bytes(&shared_device, buffer, &size);
}

/* An update of one bounce. */
static traced trace(cache_fixture *f) {
  traced t;
  hbil_cache_update update = cache_bounces(1);
  cache_update(f, &update);
  shim_argument("trace_rays", 0, sizeof t.args, &t.args);
  t.list = argument_bytes(3);
  t.hits = argument_bytes(4);
  return t;
}

static void forget_traced(traced *t) {
  free(t->list);
  free(t->hits);
}

/* The hits of a surface; NULL: it isn't listed. */
static const uint32_t *hits_of(const traced *t, uint32_t number) {
  for (uint32_t p = 0; p < t->list[0]; ++p)
    if (t->list[HBIL_LIST_HEAD + p] == number)
      return t->hits + (size_t)p * HBIL_CACHE_RAYS;
  return NULL;
}

static bool same_hits(const uint32_t *a, const uint32_t *b) {
  return a && b && !memcmp(a, b, HBIL_CACHE_RAYS * sizeof *a);
}

static bool is_surface(const uint32_t *states, uint32_t number) {
  return (states[number / 16] >> 2 * (number % 16) & 3u) == HBIL_VOXEL_SURFACE;
}

/* Empties some of the voxels that rays have hit.  Returns the states. */
static uint32_t *remove_surfaces(const traced *t) {
  size_t size;
  uint32_t *states = cache_read(CACHE_STATES, &size);
  for (uint32_t i = 0; i < t->list[0] * HBIL_CACHE_RAYS; i += 3001) {
    const uint32_t number = t->hits[i];
    if (number < 4 * size && is_surface(states, number))
      states[number / 16] ^= (HBIL_VOXEL_SURFACE ^ HBIL_VOXEL_EMPTY)
                             << 2 * (number % 16);
  }
  buffer_write(&shared_device, cache_memory(CACHE_STATES), 0, size, states);
  return states;
}

/* Whether all that a surface's rays hit is there. */
static bool hits_are_surfaces(const uint32_t *states, const uint32_t *hits) {
  bool all = true;
  for (int i = 0; i < HBIL_CACHE_RAYS; ++i)
    all &= hits[i] >= 0xfffffffeu || is_surface(states, hits[i]);
  return all;
}

/* Behind an injection, new surfaces and those whose turn it is have the hits of
 * an update that traces everything, the others those of the last update; after
 * all turns, all have the former. */
TEST(rays_are_traced_in_turn) {
  cache_fixture f;
  setup s, other, another;
  traced turn[HBIL_CACHE_TURNS];
  int fresh = 0, taken = 0, old = 0;
  exact_cache cache = filled(&f, 8, SCENE_ROOM, HBIL_VIEW_DIRECT, &s);
  traced before = trace(&f);
  assert_int_equal(before.args.turns, 1);
  view_start(&other, SCENE_ROOM, 64, 48, 9, HBIL_PROJECTION_PERSPECTIVE);
  view_start(&another, SCENE_ROOM, 48, 64, 1, HBIL_PROJECTION_PERSPECTIVE);
  cache_inject(&f, &other, HBIL_VIEW_DIRECT);
  uint32_t *states = remove_surfaces(&before);
  const size_t size = hbil_cache_size(f.cache);
  void *bytes = malloc(size);
  assert_non_null(bytes);
  assert_int_equal(hbil_cache_save(f.cache, shared_device.queue, bytes, size),
                   HBIL_SUCCESS);
  for (int i = 0; i < HBIL_CACHE_TURNS; ++i)
    turn[i] = trace(&f);
  /* a load forgets the hits, which are of other surfaces here */
  cache_inject(&f, &another, HBIL_VIEW_DIRECT);
  for (int i = 0; i < HBIL_CACHE_TURNS; ++i) {
    traced behind = trace(&f);
    forget_traced(&behind);
  }
  assert_int_equal(hbil_cache_load(f.cache, shared_device.queue, bytes, size),
                   HBIL_SUCCESS);
  traced all = trace(&f);
  const uint32_t count = all.list[0];
  assert_memory_equal(turn[0].list + HBIL_LIST_HEAD, all.list + HBIL_LIST_HEAD,
                      count * sizeof *all.list);
  assert_memory_equal(turn[HBIL_CACHE_TURNS - 1].hits, all.hits,
                      count * HBIL_CACHE_RAYS * sizeof *all.hits);
  for (uint32_t p = 0; p < count; ++p) {
    const uint32_t number = all.list[HBIL_LIST_HEAD + p];
    const uint32_t *got = hits_of(turn, number),
                   *last = hits_of(&before, number);
    const bool is_fresh =
        !last || number % HBIL_CACHE_TURNS == (uint32_t)turn[0].args.turn;
    const uint32_t *now = hits_of(&all, number);
    /* those that have hit what is gone are traced, too */
    assert_true(hits_are_surfaces(states, got));
    assert_true(same_hits(got, now) || (!is_fresh && same_hits(got, last)));
    fresh += is_fresh;
    taken += !is_fresh && same_hits(got, last);
    old += !same_hits(got, now);
  }
  assert_true(fresh > 100 && taken > 300 && old > 10);
  for (int i = 0; i < HBIL_CACHE_TURNS; ++i)
    forget_traced(turn + i);
  forget_traced(&before);
  forget_traced(&all);
  free(bytes);
  free(states);
  setup_free(&another);
  setup_free(&other);
  cache_end(&f, &s, &cache);
}

/* --- static views --- */

/* Injects a view whose direct light isn't what the last one showed. */
static void inject_static(cache_fixture *f, const setup *s, cl_bool is_static) {
  hbil_view view = cache_view(s, HBIL_VIEW_DIRECT);
  view.static_view = is_static;
  assert_int_equal(hbil_enqueue_cache_inject(f->cache, shared_device.queue,
                                             &view, 1, 0, NULL, NULL),
                   HBIL_SUCCESS);
}

/* Whether an injection changes voxels.  `s` has other light than the cache. */
static bool injects(cache_fixture *f, const setup *s, cl_bool is_static) {
  size_t bytes;
  float *before = cache_read(CACHE_VOXELS, &bytes);
  inject_static(f, s, is_static);
  float *after = cache_read(CACHE_VOXELS, &bytes);
  const bool changed = memcmp(before, after, bytes) != 0;
  free(before);
  free(after);
  return changed;
}

TEST(static_views_are_injected_until_means_settle) {
  cache_fixture f;
  setup s;
  exact_cache cache = filled(&f, 8, SCENE_ROOM, HBIL_VIEW_DIRECT, &s);
  for (int k = EXACT_DIRECT; k < EXACT_DIRECT + 3; ++k)
    for (size_t i = 0; i < setup_pixels(&s); ++i)
      s.input[k][i] *= 1.1f;
  setup_upload(&s);
  inject_static(&f, &s, CL_FALSE);
  for (int i = 1; i < HBIL_STATIC_VIEWS; ++i)
    inject_static(&f, &s, CL_TRUE);
  assert_true(injects(&f, &s, CL_TRUE)); /* the last one that counts */
  assert_false(injects(&f, &s, CL_TRUE));
  cache_touch(&f);
  assert_true(injects(&f, &s, CL_TRUE));
  for (int i = 0; i < HBIL_STATIC_VIEWS; ++i)
    inject_static(&f, &s, CL_TRUE);
  assert_false(injects(&f, &s, CL_TRUE));
  s.frame.exposure = 2.0f; /* another one isn't static */
  assert_true(injects(&f, &s, CL_TRUE));
  cache_end(&f, &s, &cache);
}

/* --- more surfaces than hits --- */

/* Makes this share of the voxels surfaces, at random. */
static void crowd(const exact_cache *cache, double share) {
  const size_t count = exact_cache_count(cache);
  uint32_t *states = cache_read(CACHE_STATES, NULL);
  float *voxels = cache_read(CACHE_VOXELS, NULL);
  random_state r = {7};
  for (size_t i = 0; i < count; ++i) {
    float *v = voxels + HBIL_VOXEL_FLOATS * i;
    const unsigned up = 2 * (i % 16);
    const uint32_t was = states[i / 16] >> up & 3u;
    if (random_unit(&r) >= share || was == HBIL_VOXEL_SURFACE)
      continue;
    states[i / 16] ^= (was ^ HBIL_VOXEL_SURFACE) << up;
    memset(v, 0, HBIL_VOXEL_FLOATS * sizeof *v);
    const vec3 n = exact_about_normal(
        vec(0.0, 0.0, 1.0), 2.0 * random_unit(&r) - 1.0, random_unit(&r));
    v[HBIL_VOXEL_NORMAL] = (float)n.x;
    v[HBIL_VOXEL_NORMAL + 1] = (float)n.y;
    v[HBIL_VOXEL_NORMAL + 2] = (float)n.z;
    v[HBIL_VOXEL_WEIGHT] = v[HBIL_VOXEL_LIGHT_WEIGHT] = 1.0f;
    for (int c = 0; c < 3; ++c) {
      v[HBIL_VOXEL_REFLECTANCE + c] = (float)random_unit(&r);
      v[HBIL_VOXEL_SENT + c] = (float)random_unit(&r);
    }
  }
  buffer_write(&shared_device, cache_memory(CACHE_STATES), 0, count / 4,
               states);
  buffer_write(&shared_device, cache_memory(CACHE_VOXELS), 0,
               HBIL_VOXEL_FLOATS * sizeof *voxels * count, voxels);
  free(states);
  free(voxels);
}

TEST(many_surfaces_have_fewer_rays) {
  static const struct {
    cl_uint width;
    double share;
    int rays;
  } cases[] = {{16, 0.15, 8}, {8, 0.6, 2}, {4, 0.3, 4}, {1, 0.3, 4}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    cache_fixture f;
    setup s;
    hbil_cache_update update;
    hbil_cache_update_init(&update);
    exact_cache cache =
        filled(&f, cases[i].width, SCENE_ROOM, HBIL_VIEW_DIRECT, &s);
    crowd(&cache, cases[i].share);
    cache_touch(&f);
    update.bounces = 0;
    cache_update(&f, &update);
    update.bounces = 1;
    check_round(&f, &cache, &update, CROWDED_RAYS * cases[i].rays);
    cache_end(&f, &s, &cache);
  }
}
