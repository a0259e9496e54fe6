/* What is wrong with a camera, told by the positions. */
#ifndef HBIL_DUMP_CHECK_CAMERA_H
#define HBIL_DUMP_CHECK_CAMERA_H

#include "dump/camera_fit.h"
#include "dump/findings.h"

/* Adds what is different about the camera of the frame from the one that fits
 * its positions.  Returns whether it added something: nothing if the camera is
 * right, or if the positions tell none. */
int check_camera(const fit_points *p, const camera_file *given, findings *out);

#endif
