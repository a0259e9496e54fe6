/* See pass_rows.h. */
#include "test/support/pass_rows.h"

#include "exact/glossy.h"
#include "exact/settings.h"
#include "lib/estimate_args.h"
#include "test/support/packing.h"
#include "test/support/stress.h"
#include "test/support/vectors.h"

/* A frame that is under way, and the device's stages. */
typedef struct under_way {
  setup *s;
  drawn *d;
  uint32_t index;
  bool carries, planted;
  exact_planes carried, split, gathered, resolved;
} under_way;

/* ------------------------------------------------------------------------ */
/* Bounds                                                                    */

typedef enum measure {
  SAME,    /* no bit differs */
  OWN,     /* each relative to itself */
  LARGEST, /* the largest difference, relative to the largest value */
  ALL,     /* the largest difference */
  RMSE,    /* the root mean square, relative to that of the values */
  LOST8,   /* what mantissas of 8 or 10 bits lose, and `limit` of the largest */
  LOST10,  /* value before */
  BENT     /* length of the difference; those longer than 1 are directions */
} measure;

typedef struct bound {
  measure how;
  double limit;
} bound;

/* Some planes of a stage.  plain: of SCENES, in floats; packed: in words.
 * hard: the root mean square of HARD contents, relative to the largest value
 * unless plain.how is ALL.
 * Of WILD ones and HARD ones in words, FAR_SHARE of the values may be off by
 * more than FAR_OFF of the largest: samples that a rounding lets rise, sectors
 * that it covers, gradients of surfaces seen edge on (measured: none, mostly).
 */
typedef struct part {
  const char *what;
  int first, count;
  bound plain, packed;
  double hard;
} part;

#define FAR_OFF 1e-3
#define FAR_SHARE 0.01

/* Words are carried over as they are. */
static const part carried_parts[] = {
    {"light", 0, HBIL_CARRIED_PLANES, {SAME, 0}, {SAME, 0}, 0.0},
};
/* Derived: averages of 4, at most 10 levels down and up in fp32.  Packed: 6
 * levels each (10 of large pictures), and each rounds by half a step, which is
 * 2^-7 of the brightest channel at most. */
static const part filled_parts[] = {
    {"light", 0, 3, {LARGEST, 1e-6}, {LARGEST, 12 * 0x1p-8}, 1e-6},
    {"weight", HBIL_CARRIED_WEIGHT, 1, {ALL, 1e-6}, {ALL, 1e-6}, 1e-6},
};
/* Derived: four roundings; a rotation, a length and a product with roundings
 * of 6e-8 each, and six of decoding, or 12 of sRGB; those of sums.  Packed
 * normals: half a step of 1/32767 in u and v is sqrt(18)/2 steps in the middle
 * of a face. */
static const part split_parts[] = {
    {"inverse depth", HBIL_SPLIT_W, 1, {OWN, 5e-7}, {OWN, 5e-7}, 1e-6},
    {"normal", HBIL_SPLIT_NORMAL, 3, {ALL, 1e-6}, {BENT, 6.6e-5}, 1e-6},
    {"radiance", HBIL_SPLIT_RED, 3, {LARGEST, 2e-6}, {LOST8, 2e-6}, 2e-6},
};
/* Measured: AO 1.3e-7, E_near 4.8e-7, bent normals 1.9e-7 (the requirement is
 * 1e-3).  Packed: half a step of 16 bits, a dithered one of 8 bits, and units
 * of 1/1023, 1/1023 and 1/511.  Lobes: lobe_limit(). */
