/* Buffers on the device: the owner's, and those that callers hand in. */
#ifndef HBIL_BUFFERS_H
#define HBIL_BUFFERS_H

#include "context.h"

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

/* Makes a buffer that the device reads and writes. */
hbil_status buffer_create(hbil_context *context, size_t bytes, cl_mem *out);

/* A part of a buffer that is nobody's sub-buffer. */
typedef struct memory_range {
  cl_mem memory; /* NULL: none */
  size_t start, bytes;
} memory_range;

/* That scratch buffers of so many bytes can live in the caller's; *lent tells
 * where. */
hbil_status check_lent(hbil_context *context, cl_mem scratch, size_t needed,
                       memory_range *lent);

/* Makes a buffer of a part of what the caller lends, from `start` on. */
hbil_status buffer_create_in(hbil_context *context, const memory_range *lent,
                             size_t start, size_t bytes, cl_mem *out);

/* Releases those that are not NULL. */
void buffers_release(cl_mem const buffers[], int count);

#endif
