/*
 * What the methods of far light read of the cache matches the exact values, on
 * what the device had before it: areas, the pyramid, the volumes' sources,
 * borders and steps; and so do the probes of all methods but rays.
 */
#include "test/support/lit_frame.h"
#include "test/support/shim.h"
#include "test/support/stages.h"

#include "exact/cache_methods.h"

static const cl_uint widths[] = {1, 4, 8, 16};

/* The floats in an argument of a kernel; the caller frees. */
static float *floats_of(const char *kernel, cl_uint index) {
  cl_mem buffer;
  shim_argument(kernel, index, sizeof buffer, &buffer);
  return (float *)buffer_bytes(&shared_device, buffer, NULL);
}

/* A cache that has seen a scene, with a method; cache: what it holds. */
static void filled(cache_fixture *f, exact_cache *cache,
                   hbil_cache_method method, cl_uint width, cl_uint voxels) {
  setup last;
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  cache_prepare(f, width);
  f->config.method = method;
  f->config.voxels = voxels;
  *cache = checked_cache(f);
  cache_fill(f, cache, SCENE_SKY, HBIL_VIEW_DIRECT, &last);
  setup_free(&last);
  update.steps = 0;
  cache_update(f, &update);
  cache_import(cache);
}

/* ------------------------------------------------------------------------ */
/* Areas                                                                     */

/* The numbers of areas follow each other: steps, slices, rows, columns. */
static void check_areas(const exact_cache *cache) {
  float *got = floats_of("area_light", 6), *at = got;
  double most = 0.0, off[2] = {0.0, 0.0}; /* of light, of weights */
  int told = 0;
  for (int step = 0;; ++step) {
    const int n = exact_cache_areas_across(cache, step);
    if (n == 0)
      break;
    for (int i = 0; i < n * n * n; ++i, at += HBIL_AREA_FLOATS) {
      const int area[3] = {i % n, i / n % n, i / n / n};
      double want[6][4];
      exact_cache_area(cache, step, area, want);
      for (int k = 0; k < 24; ++k) {
        const double gap = fabs((double)at[k] - want[k / 4][k % 4]);
        const double size = fmax(1.0, want[k / 4][3]);
        if (k % 4 < 3)
          most = fmax(most, want[k / 4][k % 4] / size);
        off[k % 4 == 3] = fmax(off[k % 4 == 3], gap / size);
        told += k % 4 == 3 && want[k / 4][3] > 0.0;
      }
    }
  }
  assert_true(told > 10 && most > 0.0);
  /* derived: sums of some dozen to some hundred positive terms */
  check_at_most("areas: light", off[0] / most, 4e-6);
  check_at_most("areas: weights", off[1], 4e-6);
  free(got);
}

/* Of all sizes of caches; behind a move, rows wrap around in other places. */
TEST(areas_match) {
  static const struct {
    cl_uint width, voxels;
    double move;
  } runs[] = {{1, 16, 0.0}, {8, 16, 1.1}, {8, 32, 0.0}, {4, 64, -1.7}};
  for (size_t i = 0; i < sizeof runs / sizeof *runs; ++i) {
    cache_fixture f;
    exact_cache cache;
    filled(&f, &cache, HBIL_CACHE_METHOD_RAYS, runs[i].width, runs[i].voxels);
    check_areas(&cache);
    if (runs[i].move != 0.0) {
      const double centre[3] = {f.config.centre[0] + runs[i].move,
                                f.config.centre[1] - 0.5 * runs[i].move,
                                f.config.centre[2] + 0.3 * runs[i].move};
      cache_move(&f, centre);
      assert_int_equal(exact_cache_move(&cache, centre), EXACT_SUCCESS);
      cache_import(&cache);
      check_areas(&cache);
    }
    exact_cache_free(&cache);
    cache_free(&f);
  }
}

/* ------------------------------------------------------------------------ */
/* The pyramid                                                               */

