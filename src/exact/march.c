/*
 * One half-slice, walked outwards from a pixel.
 *
 * A sample at the ray offset e, |e| along the half-slice, with inverse depth
 * w', is compared with the inverse depth that the receiver's own surface would
 * have there, if it went on as a plane: excess = (w' - w0 - slope.e) / |e|.  It
 * is 0 on that plane at any tilt, and the larger it is, the nearer to wo the
 * sample's direction lies.  So most samples are dismissed without a root or an
 * angle: only an excess above the coverage's threshold can hide anything.
 *
 * The plane is that of the surface and not the tangent plane of the shading
 * normal, because samples lie up to half a pixel beside the line of the
 * half-slice, and e is their true offset.  A plane of the same slope as the
 * surface carries them to the line; one of another slope would lift samples of
 * the surface itself above it.  The threshold begins at the excess of the
 * tangent plane (slice.h).  Samples of the exact gather lie on the line, so for
 * them any plane will do.
 *
 * What a sample newly hides takes the sample's radiance, as far as the sample
 * faces the receiver: the facing fade is a smoothstep of the cosine between its
 * normal and the direction back.  The rest falls to the back-facing fallback.
 *
 * The back of a sample lies deeper along its own ray by the thickness, which is
 * another inverse depth, and so another excess at the same |e|.
 *
 * Samples of finite thickness that overlap are joined and covered together
 * (COVERAGE_SECTORS).  With model.extrapolate, a sample stands for its step
 * (hbil_sample_extent()), on a plane whose slope along the half-slice is the
 * minmod of those to a pixel before it and a pixel behind it.  Each pixel of
 * the step covers what its own thickness can, so that thin occluders, which
 * leave gaps between the pixels, don't cover the whole step.  Its light weighs
 * by what it adds to the joined angles: by the derivative of A after the
 * cotangent, times the cotangents that it adds.
 */
#include "exact/march.h"

#include <string.h>

#include "exact/camera.h"
#include "exact/lobe.h"
#include "exact/planes.h"
#include "exact/settings.h"
#include "lib/sampling_pattern.h"

/* ------------------------------------------------------------------------ */
/* The receiver                                                              */

/* The relative rounding error of a depth input, with a margin. */
static double depth_tolerance(const hbil_config *c) {
  return c->inputs.depth.component == HBIL_FLOAT16 ? ldexp(1.0, -10)
                                                   : ldexp(1.0, -22);
}

/* The unit roundoff of a normal's components, with a margin of eight.  An error
 * in octahedral coordinates turns the normal by sqrt(18) times as much at most.
 */
static double normal_tolerance(const hbil_config *c) {
  static const int bits[] = {
      [HBIL_FLOAT16] = 10, [HBIL_UNORM8] = 7,   [HBIL_SNORM8] = 7,
      [HBIL_UNORM16] = 15, [HBIL_SNORM16] = 15, [HBIL_RGB10A2_UNORM] = 9,
      [HBIL_IMAGE] = 0};
  const int exponent = bits[c->inputs.normal.component];
  const double input = exponent ? ldexp(1.0, -exponent) : 0.0;
  const double octahedral =
      c->inputs.normal_encoding == HBIL_NORMAL_OCTAHEDRAL ? 4.0 : 1.0;
  const double stored =
      ldexp(1.0, c->sampling.storage != HBIL_STORAGE_FLOAT32 ? -13 : -21);
  return fmax(input * octahedral, stored);
}

/* What the rounding of the normal alone may raise a sample of the receiver's
 * own plane by, in the plane's gradient. */
static double least_excess(const hbil_config *c, const surface *s) {
  const double cosine = -vec_dot(s->normal, s->ray) / vec_length(s->ray);
  return normal_tolerance(c) * s->unit / (cosine * cosine * vec_length(s->ray));
}

/* Where rounding explains what the surface's slope differs from the tangent
 * plane's, it is that. */
static void ignore_rounding(receiver *r) {
  surface *s = &r->s;
  const double share = depth_tolerance(r->frame->config);
  const double flat_x = s->grad_x * r->pixel_x;
  const double flat_y = s->grad_y * r->pixel_y;
  const double off_x =
      share * (fabs(s->w) + fabs(flat_x)) + r->least * r->pixel_x;
  const double off_y =
      share * (fabs(s->w) + fabs(flat_y)) + r->least * r->pixel_y;
  if (fabs(s->slope_x * r->pixel_x - flat_x) <= off_x &&
      fabs(s->slope_y * r->pixel_y - flat_y) <= off_y) {
    s->slope_x = s->grad_x;
    s->slope_y = s->grad_y;
  }
}

