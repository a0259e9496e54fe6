#include "reference.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* Planes and vectors                                                        */

ref_planes ref_planes_new(int width, int height, int count) {
  size_t total = (size_t)width * (size_t)height * (size_t)count;
  ref_planes planes = {width, height, count, calloc(total, sizeof(double))};
  if (!planes.values) {
    fputs("reference: out of memory\n", stderr);
    exit(99);
  }
  return planes;
}

void ref_planes_free(ref_planes *planes) {
  free(planes->values);
  planes->values = NULL;
}

double *ref_at(const ref_planes *planes, int plane, int x, int y) {
  size_t row = (size_t)plane * (size_t)planes->height + (size_t)y;
  return planes->values + row * (size_t)planes->width + (size_t)x;
}

static void clear(ref_planes *planes, int x, int y) {
  for (int p = 0; p < planes->count; ++p)
    *ref_at(planes, p, x, y) = 0.0;
}

typedef struct vec {
  double x, y, z;
} vec;

static vec make(double x, double y, double z) {
  vec v = {x, y, z};
  return v;
}

static double dot(vec a, vec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* a + s b */
static vec add(vec a, double s, vec b) {
  return make(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}

static vec scaled(double s, vec a) {
  return make(s * a.x, s * a.y, s * a.z);
}

static double length(vec a) {
  return sqrt(dot(a, a));
}

static vec normalized(vec a) {
  return scaled(1.0 / length(a), a);
}

static double clamp(double v, double low, double high) {
  return v < low ? low : v > high ? high : v;
}

/* World direction to view space and back. */
static vec to_view(const hbil_camera *camera, vec v) {
  const double *m = camera->world_from_view;
  return make(m[0] * v.x + m[4] * v.y + m[8] * v.z,
              m[1] * v.x + m[5] * v.y + m[9] * v.z,
              m[2] * v.x + m[6] * v.y + m[10] * v.z);
}

static vec to_world(const hbil_camera *camera, vec v) {
  const double *m = camera->world_from_view;
  return make(m[0] * v.x + m[1] * v.y + m[2] * v.z,
              m[4] * v.x + m[5] * v.y + m[6] * v.z,
              m[8] * v.x + m[9] * v.y + m[10] * v.z);
}

/* Ray of the pixel, z = 1. */
static vec ray_of(const hbil_camera *camera, int x, int y) {
  return make((x + 0.5 - camera->cx) / camera->fx,
              (y + 0.5 - camera->cy) / camera->fy, 1.0);
}

/* ------------------------------------------------------------------------ */
/* Inputs                                                                    */

static float input_at(const ref_job *job, int plane, int x, int y) {
  return job->input[plane][(size_t)y * job->config->width + (size_t)x];
}

static bool is_sky(const hbil_config *config, float depth) {
  return !(depth > 0.0f) || isinf(depth) || depth >= config->background;
}

static bool sky_at(const ref_job *job, int x, int y) {
  return is_sky(job->config, input_at(job, REF_DEPTH, x, y));
}

/* Light: whatever is no positive number counts as 0. */
static double light_at(const ref_job *job, int plane, int x, int y) {
  double v;
  if (!job->input[plane])
    return 0.0;
  v = input_at(job, plane, x, y);
  return isfinite(v) && v > 0.0 ? v : 0.0;
}

static double albedo_at(const ref_job *job, int channel, int x, int y) {
  return job->input[REF_ALBEDO]
             ? clamp(light_at(job, REF_ALBEDO + channel, x, y), 0.0, 1.0)
             : 1.0;
}

/* 1 - F0: what of the light enters the surface. */
static double entering_at(const ref_job *job, int channel, int x, int y) {
  return 1.0 - clamp(light_at(job, REF_F0 + channel, x, y), 0.0, 1.0);
}

static double direct_at(const ref_job *job, int channel, int x, int y) {
  return light_at(job, REF_DIRECT + channel, x, y) *
         (double)job->config->direct_scale;
}

/* Emission as far as it lights neighbours. */
static double gathered_emission(const ref_job *job, int channel, int x, int y) {
  return job->config->gather_emission
             ? light_at(job, REF_EMISSION + channel, x, y)
             : 0.0;
}

hbil_view_args ref_view(const hbil_config *config, const hbil_camera *camera) {
  hbil_view_args v;
  v.width = (int)config->width;
  v.height = (int)config->height;
  v.fx = (float)camera->fx;
  v.fy = (float)camera->fy;
  v.cx = (float)camera->cx;
  v.cy = (float)camera->cy;
  v.inv_fx = 1.0f / v.fx;
  v.inv_fy = 1.0f / v.fy;
  return v;
}

/* ------------------------------------------------------------------------ */
/* reproject: float, every rounding as specified                             */

typedef struct fvec {
  float x, y, z;
} fvec;

/* Rows of to_view <- from_view, computed in double, then rounded. */
static void view_from_view(const hbil_camera *to, const hbil_camera *from,
                           float m[12]) {
  const double *t = to->world_from_view, *f = from->world_from_view;
  for (int i = 0; i < 3; ++i) {
    double offset = 0.0;
    for (int j = 0; j < 3; ++j) {
      double sum = 0.0;
      for (int k = 0; k < 3; ++k)
        sum += t[4 * k + i] * f[4 * k + j];
      m[4 * i + j] = (float)sum;
    }
    for (int k = 0; k < 3; ++k)
      offset += t[4 * k + i] * (f[4 * k + 3] - t[4 * k + 3]);
    m[4 * i + 3] = (float)offset;
  }
}

static float row_times(const float m[4], fvec p) {
  return fmaf(m[0], p.x, fmaf(m[1], p.y, fmaf(m[2], p.z, m[3])));
}

static fvec transformed(const float m[12], fvec p) {
  fvec q = {row_times(m, p), row_times(m + 4, p), row_times(m + 8, p)};
  return q;
}

static fvec point_at(const hbil_view_args *v, int x, int y, float z) {
  fvec p = {((float)x + 0.5f - v->cx) * v->inv_fx * z,
            ((float)y + 0.5f - v->cy) * v->inv_fy * z, z};
  return p;
}

/* Planar depth of the current frame; the pixel is not sky. */
static float planar_depth(const ref_job *job, const hbil_view_args *v, int x,
                          int y) {
  float d = input_at(job, REF_DEPTH, x, y);
  fvec r = point_at(v, x, y, 1.0f);
  if (job->config->depth_kind == HBIL_DEPTH_PLANAR)
    return d;
  return d / sqrtf(fmaf(r.x, r.x, fmaf(r.y, r.y, 1.0f)));
}

/* A source pixel's place in the new image; -1: outside. */
static int scatter_target(const hbil_view_args *v, fvec q) {
  float u, w;
  if (!(q.z > 0.0f))
    return -1;
  u = fmaf(v->fx, q.x / q.z, v->cx);
  w = fmaf(v->fy, q.y / q.z, v->cy);
  if (!(u >= 0.0f && u < (float)v->width && w >= 0.0f && w < (float)v->height))
    return -1;
  return (int)w * v->width + (int)u;
}

typedef struct winner {
  int source; /* -1: none */
  float z;
} winner;

static void scatter_one(const ref_job *job, const float m[12], int x, int y,
                        float w, winner *winners) {
  hbil_view_args old = ref_view(job->config, &job->previous);
  hbil_view_args now = ref_view(job->config, &job->camera);
  fvec q = transformed(m, point_at(&old, x, y, 1.0f / w));
  int target = scatter_target(&now, q);
  winner *best = winners + (target < 0 ? 0 : target);
  /* sources come in ascending order: the first of equals stays */
  if (target >= 0 && (best->source < 0 || q.z < best->z)) {
    best->source = y * now.width + x;
    best->z = q.z;
  }
}

static void take_source(const ref_job *job, const ref_planes *history,
                        const winner *best, int x, int y, ref_planes *carried) {
  hbil_view_args now = ref_view(job->config, &job->camera);
  int sx = best->source % now.width, sy = best->source / now.width;
  float zc = planar_depth(job, &now, x, y);
  if (!(fabsf(best->z - zc) <= job->config->disocclusion * zc))
    return;
  for (int c = 0; c < 3; ++c)
    *ref_at(carried, HBIL_CARRIED_RED + c, x, y) =
        *ref_at(history, HBIL_HISTORY_RED + c, sx, sy);
  *ref_at(carried, HBIL_CARRIED_WEIGHT, x, y) = 1.0;
}

static void scatter(const ref_job *job, const ref_planes *history,
                    ref_planes *carried) {
  int width = history->width, height = history->height;
  winner *winners = malloc((size_t)width * (size_t)height * sizeof(*winners));
  float m[12];
  if (!winners)
    exit(99);
  for (int i = 0; i < width * height; ++i)
    winners[i].source = -1;
  view_from_view(&job->camera, &job->previous, m);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float w = (float)*ref_at(history, HBIL_HISTORY_W, x, y);
      if (w > 0.0f)
        scatter_one(job, m, x, y, w, winners);
    }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const winner *best = winners + y * width + x;
      if (best->source >= 0 && !sky_at(job, x, y))
        take_source(job, history, best, x, y, carried);
    }
  free(winners);
}

