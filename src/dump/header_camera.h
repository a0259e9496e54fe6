/*
 * The camera that a renderer stores in the header of its file, as the matrices
 * worldToCamera and worldToNDC.
 *
 * Renderers agree on the names of the two matrices and on little else.  Vectors
 * may be columns or rows, z may point forward or backward, worlds may be left-
 * or right-handed, and the picture may span -1..1 or 0..1 with y up or down.
 * The two matrices together tell all of this, given that x of the camera points
 * right and y up, and that for parallel rays z of the picture grows with the
 * distance.
 */
#ifndef HBIL_DUMP_HEADER_CAMERA_H
#define HBIL_DUMP_HEADER_CAMERA_H

#include "image/camera_json.h"
#include "image/image.h"

/* Whether the header has both matrices. */
int header_camera_exists(const image *header);

/*
 * Reads the camera.  unit: camera units in a unit of the file.  A left-handed
 * world is made right-handed by changing the sign of its z; *mirrored tells.
 * Returns 0, or -1 if there are no matrices or they describe neither a
 * perspective nor an orthographic camera.
 */
int header_camera_read(const image *header, double unit, camera_file *out,
                       int *mirrored);

#endif
