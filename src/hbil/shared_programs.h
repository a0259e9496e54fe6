/* Built programs that the plans and caches of a context share. */
#ifndef HBIL_SHARED_PROGRAMS_H
#define HBIL_SHARED_PROGRAMS_H

#include "context.h"

/* The program of this identity that an earlier plan or cache was created with,
 * retained for the caller; NULL if there is none. */
cl_program shared_program(hbil_context *context,
                          const binary_identity *identity);

/* Holds a program for later plans and caches, in place of the oldest one if
 * there are MOST_SHARED.  To be called after the trial launches, when nothing
 * is left to compile or to store. */
void share_program(hbil_context *context, cl_program program,
                   const binary_identity *identity);

void forget_shared_programs(hbil_context *context);

#endif