receiver exact_receiver(const exact_frame *frame, const exact_planes *split,
                        int x, int y, coverage_kind kind, interval *list) {
  const hbil_config *config = frame->config;
  receiver r;
  memset(&r, 0, sizeof(r));
  r.frame = frame;
  r.split = split;
  r.s = exact_surface_at(frame, split, x, y);
  r.x = x;
  r.y = y;
  r.kind = kind;
  r.pixel_x = 1.0 / frame->camera.fx;
  r.pixel_y = 1.0 / frame->camera.fy;
  r.w_scale = 1.0 - (exact_is_orthographic(config) ? -1.0 : 1.0) *
                        depth_tolerance(config);
  if (r.s.is) {
    r.least = least_excess(config, &r.s);
    exact_surface_slope(frame, split, x, y, &r.s);
    ignore_rounding(&r);
  }
  r.list = list;
  return r;
}

/* ------------------------------------------------------------------------ */
/* Samples                                                                   */

/* A sample that lies above the tangent plane. */
typedef struct occluder {
  surface s;
  int x, y;
  vec3 to;         /* from the receiver's point */
  double range;    /* |to| */
  double w;        /* on the line of the half-slice */
  double distance; /* along the half-slice, in units of the ray's slope */
  double excess;   /* of its front, where it lies */
} occluder;

/* How much smaller the inverse depth of an occluder's back is than that of its
 * front, as a share of the latter; in orthographic views, the thickness. */
static double back_share(const exact_frame *frame, const occluder *o) {
  const hbil_config *c = frame->config;
  const double z = exact_depth_of_w(c, o->w);
  const double unit = exact_depth_unit(c, &frame->camera, z);
  const double thickness =
      fmin((double)c->model.thickness / vec_length(o->s.ray),
           exact_relative_thickness(c) * unit);
  return exact_is_orthographic(c) ? thickness : thickness / (z + thickness);
}

/* The excess of an occluder's back, where its front has the inverse depth w and
 * the excess `front`. */
static double excess_of_back(const exact_frame *frame, double share, double w,
                             double distance, double front) {
  const double unit = exact_is_orthographic(frame->config) ? 1.0 : w;
  return front - unit * share / distance;
}

/* Weight of an occluder at distance r (hbil_falloff). */
static double falloff(const hbil_config *c, double r) {
  const double share = r / exact_radius(c); /* 0 where unlimited */
  if (c->model.mode != HBIL_MODE_HBAO || c->model.falloff == HBIL_FALLOFF_NONE)
    return 1.0;
  return c->model.falloff == HBIL_FALLOFF_LINEAR ? fmax(0.0, 1.0 - share)
                                                 : 1.0 - share / 3.0;
}

/* How much of a sample's radiance counts, 0..1, by the cosine between its
 * normal and the direction back to the receiver. */