static const part gathered_parts[] = {
    {"AO", 0, 1, {RMSE, 1e-5}, {ALL, 0.5 / 65535 + 1e-5}, 1e-5},
    {"E_near", HBIL_LIGHT_RED, 3, {RMSE, 1e-5}, {LOST10, 1e-5}, 1e-4},
    {"bent normal", HBIL_LIGHT_BENT, 3, {RMSE, 1e-5}, {BENT, 2.41e-3}, 1e-5},
    {"unknown", HBIL_LIGHT_UNKNOWN, 1, {RMSE, 1e-5}, {ALL, 1. / 255}, 1e-4},
    {"weight", HBIL_LIGHT_WEIGHT, 1, {RMSE, 1e-5}, {RMSE, 1e-5}, 1e-5},
};
static const part lobe_parts[] = {
    {"light", EXACT_GLOSSY_PLANES, 3, {RMSE, 1}, {RMSE, 1}, 1e-3},
    {"known lobe",
     EXACT_GLOSSY_PLANES + HBIL_GLOSSY_KNOWN,
     1,
     {RMSE, 1},
     {RMSE, 1},
     1e-3},
    {"whole lobe",
     EXACT_GLOSSY_PLANES + HBIL_GLOSSY_WHOLE,
     1,
     {RMSE, 5e-6},
     {RMSE, 5e-6},
     1e-5},
};
/* Measured: 2.7e-6 and, of bent normals, 1.2e-6.
 * Errors of variances follow those of means.  Measured: 3.2e-6, and 2.6e-5 at
 * a pixel whose mean AO is off by 4.2e-5 (HBIL_STRESS_CASE=1795972092). */
static const part resolved_parts[] = {
    {"AO", 0, 1, {RMSE, 1e-5}, {RMSE, 1e-5}, 1e-5},
    {"E_near", HBIL_LIGHT_RED, 3, {RMSE, 1e-5}, {RMSE, 1e-5}, 1e-5},
    {"bent normal", HBIL_LIGHT_BENT, 3, {RMSE, 1e-5}, {RMSE, 1e-5}, 1e-5},
    {"unknown", HBIL_LIGHT_UNKNOWN, 1, {RMSE, 1e-5}, {RMSE, 1e-5}, 1e-5},
    {"glossy", EXACT_GLOSSY_PLANES, 4, {RMSE, 1e-5}, {RMSE, 1e-5}, 1e-4},
    {"variance of AO",
     EXACT_RESOLVED_ERRORS,
     1,
     {ALL, 5e-5},
     {ALL, 5e-5},
     1e-5},
    {"variance of E_near",
     EXACT_RESOLVED_ERRORS + 1,
     1,
     {ALL, 5e-5},
     {ALL, 5e-5},
     1e-5},
};
/* Derived: four roundings; a dozen of them. */
static const part history_parts[] = {
    {"inverse depth", HBIL_HISTORY_W, 1, {OWN, 5e-7}, {OWN, 5e-7}, 1e-6},
    {"light", HBIL_HISTORY_RED, 3, {LARGEST, 3e-6}, {LOST8, 3e-6}, 1e-5},
};

/* ------------------------------------------------------------------------ */
/* Comparing                                                                 */

/* How far a pixel is off, in the measure's unit.  most: the largest value. */
static double off_by(const exact_planes *got, const exact_planes *want,
                     const part *p, bound b, double most, int x, int y) {
  double g[HBIL_GATHERED_PLANES], w[HBIL_GATHERED_PLANES];
  double size = 0.0, off = 0.0;
  if (b.how == LOST8 || b.how == LOST10)
    return packed_loss(got, want, p->first, b.how == LOST8 ? 8 : 10,
                       b.limit * most, x, y);
  for (int c = 0; c < p->count; ++c) {
    g[c] = *exact_at(got, p->first + c, x, y);
    w[c] = *exact_at(want, p->first + c, x, y);
    size = fmax(size, fabs(w[c]));
  }
  if (b.how == BENT && size > 1.0) {
    normalize(g);
    normalize(w);
  }
  for (int c = 0; c < p->count; ++c) {
    const double d = fabs(g[c] - w[c]);
    if (!isfinite(d))
      return HUGE_VAL;
    off = b.how == BENT ? hypot(off, d) : fmax(off, d);
  }
  return off > 0.0 && b.how == OWN        ? off / size
         : b.how == LARGEST && most > 0.0 ? off / most
                                          : off;
}

