#include "scene.h"

#include <stdlib.h>
#include <string.h>

#include "shape.h"
#include "world.h"

/* The number of planes of a scene_frame. */
enum { PLANES = 18 };

/* Shadow rays go to these points of the light.  They form a Fibonacci grid,
 * whose projections on the light's sides are equally spaced.  So a shadow edge
 * that is parallel to a side has as many shades as there are points. */
enum { LIGHT_POINTS = 89, LIGHT_STEP = 55 };

typedef struct view {
  world now, before; /* this frame and the last one */
  bool parallel;
  hbil_camera camera;
  vec3 light_points[LIGHT_POINTS];
  double light_radius, light_area; /* m, m2 */
  double bounds[WORLD_SHAPES];
} view;

/* The caller's choice of projection and extent, as in scene.h. */
typedef struct lens {
  hbil_projection projection;
  double fov, size; /* 0: the scene's default */
  int face;         /* 1 + that of scene_render_face(); 0: none */
  bool at_light;    /* seen by scene_render_from_light() */
} lens;

static double focal_length(const world *w, const lens *l, uint32_t width,
                           uint32_t height) {
  return l->projection == HBIL_PROJECTION_ORTHOGRAPHIC
             ? width / (l->size > 0.0 ? l->size : w->size)
             : 0.5 * height / tan(0.5 * (l->fov > 0.0 ? l->fov : w->fov));
}

static hbil_camera camera_of(const world *w, uint32_t width, uint32_t height,
                             const lens *l) {
  hbil_camera c = {.cx = 0.5 * width, .cy = 0.5 * height};
  c.fx = c.fy = focal_length(w, l, width, height);
  const vec3 columns[4] = {w->right, w->down, w->forward, w->eye};
  for (int k = 0; k < 4; ++k) {
    c.world_from_view[k] = columns[k].x;
    c.world_from_view[4 + k] = columns[k].y;
    c.world_from_view[8 + k] = columns[k].z;
  }
  c.world_from_view[15] = 1.0;
  return c;
}

static void view_init(view *v, scene_kind kind, uint32_t width, uint32_t height,
                      const lens *through, uint32_t index) {
  world_build(kind, through->projection, index, &v->now);
  const bool moves = index > 0 && !through->face && !through->at_light;
  world_build(kind, through->projection, moves ? index - 1 : index, &v->before);
  if (through->face) {
    world_face(&v->now, through->face - 1);
    world_face(&v->before, through->face - 1);
  }
  if (through->at_light) {
    world_from_light(&v->now, through->projection);
    world_from_light(&v->before, through->projection);
  }
  v->camera = camera_of(&v->now, width, height, through);
  v->parallel = through->projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  const world_light *l = &v->now.light;
  for (int i = 0; i < LIGHT_POINTS; ++i) {
    double a = (2.0 * i + 1.0) / LIGHT_POINTS - 1.0;
    double b = (2.0 * (i * LIGHT_STEP % LIGHT_POINTS) + 1.0) / LIGHT_POINTS;
    v->light_points[i] = vec_add(
        l->centre, vec_add(vec_scale(l->u, a), vec_scale(l->v, b - 1.0)));
  }
  double u2 = vec_dot(l->u, l->u), v2 = vec_dot(l->v, l->v);
  v->light_radius = sqrt(u2 + v2);
  v->light_area = 4.0 * sqrt(u2 * v2);
  for (int i = 0; i < v->now.count; ++i)
    v->bounds[i] = shape_bound(&v->now.shapes[i]);
}

/*
 * Whether a shape may be between the point and some point of the light.  The
 * rays from the point to the light fill a cone around the axis between both: at
 * the fraction s of the way, its radius is s * light_radius.  The shape's
 * bounding sphere reaches at most to s = (along + bound) / (length -
 * light_radius), so it is compared with the radius there.
 */