static exact_pyramid pyramid_of(const float *texels, const exact_cache *cache) {
  exact_pyramid p;
  assert_int_equal(exact_pyramid_create(&p, cache), EXACT_SUCCESS);
  for (int step = 0; step < exact_pyramid_steps(&p); ++step) {
    const int n = exact_pyramid_across(&p, step);
    for (int i = 0; i < n * n * n; ++i) {
      exact_mip *mip = exact_pyramid_at(&p, step, i % n, i / n % n, i / n / n);
      const float *texel = texels + HBIL_MIP_FLOATS * (mip - p.mip);
      for (int k = 0; k < 24; ++k)
        mip->along[k / 4][k % 4] = (double)texel[k];
      mip->unseen = (double)texel[HBIL_MIP_UNSEEN];
      mip->sky = (double)texel[HBIL_MIP_SKY];
    }
  }
  return p;
}

/* The largest differences of light, relative to `most`, and of shares. */
static void mip_difference(const exact_mip *a, const exact_mip *b, double most,
                           double off[2]) {
  for (int way = 0; way < 6; ++way)
    for (int c = 0; c < 4; ++c) {
      const double by = fabs(a->along[way][c] - b->along[way][c]);
      double *to = off + (c == 3);
      *to = fmax(*to, c == 3 ? by : by / most);
    }
  off[1] = fmax(off[1], fabs(a->unseen - b->unseen));
  off[1] = fmax(off[1], fabs(a->sky - b->sky));
}

static void check_pyramid(cl_uint voxels) {
  cache_fixture f;
  exact_cache cache;
  filled(&f, &cache, HBIL_CACHE_METHOD_CONES, 8, voxels);
  float *texels = floats_of("level_step", 5);
  const exact_pyramid got = pyramid_of(texels, &cache);
  exact_pyramid want = pyramid_of(texels, &cache);
  int surfaces = 0;
  double off[2] = {0.0, 0.0};
  for (int step = exact_pyramid_steps(&got) - 1; step >= 0; --step) {
    const int n = exact_pyramid_across(&want, step);
    exact_pyramid_build(&cache, &want, step);
    double most = 0.0;
    for (int i = 0; i < n * n * n; ++i)
      for (int k = 0; k < 24; ++k)
        most = fmax(most,
                    exact_pyramid_at(&want, step, i % n, i / n % n, i / n / n)
                        ->along[k / 4][k % 4]);
    for (int i = 0; i < n * n * n; ++i) {
      const exact_mip *mip =
          exact_pyramid_at(&want, step, i % n, i / n % n, i / n / n);
      for (int k = 0; k < 6; ++k)
        surfaces += mip->along[k][3] > 0.0;
      mip_difference(exact_pyramid_at(&got, step, i % n, i / n % n, i / n / n),
                     mip, most, off);
    }
  }
  assert_true(surfaces > 100);
  /* derived: a dozen roundings of 2^-24 */
  check_at_most("pyramid: light", off[0], 7e-7);
  check_at_most("pyramid: shares", off[1], 7e-7);
  free(texels);
  exact_pyramid_free((exact_pyramid *)&got);
  exact_pyramid_free(&want);
  exact_cache_free(&cache);
  cache_free(&f);
}

TEST(pyramids_match) {
  check_pyramid(16);
  check_pyramid(32);
}

/* ------------------------------------------------------------------------ */
/* Volumes                                                                   */

/* Planes of a cell: four for each colour, and one more in volumes. */
static exact_volumes volumes_of(const float *planes, int colour,
                                const exact_cache *cache) {
  exact_volumes v;
  assert_int_equal(exact_volumes_create(&v, cache), EXACT_SUCCESS);
  const int n = v.across + 2, plane = n * n * n;
  for (int i = 0; i < plane * v.levels; ++i) {
    const float *from = planes + i / plane * 3 * colour * plane + i % plane;
    for (int c = 0; c < 3; ++c, from += colour * plane)
      v.cell[i].light[c] = (exact_intensity){
          (double)from[0], vec((double)from[plane], (double)from[2 * plane],
                               (double)from[3 * plane])};
  }
  return v;
}

static void read_opacities(const float *planes, exact_volumes *v) {
  const int n = v->across + 2, plane = n * n * n;
  for (int i = 0; i < plane * v->levels; ++i)
    for (int k = 0; k < 6; ++k)
      v->cell[i].opacity[k] =
          (double)planes[i / plane * 6 * plane + k * plane + i % plane];
}

