/*
 * A plane in fewer bits changes the results by no more than its rounding
 * explains.  HBIL_TEST_VERBOSE=1 prints the table: format, error, bound.
 */
#include <stdio.h>

#include "test/support/stages.h"

#define WIDTH 96
#define HEIGHT 54
#define NEAR_PLANE 0.1
#define FAR_PLANE 1000.0

typedef enum depth_form { PLANAR, NEAR_TO_FAR, REVERSED } depth_form;

typedef struct form {
  const char *name;
  plane_id id;
  hbil_component component;
  hbil_normal_encoding encoding;
  depth_form depth;
  double turn; /* of normals at most, root mean square, degrees */
} form;

#define MAP HBIL_NORMAL_OCTAHEDRAL
/* turn: half a step in each component, which in octahedral maps is up to twice
 * as much of an angle. */
static const form forms[] = {
    {"normal FLOAT16", PLANE_NORMAL, HBIL_FLOAT16, 0, 0, 0.02},
    {"normal UNORM8", PLANE_NORMAL, HBIL_UNORM8, 0, 0, 0.4},
    {"normal UNORM16", PLANE_NORMAL, HBIL_UNORM16, 0, 0, 0.002},
    {"normal SNORM8", PLANE_NORMAL, HBIL_SNORM8, 0, 0, 0.2},
    {"normal SNORM16", PLANE_NORMAL, HBIL_SNORM16, 0, 0, 0.001},
    {"normal RGB10A2", PLANE_NORMAL, HBIL_RGB10A2_UNORM, 0, 0, 0.1},
    {"octahedral FLOAT32", PLANE_NORMAL, HBIL_FLOAT32, MAP, 0, 2e-05},
    {"octahedral FLOAT16", PLANE_NORMAL, HBIL_FLOAT16, MAP, 0, 0.04},
    {"octahedral UNORM8", PLANE_NORMAL, HBIL_UNORM8, MAP, 0, 0.5},
    {"octahedral UNORM16", PLANE_NORMAL, HBIL_UNORM16, MAP, 0, 0.002},
    {"octahedral SNORM8", PLANE_NORMAL, HBIL_SNORM8, MAP, 0, 0.5},
    {"octahedral SNORM16", PLANE_NORMAL, HBIL_SNORM16, MAP, 0, 0.002},
    {"depth FLOAT16", PLANE_DEPTH, HBIL_FLOAT16, 0, PLANAR, 0},
    {"0..1 FLOAT32", PLANE_DEPTH, HBIL_FLOAT32, 0, NEAR_TO_FAR, 0},
    {"0..1 UNORM24", PLANE_DEPTH, HBIL_UNORM24, 0, NEAR_TO_FAR, 0},
    {"0..1 UNORM16", PLANE_DEPTH, HBIL_UNORM16, 0, NEAR_TO_FAR, 0},
    {"1..0 FLOAT32", PLANE_DEPTH, HBIL_FLOAT32, 0, REVERSED, 0},
    {"1..0 FLOAT16", PLANE_DEPTH, HBIL_FLOAT16, 0, REVERSED, 0},
    {"1..0 UNORM24", PLANE_DEPTH, HBIL_UNORM24, 0, REVERSED, 0},
    {"albedo UNORM8", PLANE_ALBEDO, HBIL_UNORM8, 0, 0, 0},
    {"albedo SRGB8", PLANE_ALBEDO, HBIL_SRGB8, 0, 0, 0},
    {"albedo UNORM16", PLANE_ALBEDO, HBIL_UNORM16, 0, 0, 0},
    {"albedo RGB10A2", PLANE_ALBEDO, HBIL_RGB10A2_UNORM, 0, 0, 0},
    {"direct FLOAT16", PLANE_DIRECT, HBIL_FLOAT16, 0, 0, 0},
    {"direct R11G11B10", PLANE_DIRECT, HBIL_R11G11B10_FLOAT, 0, 0, 0},
    {"direct RGB9E5", PLANE_DIRECT, HBIL_RGB9E5_FLOAT, 0, 0, 0},
};
enum { FORMS = sizeof(forms) / sizeof(*forms) };

/* What rounding has changed of the inputs. */
typedef struct change {
  double turn;     /* of normals: root mean square, radians */
  double depth;    /* largest, relative */
  double radiance; /* largest, of what pixels send */
} change;

/* --- inputs --------------------------------------------------------------- */

/* Light of all samples, as it is gathered: so the normals of a frame matter to
 * their own pixels alone, and what pixels send adds up. */
