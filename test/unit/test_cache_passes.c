/*
 * Each pass of the radiance cache matches the exact one, on what the device had
 * before it: views, injection, moves, codes and rays.  Bounces, probes and
 * their light are in test_cache_light.c.
 */
#include "test/support/cache.h"
#include "test/support/packing.h"
#include "test/support/random.h"

static const cl_uint widths[] = {1, 4, 8, 16};

/* ------------------------------------------------------------------------ */
/* Views and injection                                                       */

/* The table of texels holds what the view's pixels show. */
static void check_texels(const setup *s, const exact_cache *cache,
                         hbil_view_light light, int stride) {
  int width, height;
  exact_texel *got = cache_texels(&width, &height);
  double depth = 0.0, normal = 0.0, reflectance = 0.0, sent = 0.0;
  for (int i = 0; i < width * height; ++i) {
    const exact_texel want =
        exact_cache_texel(&s->job, cache, light == HBIL_VIEW_FINISHED,
                          i % width * stride, i / width * stride);
    assert_int_equal(got[i].depth > 0.0, want.depth > 0.0);
    if (!(want.depth > 0.0))
      continue;
    depth = fmax(depth, fabs(got[i].depth / want.depth - 1.0));
    normal =
        fmax(normal, vec_length(vec_add(got[i].normal, -1.0, want.normal)));
    const double most = fmax(want.sent[0], fmax(want.sent[1], want.sent[2]));
    for (int c = 0; c < 3; ++c) {
      reflectance =
          fmax(reflectance, fabs(got[i].reflectance[c] - want.reflectance[c]));
      if (most > 0.0)
        sent = fmax(sent,
                    fabs(got[i].sent[c] - want.sent[c]) / packed_unit(most, 8));
      else
        assert_true(got[i].sent[c] == 0.0);
    }
  }
  /* derived: two roundings; half a step of 16 bits along two axes of the map,
   * which stretches them by 1.7 at most; half a step of 10 bits; half a step of
   * a mantissa, and a few roundings of what is 255 steps at most */
  check_at_most("texels: depth", depth, 2e-7);
  check_at_most("texels: normal", normal, 6.5e-5);
  check_at_most("texels: reflectance", reflectance, 0.5 / 1023.0 + 1e-6);
  check_at_most("texels: sent, in steps", sent, 0.5 + 1e-4);
  free(got);
}

/* What a decision of the kernel may be off by: places in a view are up to 160
 * texels and 64 voxels from their origin, with some four roundings. */
#define UNSURE 2e-4
/* Measured: 0.07 % of the voxels in a view are that near to another result. */
#define MOST_UNSURE 2e-3

typedef struct difference {
  double plane, share; /* of normals and offsets; of reflectance */
  double light;        /* relative */
  int voxels, unsure, changed;
} difference;

static void compare_voxel(const exact_voxel *got, const exact_voxel *want,
                          difference *d) {
  if (got->state != want->state)
    fail_msg("state %d, not %d", got->state, want->state);
  if (want->state != HBIL_VOXEL_SURFACE)
    return;
  double light[2];
  if (want->value[HBIL_VOXEL_BEFORE] > 0.0)
    assert_int_equal(
        exact_voxel_before(got->value[HBIL_VOXEL_BEFORE], light),
        exact_voxel_before(want->value[HBIL_VOXEL_BEFORE], light + 1));
  for (int k = 0; k < HBIL_VOXEL_FLOATS; ++k) {
    const double off = fabs(got->value[k] - want->value[k]);
    if (k <= HBIL_VOXEL_OFFSET)
      d->plane = fmax(d->plane, off);
    else if (k < HBIL_VOXEL_WEIGHT)
      d->share = fmax(d->share, off);
    else if ((k >= HBIL_VOXEL_SENT && k < HBIL_VOXEL_LIGHT_WEIGHT) ||
             k == HBIL_VOXEL_BEFORE)
      d->light = fmax(d->light, off / fmax(fabs(want->value[k]), 1e-3));
    else
      assert_true(got->value[k] == want->value[k]);
  }
}