static double facing_fade(const hbil_config *c, double cosine) {
  const double low = (double)c->model.facing_fade[0];
  const double high = (double)c->model.facing_fade[1];
  if (low == high)
    return cosine >= low ? 1.0 : 0.0;
  const double t = clamp((cosine - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/* Adds the light of an occluder that covers `fresh`, and `lobe` of the lobe. */
static void add_light(const receiver *r, march *m, const occluder *o,
                      double fresh, double lobe, received *got) {
  const hbil_config *c = r->frame->config;
  const double t = facing_fade(c, -vec_dot(o->s.normal, o->to) / o->range);
  for (int i = 0; i < 3; ++i) {
    const double own = *exact_at(r->split, HBIL_SPLIT_RED + i, o->x, o->y);
    m->last[i] = c->model.back_facing_fallback == HBIL_FALLBACK_LAST_ACCEPTED
                     ? m->last[i] + t * (own - m->last[i])
                     : t * own;
    got->light[i] += m->last[i] * fresh;
    got->lobe_light[i] += m->last[i] * lobe;
  }
  got->lobe_known += lobe * (exact_fills_unknown(c) ? t : 1.0);
  got->unknown += (1.0 - t) * fresh;
}

/* The change of inverse depth from an occluder to the pixel behind it; back:
 * how much smaller that of its back is.  Where only one of the pixels before
 * and behind it shows a surface, a step to it of more than `back` a pixel
 * counts less, and one of twice that not at all, because it leads to another
 * surface.
 */
static double slope_at(const receiver *r, const occluder *o,
                       const hbil_extent *step, double back) {
  const int sx = step->slope_x, sy = step->slope_y;
  const double before =
      o->w - exact_w_at(r->frame, r->split, o->x - sx, o->y - sy);
  const double behind =
      exact_w_at(r->frame, r->split, o->x + sx, o->y + sy) - o->w;
  if (isnan(before) && isnan(behind))
    return 0.0;
  const double a = isnan(before) ? behind : before;
  const double b = isnan(behind) ? before : behind;
  const double slope = fmax(fmin(a, b), 0.0) + fmin(fmax(a, b), 0.0);
  const double pixels = fmax(abs(sx), abs(sy));
  const double most = fmax(2.0 * back * pixels - fabs(slope), 0.0);
  return isnan(before) || isnan(behind) ? clamp(slope, -most, most) : slope;
}

/* Widens the excesses to what the occluder covers at an end of its step: `away`
 * times the way to the pixel that tells its slope. */
static void widen_to(const receiver *r, const occluder *o,
                     const hbil_extent *step, double share, double slope,
                     double away, double *front, double *back) {
  const double x = (o->x - r->x + away * step->slope_x) * r->pixel_x;
  const double y = (o->y - r->y + away * step->slope_y) * r->pixel_y;
  const double w = o->w + away * slope, e = sqrt(x * x + y * y);
  /* what its front may be off by stays the same in w */
  const double above = o->excess * o->distance + away * slope -
                       away * (step->slope_x * r->pixel_x * r->s.slope_x +
                               step->slope_y * r->pixel_y * r->s.slope_y);
  *front = fmax(*front, above / e);
  *back = fmin(*back, excess_of_back(r->frame, share, w, e, above / e));
}

/* The excesses of an occluder's front and back.  step: NULL if it stands for
 * its pixel alone. */
static void extent_of(const receiver *r, const half_slice *h, const occluder *o,
                      const hbil_extent *step, double *front, double *back) {
  const double e = o->distance, share = back_share(r->frame, o);
  const double own = excess_of_back(r->frame, share, o->w, e, o->excess);
  *front = o->excess;
  *back = own;
  if (step) {
    const double unit = exact_is_orthographic(r->frame->config) ? 1.0 : o->w;
    const double slope = slope_at(r, o, step, share * unit);
    const double x = step->slope_x * r->pixel_x, y = step->slope_y * r->pixel_y;
    const double along =
        (x * (o->x - r->x) * r->pixel_x + y * (o->y - r->y) * r->pixel_y) / e;
    const double beside = (double)step->beside * (o->excess - own);
    *front = -INFINITY;
    *back = INFINITY;
    widen_to(r, o, step, share, slope, -(double)step->near * e / along, front,
             back);
    widen_to(r, o, step, share, slope, (double)step->far * e / along, front,
             back);
    *front = fmin(*front, o->excess + beside);
    *back = fmax(*back, own - beside);
  }
  *back = fmax(*back, h->tangent);
}

/* Covers what is joined, with its light. */
static void cover_joined(march *m) {
  joined *j = &m->joined;
  if (!(j->weight > 0.0))
    return;
  const double fresh = exact_cover(&m->covers, &m->h, 1.0, j->high, j->low);
  const double scale = fresh / j->weight;
  const double of_lobe =
      j->lobe_weight > 0.0 ? m->covers.lobe / j->lobe_weight : 0.0;
  m->covered += fresh;
  m->blocked += scale * j->blocked;
  m->got.unknown += scale * j->got.unknown;
  m->got.lobe_known += of_lobe * j->got.lobe_known;
  for (int i = 0; i < 3; ++i) {
    m->got.light[i] += scale * j->got.light[i];
    m->got.lobe_light[i] += of_lobe * j->got.lobe_light[i];
  }
  *j = (joined){.low = j->low, .high = j->high};
}

/* The lobe per solid angle at an angle of the half-slice. */
static double lobe_at(const half_slice *h, angle a) {
  const vec3 w = vec_add(vec_scale(a.cosine, h->wo), a.sine, h->along);
  const double cosine = vec_dot(exact_reflected(h->point->normal, h->wo), w);
  return 1.0 / pow(1.0 + h->lobe * (1.0 - cosine), 2.0);
}

/* Joins an occluder, and returns its weight; that of its lobe goes to `lobe`.
 */
static double join(march *m, double front, double back, double *lobe) {
  const half_slice *h = &m->h;
  joined *j = &m->joined;
  if (back > j->high || front < j->low) {
    cover_joined(m);
    j->low = j->high = front;
  }
  const double low = fmin(j->low, back), high = fmax(j->high, front);
  const double added = high - j->high + j->low - low;
  const angle a = exact_horizon(
      h, 1.0, 0.5 * (high > j->high ? high + j->high : low + j->low));
  const double per_excess =
      vec_length(h->point->ray) / (h->point->unit * vec_dot(h->u, h->along));
  const double density =
      h->uniform ? pow(a.sine, 3.0)
                 : pow(a.sine, 3.0) * (h->nx * a.sine + h->ny * a.cosine);
  j->low = low;
  j->high = high;
  const double weight = per_excess * added * fmax(density, 0.0);
  j->weight += weight;
  *lobe = m->covers.glossy
              ? per_excess * added * pow(a.sine, 3.0) * lobe_at(h, a)
              : 0.0;
  j->lobe_weight += *lobe;
  return weight;
}

static void meet(const receiver *r, march *m, occluder *o,
                 const hbil_extent *step) {
  const hbil_config *c = r->frame->config;
  o->s = exact_surface_at(r->frame, r->split, o->x, o->y);
  o->to = vec_add(o->s.at, -1.0, r->s.at);
  o->range = vec_length(o->to);
  if (!(o->range <= exact_radius(c)))
    return;
  double front = o->excess, back = 0.0;
  if (r->kind != COVERAGE_HORIZON)
    extent_of(r, &m->h, o, c->model.extrapolate ? step : NULL, &front, &back);
  if (r->kind == COVERAGE_SECTORS) {
    double lobe;
    const double weight = join(m, front, back, &lobe);
    m->joined.blocked += falloff(c, o->range) * weight;
    if (exact_gathers_light(c) && weight > 0.0)
      add_light(r, m, o, weight, lobe, &m->joined.got);
    return;
  }
  const double fresh = exact_cover(&m->covers, &m->h, o->distance, front, back);
  m->covered += fresh;
  m->blocked += falloff(c, o->range) * fresh;
  if (exact_gathers_light(c) && fresh > 0.0)
    add_light(r, m, o, fresh, m->covers.lobe, &m->got);
}

/* A sample at the offset (ex, ey); the occluder has x, y and w, NAN where there
 * is no surface. */
static void visit(const receiver *r, march *m, occluder *o, double ex,
                  double ey, const hbil_extent *step) {
  const double above =
      o->w * r->w_scale - r->s.w - r->s.slope_x * ex - r->s.slope_y * ey;
  o->distance = sqrt(ex * ex + ey * ey);
  if (!(above > m->covers.threshold * o->distance))
    return;
  o->excess = above / o->distance;
  meet(r, m, o, step);
}

void exact_march_visit(const receiver *r, march *m, int x, int y,
                       const hbil_extent *step) {
  occluder o = {.x = x, .y = y, .w = exact_w_at(r->frame, r->split, x, y)};
  visit(r, m, &o, (x - r->x) * r->pixel_x, (y - r->y) * r->pixel_y, step);
}

void exact_march_cross(const receiver *r, march *m, int near_x, int near_y,
                       double x, double y) {
  occluder o = {.x = near_x, .y = near_y};
  const double dx = x - o.x, dy = y - o.y; /* one of them is 0 */
  o.w = exact_w_at(r->frame, r->split, o.x, o.y);
  if (isnan(o.w))
    return;
  if (dx != 0.0)
    o.w += dx * exact_slope_along(r->frame, r->split, o.x, o.y, 1, 0, 0.0);
  else if (dy != 0.0)
    o.w += dy * exact_slope_along(r->frame, r->split, o.x, o.y, 0, 1, 0.0);
  visit(r, m, &o, (x - r->x) * r->pixel_x, (y - r->y) * r->pixel_y, NULL);
}

/* ------------------------------------------------------------------------ */

march exact_march_begin(const receiver *r, double ux, double uy) {
  const hbil_config *c = r->frame->config;
  march m;
  memset(&m, 0, sizeof(m));
  m.h = exact_half_slice(&r->s, ux, uy, c->model.mode == HBIL_MODE_HBAO,
                         r->equal_weights);
  m.covers = exact_coverage(r->kind, &m.h, m.h.tangent + r->least,
                            (double)hbil_shift_share(exact_site(c, r->x, r->y),
                                                     exact_gathered_layers(c)),
                            r->list);
  m.joined.low = m.h.tangent;
  m.joined.high = m.h.tangent + r->least;
  if (exact_is_glossy(c)) {
    m.covers.glossy = true;
    m.h.lobe = exact_lobe(c, m.h.ny);
    m.lobe_whole = exact_lobe_integral(&m.h, m.h.start);
  }
  for (int i = 0; i < 3 && exact_gathers_light(c); ++i)
    m.last[i] = *exact_at(r->split, HBIL_SPLIT_RED + i, r->x, r->y);
  return m;
}

void exact_march_end(march *m) {
  cover_joined(m);
  /* no more of the lobe is known than there is */
  const double most = m->got.lobe_known > m->lobe_whole
                          ? m->lobe_whole / m->got.lobe_known
                          : 1.0;
  m->got.lobe_known *= most;
  for (int i = 0; i < 3; ++i)
    m->got.lobe_light[i] *= most;
  m->open_bent = exact_open_bent(&m->covers, &m->h);
}
