/* Eigenvectors of small symmetric matrices, by Jacobi's rotations. */
#include "dump/eigen.h"

#include <math.h>
#include <string.h>

/* Far more than matrices of this size need. */
enum { SWEEPS = 60 };

/* Makes element (p, q) zero, and turns the basis v alike. */
static void rotate(double *a, double *v, size_t n, size_t p, size_t q) {
  const double off = a[p * n + q];
  if (!(fabs(off) > 0.0))
    return;
  const double theta = (a[q * n + q] - a[p * n + p]) / (2.0 * off);
  const double t =
      copysign(1.0, theta) / (fabs(theta) + sqrt(theta * theta + 1.0));
  const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
  for (size_t k = 0; k < n; k++) {
    const double x = a[k * n + p], y = a[k * n + q];
    a[k * n + p] = c * x - s * y;
    a[k * n + q] = s * x + c * y;
  }
  for (size_t k = 0; k < n; k++) {
    const double x = a[p * n + k], y = a[q * n + k];
    a[p * n + k] = c * x - s * y;
    a[q * n + k] = s * x + c * y;
  }
  for (size_t k = 0; k < n; k++) {
    const double x = v[k * n + p], y = v[k * n + q];
    v[k * n + p] = c * x - s * y;
    v[k * n + q] = s * x + c * y;
  }
}

double eigen_smallest(double a[], size_t n, double vector[]) {
  double v[EIGEN_MOST * EIGEN_MOST] = {0};
  size_t least = 0;
  double second = INFINITY, most = 0.0;
  for (size_t i = 0; i < n; i++)
    v[i * n + i] = 1.0;
  for (int sweep = 0; sweep < SWEEPS; sweep++)
    for (size_t p = 0; p < n; p++)
      for (size_t q = p + 1; q < n; q++)
        rotate(a, v, n, p, q);
  for (size_t i = 0; i < n; i++) {
    most = fmax(most, a[i * n + i]);
    if (a[i * n + i] < a[least * n + least])
      least = i;
  }
  for (size_t i = 0; i < n; i++) {
    vector[i] = v[i * n + least];
    if (i != least)
      second = fmin(second, a[i * n + i]);
  }
  return most > 0.0 ? second / most : 0.0;
}
