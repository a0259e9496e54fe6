/* Eigenvectors of small symmetric matrices. */
#ifndef HBIL_DUMP_EIGEN_H
#define HBIL_DUMP_EIGEN_H

#include <stddef.h>

enum { EIGEN_MOST = 12 };

/* The eigenvector of the smallest eigenvalue of the n x n matrix, which is
 * overwritten.  n is EIGEN_MOST at most.  Returns the second smallest
 * eigenvalue over the largest: near 0, the vector is one of many. */
double eigen_smallest(double matrix[], size_t n, double vector[]);

#endif
