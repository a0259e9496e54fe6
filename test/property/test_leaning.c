/*
 * Shading normals that lean from the surface: normal maps, and smooth normals
 * on few facets.  A surface that nothing rises above hides from a normal that
 * leans by the angle t what is behind its own plane, so AO is (1 + cos t) / 2.
 */
#include "test/support/random.h"
#include "test/support/stages.h"
#include "test/support/vectors.h"

#define DEGREES (PI / 180.0)

enum { WIDTH = 128, HEIGHT = 72, BORDER = 8 };

static double right_ao(const double surface[3], const double shading[3]) {
  return 0.5 * (1.0 + dot(surface, shading));
}

static void set_normal(setup *s, int at, const double n[3]) {
  for (int c = 0; c < 3; ++c)
    s->input[EXACT_NORMAL + c][at] = (float)n[c];
}

static double cosine_to_eye(const setup *s, int at, const double n[3]) {
  double ray[3];
  setup_ray(s, at % WIDTH, at / WIDTH, ray);
  if (s->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC)
    return -n[2];
  normalize(ray);
  return -dot(n, ray);
}

/* n, turned by an angle towards `to`, which is at right angles to it. */
static void turned(const double n[3], const double to[3], double angle,
                   double out[3]) {
  for (int c = 0; c < 3; ++c)
    out[c] = cos(angle) * n[c] + sin(angle) * to[c];
}

/* ------------------------------------------------------------------------ */
/* Even floors                                                               */

typedef struct floor_case {
  float thickness;
  hbil_mode mode;
  hbil_resolution resolution;
  cl_uint width;
  bool orthographic;
} floor_case;

/* A floor seen at 45 degrees whose normals lean along its slope, up to nearly a
 * right angle to the view.  Returns the largest error of a row's mean AO: all
 * pixels of a row see the floor alike.  With finite thickness, a single pixel's
 * is off by up to .008, as sectors are. */
static double error_on_floor(const floor_case *f, double lean) {
  const double tilt = 45.0 * DEGREES;
  double n[3], along[3], shading[3], worst = 0.0;
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  setup_mode(&s, f->mode);
  s.config.model.relative_thickness = f->thickness;
  s.config.model.extrapolate = CL_TRUE;
  s.config.sampling.resolution = f->resolution;
  s.config.sampling.slices = 3;
  s.config.sampling.steps_per_side = 16;
  s.config.sampling.step_growth = 3.0f;
  s.config.execution.vector_width = f->width;
  setup_camera(&s, 20.0);
  if (f->orthographic)
    setup_flatten(&s, 3.0);
  tilted_normal(tilt, PI / 2.0, n);
  setup_plane(&s, n);
  for (int i = 0; i < WIDTH * HEIGHT && f->orthographic; ++i) {
    double at[3];
    setup_ray(&s, i % WIDTH, i / WIDTH, at);
    s.input[EXACT_DEPTH][i] =
        (float)(3.0 - (n[0] * at[0] + n[1] * at[1]) / n[2]);
  }
  tilted_normal(tilt + PI / 2.0, PI / 2.0, along);
  turned(n, along, lean, shading);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    set_normal(&s, i, shading);
  exact_planes got = first_outputs(&s);
  for (int y = BORDER; y < HEIGHT - BORDER; ++y) {
    double sum = 0.0;
    for (int x = BORDER; x < WIDTH - BORDER; ++x)
      sum += *exact_at(&got, EXACT_AO, x, y);
    if (cosine_to_eye(&s, y * WIDTH + WIDTH / 2, shading) > 0.01)
      worst =
          fmax(worst, fabs(sum / (WIDTH - 2 * BORDER) - right_ao(n, shading)));
  }
  exact_planes_free(&got);
  setup_free(&s);
  return worst;
}

