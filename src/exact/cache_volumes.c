/*
 * Light propagation volumes.
 *
 * Light goes from the middle of a cell through five faces of the next one, and
 * on from that one's middle towards each face, as a cosine lobe.  Of a lobe
 * about n of flux F the order-1 part is F/pi (1/4 + 1/2 n.w).
 */
#include <stdlib.h>

#include "exact/passes.h"
#include "exact/cache_methods.h"

/* --- cells --- */

exact_status exact_volumes_create(exact_volumes *volumes,
                                  const exact_cache *cache) {
  volumes->across = cache->voxels / 2;
  volumes->levels = cache->levels;
  const size_t n = (size_t)volumes->across + 2;
  volumes->cell =
      calloc(n * n * n * (size_t)volumes->levels, sizeof *volumes->cell);
  return volumes->cell ? EXACT_SUCCESS : EXACT_OUT_OF_MEMORY;
}

void exact_volumes_free(exact_volumes *volumes) {
  free(volumes->cell);
  volumes->cell = NULL;
}

exact_cell *exact_volumes_at(const exact_volumes *volumes, int level, int x,
                             int y, int z) {
  const size_t n = (size_t)volumes->across + 2;
  const size_t row =
      ((size_t)level * n + (size_t)(z + 1)) * n + (size_t)(y + 1);
  return volumes->cell + row * n + (size_t)(x + 1);
}

static bool is_inside(const exact_volumes *volumes, const int at[3]) {
  for (int i = 0; i < 3; ++i)
    if (at[i] < 0 || at[i] >= volumes->across)
      return false;
  return true;
}

/* Adds a lobe of that flux about n. */
static void add_lobe(exact_intensity *to, double flux, vec3 n) {
  to->mean += flux / PI * 0.25;
  to->slope = vec_add(to->slope, flux / PI * 0.5, n);
}

/* --- outside --- */

/* An environment of radiance L(d): light that travels along w has 3/2 s^2
 * L(-w). */
static void set_sky(exact_cell *cell, double size, hbil_far_field far_field,
                    const float environment[9][3]) {
  static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const double scale = 1.5 * size * size;
  for (int c = 0; c < 3; ++c) {
    double basis[3][9], slope[3] = {0.0, 0.0, 0.0};
    double mean =
        far_field == HBIL_FAR_CONSTANT ? (double)environment[0][c] : 0.0;
    for (int i = 0; i < 3 && far_field == HBIL_FAR_SH; ++i) {
      exact_sh_basis(axes[i], basis[i]);
      mean = basis[i][0] * (double)environment[0][c];
      for (int k = 1; k < 4; ++k)
        slope[i] -= basis[i][k] * (double)environment[k][c];
    }
    cell->light[c].mean = scale * fmax(mean, 0.0);
    cell->light[c].slope =
        vec(scale * slope[0], scale * slope[1], scale * slope[2]);
  }
}

/* What the next coarser level has there.  Its cells are twice as wide, so four
 * times the flux passes them. */
static void set_coarser(const exact_volumes *volumes, int level,
                        const int at[3], exact_cell *cell) {
  const double half = volumes->across / 2;
  int in[3];
  for (int i = 0; i < 3; ++i)
    in[i] = (int)floor((at[i] + 0.5 - half) / 2.0 + half);
  const exact_cell *from =
      exact_volumes_at(volumes, level + 1, in[0], in[1], in[2]);
  for (int c = 0; c < 3; ++c) {
    cell->light[c].mean = from->light[c].mean / 4.0;
    cell->light[c].slope = vec_scale(0.25, from->light[c].slope);
  }
}

void exact_volume_border(exact_volumes *volumes, hbil_far_field far_field,
                         const float environment[9][3]) {
  const int n = volumes->across + 2;
  for (int l = 0; l < volumes->levels; ++l)
    for (int i = 0; i < n * n * n; ++i) {
      const int at[3] = {i % n - 1, i / n % n - 1, i / n / n - 1};
      exact_cell *cell = exact_volumes_at(volumes, l, at[0], at[1], at[2]);
      if (is_inside(volumes, at))
        continue;
      if (l + 1 == volumes->levels)
        set_sky(cell, ldexp(2.0, l), far_field, environment);
      else
        set_coarser(volumes, l, at, cell);
    }
}

/* --- steps --- */

static vec3 along(int way) {
  const double v = way % 2 ? -1.0 : 1.0;
  return vec(way / 2 == 0 ? v : 0.0, way / 2 == 1 ? v : 0.0,
             way / 2 == 2 ? v : 0.0);
}

/* The flux that a cell sends through a face of its neighbour: `way` is where
 * the neighbour is, `face` where the face is in it; not the one between. */
static double flux_through(const exact_intensity *v, int way, int face) {
  /* a unit square at the distance 3/2: 4 atan(a b / (d sqrt(a a + b b + d d)))
   * with a = b = 1/2; the six neighbours' faces are all around */
  const double front = 4.0 * atan(1.0 / (3.0 * sqrt(11.0)));
  const double angle = face == way ? front : (2.0 * PI / 3.0 - front) / 4.0;
  const vec3 to = vec_normalize(vec_add(along(way), 0.5, along(face)));
  return angle * fmax(0.0, v->mean + vec_dot(v->slope, to));
}

double exact_flux_factor(const exact_intensity *v) {
  double sum = 0.0;
  for (int way = 0; way < 6; ++way)
    for (int face = 0; face < 6; ++face)
      if (face != (way ^ 1))
        sum += flux_through(v, way, face);
  return sum > 0.0 ? 4.0 * PI * v->mean / sum : 0.0;
}

