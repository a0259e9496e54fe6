/* What a cache takes from saved bytes, which may hold anything. */
#ifndef HBIL_VOXEL_REPAIR_H
#define HBIL_VOXEL_REPAIR_H

#include <stddef.h>

#include "names.h"

/* Replaces what no view and no bounce can have left in these voxels of
 * HBIL_VOXEL_FLOATS floats, as unusable values of a view are replaced
 * (hbil_config.h).  The bits of all else stay. */
void voxels_repair(float *voxels, size_t count);

#endif