static bool may_shadow(const view *v, int number, vec3 point) {
  vec3 axis = vec_sub(v->now.light.centre, point);
  vec3 c = vec_sub(v->now.shapes[number].centre, point);
  double length = sqrt(vec_dot(axis, axis)), bound = v->bounds[number];
  double along = vec_dot(c, axis) / length, s = 1.0;
  if (along + bound < 0.0 && length > v->light_radius)
    return false;
  if (along + bound < length - v->light_radius)
    s = (along + bound) / (length - v->light_radius);
  double clear = bound + s * v->light_radius;
  double across2 = vec_dot(c, c) - along * along;
  return across2 <= clear * clear;
}

static bool in_shadow(const view *v, const int *near, int count, vec3 point,
                      vec3 to_light) {
  for (int i = 0; i < count; ++i) {
    double t = 1.0;
    if (shape_hit(&v->now.shapes[near[i]], point, to_light, &t, NULL))
      return true;
  }
  return false;
}

/* The light's irradiance at a surface point. */
static vec3 direct_light(const view *v, vec3 point, vec3 normal) {
  const world_light *l = &v->now.light;
  /* above the surface, so that the shape does not shadow itself */
  point = vec_add(point, vec_scale(normal, 1e-7));
  int near[WORLD_SHAPES], count = 0;
  for (int i = 0; i < v->now.count; ++i)
    if (v->now.shapes[i].casts && may_shadow(v, i, point))
      near[count++] = i;
  double sum = 0.0;
  for (int i = 0; i < LIGHT_POINTS; ++i) {
    vec3 d = vec_sub(v->light_points[i], point);
    double receive = vec_dot(normal, d), send = -vec_dot(l->normal, d);
    if (receive <= 0.0 || send <= 0.0 || in_shadow(v, near, count, point, d))
      continue;
    double d2 = vec_dot(d, d);
    sum += receive * send / (d2 * d2);
  }
  return vec_scale(l->radiance, sum * v->light_area / LIGHT_POINTS);
}

/*
 * The point's pixel position in the last frame, minus (x, y).  A point that was
 * behind the last camera gets a motion that leads out of any picture.
 */
static void motion_of(const view *v, vec3 before, double x, double y,
                      double motion[2]) {
  const world *w = &v->before;
  vec3 d = vec_sub(before, w->eye);
  double z = vec_dot(w->forward, d);
  if (z <= 0.0) {
    motion[0] = motion[1] = -1e6;
    return;
  }
  if (v->parallel)
    z = 1.0;
  motion[0] = v->camera.cx + v->camera.fx * vec_dot(w->right, d) / z - x;
  motion[1] = v->camera.cy + v->camera.fy * vec_dot(w->down, d) / z - y;
}

static void store(float *const planes[3], size_t pixel, vec3 value) {
  planes[0][pixel] = (float)value.x;
  planes[1][pixel] = (float)value.y;
  planes[2][pixel] = (float)value.z;
}

static void shade(const view *v, int number, vec3 point, vec3 normal, double x,
                  double y, size_t pixel, scene_frame *out) {
  const shape *s = &v->now.shapes[number];
  vec3 local = shape_local(s, point);
  double motion[2] = {0.0, 0.0};
  store(out->normal, pixel, normal);
  store(out->position, pixel, point);
  store(out->albedo, pixel, shape_albedo(s, local));
  store(out->emission, pixel, s->emission);
  if (vec_dot(s->emission, s->emission) == 0.0)
    store(out->direct, pixel, direct_light(v, point, normal));
  motion_of(v, shape_world(&v->before.shapes[number], local), x, y, motion);
  out->motion[0][pixel] = (float)motion[0];
  out->motion[1][pixel] = (float)motion[1];
}