/* Roundings decide which sectors a sample covers, whether two of finite
 * thickness overlap, and, of depths in few steps, which one is the higher: so
 * many pixels may be off by whole samples. */
static int few_pixels(const under_way *u) {
  const hbil_config *c = &u->s->config;
  const bool decides = u->d->kind != SCENES || !isinf(c->model.thickness) ||
                       !isinf(c->model.relative_thickness) ||
                       c->inputs.depth.component == HBIL_FLOAT16;
  return decides ? 1 + (int)setup_pixels(u->s) / 1000 : 0;
}

/* The largest difference but for a few pixels; *at: where it is. */
static double largest_but_few(const exact_planes *got, const exact_planes *want,
                              const part *p, bound b, int few, int at[2]) {
  const double most = largest_value(want, p->first, p->count);
  double off[4] = {-1.0, -1.0, -1.0, -1.0}; /* descending */
  int places[4][2] = {{0}};
  few = few < 3 ? few : 3;
  for (int y = 0; y < want->height; ++y)
    for (int x = 0; x < want->width; ++x) {
      const double here = off_by(got, want, p, b, most, x, y);
      int i = 3;
      if (here <= off[i])
        continue;
      for (; i > 0 && here > off[i - 1]; --i) {
        off[i] = off[i - 1];
        memcpy(places[i], places[i - 1], sizeof *places);
      }
      off[i] = here;
      places[i][0] = x;
      places[i][1] = y;
    }
  memcpy(at, places[few], sizeof *places);
  return off[0] == HUGE_VAL ? HUGE_VAL : fmax(off[few], 0.0);
}

/* The number of values that are far off.  packed: words lose a part. */
static double far_off(const exact_planes *got, const exact_planes *want,
                      const part *p, bool packed) {
  const double most = largest_value(want, p->first, p->count);
  const bound *b = &p->packed;
  double near = FAR_OFF * (p->plain.how == ALL ? 1.0 : most), count = 0.0;
  if (packed && (b->how == LOST8 || b->how == LOST10))
    near += 0x1p-8 * most;
  else if (packed && b->how != RMSE)
    near += b->limit * (b->how == LARGEST ? most : 1.0);
  for (int c = p->first; c < p->first + p->count; ++c)
    for (int i = 0; i < want->width * want->height; ++i)
      count +=
          !(fabs(*exact_at(got, c, i % want->width, i / want->width) -
                 *exact_at(want, c, i % want->width, i / want->width)) <= near);
  return count;
}

static void tell_pixel(const under_way *u, const part *p, const int at[2],
                       const exact_planes *got, const exact_planes *want) {
  print_error("frame %u, pixel (%d, %d):\n", u->index, at[0], at[1]);
  for (int c = p->first; c < p->first + p->count; ++c)
    print_error("  %.9g should be %.9g\n", *exact_at(got, c, at[0], at[1]),
                *exact_at(want, c, at[0], at[1]));
}

/* Prints the largest and the mean difference in units of 2^-24 of the largest
 * value. */
static void tell_roundings(const under_way *u, const char *what, const part *p,
                           const exact_planes *got, const exact_planes *want) {
  const double most = largest_value(want, p->first, p->count);
  const size_t from = setup_pixels(u->s) * (size_t)p->first;
  const size_t count = setup_pixels(u->s) * (size_t)p->count;
  double sum = 0.0, largest = 0.0;
  for (size_t i = from; i < from + count && most > 0.0; ++i) {
    const double off = fabs(got->values[i] - want->values[i]) / most;
    largest = fmax(largest, off);
    sum += off;
  }
  print_message("%s | %s | %.3g | %.3g\n",
                u->d->kind == SCENES ? "scene" : content_names[u->d->what],
                what, largest * 0x1p24, sum / (double)count * 0x1p24);
}