TEST(floors_hide_what_is_behind_them) {
  static const floor_case cases[] = {
      {INFINITY, HBIL_MODE_HBIL, HBIL_RESOLUTION_FULL, 0, false},
      {INFINITY, HBIL_MODE_GTAO, HBIL_RESOLUTION_FULL, 1, false},
      {0.1f, HBIL_MODE_HBIL, HBIL_RESOLUTION_FULL, 0, false},
      {0.1f, HBIL_MODE_HBIL, HBIL_RESOLUTION_HALF, 0, false},
      {0.1f, HBIL_MODE_HBIL, HBIL_RESOLUTION_FULL, 1, true}};
  static const double leans[] = {-40.0, -10.0, 0.0, 10.0, 30.0, 40.0, 44.0};
  for (int i = 0; i < 5; ++i)
    for (int k = 0; k < 7; ++k)
      check_at_most("AO of a floor",
                    error_on_floor(&cases[i], leans[k] * DEGREES), 0.005);
}

/* ------------------------------------------------------------------------ */
/* Normals that differ from pixel to pixel                                   */

/* As it comes out of each pixel by itself. */
static void start_unfiltered(setup *s, float thickness) {
  s->config.model.relative_thickness = thickness;
  s->config.sampling.unfiltered = CL_TRUE;
  s->config.sampling.slices = 32;
  s->config.sampling.steps_per_side = 16;
  s->config.sampling.step_growth = 3.0f;
  setup_start(s);
  setup_run(s, hbil_enqueue_frame);
}

static double error_on_normal_map(float thickness) {
  double surface[3], squares = 0.0;
  random_state random = {7};
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  tilted_normal(40.0 * DEGREES, 0.3, surface);
  setup_camera(&s, 40.0);
  setup_plane(&s, surface);
  double *right = calloc(WIDTH * HEIGHT, sizeof(*right));
  assert_non_null(right);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    double side[3], other[3], to[3], n[3];
    const double psi = 2.0 * PI * random_unit(&random);
    const double lean = 40.0 * DEGREES * random_unit(&random);
    cross(surface, (const double[]){0.0, 0.0, 1.0}, side);
    normalize(side);
    cross(surface, side, other);
    for (int c = 0; c < 3; ++c)
      to[c] = cos(psi) * side[c] + sin(psi) * other[c];
    turned(surface, to, lean, n);
    const bool faces =
        s.input[EXACT_DEPTH][i] > 0.0f && cosine_to_eye(&s, i, n) > 0.02;
    set_normal(&s, i, faces ? n : surface);
    right[i] = faces ? right_ao(surface, n) : 1.0;
  }
  start_unfiltered(&s, thickness);
  exact_planes got = outputs_read(&s);
  for (int y = BORDER; y < HEIGHT - BORDER; ++y)
    for (int x = BORDER; x < WIDTH - BORDER; ++x) {
      const double off = *exact_at(&got, EXACT_AO, x, y) - right[y * WIDTH + x];
      squares += off * off;
    }
  exact_planes_free(&got);
  free(right);
  setup_free(&s);
  return sqrt(squares / ((WIDTH - 2 * BORDER) * (HEIGHT - 2 * BORDER)));
}

/* Measured: 1e-5; with sectors, which are all dithered alike in a single
 * pixel, .009. */
TEST(a_normal_map_is_not_a_wall) {
  check_at_most("AO of a normal map", error_on_normal_map(INFINITY), 0.001);
  check_at_most("AO of a normal map", error_on_normal_map(0.1f), 0.02);
}

/* ------------------------------------------------------------------------ */
/* Smooth normals on facets                                                  */

typedef struct facet {
  double normal[3], distance;
} facet;

