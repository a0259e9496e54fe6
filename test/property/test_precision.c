/*
 * Horizons are right from the tangent plane to the zenith.
 */
#include "test/support/contents.h"
#include "test/support/stress.h"

#include <stdio.h>

#include "exact/march.h"
#include "lib/sampling_pattern.h"

typedef long double real;

/* The cosine-weighted measure between the direction to the eye and the angle
 * theta, whose tangent is along / up (A in doc/method.md), for a normal of
 * these components. */
static real measure(real nx, real ny, real along, real up) {
  const real size = sqrtl(along * along + up * up);
  const real sine = along / size, theta = atan2l(along, up);
  return nx / 2 * (theta - sine * up / size) + ny / 2 * sine * sine;
}

/* A pixel as its one slice sees it. */
typedef struct cut {
  real wo[3], r, w;
  real ud, nx, ny; /* u.D; the normal along D and wo */
  real gx, gy;     /* the tangent plane's gradient of inverse depth */
  real sx, sy;     /* the same of the surface's plane */
} cut;

static cut cut_of(const setup *s, const exact_planes *split, int x, int y,
                  float ux, float uy) {
  const hbil_camera *camera = &s->frame.camera;
  const real ray[3] = {(x + (real)0.5 - camera->cx) / camera->fx,
                       (y + (real)0.5 - camera->cy) / camera->fy, 1};
  cut c = {.w = *exact_at(split, HBIL_SPLIT_W, x, y)};
  real n[3], n_r = 0, u_wo, n_u;
  c.r = sqrtl(ray[0] * ray[0] + ray[1] * ray[1] + 1);
  for (int i = 0; i < 3; ++i) {
    n[i] = *exact_at(split, HBIL_SPLIT_NORMAL + i, x, y);
    c.wo[i] = -ray[i] / c.r;
    n_r += n[i] * ray[i];
  }
  u_wo = ux * c.wo[0] + uy * c.wo[1];
  n_u = n[0] * ux + n[1] * uy;
  c.ud = sqrtl((real)ux * ux + (real)uy * uy - u_wo * u_wo);
  c.ny = -n_r / c.r;
  c.nx = (n_u - u_wo * c.ny) / c.ud;
  c.gx = n[0] * c.w / n_r;
  c.gy = n[1] * c.w / n_r;
  const receiver here =
      exact_receiver(&s->job, split, x, y, COVERAGE_HORIZON, NULL);
  c.sx = here.s.slope_x;
  c.sy = here.s.slope_y;
  return c;
}

/* AO of a pixel with one slice of one sample on each side, whose inverse depths
 * are lowered by `lowered` of themselves. */
static double one_sample_ao(const setup *s, const exact_planes *split, int x,
                            int y, real lowered) {
  const hbil_pattern_args pattern = exact_pattern(&s->job);
  const hbil_view_args view = exact_view(&s->config, &s->frame.camera);
  const int layer = 4 * (y % 4) + x % 4;
  float ux, uy;
  real open = 0, whole = 0;
  hbil_slice_direction(layer, 0, pattern, &ux, &uy);
  for (int side = 0; side < 2; ++side, ux = -ux, uy = -uy) {
    const cut c = cut_of(s, split, x, y, ux, uy);
    const real start = measure(c.nx, c.ny, c.ny, -c.nx);
    int dx, dy;
    hbil_sample_offset(layer, 0, 0, ux, uy, view, pattern, &dx, &dy);
    whole += start;
    if (x + dx < 0 || x + dx >= WIDTH || y + dy < 0 || y + dy >= HEIGHT) {
      open += start;
      continue;
    }
    const real ex = dx / (real)view.fx, ey = dy / (real)view.fy;
    const real e = sqrtl(ex * ex + ey * ey);
    const real w1 =
        *exact_at(split, HBIL_SPLIT_W, x + dx, y + dy) * (1 - lowered);
    /* above the tangent plane, on the slice's line */
    const real excess = (w1 - c.w - c.sx * ex - c.sy * ey) / e +
                        (c.sx - c.gx) * ux + (c.sy - c.gy) * uy;
    /* cot(theta) is the tangent plane's, or what the sample adds to it */
    const real cot = -c.nx / c.ny + fmaxl(excess, 0) * c.r / (c.ud * c.w);
    open += measure(c.nx, c.ny, 1, cot);
  }
  return (double)(open / whole);
}

/* On walls, a quarter of the pixels is nearer by this share: from less than a
 * rounding above the tangent plane up to the zenith. */
static const double nearer[] = {0x1p-24,  0x1p-22,  1e-6,     1e-5, 1e-4, 1e-3,
                                1e-2,     0.1,      0.5,      0.9,  0.99, 0.999,
                                1 - 1e-5, 1 - 1e-7, 1 - 1e-10};
#define NEARER (sizeof nearer / sizeof *nearer)

TEST(horizons_from_the_tangent_plane_to_the_zenith) {
  setup *s = stress_begin(ONE_SAMPLE);
  random_state r = {stress_effort.seed};
  double worst = 0.0, mean = 0.0, count = 0.0;
  setup_camera(s, 60.0);
  for (size_t i = 0; i < NEARER * 3; ++i) {
    const double tilt = 40.0 * (double)(i / NEARER);
    STRESS_CASE("one sample nearer by %g on a wall tilted by %g degrees",
                nearer[i % NEARER], tilt);
    load_plane(s, tilt, 0.7);
    for (int p = 0; p < PIXELS; ++p)
      if (random_unit(&r) < 0.25)
        s->input[EXACT_DEPTH][p] =
            (float)(s->input[EXACT_DEPTH][p] * (1.0 - nearer[i % NEARER]));
    stress_run(s);
    exact_planes split = stage_read(s, HBIL_STAGE_SPLIT);
    exact_planes got = stage_read(s, HBIL_STAGE_GATHERED);
    for (int y = 0; y < HEIGHT; ++y)
      for (int x = 0; x < WIDTH; ++x) {
        if (!(*exact_at(&split, HBIL_SPLIT_W, x, y) > 0.0))
          continue;
        /* the kernel lowers samples by 2^-22, and rounds what the surface rises
         * by on the way, which is much where it is steep */
        const receiver here =
            exact_receiver(&s->job, &split, x, y, COVERAGE_HORIZON, NULL);
        const double rounding =
            0x1p-23 * (fabs(here.s.slope_x) + fabs(here.s.slope_y)) / here.s.w;
        const double ao = *exact_at(&got, HBIL_LIGHT_AO, x, y);
        const double least = one_sample_ao(s, &split, x, y, 0);
        const double most = one_sample_ao(s, &split, x, y, 0x1p-22L);
        const double off = fmax(0.0, fmax(least - ao, ao - most) - rounding);
        worst = fmax(worst, isfinite(off) ? off : INFINITY);
        mean += off;
        count += 1.0;
      }
    planes_free(&split, &got);
    check_case("AO against long double", worst, 2e-6); /* measured: 3.7e-7 */
  }
  if (getenv("HBIL_TEST_VERBOSE"))
    print_message("horizons | gather: AO | %.3g | %.3g\n", worst * 0x1p24,
                  mean / count * 0x1p24);
}