/* few: pixels that don't count. */
static void check_part(const under_way *u, const char *pass, const part *p,
                       bool packed, int few, const exact_planes *got,
                       const exact_planes *want) {
  const bound b = packed ? p->packed : p->plain;
  /* no decision is in these, whatever the contents */
  const bool always = b.how == SAME || b.how == OWN || b.how == LOST8;
  double off, limit = b.limit;
  char what[64];
  int at[2];
  const double largest = largest_but_few(got, want, p, b, few, at);
  if (!always && u->d->kind == HARD && !packed) {
    off = rms_over_largest(got, want, p->first, p->count, few);
    if (b.how == ALL)
      off *= largest_value(want, p->first, p->count);
    limit = p->hard * (u->d->what == AWAY ? 10.0 : 1.0);
  } else if (!always && u->d->kind != SCENES) {
    off = far_off(got, want, p, packed);
    limit = 3.0 + FAR_SHARE * p->count * (double)setup_pixels(u->s);
  } else if (b.how == RMSE) {
    off = relative_rmse_but_few(got, want, p->first, p->count, few);
  } else {
    off = largest;
    if (b.how == LOST8 || b.how == LOST10)
      limit = PACKED_LOSS_LIMIT;
  }
  snprintf(what, sizeof what, "%s: %s", pass, p->what);
  if (getenv("HBIL_TEST_VERBOSE") && !packed)
    tell_roundings(u, what, p, got, want);
  if (!(off <= limit))
    tell_pixel(u, p, at, got, want);
  check_case(what, off, limit);
}

/* Planes that the plan doesn't have, or that hold nothing, aren't compared. */
static bool has_part(const under_way *u, hbil_stage stage, const part *p) {
  if (!stage_has(u->s, stage, p->first))
    return false;
  if (stage < HBIL_STAGE_GATHERED || p->first == HBIL_LIGHT_AO)
    return true;
  if (p->first == HBIL_LIGHT_UNKNOWN)
    return exact_fills_unknown(&u->s->config) && gathers_light(u->s);
  return p->first != HBIL_LIGHT_RED || gathers_light(u->s);
}

#define PARTS(list) list, (int)(sizeof list / sizeof *list)
static void check_parts(const under_way *u, const char *pass, hbil_stage stage,
                        const part *parts, int count, const exact_planes *got,
                        const exact_planes *want) {
  const bool packed = u->s->config.sampling.storage != HBIL_STORAGE_FLOAT32 &&
                      stage != HBIL_STAGE_RESOLVED &&
                      stage != HBIL_STAGE_AO_RESOLVED;
  for (int i = 0; i < count; ++i)
    if (has_part(u, stage, parts + i))
      check_part(u, pass, parts + i, packed,
                 stage == HBIL_STAGE_GATHERED || stage == HBIL_STAGE_AO_GATHERED
                     ? few_pixels(u)
                     : 0,
                 got, want);
}

/* ------------------------------------------------------------------------ */
/* Rows                                                                      */

static exact_planes no_planes(const under_way *u, int count) {
  return checked_planes((int)u->s->config.width, (int)u->s->config.height,
                        count);
}

/* Reads a stage with all planes that it can have; those that the plan lacks, or
 * doesn't define, are 0. */
