/*
 * Probes: rays from surfaces of the frame through the radiance cache.
 *
 * Rays are spread evenly over the hemisphere.  A ray whose end the frame shows,
 * inside the near field, counts for nothing: near light has it.
 */
#include <stdlib.h>
#include <string.h>

#include "exact/camera.h"
#include "exact/input.h"
#include "exact/passes.h"
#include "exact/cache_methods.h"
#include "exact/surface.h"

/* A probe every 8 pixels, or a multiple of that by a power of two, so that
 * there are at most 40 intervals across and down. */
static int spacing_of(const hbil_config *config) {
  const cl_uint most =
      config->width > config->height ? config->width : config->height;
  cl_uint spacing = 8;
  while (40 * spacing < most)
    spacing *= 2;
  return (int)spacing;
}

exact_status exact_probes_create(exact_probes *probes,
                                 const hbil_config *config) {
  const int spacing = spacing_of(config);
  probes->spacing = spacing;
  /* the last corners are at or behind the picture's edge */
  probes->columns = ((int)config->width - 1 + spacing - 1) / spacing + 1;
  probes->lines = 2 * (((int)config->height - 1 + spacing - 1) / spacing) + 1;
  probes->count = probes->columns * probes->lines;
  probes->probe = calloc((size_t)probes->count, sizeof *probes->probe);
  return probes->probe ? EXACT_SUCCESS : EXACT_OUT_OF_MEMORY;
}

void exact_probes_free(exact_probes *probes) {
  free(probes->probe);
  probes->probe = NULL;
}

/* --- rays --- */

static vec3 world_of_view(const exact_frame *frame, vec3 p) {
  const double *m = frame->camera.world_from_view;
  return vec_add(exact_to_world(&frame->camera, p), 1.0,
                 vec(m[3], m[7], m[11]));
}

static vec3 view_of_world(const exact_frame *frame, vec3 p) {
  const double *m = frame->camera.world_from_view;
  return exact_to_view(&frame->camera,
                       vec_add(p, -1.0, vec(m[3], m[7], m[11])));
}

/* Whether the frame shows the place, in view space, that a ray ends at.  A
 * surface of the frame is that place if it is no farther from it than
 * `tolerance`, in depth, and if the ray comes from its front. */
static bool is_shown(const exact_frame *frame, const exact_planes *split,
                     vec3 q, vec3 direction, double tolerance) {
  const hbil_camera *c = &frame->camera;
  const bool flat = exact_is_orthographic(frame->config);
  if (!flat && !(q.z > 0.0))
    return false;
  const double x = c->fx * q.x / (flat ? 1.0 : q.z) + c->cx;
  const double y = c->fy * q.y / (flat ? 1.0 : q.z) + c->cy;
  if (!(x >= 0.0 && y >= 0.0 && x < split->width && y < split->height))
    return false;
  const surface s = exact_surface_at(frame, split, (int)x, (int)y);
  return s.is && fabs(s.at.z - q.z) <= tolerance &&
         vec_dot(s.normal, direction) < 0.0;
}

bool exact_frame_shows(const exact_frame *frame, const exact_cache *cache,
                       const exact_planes *split, vec3 at, vec3 direction,
                       double tolerance) {
  return is_shown(
      frame, split, view_of_world(frame, exact_cache_to_world(cache, at)),
      exact_to_view(&frame->camera, direction), tolerance * cache->voxel_size);
}

void exact_probe_add(const exact_frame *frame, double sum[4], double share,
                     vec3 direction) {
  const vec3 d = exact_to_view(&frame->camera, direction);
  sum[0] += share;
  sum[1] += 3.0 * share * d.x;
  sum[2] += 3.0 * share * d.y;
  sum[3] += 3.0 * share * d.z;
}

/* Voxels of the finest level that has a place in cache space. */
static double size_at(const exact_cache *cache, vec3 at) {
  const double away = fmax(fabs(at.x), fmax(fabs(at.y), fabs(at.z)));
  int level = 0;
  while (level + 1 < cache->levels && !(away < ldexp(cache->voxels / 2, level)))
    ++level;
  return ldexp(1.0, level);
}

exact_stand exact_probe_stand(const exact_frame *frame,
                              const exact_cache *cache, const exact_probe *p) {
  exact_stand s = {.n = exact_to_world(&frame->camera, p->normal)};
  s.at = exact_cache_from_world(cache, world_of_view(frame, p->place));
  s.size = size_at(cache, s.at);
  return s;
}

/* What areas tell of a share of rays. */
static void add_guess(const exact_cache *cache, vec3 at, vec3 d, double share,
                      double guess[4]) {
  double light[3];
  if (!exact_cache_local_light(cache, at, d, light))
    return;
  for (int c = 0; c < 3; ++c)
    guess[c] += share * light[c];
  guess[3] += share;
}