static void prepare(setup *s, const form *f) {
  const double n = NEAR_PLANE, range = FAR_PLANE - NEAR_PLANE;
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s->config.sampling.slices = 4;
  s->config.model.extrapolate = CL_FALSE;
  s->config.model.gather_emission = CL_FALSE;
  s->config.model.facing_fade[0] = s->config.model.facing_fade[1] = -1.0f;
  if (!f)
    return;
  *plane_format(&s->config, f->id) = (hbil_plane_format){f->component, 0};
  /* Single pixels compile fastest.  Vectors of these are read in test_formats,
   * of colours here. */
  if (f->id == PLANE_NORMAL || f->id == PLANE_DEPTH)
    s->config.execution.vector_width = 1;
  s->config.inputs.normal_encoding = f->encoding;
  if (f->depth == PLANAR)
    return;
  s->config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
  s->frame.hardware_depth[0] = (f->depth == REVERSED ? -n : FAR_PLANE) / range;
  s->frame.hardware_depth[1] =
      (f->depth == REVERSED ? n : -n) * FAR_PLANE / range;
}

static double radiance_at(const setup *s, int channel, size_t i) {
  return (double)s->input[EXACT_ALBEDO + channel][i] / PI *
         (double)s->input[EXACT_DIRECT + channel][i];
}

static double turn_between(const setup *a, const setup *b, size_t i) {
  double square = 0.0, lengths[2] = {0.0, 0.0};
  for (int c = 0; c < 3; ++c) {
    lengths[0] += pow((double)a->input[EXACT_NORMAL + c][i], 2.0);
    lengths[1] += pow((double)b->input[EXACT_NORMAL + c][i], 2.0);
  }
  for (int c = 0; c < 3; ++c)
    square += pow((double)a->input[EXACT_NORMAL + c][i] / sqrt(lengths[0]) -
                      (double)b->input[EXACT_NORMAL + c][i] / sqrt(lengths[1]),
                  2.0);
  return sqrt(square);
}

static change change_between(const setup *a, const setup *b) {
  change all = {0.0, 0.0, 0.0};
  for (size_t i = 0; i < setup_pixels(a); ++i) {
    const double depth = (double)a->input[EXACT_DEPTH][i];
    if (!(depth > 0.0))
      continue;
    all.turn += pow(turn_between(a, b, i), 2.0) / (WIDTH * HEIGHT);
    all.depth =
        fmax(all.depth, fabs(depth / (double)b->input[EXACT_DEPTH][i] - 1.0));
    for (int c = 0; c < 3; ++c)
      all.radiance =
          fmax(all.radiance, fabs(radiance_at(a, c, i) - radiance_at(b, c, i)));
  }
  all.turn = sqrt(all.turn);
  return all;
}

/* --- results -------------------------------------------------------------- */

static double rmse(const exact_planes *a, const exact_planes *b, int first,
                   int count) {
  double sum = 0.0;
  for (int c = first; c < first + count; ++c)
    for (int y = 0; y < HEIGHT; ++y)
      for (int x = 0; x < WIDTH; ++x)
        sum += pow(*exact_at(a, c, x, y) - *exact_at(b, c, x, y), 2.0);
  return sqrt(sum / (count * WIDTH * HEIGHT));
}

static double brightest(const setup *s) {
  double most = 0.0;
  for (size_t i = 0; i < setup_pixels(s); ++i)
    for (int c = 0; c < 3; ++c)
      most = fmax(most, radiance_at(s, c, i));
  return most;
}

/*
 * Bounds, to first order.  AO is 1/pi times an integral of the cosine with the
 * normal over open directions: if the normal turns by an angle, it changes by
 * at most 1/pi times the integral of |t.w| over a hemisphere, which is the
 * angle; four slices know the integral to a factor of two.  A change of the
 * inverse depth by a share e moves the horizon of a sample by up to 2 e over
 * its distance from the pixel, which is 1/fx or more in units of the ray's
 * slope, and AO by as much.  E_near changes by that times pi times the
 * brightest radiance, or by pi times the change of radiance.  Roundings of the
 * gather add 1e-6 (measured: 2.5e-8 with FLOAT32 octahedral normals).
 */
static void check_form(const form *f, const setup *floats,
                       const exact_planes *want) {
  setup s;
  char text[80];
  prepare(&s, f);
  setup_start(&s);
  const change c = change_between(floats, &s);
  exact_planes got = stage_gathered(&s);
  if (f->id == PLANE_NORMAL) {
    snprintf(text, sizeof text, "%s: degrees", f->name);
    check_at_most(text, c.turn * 180.0 / PI, f->turn);
  }
  const double shape = 2.0 * c.turn + 2.0 * c.depth * s.frame.camera.fx + 1e-6;
  snprintf(text, sizeof text, "%s: AO", f->name);
  check_at_most(text, rmse(&got, want, HBIL_LIGHT_AO, 1), shape);
  snprintf(text, sizeof text, "%s: E_near", f->name);
  check_at_most(text, rmse(&got, want, HBIL_LIGHT_RED, 3),
                PI * (shape * brightest(floats) + c.radiance));
  exact_planes_free(&got);
  setup_free(&s);
}

TEST(errors_are_those_of_the_rounding) {
  setup floats;
  prepare(&floats, NULL);
  setup_start(&floats);
  exact_planes want = stage_gathered(&floats);
  for (int i = 0; i < FORMS; ++i)
    check_form(&forms[i], &floats, &want);
  exact_planes_free(&want);
  setup_free(&floats);
}
