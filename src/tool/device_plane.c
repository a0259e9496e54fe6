/* Planes of frames, in the host's memory and on the device. */
#include "tool/device_plane.h"

#include <stdint.h>

/* Whether channels lie one behind the other, at equal distances. */
static int are_spaced(const host_channels *h, size_t *pitch) {
  const uintptr_t first = (uintptr_t)h->channel[0];
  *pitch = h->bytes;
  if (h->count > 1)
    *pitch = (size_t)((uintptr_t)h->channel[1] - first);
  for (size_t c = 1; c < h->count; c++)
    if ((uintptr_t)h->channel[c] != first + c * *pitch)
      return 0;
  return *pitch >= h->bytes && *pitch < SIZE_MAX / DEVICE_PLANE_CHANNELS;
}

/* Makes a buffer unless one is left from an earlier frame: all planes of a
 * sequence have the same size. */
static cl_int open(const device *d, const host_channels *h, cl_mem_flags flags,
                   device_plane *p) {
  cl_int status = CL_SUCCESS;
  size_t pitch;
  if (p->buffer)
    return CL_SUCCESS;
  p->is_the_host = d->uses_host_memory && are_spaced(h, &pitch);
  p->pitch = p->is_the_host ? pitch : h->bytes;
  const size_t size = (h->count - 1) * p->pitch + h->bytes;
  p->buffer = p->is_the_host
                  ? clCreateBuffer(d->context, flags | CL_MEM_USE_HOST_PTR,
                                   size, h->channel[0], &status)
                  : clCreateBuffer(d->context, flags, size, NULL, &status);
  return status;
}

cl_int device_plane_write(const device *d, const host_channels *from,
                          device_plane *p) {
  cl_int status = open(d, from, CL_MEM_READ_ONLY, p);
  for (size_t c = 0; !p->is_the_host && c < from->count && status == CL_SUCCESS;
       c++)
    status = clEnqueueWriteBuffer(d->queue, p->buffer, CL_FALSE, c * p->pitch,
                                  from->bytes, from->channel[c], 0, NULL, NULL);
  return status;
}

cl_int device_plane_open(const device *d, const host_channels *to,
                         device_plane *p) {
  return open(d, to, CL_MEM_WRITE_ONLY, p);
}

/* Mapping such a buffer brings its contents to where the host's planes are. */
static cl_int map(const device *d, const host_channels *to, device_plane *p) {
  cl_int status;
  const size_t size = (to->count - 1) * p->pitch + to->bytes;
  void *mapped = clEnqueueMapBuffer(d->queue, p->buffer, CL_TRUE, CL_MAP_READ,
                                    0, size, 0, NULL, NULL, &status);
  return status == CL_SUCCESS ? clEnqueueUnmapMemObject(d->queue, p->buffer,
                                                        mapped, 0, NULL, NULL)
                              : status;
}

cl_int device_plane_read(const device *d, const host_channels *to,
                         device_plane *p) {
  cl_int status = CL_SUCCESS;
  if (p->is_the_host)
    return map(d, to, p);
  for (size_t c = 0; c < to->count && status == CL_SUCCESS; c++)
    status = clEnqueueReadBuffer(d->queue, p->buffer, CL_TRUE, c * p->pitch,
                                 to->bytes, to->channel[c], 0, NULL, NULL);
  return status;
}

void device_plane_end(const device *d, device_plane *p) {
  if (d->uses_host_memory)
    device_plane_close(p);
}

void device_plane_close(device_plane *p) {
  if (p->buffer)
    clReleaseMemObject(p->buffer);
  *p = (device_plane){.buffer = NULL};
}
