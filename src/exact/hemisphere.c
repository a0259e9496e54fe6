/*
 * From half-slices to a pixel's AO, irradiance and bent normal.
 *
 * With S slices the hemisphere's measure is pi/S times the sum of all A(tangent
 * plane).  For few slices that is not exactly pi, so AO and irradiance are
 * ratio estimators: the open measure, and light times measure, over the whole
 * measure of the same slices.  Unit radiance everywhere then gives AO + E / pi
 * = 1 in every pixel.  The bent normal gets what the slices miss of the whole
 * plane's, which is S n, in proportion to AO.
 *
 * HBIL_MODE_GTAO sums the arcs as Jimenez et al. 2016 write them.  The normal
 * projected onto the slice's plane has a length and a signed angle gamma from
 * wo; between the horizons h1 < 0 < h2, no farther than pi/2 from gamma, lies
 *   length/4 (-cos(2 h1 - gamma) + cos gamma + 2 h1 sin gamma
 *             -cos(2 h2 - gamma) + cos gamma + 2 h2 sin gamma).
 */
#include "exact/hemisphere.h"

#include "exact/glossy.h"
#include "exact/passes.h"
#include "exact/planes.h"
#include "exact/settings.h"

static double arc(double gamma, double h) {
  h = clamp(h, gamma - PI / 2.0, gamma + PI / 2.0);
  return (-cos(2.0 * h - gamma) + cos(gamma) + 2.0 * h * sin(gamma)) / 4.0;
}

static void add_arcs(hemisphere *sum, const march *ahead, const march *behind) {
  const half_slice *h = &ahead->h;
  const double size = sqrt(h->nx * h->nx + h->ny * h->ny);
  const double gamma = atan2(h->nx, h->ny);
  sum->whole += h->weight * size * (arc(gamma, PI) + arc(gamma, -PI));
  sum->open += h->weight * size *
               (arc(gamma, ahead->covers.horizon.top.theta) +
                arc(gamma, -behind->covers.horizon.top.theta));
}

static void add_openness(hemisphere *sum, const march *m) {
  sum->whole += m->h.weight * m->h.whole;
  sum->open += m->h.weight * (m->h.whole - m->blocked);
}

static void add_bent_and_light(hemisphere *sum, const march *m) {
  const half_slice *h = &m->h;
  sum->bent = vec_add(sum->bent, h->weight, m->open_bent);
  sum->bent_whole =
      vec_add(sum->bent_whole, h->weight, exact_bent_integral(h, h->start));
  sum->unknown += h->weight * m->got.unknown;
  for (int i = 0; i < 3; ++i)
    sum->light[i] += h->weight * m->got.light[i];
  for (int i = 0; i < 3; ++i)
    sum->lobe[HBIL_GLOSSY_RED + i] += h->weight * m->got.lobe_light[i];
  sum->lobe[HBIL_GLOSSY_KNOWN] += h->weight * m->got.lobe_known;
  sum->lobe[HBIL_GLOSSY_WHOLE] += h->weight * m->lobe_whole;
}

void exact_add_slice(hemisphere *sum, const hbil_config *config,
                     const march *ahead, const march *behind) {
  if (config->model.mode == HBIL_MODE_GTAO &&
      ahead->covers.kind == COVERAGE_HORIZON) {
    add_arcs(sum, ahead, behind);
  } else {
    add_openness(sum, ahead);
    add_openness(sum, behind);
  }
  add_bent_and_light(sum, ahead);
  add_bent_and_light(sum, behind);
}

static void store_bent_normal(const receiver *r, const hemisphere *sum,
                              double slices, double ao,
                              exact_planes *gathered) {
  const vec3 missed =
      vec_add(vec_scale(slices, r->s.normal), -1.0, sum->bent_whole);
  const vec3 bent = vec_scale(1.0 / slices, vec_add(sum->bent, ao, missed));
  *exact_at(gathered, HBIL_LIGHT_BENT, r->x, r->y) = bent.x;
  *exact_at(gathered, HBIL_LIGHT_BENT + 1, r->x, r->y) = bent.y;
  *exact_at(gathered, HBIL_LIGHT_BENT + 2, r->x, r->y) = bent.z;
}

void exact_store_gathered(const receiver *r, const hemisphere *sum, int slices,
                          exact_planes *gathered) {
  const hbil_config *config = r->frame->config;
  const double ao = sum->open / sum->whole;
  exact_planes_clear(gathered, r->x, r->y);
  *exact_at(gathered, HBIL_LIGHT_AO, r->x, r->y) = ao;
  for (int i = 0; i < 3; ++i)
    *exact_at(gathered, HBIL_LIGHT_RED + i, r->x, r->y) =
        PI * sum->light[i] / sum->whole;
  if (exact_has_bent_normal(config))
    store_bent_normal(r, sum, slices, ao, gathered);
  if (gathered->count > HBIL_LIGHT_UNKNOWN && exact_fills_unknown(config))
    *exact_at(gathered, HBIL_LIGHT_UNKNOWN, r->x, r->y) =
        sum->unknown / sum->whole;
  if (gathered->count > HBIL_LIGHT_WEIGHT && exact_weighs_slices(config))
    *exact_at(gathered, HBIL_LIGHT_WEIGHT, r->x, r->y) = sum->whole;
  for (int i = 0; i < HBIL_GATHERED_GLOSSY_PLANES; ++i)
    if (gathered->count > EXACT_GLOSSY_PLANES + i)
      *exact_at(gathered, EXACT_GLOSSY_PLANES + i, r->x, r->y) = sum->lobe[i];
}

void exact_store_sky(const receiver *r, exact_planes *gathered) {
  exact_planes_clear(gathered, r->x, r->y);
  *exact_at(gathered, HBIL_LIGHT_AO, r->x, r->y) = 1.0;
  if (gathered->count > HBIL_LIGHT_WEIGHT &&
      exact_weighs_slices(r->frame->config))
    *exact_at(gathered, HBIL_LIGHT_WEIGHT, r->x, r->y) = 1.0;
}