/* `first`: of its directions, every HBIL_PROBE_TILE^2-th of a sequence. */
static void trace(const exact_frame *frame, const exact_cache *cache,
                  const exact_planes *split, int rays, int first,
                  exact_probe *p) {
  const int probes = HBIL_PROBE_TILE * HBIL_PROBE_TILE;
  const exact_stand s = exact_probe_stand(frame, cache, p);
  const vec3 origin = vec_add(s.at, (double)HBIL_CACHE_LIFT * s.size, s.n);
  const double radius = (double)frame->config->model.radius / cache->voxel_size;
  const double share = 1.0 / rays;
  int sky = 0, others = rays;
  for (int i = 0; i < rays; ++i) {
    double u, v;
    exact_ray_place(probes * i + first, probes * rays, 0x80000000u, &u, &v);
    const vec3 d = exact_about_normal(s.n, u, v);
    const exact_ray_end end =
        exact_cache_follow(cache, origin, d, (double)HBIL_CACHE_START * s.size);
    if (end.kind == EXACT_RAY_UNKNOWN) {
      exact_probe_add(frame, p->unknown, share, d);
      if (end.lost > 0.0 && frame->config->model.far_field == HBIL_FAR_FRAME)
        add_guess(cache, vec_add(origin, end.lost, d), d, share, p->guess);
      --others;
      continue;
    }
    sky += end.kind == EXACT_RAY_SKY;
    if (end.kind == EXACT_RAY_HIT && end.distance < radius &&
        exact_frame_shows(frame, cache, split, vec_add(origin, end.distance, d),
                          d, ldexp((double)HBIL_CACHE_SHOWN, end.place.level)))
      continue;
    exact_probe_add(frame, p->known, share, d);
    for (int c = 0; c < 3; ++c)
      exact_probe_add(
          frame, p->light[c],
          share * (end.kind == EXACT_RAY_HIT
                       ? exact_cache_at(cache, &end.place)->radiance[c]
                       : exact_environment(frame->config->model.far_field,
                                           frame->environment, c, d) /
                             exact_exposure(frame)),
          d);
  }
  const double unknown = 1.0 - others / (double)rays;
  const double weight =
      fmin(1.0, fmax(0.0, 2.0 - 2.0 * unknown / (double)HBIL_AREA_HOLE)) *
      fmax(0.0, 1.0 - sky / ((double)HBIL_AREA_SKY * fmax(others, 1.0)));
  for (int k = 0; k < 4; ++k)
    p->guess[k] *= weight;
}

/* --- places --- */

static int inside(int i, int size) {
  return i < 0 ? 0 : i < size ? i : size - 1;
}

/* The surface at a corner: that of the pixel there or, where it shows none, of
 * the first of those around it that does. */
static surface corner_surface(const exact_frame *frame,
                              const exact_planes *split,
                              const exact_probes *probes, int column, int row) {
  const int away = probes->spacing / 3;
  const int x = inside(column * probes->spacing, split->width);
  const int y = inside(row * probes->spacing, split->height);
  static const int order[9] = {4, 5, 6, 7, 8, 0, 1, 2, 3};
  surface s = {.is = false};
  for (int i = 0; i < 9 && !s.is; ++i)
    s = exact_surface_at(frame, split,
                         inside(x + (order[i] % 3 - 1) * away, split->width),
                         inside(y + (order[i] / 3 - 1) * away, split->height));
  return s;
}

/* How much another probe is like one: how near it is to its plane, and whether
 * it faces the same way. */
static double likeness(const exact_frame *frame, const exact_probe *p,
                       const exact_probe *other) {
  const double unit =
      exact_depth_unit(frame->config, &frame->camera, p->place.z);
  const double off = vec_dot(vec_add(other->place, -1.0, p->place), p->normal) /
                     ((double)HBIL_PROBE_TOLERANCE * unit);
  const double facing = fmax(0.0, vec_dot(p->normal, other->normal));
  return pow(facing, 8.0) / pow(1.0 + off * off, 2.0);
}

static exact_probe probe_on(const surface *s) {
  return (exact_probe){.valid = s->is, .place = s->at, .normal = s->normal};
}

/* Looks at sixteen pixels, at 1/8, 3/8, 5/8 and 7/8 of the cell each way, one
 * of the middle first.  Takes the first one whose surface no corner probe
 * stands on. */
