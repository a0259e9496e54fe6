#include "world.h"

static const double pi = 3.14159265358979323846;

static vec3 grey(double value) {
  return vec(value, value, value);
}

static shape *add(world *w, shape_kind kind, vec3 centre, vec3 half,
                  vec3 albedo) {
  shape *s = &w->shapes[w->count++];
  *s = (shape){.kind = kind, .centre = centre, .half = half, .casts = true};
  s->axis[0] = vec(1, 0, 0);
  s->axis[1] = vec(0, 1, 0);
  s->axis[2] = vec(0, 0, 1);
  s->albedo[0] = s->albedo[1] = albedo;
  s->period = 1.0;
  return s;
}

static shape *add_box(world *w, vec3 centre, vec3 half, vec3 albedo) {
  return add(w, SHAPE_BOX, centre, half, albedo);
}

static shape *add_sphere(world *w, vec3 centre, double radius, vec3 albedo) {
  return add(w, SHAPE_SPHERE, centre, grey(radius), albedo);
}

/* A box that encloses the scene.  Nothing lies behind it, so it casts no
 * shadows. */
static shape *add_hull_box(world *w, vec3 centre, vec3 half, vec3 albedo) {
  shape *s = add_box(w, centre, half, albedo);
  s->casts = false;
  return s;
}

static shape *add_floor(world *w, vec3 centre, double half_x, double half_y,
                        vec3 albedo) {
  shape *s = add(w, SHAPE_RECTANGLE, centre, vec(half_x, half_y, 0.0), albedo);
  s->casts = false;
  return s;
}

static void set_pattern(shape *s, shape_pattern pattern, double period,
                        vec3 second) {
  s->pattern = pattern;
  s->period = period;
  s->albedo[1] = second;
}

/* Rotates a shape around the vertical through its centre, in radians. */
static void turn(shape *s, double angle) {
  double c = cos(angle), n = sin(angle);
  s->axis[0] = vec(c, n, 0);
  s->axis[1] = vec(-n, c, 0);
}

/* Tilts a shape around its own x axis, in radians. */
static void lean(shape *s, double angle) {
  double c = cos(angle), n = sin(angle);
  vec3 y = s->axis[1], z = s->axis[2];
  s->axis[1] = vec_add(vec_scale(y, c), vec_scale(z, n));
  s->axis[2] = vec_add(vec_scale(z, c), vec_scale(y, -n));
}

/* Sets the camera.  yaw turns it from +y to the right, pitch upwards, in
 * radians. */
static void look(world *w, vec3 eye, double yaw, double pitch) {
  w->eye = eye;
  w->forward = vec(sin(yaw) * cos(pitch), cos(yaw) * cos(pitch), sin(pitch));
  w->right = vec(cos(yaw), -sin(yaw), 0.0);
  w->down = vec_cross(w->forward, w->right);
}

/* The wall at y = 3: four blocks around a window, and the cross in it. */
static void add_back_wall(world *w) {
  const vec3 white = grey(0.75), frame = vec(0.5, 0.38, 0.25);
  add_hull_box(w, vec(0, 3.1, 0.5), vec(2.2, 0.1, 0.5), white);
  add_hull_box(w, vec(0, 3.1, 2.35), vec(2.2, 0.1, 0.25), white);
  add_hull_box(w, vec(-1.4, 3.1, 1.55), vec(0.8, 0.1, 0.55), white);
  add_hull_box(w, vec(1.6, 3.1, 1.55), vec(0.6, 0.1, 0.55), white);
  add_hull_box(w, vec(0.2, 3.1, 1.55), vec(0.02, 0.03, 0.55), frame);
  add_hull_box(w, vec(0.2, 3.1, 1.6), vec(0.8, 0.03, 0.02), frame);
}

