/*
 * The part of the shim that is about programs: each source is built once for
 * each set of options and each context, and plans that need it again get the
 * same program.  Even with PoCL's cache on disk a build takes 90 ms, and a test
 * creates hundreds of plans.  Only shim.c includes this.
 */
#ifndef HBIL_TEST_SHIM_PROGRAMS_H
#define HBIL_TEST_SHIM_PROGRAMS_H

#include <stdio.h>
#include <stdlib.h>

#include <CL/cl.h>

/* libOpenCL's function of that name.  C doesn't let an object pointer become a
 * function pointer; POSIX does. */
#define NEXT(name)                                                             \
  (((union {                                                                   \
     void *object;                                                             \
     __typeof__(&name) function;                                               \
   }){.object = dlsym(RTLD_NEXT, #name)})                                      \
       .function)

/* Prints the reason and aborts. */
_Noreturn void shim_give_up(const char *why);

/* What the shim does in place of the OpenCL functions. */
cl_program programs_create(cl_context context, cl_uint count,
                           const char **strings, const size_t *lengths,
                           cl_int *error);
cl_int programs_build(cl_program program, cl_uint count,
                      const cl_device_id *devices, const char *options,
                      void(CL_CALLBACK *notify)(cl_program, void *),
                      void *data);
cl_kernel programs_kernel(cl_program program, const char *name, cl_int *error);
cl_int programs_info(cl_program program, cl_program_info what, size_t room,
                     void *value, size_t *size);
/* CL_SUCCESS without effect while builds are skipped. */
cl_int programs_set_argument(cl_kernel kernel, cl_uint index, size_t size,
                             const void *value);
/* The program, or the context, has lost its last reference. */
void programs_forget(cl_program program);
void programs_forget_context(cl_context context);

#endif
