/* Cameras that are fitted to a frame's positions. */
#ifndef HBIL_DUMP_FITTED_CAMERA_H
#define HBIL_DUMP_FITTED_CAMERA_H

#include "dump/frame_camera.h"

/* Fits a camera to the positions of the frame's file.  Returns 0, and sets
 * out->from to NULL if it has no positions or if they tell no camera; or -1
 * with `error` filled. */
int fitted_camera_read(const char *frame, const channel_map *map,
                       frame_camera *out, image_error *error);

#endif
