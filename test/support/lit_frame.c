/* See lit_frame.h. */
#include "test/support/lit_frame.h"

#include "test/support/random.h"
#include "test/support/shim.h"

#include "exact/camera.h"
#include "exact/input.h"

void lit_environment(setup *s) {
  random_state r = {31};
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      s->frame.environment[i][c] =
          (float)(i ? random_unit(&r) - 0.5 : 2.0 + random_unit(&r));
}

void lit_prepare(lit_frame *l, hbil_cache_method method, cl_uint width,
                 scene_kind kind, hbil_projection projection,
                 hbil_far_field far_field) {
  setup last;
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  cache_prepare(&l->f, width);
  l->f.config.method = method;
  l->cache = checked_cache(&l->f);
  cache_fill(&l->f, &l->cache, kind, HBIL_VIEW_DIRECT, &last);
  setup_free(&last);
  cache_update(&l->f, &update);
  cache_import(&l->cache);
  view_prepare(&l->s, kind, LIT_WIDTH, LIT_HEIGHT, 3, projection);
  l->device = shared_device;
  l->device.hbil = l->f.context;
  l->s.device = &l->device;
  l->s.frame.cache = l->f.cache;
  l->s.config.model.cache_method = method;
  l->s.config.model.far_field = far_field;
  l->s.config.model.radius =
      (float)(HBIL_CACHE_NEAR_VOXELS * l->f.config.voxel_size);
  /* one search serves light and outputs; test_ao_radius has two */
  l->s.config.model.ao_radius = l->s.config.model.radius;
  setup_all_outputs(&l->s);
  lit_environment(&l->s);
}

void lit_free(lit_frame *l) {
  setup_free(&l->s);
  exact_cache_free(&l->cache);
  cache_free(&l->f);
}

/* --- light that has fallen --- */

void lit_draw_factors(uint64_t seed, float ratios[HBIL_CACHE_REGIONS]) {
  random_state r = {seed};
  for (int i = 0; i < HBIL_CACHE_REGIONS; ++i)
    ratios[i] = (float)(0.1 + 0.9 * random_unit(&r));
}

void lit_fall(lit_frame *l, const float ratios[HBIL_CACHE_REGIONS]) {
  hbil_cache_update none = cache_bounces(0);
  cache_touch(&l->f);
  cache_update(&l->f, &none);
  buffer_write(&shared_device, cache_memory(CACHE_RATIOS), 0,
               HBIL_CACHE_REGIONS * sizeof *ratios, ratios);
}

double lit_fallen(const lit_frame *l, const float ratios[HBIL_CACHE_REGIONS],
                  int x, int y) {
  const double *m = l->s.job.camera.world_from_view;
  const vec3 p =
      exact_point(&l->s.job, x, y, exact_planar_depth(&l->s.job, x, y));
  const vec3 at = exact_cache_from_world(
      &l->cache, vec_add(exact_to_world(&l->s.job.camera, p), 1.0,
                         vec(m[3], m[7], m[11])));
  const double ratio = exact_cache_fallen(&l->cache, ratios, at);
  for (int i = 0; i < 6; ++i) {
    const double off = i & 1 ? 1e-3 : -1e-3;
    const vec3 beside =
        vec(at.x + (i / 2 == 0) * off, at.y + (i / 2 == 1) * off,
            at.z + (i / 2 == 2) * off);
    if (exact_cache_fallen(&l->cache, ratios, beside) != ratio)
      return NAN;
  }
  return ratio;
}

/* --- probes on the device --- */

/* The kernels that make probes. */
static const char *const makers[] = {[HBIL_CACHE_METHOD_RAYS] = "probe_rays",
                                     [HBIL_CACHE_METHOD_CONES] = "probe_cones",
                                     [HBIL_CACHE_METHOD_LPV] = "probe_lpv",
                                     [HBIL_CACHE_METHOD_RSM] = "probe_rsm"};

exact_probes lit_no_probes(const setup *s) {
  exact_probes probes;
  assert_int_equal(exact_probes_create(&probes, &s->config), EXACT_SUCCESS);
  return probes;
}

static vec3 vec_of(const float *v) {
  return vec((double)v[0], (double)v[1], (double)v[2]);
}

exact_probes lit_probes(const setup *s, const char *kernel, cl_uint index) {
  exact_probes probes = lit_no_probes(s);
  hbil_probes_args args;
  cl_mem buffer;
  shim_argument(makers[s->config.model.cache_method], 0, sizeof args, &args);
  assert_int_equal(args.grid.spacing, probes.spacing);
  assert_int_equal(args.grid.columns, probes.columns);
  assert_int_equal(args.grid.lines, probes.lines);
  shim_argument(kernel, index, sizeof buffer, &buffer);
  float *values = (float *)buffer_bytes(s->device, buffer, NULL);
  for (int i = 0; i < probes.count; ++i) {
    const float *v = values + HBIL_PROBE_FLOATS * i;
    exact_probe *p = probes.probe + i;
    p->valid = v[HBIL_PROBE_VALID] != 0.0f;
    p->place = vec_of(v + HBIL_PROBE_POSITION);
    p->normal = vec_of(v + HBIL_PROBE_NORMAL);
    p->frames = (double)v[HBIL_PROBE_FRAMES_AT];
    for (int k = 0; k < 4; ++k) {
      p->known[k] = (double)v[HBIL_PROBE_KNOWN + k];
      p->unknown[k] = (double)v[HBIL_PROBE_UNKNOWN + k];
      p->guess[k] = (double)v[HBIL_PROBE_GUESS + k];
      for (int c = 0; c < 3; ++c)
        p->light[c][k] = (double)v[HBIL_PROBE_LIGHT + 4 * c + k];
    }
  }
  free(values);
  return probes;
}

void probe_difference(const exact_probe *a, const exact_probe *b,
                      double off[3]) {
  off[0] = fmax(vec_length(vec_add(a->place, -1.0, b->place)),
                vec_length(vec_add(a->normal, -1.0, b->normal)));
  off[1] = off[2] = 0.0;
  for (int k = 0; k < 4; ++k) {
    off[1] = fmax(off[1], fmax(fabs(a->known[k] - b->known[k]),
                               fabs(a->unknown[k] - b->unknown[k])));
    for (int c = 0; c < 3; ++c)
      off[2] = fmax(off[2], fabs(a->light[c][k] - b->light[c][k]));
    off[k < 3 ? 2 : 1] =
        fmax(off[k < 3 ? 2 : 1], fabs(a->guess[k] - b->guess[k]));
  }
}

bool same_place(const exact_probes *got, int i, const exact_probe *want) {
  const exact_probe *p = got->probe + i;
  const double off = fmax(vec_length(vec_add(p->place, -1.0, want->place)),
                          vec_length(vec_add(p->normal, -1.0, want->normal)));
  const bool same = p->valid == want->valid &&
                    off <= 3e-6 * fmax(1.0, vec_length(want->place));
  const bool is_inside = i / got->columns % 2;
  assert_true(same || is_inside);
  return same;
}
