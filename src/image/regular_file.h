/* Opens files for reading that are nothing else: to open a FIFO waits for
 * whoever writes to it, and a device has no end. */
#ifndef HBIL_IMAGE_REGULAR_FILE_H
#define HBIL_IMAGE_REGULAR_FILE_H

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Returns a descriptor, which the caller closes.  On failure returns -1, and
 * *why says why: what strerror() says, or "not a regular file". */
int regular_file_open(const char *path, const char **why);

/* The same as a stream; NULL on failure. */
FILE *regular_file_stream(const char *path, const char **why);

#ifdef __cplusplus
}
#endif

#endif
