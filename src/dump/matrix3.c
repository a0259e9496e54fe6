/* 3x3 matrices. */
#include "dump/matrix3.h"

#include <math.h>

double matrix3_dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double matrix3_determinant(const matrix3 *a) {
  const double(*m)[3] = a->m;
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

double matrix3_inner(const matrix3 *a, const matrix3 *b) {
  double sum = 0;
  for (int i = 0; i < 3; i++)
    sum += matrix3_dot(a->m[i], b->m[i]);
  return sum;
}

void matrix3_add_outer(matrix3 *sum, const double a[3], const double b[3]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      sum->m[i][j] += a[i] * b[j];
}

static matrix3 cofactors(const matrix3 *a) {
  matrix3 out;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const int p = (i + 1) % 3, q = (i + 2) % 3;
      const int r = (j + 1) % 3, s = (j + 2) % 3;
      out.m[i][j] = a->m[p][r] * a->m[q][s] - a->m[p][s] * a->m[q][r];
    }
  return out;
}

/* Newton's iteration, X' = (X + X^-T) / 2. */
int matrix3_orthogonal_factor(matrix3 a, matrix3 *out) {
  const double size = sqrt(matrix3_inner(&a, &a));
  /* below this, the vectors that were summed have too few directions */
  if (!(fabs(matrix3_determinant(&a)) > 1e-6 * size * size * size))
    return 0;
  for (int step = 0; step < 60; step++) { /* far more than it needs */
    const double d = matrix3_determinant(&a);
    const matrix3 c = cofactors(&a);
    double change = 0;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        const double next = 0.5 * (a.m[i][j] + c.m[i][j] / d);
        change = fmax(change, fabs(next - a.m[i][j]));
        a.m[i][j] = next;
      }
    if (change < 1e-12)
      break;
  }
  *out = a;
  return 1;
}