static exact_planes read_stage(const under_way *u, hbil_stage stage) {
  static const int counts[] = {[HBIL_STAGE_HISTORY] = HBIL_HISTORY_PLANES,
                               [HBIL_STAGE_CARRIED] = HBIL_CARRIED_PLANES,
                               [HBIL_STAGE_SPLIT] = HBIL_SPLIT_PLANES,
                               [HBIL_STAGE_GATHERED] = EXACT_GLOSSY_GATHERED,
                               [HBIL_STAGE_RESOLVED] = EXACT_RESOLVED_PLANES,
                               [HBIL_STAGE_AO_GATHERED] = EXACT_GLOSSY_GATHERED,
                               [HBIL_STAGE_AO_RESOLVED] =
                                   EXACT_RESOLVED_PLANES};
  exact_planes all = no_planes(u, counts[stage]);
  exact_planes some = stage_read(u->s, stage);
  memcpy(all.values, some.values, count_values(&some) * sizeof *all.values);
  exact_planes_free(&some);
  if (stage >= HBIL_STAGE_GATHERED && !gathers_light(u->s))
    memset(exact_at(&all, HBIL_LIGHT_RED, 0, 0), 0,
           3 * setup_pixels(u->s) * sizeof *all.values);
  return all;
}

/* Replaces a stage, and returns what its words hold of it. */
static exact_planes planted(const under_way *u, hbil_stage stage,
                            exact_planes planes) {
  stage_write(u->s, stage, &planes);
  exact_planes_free(&planes);
  return read_stage(u, stage);
}

/* A first frame has nothing to carry over, which the statistics then tell. */
static void check_reproject(under_way *u) {
  if (!u->carries) {
    setup_run(u->s, enqueue_reproject);
    return;
  }
  exact_planes history = read_stage(u, HBIL_STAGE_HISTORY);
  exact_planes want = no_planes(u, HBIL_CARRIED_PLANES);
  checked_reproject(&u->s->job, &history, &want);
  setup_run(u->s, enqueue_reproject);
  u->carried = read_stage(u, HBIL_STAGE_CARRIED);
  check_parts(u, "reproject", HBIL_STAGE_CARRIED, PARTS(carried_parts),
              &u->carried, &want);
  planes_free(&history, &want);
}

/* Holes of all sizes; what is no hole is light, or sky that nothing fills. */
static exact_planes random_carried(under_way *u) {
  static const double shares[] = {0.0, 0.02, 0.5, 0.97, 1.0};
  random_state *r = &u->d->r;
  const double valid = ANY_OF(r, shares), sky = ANY_OF(r, shares);
  exact_planes p = no_planes(u, HBIL_CARRIED_PLANES);
  for (int i = 0; i < p.width * p.height; ++i) {
    const bool lit = random_unit(r) < valid;
    const int x = i % p.width, y = i / p.width;
    for (int c = 0; c < 3 && lit; ++c)
      *exact_at(&p, c, x, y) = (double)(float)(10.0 * random_unit(r));
    *exact_at(&p, HBIL_CARRIED_WEIGHT, x, y) = lit                    ? 1.0
                                               : random_unit(r) < sky ? -1.0
                                                                      : 0.0;
  }
  return p;
}

static void check_push_pull(under_way *u) {
  if (!u->carries)
    return;
  if (u->planted)
    u->carried = planted(u, HBIL_STAGE_CARRIED, random_carried(u));
  exact_planes want = u->carried;
  checked_push_pull(&want);
  setup_run(u->s, enqueue_push_pull);
  u->carried = read_stage(u, HBIL_STAGE_CARRIED);
  check_parts(u, "push_pull", HBIL_STAGE_CARRIED, PARTS(filled_parts),
              &u->carried, &want);
  exact_planes_free(&want);
}

/* Packed normals of the sky are anything. */
static void forget_sky(const exact_planes *got, const exact_planes *split) {
  for (int y = 0; y < split->height; ++y)
    for (int x = 0; x < split->width; ++x)
      for (int c = 0; c < 3 && *exact_at(split, HBIL_SPLIT_W, x, y) < -1e29;
           ++c)
        *exact_at(got, HBIL_SPLIT_NORMAL + c, x, y) =
            *exact_at(split, HBIL_SPLIT_NORMAL + c, x, y);
}

