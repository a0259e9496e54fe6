/*
 * A bare plane hides nothing from itself, at every tilt and field of view and
 * in every mode: AO is 1, no light arrives, and the bent normal is its normal.
 */
#include "test/support/stages.h"
#include "test/support/vectors.h"

#include <stdio.h>

#define WIDTH 80
#define HEIGHT 45

/* Largest deviations from a bare plane. */
typedef struct deviation {
  double ao, light, bent;
} deviation;

/*
 * Measured: AO 2.4e-7, E_near 2.8e-11 of radiance 1, bent 8.2e-5, where the
 * plane is seen almost edge on and its fp32 normal has few digits left.  With
 * half-float depth they are the same, since its tolerance covers its rounding.
 * The requirement is 1e-3, 1e-3 and 1e-2.
 */
static const deviation limit = {1e-5, 1e-5, 5e-4};
/* Derived: half a step of AO's 16 bits, and the error of the fp32 search; one
 * step of the bent normal's word, 1/1023 in x and in y and 1/511 in z, and half
 * a step of the octahedral normal (unit/test_storage.c). */
static const deviation packed_limit = {0.5 / 65535.0 + 1e-5, 1e-5,
                                       2.41e-3 + 6.6e-5};

/* Cosine of the angle at which the eye sees the plane. */
static double cosine_at(const setup *s, const double normal[3], int x, int y) {
  double ray[3];
  setup_ray(s, x, y, ray);
  normalize(ray);
  return fabs(dot(ray, normal));
}

static void compare_pixel(const exact_planes *got, const setup *s,
                          const double normal[3], int x, int y,
                          deviation *worst) {
  double bent[3], off[3];
  worst->ao = fmax(worst->ao, fabs(*exact_at(got, HBIL_LIGHT_AO, x, y) - 1.0));
  for (int c = 0; c < 3 && s->config.model.mode == HBIL_MODE_HBIL; ++c)
    worst->light =
        fmax(worst->light, fabs(*exact_at(got, HBIL_LIGHT_RED + c, x, y)));
  if (s->config.model.mode == HBIL_MODE_HBAO)
    return;
  for (int c = 0; c < 3; ++c)
    bent[c] = *exact_at(got, HBIL_LIGHT_BENT + c, x, y);
  normalize(bent);
  add(bent, -1.0, normal, off);
  const double size = sqrt(dot(off, off));
  worst->bent = fmax(worst->bent, isfinite(size) ? size : INFINITY);
}

/* All tilts in 5 azimuths at one field of view, where the eye sees the plane at
 * least_cosine or more. */
static void compare_view(setup *s, double fov, double least_cosine,
                         deviation *worst) {
  const int tilts[] = {0, 10, 30, 45, 60, 75, 80, 85};
  setup_camera(s, fov);
  for (int i = 0; i < 40; ++i) {
    double normal[3];
    tilted_normal(tilts[i % 8] * PI / 180.0, 0.4 + 1.3 * (i / 8), normal);
    setup_plane(s, normal);
    setup_upload(s);
    exact_planes got = stage_gathered(s);
    for (int p = 0; p < WIDTH * HEIGHT; ++p)
      if (s->input[EXACT_DEPTH][p] > 0.0f &&
          cosine_at(s, normal, p % WIDTH, p / WIDTH) >= least_cosine)
        compare_pixel(&got, s, normal, p % WIDTH, p / WIDTH, worst);
    exact_planes_free(&got);
  }
}

/* Starts and frees the setup. */
static void check_planes_from(setup *s, double least_cosine,
                              const deviation *most) {
  const double fov[] = {30.0, 60.0, 90.0, 120.0};
  deviation worst = {0.0, 0.0, 0.0};
  s->config.inputs.albedo.component = s->config.inputs.emission.component =
      HBIL_NONE;
  for (int c = 0; c < 3; ++c)
    setup_fill(s, EXACT_DIRECT + c, (float)PI); /* radiance 1 */
  setup_start(s);
  for (int i = 0; i < 4; ++i)
    compare_view(s, fov[i], least_cosine, &worst);
  setup_free(s);
  check_at_most("AO", worst.ao, most->ao);
  check_at_most("E_near", worst.light, most->light);
  check_at_most("bent", worst.bent, most->bent);
}

