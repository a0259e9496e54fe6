/* 3x3 matrices. */
#ifndef HBIL_DUMP_MATRIX3_H
#define HBIL_DUMP_MATRIX3_H

typedef struct matrix3 {
  double m[3][3];
} matrix3;

double matrix3_dot(const double a[3], const double b[3]);

double matrix3_determinant(const matrix3 *a);

/* The sum over the products of equal elements: trace(a^T b). */
double matrix3_inner(const matrix3 *a, const matrix3 *b);

/* Adds a b^T. */
void matrix3_add_outer(matrix3 *sum, const double a[3], const double b[3]);

/* The orthogonal factor of the polar decomposition: the orthogonal matrix H
 * with the largest trace(H^T a).  Returns 0 if the matrix is too close to a
 * singular one to tell. */
int matrix3_orthogonal_factor(matrix3 a, matrix3 *out);

#endif