static void add_table(world *w, vec3 place, double angle) {
  const vec3 wood = vec(0.55, 0.36, 0.2);
  const double c = cos(angle), n = sin(angle), height = 0.72;
  shape *top = add_box(w, vec_add(place, vec(0, 0, height)),
                       vec(0.55, 0.38, 0.025), wood);
  turn(top, angle);
  for (int leg = 0; leg < 4; ++leg) {
    double x = leg & 1 ? 0.48 : -0.48, y = leg & 2 ? 0.31 : -0.31;
    vec3 foot = vec_add(place, vec(c * x - n * y, n * x + c * y, 0));
    shape *s = add_box(w, vec_add(foot, vec(0, 0, 0.5 * height)),
                       vec(0.03, 0.03, 0.5 * height), wood);
    turn(s, angle);
  }
}

/* The visible rectangle, and the light that it emits downwards. */
static void add_ceiling_lamp(world *w, vec3 centre, double half_x,
                             double half_y, vec3 radiance) {
  shape *s = add_floor(w, centre, half_x, half_y, grey(0.8));
  s->emission = radiance;
  w->light = (world_light){.centre = centre,
                           .u = vec(half_x, 0, 0),
                           .v = vec(0, half_y, 0),
                           .normal = vec(0, 0, -1),
                           .radiance = radiance};
}

/* A room, 4 m wide, 6 m deep and 2.6 m high, open behind the camera. */
static void build_room(world *w, hbil_projection projection, double time) {
  const vec3 white = grey(0.75);
  shape *s = add_floor(w, vec(0, 0, 0), 2, 3, grey(0.7));
  set_pattern(s, PATTERN_CHECKER, 0.5, vec(0.35, 0.33, 0.3));
  add_floor(w, vec(0, 0, 2.6), 2, 3, white);
  add_hull_box(w, vec(-2.1, 0, 1.3), vec(0.1, 3.0, 1.3), vec(0.7, 0.08, 0.06));
  add_hull_box(w, vec(2.1, 0, 1.3), vec(0.1, 3.0, 1.3), vec(0.1, 0.55, 0.12));
  add_back_wall(w);
  add_ceiling_lamp(w, vec(0.1, 0.6, 2.58), 0.6, 0.45, vec(14.0, 12.6, 10.5));

  add_table(w, vec(0.95, 1.3, 0), 0.3);
  add_sphere(w, vec(0.8, 1.2, 0.745 + 0.17), 0.17, vec(0.8, 0.62, 0.15));
  s = add_box(w, vec(1.2, 1.42, 0.745 + 0.11), vec(0.1, 0.14, 0.11),
              vec(0.15, 0.35, 0.7));
  turn(s, -0.5);

  s = add_box(w, vec(-1.0, 1.5, 0.75), vec(0.38, 0.38, 0.75), grey(0.75));
  turn(s, 0.35);
  s = add_box(w, vec(-0.35, 0.25, 0.28), vec(0.28, 0.28, 0.28), grey(0.72));
  turn(s, -0.3);
  set_pattern(s, PATTERN_STRIPES, 0.112, vec(0.15, 0.4, 0.6));
  s = add_box(w, vec(1.45, -0.1, 0.42), vec(0.3, 0.04, 0.45), grey(0.7));
  turn(s, -1.1);
  lean(s, -0.35);
  add_sphere(w, vec(-1.35, 0.35, 0.36), 0.36, grey(0.78));
  add_box(w, vec(0.35, 2.3, 1.3), vec(0.025, 0.025, 1.3), grey(0.4));

  double angle = 0.11 * time;
  s = add_sphere(w, vec(0.45 + 0.35 * sin(angle), 0.1 - 0.3 * cos(angle), 0.2),
                 0.2, vec(0.8, 0.3, 0.1));
  turn(s, 2.0 * angle);
  set_pattern(s, PATTERN_STRIPES, pi / 6.0, grey(0.8));

  vec3 eye = vec(0.4 * sin(0.05 * time), -2.55 + 0.3 * sin(0.045 * time), 1.35);
  double yaw = 0.12 * sin(0.08 * time);
  w->fov = 1.0;
  w->size = 3.4;
  if (projection == HBIL_PROJECTION_ORTHOGRAPHIC)
    look(w, vec_add(eye, vec(-0.15, 0.3, 0.1)), yaw + 0.35, -0.3);
  else
    look(w, eye, yaw, -0.1);
}