/* The largest difference of intensities and of opacities of the cells inside or
 * outside, relative to the largest intensity of the level. */
static void volume_difference(const exact_volumes *got,
                              const exact_volumes *want, bool outside,
                              double off[2]) {
  const int n = want->across + 2, plane = n * n * n;
  double most[HBIL_CACHE_MAX_LEVELS] = {0.0};
  off[0] = off[1] = 0.0;
  for (int i = 0; i < 2 * plane * want->levels; ++i) {
    const int cell = i % (plane * want->levels), l = cell / plane;
    const int x = cell % n, y = cell / n % n, z = cell / n / n % n;
    const bool is_outside =
        x % (n - 1) == 0 || y % (n - 1) == 0 || z % (n - 1) == 0;
    const exact_cell *a = got->cell + cell, *b = want->cell + cell;
    for (int c = 0; c < 3 && is_outside == outside; ++c) {
      const exact_intensity *v = &a->light[c], *w = &b->light[c];
      if (i == cell)
        most[l] = fmax(most[l], w->mean);
      else
        off[0] = fmax(off[0], (fabs(v->mean - w->mean) +
                               vec_length(vec_add(v->slope, -1.0, w->slope))) /
                                  fmax(most[l], 1e-30));
    }
    for (int k = 0; k < 6 && is_outside == outside; ++k)
      off[1] = fmax(off[1], fabs(a->opacity[k] - b->opacity[k]));
  }
  /* the finest levels may be empty */
  assert_true(most[want->levels - 1] > 0.0);
}

/* The factors that preserve a cell's flux, of all cells. */
static void check_factors(const float *planes, const exact_volumes *v) {
  const int n = v->across + 2, plane = n * n * n;
  double worst = 0.0;
  for (int i = 0; i < plane * v->levels; ++i)
    for (int c = 0; c < 3; ++c)
      worst = fmax(
          worst,
          fabs(
              (double)planes[(i / plane * 15 + 5 * c + 4) * plane + i % plane] -
              exact_flux_factor(&v->cell[i].light[c])));
  /* derived: sums of 30 products, each of a few roundings */
  check_at_most("volumes: flux factor", worst, 5e-6);
}

static void check_volumes(cl_uint width, cl_uint voxels,
                          hbil_far_field far_field) {
  cache_fixture f;
  exact_cache cache;
  hbil_cache_update update = cache_bounces(0);
  setup sky;
  double off[2];
  filled(&f, &cache, HBIL_CACHE_METHOD_LPV, width, voxels);
  lit_environment(&sky);
  update.far_field = far_field;
  memcpy(update.environment, sky.frame.environment, sizeof update.environment);
  update.steps = 7;
  cache_update(&f, &update);
  update.steps = 1;
  cache_update(&f, &update);
  float *s = floats_of("propagate", 1), *o = floats_of("propagate", 2);
  float *b = floats_of("propagate", 3), *a = floats_of("propagate", 4);
  exact_volumes sources = volumes_of(s, 4, &cache), want;
  exact_volumes before = volumes_of(b, 5, &cache);
  exact_volumes after = volumes_of(a, 5, &cache);
  read_opacities(o, &sources);
  assert_int_equal(exact_volumes_create(&want, &cache), EXACT_SUCCESS);
  exact_volume_sources(&cache, &want);
  volume_difference(&sources, &want, false, off);
  /* derived: a cell is a sum over 64 voxels at most */
  check_at_most("volumes: sources", off[0], 4e-6);
  check_at_most("volumes: opacities", off[1], 7e-7);
  exact_volumes_free(&want);
  want = volumes_of(b, 5, &cache);
  exact_volume_border(&want, far_field, (const float(*)[3])update.environment);
  volume_difference(&before, &want, true, off);
  check_at_most("volumes: border", off[0], 5e-7);
  check_factors(b, &before);
  exact_propagate(&sources, &before, &want);
  volume_difference(&after, &want, false, off);
  check_at_most("volumes: a step", off[0], 3e-6);
  exact_volumes_free(&sources);
  exact_volumes_free(&before);
  exact_volumes_free(&after);
  exact_volumes_free(&want);
  free(s);
  free(o);
  free(b);
  free(a);
  exact_cache_free(&cache);
  cache_free(&f);
}

