/*
 * Attempts in which one OpenCL call fails: status and message must tell of it.
 */
#ifndef HBIL_TEST_FAULT_H
#define HBIL_TEST_FAULT_H

#include "test/support/fixture.h"
#include "test/support/shim.h"

/* What calls return.  MEMORY_FAULTS: the first ones, which are about memory on
 * the device or the host. */
enum { FAULTS = 4, MEMORY_FAULTS = 2 };
extern const cl_int faults[FAULTS];

/* The result of an attempt in which call `nth` should fail. */
typedef struct outcome {
  int nth;
  const char *failed; /* NULL: it made fewer calls */
  hbil_status status;
} outcome;

/* `statement`, whose value is a status, with a fault in it. */
#define ATTEMPT(n, error, statement)                                           \
  (shim_fail((n), (error)), attempted((n), (statement)))
outcome attempted(int nth, hbil_status status);
/* Checks status and message of an attempt in which faults[fault] was returned.
 * context: NULL if there was none yet. */
void check_outcome(const hbil_context *context, const outcome *o, int fault);
/* The status alone. */
void check_outcome_status(const outcome *o, int fault);
/* That so many references are held. */
void check_held(const outcome *o, long want);

#endif