/* The sun is a square, so far away that its light is parallel. */
static void set_sun(world *w, vec3 direction, double half_angle,
                    vec3 irradiance) {
  const double distance = 1e5, half = distance * tan(half_angle);
  vec3 d = vec_unit(direction), u = vec_unit(vec_cross(d, vec(0, 0, 1)));
  w->light = (world_light){.centre = vec_scale(d, distance),
                           .u = vec_scale(u, half),
                           .v = vec_scale(vec_cross(u, d), half),
                           .normal = vec_scale(d, -1.0)};
  w->light.radiance =
      vec_scale(irradiance, distance * distance / (4.0 * half * half));
}

static void add_gate(world *w, vec3 place) {
  const vec3 stone = vec(0.62, 0.56, 0.48);
  for (int side = -1; side <= 1; side += 2) {
    vec3 foot = vec_add(place, vec(0.9 * side, 0, 0));
    add_box(w, vec_add(foot, vec(0, 0, 1.0)), vec(0.22, 0.3, 1.0), stone);
  }
  add_box(w, vec_add(place, vec(0, 0, 2.15)), vec(1.35, 0.36, 0.15), stone);
}

static void build_sky(world *w, hbil_projection projection, double time) {
  shape *s = add_floor(w, vec(0, 30, 0), 60, 60, vec(0.5, 0.46, 0.38));
  set_pattern(s, PATTERN_CHECKER, 2.0, vec(0.4, 0.38, 0.33));
  set_sun(w, vec(-0.55, -0.5, 0.75), 0.012, vec(4.8, 4.5, 3.9));

  add_gate(w, vec(-0.3, 6.5, 0));
  s = add_box(w, vec(-2.6, 5.0, 0.6), vec(0.7, 0.7, 0.6), vec(0.7, 0.15, 0.1));
  turn(s, 0.5);
  s = add_box(w, vec(2.9, 6.2, 1.3), vec(0.15, 1.8, 1.3), grey(0.75));
  turn(s, 0.35);
  s = add_box(w, vec(1.5, 4.1, 0.3), vec(0.45, 0.45, 0.3), grey(0.7));
  turn(s, 0.8);
  set_pattern(s, PATTERN_STRIPES, 0.12, vec(0.15, 0.3, 0.6));
  add_sphere(w, vec(2.0, 5.6, 0.7), 0.7, vec(0.2, 0.6, 0.2));
  add_sphere(w, vec(-1.1, 4.2, 0.45), 0.45, grey(0.8));
  add_box(w, vec(0.55, 5.0, 1.6), vec(0.03, 0.03, 1.6), grey(0.35));
  s = add_box(w, vec(-3.6, 9.5, 1.6), vec(1.0, 0.8, 1.6), vec(0.6, 0.6, 0.65));
  turn(s, -0.3);
  s = add_box(w, vec(4.5, 13.0, 2.5), vec(1.5, 1.5, 2.5), vec(0.6, 0.5, 0.4));
  turn(s, 0.6);

  double angle = 0.1 * time;
  s = add_sphere(w, vec(0.2 + 0.6 * sin(angle), 3.4 - 0.3 * cos(angle), 0.28),
                 0.28, vec(0.85, 0.55, 0.1));
  turn(s, 2.0 * angle);
  set_pattern(s, PATTERN_STRIPES, pi / 4.0, grey(0.25));

  vec3 eye = vec(0.5 * sin(0.06 * time), -0.6 + 0.5 * sin(0.05 * time), 1.6);
  double yaw = 0.1 * sin(0.07 * time);
  w->fov = 0.9;
  w->size = 7.0;
  if (projection == HBIL_PROJECTION_ORTHOGRAPHIC)
    look(w, vec_add(eye, vec(0, 0, 0.6)), yaw + 0.1, -0.03);
  else
    look(w, eye, yaw, -0.12);
}

