/* Cameras: what kernels need of them, computed in double and rounded once. */
#ifndef HBIL_CAMERA_H
#define HBIL_CAMERA_H

#include "context.h"
#include "shared.h"

/* Rejects a camera that is outside of the ranges of hbil_camera, or whose
 * world_from_view is not a rigid transform, mirrored or not. */
hbil_status camera_check(hbil_context *context, const hbil_camera *camera);

enum { RIGID_ERROR_SIZE = 80 };
/* What is wrong with a rigid transform, mirrored or not, perhaps in `text`;
 * NULL: nothing. */
const char *rigid_error(const double m[16], char text[RIGID_ERROR_SIZE]);

hbil_view_args camera_view(const hbil_camera *camera,
                           const hbil_config *config);

/* From the view space of `from` to that of `to`. */
hbil_transform_args camera_between(const hbil_camera *from,
                                   const hbil_camera *to);

hbil_transform_args camera_to_world(const hbil_camera *camera);

/* From normals as a plan of this configuration finds them stored to view space.
 * Only the first three columns count. */
hbil_transform_args camera_view_from_normals(const hbil_camera *camera,
                                             const hbil_config *config);

/* From view space to a cache's space, of `scale` voxels per world unit about a
 * centre; and back.  unit: units of length in view space per world unit. */
hbil_transform_args camera_to_cache(const hbil_camera *camera,
                                    const double centre[3], double scale,
                                    double unit);
hbil_transform_args camera_from_cache(const hbil_camera *camera,
                                      const double centre[3], double scale,
                                      double unit);

#endif