static void check_split(under_way *u) {
  exact_planes want = no_planes(u, HBIL_SPLIT_PLANES);
  exact_split(&u->s->job, u->carries ? &u->carried : NULL, &want);
  setup_run(u->s, enqueue_split);
  u->split = read_stage(u, HBIL_STAGE_SPLIT);
  forget_sky(&want, &u->split);
  check_parts(u, "split", HBIL_STAGE_SPLIT, PARTS(split_parts), &u->split,
              &want);
  exact_planes_free(&want);
}

/* Derived: a lobe's terms are up to sqrt(k) / 2 = 12 times as large as their
 * sum, so it loses four bits.  Measured: 5.1e-7.  An interval that is narrower
 * than a sector takes none of it or all, up to 3000 times as much as it has.
 * Measured: 1.3e-3. */
static double lobe_limit(const hbil_model *m) {
  return isinf(m->thickness) && isinf(m->relative_thickness) ? 5e-6 : 5e-3;
}

static void check_lobes(const under_way *u, const exact_planes *want) {
  part parts[3];
  memcpy(parts, lobe_parts, sizeof parts);
  for (int i = 0; i < 2; ++i)
    parts[i].plain.limit = parts[i].packed.limit =
        lobe_limit(&u->s->config.model);
  check_parts(u, "gather, glossy", HBIL_STAGE_GATHERED, parts, 3, &u->gathered,
              want);
}

/* A single slice that hardly sees its hemisphere (1e-6 of a slice is rounding)
 * has few digits, and as little weight. */
static void forget_unseen(const exact_planes *want, const exact_planes *got) {
  for (int i = 0; i < want->width * want->height; ++i) {
    const int x = i % want->width, y = i / want->width;
    for (int p = 0; p < want->count; ++p)
      if (p != HBIL_LIGHT_WEIGHT &&
          *exact_at(want, HBIL_LIGHT_WEIGHT, x, y) < 1e-4)
        *exact_at(want, p, x, y) = *exact_at(got, p, x, y);
  }
}

static void check_gather(under_way *u) {
  exact_planes want = no_planes(u, EXACT_GLOSSY_GATHERED);
  checked_gather(&u->s->job, &u->split, &want);
  setup_run(u->s, enqueue_gather);
  u->gathered = read_stage(u, HBIL_STAGE_GATHERED);
  if (exact_weighs_slices(&u->s->config))
    forget_unseen(&want, &u->gathered);
  check_parts(u, "gather", HBIL_STAGE_GATHERED, PARTS(gathered_parts),
              &u->gathered, &want);
  check_lobes(u, &want);
  exact_planes_free(&want);
  exact_estimate_frame(&u->s->job, &u->split, &u->gathered);
}

static bool is_surface(const under_way *u, int x, int y) {
  return *exact_at(&u->split, HBIL_SPLIT_W, x, y) >
         (exact_is_orthographic(&u->s->config) ? -1e29 : 0.0);
}

/* Plausible light: AO in 0..1, here and there a rounding above 1, unit bent
 * normals, a part of what is blocked behind surfaces that face away.  The sky
 * is open and dark.  What isn't gathered is NaN, so nobody may read it. */
static exact_planes random_light(under_way *u, int count, bool gathered) {
  random_state *r = &u->d->r;
  exact_planes p = no_planes(u, count);
  for (int i = 0; i < p.width * p.height; ++i) {
    const int x = i % p.width, y = i / p.width;
    const double ao = i % 11 ? random_unit(r) : gathered ? 1.0 : 1.0 + 0x1p-23;
    double n[3] = {random_unit(r) - 0.5, random_unit(r) - 0.5, 0.3};
    normalize(n);
    const bool left_out = gathered && !exact_is_gathered(&u->s->config, x, y);
    for (int k = 0; k < count; ++k) {
      const double value = random_unit(r);
      double *at = exact_at(&p, k, x, y);
      *at = left_out                  ? (double)NAN
            : !is_surface(u, x, y)    ? k == HBIL_LIGHT_AO
            : k == HBIL_LIGHT_AO      ? ao
            : k < HBIL_LIGHT_BENT     ? 3.0 * value
            : k < HBIL_LIGHT_UNKNOWN  ? n[k - HBIL_LIGHT_BENT]
            : k == HBIL_LIGHT_UNKNOWN ? fmax(0.0, 1.0 - ao) * value
                                      : 0.05 + value;
    }
  }
  return p;
}