/* Injects on both sides, from what the device holds, and compares. */
static void check_injection(cache_fixture *f, exact_cache *cache,
                            const setup *s, hbil_view_light light) {
  const size_t count = exact_cache_count(cache);
  exact_cache before = checked_cache(f);
  double *margin = malloc(count * sizeof *margin);
  difference d = {.voxels = 0};
  memcpy(before.middle, cache->middle, sizeof before.middle);
  exact_cache_view view = {.camera = s->frame.camera,
                           .orthographic = s->config.inputs.projection ==
                                           HBIL_PROJECTION_ORTHOGRAPHIC,
                           .finished = light == HBIL_VIEW_FINISHED,
                           .stride = 1};
  assert_non_null(margin);
  cache_import(&before);
  cache_inject(f, s, light);
  const int across = (int)s->config.width, down = (int)s->config.height;
  while (((across - 1) / view.stride + 1) * ((down - 1) / view.stride + 1) >
         HBIL_CACHE_MOST_TEXELS)
    ++view.stride;
  check_texels(s, cache, light, view.stride);
  exact_texel *texels = cache_texels(&view.width, &view.height);
  view.texel = texels;
  cache_import(cache);
  exact_cache_inject(&before, &view, margin);
  for (size_t i = 0; i < count; ++i) {
    const exact_place place = exact_cache_place(cache, i);
    d.voxels += margin[i] < HUGE_VAL;
    d.unsure += margin[i] < UNSURE;
    if (margin[i] >= UNSURE)
      compare_voxel(exact_cache_at(cache, &place),
                    exact_cache_at(&before, &place), &d);
  }
  assert_true(d.voxels > 1000);
  check_at_most("unsure voxels", d.unsure / (double)d.voxels, MOST_UNSURE);
  /* measured: 3.1e-6, roundings of places some 64 voxels away; 1.4e-7; 2.2e-6,
   * because what is left of brighter views has their roundings */
  check_at_most("planes", d.plane, 1e-5);
  check_at_most("reflectance", d.share, 5e-7);
  check_at_most("light, relative", d.light, 1e-5);
  free(margin);
  free(texels);
  exact_cache_free(&before);
}

/* The lamp of the room is in sight; that of a renderer whose direct light
 * contains what it emits doesn't count again. */
static void check_views(cl_uint width, scene_kind kind,
                        hbil_projection projection, cl_bool gather_emission,
                        hbil_direct_kind direct_kind) {
  static const hbil_view_light light[] = {HBIL_VIEW_DIRECT, HBIL_VIEW_DIRECT,
                                          HBIL_VIEW_FINISHED, HBIL_VIEW_DIRECT};
  cache_fixture f;
  cache_prepare(&f, width);
  exact_cache cache = checked_cache(&f);
  for (uint32_t i = 0; i < 4; ++i) {
    setup s;
    view_start(&s, kind, 160, 90, 3 * i, projection);
    s.config.model.gather_emission = gather_emission;
    s.config.inputs.direct_kind = direct_kind;
    if (i == 0)
      cache_start(&f, &s);
    check_injection(&f, &cache, &s, light[i]);
    setup_free(&s);
  }
  cache_free(&f);
  exact_cache_free(&cache);
}

TEST(views_tell_voxels_what_they_show) {
  for (int i = 0; i < 4; ++i) {
    check_views(widths[i], SCENE_ROOM, HBIL_PROJECTION_PERSPECTIVE, i & 1,
                HBIL_DIRECT_IRRADIANCE);
    check_views(widths[i], SCENE_SKY, HBIL_PROJECTION_ORTHOGRAPHIC, CL_TRUE,
                HBIL_DIRECT_RADIANCE);
  }
  check_views(1, SCENE_SKY, HBIL_PROJECTION_PERSPECTIVE, CL_TRUE,
              HBIL_DIRECT_IRRADIANCE);
  check_views(1, SCENE_ROOM, HBIL_PROJECTION_ORTHOGRAPHIC, CL_TRUE,
              HBIL_DIRECT_IRRADIANCE);
}

/* 1024 x 600 pixels are more than fit into the table. */
TEST(of_large_views_some_pixels_are_read) {
  cache_fixture f;
  setup s;
  cache_prepare(&f, 8);
  exact_cache cache = checked_cache(&f);
  view_start(&s, SCENE_ROOM, 1024, 600, 0, HBIL_PROJECTION_PERSPECTIVE);
  cache_start(&f, &s);
  check_injection(&f, &cache, &s, HBIL_VIEW_DIRECT);
  cache_end(&f, &s, &cache);
}

/* ------------------------------------------------------------------------ */
/* Moves                                                                     */

/* Exact: states are those of the exact cache; what stays has its values.
 */
static void check_move(cache_fixture *f, exact_cache *cache,
                       const double by[3]) {
  exact_cache after = checked_cache(f);
  double centre[3];
  for (int i = 0; i < 3; ++i)
    centre[i] = (double)cache->middle[i] * 4.0 * cache->voxel_size + by[i];
  cache_import(cache);
  assert_int_equal(exact_cache_move(cache, centre), EXACT_SUCCESS);
  cache_move(f, centre);
  memcpy(after.middle, cache->middle, sizeof after.middle);
  cache_import(&after);
  for (size_t i = 0; i < exact_cache_count(cache); ++i) {
    const exact_place place = exact_cache_place(cache, i);
    const exact_voxel *want = exact_cache_at(cache, &place);
    const exact_voxel *got = exact_cache_at(&after, &place);
    assert_int_equal(got->state, want->state);
    if (want->state == HBIL_VOXEL_SURFACE)
      assert_memory_equal(got->value, want->value, sizeof got->value);
  }
  exact_cache_free(&after);
}

