/* What is wrong with a camera, told by the positions. */
#include "dump/check_camera.h"

#include "dump/matrix3.h"

#include <math.h>

/* Cameras look in the same direction within so many degrees. */
static const double same_turn = 0.6;

/* Focal lengths differ if by more than this share. */
static const double same_focus = 0.015;

static const char advice[] =
    "; the positions tell the right camera: --camera positions";

static matrix3 axes_of(const camera_file *c) {
  matrix3 m;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      m.m[i][j] = c->camera_to_world[4 * i + j];
  return m;
}

/* Degrees between a and b after a's world axes are sent to others: axis i of
 * the result is sign[i] times axis from[i]. */
static double turn_between(const matrix3 *a, const matrix3 *b,
                           const int from[3], const int sign[3]) {
  double trace = 0.0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      trace += sign[i] * a->m[from[i]][j] * b->m[i][j];
  return acos(fmax(-1.0, fmin(1.0, 0.5 * (trace - 1.0)))) * 57.29578;
}

/* Whether other world axes explain the difference; the order and signs. */
static int find_axes(const matrix3 *given, const matrix3 *fitted, int from[3],
                     int sign[3]) {
  static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int k = 0; k < 6; k++)
    for (int bits = 0; bits < 8; bits++) {
      for (int i = 0; i < 3; i++) {
        from[i] = orders[k][i];
        sign[i] = bits >> i & 1 ? -1 : 1;
      }
      if (turn_between(given, fitted, from, sign) < same_turn)
        return 1;
    }
  return 0;
}

/* Whether the camera's own axes are those of another convention: y down and z
 * forward. */
static int looks_forward(const matrix3 *given, const matrix3 *fitted) {
  static const int same[3] = {0, 1, 2}, plus[3] = {1, 1, 1};
  matrix3 turned = *given;
  for (int i = 0; i < 3; i++)
    for (int j = 1; j < 3; j++)
      turned.m[i][j] = -turned.m[i][j];
  return turn_between(&turned, fitted, same, plus) < same_turn;
}

static void name_turn(const matrix3 *given, const matrix3 *fitted,
                      findings *out) {
  static const int same[3] = {0, 1, 2}, plus[3] = {1, 1, 1};
  int from[3], sign[3];
  if (looks_forward(given, fitted))
    findings_add(out,
                 "the camera's axes are y down and z forward, and those of "
                 "OpenGL, y up and z backward, are needed%s",
                 advice);
  else if (find_axes(given, fitted, from, sign))
    findings_add(out,
                 "the camera's world has other axes than the positions', which "
                 "are %s%c, %s%c, %s%c of it%s",
                 sign[0] < 0 ? "-" : "", "xyz"[from[0]], sign[1] < 0 ? "-" : "",
                 "xyz"[from[1]], sign[2] < 0 ? "-" : "", "xyz"[from[2]],
                 advice);
  else
    findings_add(out,
                 "the camera is turned by %.1f degrees against the positions: "
                 "the camera of another frame?%s",
                 turn_between(given, fitted, same, plus), advice);
}

static int has_focus(const camera_file *given, const camera_file *fitted) {
  return fabs(given->fx / fitted->fx - 1) < same_focus &&
         fabs(given->fy / fitted->fy - 1) < same_focus;
}

/* Whether parallel rays come from elsewhere, by more than some pixels. */
static int is_moved(const camera_file *given, const camera_file *fitted,
                    double away) {
  return given->orthographic && has_focus(given, fitted) &&
         away * given->fx > CAMERA_FITS;
}

static void name_lens(const camera_file *given, const camera_file *fitted,
                      findings *out) {
  const double x = given->fx / fitted->fx, y = given->fy / fitted->fy;
  if (!has_focus(given, fitted))
    findings_add(out,
                 "the camera's focal length is %.4g, %.4g pixels, but that of "
                 "the positions is %.4g, %.4g, off by a factor of %.3g%s",
                 given->fx, given->fy, fitted->fx, fitted->fy,
                 fabs(x - 1) > fabs(y - 1) ? x : y, advice);
  else
    findings_add(out,
                 "the camera's centre is %.1f, %.1f, but that of the positions "
                 "is %.1f, %.1f%s",
                 given->cx, given->cy, fitted->cx, fitted->cy, advice);
}