/* Errors are roots of variances, and these are differences of squares, so fp32
 * loses digits of the squares: errors become variances in units of the largest
 * square of the light. */
static void to_variances(const under_way *u, const exact_planes *light,
                         const exact_planes *errors) {
  for (int i = 0; i < 2; ++i) {
    const double most = largest_value(light, i, i ? 3 : 1);
    const double unit = u->s->job.error_factors[i] * (most > 0.0 ? most : 1.0);
    for (int k = 0; k < (int)setup_pixels(u->s) && unit > 0.0; ++k) {
      double *at = exact_at(errors, EXACT_RESOLVED_ERRORS + i,
                            k % errors->width, k / errors->width);
      *at = *at * *at / (unit * unit);
    }
  }
}

static void check_recompose(under_way *u) {
  exact_planes light = u->gathered, want = no_planes(u, EXACT_RESOLVED_PLANES);
  if (u->planted)
    light = planted(u, HBIL_STAGE_GATHERED,
                    random_light(u, EXACT_GLOSSY_GATHERED, true));
  setup_run(u->s, enqueue_recompose);
  exact_recompose(&u->s->job, &u->split, &light, &want);
  u->resolved = read_stage(u, HBIL_STAGE_RESOLVED);
  exact_planes got = read_stage(u, HBIL_STAGE_RESOLVED);
  to_variances(u, &light, &got);
  to_variances(u, &light, &want);
  check_parts(u, "recompose", HBIL_STAGE_RESOLVED, PARTS(resolved_parts), &got,
              &want);
  planes_free(&got, &want);
  if (u->planted)
    exact_planes_free(&light);
}

/* The search for the outputs, where it is one of its own: gather and recompose
 * have run it behind that of light.  Writes the outputs that show it. */
static void check_ao_search(const under_way *u, exact_planes *out) {
  hbil_config config;
  setup s = *u->s;
  under_way ao = *u;
  hbil_buffer b;
  const bool searches = exact_searches_ao(&u->s->config, &config);
  assert_int_equal(searches,
                   hbil_plan_buffer(u->s->plan, HBIL_STAGE_AO_GATHERED, &b) ==
                       HBIL_SUCCESS);
  if (!searches)
    return;
  s.config = config;
  s.job.config = &config;
  ao.s = &s;
  exact_planes want = no_planes(u, EXACT_GLOSSY_GATHERED);
  checked_gather(&s.job, &u->split, &want);
  exact_planes got = read_stage(&ao, HBIL_STAGE_AO_GATHERED);
  if (exact_weighs_slices(&config))
    forget_unseen(&want, &got);
  check_parts(&ao, "gather of ao", HBIL_STAGE_AO_GATHERED,
              PARTS(gathered_parts), &got, &want);
  exact_planes_free(&want);
  want = no_planes(u, EXACT_RESOLVED_PLANES);
  exact_recompose(&s.job, &u->split, &got, &want);
  exact_planes resolved = read_stage(&ao, HBIL_STAGE_AO_RESOLVED);
  exact_composite_ao(&s.job, &resolved, out);
  to_variances(&ao, &got, &resolved);
  to_variances(&ao, &got, &want);
  check_parts(&ao, "recompose of ao", HBIL_STAGE_AO_RESOLVED,
              PARTS(resolved_parts), &resolved, &want);
  planes_free(&got, &want, &resolved);
}

