/* Loaded before a program (LD_PRELOAD): its OpenCL platform has the name that
 * HBIL_TEST_PLATFORM says, so that PoCL stands for any other driver. */
#define _GNU_SOURCE /* RTLD_NEXT */
#include <CL/cl.h>

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

typedef cl_int (*get_info)(cl_platform_id, cl_platform_info, size_t, void *,
                           size_t *);

cl_int clGetPlatformInfo(cl_platform_id platform, cl_platform_info what,
                         size_t size, void *value, size_t *needed) {
  const char *name = getenv("HBIL_TEST_PLATFORM");
  get_info next;
  *(void **)&next = dlsym(RTLD_NEXT, "clGetPlatformInfo");
  const cl_int status = next(platform, what, size, value, needed);
  if (status == CL_SUCCESS && what == CL_PLATFORM_NAME && value && name) {
    const int length = snprintf(value, size, "%s", name);
    if (needed)
      *needed = (size_t)length + 1;
  }
  return status;
}