/* A closed room, 4 m wide, 6 m deep and 2.6 m high.  The lamp is behind the
 * camera, and leans backwards: it shines at the red wall there and at the part
 * of the floor that is nearest. */
static void build_corner(world *w, hbil_projection projection, double time) {
  const vec3 white = grey(0.75);
  shape *s = add_floor(w, vec(0, 0, 0), 2, 3, grey(0.65));
  set_pattern(s, PATTERN_CHECKER, 0.5, grey(0.45));
  add_floor(w, vec(0, 0, 2.6), 2, 3, white);
  add_hull_box(w, vec(-2.1, 0, 1.3), vec(0.1, 3.0, 1.3), white);
  add_hull_box(w, vec(2.1, 0, 1.3), vec(0.1, 3.0, 1.3), vec(0.15, 0.35, 0.7));
  add_hull_box(w, vec(0, 3.1, 1.3), vec(2.2, 0.1, 1.3), white);
  add_hull_box(w, vec(0, -3.1, 1.3), vec(2.2, 0.1, 1.3), vec(0.8, 0.2, 0.1));

  const vec3 lamp = vec(0.2, -1.3, 2.2);
  const double angle = -0.64;
  s = add_floor(w, lamp, 0.35, 0.25, grey(0.8));
  lean(s, angle);
  s->emission = vec(60.0, 55.0, 48.0);
  w->light = (world_light){.centre = lamp,
                           .u = vec_scale(s->axis[0], 0.35),
                           .v = vec_scale(s->axis[1], 0.25),
                           .normal = vec_scale(s->axis[2], -1.0),
                           .radiance = s->emission};

  add_table(w, vec(0.85, 1.7, 0), 0.25);
  add_sphere(w, vec(0.7, 1.65, 0.745 + 0.2), 0.2, vec(0.8, 0.7, 0.3));
  s = add_box(w, vec(-1.0, 1.9, 0.8), vec(0.4, 0.4, 0.8), white);
  turn(s, 0.4);
  add_sphere(w, vec(-0.55 + 0.02 * time, 0.9, 0.3), 0.3, grey(0.78));
  s = add_box(w, vec(0.75, 0.75, 0.2), vec(0.22, 0.22, 0.2), grey(0.7));
  turn(s, -0.4);

  w->fov = 1.0;
  w->size = 3.4;
  look(w, vec(0.1 * sin(0.05 * time), -0.9, 1.35), 0.06 * sin(0.08 * time),
       projection == HBIL_PROJECTION_ORTHOGRAPHIC ? -0.3 : -0.12);
}

void world_face(world *w, int face) {
  const vec3 axis[3] = {vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1)};
  w->fov = 0.5 * pi;
  w->forward = vec_scale(axis[face / 2], face % 2 ? -1.0 : 1.0);
  w->right = axis[(face / 2 + 1) % 3];
  w->down = vec_cross(w->forward, w->right);
}

void world_from_light(world *w, hbil_projection projection) {
  const world_light *l = &w->light;
  const bool sun = projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  w->forward = l->normal;
  w->right = vec_unit(l->u);
  w->down = vec_cross(w->forward, w->right);
  /* nearly all that a lamp sheds: 1 - cos^2 of 69 degrees is .87 */
  w->fov = 2.4;
  w->size = 24.0;
  w->eye = sun ? vec_sub(vec(0, 6, 1), vec_scale(l->normal, 50.0))
               : vec_add(l->centre, vec_scale(l->normal, 0.02));
}

void world_build(scene_kind kind, hbil_projection projection, uint32_t index,
                 world *out) {
  *out = (world){.count = 0};
  if (kind == SCENE_SKY)
    build_sky(out, projection, index);
  else if (kind == SCENE_CORNER)
    build_corner(out, projection, index);
  else
    build_room(out, projection, index);
}
