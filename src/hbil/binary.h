/* Built programs that a caller's store has from an earlier run. */
#ifndef HBIL_BINARY_H
#define HBIL_BINARY_H

#include <stdbool.h>

#include "context.h"

/* Identifies a program by its name, text and build options, and the context's
 * device. */
void binary_identify(const hbil_context *context, const char *name,
                     const char *text, const char *options,
                     binary_identity *out);

/* The program, built from what the store has; NULL if that can't be used, or if
 * there is no store. */
cl_program binary_load(hbil_context *context, const char *options,
                       const binary_identity *identity);

/* Hands a new program to the store, if there is one. */
void binary_store(hbil_context *context, cl_program program,
                  const binary_identity *identity);

#endif
