#include "test/support/vectors.h"

#include <math.h>

double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void cross(const double a[3], const double b[3], double out[3]) {
  for (int c = 0; c < 3; ++c)
    out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

void add(const double a[3], double s, const double b[3], double out[3]) {
  for (int c = 0; c < 3; ++c)
    out[c] = a[c] + s * b[c];
}

void normalize(double v[3]) {
  double size = sqrt(dot(v, v));
  for (int c = 0; c < 3; ++c)
    v[c] /= size;
}
