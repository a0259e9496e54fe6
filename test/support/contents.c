#include "test/support/contents.h"

#include <float.h>

#include "test/support/vectors.h"

/* Values of all kinds, valid ones among them. */
static const float odd_depths[] = {
    0.0f,   -0.0f, -1.0f,    NAN,   INFINITY, -INFINITY, 1e-40f, FLT_MIN,
    1e-16f, 1e-6f, 65504.0f, 1e10f, 9e14f,    1e15f,     1e20f,  FLT_MAX};
static const float odd_shares[] = {0.0f,     1.0f,  2.0f,   -1e-6f, NAN,
                                   INFINITY, 1e30f, -1e30f, 1e-30f, -0.0f};
static const float odd_light[] = {0.0f,  1e-30f,  65504.0f, 1e30f,
                                  NAN,   -1.0f,   INFINITY, -INFINITY,
                                  2e30f, FLT_MAX, 1e-40f,   -0.0f};
static const float odd_motion[] = {0.0f, NAN,      INFINITY, -INFINITY,
                                   1e9f, -FLT_MAX, 1e-40f,   FLT_MAX};
static const float odd_normals[][3] = {
    {0, 0, 0},         {NAN, 0, -1},       {INFINITY, 0, 0}, {0, 0, 1},
    {0, 0, -1e-3f},    {1e10f, 0, -1e10f}, {0, 1e-20f, 0},   {1e20f, 0, 0},
    {0, 0, -INFINITY}, {1, 0, 0},          {0, -5e-9f, 0},   {NAN, NAN, NAN}};

/* Replaces a value with some probability. */
#define SPOIL_VALUE(r, share, value, values)                                   \
  do                                                                           \
    if (random_unit(r) < (share))                                              \
      (value) = ANY_OF(r, values);                                             \
  while (0)

void spoil(setup *s, random_state *r, double share) {
  const size_t pixels = (size_t)s->config.width * s->config.height;
  for (size_t i = 0; i < pixels; ++i) {
    SPOIL_VALUE(r, share, s->input[EXACT_DEPTH][i], odd_depths);
    if (random_unit(r) < share) {
      const float *n = ANY_OF(r, odd_normals);
      for (int c = 0; c < 3; ++c)
        s->input[EXACT_NORMAL + c][i] = n[c];
    }
    for (int c = 0; c < 3; ++c) {
      SPOIL_VALUE(r, share, s->input[EXACT_ALBEDO + c][i], odd_shares);
      SPOIL_VALUE(r, share, s->input[EXACT_F0 + c][i], odd_shares);
      SPOIL_VALUE(r, share, s->input[EXACT_DIRECT + c][i], odd_light);
      SPOIL_VALUE(r, share, s->input[EXACT_EMISSION + c][i], odd_light);
    }
    for (int c = 0; c < 2; ++c)
      SPOIL_VALUE(r, share, s->input[EXACT_MOTION + c][i], odd_motion);
  }
}

const char *const content_names[CONTENTS] = {
    "a room", "depths over a factor of 1e7", "a checkerboard", "spikes",
    "noise",  "normals that face away"};

static double depth_of(content kind, int x, int y, random_state *r) {
  const double u = random_unit(r);
  switch (kind) {
  case JUMBLE:
    return pow(10.0, 7.0 * u - 3.5);
  case CHECKER:
    return (x + y) % 2 ? 1.0 : 2.0;
  case SPIKES:
    return u < 0.01 ? 1e-3 : u > 0.99 ? 1e5 : 3.0;
  default:
    return 1.0 + u;
  }
}

/* A random normal; faces: turned towards the eye. */
static void random_normal(setup *s, size_t i, bool faces, random_state *r) {
  const int width = (int)s->config.width;
  double n[3], ray[3];
  for (int c = 0; c < 3; ++c)
    n[c] = 2.0 * random_unit(r) - 1.0;
  setup_ray(s, (int)i % width, (int)i / width, ray);
  const double sign = faces && dot(n, ray) > 0.0 ? -1.0 : 1.0;
  for (int c = 0; c < 3; ++c)
    s->input[EXACT_NORMAL + c][i] = (float)(sign * n[c]);
}

void load_content(setup *s, content kind, uint32_t index, random_state *r) {
  const size_t width = s->config.width, pixels = width * s->config.height;
  const bool flat = kind == CHECKER || kind == SPIKES;
  s->frame.frame_index = index;
  for (size_t i = 0; i < pixels; ++i) {
    s->input[EXACT_DEPTH][i] =
        (float)depth_of(kind, (int)(i % width), (int)(i / width), r);
    random_normal(s, i, kind != AWAY, r);
    for (int c = 0; c < 3; ++c) {
      if (flat)
        s->input[EXACT_NORMAL + c][i] = c == 2 ? -1.0f : 0.0f;
      s->input[EXACT_ALBEDO + c][i] = (float)random_unit(r);
      s->input[EXACT_F0 + c][i] = 0.04f;
      s->input[EXACT_DIRECT + c][i] = (float)(10.0 * random_unit(r));
      s->input[EXACT_EMISSION + c][i] = random_unit(r) < 0.01 ? 5.0f : 0.0f;
    }
    for (int c = 0; c < 2; ++c)
      s->input[EXACT_MOTION + c][i] = (float)(4.0 * random_unit(r) - 2.0);
  }
}

void set_view(setup *s, const camera_view *v) {
  hbil_camera *camera = &s->frame.camera;
  setup_camera(s, v->fov);
  camera->fx *= v->pixel;
  camera->cx += v->off_x * s->config.width;
  camera->cy += v->off_y * s->config.height;
}

const camera_view views[VIEWS] = {
    {1.0, 0.0, 0.0, 1.0},    {10.0, 0.3, -0.2, 2.0}, {60.0, 0.0, 0.0, 1.0},
    {90.0, -2.0, 1.5, 0.25}, {120.0, 0.4, 0.0, 4.0}, {170.0, 0.0, 0.0, 1.0},
    {170.0, -0.4, 0.3, 0.5}};

void load_plane(setup *s, double tilt, double azimuth) {
  const int width = (int)s->config.width;
  double n[3];
  tilted_normal(tilt * PI / 180.0, azimuth, n);
  setup_plane(s, n);
  for (int i = 0; i < (int)setup_pixels(s); ++i) {
    double ray[3];
    setup_ray(s, i % width, i / width, ray);
    /* normals of surfaces seen from less than 0.06 degrees are bent to the eye
     */
    if (dot(n, ray) >= -1e-3 * sqrt(dot(ray, ray)))
      s->input[EXACT_DEPTH][i] = 0.0f;
    for (int c = 0; c < 3; ++c) {
      s->input[EXACT_ALBEDO + c][i] = 1.0f;
      s->input[EXACT_F0 + c][i] = s->input[EXACT_EMISSION + c][i] = 0.0f;
      s->input[EXACT_DIRECT + c][i] = (float)PI;
    }
  }
}