static surface cell_surface(const exact_frame *frame, const exact_planes *split,
                            const exact_probes *probes, int column, int row) {
  static const int order[16] = {5,  10, 15, 4,  9, 14, 3,  8,
                                13, 2,  7,  12, 1, 6,  11, 0};
  surface none = {.is = false};
  exact_probe corners[4];
  if (column + 1 >= probes->columns || 2 * row + 2 >= probes->lines)
    return none;
  for (int i = 0; i < 4; ++i) {
    const surface s =
        corner_surface(frame, split, probes, column + i % 2, row + i / 2);
    corners[i] = probe_on(&s);
  }
  for (int i = 0; i < 16; ++i) {
    const int x = column * probes->spacing +
                  (2 * (order[i] % 4) + 1) * probes->spacing / 8;
    const int y =
        row * probes->spacing + (2 * (order[i] / 4) + 1) * probes->spacing / 8;
    if (x >= split->width || y >= split->height)
      continue;
    const surface s = exact_surface_at(frame, split, x, y);
    const exact_probe p = probe_on(&s);
    bool is_like_any = false;
    for (int k = 0; k < 4; ++k)
      is_like_any |= corners[k].valid && likeness(frame, corners + k, &p) >=
                                             (double)HBIL_PROBE_LEAST_LIKENESS;
    if (s.is && !is_like_any)
      return s;
  }
  return none;
}

void exact_place_probes(const exact_frame *frame, const exact_planes *split,
                        exact_probes *probes) {
  for (int i = 0; i < probes->count; ++i) {
    const int column = i % probes->columns, line = i / probes->columns;
    const surface s =
        line % 2 ? cell_surface(frame, split, probes, column, line / 2)
                 : corner_surface(frame, split, probes, column, line / 2);
    memset(probes->probe + i, 0, sizeof *probes->probe);
    if (s.is)
      probes->probe[i] = probe_on(&s);
  }
}

/* Where few of the corner probes around stand on the same surface, there are
 * more rays.  For a probe inside a cell, these are the nine about the cell's
 * first corner. */
static int rays_of_probe(const exact_frame *frame, const exact_planes *split,
                         const exact_probes *probes, int number) {
  const exact_probe *p = probes->probe + number;
  const int column = number % probes->columns;
  const int line = number / probes->columns;
  int alike = 0;
  for (int i = 0; i < 9; ++i) {
    const int x = column + i % 3 - 1, y = line / 2 + i / 3 - 1;
    const bool itself = i == 4 && line % 2 == 0;
    if (itself || x < 0 || y < 0 || x >= probes->columns ||
        2 * y >= probes->lines)
      continue;
    const surface s = exact_surface_at(
        frame, split, inside(x * probes->spacing, split->width),
        inside(y * probes->spacing, split->height));
    const exact_probe other = probe_on(&s);
    alike += s.is && likeness(frame, p, &other) > 0.5;
  }
  return HBIL_PROBE_RAYS * (alike < 3 ? 4 : alike < 5 ? 2 : 1);
}

void exact_make_probes(const exact_frame *frame, const exact_cache *cache,
                       const exact_planes *split, exact_probes *probes) {
  exact_place_probes(frame, split, probes);
  for (int i = 0; i < probes->count; ++i) {
    const int column = i % probes->columns, row = i / probes->columns / 2;
    if (probes->probe[i].valid)
      trace(frame, cache, split, rays_of_probe(frame, split, probes, i),
            column % HBIL_PROBE_TILE + row % HBIL_PROBE_TILE * HBIL_PROBE_TILE,
            probes->probe + i);
  }
}

/* --- the filter --- */

static void add_function(double sum[4], double weight, const double f[4]) {
  for (int i = 0; i < 4; ++i)
    sum[i] += weight * f[i];
}

static void filter_probe(const exact_frame *frame, const exact_probes *probes,
                         int number, exact_probe *out) {
  const exact_probe *p = probes->probe + number;
  const int line = number / probes->columns;
  const double across = number % probes->columns + (line % 2 ? 0.5 : 0.0);
  double total = 0.0;
  *out =
      (exact_probe){.valid = p->valid, .place = p->place, .normal = p->normal};
  if (!p->valid)
    return;
  /* the sum of the weights first, then shares of it */
  for (int pass = 0; pass < 2; ++pass)
    for (int i = 0; i < probes->count; ++i) {
      const exact_probe *other = probes->probe + i;
      const double tent =
          exact_probe_tent(probes, i, across, line / 2.0, HBIL_PROBE_TILE);
      if (!other->valid || !(tent > 0.0))
        continue;
      const double weight =
          tent * (other == p ? 1.0 : likeness(frame, p, other));
      if (pass == 0) {
        total += weight;
        continue;
      }
      add_function(out->known, weight / total, other->known);
      add_function(out->unknown, weight / total, other->unknown);
      add_function(out->guess, weight / total, other->guess);
      for (int c = 0; c < 3; ++c)
        add_function(out->light[c], weight / total, other->light[c]);
    }
}

void exact_filter_probes(const exact_frame *frame, const exact_probes *probes,
                         exact_probes *filtered) {
  for (int i = 0; i < probes->count; ++i)
    filter_probe(frame, probes, i, filtered->probe + i);
}