static bool tap_counts(const ref_job *job, const ref_planes *history, int x,
                       int y, float z) {
  float w;
  if (x < 0 || y < 0 || x >= history->width || y >= history->height)
    return false;
  w = (float)*ref_at(history, HBIL_HISTORY_W, x, y);
  return w > 0.0f && fabsf(1.0f / w - z) <= job->config->disocclusion * z;
}

static void motion_taps(const ref_job *job, const ref_planes *history, float fu,
                        float fv, float z, float out[4]) {
  float a = fu - floorf(fu), c = fv - floorf(fv), total = 0.0f;
  const float share[4] = {(1.0f - a) * (1.0f - c), a * (1.0f - c),
                          (1.0f - a) * c, a * c};
  float sum[3] = {0.0f, 0.0f, 0.0f};
  for (int tap = 0; tap < 4; ++tap) {
    int x = (int)floorf(fu) + (tap & 1), y = (int)floorf(fv) + (tap >> 1);
    if (!tap_counts(job, history, x, y, z))
      continue;
    total = total + share[tap];
    for (int i = 0; i < 3; ++i)
      sum[i] =
          fmaf(share[tap], (float)*ref_at(history, HBIL_HISTORY_RED + i, x, y),
               sum[i]);
  }
  for (int i = 0; i < 3; ++i)
    out[i] = total > 0.0f ? sum[i] / total : 0.0f;
  out[3] = total > 0.0f ? 1.0f : 0.0f;
}

static void motion_one(const ref_job *job, const ref_planes *history,
                       const float n[12], int x, int y, ref_planes *carried) {
  hbil_view_args now = ref_view(job->config, &job->camera);
  float z = planar_depth(job, &now, x, y), taken[4];
  fvec q = transformed(n, point_at(&now, x, y, z));
  float sx = input_at(job, REF_MOTION, x, y) * job->config->motion_scale[0];
  float sy = input_at(job, REF_MOTION + 1, x, y) * job->config->motion_scale[1];
  float fu = ((float)x + 0.5f) + sx, fv = ((float)y + 0.5f) + sy;
  fu = fu - 0.5f;
  fv = fv - 0.5f;
  if (!(q.z > 0.0f && fu > -1.0f && fu < (float)now.width && fv > -1.0f &&
        fv < (float)now.height))
    return;
  motion_taps(job, history, fu, fv, q.z, taken);
  for (int i = 0; i < 4; ++i)
    *ref_at(carried, i, x, y) = taken[i];
}

static void follow_motion(const ref_job *job, const ref_planes *history,
                          ref_planes *carried) {
  float n[12];
  view_from_view(&job->previous, &job->camera, n);
  for (int y = 0; y < history->height; ++y)
    for (int x = 0; x < history->width; ++x)
      if (!sky_at(job, x, y))
        motion_one(job, history, n, x, y, carried);
}

void ref_reproject(const ref_job *job, const ref_planes *history,
                   ref_planes *carried) {
  for (int y = 0; y < carried->height; ++y)
    for (int x = 0; x < carried->width; ++x)
      clear(carried, x, y);
  if (job->config->reprojection == HBIL_REPROJECTION_SCATTER)
    scatter(job, history, carried);
  else
    follow_motion(job, history, carried);
}

/* ------------------------------------------------------------------------ */
/* push_pull                                                                 */

