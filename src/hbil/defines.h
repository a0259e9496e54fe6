/* The build defines of a plan's kernels. */
#ifndef HBIL_DEFINES_H
#define HBIL_DEFINES_H

#include "context.h"
#include "layout.h"

/* Writes all that changes machine code as "-DNAME=VALUE" with spaces between;
 * fails where that doesn't fit into `size` characters. */
hbil_status write_defines(hbil_context *context, const hbil_config *config,
                          const layout *l, char *text, size_t size);

#endif
