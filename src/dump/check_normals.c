/* Checks that normals fit the depth. */
#include "dump/check_normals.h"

#include "dump/normal_fit.h"

#include <math.h>

/* The more likely ones come first. */
static const unsigned flip_orders[] = {0, 4, 2, 1, 6, 5, 3, 7};

/* Whether another space or other axes fit much better. */
static int find_space(const normal_fit *f, double agreement, findings *out) {
  const conventions *how = &f->s.g->map.how;
  const unsigned table = source_table[f->s.g->map.kind].how.flips;
  double best = agreement + 0.1; /* bump maps differ by less */
  dump_space space = how->normals;
  unsigned flips = 0;
  int found = 0;
  for (int s = 0; s < 2; s++)
    for (size_t i = 0; i < sizeof flip_orders / sizeof *flip_orders; i++) {
      const matrix3 h = normal_fit_view_if(f, (dump_space)s, flip_orders[i]);
      const double fits = normal_fit_cosine(f, &f->planar, &h);
      if (fits > best && fits > 0.9) {
        found = 1;
        best = fits + 1e-3; /* equally good is not better */
        space = (dump_space)s;
        flips = flip_orders[i];
      }
    }
  if (!found)
    return 0;
  if (space == source_table[f->s.g->map.kind].how.normals)
    flips ^= table; /* --flip adds to the flips of the source */
  findings_add(
      out,
      "normals don't fit the depth, but do in %s space%s%s%s%s: --normals "
      "%s%s%s%s%s",
      space == SPACE_WORLD ? "world" : "camera", flips ? " with turned " : "",
      flips & 1 ? "x" : "", flips & 2 ? "y" : "", flips & 4 ? "z" : "",
      space == SPACE_WORLD ? "world" : "camera", flips ? " --flip " : "",
      flips & 1 ? "x" : "", flips & 2 ? "y" : "", flips & 4 ? "z" : "");
  return 1;
}

static const char *lens_option(const normal_fit *f) {
  return surface_rays_are_parallel(&f->s) ? "--orthographic" : "--fov";
}

/* Whether a rotation between the camera and the one that the normals belong to
 * explains the difference.  Bumps make up to half a degree in real dumps. */
static int find_turn(const normal_fit *f, const matrix3 *h, findings *out) {
  matrix3 best;
  if (!matrix3_orthogonal_factor(f->planar, &best) ||
      normal_fit_cosine(f, &f->planar, &best) < 0.95)
    return 0;
  /* 57.29578 degrees in a radian */
  const double turn =
      acos(fmax(-1.0, fmin(1.0, 0.5 * (matrix3_inner(&best, h) - 1.0)))) *
      57.29578;
  if (matrix3_determinant(&best) * matrix3_determinant(h) < 0.0 ||
      !(turn > 1.5))
    return 0;
  findings_add(
      out,
      "normals fit the depth if the camera is turned by %.1f degrees: the "
      "camera of another frame, or another lens? --camera, %s",
      turn, lens_option(f));
  return 1;
}

static void find_disagreement(const normal_fit *f, double agreement,
                              double deepest, findings *out) {
  if (agreement > 0.9)
    return;
  findings_add(out,
               "normals don't fit the depth (%.0f degrees off on average)%s",
               acos(fmax(-1.0, agreement)) * 57.29578,
               deepest <= 1.0 && f->s.g->map.how.depth == DEPTH_PLANAR
                   ? ", which is 0..1: --depth device or reversed, with --clip?"
               : surface_rays_are_parallel(&f->s)
                   ? ": another --normals, --depth, --orthographic or camera?"
                   : ": another --normals, --depth, --fov or camera, or a "
                     "fisheye or panorama?");
}

double check_normals(const surface_points *s, double deepest, findings *out) {
  const normal_fit f = normal_fit_measure(s);
  if (f.count < NORMAL_FIT_LEAST)
    return NAN;
  const matrix3 h = surface_view_from_normals(s);
  const double agreement = normal_fit_cosine(&f, &f.planar, &h);
  if (find_space(&f, agreement, out))
    return agreement;
  if (normal_fit_is_other_depth(&f, &h))
    findings_add(
        out,
        s->g->map.how.depth == DEPTH_RAY
            ? "depth is taken for the distance from the eye, but fits the "
              "normals as that along the axis: --depth planar"
            : "depth is taken for that along the camera's axis, but fits the "
              "normals as distance from the eye: --depth ray");
  else if (!find_turn(&f, &h, out))
    find_disagreement(&f, agreement, deepest, out);
  return agreement;
}
