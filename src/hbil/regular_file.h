/* Files that the library reads: stored programs and, for work on them, kernels.
 */
#ifndef HBIL_REGULAR_FILE_H
#define HBIL_REGULAR_FILE_H

#include <stddef.h>
#include <stdio.h>

#include "names.h"

/* Opens a regular file for reading.  *size: its bytes, which may be too many.
 * NULL if there is none, or if it is something else: to open a FIFO would wait
 * for whoever writes to it, and a device may have no end. */
FILE *open_regular_file(const char *path, size_t *size);

#endif