/* What light that is guessed from the frame may be off by, beside a given sky.
 * Derived: two depths of four roundings each, over HBIL_PLANE_TOLERANCE, make a
 * neighbour's share wrong by 4.8e-5 (mean_sky_light()), those of three
 * neighbours the mean of four by 3.6e-5 of a sky's light, and the share that is
 * guessed has a slope of 2.  Measured: 7.5e-6 */
static double guess_limit(const under_way *u) {
  const hbil_frame *f = &u->s->frame;
  double sky = 0.0;
  for (int c = 0; c < 3; ++c)
    sky = fmax(sky, (double)f->environment[0][c]);
  return u->s->config.model.far_field == HBIL_FAR_FRAME && sky > 0.0 ? 7e-5
                                                                     : 0.0;
}

/* Derived: half floats round by 2^-11, and have no larger value than 65504;
 * else a dozen fp32 roundings, and of glossy light some thirty and those of the
 * lobe's 1 - cosine, of 2^-24, times k of 75. */
static void check_output(const under_way *u, plane_id id,
                         const exact_planes *got, exact_planes *want) {
  const hbil_component component = plane_format(&u->s->config, id)->component;
  const bool half = component == HBIL_FLOAT16;
  const bool guessed = id == PLANE_FAR || id == PLANE_INDIRECT ||
                       id == PLANE_BEAUTY || id == PLANE_UNKNOWN ||
                       id == PLANE_GLOSSY;
  const double limit = (half                 ? 5e-4
                        : id == PLANE_GLOSSY ? 2e-5
                                             : 3e-6) +
                       (guessed ? guess_limit(u) : 0.0);
  const part p = {plane_name(id),   plane_first(id),  plane_channels(id),
                  {LARGEST, limit}, {LARGEST, limit}, half ? 5e-4 : 1e-5};
  for (int c = p.first; half && c < p.first + p.count; ++c)
    for (int i = 0; i < want->width * want->height; ++i) {
      double *at = exact_at(want, c, i % want->width, i / want->width);
      *at = fmin(*at, 65504.0);
    }
  if (component)
    check_part(u, "composite", &p, false, 0, got, want);
}

static void check_composite(under_way *u) {
  exact_planes want = no_planes(u, EXACT_OUTPUT_PLANES);
  exact_planes history = no_planes(u, HBIL_HISTORY_PLANES);
  if (u->planted)
    u->resolved = planted(u, HBIL_STAGE_RESOLVED,
                          random_light(u, EXACT_RESOLVED_PLANES, false));
  setup_run(u->s, enqueue_composite);
  exact_composite(&u->s->job, &u->resolved, &want, &history);
  check_ao_search(u, &want);
  if (u->s->config.outputs.glossy.component)
    exact_glossy(&u->s->job, &u->split, &u->resolved, NULL, &want);
  exact_planes got = outputs_read(u->s);
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    check_output(u, id, &got, &want);
  planes_free(&got, &want);
  if (stage_has(u->s, HBIL_STAGE_HISTORY, 0)) {
    got = read_stage(u, HBIL_STAGE_HISTORY);
    part parts[2] = {history_parts[0], history_parts[1]};
    parts[1].plain.limit += guess_limit(u);
    parts[1].packed.limit += guess_limit(u);
    check_parts(u, "composite", HBIL_STAGE_HISTORY, PARTS(parts), &got,
                &history);
    exact_planes_free(&got);
  }
  exact_planes_free(&history);
}

/* The passes in their order. */
static void (*const rows[])(under_way *u) = {check_reproject, check_push_pull,
                                             check_split,     check_gather,
                                             check_recompose, check_composite};

void check_passes(setup *s, drawn *d, uint32_t index, bool planted) {
  under_way u = {.s = s, .d = d, .index = index, .planted = planted};
  u.carries = index > 0 && stage_has(s, HBIL_STAGE_CARRIED, 0);
  s->job.bounces = u.carries ? index : 0;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i)
    rows[i](&u);
  s->job.previous = s->frame.camera;
  planes_free(&u.carried, &u.split, &u.gathered, &u.resolved);
}
