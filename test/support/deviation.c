#include "test/support/deviation.h"

#include "test/support/stress.h"

/* limit: of the root mean square, in units of the plane's largest value.  Two
 * dozen roundings of 2^-24 are 1.4e-6.  In the gather a rounding can decide
 * whether a sample rises over the horizon.  With the last-accepted fallback
 * that moves E_near by the sample's whole share. */
static const struct {
  const char *name;
  double limit;
} kinds[DEVIATIONS] = {
    [REPROJECT] = {"reproject: carried light", 0.0},
    [PUSH_PULL] = {"push/pull: filled light", 1e-6},
    [SPLIT_W] = {"split: inverse depth", 1e-6},
    [SPLIT_NORMAL] = {"split: normal", 1e-6},
    [SPLIT_LIGHT] = {"split: radiance", 1e-6},
    [GATHER_AO] = {"gather: AO", 1e-5},
    [GATHER_LIGHT] = {"gather: E_near", 1e-4},
    [GATHER_BENT] = {"gather: bent normal", 1e-5},
    [RECOMPOSE_AO] = {"recompose: AO", 1e-5},
    [RECOMPOSE_LIGHT] = {"recompose: E_near", 1e-5},
    [RECOMPOSE_BENT] = {"recompose: bent normal", 1e-5},
    [COMPOSITE_FAR] = {"composite: E_far", 1e-5},
    [COMPOSITE_CONE] = {"composite: cone", 1e-6},
    [COMPOSITE_INDIRECT] = {"composite: indirect", 1e-5},
    [COMPOSITE_BEAUTY] = {"composite: beauty", 1e-5},
};

const char *deviation_name(deviation_id id) {
  return kinds[id].name;
}

void add_deviation(deviation *all, deviation_id id, const exact_planes *got,
                   int got_first, const exact_planes *want, int want_first,
                   int count) {
  const size_t plane = (size_t)want->width * (size_t)want->height;
  const double *a = got->values + plane * (size_t)got_first;
  const double *b = want->values + plane * (size_t)want_first;
  const double most = largest_value(want, want_first, count);
  deviation *f = all + id;
  for (size_t i = 0; i < plane * (size_t)count; ++i) {
    const double off = fabs(a[i] - b[i]) / (most > 0.0 ? most : 1.0);
    f->largest = fmax(f->largest, isfinite(off) ? off : INFINITY);
    f->sum += off;
    f->squares += off * off;
    f->count++;
    f->far_off += !(off <= FAR_OFF);
  }
}

void add_light_deviation(deviation *all, deviation_id first,
                         const exact_planes *got, const exact_planes *want,
                         bool light, bool bent) {
  add_deviation(all, first, got, HBIL_LIGHT_AO, want, HBIL_LIGHT_AO, 1);
  if (light)
    add_deviation(all, first + 1, got, HBIL_LIGHT_RED, want, HBIL_LIGHT_RED, 3);
  if (bent)
    add_deviation(all, first + 2, got, HBIL_LIGHT_BENT, want, HBIL_LIGHT_BENT,
                  3);
}

void check_deviations(const deviation *all, double slack) {
  for (int i = 0; i < DEVIATIONS; ++i) {
    const deviation *f = all + i;
    if (!f->count)
      continue;
    if (getenv("HBIL_TEST_VERBOSE"))
      print_message("%s | %s | %.3g | %.3g\n", stress_case, kinds[i].name,
                    f->largest * 0x1p24, f->sum / (double)f->count * 0x1p24);
    check_case(kinds[i].name, sqrt(f->squares / (double)f->count),
               kinds[i].limit * slack);
  }
}
