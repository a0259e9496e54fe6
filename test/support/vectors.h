/*
 * Vectors of three doubles.
 */
#ifndef HBIL_TEST_VECTORS_H
#define HBIL_TEST_VECTORS_H

double dot(const double a[3], const double b[3]);
/* `out` is neither `a` nor `b`. */
void cross(const double a[3], const double b[3], double out[3]);
/* a + s b; `out` may be `a`. */
void add(const double a[3], double s, const double b[3], double out[3]);
void normalize(double v[3]);

#endif