static void render_pixel(const view *v, uint32_t column, uint32_t row,
                         scene_frame *out) {
  double x = column + 0.5, y = row + 0.5;
  size_t pixel = (size_t)row * out->width + column;
  vec3 aside =
      vec_add(vec_scale(v->now.right, (x - v->camera.cx) / v->camera.fx),
              vec_scale(v->now.down, (y - v->camera.cy) / v->camera.fy));
  vec3 from = v->now.eye, ray = v->now.forward;
  if (v->parallel)
    from = vec_add(from, aside);
  else /* length 1 along the camera's axis: t is planar depth */
    ray = vec_add(ray, aside);
  double t = HUGE_VAL;
  int number = -1;
  vec3 normal;
  for (int i = 0; i < v->now.count; ++i)
    if (shape_hit(&v->now.shapes[i], from, ray, &t, &normal))
      number = i;
  if (number < 0)
    return;
  if (vec_dot(normal, ray) > 0.0)
    normal = vec_scale(normal, -1.0);
  vec3 point = vec_add(from, vec_scale(ray, t));
  out->depth[pixel] = (float)t;
  shade(v, number, point, normal, x, y, pixel, out);
}

static int allocate(uint32_t width, uint32_t height, scene_frame *out) {
  *out = (scene_frame){.width = 0};
  size_t pixels = (size_t)width * height;
  if (height != 0 && pixels / height != width)
    return -1;
  float *p = calloc(pixels > 0 ? pixels : 1, PLANES * sizeof *p);
  if (p == NULL)
    return -1;
  out->width = width;
  out->height = height;
  out->storage = out->depth = p;
  float **const triples[] = {out->normal, out->position, out->albedo,
                             out->direct, out->emission};
  for (int i = 0; i < 15; ++i)
    triples[i / 3][i % 3] = p += pixels;
  out->motion[0] = p += pixels;
  out->motion[1] = p + pixels;
  return 0;
}

static int render(scene_kind kind, uint32_t width, uint32_t height,
                  const lens *l, uint32_t index, scene_frame *out) {
  if (allocate(width, height, out) != 0)
    return -1;
  view v;
  view_init(&v, kind, width, height, l, index);
  out->projection = l->projection;
  out->camera = v.camera;
  for (uint32_t row = 0; row < height; ++row)
    for (uint32_t column = 0; column < width; ++column)
      render_pixel(&v, column, row, out);
  return 0;
}

int scene_render(scene_kind kind, uint32_t width, uint32_t height, double fov,
                 uint32_t index, scene_frame *out) {
  const lens l = {.projection = HBIL_PROJECTION_PERSPECTIVE, .fov = fov};
  return render(kind, width, height, &l, index, out);
}

int scene_render_orthographic(scene_kind kind, uint32_t width, uint32_t height,
                              double size, uint32_t index, scene_frame *out) {
  const lens l = {.projection = HBIL_PROJECTION_ORTHOGRAPHIC, .size = size};
  return render(kind, width, height, &l, index, out);
}

int scene_render_face(scene_kind kind, uint32_t size, int face, uint32_t index,
                      scene_frame *out) {
  const lens l = {.projection = HBIL_PROJECTION_PERSPECTIVE, .face = face + 1};
  return render(kind, size, size, &l, index, out);
}

int scene_render_from_light(scene_kind kind, uint32_t size, uint32_t index,
                            scene_frame *out) {
  const lens l = {.projection = kind == SCENE_SKY ? HBIL_PROJECTION_ORTHOGRAPHIC
                                                  : HBIL_PROJECTION_PERSPECTIVE,
                  .at_light = true};
  return render(kind, size, size, &l, index, out);
}

void scene_free(scene_frame *frame) {
  if (frame == NULL)
    return;
  free(frame->storage);
  memset(frame, 0, sizeof *frame);
}

void scene_sky(const double direction[3], float rgb[3]) {
  static const double zenith[3] = {0.12, 0.22, 0.45};
  static const double horizon[3] = {0.42, 0.47, 0.55};
  static const double ground[3] = {0.30, 0.27, 0.22};
  vec3 d = vec_unit(vec(direction[0], direction[1], direction[2]));
  /* pale near the horizon only, like haze that hides the ground's edge */
  double t = d.z > 0.0 ? sqrt(d.z) : fmin(1.0, -8.0 * d.z);
  const double *far = d.z > 0.0 ? zenith : ground;
  for (int k = 0; k < 3; ++k)
    rgb[k] = (float)(horizon[k] + t * (far[k] - horizon[k]));
}