static void push_texel(const ref_planes *fine, ref_planes *coarse, int x,
                       int y) {
  double sum[4] = {0.0, 0.0, 0.0, 0.0};
  for (int child = 0; child < 4; ++child) {
    int cx = 2 * x + (child & 1), cy = 2 * y + (child >> 1);
    double w;
    if (cx >= fine->width || cy >= fine->height)
      continue;
    w = *ref_at(fine, HBIL_CARRIED_WEIGHT, cx, cy);
    for (int c = 0; c < 3; ++c)
      sum[c] += w * *ref_at(fine, c, cx, cy);
    sum[3] += w;
  }
  for (int c = 0; c < 3; ++c)
    *ref_at(coarse, c, x, y) = sum[3] > 0.0 ? sum[c] / sum[3] : 0.0;
  *ref_at(coarse, HBIL_CARRIED_WEIGHT, x, y) = sum[3] / 4.0;
}

static ref_planes pushed(const ref_planes *fine) {
  ref_planes coarse =
      ref_planes_new((fine->width + 1) / 2, (fine->height + 1) / 2, 4);
  for (int y = 0; y < coarse.height; ++y)
    for (int x = 0; x < coarse.width; ++x)
      push_texel(fine, &coarse, x, y);
  return coarse;
}

/* One coarse neighbour along an axis: the near one has 3/4. */
static int coarse_index(int fine, int far, int size) {
  int index = fine / 2 + (far ? (fine & 1 ? 1 : -1) : 0);
  return index < 0 ? 0 : index >= size ? size - 1 : index;
}

static double interpolated(const ref_planes *coarse, int plane, int x, int y) {
  double sum = 0.0;
  for (int far = 0; far < 4; ++far) {
    int cx = coarse_index(x, far & 1, coarse->width);
    int cy = coarse_index(y, far >> 1, coarse->height);
    double share = (far & 1 ? 0.25 : 0.75) * (far >> 1 ? 0.25 : 0.75);
    sum += share * *ref_at(coarse, plane, cx, cy);
  }
  return sum;
}

void ref_push_pull(ref_planes *carried) {
  ref_planes coarse;
  if (carried->width == 1 && carried->height == 1)
    return;
  coarse = pushed(carried);
  ref_push_pull(&coarse);
  for (int y = 0; y < carried->height; ++y)
    for (int x = 0; x < carried->width; ++x)
      if (!(*ref_at(carried, HBIL_CARRIED_WEIGHT, x, y) > 0.0))
        for (int p = 0; p < 4; ++p)
          *ref_at(carried, p, x, y) = interpolated(&coarse, p, x, y);
  ref_planes_free(&coarse);
}

/* ------------------------------------------------------------------------ */
/* split                                                                     */

/* Unit view-space normal that faces the eye. */
static vec facing_normal(const ref_job *job, int x, int y) {
  vec wo = scaled(-1.0, normalized(ray_of(&job->camera, x, y)));
  vec n =
      make(input_at(job, REF_NORMAL, x, y), input_at(job, REF_NORMAL + 1, x, y),
           input_at(job, REF_NORMAL + 2, x, y));
  if (job->config->normal_space == HBIL_SPACE_WORLD)
    n = to_view(&job->camera, n);
  /* of a length whose square a float can hold */
  if (!isfinite((float)dot(n, n)) || dot(n, n) < 1e-20)
    return wo;
  n = normalized(n);
  if (dot(n, wo) < (double)HBIL_MIN_COSINE)
    n = normalized(add(n, (double)HBIL_MIN_COSINE - dot(n, wo), wo));
  return n;
}

static double radiance_of(const ref_job *job, const ref_planes *carried, int c,
                          int x, int y) {
  bool radiance = job->config->feedback == HBIL_FEEDBACK_RADIANCE;
  double value = carried ? *ref_at(carried, HBIL_CARRIED_RED + c, x, y) : 0.0;
  double diffuse = entering_at(job, c, x, y) * albedo_at(job, c, x, y) / PI;
  if (radiance && carried && *ref_at(carried, HBIL_CARRIED_WEIGHT, x, y) > 0.0)
    return value;
  return diffuse * (direct_at(job, c, x, y) + (radiance ? 0.0 : value)) +
         gathered_emission(job, c, x, y);
}

/* Rounded once: the float that the plan stores decides about levels. */
static double inverse_depth(const ref_job *job, int x, int y) {
  float d = input_at(job, REF_DEPTH, x, y);
  if (job->config->depth_kind == HBIL_DEPTH_PLANAR)
    return 1.0f / d;
  return (float)(length(ray_of(&job->camera, x, y)) / (double)d);
}

static void split_pixel(const ref_job *job, const ref_planes *carried, int x,
                        int y, ref_planes *split) {
  vec n = facing_normal(job, x, y), r = ray_of(&job->camera, x, y);
  double w = inverse_depth(job, x, y);
  *ref_at(split, HBIL_SPLIT_W, x, y) = w;
  *ref_at(split, HBIL_SPLIT_GX, x, y) = n.x / dot(n, r) * w;
  *ref_at(split, HBIL_SPLIT_GY, x, y) = n.y / dot(n, r) * w;
  for (int c = 0; c < 3; ++c)
    *ref_at(split, HBIL_SPLIT_RED + c, x, y) =
        radiance_of(job, carried, c, x, y);
}

void ref_split(const ref_job *job, const ref_planes *carried,
               ref_planes *split) {
  for (int y = 0; y < split->height; ++y)
    for (int x = 0; x < split->width; ++x) {
      clear(split, x, y);
      if (sky_at(job, x, y))
        *ref_at(split, HBIL_SPLIT_W, x, y) = (double)HBIL_NOTHING;
      else
        split_pixel(job, carried, x, y, split);
    }
}

/* ------------------------------------------------------------------------ */
/* gather                                                                    */

hbil_pattern_args ref_pattern(const ref_job *job) {
  const hbil_config *c = job->config;
  hbil_view_args v = ref_view(c, &job->camera);
  hbil_pattern_args p;
  p.slices = (int)c->slices;
  p.samples = (int)c->samples;
  p.levels = isinf(c->radius) ? 1 : HBIL_MAX_LEVELS;
  p.lattice = c->lattice == HBIL_LATTICE_LAYER ? HBIL_SIDE : 1;
  p.reach = fmaxf((float)v.width / v.fx, (float)v.height / v.fy);
  p.growth = c->step_growth;
  p.turn = (float)fmod(job->index * 0.6457513, 1.0);
  p.shift = (float)fmod(job->index * 0.7548777, 1.0);
  return p;
}

