/* A ray caster and its matrices.  Like test_adopter, this file stands for a
 * program outside of the tree: of hbil it has the public headers alone. */
#include "test/system/adopter_scene.h"

#include <math.h>
#include <string.h>

/* The picture is off-centre, as one that is jittered. */
static const double focal = 130;                 /* pixels */
static const double centre_x = WIDTH / 2 + 0.25; /* pixels */
static const double centre_y = HEIGHT / 2 - 0.375;

/* World units. */
static const double back_wall_z = -3, red_wall_x = -1.8, wall_height = 2.2;
static const double ball_centre[3] = {0.6, 0.8, -1}, ball_radius = 0.8;

/* 0.96 and 0.28 are cosine and sine of an angle. */
const pose looks_down = {{0.3, 2, 4},
                         {{1, 0, 0}, {0, 0.96, -0.28}, {0, -0.28, -0.96}}};
/* Low enough for a cosine of 0.2 between much of the floor and the eye. */
const pose is_level = {{0.3, 1.2, 4}, {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}};

const convention opengl = {-1,
                           1,
                           {0, NEAR_PLANE},
                           true,
                           HBIL_MATRIX_COLUMN_MAJOR |
                               HBIL_MATRIX_REVERSED_DEPTH};

/* --- rays --- */

enum { FLOOR, BACK_WALL, RED_WALL, BALL, SURFACES, SKY = SURFACES };

typedef struct hit {
  int surface;
  double distance; /* along the camera's axis; infinite at the sky */
  double place[3]; /* in the world; not set at the sky */
} hit;

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The direction of a pixel, 1 long along the camera's axis. */
static void pixel_ray(const pose *from, int pixel, double ray[3]) {
  const double right = (pixel % WIDTH + 0.5 - centre_x) / focal;
  const double up = (centre_y - pixel / WIDTH - 0.5) / focal;
  for (int i = 0; i < 3; ++i)
    ray[i] =
        from->axes[2][i] + right * from->axes[0][i] + up * from->axes[1][i];
}

/* NaN where the ray passes by. */
static double ball_distance(const double eye[3], const double ray[3]) {
  double to_eye[3];
  for (int i = 0; i < 3; ++i)
    to_eye[i] = eye[i] - ball_centre[i];
  const double a = dot(ray, ray), b = dot(to_eye, ray);
  const double c = dot(to_eye, to_eye) - ball_radius * ball_radius;
  return -(b + sqrt(b * b - a * c)) / a;
}

static hit cast(const pose *from, int pixel) {
  const double *eye = from->eye;
  hit nearest = {SKY, INFINITY, {0}};
  double ray[3], distance[SURFACES];
  pixel_ray(from, pixel, ray);
  distance[FLOOR] = -eye[1] / ray[1];
  distance[BACK_WALL] = (back_wall_z - eye[2]) / ray[2];
  distance[RED_WALL] = (red_wall_x - eye[0]) / ray[0];
  distance[BALL] = ball_distance(eye, ray);
  for (int i = 0; i < SURFACES; ++i) {
    const bool in_front = distance[i] > 0 && distance[i] < nearest.distance;
    if (in_front && eye[1] + distance[i] * ray[1] < wall_height) {
      nearest.surface = i;
      nearest.distance = distance[i];
    }
  }
  for (int i = 0; i < 3 && nearest.surface != SKY; ++i)
    nearest.place[i] = eye[i] + nearest.distance * ray[i];
  return nearest;
}

/* --- pixels --- */

static double normal_of(const hit *at, int axis) {
  static const int across[] = {[FLOOR] = 1, [BACK_WALL] = 2, [RED_WALL] = 0};
  if (at->surface == SKY)
    return 0;
  if (at->surface == BALL)
    return (at->place[axis] - ball_centre[axis]) / ball_radius;
  return axis == across[at->surface];
}

static double albedo_of(const hit *at, int channel) {
  static const double colours[][3] = {[FLOOR] = {0.7, 0.7, 0.7},
                                      [BACK_WALL] = {0.6, 0.6, 0.8},
                                      [RED_WALL] = {0.9, 0.3, 0.2},
                                      [BALL] = {0.5, 0.8, 0.5},
                                      [SKY] = {0, 0, 0}};
  return colours[at->surface][channel];
}

/* A reddish lamp at the red wall, and a dim light everywhere. */
static double direct_of(const hit *at, int channel) {
  return at->surface == RED_WALL ? 20.0 / (channel + 1) : 0.2;
}