/* --- the history --- */

/* From one view to another; w: 1 for points, 0 for directions. */
static vec3 between(const hbil_camera *from, const hbil_camera *to, vec3 p,
                    double w) {
  const double *f = from->world_from_view, *t = to->world_from_view;
  const vec3 world = exact_to_world(from, p);
  return exact_to_view(to, vec(world.x + w * (f[3] - t[3]),
                               world.y + w * (f[7] - t[7]),
                               world.z + w * (f[11] - t[11])));
}

static void scale_probe(exact_probe *p, double factor) {
  p->frames *= factor;
  for (int k = 0; k < 4; ++k) {
    p->known[k] *= factor;
    p->unknown[k] *= factor;
    p->guess[k] *= factor;
    for (int c = 0; c < 3; ++c)
      p->light[c][k] *= factor;
  }
}

static void add_probe(exact_probe *sum, double weight, const exact_probe *p) {
  sum->frames += weight * p->frames;
  add_function(sum->known, weight, p->known);
  add_function(sum->unknown, weight, p->unknown);
  add_function(sum->guess, weight, p->guess);
  for (int c = 0; c < 3; ++c)
    add_function(sum->light[c], weight, p->light[c]);
}

/* The mean of the last frame's probes around a place that stand on its surface;
 * p: place and normal in that frame's view.  Of 0 frames: there are none. */
static exact_probe find_past(const exact_frame *last, const exact_probes *past,
                             const exact_probe *p) {
  const hbil_camera *camera = &last->camera;
  exact_probe sum = {.valid = false};
  const double z = exact_is_orthographic(last->config) ? 1.0 : p->place.z;
  if (!(z > 0.0))
    return sum;
  /* pixels to 1/256, as the device has them, so that what rests stays in place
   */
  const double u =
      rint(256.0 * (camera->fx * p->place.x / z + camera->cx - 0.5)) / 256.0 /
      past->spacing;
  const double v =
      rint(256.0 * (camera->fy * p->place.y / z + camera->cy - 0.5)) / 256.0 /
      past->spacing;
  double total = 0.0;
  for (int i = 0; i < past->count; ++i) {
    const exact_probe *other = past->probe + i;
    const double corner = exact_probe_tent(past, i, u, v, 1.0);
    if (!(corner > 0.0) || !other->valid)
      continue;
    const double weight = corner * likeness(last, p, other);
    total += weight;
    add_probe(&sum, weight, other);
  }
  scale_probe(&sum,
              total >= (double)HBIL_PROBE_LEAST_LIKENESS ? 1.0 / total : 0.0);
  return sum;
}

static void turn_function(const hbil_camera *from, const hbil_camera *to,
                          double f[4]) {
  const vec3 d = between(from, to, vec(f[1], f[2], f[3]), 0.0);
  f[1] = d.x;
  f[2] = d.y;
  f[3] = d.z;
}

/* The largest difference of a share, or of all light over the brighter one. */
static double change(const exact_probe *a, const exact_probe *b) {
  double light[2] = {0.0, 0.0};
  for (int c = 0; c < 3; ++c) {
    light[0] += a->light[c][0];
    light[1] += b->light[c][0];
  }
  const double brighter = fmax(light[0], light[1]);
  const double shares = fmax(fabs(a->known[0] - b->known[0]),
                             fabs(a->unknown[0] - b->unknown[0]));
  return brighter > 0.0 ? fmax(shares, fabs(light[0] - light[1]) / brighter)
                        : shares;
}

void exact_follow_probes(const exact_frame *frame, const hbil_camera *before,
                         const exact_probes *filtered, const exact_probes *past,
                         exact_probes *followed) {
  exact_frame last = *frame;
  last.camera = *before;
  for (int i = 0; i < filtered->count; ++i) {
    const exact_probe now = filtered->probe[i];
    exact_probe *out = followed->probe + i, there = now;
    *out = now;
    out->frames = 1.0;
    if (!now.valid)
      continue;
    there.place = between(&frame->camera, before, now.place, 1.0);
    there.normal = between(&frame->camera, before, now.normal, 0.0);
    exact_probe then = find_past(&last, past, &there);
    turn_function(before, &frame->camera, then.known);
    turn_function(before, &frame->camera, then.unknown);
    for (int c = 0; c < 3; ++c)
      turn_function(before, &frame->camera, then.light[c]);
    if (!(then.frames > 0.0) || change(&now, &then) > (double)HBIL_PROBE_CHANGE)
      continue;
    const double frames = fmin(then.frames + 1.0, HBIL_PROBE_FRAMES);
    then.frames = 0.0;
    scale_probe(out, 1.0 / frames);
    add_probe(out, (frames - 1.0) / frames, &then);
    out->frames = frames;
  }
}
