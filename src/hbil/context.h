/* A device, its limits, and the message of the last failure. */
#ifndef HBIL_CONTEXT_H
#define HBIL_CONTEXT_H

#include <stdbool.h>

#include "hbil/hbil.h"
#include "names.h"

/* What a program was built of. */
typedef struct binary_identity {
  char key[48];      /* in the store: the program's name and a hash */
  cl_ulong identity; /* another hash, which is stored with the binary */
  bool is_new;       /* neither from the store nor shared */
} binary_identity;

/* Programs that a context holds for later plans and caches: those of about two
 * plans with a cache each, which have up to 19 and 11. */
enum { MOST_SHARED = 64 };

struct hbil_context {
  int references; /* of the caller and of each plan */
  cl_context context;
  cl_device_id device;
  char *message; /* NULL: none */
  /* of several views, the number of the one that is checked, and 1; else 0 */
  cl_uint checked_view;
  hbil_message_callback callback; /* NULL: none */
  void *user;                     /* the callback's */
  bool is_cpu;                    /* the device is a CPU */
  cl_uint compute_units;
  cl_uint vector_width; /* of the kernels, chosen for the device */
  size_t group[2];      /* work-group of every kernel */
  bool exact_divide;    /* CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT */
  bool takes_registers; /* the compiler can be told how many to use at most */
  /* where built programs are stored (binary.h) */
  struct {
    hbil_program_load load; /* NULL: nowhere, and no store either */
    hbil_program_store store;
    void *user;
    char *folder;    /* of folder.c; NULL: a store of the caller's */
    bool warned;     /* that something could not be stored there */
    cl_ulong device; /* a hash of what the binaries depend on */
  } programs;
  /* shared_programs.h; without gaps from the start until all are taken */
  struct {
    cl_program programs[MOST_SHARED]; /* NULL: none */
    binary_identity identity[MOST_SHARED];
    int next; /* the next one to be replaced */
  } shared;
};

void context_retain(hbil_context *context);
/* Destroys it with the last reference.  NULL is allowed. */
void context_release(hbil_context *context);

#if defined(__GNUC__)
#define PRINTF_FORMAT(text, first)                                             \
  __attribute__((format(printf, (text), (first))))
#else
#define PRINTF_FORMAT(text, first)
#endif

/* Sets the context's message and hands it to the callback; if context is NULL,
 * sets the thread's message.  Returns `status`, so that a failing function ends
 * with `return fail(...)`. */
hbil_status fail(hbil_context *context, hbil_status status, const char *format,
                 ...) PRINTF_FORMAT(3, 4);

/* fail() for a public function whose argument `name` is null. */
hbil_status fail_null(hbil_context *context, const char *function,
                      const char *name);

/* The status that an OpenCL error is to the caller. */
hbil_status status_of(cl_int error);

/* fail() for an OpenCL function that returned `error`.  The format gives its
 * name and, in parentheses, what it was called for: "clCreateKernel(split)". */
hbil_status fail_cl(hbil_context *context, cl_int error, const char *format,
                    ...) PRINTF_FORMAT(3, 4);

/* Hands a warning to the callback; the message stays that of the last failure.
 */
void warn(hbil_context *context, const char *format, ...) PRINTF_FORMAT(2, 3);

/* "CL_INVALID_VALUE"; never NULL. */
const char *cl_error_name(cl_int error);

#endif
