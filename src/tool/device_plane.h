/*
 * A plane of a frame, in the host's memory and on the device.  A device that
 * works in the host's memory uses the host's planes themselves, if its channels
 * lie equally spaced.  Otherwise there is a buffer, to which or from which they
 * are copied.
 */
#ifndef HBIL_TOOL_DEVICE_PLANE_H
#define HBIL_TOOL_DEVICE_PLANE_H

#include "tool/device.h"

#include <stddef.h>

enum { DEVICE_PLANE_CHANNELS = 3 };

typedef struct host_channels {
  void *channel[DEVICE_PLANE_CHANNELS]; /* the first `count` ones are there */
  size_t count;
  size_t bytes; /* of each */
} host_channels;

/* All zeros: none yet. */
typedef struct device_plane {
  cl_mem buffer;
  size_t pitch;    /* bytes between the beginnings of two channels */
  int is_the_host; /* 1: the buffer is the host's own memory */
} device_plane;

/* Makes an input of the host's planes.  Copies don't block: the planes stay as
 * they are until the queue has done what was enqueued. */
cl_int device_plane_write(const device *d, const host_channels *from,
                          device_plane *p);

/* Makes an output that device_plane_read() brings to the host's planes; nobody
 * looks at these in between. */
cl_int device_plane_open(const device *d, const host_channels *to,
                         device_plane *p);
/* Blocks. */
cl_int device_plane_read(const device *d, const host_channels *to,
                         device_plane *p);

/* Releases what is the host's own memory, and on a device that works in it any
 * buffer, after the queue has done with it. */
void device_plane_end(const device *d, device_plane *p);

void device_plane_close(device_plane *p);

#endif