/* The lens with which the given camera sees the positions best: least squares
 * of a line through slopes and pixels, for each axis. */
static camera_file with_best_lens(const fit_points *p,
                                  const camera_file *given) {
  const double *m = given->camera_to_world;
  camera_file out = *given;
  for (int axis = 0; axis < 2; axis++) {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (size_t i = 0; i < p->count; i++) {
      double v[3] = {0};
      for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++)
          v[c] += m[4 * r + c] * (p->list[i].at[r] - m[4 * r + 3]);
      const double by = given->orthographic ? 1.0 : -v[2];
      const double slope = (axis ? -v[1] : v[0]) / by;
      const double at = axis ? p->list[i].y : p->list[i].x;
      if (!(by > 0.0))
        continue;
      n++;
      x += slope;
      y += at;
      xx += slope * slope;
      xy += slope * at;
    }
    const double f = (n * xy - x * y) / (n * xx - x * x);
    *(axis ? &out.fy : &out.fx) = f;
    *(axis ? &out.cy : &out.cx) = (y - f * x) / n;
  }
  return out;
}

/* Whether the camera is in other units than the positions. */
static int has_other_units(const camera_file *given, const camera_file *fitted,
                           double turn) {
  double a = 0.0, b = 0.0;
  for (int k = 0; k < 3; k++) {
    a = hypot(a, given->camera_to_world[4 * k + 3]);
    b = hypot(b, fitted->camera_to_world[4 * k + 3]);
  }
  const double factor = given->orthographic ? fitted->fx / given->fx : a / b;
  return turn < same_turn && fabs(log(factor)) > log(2.0);
}

/* A picture that no camera of the library shows. */
static int name_projection(const fit_points *p, const camera_file *given,
                           findings *out) {
  const double *m = given->camera_to_world;
  const double eye[3] = {m[3], m[7], m[11]};
  const char *kind = camera_fit_name_projection(p, eye);
  if (kind)
    findings_add(out,
                 "the picture is %s by its positions, and is taken for %s one: "
                 "several perspective or orthographic pictures that show the "
                 "same are needed",
                 kind,
                 given->orthographic ? "an orthographic" : "a perspective");
  return kind != NULL;
}

int check_camera(const fit_points *p, const camera_file *given, findings *out) {
  static const int same[3] = {0, 1, 2}, plus[3] = {1, 1, 1};
  const double error = camera_fit_error(p, given);
  if (error < CAMERA_FITS)
    return 0;
  const camera_fit f = camera_fit_find(p);
  if (!f.found)
    return name_projection(p, given, out);
  if (!(2 * f.error < error))
    return 0;
  if (f.camera.orthographic != given->orthographic) {
    findings_add(out, "the camera is %s, but the positions are seen by %s%s",
                 given->orthographic ? "orthographic" : "a perspective one",
                 given->orthographic ? "a perspective one"
                                     : "an orthographic one",
                 advice);
    return 1;
  }
  const matrix3 is = axes_of(given), right = axes_of(&f.camera);
  const double turn = turn_between(&is, &right, same, plus);
  const camera_file lens = with_best_lens(p, given);
  double away = 0.0;
  for (int k = 0; k < 3; k++)
    away = hypot(away, given->camera_to_world[4 * k + 3] -
                           f.camera.camera_to_world[4 * k + 3]);
  if (has_other_units(given, &f.camera, turn))
    return 0; /* depth tells which of both (check_positions.h) */
  if (f.mirrored)
    findings_add(out,
                 "the positions are of a left-handed world, and the camera is "
                 "not%s",
                 advice);
  else if (!is_moved(given, &f.camera, away) && lens.fx > 0.0 &&
           lens.fy > 0.0 && camera_fit_error(p, &lens) < 1.2 * f.error + 0.1)
    name_lens(given, &lens, out);
  else if (turn > same_turn)
    name_turn(&is, &right, out);
  else
    findings_add(out,
                 "the camera stands %.3g units from where the positions were "
                 "seen from: the camera of another frame?%s",
                 away, advice);
  return 1;
}