TEST(volumes_match) {
  for (int i = 0; i < 4; ++i)
    check_volumes(widths[i], i < 3 ? 32 : 16, HBIL_FAR_SH);
  check_volumes(8, 16, HBIL_FAR_CONSTANT);
}

/* ------------------------------------------------------------------------ */
/* Probes                                                                    */

static exact_planes start_probes(lit_frame *l) {
  setup_start(&l->s);
  setup_run(&l->s, enqueue_split);
  setup_run(&l->s, enqueue_composite);
  return stage_read(&l->s, HBIL_STAGE_SPLIT);
}

/* What a method's probes may be off by: shares, and light relative to the
 * brightest probe's; and how many probes may be off by more. */
typedef struct tolerance {
  double share, light, different;
} tolerance;

static void check_probes(const lit_frame *l, const char *name,
                         const exact_probes *want, const tolerance *t) {
  const exact_probes got = lit_probes(&l->s, "filter_probes", 1);
  double most = 0.0, worst[2] = {0.0, 0.0};
  int valid = 0, different = 0, lit = 0;
  for (int i = 0; i < got.count; ++i)
    for (int c = 0; c < 3; ++c)
      most = fmax(most, want->probe[i].light[c][0]);
  for (int i = 0; i < got.count; ++i) {
    const exact_probe *p = want->probe + i;
    double off[3];
    probe_difference(got.probe + i, p, off);
    valid += p->valid;
    lit += p->light[0][0] > 0.0;
    if (!same_place(&got, i, p) ||
        !(off[1] <= t->share && off[2] <= t->light * most)) {
      ++different;
      continue;
    }
    worst[0] = fmax(worst[0], off[1]);
    worst[1] = fmax(worst[1], off[2] / most);
  }
  assert_true(valid > 50 && lit > valid / 4);
  check_at_most(name, different / (double)valid, t->different);
  check_at_most("shares of the others", worst[0], t->share);
  check_at_most("light of the others", worst[1], t->light);
  exact_probes_free((exact_probes *)&got);
}

TEST(cones_match) {
  /* A sample on the other side of a voxel's border changes a probe (measured:
   * one of 300 does).  The others are off by roundings: derived, a place 64
   * voxels away by 2^-18 voxels, and opacity by ten times that, as the least
   * share of a sample that has been seen is 1/20 of two voxels (measured: 8e-6,
   * 2e-5). */
  static const tolerance t = {4e-5, 4e-5, 0.02};
  for (int i = 0; i < 4; ++i) {
    lit_frame l;
    lit_prepare(
        &l, HBIL_CACHE_METHOD_CONES, widths[i], i & 1 ? SCENE_SKY : SCENE_ROOM,
        i == 2 ? HBIL_PROJECTION_ORTHOGRAPHIC : HBIL_PROJECTION_PERSPECTIVE,
        i == 2 ? HBIL_FAR_CONSTANT : HBIL_FAR_SH);
    exact_planes split = start_probes(&l);
    float *texels = floats_of("probe_cones", 5);
    exact_pyramid pyramid = pyramid_of(texels, &l.cache);
    exact_probes want = lit_no_probes(&l.s);
    exact_probe_cones(&l.s.job, &l.cache, &pyramid, &split, &want);
    check_probes(&l, "cones: probes that differ", &want, &t);
    exact_probes_free(&want);
    exact_pyramid_free(&pyramid);
    free(texels);
    exact_planes_free(&split);
    lit_free(&l);
  }
}

TEST(volumes_at_probes_match) {
  static const tolerance t = {1e-6, 2e-5, 0.0};
  for (int i = 0; i < 4; ++i) {
    lit_frame l;
    hbil_cache_update update;
    lit_prepare(
        &l, HBIL_CACHE_METHOD_LPV, widths[i], i & 1 ? SCENE_SKY : SCENE_ROOM,
        i == 2 ? HBIL_PROJECTION_ORTHOGRAPHIC : HBIL_PROJECTION_PERSPECTIVE,
        HBIL_FAR_SH);
    hbil_cache_update_init(&update);
    update.far_field = HBIL_FAR_SH;
    memcpy(update.environment, l.s.frame.environment,
           sizeof update.environment);
    cache_update(&l.f, &update);
    exact_planes split = start_probes(&l);
    float *planes = floats_of("probe_lpv", 2);
    exact_volumes volumes = volumes_of(planes, 5, &l.cache);
    exact_probes want = lit_no_probes(&l.s);
    exact_probe_volumes(&l.s.job, &l.cache, &volumes, &split, &want);
    check_probes(&l, "LPV: probes that differ", &want, &t);
    exact_probes_free(&want);
    exact_volumes_free(&volumes);
    free(planes);
    exact_planes_free(&split);
    lit_free(&l);
  }
}