static void check_planes(setup *s, const deviation *most) {
  check_planes_from(s, 0.0, most);
}

static void check_mode(hbil_mode mode, float radius, float thickness) {
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  setup_mode(&s, mode);
  s.config.model.radius = s.config.model.ao_radius = radius;
  s.config.model.thickness = thickness;
  check_planes(&s, &limit);
}

TEST(hbil_planes_hide_nothing) {
  check_mode(HBIL_MODE_HBIL, INFINITY, INFINITY);
  check_mode(HBIL_MODE_HBIL, 1.0f, INFINITY);
}

TEST(gtao_planes_hide_nothing) {
  check_mode(HBIL_MODE_GTAO, INFINITY, INFINITY);
  check_mode(HBIL_MODE_GTAO, 1.0f, INFINITY);
}

TEST(hbao_planes_hide_nothing) {
  check_mode(HBIL_MODE_HBAO, INFINITY, INFINITY);
  check_mode(HBIL_MODE_HBAO, 1.0f, INFINITY);
  check_mode(HBIL_MODE_HBAO, 1.0f, 0.1f);
}

TEST(planes_with_half_float_depth_hide_nothing) {
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  s.config.inputs.depth.component = HBIL_FLOAT16;
  check_planes(&s, &limit);
}

TEST(packed_planes_hide_nothing) {
  const hbil_component depth[] = {HBIL_FLOAT32, HBIL_FLOAT16};
  for (int i = 0; i < 2; ++i) {
    setup s;
    setup_init(&s, WIDTH, HEIGHT);
    s.config.sampling.storage = HBIL_STORAGE_PACKED;
    s.config.inputs.depth.component = depth[i];
    check_planes(&s, &packed_limit);
  }
}

/* Formats of normals whose steps are coarser than a float's. */
typedef struct coarse {
  const char *name;
  hbil_component component;
  hbil_normal_encoding encoding;
  double step; /* of a component, of -1..1 */
} coarse;

static const coarse coarse_forms[] = {
    {"UNORM8", HBIL_UNORM8, HBIL_NORMAL_XYZ, 2.0 / 255},
    {"SNORM8", HBIL_SNORM8, HBIL_NORMAL_XYZ, 1.0 / 127},
    {"RGB10A2", HBIL_RGB10A2_UNORM, HBIL_NORMAL_XYZ, 2.0 / 1023},
    {"UNORM16", HBIL_UNORM16, HBIL_NORMAL_XYZ, 2.0 / 65535},
    {"SNORM16", HBIL_SNORM16, HBIL_NORMAL_XYZ, 1.0 / 32767},
    {"halves", HBIL_FLOAT16, HBIL_NORMAL_XYZ, 0x1p-11},
    {"octahedral UNORM8", HBIL_UNORM8, HBIL_NORMAL_OCTAHEDRAL, 2.0 / 255},
    {"octahedral SNORM16", HBIL_SNORM16, HBIL_NORMAL_OCTAHEDRAL, 1.0 / 32767},
    {"octahedral halves", HBIL_FLOAT16, HBIL_NORMAL_OCTAHEDRAL, 0x1p-11},
};

/* AO measured, before gather.c knew these formats and since: UNORM8 0.54 and
 * 3e-7, SNORM8 0.73 and 2e-7, RGB10A2 0.25 and 6e-8, UNORM16 1.1e-5 and 6e-8,
 * SNORM16 3.2e-5 and 6e-8, octahedral UNORM8 0.49 and 0 (0.12
 * where the plane is almost edge on). */
