/*
 * Injection: what a view tells of each voxel.
 *
 * A voxel looks at the texels around its own place in the view.  Surfaces in it
 * make its means; if only things behind it show, it is empty.
 */
#include <stdint.h>
#include <string.h>

#include "exact/cache.h"

/* How near to their other side decisions were. */
typedef struct decisions {
  double margin;
} decisions;

/* value >= 0 */
static bool decide(decisions *d, double value) {
  d->margin = fmin(d->margin, fabs(value));
  return value >= 0.0;
}

/* The distance of a value from the next whole number. */
static void decide_floor(decisions *d, double value) {
  d->margin = fmin(d->margin, fabs(value - rint(value)));
}

/* What the texels around a voxel's place have shown. */
typedef struct shown {
  int surfaces, taps, behind, sky;
  bool in_sight; /* any of the surfaces */
  vec3 normal, last;
  double offset, reflectance[3], sent[3];
} shown;

/* A point of the world in the view, and back. */
static vec3 to_view(const hbil_camera *camera, vec3 p) {
  const double *m = camera->world_from_view;
  const vec3 off = vec(p.x - m[3], p.y - m[7], p.z - m[11]);
  return vec(m[0] * off.x + m[4] * off.y + m[8] * off.z,
             m[1] * off.x + m[5] * off.y + m[9] * off.z,
             m[2] * off.x + m[6] * off.y + m[10] * off.z);
}

static vec3 to_world(const hbil_camera *camera, vec3 p) {
  const double *m = camera->world_from_view;
  return vec(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
             m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
             m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}

/* The point that a texel shows, in cache space. */
static vec3 point_of(const exact_cache *cache, const exact_cache_view *view,
                     int x, int y, double depth) {
  const hbil_camera *c = &view->camera;
  const double z = depth * cache->voxel_size;
  const double spread = view->orthographic ? 1.0 : z;
  const vec3 p = vec((x * view->stride + 0.5 - c->cx) / c->fx * spread,
                     (y * view->stride + 0.5 - c->cy) / c->fy * spread, z);
  return exact_cache_from_world(cache, to_world(c, p));
}

/* The texel of a place of cache space, and the place's depth in voxels. */
static bool texel_of(const exact_cache *cache, const exact_cache_view *view,
                     vec3 p, double size, decisions *d, int *x, int *y,
                     double *depth) {
  const hbil_camera *c = &view->camera;
  const vec3 q = to_view(c, exact_cache_to_world(cache, p));
  const double stride = view->stride;
  *depth = q.z / cache->voxel_size;
  if (!view->orthographic && !decide(d, *depth - 0.3 * size))
    return false;
  const double shrink = view->orthographic ? 1.0 : 1.0 / q.z;
  const double px = (c->fx * q.x * shrink + c->cx - 0.5) / stride + 0.5;
  const double py = (c->fy * q.y * shrink + c->cy - 0.5) / stride + 0.5;
  if (!decide(d, px) || !decide(d, py) || decide(d, px - view->width) ||
      decide(d, py - view->height))
    return false;
  decide_floor(d, px);
  decide_floor(d, py);
  *x = (int)px;
  *y = (int)py;
  return true;
}

/* Whether the plane of normal n through a point crosses a voxel; to: the point,
 * from the voxel's centre. */
static bool crosses(vec3 n, vec3 to, double size, decisions *d) {
  return decide(d, 0.5 * size * (fabs(n.x) + fabs(n.y) + fabs(n.z)) -
                       fabs(vec_dot(n, to)));
}

/* Whether the view has nothing in front of a place of a surface in a voxel but
 * planes that cross the voxel, too. */
static bool is_in_sight(const exact_cache *cache, const exact_cache_view *view,
                        vec3 p, vec3 centre, double size, decisions *d) {
  int x, y;
  double depth;
  if (!texel_of(cache, view, p, size, d, &x, &y, &depth))
    return true;
  const exact_texel *t = view->texel + (size_t)y * (size_t)view->width + x;
  if (!(t->depth > 0.0))
    return true;
  /* what shows the plane itself crosses the voxel, at any depth */
  const vec3 to = vec_add(point_of(cache, view, x, y, t->depth), -1.0, centre);
  return crosses(t->normal, to, size, d) || decide(d, t->depth - depth);
}

static void look(const exact_cache *cache, const exact_cache_view *view, int x,
                 int y, vec3 centre, double depth, double size, decisions *d,
                 shown *s) {
  const exact_texel *t = view->texel + (size_t)y * (size_t)view->width + x;
  ++s->taps;
  if (!(t->depth > 0.0)) {
    ++s->behind;
    ++s->sky;
    return;
  }
  const vec3 to = vec_add(point_of(cache, view, x, y, t->depth), -1.0, centre);
  const double most = fmax(fabs(to.x), fmax(fabs(to.y), fabs(to.z)));
  if (decide(d, size - most)) {
    const vec3 n = t->normal;
    const double along = vec_dot(n, to);
    if (crosses(n, to, size, d)) {
      s->in_sight =
          s->in_sight || decide(d, (double)HBIL_CACHE_INSIDE * size - most) ||
          is_in_sight(cache, view, vec_add(centre, along, n), centre, size, d);
      ++s->surfaces;
      s->normal = vec_add(s->normal, 1.0, n);
      s->last = n;
      s->offset += along;
      for (int c = 0; c < 3; ++c) {
        s->reflectance[c] += t->reflectance[c];
        s->sent[c] += t->sent[c];
      }
      return;
    }
  }
  s->behind += decide(d, t->depth - depth);
}

static void join(double *mean, double value, double share) {
  *mean += share * (value - *mean);
}

static bool is_other_light(const double *held, const shown *s, decisions *d) {
  double change = 0.0, most = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double seen = s->sent[c] / s->surfaces;
    change = fmax(change, fabs(held[c] - seen));
    most = fmax(most, fmax(held[c], seen));
  }
  /* in parts of the light, as roundings are */
  return most > 0.0 &&
         !decide(d, (double)HBIL_CACHE_LIGHT_CHANGED - change / most);
}