/* --- light views --- */

enum { LIGHTS = 3 };

/* The device's texels of a light's view, as the kernel takes them. */
static exact_texel *light_texels(int number, int count) {
  uint32_t *words = (uint32_t *)floats_of("probe_rsm", 2);
  exact_texel *texels = calloc((size_t)count, sizeof *texels);
  assert_non_null(texels);
  for (int i = 0; i < count; ++i)
    texels[i] = texel_of_words(
        words + HBIL_TEXEL_WORDS * (number * HBIL_LIGHT_MOST_TEXELS + i));
  free(words);
  return texels;
}

/* Three views of the scene, of which the second is orthographic and the third
 * so large that it has every other pixel. */
static void light_up(lit_frame *l, scene_kind kind,
                     exact_cache_view lights[LIGHTS]) {
  static const int sizes[LIGHTS][2] = {{160, 90}, {131, 77}, {400, 230}};
  hbil_view views[LIGHTS];
  setup s[LIGHTS];
  for (int i = 0; i < LIGHTS; ++i) {
    const hbil_projection projection =
        i == 1 ? HBIL_PROJECTION_ORTHOGRAPHIC : HBIL_PROJECTION_PERSPECTIVE;
    view_start(&s[i], kind, sizes[i][0], sizes[i][1], 2 * (uint32_t)i + 1,
               projection);
    views[i] = cache_view(&s[i], HBIL_VIEW_DIRECT);
    const int stride = i == 2 ? 2 : 1;
    lights[i] =
        (exact_cache_view){.camera = s[i].frame.camera,
                           .orthographic = i == 1,
                           .stride = stride,
                           .width = (sizes[i][0] + stride - 1) / stride,
                           .height = (sizes[i][1] + stride - 1) / stride};
  }
  assert_success(&l->s,
                 hbil_enqueue_cache_light_views(l->f.cache, shared_device.queue,
                                                views, LIGHTS, 0, NULL, NULL));
  assert_int_equal(clFinish(shared_device.queue), CL_SUCCESS);
  for (int i = 0; i < LIGHTS; ++i)
    setup_free(&s[i]);
}

TEST(lights_match) {
  /* A sample on the other side of a texel's border changes a probe.  Azimuths
   * are fractions of multiples of the golden ratio up to 160, so they are off
   * by up to 2^-17 of a turn, 1/200 of a texel at a hundred texels (measured:
   * 6.4 % of the probes, each of which has 768 samples). */
  static const tolerance t = {1e-6, 1e-4, 0.13};
  for (int i = 0; i < 2; ++i) {
    lit_frame l;
    exact_cache_view lights[LIGHTS];
    const scene_kind kind = i ? SCENE_SKY : SCENE_ROOM;
    lit_prepare(&l, HBIL_CACHE_METHOD_RSM, widths[i], kind,
                i ? HBIL_PROJECTION_ORTHOGRAPHIC : HBIL_PROJECTION_PERSPECTIVE,
                HBIL_FAR_NONE);
    light_up(&l, kind, lights);
    exact_planes split = start_probes(&l);
    exact_probes want = lit_no_probes(&l.s);
    for (int k = 0; k < LIGHTS; ++k)
      lights[k].texel = light_texels(k, lights[k].width * lights[k].height);
    exact_probe_lights(&l.s.job, &l.cache, lights, LIGHTS, false, &split,
                       &want);
    check_probes(&l, "RSM: probes that differ", &want, &t);
    for (int k = 0; k < LIGHTS; ++k)
      free((void *)lights[k].texel);
    exact_probes_free(&want);
    exact_planes_free(&split);
    lit_free(&l);
  }
}