/* A surface sends what a neighbour behind it would if all light there had its
 * radiance. */
static void add_source(exact_cell *cell, const exact_mip *mip, double size) {
  for (int k = 0; k < 6; ++k) {
    cell->opacity[k] = mip->along[k][3];
    for (int c = 0; c < 3; ++c) {
      const exact_intensity even = {1.5 * size * size * mip->along[k][c],
                                    {0.0, 0.0, 0.0}};
      for (int face = 0; face < 6; ++face)
        if (face != k) /* against the half-axis */
          add_lobe(&cell->light[c], flux_through(&even, k ^ 1, face),
                   along(face));
    }
  }
}

void exact_volume_sources(const exact_cache *cache, exact_volumes *sources) {
  const int n = sources->across;
  for (int i = 0; i < n * n * n * sources->levels; ++i) {
    const int at[3] = {i % n, i / n % n, i / n / n % n}, l = i / n / n / n;
    const int low[3] = {2 * at[0] - n, 2 * at[1] - n, 2 * at[2] - n};
    const exact_mip mip = exact_mip_of_voxels(cache, l, low);
    add_source(exact_volumes_at(sources, l, at[0], at[1], at[2]), &mip,
               ldexp(2.0, l));
  }
}

static void step_cell(const exact_volumes *sources, const exact_volumes *before,
                      int level, const int at[3], exact_cell *to) {
  const exact_cell *own = exact_volumes_at(sources, level, at[0], at[1], at[2]);
  for (int c = 0; c < 3; ++c)
    to->light[c] = own->light[c];
  for (int way = 0; way < 6; ++way) {
    int in[3] = {at[0], at[1], at[2]};
    in[way / 2] -= way % 2 ? -1 : 1;
    const exact_cell *from =
        exact_volumes_at(before, level, in[0], in[1], in[2]);
    /* what the neighbour's surfaces let pass, and this cell's, which face the
     * other way, don't hide */
    const exact_cell *other =
        exact_volumes_at(sources, level, in[0], in[1], in[2]);
    const double open =
        (1.0 - other->opacity[way]) * (1.0 - own->opacity[way ^ 1]);
    for (int c = 0; c < 3; ++c) {
      const double factor = open * exact_flux_factor(&from->light[c]);
      for (int face = 0; face < 6; ++face)
        if (face != (way ^ 1))
          add_lobe(&to->light[c],
                   factor * flux_through(&from->light[c], way, face),
                   along(face));
    }
  }
}

void exact_propagate(const exact_volumes *sources, const exact_volumes *before,
                     exact_volumes *after) {
  const int n = before->across;
  for (int i = 0; i < n * n * n * before->levels; ++i) {
    const int at[3] = {i % n, i / n % n, i / n / n % n}, l = i / n / n / n;
    step_cell(sources, before, l, at,
              exact_volumes_at(after, l, at[0], at[1], at[2]));
  }
}

/* --- probes --- */

static exact_intensity between(const exact_volumes *volumes, int level, int c,
                               const double q[3]) {
  exact_intensity sum = {0.0, {0.0, 0.0, 0.0}};
  int low[3];
  double f[3];
  for (int i = 0; i < 3; ++i) {
    low[i] = (int)clamp(floor(q[i]), -1.0, volumes->across - 1.0);
    f[i] = clamp(q[i] - low[i], 0.0, 1.0);
  }
  for (int k = 0; k < 8; ++k) {
    double weight = 1.0;
    for (int i = 0; i < 3; ++i)
      weight *= k >> i & 1 ? f[i] : 1.0 - f[i];
    const exact_intensity *v =
        &exact_volumes_at(volumes, level, low[0] + (k & 1),
                          low[1] + (k >> 1 & 1), low[2] + (k >> 2))
             ->light[c];
    sum.mean += weight * v->mean;
    sum.slope = vec_add(sum.slope, weight, v->slope);
  }
  return sum;
}

void exact_probe_volumes(const exact_frame *frame, const exact_cache *cache,
                         const exact_volumes *volumes,
                         const exact_planes *split, exact_probes *probes) {
  exact_place_probes(frame, split, probes);
  for (int k = 0; k < probes->count; ++k) {
    exact_probe *p = probes->probe + k;
    if (!p->valid)
      continue;
    const exact_stand s = exact_probe_stand(frame, cache, p);
    const double size = 2.0 * s.size; /* of a cell */
    const vec3 at = vec_add(s.at, 0.5 * size, s.n);
    const double half = volumes->across / 2 - 0.5;
    const double q[3] = {at.x / size + half, at.y / size + half,
                         at.z / size + half};
    /* the mean of a direction over the hemisphere is n/2 */
    p->known[0] = 1.0;
    p->known[1] = 1.5 * p->normal.x;
    p->known[2] = 1.5 * p->normal.y;
    p->known[3] = 1.5 * p->normal.z;
    for (int c = 0; c < 3; ++c) {
      const exact_intensity v = between(volumes, ilogb(s.size), c, q);
      /* radiance from direction d: (mean - slope.d) / (3/2 s^2), and the mean
       * of d d^T is 1/3 */
      const double scale = 1.0 / (1.5 * size * size);
      const vec3 with_d =
          vec_add(vec_scale(0.5 * v.mean * scale, s.n), -scale / 3.0, v.slope);
      exact_probe_add(frame, p->light[c], 1.0, with_d);
      p->light[c][0] = scale * (v.mean - 0.5 * vec_dot(v.slope, s.n));
    }
  }
}
