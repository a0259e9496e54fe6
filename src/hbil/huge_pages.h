/* Large buffers of CPU devices, in memory of huge pages. */
#ifndef HBIL_HUGE_PAGES_H
#define HBIL_HUGE_PAGES_H

#include "names.h"
#include "hbil/hbil.h"

/* Makes a buffer that a CPU device can read and write, in memory that lies on
 * huge pages where the system has them to give.  The memory is freed when
 * OpenCL no longer needs the buffer.  NULL where this is not possible, or where
 * the buffer is too small to gain by it; then clCreateBuffer() does it alone.
 *
 * The gather reads from everywhere in the picture.  With pages of 4 KiB it
 * would often wait for misses of the TLB: at 3840 x 2160 a frame would take 2
 * to 17 % longer (doc/measurements.md, "Scaling"). */
cl_mem create_on_huge_pages(cl_context context, size_t bytes);

#endif