TEST(what_stays_inside_has_its_values) {
  static const double by[][3] = {
      {0.5, 0.0, 0.0}, {-0.46, 0.93, -1.4}, {0.0, -7.0, 2.3}, {90, 0, 0}};
  cache_fixture f;
  setup s;
  cache_prepare(&f, 8);
  exact_cache cache = checked_cache(&f);
  view_start(&s, SCENE_ROOM, 160, 90, 0, HBIL_PROJECTION_PERSPECTIVE);
  cache_start(&f, &s);
  cache_update(&f, NULL); /* its kernels tell where the buffers are */
  cache_inject(&f, &s, HBIL_VIEW_DIRECT);
  for (int i = 0; i < 4; ++i) {
    check_move(&f, &cache, by[i]);
    if (i < 3)
      check_injection(&f, &cache, &s, HBIL_VIEW_DIRECT);
  }
  cache_end(&f, &s, &cache);
}

/* ------------------------------------------------------------------------ */
/* Ways                                                                      */

/* The state of a voxel for rays, given where it is in memory. */
static int way_at(const exact_cache *cache, const size_t at[4]) {
  const size_t n = (size_t)cache->voxels;
  exact_place place = exact_cache_place(
      cache, ((at[3] * n + at[2] % n) * n + at[1] % n) * n + at[0] % n);
  return exact_cache_state_for_rays(cache, &place);
}

/* Whether all voxels at the distance r, the largest of those along the three
 * axes, have the state of a voxel. */
static bool is_alike(const exact_cache *cache, const size_t at[4], size_t r) {
  const size_t n = (size_t)cache->voxels, side = 2 * r + 1;
  const int state = way_at(cache, at);
  for (size_t i = 0; i < side * side * side; ++i) {
    const size_t by[3] = {i % side, i / side % side, i / side / side};
    const bool is_shell =
        by[0] % (2 * r) == 0 || by[1] % (2 * r) == 0 || by[2] % (2 * r) == 0;
    if (is_shell &&
        way_at(cache, (size_t[4]){at[0] + n + by[0] - r, at[1] + n + by[1] - r,
                                  at[2] + n + by[2] - r, at[3]}) != state)
      return false;
  }
  return true;
}

/* How far around a voxel all have its state. */
static int clearance_at(const exact_cache *cache, const size_t at[4]) {
  int clear = 0;
  while (clear < HBIL_MOST_CLEARANCE && is_alike(cache, at, (size_t)clear + 1))
    ++clear;
  return clear;
}

static void check_ways(exact_cache *cache) {
  const size_t n = (size_t)cache->voxels;
  size_t count, clear = 0, above = 0;
  cache_import(cache);
  unsigned char *codes = cache_read(CACHE_CLEARANCE, &count);
  assert_int_equal(count, exact_cache_count(cache));
  for (size_t i = 0; i < count; ++i) {
    const size_t at[4] = {i % n, i / n % n, i / n / n % n, i / n / n / n};
    exact_place place = exact_cache_place(cache, i);
    const int own = place.level;
    assert_int_equal(codes[i] & 3, exact_cache_state_for_rays(cache, &place));
    const int upper = codes[i] >> 2;
    if ((codes[i] & 3) == HBIL_VOXEL_SURFACE) {
      assert_int_equal(upper, place.level - own);
      above += upper > 0;
    } else if (i % 7 == 0) { /* as each looks at up to 3374 others */
      assert_int_equal(upper, clearance_at(cache, at));
      clear += upper > 0;
    }
  }
  assert_true(clear > count / 70 && above > 0);
  free(codes);
}

TEST(ways_are_the_finest_state_that_is_known) {
  for (int kind = 0; kind < SCENE_KINDS; ++kind) {
    cache_fixture f;
    setup s;
    const hbil_cache_update none = {.struct_size = sizeof none, .phases = 1};
    cache_prepare(&f, 4);
    exact_cache cache = checked_cache(&f);
    cache_fill(&f, &cache, (scene_kind)kind, HBIL_VIEW_DIRECT, &s);
    cache_update(&f, &none);
    check_ways(&cache);
    cache_end(&f, &s, &cache);
  }
}
