#include "reference.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* Planes and vectors                                                        */

/* All zero.  Ends the program when there is no memory. */
static void *allocate(size_t count, size_t size) {
  void *memory = calloc(count, size);
  if (!memory) {
    fprintf(stderr, "reference: no memory for %zu x %zu bytes\n", count, size);
    exit(99);
  }
  return memory;
}

ref_planes ref_planes_new(int width, int height, int count) {
  size_t total = (size_t)width * (size_t)height * (size_t)count;
  ref_planes planes = {width, height, count, allocate(total, sizeof(double))};
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

static bool is_orthographic(const hbil_config *config) {
  return config->projection == HBIL_PROJECTION_ORTHOGRAPHIC;
}

/* The pixel's place in the picture's plane: perspective, at depth 1. */
static vec place_of(const hbil_camera *camera, double x, double y) {
  return make((x + 0.5 - camera->cx) / camera->fx,
              (y + 0.5 - camera->cy) / camera->fy, 0.0);
}

/* Ray of the pixel, z = 1. */
static vec ray_of(const ref_job *job, double x, double y) {
  const vec ray = make(0.0, 0.0, 1.0);
  return is_orthographic(job->config)
             ? ray
             : add(ray, 1.0, place_of(&job->camera, x, y));
}

/* The point that a pixel shows at depth z. */
static vec seen_at(const ref_job *job, double x, double y, double z) {
  const vec point = make(0.0, 0.0, z);
  return add(point, is_orthographic(job->config) ? 1.0 : z,
             place_of(&job->camera, x, y));
}

/* What grows towards the eye and is affine on a plane: inverse depth or,
 * orthographic, -z. */
static double w_of(const hbil_config *config, double z) {
  return is_orthographic(config) ? -z : 1.0 / z;
}

static double z_of(const hbil_config *config, double w) {
  return is_orthographic(config) ? -w : 1.0 / w;
}

/* Whether a w is that of a surface. */
static bool shows(const hbil_config *config, double w) {
  return is_orthographic(config) ? w > 0.5 * (double)HBIL_NOTHING : w > 0.0;
}

/* What a share of depth z is a share of. */
static double depth_unit(const hbil_config *config, const hbil_camera *camera,
                         double z) {
  return is_orthographic(config) ? config->width / camera->fx : z;
}

/* ------------------------------------------------------------------------ */
/* Inputs                                                                    */

static float input_at(const ref_job *job, int plane, int x, int y) {
  return job->input[plane][(size_t)y * job->config->width + (size_t)x];
}

static bool is_sky(const hbil_config *config, float depth) {
  return !(depth >= HBIL_NEAREST_DEPTH) || depth >= HBIL_FARTHEST_DEPTH ||
         depth >= config->sky_depth;
}

static bool sky_at(const ref_job *job, int x, int y) {
  return is_sky(job->config, input_at(job, REF_DEPTH, x, y));
}

/* Light: whatever is no positive number, or too large a one, counts as 0. */
static double scaled_light_at(const ref_job *job, int plane, int x, int y,
                              float scale) {
  float v;
  if (!job->input[plane])
    return 0.0;
  v = input_at(job, plane, x, y) * scale;
  return v > 0.0f && v <= HBIL_BRIGHTEST ? (double)v : 0.0;
}

static double light_at(const ref_job *job, int plane, int x, int y) {
  return scaled_light_at(job, plane, x, y, 1.0f);
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
  return scaled_light_at(job, REF_DIRECT + channel, x, y,
                         job->config->direct_scale);
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

static float spread_at(const hbil_config *c, float z) {
  return is_orthographic(c) ? 1.0f : z;
}

static fvec point_at(const hbil_config *c, const hbil_view_args *v, int x,
                     int y, float z) {
  fvec p = {((float)x + 0.5f - v->cx) * v->inv_fx * spread_at(c, z),
            ((float)y + 0.5f - v->cy) * v->inv_fy * spread_at(c, z), z};
  return p;
}

/* Planar depth of the current frame; the pixel is not sky. */
static float planar_depth(const ref_job *job, const hbil_view_args *v, int x,
                          int y) {
  float d = input_at(job, REF_DEPTH, x, y);
  fvec r = point_at(job->config, v, x, y, 1.0f);
  if (job->config->depth_kind == HBIL_DEPTH_PLANAR ||
      is_orthographic(job->config))
    return d;
  return d / sqrtf(fmaf(r.x, r.x, fmaf(r.y, r.y, 1.0f)));
}

/* The float that the kernels have for depth_unit(). */
static float depth_unit_of(const hbil_config *c, const hbil_view_args *v,
                           float z) {
  return is_orthographic(c) ? (float)v->width * v->inv_fx : z;
}

/* A source pixel's place in the new image; -1: outside. */
static int scatter_target(const hbil_config *c, const hbil_view_args *v,
                          fvec q) {
  float u, w;
  if (!(q.z > 0.0f))
    return -1;
  u = fmaf(v->fx, q.x / spread_at(c, q.z), v->cx);
  w = fmaf(v->fy, q.y / spread_at(c, q.z), v->cy);
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
  fvec q = transformed(m, point_at(job->config, &old, x, y, 1.0f / w));
  int target = scatter_target(job->config, &now, q);
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
  if (!(fabsf(best->z - zc) <= job->config->disocclusion_threshold *
                                   depth_unit_of(job->config, &now, zc)))
    return;
  for (int c = 0; c < 3; ++c)
    *ref_at(carried, HBIL_CARRIED_RED + c, x, y) =
        *ref_at(history, HBIL_HISTORY_RED + c, sx, sy);
  *ref_at(carried, HBIL_CARRIED_WEIGHT, x, y) = 1.0;
}

static void scatter(const ref_job *job, const ref_planes *history,
                    ref_planes *carried) {
  int width = history->width, height = history->height;
  winner *winners = allocate((size_t)width * (size_t)height, sizeof(*winners));
  float m[12];
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
  /* |1/w - z| <= off, times w */
  const hbil_view_args view = ref_view(job->config, &job->camera);
  const float off = job->config->disocclusion_threshold *
                    depth_unit_of(job->config, &view, z);
  return w > 0.0f && fabsf(fmaf(w, z, -1.0f)) <= w * off;
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
    out[i] = total > 0.0f ? sum[i] * (1.0f / total) : 0.0f;
  out[3] = total > 0.0f ? 1.0f : 0.0f;
}

static void motion_one(const ref_job *job, const ref_planes *history,
                       const float n[12], int x, int y, ref_planes *carried) {
  hbil_view_args now = ref_view(job->config, &job->camera);
  float z = planar_depth(job, &now, x, y), taken[4];
  fvec q = transformed(n, point_at(job->config, &now, x, y, z));
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
    for (int x = 0; x < carried->width; ++x) {
      clear(carried, x, y);
      if (sky_at(job, x, y))
        *ref_at(carried, HBIL_CARRIED_WEIGHT, x, y) = -1.0;
    }
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
    w = fmax(*ref_at(fine, HBIL_CARRIED_WEIGHT, cx, cy), 0.0);
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
      if (*ref_at(carried, HBIL_CARRIED_WEIGHT, x, y) == 0.0)
        for (int p = 0; p < 4; ++p)
          *ref_at(carried, p, x, y) = interpolated(&coarse, p, x, y);
  ref_planes_free(&coarse);
}

/* ------------------------------------------------------------------------ */
/* split                                                                     */

/* Unit view-space normal that faces the eye. */
static vec facing_normal(const ref_job *job, int x, int y) {
  vec wo = scaled(-1.0, normalized(ray_of(job, x, y)));
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

static double exact_depth(const ref_job *job, int x, int y) {
  double along = job->config->depth_kind == HBIL_DEPTH_PLANAR
                     ? 1.0
                     : length(ray_of(job, x, y));
  return (double)input_at(job, REF_DEPTH, x, y) / along;
}

/* Rounded once: the float that the plan stores decides about levels. */
static double rounded_w(const ref_job *job, int x, int y) {
  return (float)w_of(job->config, exact_depth(job, x, y));
}

static void split_pixel(const ref_job *job, const ref_planes *carried, int x,
                        int y, ref_planes *split) {
  vec n = facing_normal(job, x, y);
  *ref_at(split, HBIL_SPLIT_W, x, y) = rounded_w(job, x, y);
  *ref_at(split, HBIL_SPLIT_NORMAL, x, y) = n.x;
  *ref_at(split, HBIL_SPLIT_NORMAL + 1, x, y) = n.y;
  *ref_at(split, HBIL_SPLIT_NORMAL + 2, x, y) = n.z;
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
  p.samples = (int)c->steps_per_side;
  p.levels = isinf(c->radius) ? 1 : HBIL_MAX_LEVELS;
  p.lattice = c->sample_grid == HBIL_GRID_SAME_LAYER ? HBIL_SIDE : 1;
  p.reach = fmaxf((float)v.width / v.fx, (float)v.height / v.fy);
  p.growth = c->step_growth;
  p.turn = (float)fmod(job->index * 0.6457513, 1.0);
  p.shift = (float)fmod(job->index * 0.7548777, 1.0);
  return p;
}

/* A visible point of the scene. */
typedef struct surface {
  bool is;
  double w;      /* inverse depth; orthographic, -z */
  double unit;   /* of what w is a share of: itself; orthographic, 1 */
  double gx, gy; /* of its tangent plane's w */
  vec ray, at, normal;
} surface;

static double w_at(const ref_planes *split, int x, int y) {
  if (x < 0 || y < 0 || x >= split->width || y >= split->height)
    return (double)HBIL_NOTHING;
  return *ref_at(split, HBIL_SPLIT_W, x, y);
}

static surface surface_at(const ref_job *job, const ref_planes *split, int x,
                          int y) {
  surface s = {false, 0.0, 0.0, 0.0, 0.0, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  double to_plane;
  s.w = w_at(split, x, y);
  s.is = shows(job->config, s.w);
  if (!s.is)
    return s;
  s.unit = is_orthographic(job->config) ? 1.0 : s.w;
  s.ray = ray_of(job, x, y);
  s.at = seen_at(job, x, y, z_of(job->config, s.w));
  s.normal = normalized(make(*ref_at(split, HBIL_SPLIT_NORMAL, x, y),
                             *ref_at(split, HBIL_SPLIT_NORMAL + 1, x, y),
                             *ref_at(split, HBIL_SPLIT_NORMAL + 2, x, y)));
  /* n.r' / n.P is the plane's inverse depth along the ray r'; orthographic,
   * n.e / n_z is what -z gains along e */
  to_plane = is_orthographic(job->config) ? s.normal.z : dot(s.normal, s.at);
  s.gx = s.normal.x / to_plane;
  s.gy = s.normal.y / to_plane;
  return s;
}

typedef struct gathering {
  const ref_job *job;
  const ref_planes *split;
  ref_planes *gathered;
  const ref_dense *dense; /* NULL: the kernels' pattern */
  hbil_view_args view;
  hbil_pattern_args pattern; /* dense: its number of slices only */
  int threads;
  atomic_int *rows_done;
} gathering;

/* What a mode computes. */
static bool gathers_light(const hbil_config *c) {
  return c->mode == HBIL_MODE_HBIL;
}

static bool has_bent(const hbil_config *c) {
  return c->mode != HBIL_MODE_HBAO;
}

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
  bool uniform; /* every direction counts alike (HBAO), not by its cosine */
} half_slice;

/* An angle from wo, and what is needed of it. */
typedef struct angle {
  double theta, sine, cosine, arc; /* arc: theta - sine cosine */
} angle;

/* Of the direction with these two components; of any length. */
static angle angle_of(double along, double wo) {
  double size = sqrt(along * along + wo * wo);
  angle a = {atan2(along, wo), along / size, wo / size, 0.0};
  a.arc = a.theta - a.sine * a.cosine;
  return a;
}

/* Measure of the angles from wo to a: cosine-weighted, or the solid angle per
 * unit of azimuth. */
static double measure(const half_slice *h, angle a) {
  if (h->uniform)
    return 1.0 - a.cosine;
  return h->nx / 2.0 * a.arc + h->ny / 2.0 * a.sine * a.sine;
}

static vec bent_to(const half_slice *h, angle a) {
  vec along = scaled(a.arc / 2.0, h->along);
  return add(along, a.sine * a.sine / 2.0, h->wo);
}

static half_slice make_half(const gathering *g, const surface *s, double ux,
                            double uy) {
  half_slice h;
  double across;
  h.u = make(ux, uy, 0.0);
  h.wo = scaled(-1.0, normalized(s->ray));
  h.along = normalized(add(h.u, -dot(h.u, h.wo), h.wo));
  h.nx = dot(s->normal, h.along);
  h.ny = dot(s->normal, h.wo);
  across = dot(h.u, h.wo); /* u has no z: only the xy parts count */
  h.weight = g->dense && g->dense->equal_weights
                 ? 1.0
                 : fabs(h.wo.z) / (1.0 - across * across);
  h.uniform = g->job->config->mode == HBIL_MODE_HBAO;
  return h;
}

/*
 * Angle from wo of a point `distance` along the slice whose inverse depth is
 * `excess * distance` above the tangent plane: the direction to it, scaled by
 * both inverse depths so that points at and beyond infinity are no exception,
 *   w0 w1 (P1 - P0) = w0 (r0 + e) - w1 r0 = w0 e - (w1 - w0) r0.
 */
static angle horizon(const surface *s, const half_slice *h, double distance,
                     double excess) {
  double rise = (s->gx * h->u.x + s->gy * h->u.y + excess) * distance;
  vec to = add(scaled(distance * s->unit, h->u), -rise, s->ray);
  return angle_of(dot(to, h->along), dot(to, h->wo));
}

static double fade(const hbil_config *c, double cosine) {
  double low = (double)c->facing_fade[0], high = (double)c->facing_fade[1], t;
  if (low == high)
    return cosine >= low ? 1.0 : 0.0;
  t = clamp((cosine - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

static double tolerance_of(const hbil_config *c) {
  return c->depth.component == HBIL_FLOAT16 ? ldexp(1.0, -10) : ldexp(1.0, -22);
}

/* What the rounding of the normal alone may raise a sample of the pixel's own
 * plane by: the normal's unit roundoff, eightfold, in the plane's gradient. */
static double least_excess(const hbil_config *c, const surface *s) {
  double cosine = -dot(s->normal, s->ray) / length(s->ray);
  double unit = ldexp(1.0, c->normal.component == HBIL_FLOAT16  ? -10
                           : c->storage != HBIL_STORAGE_FLOAT32 ? -13
                                                                : -21);
  return unit * s->unit / (cosine * cosine * length(s->ray));
}

/* Weight of an occluder at distance r (hbil_falloff). */
static double falloff(const hbil_config *c, double r) {
  double share = r / (double)c->radius; /* 0 where unlimited */
  if (c->mode != HBIL_MODE_HBAO || c->falloff == HBIL_FALLOFF_NONE)
    return 1.0;
  return c->falloff == HBIL_FALLOFF_LINEAR ? fmax(0.0, 1.0 - share)
                                           : 1.0 - share / 3.0;
}

/* A stretch of a half-slice's angles that is covered.  Angles fall as excess
 * grows, so either tells the order; excess costs nothing to know. */
typedef struct stretch {
  double high, low;  /* excess of the end towards wo, and of the other */
  angle front, back; /* their angles */
} stretch;

/* One pixel, what its half-slices add up to, and the thread's room for a
 * half-slice's stretches. */
typedef struct walker {
  const gathering *g;
  surface s;
  int x, y, layer, level;
  double pixel_x, pixel_y; /* size, in units of ray slope */
  double keep, least;      /* of a sampled inverse depth; excess that counts */
  sums sum;
  stretch *room;
} walker;

/* How what is covered is kept. */
typedef enum cover_kind {
  COVER_HORIZON,  /* endless occluders: everything beyond one angle */
  COVER_SECTORS,  /* the kernels' parts of the measure, dithered */
  COVER_STRETCHES /* exactly */
} cover_kind;

/* A half-slice on its way outwards. */
typedef struct march {
  half_slice h;
  cover_kind kind;
  angle start;    /* of the tangent plane */
  double whole;   /* measure up to it */
  double best;    /* excess that a sample must exceed */
  double covered; /* measure */
  double blocked; /* the same, weighed by the falloff */
  double less;    /* factor of what is open, of extrapolation */
  double unknown, light[3], last[3];
  angle top;        /* COVER_HORIZON: the horizon */
  double below;     /* measure up to it */
  unsigned sectors; /* COVER_SECTORS: from wo outwards */
  double dither;
  vec bent;      /* of what is open */
  stretch *list; /* COVER_STRETCHES: disjoint, from wo outwards */
  int count;
} march;

static cover_kind cover_kind_of(const gathering *g) {
  const hbil_config *c = g->job->config;
  if (isinf(c->thickness) && isinf(c->relative_thickness))
    return COVER_HORIZON;
  return g->dense ? COVER_STRETCHES : COVER_SECTORS;
}

static march begin(const walker *w, double ux, double uy) {
  march m;
  memset(&m, 0, sizeof(m));
  m.h = make_half(w->g, &w->s, ux, uy);
  m.kind = cover_kind_of(w->g);
  m.less = 1.0;
  m.start = m.top = angle_of(m.h.ny, -m.h.nx);
  m.whole = m.below = measure(&m.h, m.start);
  m.best = w->least;
  m.dither = (hbil_shift_slot(w->layer) + 0.5) / 16.0;
  m.bent = bent_to(&m.h, m.start);
  m.list = w->room;
  for (int i = 0; i < 3 && gathers_light(w->g->job->config); ++i)
    m.last[i] = *ref_at(w->g->split, HBIL_SPLIT_RED + i, w->x, w->y);
  return m;
}

/* A sample that lies above the tangent plane. */
typedef struct occluder {
  surface s;
  int x, y;
  vec to;                 /* from the point */
  double distance, range; /* along the slice in units of ray slope; |to| */
  double excess;
} occluder;

/* Where the back of a sample lies, in excess. */
static double excess_of_back(const ref_job *job, const occluder *o) {
  const hbil_config *c = job->config;
  double z = z_of(c, o->s.w);
  double deep =
      fmin((double)c->thickness / length(o->s.ray),
           (double)c->relative_thickness * depth_unit(c, &job->camera, z));
  return fmax(o->excess + (w_of(c, z + deep) - o->s.w) / o->distance, 0.0);
}

static double raise_horizon(const walker *w, march *m, const occluder *o) {
  double before = m->below;
  m->top = horizon(&w->s, &m->h, o->distance, o->excess);
  m->below = measure(&m->h, m->top);
  m->best = o->excess;
  return before - m->below;
}

static unsigned sectors_below(const march *m, angle a) {
  double part =
      measure(&m->h, a) / fmax(m->whole, 1e-6) * HBIL_SECTORS + m->dither;
  return (1u << (int)clamp(part, 0.0, HBIL_SECTORS)) - 1u;
}

static double cover_sectors(const walker *w, march *m, const occluder *o) {
  double low = excess_of_back(w->g->job, o);
  angle front = horizon(&w->s, &m->h, o->distance, o->excess);
  angle back = horizon(&w->s, &m->h, o->distance, low);
  unsigned fresh =
      sectors_below(m, back) & ~sectors_below(m, front) & ~m->sectors;
  int count = 0;
  double share, part;
  m->sectors |= fresh;
  for (; fresh; fresh &= fresh - 1)
    ++count;
  share = m->whole * count / HBIL_SECTORS;
  /* the interval's mean direction stands for its fresh part */
  part = share / fmax(measure(&m->h, back) - measure(&m->h, front), 1e-5);
  m->bent = add(m->bent, part, bent_to(&m->h, front));
  m->bent = add(m->bent, -part, bent_to(&m->h, back));
  return share;
}

/* Measure of `s` that a stretch of the list has already. */
static double overlap(const half_slice *h, const stretch *s,
                      const stretch *covered) {
  bool in_front = s->high > covered->high, behind = s->low < covered->low;
  return measure(h, behind ? covered->back : s->back) -
         measure(h, in_front ? covered->front : s->front);
}

/* Puts one stretch in the place of those in [first, last), which touch it. */
static void merge(march *m, stretch s, int first, int last) {
  if (last > first && m->list[first].high > s.high) {
    s.high = m->list[first].high;
    s.front = m->list[first].front;
  }
  if (last > first && m->list[last - 1].low < s.low) {
    s.low = m->list[last - 1].low;
    s.back = m->list[last - 1].back;
  }
  memmove(m->list + first + 1, m->list + last,
          (size_t)(m->count - last) * sizeof(s));
  m->list[first] = s;
  m->count += 1 - (last - first);
}

static double cover_stretch(const walker *w, march *m, const occluder *o) {
  stretch s = {.high = o->excess, .low = excess_of_back(w->g->job, o)};
  int first = 0, last;
  double taken;
  while (first < m->count && m->list[first].low > s.high)
    ++first;
  if (first < m->count && m->list[first].high >= s.high &&
      m->list[first].low <= s.low)
    return 0.0; /* within a stretch: nothing new, and no angles needed */
  s.front = horizon(&w->s, &m->h, o->distance, s.high);
  s.back = horizon(&w->s, &m->h, o->distance, s.low);
  taken = measure(&m->h, s.back) - measure(&m->h, s.front);
  for (last = first; last < m->count && m->list[last].high >= s.low; ++last)
    taken -= overlap(&m->h, &s, m->list + last);
  merge(m, s, first, last);
  return fmax(taken, 0.0);
}

/* Covers what a sample hides; returns the measure that was open before. */
static double cover(const walker *w, march *m, const occluder *o) {
  if (m->kind == COVER_HORIZON)
    return raise_horizon(w, m, o);
  return m->kind == COVER_SECTORS ? cover_sectors(w, m, o)
                                  : cover_stretch(w, m, o);
}

/* The light that is taken to come from a newly found occluder, for all of the
 * measure that it newly covers. */
static void take_light(const walker *w, march *m, const occluder *o,
                       double taken) {
  const hbil_config *c = w->g->job->config;
  double t = fade(c, -dot(o->s.normal, o->to) / o->range);
  for (int i = 0; i < 3; ++i) {
    double own = *ref_at(w->g->split, HBIL_SPLIT_RED + i, o->x, o->y);
    m->last[i] = c->back_facing_fallback == HBIL_FALLBACK_LAST_ACCEPTED
                     ? m->last[i] + t * (own - m->last[i])
                     : t * own;
    m->light[i] += m->last[i] * taken;
  }
  m->unknown += (1.0 - t) * taken;
}

static void meet(const walker *w, march *m, occluder *o) {
  const hbil_config *c = w->g->job->config;
  double taken;
  o->s = surface_at(w->g->job, w->g->split, o->x, o->y);
  o->to = add(o->s.at, -1.0, w->s.at);
  o->range = length(o->to);
  if (!isinf(c->radius) && !(o->range <= (double)c->radius))
    return;
  taken = cover(w, m, o);
  m->covered += taken;
  m->blocked += falloff(c, o->range) * taken;
  /* what covers nothing new is not seen */
  if (gathers_light(c) && taken > 0.0)
    take_light(w, m, o, taken);
}

/* Looks at one pixel inside the image.  Most samples do not rise: for them the
 * excess is compared squared, without a root. */
static void visit(const walker *w, march *m, int x, int y) {
  double w1 = *ref_at(w->g->split, HBIL_SPLIT_W, x, y);
  double ex = (x - w->x) * w->pixel_x, ey = (y - w->y) * w->pixel_y;
  double above = w1 * w->keep - w->s.w - w->s.gx * ex - w->s.gy * ey;
  double e2 = ex * ex + ey * ey;
  occluder o;
  if (!(shows(w->g->job->config, w1) && above > 0.0 &&
        above * above > m->best * m->best * e2))
    return;
  o.x = x;
  o.y = y;
  o.distance = sqrt(e2);
  o.excess = above / o.distance;
  meet(w, m, &o);
}

static bool inside(const ref_planes *p, int x, int y) {
  return x >= 0 && y >= 0 && x < p->width && y < p->height;
}

/* The pixels that the kernels look at, or one half of them (HBIL_HALF_). */
static void follow_pattern(const walker *w, march *m, int halves) {
  const gathering *g = w->g;
  const float ux = (float)m->h.u.x, uy = (float)m->h.u.y;
  const int samples = g->pattern.samples;
  int x, y, before = 0;
  hbil_sample_offset(w->layer, 0, w->level, ux, uy, g->view, g->pattern, &x,
                     &y);
  for (int k = 0; k < samples; ++k) {
    int next_x = x, next_y = y;
    if (k + 1 < samples)
      hbil_sample_offset(w->layer, k + 1, w->level, ux, uy, g->view, g->pattern,
                         &next_x, &next_y);
    if (halves & hbil_sample_halves(w->layer, k, samples, before,
                                    hbil_offset_length(next_x, next_y)) &&
        inside(g->split, w->x + x, w->y + y))
      visit(w, m, w->x + x, w->y + y);
    before = hbil_offset_length(x, y);
    x = next_x;
    y = next_y;
  }
}

/* Least distance from the pixel's point to anything that a pixel can show:
 * rises along a half-slice. */
static double nearest_on(const walker *w, double x, double y) {
  const vec from = seen_at(w->g->job, x, y, 0.0);
  const vec way = add(w->s.at, -1.0, from);
  const vec to = normalized(ray_of(w->g->job, x, y));
  return length(add(way, -fmax(0.0, dot(way, to)), to));
}

/* Number of steps (sx, sy) beyond which nothing can be within the radius. */
static int steps_within(const walker *w, double sx, double sy) {
  const gathering *g = w->g;
  double radius = (double)g->job->config->radius;
  int near = 0, far = g->split->width + g->split->height;
  if (isinf(radius))
    return far;
  while (near < far) {
    int middle = (near + far + 1) / 2;
    if (nearest_on(w, w->x + middle * sx, w->y + middle * sy) <= radius)
      near = middle;
    else
      far = middle - 1;
  }
  return near + 2; /* pixels lie up to half a pixel off the line */
}

/* The pixel in every column (or row) that the line from a pixel's centre
 * crosses. */
static void follow_line(const walker *w, march *m) {
  const ref_planes *split = w->g->split;
  double px = m->h.u.x * w->g->job->camera.fx;
  double py = m->h.u.y * w->g->job->camera.fy;
  double major = fmax(fabs(px), fabs(py));
  double slope_x = fabs(px) / major, slope_y = fabs(py) / major;
  int sign_x = px < 0.0 ? -1 : 1, sign_y = py < 0.0 ? -1 : 1;
  int steps = steps_within(w, px / major, py / major);
  for (int k = 1; k <= steps; ++k) {
    int x = w->x + sign_x * (int)(k * slope_x + 0.5);
    int y = w->y + sign_y * (int)(k * slope_y + 0.5);
    if (!inside(split, x, y))
      return;
    visit(w, m, x, y);
  }
}

static const int both_halves = HBIL_HALF_EVEN | HBIL_HALF_ODD;

/* The jackknife: what all samples cover, and once more what either half of them
 * covers less on average; no more than there is. */
static void extrapolate(const walker *w, march *m) {
  double half = 0.0, open = m->whole - m->covered, left, more;
  for (int i = HBIL_HALF_EVEN; i <= HBIL_HALF_ODD; ++i) {
    march part = begin(w, m->h.u.x, m->h.u.y);
    follow_pattern(w, &part, i);
    half += 0.5 * (part.whole - part.covered);
  }
  left = fmax(2.0 * open - half, 0.0);
  more = m->covered > 0.0 ? (m->whole - left) / m->covered : 1.0;
  /* the sum of all sectors leaves a rounding of nothing */
  m->less = open > 1e-12 * m->whole ? left / open : 1.0;
  m->blocked *= more;
  m->unknown *= more;
  for (int i = 0; i < 3; ++i)
    m->light[i] *= more;
}

static march march_along(const walker *w, double ux, double uy) {
  march m = begin(w, ux, uy);
  if (w->g->dense) {
    follow_line(w, &m);
    return m;
  }
  follow_pattern(w, &m, both_halves);
  if (w->g->job->config->extrapolate)
    extrapolate(w, &m);
  return m;
}

/* Integral of bent_to() over what the stretches leave open. */
static vec bent_between(const march *m) {
  vec sum = bent_to(&m->h, m->start);
  for (int i = 0; i < m->count; ++i) {
    sum = add(sum, 1.0, bent_to(&m->h, m->list[i].front));
    sum = add(sum, -1.0, bent_to(&m->h, m->list[i].back));
  }
  return sum;
}

static vec open_bent(const march *m) {
  vec open = m->kind == COVER_HORIZON   ? bent_to(&m->h, m->top)
             : m->kind == COVER_SECTORS ? m->bent
                                        : bent_between(m);
  return scaled(m->less, open);
}

static void add_openness(walker *w, const march *m) {
  w->sum.whole += m->h.weight * m->whole;
  w->sum.open += m->h.weight * (m->whole - m->blocked);
}

/*
 * The same as Jimenez et al. 2016 write it, in terms of the slice's plane: the
 * normal projected onto it has a length and a signed angle gamma from wo, and
 * between the horizons h1 < 0 < h2, no farther than pi/2 from gamma, lies
 *   length/4 (-cos(2 h1 - gamma) + cos gamma + 2 h1 sin gamma
 *             -cos(2 h2 - gamma) + cos gamma + 2 h2 sin gamma).
 */
static double arc(double gamma, double h) {
  h = clamp(h, gamma - PI / 2.0, gamma + PI / 2.0);
  return (-cos(2.0 * h - gamma) + cos(gamma) + 2.0 * h * sin(gamma)) / 4.0;
}

static void add_arcs(walker *w, const march *ahead, const march *behind) {
  const half_slice *h = &ahead->h;
  double size = sqrt(h->nx * h->nx + h->ny * h->ny);
  double gamma = atan2(h->nx, h->ny);
  w->sum.whole += h->weight * size * (arc(gamma, PI) + arc(gamma, -PI));
  w->sum.open += h->weight * size *
                 (ahead->less * arc(gamma, ahead->top.theta) +
                  behind->less * arc(gamma, -behind->top.theta));
}

static void add_bent_and_light(walker *w, const march *m) {
  sums *sum = &w->sum;
  sum->bent = add(sum->bent, m->h.weight, open_bent(m));
  sum->bent_whole = add(sum->bent_whole, m->h.weight, bent_to(&m->h, m->start));
  sum->unknown += m->h.weight * m->unknown;
  for (int i = 0; i < 3; ++i)
    sum->light[i] += m->h.weight * m->light[i];
}

static void gather_slice(walker *w, double ux, double uy) {
  march ahead = march_along(w, ux, uy), behind;
  bool arcs =
      w->g->job->config->mode == HBIL_MODE_GTAO && ahead.kind == COVER_HORIZON;
  if (!arcs)
    add_openness(w, &ahead);
  add_bent_and_light(w, &ahead);
  behind = march_along(w, -ux, -uy); /* in the same room for stretches */
  if (!arcs)
    add_openness(w, &behind);
  else
    add_arcs(w, &ahead, &behind);
  add_bent_and_light(w, &behind);
}

/* The level that the pixel's tile of its layer's row uses. */
static int level_at(const gathering *g, int x, int y) {
  int first =
      x % HBIL_SIDE + x / (HBIL_SIDE * HBIL_SPAN) * HBIL_SIDE * HBIL_SPAN;
  float nearest = 0.0f;
  if (g->pattern.levels == 1)
    return 0;
  for (int i = 0; i < HBIL_SPAN; ++i) {
    int at = first + i * HBIL_SIDE;
    if (at < g->split->width)
      nearest = fmaxf(nearest, (float)*ref_at(g->split, HBIL_SPLIT_W, at, y));
  }
  if (is_orthographic(g->job->config))
    nearest = 1.0f;
  return hbil_level(g->pattern.reach, g->job->config->radius * nearest,
                    g->pattern.levels);
}

/* Whether refused light is made up for by the frame's. */
static bool fills_unknown(const hbil_config *config) {
  return gathers_light(config) &&
         config->back_facing_fallback == HBIL_FALLBACK_FRAME_MEAN;
}

bool ref_weighs_slices(const hbil_config *config) {
  return config->slices == 1 && !config->unfiltered;
}

static void store_bent_sum(const walker *w, double ao) {
  const sums *sum = &w->sum;
  double slices = w->g->pattern.slices;
  /* what few slices miss of the whole plane's bent normal */
  vec rest = add(scaled(slices, w->s.normal), -1.0, sum->bent_whole);
  vec bent = scaled(1.0 / slices, add(sum->bent, ao, rest));
  *ref_at(w->g->gathered, HBIL_LIGHT_BENT, w->x, w->y) = bent.x;
  *ref_at(w->g->gathered, HBIL_LIGHT_BENT + 1, w->x, w->y) = bent.y;
  *ref_at(w->g->gathered, HBIL_LIGHT_BENT + 2, w->x, w->y) = bent.z;
}

static void store_gathered(const walker *w) {
  const ref_planes *gathered = w->g->gathered;
  const sums *sum = &w->sum;
  double ao = sum->open / sum->whole;
  *ref_at(gathered, HBIL_LIGHT_AO, w->x, w->y) = ao;
  for (int i = 0; i < 3; ++i)
    *ref_at(gathered, HBIL_LIGHT_RED + i, w->x, w->y) =
        PI * sum->light[i] / sum->whole;
  if (has_bent(w->g->job->config))
    store_bent_sum(w, ao);
  if (gathered->count > HBIL_LIGHT_UNKNOWN && fills_unknown(w->g->job->config))
    *ref_at(gathered, HBIL_LIGHT_UNKNOWN, w->x, w->y) =
        sum->unknown / sum->whole;
  if (gathered->count > HBIL_LIGHT_WEIGHT &&
      ref_weighs_slices(w->g->job->config))
    *ref_at(gathered, HBIL_LIGHT_WEIGHT, w->x, w->y) = sum->whole;
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

static walker walker_at(const gathering *g, int x, int y, stretch *room) {
  walker w;
  memset(&w, 0, sizeof(w));
  w.g = g;
  w.s = surface_at(g->job, g->split, x, y);
  w.x = x;
  w.y = y;
  w.layer = HBIL_SIDE * (y % HBIL_SIDE) + x % HBIL_SIDE;
  w.level = g->dense ? 0 : level_at(g, x, y);
  w.pixel_x = 1.0 / g->job->camera.fx;
  w.pixel_y = 1.0 / g->job->camera.fy;
  w.keep = 1.0 - (is_orthographic(g->job->config) ? -1.0 : 1.0) *
                     tolerance_of(g->job->config);
  w.room = room;
  return w;
}

static void gather_pixel(const gathering *g, int x, int y, stretch *room) {
  walker w = walker_at(g, x, y, room);
  clear(g->gathered, x, y);
  *ref_at(g->gathered, HBIL_LIGHT_AO, x, y) = 1.0;
  if (g->gathered->count > HBIL_LIGHT_WEIGHT &&
      ref_weighs_slices(g->job->config))
    *ref_at(g->gathered, HBIL_LIGHT_WEIGHT, x, y) = 1.0;
  if (!w.s.is)
    return;
  w.least = least_excess(g->job->config, &w.s);
  for (int slice = 0; slice < g->pattern.slices; ++slice) {
    double ux, uy;
    slice_direction(&w, slice, &ux, &uy);
    gather_slice(&w, ux, uy);
  }
  store_gathered(&w);
}

static bool is_wanted(const gathering *g, int x, int y) {
  return !g->dense || !g->dense->wanted ||
         g->dense->wanted[(size_t)y * (size_t)g->split->width + (size_t)x];
}

static void gather_row(const gathering *g, int y, stretch *room) {
  for (int x = 0; x < g->split->width; ++x)
    if (is_wanted(g, x, y))
      gather_pixel(g, x, y, room);
  atomic_fetch_add(g->rows_done, 1);
}

/* One thread's share: every `threads`-th row. */
typedef struct worker {
  const gathering *g;
  int index;
  pthread_t thread;
  bool running;
} worker;

static void report(const gathering *g) {
  if (g->dense && g->dense->progress)
    g->dense->progress(g->dense->user, atomic_load(g->rows_done),
                       g->split->height);
}

static void gather_share(const worker *w, bool reports) {
  const gathering *g = w->g;
  /* no line crosses more pixels, and a pixel adds one stretch at most */
  size_t longest = (size_t)(g->split->width + g->split->height);
  stretch *room = allocate(longest, sizeof(*room));
  for (int y = w->index; y < g->split->height; y += g->threads) {
    gather_row(g, y, room);
    if (reports)
      report(g);
  }
  free(room);
}

static void *gather_share_aside(void *argument) {
  gather_share(argument, false);
  return NULL;
}

/* The calling thread takes its share, and that of threads that can't start. */
static void gather_all(gathering *g) {
  atomic_int done = 0;
  worker *workers = allocate((size_t)g->threads, sizeof(*workers));
  g->rows_done = &done;
  for (int i = g->threads - 1; i >= 0; --i) {
    workers[i].g = g;
    workers[i].index = i;
    workers[i].running =
        i > 0 && pthread_create(&workers[i].thread, NULL, gather_share_aside,
                                workers + i) == 0;
  }
  for (int i = 0; i < g->threads; ++i)
    if (!workers[i].running)
      gather_share(workers + i, true);
  for (int i = 0; i < g->threads; ++i)
    if (workers[i].running)
      pthread_join(workers[i].thread, NULL);
  report(g);
  free(workers);
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
  g.threads = 2;
  return g;
}

void ref_gather(const ref_job *job, const ref_planes *split,
                ref_planes *gathered) {
  gathering g = gathering_of(job, split, gathered);
  gather_all(&g);
}

void ref_gather_dense(const ref_job *job, const ref_planes *split,
                      const ref_dense *how, ref_planes *gathered) {
  gathering g = gathering_of(job, split, gathered);
  g.dense = how;
  g.pattern.slices = how->slices;
  if (how->threads > 0)
    g.threads = how->threads;
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
      if (s.is)
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

/* Of layers that are around a pixel twice, both count half; of the one at the
 * four corners, two opposite ones do. */
static double spatial(int dx, int dy) {
  bool outer_x = abs(dx) == 2, outer_y = abs(dy) == 2;
  if (outer_x && outer_y)
    return dx == dy ? 0.5 : 0.0;
  return outer_x || outer_y ? 0.5 : 1.0;
}

static double guide(const ref_job *job, const surface *s,
                    const ref_planes *split, int x, int y, int dx, int dy) {
  surface other;
  double plane, off, turned;
  other = surface_at(job, split, x + dx, y + dy);
  if (!other.is)
    return 0.0;
  plane = s->w + s->gx * dx / job->camera.fx + s->gy * dy / job->camera.fy;
  off = fabs(other.w - plane) / ((double)HBIL_PLANE_TOLERANCE *
                                 depth_unit(job->config, &job->camera, s->w));
  turned = (1.0 - dot(s->normal, other.normal)) / (double)HBIL_TURN_TOLERANCE;
  return fmax(0.0, 1.0 - off * off - turned);
}

double ref_guide(const ref_job *job, const ref_planes *split, int x, int y,
                 int dx, int dy) {
  surface s = surface_at(job, split, x, y);
  return s.is ? guide(job, &s, split, x, y, dx, dy) : 0.0;
}

static double tap_weight(const ref_job *job, const surface *s,
                         const ref_planes *split, int x, int y, int dx,
                         int dy) {
  if (job->config->unfiltered && (dx || dy))
    return 0.0;
  return spatial(dx, dy) * guide(job, s, split, x, y, dx, dy);
}

static void normalize_bent(ref_planes *resolved, int x, int y) {
  double *p[3], size = 0.0;
  for (int i = 0; i < 3; ++i) {
    p[i] = ref_at(resolved, HBIL_LIGHT_BENT + i, x, y);
    size += *p[i] * *p[i];
  }
  /* a length of 1e-12 is what roundings leave of a closed point's */
  for (int i = 0; i < 3; ++i)
    *p[i] = size > 1e-24 ? *p[i] / sqrt(size) : 0.0;
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
  bool fills = fills_unknown(job->config);
  surface s = surface_at(job, split, x, y);
  double total = 0.0, unknown = 0.0;
  clear(resolved, x, y);
  *ref_at(resolved, HBIL_LIGHT_AO, x, y) = s.is ? 0.0 : 1.0;
  if (!s.is)
    return;
  for (int tap = 0; tap < 25; ++tap) {
    int dx = tap % 5 - 2, dy = tap / 5 - 2;
    double weight = tap_weight(job, &s, split, x, y, dx, dy), quotient;
    if (!(weight > 0.0))
      continue;
    quotient = weight;
    if (ref_weighs_slices(job->config))
      quotient *= *ref_at(gathered, HBIL_LIGHT_WEIGHT, x + dx, y + dy);
    total += quotient;
    for (int p = 0; p < HBIL_LIGHT_PLANES; ++p)
      *ref_at(resolved, p, x, y) += (p < HBIL_LIGHT_BENT ? quotient : weight) *
                                    *ref_at(gathered, p, x + dx, y + dy);
    if (fills)
      unknown +=
          quotient * *ref_at(gathered, HBIL_LIGHT_UNKNOWN, x + dx, y + dy);
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

/* Of the share `ao` of the hemisphere that the screen leaves open, what ends on
 * a surface all the same.  Direct light (as radiance) that holds the sky's
 * shows that no more than direct / sky of the hemisphere sees the sky; of the
 * open share, dark = 1 - direct / sky / ao is thus without it, and an open
 * direction is taken for blocked as often. */
static double unlit_share(const ref_job *job, int x, int y, double ao) {
  double seen = 0.0, dark;
  for (int c = 0; c < 3; ++c) {
    double sky = (double)job->environment[0][c];
    if (sky > 0.0)
      seen = fmax(seen, direct_at(job, c, x, y) / PI / sky);
  }
  dark = clamp(1.0 - seen / fmax(ao, 1e-6), 0.0, 1.0);
  return ao * dark * dark;
}

/* Far irradiance through a cone about a view-space direction (0: none). */
static double far_irradiance(const ref_job *job, int channel, int x, int y,
                             double ao, vec bent, double near_irradiance) {
  vec world = to_world(&job->camera, bent);
  double d[3] = {world.x, world.y, world.z}, basis[9], sum = 0.0;
  if (job->config->far_field == HBIL_FAR_NONE)
    return 0.0;
  if (job->config->far_field == HBIL_FAR_CONSTANT)
    return PI * ao * (double)job->environment[0][channel];
  if (job->config->far_field == HBIL_FAR_FRAME)
    return PI * unlit_share(job, x, y, ao) *
           unseen_light(job, channel, bent, near_irradiance / PI, 1.0 - ao);
  ref_sh_basis(d, basis);
  for (int i = 0; i < 9; ++i) {
    int l = band_of(i);
    sum += sqrt(4.0 * PI / (2 * l + 1)) *
           cone_band(l, sqrt(fmax(0.0, 1.0 - ao))) * basis[i] *
           (double)job->environment[i][channel];
  }
  return fmax(0.0, sum);
}

static double sky_radiance(const ref_job *job, int channel, int x, int y) {
  vec world = to_world(&job->camera, normalized(ray_of(job, x, y)));
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
                              double near_irradiance, double far,
                              ref_planes *out, ref_planes *history) {
  double entering = entering_at(job, c, x, y);
  double indirect = entering * (near_irradiance + far) / PI;
  double diffuse = albedo_at(job, c, x, y) *
                   (entering * direct_at(job, c, x, y) / PI + indirect);
  *ref_at(out, REF_NEAR + c, x, y) = near_irradiance;
  *ref_at(out, REF_FAR + c, x, y) = far;
  *ref_at(out, REF_INDIRECT + c, x, y) = indirect;
  *ref_at(out, REF_RADIANCE + c, x, y) =
      diffuse + light_at(job, REF_EMISSION + c, x, y);
  *ref_at(history, HBIL_HISTORY_RED + c, x, y) =
      job->config->feedback == HBIL_FEEDBACK_IRRADIANCE
          ? near_irradiance + far
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
  if (has_bent(job->config))
    *ref_at(out, REF_CONE, x, y) = sqrt(fmax(0.0, 1.0 - ao));
  store_bent(out, x, y,
             job->config->bent_normal_space == HBIL_SPACE_WORLD
                 ? to_world(&job->camera, bent)
                 : bent);
  for (int c = 0; c < 3; ++c) {
    double near_irradiance = *ref_at(resolved, HBIL_LIGHT_RED + c, x, y);
    composite_channel(job, c, x, y, near_irradiance,
                      far_irradiance(job, c, x, y, ao, bent, near_irradiance),
                      out, history);
  }
  *ref_at(history, HBIL_HISTORY_W, x, y) =
      (float)(1.0 / exact_depth(job, x, y));
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

/* What comes before the gather: everything up to SPLIT and the estimate. */
static void prepare(ref_state *state, ref_job *job) {
  bool carries =
      job->config->reprojection != HBIL_REPROJECTION_NONE && state->has_history;
  job->previous = state->camera;
  if (carries) {
    ref_reproject(job, &state->history, &state->carried);
    ref_push_pull(&state->carried);
  }
  ref_split(job, carries ? &state->carried : NULL, &state->split);
  ref_estimate_frame(job, &state->split);
}

/* What comes after it. */
static void finish(ref_state *state, const ref_job *job) {
  ref_recompose(job, &state->split, &state->gathered, &state->resolved);
  ref_composite(job, &state->resolved, &state->out, &state->history);
  state->camera = job->camera;
  state->has_history = job->config->reprojection != HBIL_REPROJECTION_NONE;
}

void ref_frame(ref_state *state, ref_job *job) {
  prepare(state, job);
  ref_gather(job, &state->split, &state->gathered);
  finish(state, job);
}

void ref_frame_dense(ref_state *state, ref_job *job, const ref_dense *how) {
  hbil_config unfiltered = *job->config;
  ref_job own;
  unfiltered.unfiltered = CL_TRUE;
  prepare(state, job);
  own = *job;
  own.config = &unfiltered;
  ref_gather_dense(&own, &state->split, how, &state->gathered);
  finish(state, &own);
}