/* The facets between two circles of latitude of a sphere about the origin. */
static int make_facets(int sides, facet *out) {
  int count = 0;
  for (int ring = 0; ring < sides / 2; ++ring)
    for (int side = 0; side < sides; ++side) {
      const double high = PI * ring / (sides / 2),
                   low = high + 2.0 * PI / sides;
      const double mid = 2.0 * PI * (side + 0.5) / sides;
      /* the profile's middle radius is that of the facet's middle line */
      const double apothem = cos(PI / sides);
      const double a[2] = {apothem * sin(high), cos(high)};
      const double b[2] = {apothem * sin(low), cos(low)};
      double normal[2] = {a[1] - b[1], b[0] - a[0]};
      const double size = hypot(normal[0], normal[1]);
      facet *f = &out[count++];
      f->normal[0] = normal[0] / size * cos(mid);
      f->normal[1] = normal[1] / size;
      f->normal[2] = normal[0] / size * sin(mid);
      f->distance = (normal[0] * a[0] + normal[1] * a[1]) / size;
    }
  return count;
}

/* The facet of a convex body that the ray from the origin meets first, or NULL.
 * centre: where the body is. */
static const facet *facet_seen(const facet *list, int count,
                               const double centre[3], const double ray[3],
                               double *z) {
  double enter = 0.0, leave = INFINITY;
  const facet *seen = NULL;
  for (int i = 0; i < count; ++i) {
    const double towards = dot(list[i].normal, ray);
    const double away = list[i].distance + dot(list[i].normal, centre);
    if (towards < 0.0 && away / towards > enter) {
      enter = away / towards;
      seen = &list[i];
    } else if (towards > 0.0) {
      leave = fmin(leave, away / towards);
    } else if (towards == 0.0 && away < 0.0) {
      return NULL;
    }
  }
  *z = enter;
  return enter < leave ? seen : NULL;
}

/* Whether two pixels to each side show the same facet, so that its plane can be
 * known. */
static bool is_inside(const facet *const *seen, int i) {
  for (int k = 1; k <= 2; ++k)
    if (seen[i - k] != seen[i] || seen[i + k] != seen[i] ||
        seen[i - k * WIDTH] != seen[i] || seen[i + k * WIDTH] != seen[i])
      return false;
  return true;
}

static double error_on_sphere(int sides, float thickness) {
  const double centre[3] = {0.1, -0.05, 4.0};
  facet *facets = calloc((size_t)(sides * sides), sizeof(*facets));
  double *right = calloc(WIDTH * HEIGHT, sizeof(*right));
  double squares = 0.0;
  int count = 0;
  setup s;
  const facet **seen = calloc(WIDTH * HEIGHT, sizeof(*seen));
  assert_non_null(facets);
  assert_non_null(seen);
  assert_non_null(right);
  setup_init(&s, WIDTH, HEIGHT);
  setup_camera(&s, 35.0);
  const int all = make_facets(sides, facets);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    double ray[3], z = 0.0, n[3];
    setup_ray(&s, i % WIDTH, i / WIDTH, ray);
    const facet *f = facet_seen(facets, all, centre, ray, &z);
    s.input[EXACT_DEPTH][i] = f ? (float)z : 0.0f;
    for (int c = 0; c < 3; ++c)
      n[c] = z * ray[c] - centre[c];
    normalize(n);
    set_normal(&s, i, n);
    seen[i] = f;
    if (f && cosine_to_eye(&s, i, n) > 0.1)
      right[i] = right_ao(f->normal, n);
  }
  start_unfiltered(&s, thickness);
  exact_planes got = outputs_read(&s);
  for (int i = 0; i < WIDTH * HEIGHT; ++i)
    if (right[i] > 0.0 && is_inside(seen, i)) {
      const double off =
          *exact_at(&got, EXACT_AO, i % WIDTH, i / WIDTH) - right[i];
      squares += off * off;
      ++count;
    }
  assert_true(count > 100);
  exact_planes_free(&got);
  free(facets);
  free(seen);
  free(right);
  setup_free(&s);
  return sqrt(squares / count);
}

TEST(smooth_normals_leave_facets_flat) {
  for (int sides = 8; sides <= 32; sides *= 2) {
    check_at_most("AO of a sphere", error_on_sphere(sides, INFINITY), 0.005);
    /* measured: .0064, by sectors, which are dithered alike */
    check_at_most("AO of a sphere", error_on_sphere(sides, 0.1f), 0.01);
  }
}
