/*
 * The slice integral.
 *
 * wo points to the eye.  A slice goes through wo and one direction u of the
 * image; D = normalize(u - (u.wo) wo) is u made perpendicular to wo.  The
 * half-slice has the directions wo cos t + D sin t, t from 0 to pi.  With
 * nx = n.D and ny = n.wo, a direction's cosine with the normal is
 * ny cos t + nx sin t, and its solid angle is sin t dt per unit of azimuth, so
 *   A(theta) = integral_0^theta (nx sin t + ny cos t) sin t dt
 *            = nx/2 (theta - sin theta cos theta) + ny/2 sin^2 theta.
 * The tangent plane lies where the cosine is 0: cot theta = -nx/ny.  Without
 * the cosine (HBAO) the measure is 1 - cos theta.
 *
 * Slices that are equally spaced on the screen, by their angle psi, are not
 * equally spaced in azimuth phi about wo: dphi/dpsi = |wo.z| / (1 - (u.wo)^2).
 * That is the weight J; its mean over psi is 1.
 */
#include "exact/slice.h"

/* Of the direction with those components along D and along wo; any length. */
static angle angle_of(double along, double wo) {
  const double size = sqrt(along * along + wo * wo);
  angle a = {atan2(along, wo), along / size, wo / size, 0.0};
  a.arc = a.theta - a.sine * a.cosine;
  return a;
}

vec3 exact_bent_integral(const half_slice *h, angle a) {
  const vec3 along = vec_scale(a.arc / 2.0, h->along);
  return vec_add(along, a.sine * a.sine / 2.0, h->wo);
}

half_slice exact_half_slice(const surface *point, double ux, double uy,
                            bool uniform, bool equal_weights) {
  half_slice h;
  h.point = point;
  h.u = vec(ux, uy, 0.0);
  h.wo = vec_scale(-1.0, vec_normalize(point->ray));
  h.along = vec_normalize(vec_add(h.u, -vec_dot(h.u, h.wo), h.wo));
  h.nx = vec_dot(point->normal, h.along);
  h.ny = vec_dot(point->normal, h.wo);
  const double u_wo = vec_dot(h.u, h.wo);
  h.weight = equal_weights ? 1.0 : fabs(h.wo.z) / (1.0 - u_wo * u_wo);
  h.uniform = uniform;
  h.tangent = (point->grad_x - point->slope_x) * ux +
              (point->grad_y - point->slope_y) * uy;
  h.start = angle_of(h.ny, -h.nx);
  h.whole = exact_measure(&h, h.start);
  return h;
}

/*
 * The direction to the point is scaled by both inverse depths, so that points
 * at infinity and beyond are no exception: with P0 = r0 / w0 and P1 = (r0 + e)
 * / w1, w0 w1 (P1 - P0) = w0 (r0 + e) - w1 r0 = w0 e - (w1 - w0) r0.
 */
angle exact_horizon(const half_slice *h, double distance, double excess) {
  const surface *s = h->point;
  const double rise =
      (s->slope_x * h->u.x + s->slope_y * h->u.y + excess) * distance;
  const vec3 to = vec_add(vec_scale(distance * s->unit, h->u), -rise, s->ray);
  return angle_of(vec_dot(to, h->along), vec_dot(to, h->wo));
}
