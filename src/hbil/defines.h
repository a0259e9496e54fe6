/* The build defines of the kernels of plans and caches. */
#ifndef HBIL_DEFINES_H
#define HBIL_DEFINES_H

#include "context.h"
#include "layout.h"

/* Writes all that changes machine code as "-DNAME=VALUE" with spaces between;
 * fails where that doesn't fit into `size` characters. */
hbil_status write_defines(hbil_context *context, const hbil_config *config,
                          const layout *l, char *text, size_t size);

/* The same for a cache, whose views have these formats. */
hbil_status write_view_defines(hbil_context *context, const hbil_config *config,
                               char *text, size_t size);

#endif