static void check_coarse(const coarse *f, cl_uint vector_width) {
  const bool map = f->encoding == HBIL_NORMAL_OCTAHEDRAL;
  /* Derived: components, or u and v, are off by half a step; sqrt(18) and
   * sqrt(3) are what turns the normal most (planes.c). */
  const double turn = 0.5 * f->step * sqrt(map ? 18.0 : 3.0);
  const deviation most = {limit.ao, limit.light, limit.bent + turn};
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  s.config.inputs.normal = (hbil_plane_format){f->component, 0};
  s.config.inputs.normal_encoding = f->encoding;
  s.config.execution.vector_width = vector_width;
  if (getenv("HBIL_TEST_VERBOSE"))
    printf("# %s\n", f->name);
  /* A normal that is turned by more than half of the angle between the ray and
   * the plane moves the horizon by more than the first-order limit knows. */
  check_planes_from(&s, map ? 2.0 * turn : 0.0, &most);
}

/* By vectors of the device's own width, and by single pixels, which compile
 * fastest; test_formats reads each format by both. */
TEST(planes_with_coarse_normals_hide_nothing) {
  for (size_t i = 0; i < sizeof coarse_forms / sizeof *coarse_forms; ++i)
    check_coarse(&coarse_forms[i], i % 3 ? 1 : 0);
}

/* Depth buffers, whose steps are as large far away as they are near. */
typedef struct buffered {
  const char *name;
  hbil_component depth, normal;
  double a, b; /* hbil_frame.hardware_depth; the near plane is at 0.05 */
} buffered;

static const buffered buffered_forms[] = {
    {"UNORM16, 0..1", HBIL_UNORM16, HBIL_FLOAT32, 1.0, -0.05},
    {"UNORM16, 1..0", HBIL_UNORM16, HBIL_FLOAT32, 0.0, 0.05},
    {"UNORM24, 0..1", HBIL_UNORM24, HBIL_FLOAT32, 1.0, -0.05},
    {"FLOAT32, 0..1", HBIL_FLOAT32, HBIL_FLOAT32, 1.0, -0.05},
    {"FLOAT32, 1..0", HBIL_FLOAT32, HBIL_FLOAT32, 0.0, 0.05},
    {"FLOAT16, 0..1", HBIL_FLOAT16, HBIL_FLOAT32, 1.0, -0.05},
    {"FLOAT16, 1..0", HBIL_FLOAT16, HBIL_FLOAT32, 0.0, 0.05},
    {"UNORM16 and normals of UNORM8", HBIL_UNORM16, HBIL_UNORM8, 1.0, -0.05},
};

/* AO measured, without the gather's half_step and with it: UNORM16 8e-3 and 0,
 * with UNORM8 normals 2e-3 and 3e-7, UNORM24 and FLOAT32 of 0..1 5e-7 and 6e-8,
 * FLOAT16 of 0..1 0.89 and 0, 1..0 6e-8 in both.  bent: 0.70 and 7e-5, 0.07 and
 * 6e-3, 1e-3 and 8e-5, 1.2 and 4e-8. */
static void check_buffered(const buffered *f) {
  setup s;
  setup_init(&s, WIDTH, HEIGHT);
  s.config.inputs.normal = (hbil_plane_format){f->normal, 0};
  s.config.inputs.depth = (hbil_plane_format){f->depth, 0};
  s.config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
  s.frame.hardware_depth[0] = f->a;
  s.frame.hardware_depth[1] = f->b;
  if (f->depth == HBIL_UNORM24 || f->depth == HBIL_FLOAT16)
    s.config.execution.vector_width = 1; /* as above */
  if (getenv("HBIL_TEST_VERBOSE"))
    printf("# %s\n", f->name);
  /* a step of UNORM8 is 2/255, and sqrt(3)/2 of it turns the normal */
  const double turn = f->normal == HBIL_UNORM8 ? sqrt(3.0) / 255.0 : 0.0;
  check_planes(&s, &(deviation){limit.ao, limit.light, limit.bent + turn});
}

TEST(planes_in_depth_buffers_hide_nothing) {
  for (size_t i = 0; i < sizeof buffered_forms / sizeof *buffered_forms; ++i)
    check_buffered(&buffered_forms[i]);
}