/* HBIL_VOXEL_BEFORE, whose lowest bits of a float are a number of views. */
static double mark(double light, unsigned views) {
  float value = (float)light;
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  bits = (bits & ~HBIL_VOXEL_MOMENT_VIEWS) | views;
  memcpy(&value, &bits, sizeof value);
  return (double)value;
}

unsigned exact_voxel_before(double held, double *light) {
  const float value = (float)held;
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  *light = mark(held, 0);
  return bits & HBIL_VOXEL_MOMENT_VIEWS;
}

/* The same with one more view. */
static double with_view(double before, bool is_like, const double *sent) {
  double light = sent[0] + sent[1] + sent[2];
  if (!is_like || before < 0.0)
    return -1.0;
  if (before > 0.0) {
    const unsigned views = exact_voxel_before(before, &light);
    return mark(light, views < HBIL_VOXEL_MOMENT_VIEWS ? views + 1 : views);
  }
  return light >= (double)HBIL_VOXEL_LEAST_LIGHT ? mark(light, 1) : -1.0;
}

/* Joins the means of a view to the voxel's. */
static void add_surface(exact_voxel *voxel, bool finished, const shown *s,
                        decisions *d) {
  double *v = voxel->value;
  const double mean[3] = {s->normal.x / s->surfaces, s->normal.y / s->surfaces,
                          s->normal.z / s->surfaces};
  const double last[3] = {s->last.x, s->last.y, s->last.z};
  const double most = (double)HBIL_CACHE_MOST_VIEWS;
  double length2 = 0.0;
  if (voxel->state != HBIL_VOXEL_SURFACE)
    for (int i = 0; i < HBIL_VOXEL_FLOATS; ++i)
      v[i] = 0.0;
  v[HBIL_VOXEL_WEIGHT] = fmin(v[HBIL_VOXEL_WEIGHT] + 1.0, most);
  const double share = 1.0 / v[HBIL_VOXEL_WEIGHT];
  join(v + HBIL_VOXEL_OFFSET, s->offset / s->surfaces, share);
  for (int c = 0; c < 3; ++c) {
    join(v + HBIL_VOXEL_NORMAL + c, mean[c], share);
    join(v + HBIL_VOXEL_REFLECTANCE + c, s->reflectance[c] / s->surfaces,
         share);
    length2 += v[HBIL_VOXEL_NORMAL + c] * v[HBIL_VOXEL_NORMAL + c];
  }
  /* opposite sides of a sheet leave no normal */
  if (!decide(d, length2 - 1e-4)) {
    for (int c = 0; c < 3; ++c)
      v[HBIL_VOXEL_NORMAL + c] = last[c];
    v[HBIL_VOXEL_OFFSET] = s->offset / s->surfaces;
  }
  double *weight = v + HBIL_VOXEL_LIGHT_WEIGHT;
  const double held = fabs(*weight);
  v[HBIL_VOXEL_BEFORE] =
      with_view(v[HBIL_VOXEL_BEFORE],
                s->in_sight && held >= 1.0 && finished == (*weight < 0.0),
                v + HBIL_VOXEL_SENT);
  if (*weight < 0.0 && !finished)
    return;
  if ((*weight > 0.0 && finished) || is_other_light(v + HBIL_VOXEL_SENT, s, d))
    *weight = 0.0;
  double views = fmin(fabs(*weight) + 1.0, most);
  for (int c = 0; c < 3; ++c)
    join(v + HBIL_VOXEL_SENT + c, s->sent[c] / s->surfaces, 1.0 / views);
  if (!s->in_sight && held < 1.0)
    views = (double)HBIL_CACHE_NOT_IN_SIGHT;
  *weight = finished ? -views : views;
}

