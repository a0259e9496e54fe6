/* A device, its limits, and the message of the last failure. */
#ifndef HBIL_CONTEXT_H
#define HBIL_CONTEXT_H

#include <stdbool.h>

#include "hbil/hbil.h"
#include "names.h"

struct hbil_context {
  cl_context context;
  cl_device_id device;
  char *message;        /* NULL: none */
  cl_uint vector_width; /* of the kernels, chosen for the device */
  size_t group[2];      /* work-group of every kernel */
  bool exact_divide;    /* CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT */
};

/* Sets the context's message.  Returns `status`, so that a failing function
 * ends with `return fail(...)`. */
hbil_status fail(hbil_context *context, hbil_status status, const char *format,
                 ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* The status that an OpenCL error is to the caller. */
hbil_status status_of(cl_int error);

/* fail() for an OpenCL function `call` that returned `error`. */
hbil_status fail_cl(hbil_context *context, cl_int error, const char *call);

/* "CL_INVALID_VALUE"; never NULL. */
const char *cl_error_name(cl_int error);

#endif