/* HBIL_RGB9E5_FLOAT: a channel is mantissa 2^(exponent - 24), and the greatest
 * mantissa is below 2^9.  So the exponent is 20 for up to 20 (2^4 .. 2^5), and
 * 13 for 0.2 (2^-3 .. 2^-2). */
static cl_uint rgb9e5_of(const hit *at) {
  const int exponent = at->surface == RED_WALL ? 20 : 13;
  cl_uint word = (cl_uint)exponent << 27;
  for (int i = 0; i < 3; ++i)
    word |= (cl_uint)lround(ldexp(direct_of(at, i), 24 - exponent)) << 9 * i;
  return word;
}

static void draw_pixel(scene *out, int pixel, const hit *at) {
  const bool sky = at->surface == SKY;
  out->sky_pixels += sky;
  out->depth[pixel][0] = (float)(NEAR_PLANE / at->distance);
  out->direct_rgb9e5[pixel] = rgb9e5_of(at);
  for (int i = 0; i < 3; ++i) {
    const double normal = normal_of(at, i), albedo = albedo_of(at, i);
    out->normal[pixel][i] = (float)normal;
    out->albedo[pixel][i] = (float)albedo;
    out->direct[pixel][i] = (float)direct_of(at, i);
    out->sky_light[pixel][i] = sky ? 1.5f : 0.0f;
    out->wall_light[pixel][i] = at->surface == RED_WALL ? 4.0f : 0.0f;
    out->normal_rgb10[pixel] |= (cl_uint)lround(511.5 + 511.5 * normal)
                                << 10 * i;
    out->albedo_rgb8[pixel] |= (cl_uint)lround(255 * albedo) << 8 * i;
  }
}

void scene_draw(scene *out, const pose *from) {
  memset(out, 0, sizeof *out);
  for (int pixel = 0; pixel < PIXELS; ++pixel) {
    const hit at = cast(from, pixel);
    draw_pixel(out, pixel, &at);
  }
}

/* --- cameras --- */

/* Row-major. */
static void make_projection(const convention *with, double out[16]) {
  const double w = with->along, up = with->up;
  memset(out, 0, 16 * sizeof *out);
  out[0] = 2 * focal / WIDTH;
  out[2] = w * (2 * centre_x / WIDTH - 1);
  out[5] = up * 2 * focal / HEIGHT;
  out[6] = up * w * (1 - 2 * centre_y / HEIGHT);
  out[10] = w * with->depth[0];
  out[11] = with->depth[1];
  out[14] = w;
}

/* Row-major.  World to view: the axes are the rows of the rotation. */
static void make_view(const convention *with, const pose *from,
                      double out[16]) {
  memset(out, 0, 16 * sizeof *out);
  for (int i = 0; i < 3; ++i) {
    const double sign = i == 2 ? with->along : 1;
    for (int j = 0; j < 3; ++j)
      out[4 * i + j] = sign * from->axes[i][j];
    out[4 * i + 3] = -sign * dot(from->axes[i], from->eye);
  }
  out[15] = 1;
}

static void transpose(double m[16]) {
  double rows[16];
  memcpy(rows, m, sizeof rows);
  for (int i = 0; i < 16; ++i)
    m[i] = rows[i % 4 * 4 + i / 4];
}

hbil_status scene_camera(hbil_frame *frame, const hbil_config *config,
                         const pose *from, const convention *with) {
  double projection[16], view[16];
  make_projection(with, projection);
  make_view(with, from, view);
  if (with->by_columns) {
    transpose(projection);
    transpose(view);
  }
  return hbil_camera_from_matrices(&frame->camera, frame->hardware_depth,
                                   config, projection, view, with->flags);
}

void scene_camera_from_pose(hbil_camera *camera, const pose *from) {
  double camera_to_world[16] = {[15] = 1};
  for (int i = 0; i < 3; ++i) {
    camera_to_world[4 * i] = from->axes[0][i];
    camera_to_world[4 * i + 1] = from->axes[1][i];
    camera_to_world[4 * i + 2] = -from->axes[2][i];
    camera_to_world[4 * i + 3] = from->eye[i];
  }
  hbil_camera_from_opengl(camera, camera_to_world, focal, focal, centre_x,
                          centre_y);
}

double scene_camera_distance(const hbil_camera *a, const hbil_camera *b) {
  double most = fmax(fabs(a->fx - b->fx), fabs(a->fy - b->fy));
  most = fmax(most, fmax(fabs(a->cx - b->cx), fabs(a->cy - b->cy)));
  for (int i = 0; i < 16; ++i)
    most = fmax(most, fabs(a->world_from_view[i] - b->world_from_view[i]));
  return most;
}
