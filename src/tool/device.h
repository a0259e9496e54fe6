/* Lists the machine's OpenCL devices and opens one of them. */
#ifndef HBIL_TOOL_DEVICE_H
#define HBIL_TOOL_DEVICE_H

#include "hbil/hbil.h"
#include "image/error.h"

typedef struct device {
  cl_device_id id;
  cl_context context;
  cl_command_queue queue; /* in order */
  int uses_host_memory;   /* 1: kernels work in the host's memory, as those of
                             CPUs do */
  char name[256], driver[256];
  char *note; /* on its driver's folder for compiled kernels, or NULL; owned */
} device;

/* wanted: an index in the list, a part of a name, or NULL for the first GPU or
 * else the first device.  Returns 0, or -1 with `error` filled. */
int device_open(const char *wanted, int profiling, device *out,
                image_error *error);

/* It may be called on a zeroed device. */
void device_close(device *d);

/* The name of the device's platform. */
void device_platform(cl_device_id id, char name[256]);

/* Bytes of the device's global memory; 0: unknown. */
unsigned long long device_memory(cl_device_id id);

/* Prints all devices to standard output.  Returns 0, or -1 with `error` filled
 * if there are none. */
int device_list(image_error *error);

#endif