/* A visible point of the scene. */
typedef struct surface {
  double w;      /* 1/z, <= 0: none */
  double gx, gy; /* of its tangent plane's inverse depth */
  vec ray, at, normal;
} surface;

/* Not positive: nothing there. */
static double inverse_depth_at(const ref_planes *split, int x, int y) {
  if (x < 0 || y < 0 || x >= split->width || y >= split->height)
    return 0.0;
  return *ref_at(split, HBIL_SPLIT_W, x, y);
}

static surface surface_at(const ref_job *job, const ref_planes *split, int x,
                          int y) {
  surface s = {0.0, 0.0, 0.0, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  s.w = inverse_depth_at(split, x, y);
  if (!(s.w > 0.0))
    return s;
  s.gx = *ref_at(split, HBIL_SPLIT_GX, x, y);
  s.gy = *ref_at(split, HBIL_SPLIT_GY, x, y);
  s.ray = ray_of(&job->camera, x, y);
  s.at = scaled(1.0 / s.w, s.ray);
  /* the plane of all P with (gx,gy,c).P = 1, seen from the eye's side */
  s.normal =
      normalized(make(-s.gx, -s.gy, -(s.w - s.gx * s.ray.x - s.gy * s.ray.y)));
  return s;
}

typedef struct gathering {
  const ref_job *job;
  const ref_planes *split;
  ref_planes *gathered;
  hbil_view_args view;
  hbil_pattern_args pattern;
  bool dense;         /* every pixel, pattern.slices equal slices */
  bool equal_weights; /* no Jacobian */
  int first, step;    /* rows of this thread */
} gathering;

/* What the half-slices of a pixel add up to, each weighted with J. */
typedef struct sums {
  double whole, open, unknown, light[3];
  vec bent, bent_whole;
} sums;

/* One pixel's half-slice. */
typedef struct half_slice {
  vec wo, along; /* D of METHOD */
  vec u;
  double nx, ny, weight;
} half_slice;

/* Cosine-weighted measure of the angles from wo (0) to theta. */
static double measure(const half_slice *h, double theta) {
  return h->nx / 2.0 * (theta - sin(theta) * cos(theta)) +
         h->ny / 2.0 * sin(theta) * sin(theta);
}

static vec bent_to(const half_slice *h, double theta) {
  vec along = scaled((theta - sin(theta) * cos(theta)) / 2.0, h->along);
  return add(along, sin(theta) * sin(theta) / 2.0, h->wo);
}

static half_slice make_half(const surface *s, double ux, double uy) {
  half_slice h;
  double across;
  h.u = make(ux, uy, 0.0);
  h.wo = scaled(-1.0, normalized(s->ray));
  h.along = normalized(add(h.u, -dot(h.u, h.wo), h.wo));
  h.nx = dot(s->normal, h.along);
  h.ny = dot(s->normal, h.wo);
  across = dot(h.u, h.wo); /* u has no z: only the xy parts count */
  h.weight = fabs(h.wo.z) / (1.0 - across * across);
  return h;
}

/*
 * Angle from wo of a point `distance` along the slice whose inverse depth is
 * `excess * distance` above the tangent plane: the direction to it, scaled by
 * both inverse depths so that points at and beyond infinity are no exception.
 */
static double horizon(const surface *s, const half_slice *h, double distance,
                      double excess) {
  double rise = (s->gx * h->u.x + s->gy * h->u.y + excess) * distance;
  double w = s->w + rise;
  vec to = add(scaled(s->w, add(s->ray, distance, h->u)), -w, s->ray);
  return atan2(dot(to, h->along), dot(to, h->wo));
}

static double fade(const hbil_config *c, double cosine) {
  double low = (double)c->facing[0], high = (double)c->facing[1], t;
  if (low == high)
    return cosine >= low ? 1.0 : 0.0;
  t = clamp((cosine - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/* The light that is taken to come from a newly found occluder; returns the
 * share of it that is accepted. */
static double accept_light(const gathering *g, const surface *s,
                           const surface *other, int x, int y, double last[3]) {
  const hbil_config *c = g->job->config;
  vec to = add(other->at, -1.0, s->at);
  double t = fade(c, -dot(other->normal, to) / length(to));
  for (int i = 0; i < 3; ++i) {
    double own = *ref_at(g->split, HBIL_SPLIT_RED + i, x, y);
    last[i] = c->refused == HBIL_REFUSED_LAST ? last[i] + t * (own - last[i])
                                              : t * own;
  }
  return t;
}

static double tolerance_of(const hbil_config *c) {
  return c->depth.component == HBIL_FLOAT16 ? ldexp(1.0, -10) : ldexp(1.0, -22);
}

/* What the rounding of the normal alone may raise a sample of the pixel's own
 * plane by: the normal's unit roundoff, eightfold, in the plane's gradient. */
static double least_excess(const hbil_config *c, const surface *s) {
  double cosine = -dot(s->normal, s->ray) / length(s->ray);
  double unit = ldexp(1.0, c->normal.component == HBIL_FLOAT16 ? -10 : -21);
  return unit * s->w / (cosine * cosine * length(s->ray));
}

static bool within_radius(const hbil_config *c, const surface *a,
                          const surface *b) {
  return isinf(c->radius) ||
         length(add(a->at, -1.0, b->at)) <= (double)c->radius;
}

/* Of an inverse depth w at offset e. */
static double excess_of(const gathering *g, const surface *s, double w, vec e) {
  double raised = w * (1.0 - tolerance_of(g->job->config));
  return (raised - s->w - s->gx * e.x - s->gy * e.y) / length(e);
}

/* The pixel in the k-th column (or row) that the line from a pixel's centre
 * crosses. */
static void crossed_pixel(const gathering *g, int k, double ux, double uy,
                          int *dx, int *dy) {
  double px = ux * g->job->camera.fx, py = uy * g->job->camera.fy;
  double steps = (k + 1) / fmax(fabs(px), fabs(py));
  *dx = (int)rint(steps * px);
  *dy = (int)rint(steps * py);
}

/* One pixel's half-slices, and what they add up to. */
typedef struct walker {
  const gathering *g;
  surface s;
  int x, y, layer, level;
  sums sum;
} walker;

/* Pixel of the k-th sample; false past the last one that the image can have. */
static bool sample_pixel(const walker *w, int k, double ux, double uy, int *x,
                         int *y) {
  const gathering *g = w->g;
  int dx, dy;
  if (g->dense)
    crossed_pixel(g, k, ux, uy, &dx, &dy);
  else
    hbil_sample_offset(w->layer, k, w->level, (float)ux, (float)uy, g->view,
                       g->pattern, &dx, &dy);
  *x = w->x + dx;
  *y = w->y + dy;
  return !g->dense ||
         (*x >= 0 && *y >= 0 && *x < g->split->width && *y < g->split->height);
}

/* What of a half-slice is still open where occluders have a thickness. */
typedef struct openings {
  bool finite;
  unsigned covered; /* sectors of equal A, from wo outwards */
  double start, dither, open;
  vec bent;
} openings;

enum { SECTORS = 32 };

static bool is_finite(const hbil_config *c) {
  return !isinf(c->thickness) || !isinf(c->relative_thickness);
}

static openings all_open(const walker *w, const half_slice *h, double start) {
  int layer = HBIL_SIDE * (w->y % HBIL_SIDE) + w->x % HBIL_SIDE;
  openings o = {.finite = is_finite(w->g->job->config), .start = start};
  o.dither = (hbil_shift_slot(layer) + 0.5) / 16.0;
  o.open = measure(h, start);
  o.bent = bent_to(h, start);
  return o;
}

/* Where the back of a sample lies, in excess. */
static double excess_of_back(const hbil_config *c, const surface *other,
                             double distance, double excess) {
  double z = 1.0 / other->w;
  double deep = fmin((double)c->thickness / length(other->ray),
                     (double)c->relative_thickness * z);
  return fmax(excess + (1.0 / (z + deep) - other->w) / distance, 0.0);
}

static unsigned sectors_below(const half_slice *h, const openings *o,
                              double theta) {
  double part = measure(h, theta) / measure(h, o->start) * SECTORS + o->dither;
  int n = part < 0.0 ? 0 : part > SECTORS ? SECTORS : (int)part;
  return n == SECTORS ? ~0u : (1u << n) - 1u;
}

/* Takes the sectors between front and back from what is open; returns the part
 * of A that was not covered before. */
static double cover(const half_slice *h, openings *o, double front,
                    double back) {
  unsigned fresh =
      sectors_below(h, o, back) & ~sectors_below(h, o, front) & ~o->covered;
  int count = 0;
  double share, part;
  o->covered |= fresh;
  for (; fresh; fresh &= fresh - 1)
    ++count;
  share = measure(h, o->start) * count / SECTORS;
  part = share / fmax(measure(h, back) - measure(h, front), 1e-5);
  o->open = fmax(o->open - share, 0.0);
  o->bent = add(o->bent, part, bent_to(h, front));
  o->bent = add(o->bent, -part, bent_to(h, back));
  return share;
}

static void march(walker *w, double ux, double uy) {
  const gathering *g = w->g;
  const surface *s = &w->s;
  sums *sum = &w->sum;
  half_slice h = make_half(s, ux, uy);
  double start = atan2(h.ny, -h.nx), theta = start, last[3];
  double best = least_excess(g->job->config, s);
  openings o = all_open(w, &h, start);
  int x, y;
  if (g->equal_weights)
    h.weight = 1.0;
  for (int i = 0; i < 3; ++i)
    last[i] = *ref_at(g->split, HBIL_SPLIT_RED + i, w->x, w->y);
  for (int k = 0; (g->dense || k < g->pattern.samples) &&
                  sample_pixel(w, k, ux, uy, &x, &y);
       ++k) {
    double w1 = inverse_depth_at(g->split, x, y);
    double excess, next, taken, accepted;
    surface other;
    vec e = make((x - w->x) / g->job->camera.fx, (y - w->y) / g->job->camera.fy,
                 0.0);
    if (!(w1 > 0.0))
      continue;
    excess = excess_of(g, s, w1, e);
    if (!(excess > best))
      continue;
    other = surface_at(g->job, g->split, x, y);
    if (!within_radius(g->job->config, s, &other))
      continue;
    next = horizon(s, &h, length(e), excess);
    taken = o.finite ? cover(&h, &o, next,
                             horizon(s, &h, length(e),
                                     excess_of_back(g->job->config, &other,
                                                    length(e), excess)))
                     : measure(&h, theta) - measure(&h, next);
    taken *= h.weight;
    accepted = accept_light(g, s, &other, x, y, last);
    for (int i = 0; i < 3; ++i)
      sum->light[i] += last[i] * taken;
    sum->unknown += (1.0 - accepted) * taken;
    if (o.finite)
      continue;
    theta = next;
    best = excess;
  }
  sum->whole += h.weight * measure(&h, start);
  sum->open += h.weight * (o.finite ? o.open : measure(&h, theta));
  sum->bent = add(sum->bent, h.weight, o.finite ? o.bent : bent_to(&h, theta));
  sum->bent_whole = add(sum->bent_whole, h.weight, bent_to(&h, start));
}

/* The level that the pixel's tile of its layer's row uses. */
static int level_at(const gathering *g, int x, int y) {
  int first =
      x % HBIL_SIDE + x / (HBIL_SIDE * HBIL_TILE) * HBIL_SIDE * HBIL_TILE;
  float nearest = 0.0f;
  if (g->pattern.levels == 1)
    return 0;
  for (int i = 0; i < HBIL_TILE; ++i) {
    int at = first + i * HBIL_SIDE;
    if (at < g->split->width)
      nearest = fmaxf(nearest, (float)*ref_at(g->split, HBIL_SPLIT_W, at, y));
  }
  return hbil_level(g->pattern.reach, g->job->config->radius * nearest,
                    g->pattern.levels);
}

static void store_gathered(const walker *w) {
  const ref_planes *gathered = w->g->gathered;
  const sums *sum = &w->sum;
  double slices = w->g->pattern.slices, ao = sum->open / sum->whole;
  /* what few slices miss of the whole plane's bent normal */
  vec rest = add(scaled(slices, w->s.normal), -1.0, sum->bent_whole);
  vec bent = scaled(1.0 / slices, add(sum->bent, ao, rest));
  *ref_at(gathered, HBIL_LIGHT_AO, w->x, w->y) = ao;
  for (int i = 0; i < 3; ++i)
    *ref_at(gathered, HBIL_LIGHT_RED + i, w->x, w->y) =
        PI * sum->light[i] / sum->whole;
  *ref_at(gathered, HBIL_LIGHT_BENT, w->x, w->y) = bent.x;
  *ref_at(gathered, HBIL_LIGHT_BENT + 1, w->x, w->y) = bent.y;
  *ref_at(gathered, HBIL_LIGHT_BENT + 2, w->x, w->y) = bent.z;
  if (gathered->count > HBIL_LIGHT_UNKNOWN)
    *ref_at(gathered, HBIL_LIGHT_UNKNOWN, w->x, w->y) =
        sum->unknown / sum->whole;
}

/* Unit direction of a slice in the screen. */
static void slice_direction(const walker *w, int slice, double *ux,
                            double *uy) {
  const gathering *g = w->g;
  float x, y;
  if (g->dense) {
    *ux = cos((slice + 0.5) / g->pattern.slices * PI);
    *uy = sin((slice + 0.5) / g->pattern.slices * PI);
    return;
  }
  hbil_slice_direction(w->layer, slice, g->pattern, &x, &y);
  *ux = (double)x;
  *uy = (double)y;
}

static void gather_pixel(const gathering *g, int x, int y) {
  walker w;
  memset(&w, 0, sizeof(w));
  w.g = g;
  w.s = surface_at(g->job, g->split, x, y);
  w.x = x;
  w.y = y;
  w.layer = HBIL_SIDE * (y % HBIL_SIDE) + x % HBIL_SIDE;
  w.level = level_at(g, x, y);
  clear(g->gathered, x, y);
  *ref_at(g->gathered, HBIL_LIGHT_AO, x, y) = 1.0;
  if (!(w.s.w > 0.0))
    return;
  for (int slice = 0; slice < g->pattern.slices; ++slice) {
    double ux, uy;
    slice_direction(&w, slice, &ux, &uy);
    march(&w, ux, uy);
    march(&w, -ux, -uy);
  }
  store_gathered(&w);
}

static void *gather_rows(void *argument) {
  const gathering *g = argument;
  for (int y = g->first; y < g->split->height; y += g->step)
    for (int x = 0; x < g->split->width; ++x)
      gather_pixel(g, x, y);
  return NULL;
}

/* Two threads, every other row each. */
static void gather_all(const gathering *all) {
  gathering even = *all, odd = *all;
  pthread_t thread;
  bool threaded;
  even.step = odd.step = 2;
  odd.first = 1;
  threaded = pthread_create(&thread, NULL, gather_rows, &odd) == 0;
  gather_rows(&even);
  if (threaded)
    pthread_join(thread, NULL);
  else
    gather_rows(&odd);
}

static gathering gathering_of(const ref_job *job, const ref_planes *split,
                              ref_planes *gathered) {
  gathering g;
  memset(&g, 0, sizeof(g));
  g.job = job;
  g.split = split;
  g.gathered = gathered;
  g.view = ref_view(job->config, &job->camera);
  g.pattern = ref_pattern(job);
  return g;
}

void ref_gather(const ref_job *job, const ref_planes *split,
                ref_planes *gathered) {
  gathering g = gathering_of(job, split, gathered);
  gather_all(&g);
}

void ref_gather_dense(const ref_job *job, const ref_planes *split, int slices,
                      bool jacobian, ref_planes *gathered) {
  gathering g = gathering_of(job, split, gathered);
  g.dense = true;
  g.equal_weights = !jacobian;
  g.pattern.slices = slices;
  gather_all(&g);
}

/* ------------------------------------------------------------------------ */
/* estimate                                                                  */

/* How much a visible surfel counts, and which power of its radiance is
 * averaged: every pixel alike, and the root, so that a few very bright ones do
 * not decide. */
static double surfel_weight(const surface *s) {
  (void)s;
  return 1.0;
}

static double surfel_value(double radiance) {
  return sqrt(radiance);
}

static double radiance_of_mean(double value) {
  return value * value;
}

static void polynomials(vec d, double p[9]) {
  const double values[9] = {1.0,
                            d.y,
                            d.z,
                            d.x,
                            d.x * d.y,
                            d.y * d.z,
                            3.0 * d.z * d.z - 1.0,
                            d.z * d.x,
                            d.x * d.x - d.y * d.y};
  memcpy(p, values, sizeof(values));
}

static void add_surfel(ref_estimate *e, const ref_planes *split,
                       const surface *s, int x, int y) {
  double p[9], weight = surfel_weight(s);
  polynomials(scaled(-1.0, s->normal), p);
  for (int c = 0; c < 4; ++c) {
    double light =
        c < 3 ? surfel_value(*ref_at(split, HBIL_SPLIT_RED + c, x, y)) : 1.0;
    for (int i = 0; i < 9; ++i)
      e->sum[c][i] += weight * light * p[i];
  }
}

void ref_estimate_frame(ref_job *job, const ref_planes *split) {
  memset(&job->estimate, 0, sizeof(job->estimate));
  for (int y = 0; y < split->height; y += HBIL_SIDE)
    for (int x = 0; x < split->width; x += HBIL_SIDE) {
      surface s = surface_at(job, split, x, y);
      if (s.w > 0.0)
        add_surfel(&job->estimate, split, &s, x, y);
    }
}

/*
 * Sum of weight(c) = 1.05 + 4/3 P1(c) + 5/16 P2(c), c the cosine between the
 * receiver's normal and the surfel's turned one.  5/16 P2, multiplied out in
 * the polynomials, has the factors 15/16, 5/64 (of 3zz-1) and 15/64 (of xx-yy).
 */
static double weighted_sum(const double sum[9], vec n) {
  const double factor[9] = {1.05,       4.0 / 3.0,   4.0 / 3.0,
                            4.0 / 3.0,  15.0 / 16,   15.0 / 16,
                            5.0 / 64.0, 15.0 / 16.0, 15.0 / 64.0};
  double p[9], total = 0.0;
  polynomials(n, p);
  for (int i = 0; i < 9; ++i)
    total += factor[i] * sum[i] * p[i];
  return total;
}

/* The frame's mean radiance towards a receiver of that normal. */
static double frame_light(const ref_job *job, int channel, vec n) {
  double light = weighted_sum(job->estimate.sum[channel], n);
  double weight = weighted_sum(job->estimate.sum[3], n);
  return weight > 0.0 ? radiance_of_mean(light / weight) : 0.0;
}

double ref_frame_light(const ref_job *job, int channel,
                       const double normal[3]) {
  return frame_light(job, channel, make(normal[0], normal[1], normal[2]));
}

/* Radiance of what a pixel doesn't see: the mean of what it does see (`shown`
 * from `share` of the hemisphere) and of the frame's, which counts as
 * HBIL_UNSEEN_PRIOR of a hemisphere. */
static double unseen_light(const ref_job *job, int channel, vec n, double shown,
                           double share) {
  double prior = (double)HBIL_UNSEEN_PRIOR;
  return (shown + prior * frame_light(job, channel, n)) / (share + prior);
}

/* ------------------------------------------------------------------------ */
/* recompose                                                                 */

static double spatial(int d) {
  return d == -2 || d == 2 ? 0.5 : 1.0;
}

static double tap_weight(const ref_job *job, const surface *s,
                         const ref_planes *split, int x, int y, int dx,
                         int dy) {
  surface other = surface_at(job, split, x + dx, y + dy);
  double plane, off, alike;
  if (!(other.w > 0.0) || (job->config->raw_interleave && (dx || dy)))
    return 0.0;
  plane = s->w + s->gx * dx / job->camera.fx + s->gy * dy / job->camera.fy;
  off = fabs(other.w - plane) / ((double)HBIL_PLANE_TOLERANCE * s->w);
  alike = fmax(0.0, dot(s->normal, other.normal));
  return spatial(dx) * spatial(dy) * fmax(0.0, 1.0 - off) * pow(alike, 16.0);
}

static void normalize_bent(ref_planes *resolved, int x, int y) {
  double *p[3], size = 0.0;
  for (int i = 0; i < 3; ++i) {
    p[i] = ref_at(resolved, HBIL_LIGHT_BENT + i, x, y);
    size += *p[i] * *p[i];
  }
  for (int i = 0; i < 3; ++i)
    *p[i] = size > 0.0 ? *p[i] / sqrt(size) : 0.0;
}

/* Light of the filtered pixel's refused share. */
static void fill_unknown(const ref_job *job, const surface *s, double unknown,
                         int x, int y, ref_planes *resolved) {
  double ao = *ref_at(resolved, HBIL_LIGHT_AO, x, y);
  for (int c = 0; c < 3; ++c) {
    double *light = ref_at(resolved, HBIL_LIGHT_RED + c, x, y);
    *light += PI * unknown *
              unseen_light(job, c, s->normal, *light / PI,
                           fmax(0.0, 1.0 - ao - unknown));
  }
}

static void recompose_pixel(const ref_job *job, const ref_planes *split,
                            const ref_planes *gathered, int x, int y,
                            ref_planes *resolved) {
  bool fills = job->config->refused == HBIL_REFUSED_FRAME;
  surface s = surface_at(job, split, x, y);
  double total = 0.0, unknown = 0.0;
  clear(resolved, x, y);
  *ref_at(resolved, HBIL_LIGHT_AO, x, y) = s.w > 0.0 ? 0.0 : 1.0;
  if (!(s.w > 0.0))
    return;
  for (int tap = 0; tap < 25; ++tap) {
    int dx = tap % 5 - 2, dy = tap / 5 - 2;
    double weight = tap_weight(job, &s, split, x, y, dx, dy);
    total += weight;
    for (int p = 0; p < HBIL_LIGHT_PLANES && weight > 0.0; ++p)
      *ref_at(resolved, p, x, y) +=
          weight * *ref_at(gathered, p, x + dx, y + dy);
    if (fills && weight > 0.0)
      unknown += weight * *ref_at(gathered, HBIL_LIGHT_UNKNOWN, x + dx, y + dy);
  }
  for (int p = 0; p < HBIL_LIGHT_PLANES; ++p)
    *ref_at(resolved, p, x, y) /= total;
  if (fills)
    fill_unknown(job, &s, unknown / total, x, y, resolved);
  normalize_bent(resolved, x, y);
}

void ref_recompose(const ref_job *job, const ref_planes *split,
                   const ref_planes *gathered, ref_planes *resolved) {
  for (int y = 0; y < resolved->height; ++y)
    for (int x = 0; x < resolved->width; ++x)
      recompose_pixel(job, split, gathered, x, y, resolved);
}

/* ------------------------------------------------------------------------ */
/* composite                                                                 */

void ref_sh_basis(const double d[3], double y[9]) {
  double x = d[0], z = d[2], v = d[1];
  y[0] = sqrt(1.0 / (4.0 * PI));
  y[1] = sqrt(3.0 / (4.0 * PI)) * v;
  y[2] = sqrt(3.0 / (4.0 * PI)) * z;
  y[3] = sqrt(3.0 / (4.0 * PI)) * x;
  y[4] = sqrt(15.0 / (4.0 * PI)) * x * v;
  y[5] = sqrt(15.0 / (4.0 * PI)) * v * z;
  y[6] = sqrt(5.0 / (16.0 * PI)) * (3.0 * z * z - 1.0);
  y[7] = sqrt(15.0 / (4.0 * PI)) * x * z;
  y[8] = sqrt(15.0 / (16.0 * PI)) * (x * x - v * v);
}

/*
 * Band l of a clamped cosine within a cone of cosine t:
 *   c_l = 2 pi sqrt((2l+1)/(4 pi)) integral_t^1 P_l(x) x dx.
 * (METHOD section 5 has half of c_2; its value at t = 0, Ramamoorthi and
 * Hanrahan's sqrt(5 pi)/8, agrees with the integral.)
 */
static double cone_band(int l, double t) {
  double t2 = t * t, integral = (1.0 - t2) / 2.0;
  if (l == 1)
    integral = (1.0 - t2 * t) / 3.0;
  if (l == 2)
    integral = (3.0 * (1.0 - t2 * t2) - 2.0 * (1.0 - t2)) / 8.0;
  return sqrt((2 * l + 1) * PI) * integral;
}

static int band_of(int index) {
  return index == 0 ? 0 : index < 4 ? 1 : 2;
}

/* Far irradiance through a cone about a view-space direction (0: none). */
static double far_light(const ref_job *job, int channel, double ao, vec bent,
                        double near_light) {
  vec world = to_world(&job->camera, bent);
  double d[3] = {world.x, world.y, world.z}, y[9], sum = 0.0;
  if (job->config->far_field == HBIL_FAR_NONE)
    return 0.0;
  if (job->config->far_field == HBIL_FAR_CONSTANT)
    return PI * ao * (double)job->environment[0][channel];
  if (job->config->far_field == HBIL_FAR_FRAME)
    return PI * ao *
           unseen_light(job, channel, bent, near_light / PI, 1.0 - ao);
  ref_sh_basis(d, y);
  for (int i = 0; i < 9; ++i) {
    int l = band_of(i);
    sum += sqrt(4.0 * PI / (2 * l + 1)) *
           cone_band(l, sqrt(fmax(0.0, 1.0 - ao))) * y[i] *
           (double)job->environment[i][channel];
  }
  return fmax(0.0, sum);
}

static double sky_radiance(const ref_job *job, int channel, int x, int y) {
  vec world = to_world(&job->camera, normalized(ray_of(&job->camera, x, y)));
  double d[3] = {world.x, world.y, world.z}, basis[9], sum = 0.0;
  if (job->input[REF_EMISSION])
    return light_at(job, REF_EMISSION + channel, x, y);
  if (job->config->far_field == HBIL_FAR_NONE ||
      job->config->far_field == HBIL_FAR_FRAME)
    return 0.0;
  if (job->config->far_field == HBIL_FAR_CONSTANT)
    return (double)job->environment[0][channel];
  ref_sh_basis(d, basis);
  for (int i = 0; i < 9; ++i)
    sum += basis[i] * (double)job->environment[i][channel];
  return fmax(0.0, sum);
}

static void composite_sky(const ref_job *job, int x, int y, ref_planes *out) {
  clear(out, x, y);
  *ref_at(out, REF_AO, x, y) = 1.0;
  for (int c = 0; c < 3; ++c)
    *ref_at(out, REF_RADIANCE + c, x, y) = sky_radiance(job, c, x, y);
}

static void composite_channel(const ref_job *job, int c, int x, int y,
                              double near_light, double far, ref_planes *out,
                              ref_planes *history) {
  double entering = entering_at(job, c, x, y);
  double indirect = entering * (near_light + far) / PI;
  double diffuse = albedo_at(job, c, x, y) *
                   (entering * direct_at(job, c, x, y) / PI + indirect);
  *ref_at(out, REF_NEAR + c, x, y) = near_light;
  *ref_at(out, REF_FAR + c, x, y) = far;
  *ref_at(out, REF_INDIRECT + c, x, y) = indirect;
  *ref_at(out, REF_RADIANCE + c, x, y) =
      diffuse + light_at(job, REF_EMISSION + c, x, y);
  *ref_at(history, HBIL_HISTORY_RED + c, x, y) =
      job->config->feedback == HBIL_FEEDBACK_IRRADIANCE
          ? near_light + far
          : diffuse + gathered_emission(job, c, x, y);
}

static void store_bent(ref_planes *out, int x, int y, vec bent) {
  *ref_at(out, REF_BENT, x, y) = bent.x;
  *ref_at(out, REF_BENT + 1, x, y) = bent.y;
  *ref_at(out, REF_BENT + 2, x, y) = bent.z;
}

static void composite_pixel(const ref_job *job, const ref_planes *resolved,
                            int x, int y, ref_planes *out,
                            ref_planes *history) {
  double ao = *ref_at(resolved, HBIL_LIGHT_AO, x, y);
  vec bent = make(*ref_at(resolved, HBIL_LIGHT_BENT, x, y),
                  *ref_at(resolved, HBIL_LIGHT_BENT + 1, x, y),
                  *ref_at(resolved, HBIL_LIGHT_BENT + 2, x, y));
  *ref_at(out, REF_AO, x, y) = ao;
  *ref_at(out, REF_CONE, x, y) = sqrt(fmax(0.0, 1.0 - ao));
  store_bent(out, x, y,
             job->config->bent_space == HBIL_SPACE_WORLD
                 ? to_world(&job->camera, bent)
                 : bent);
  for (int c = 0; c < 3; ++c) {
    double near_light = *ref_at(resolved, HBIL_LIGHT_RED + c, x, y);
    composite_channel(job, c, x, y, near_light,
                      far_light(job, c, ao, bent, near_light), out, history);
  }
  *ref_at(history, HBIL_HISTORY_W, x, y) = inverse_depth(job, x, y);
}

void ref_composite(const ref_job *job, const ref_planes *resolved,
                   ref_planes *out, ref_planes *history) {
  for (int y = 0; y < out->height; ++y)
    for (int x = 0; x < out->width; ++x) {
      clear(history, x, y);
      if (sky_at(job, x, y))
        composite_sky(job, x, y, out);
      else
        composite_pixel(job, resolved, x, y, out, history);
    }
}

/* ------------------------------------------------------------------------ */
/* Frames                                                                    */

void ref_state_init(ref_state *state, int width, int height) {
  memset(state, 0, sizeof(*state));
  state->history = ref_planes_new(width, height, HBIL_HISTORY_PLANES);
  state->carried = ref_planes_new(width, height, HBIL_CARRIED_PLANES);
  state->split = ref_planes_new(width, height, HBIL_SPLIT_PLANES);
  state->gathered = ref_planes_new(width, height, HBIL_GATHERED_PLANES);
  state->resolved = ref_planes_new(width, height, HBIL_LIGHT_PLANES);
  state->out = ref_planes_new(width, height, REF_OUTPUT_PLANES);
}

void ref_state_free(ref_state *state) {
  ref_planes_free(&state->history);
  ref_planes_free(&state->carried);
  ref_planes_free(&state->split);
  ref_planes_free(&state->gathered);
  ref_planes_free(&state->resolved);
  ref_planes_free(&state->out);
}

void ref_frame(ref_state *state, ref_job *job) {
  bool reprojects = job->config->reprojection != HBIL_REPROJECTION_NONE;
  bool carries = reprojects && state->has_history;
  job->previous = state->camera;
  if (carries) {
    ref_reproject(job, &state->history, &state->carried);
    ref_push_pull(&state->carried);
  }
  ref_split(job, carries ? &state->carried : NULL, &state->split);
  ref_estimate_frame(job, &state->split);
  ref_gather(job, &state->split, &state->gathered);
  ref_recompose(job, &state->split, &state->gathered, &state->resolved);
  ref_composite(job, &state->resolved, &state->out, &state->history);
  state->camera = job->camera;
  state->has_history = reprojects;
}
