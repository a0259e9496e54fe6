/* Settings of a cache: defaults, and the rejection of what is out of range. */
#ifndef HBIL_CACHE_CONFIG_H
#define HBIL_CACHE_CONFIG_H

#include "context.h"

#include <stdbool.h>

/* The farthest that anything may be, in voxels of the coarsest level: numbers
 * of voxels stay far from the ends of 64 bits. */
#define CACHE_FARTHEST_MIDDLE 0x1p52

/* See config_take().  views: a configuration whose inputs are those of the
 * views, as the passes see them, of pictures of one pixel. */
hbil_status cache_config_take(hbil_context *context,
                              const hbil_cache_config *given,
                              hbil_cache_config *own, hbil_config *views);
hbil_status view_take(hbil_context *context, const hbil_view *given,
                      hbil_view *own);
hbil_status cache_update_take(hbil_context *context,
                              const hbil_cache_update *given,
                              hbil_cache_update *own);
hbil_status cache_change_take(hbil_context *context,
                              const hbil_cache_change *given,
                              hbil_cache_change *own);

#endif