/* Where a voxel looks: its middle's place in the view, in texels, its depth,
 * and how far its footprint reaches. */
typedef struct footprint {
  int x, y, step, most;
  double depth;
} footprint;

static bool find_footprint(const exact_cache *cache,
                           const exact_cache_view *view, vec3 centre,
                           double size, decisions *d, footprint *f) {
  if (!texel_of(cache, view, centre, size, d, &f->x, &f->y, &f->depth))
    return false;
  const double across =
      0.5 * view->camera.fx / view->stride * size *
      (view->orthographic ? cache->voxel_size : 1.0 / f->depth);
  if (across < HBIL_CACHE_FOOTPRINT + 0.5)
    decide_floor(d, across);
  const int reach = (int)fmin(across, HBIL_CACHE_FOOTPRINT);
  f->step = reach > 1 ? reach : 1;
  f->most = reach > 0;
  return true;
}

/* Whether the view looks through the surface that a voxel holds, and all around
 * it. */
static bool looks_through(const exact_cache *cache,
                          const exact_cache_view *view,
                          const exact_voxel *voxel, vec3 centre, double size,
                          int around, decisions *d, bool *sky) {
  const double *v = voxel->value;
  const vec3 plane = vec(v[HBIL_VOXEL_NORMAL], v[HBIL_VOXEL_NORMAL + 1],
                         v[HBIL_VOXEL_NORMAL + 2]);
  const vec3 n = vec_scale(1.0 / sqrt(vec_dot(plane, plane)), plane);
  const vec3 p = vec_add(centre, v[HBIL_VOXEL_OFFSET], n);
  int column, row;
  double depth;
  if (!texel_of(cache, view, p, size, d, &column, &row, &depth))
    return false;
  *sky = true;
  for (int y = row - around; y <= row + around; ++y)
    for (int x = column - around; x <= column + around; ++x) {
      if (x < 0 || y < 0 || x >= view->width || y >= view->height)
        continue;
      const double z = view->texel[(size_t)y * (size_t)view->width + x].depth;
      if (!(z > 0.0))
        continue;
      *sky = false;
      const vec3 off = vec_add(point_of(cache, view, x, y, z), -1.0, p);
      if (decide(d, depth + size - z) ||
          decide(d, size - fabs(vec_dot(n, off))))
        return false;
    }
  return true;
}

static void inject_voxel(const exact_cache *cache, const exact_cache_view *view,
                         const exact_place *place, decisions *d) {
  exact_voxel *voxel = exact_cache_at(cache, place);
  const vec3 centre = exact_cache_centre(place);
  const double size = ldexp(1.0, place->level);
  footprint f;
  shown s = {.surfaces = 0};
  if (!find_footprint(cache, view, centre, size, d, &f))
    return;
  for (int j = -f.most; j <= f.most; ++j)
    for (int i = -f.most; i <= f.most; ++i) {
      const int x = f.x + i * f.step, y = f.y + j * f.step;
      if (x >= 0 && y >= 0 && x < view->width && y < view->height)
        look(cache, view, x, y, centre, f.depth, size, d, &s);
    }
  if (s.surfaces > 0) {
    add_surface(voxel, view->finished, &s, d);
    voxel->state = HBIL_VOXEL_SURFACE;
  } else if (voxel->state == HBIL_VOXEL_SURFACE) {
    bool sky;
    if (looks_through(cache, view, voxel, centre, size, f.step, d, &sky))
      voxel->state = sky ? HBIL_VOXEL_SKY : HBIL_VOXEL_EMPTY;
  } else if (s.behind == s.taps) {
    if (s.sky == s.taps)
      voxel->state = HBIL_VOXEL_SKY;
    else if (voxel->state == HBIL_VOXEL_UNKNOWN)
      voxel->state = HBIL_VOXEL_EMPTY;
  }
}

void exact_cache_inject(exact_cache *cache, const exact_cache_view *view,
                        double *margin) {
  for (size_t i = 0; i < exact_cache_count(cache); ++i) {
    const exact_place place = exact_cache_place(cache, i);
    decisions d = {HUGE_VAL};
    inject_voxel(cache, view, &place, &d);
    if (margin)
      margin[i] = d.margin;
  }
}
