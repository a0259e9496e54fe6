/* The plan's buffers, and scratch memory that the caller lends. */
#ifndef HBIL_MEMORY_H
#define HBIL_MEMORY_H

#include "commands.h"
#include "plan.h"

/* What OpenCL knows of a buffer or an image. */
typedef struct memory_info {
  cl_mem_object_type type;
  cl_context context;
  cl_mem_flags flags;
  size_t bytes;
  cl_mem parent; /* of a sub-buffer, else null */
  size_t origin; /* where a sub-buffer begins in its parent, else 0 */
} memory_info;

cl_int memory_read(cl_mem buffer, memory_info *info);

typedef struct buffer_limits {
  size_t largest;   /* bytes of one buffer */
  size_t alignment; /* bytes: multiples at which sub-buffers may begin */
} buffer_limits;

hbil_status memory_limits(hbil_context *context, buffer_limits *limits);

/* That a plan's scratch buffers can live in the caller's; *lent tells where. */
hbil_status check_lent(hbil_context *context, cl_mem scratch, size_t needed,
                       memory_range *lent);

/* Makes a buffer that the device reads and writes; NULL and an error if there
 * is no memory for it. */
cl_mem memory_create(const hbil_context *context, size_t bytes, cl_int *error);

/* Makes the plan's buffers. */
hbil_status allocate(hbil_plan *plan);

/* Clears what kernels read around the pixels of layers, but do not write. */
hbil_status clear_padding(commands *chain);

#endif
