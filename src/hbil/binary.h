/* Built programs that a caller's store has from an earlier run. */
#ifndef HBIL_BINARY_H
#define HBIL_BINARY_H

#include <stdbool.h>

#include "context.h"

/* What a program was built of. */
typedef struct binary_identity {
  char key[48];      /* in the store: the program's name and a hash */
  cl_ulong identity; /* another hash, which is stored with the binary */
  bool is_new;       /* not from the store */
} binary_identity;

/* Identifies a program by its name, text and build options, and the context's
 * device.  Without a store nothing is done, here and below. */
void binary_identify(const hbil_context *context, const char *name,
                     const char *text, const char *options,
                     binary_identity *out);

/* The program, built from what the store has; NULL if that can't be used. */
cl_program binary_load(hbil_context *context, const char *options,
                       const binary_identity *identity);

/* Hands a new program to the store. */
void binary_store(hbil_context *context, cl_program program,
                  const binary_identity *identity);

#endif
