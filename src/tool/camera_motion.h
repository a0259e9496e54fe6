/* Whether the camera of a sequence moves. */
#ifndef HBIL_TOOL_CAMERA_MOTION_H
#define HBIL_TOOL_CAMERA_MOTION_H

#include "hbil/hbil.h"

#include <stddef.h>

/* Pixels that a point of a surface may move without a change of what the
 * sequence is taken for.  Numbers that a renderer writes differ from frame to
 * frame by roundings, and no layer shows a hundredth of a pixel. */
#define CAMERA_SAME_PIXELS 0.01

typedef enum camera_motion_kind {
  CAMERA_STANDS,  /* no pixel moves by more than CAMERA_SAME_PIXELS */
  CAMERA_JITTERS, /* nor would one, if the centres were the same; these are
                   * less than a pixel apart, as TAA makes them */
  CAMERA_MOVES
} camera_motion_kind;

typedef struct camera_motion {
  camera_motion_kind kind;
  double pixels; /* how far a pixel moves at most, without jitter */
  double jitter; /* how far the centres are apart at most, x or y, in pixels */
} camera_motion;

/* The cameras of a job's frames, all of one projection and one picture size. */
typedef struct camera_path {
  const hbil_camera *const *cameras;
  size_t count; /* 1 or more */
  hbil_projection projection;
  size_t width, height;
} camera_path;

/* Planar depths of what is seen; low is INFINITY if there is no surface. */
typedef struct depth_range {
  double low, high;
} depth_range;

/* Whether the depths can change what camera_motion_find() returns: with
 * INFINITY .. -INFINITY for them, it returns no CAMERA_MOVES, and the cameras'
 * places differ.  Saves reading a picture for nothing. */
int camera_motion_needs_depths(const camera_path *path);

/*
 * Compares all cameras with the first one.  A point that the first one sees in
 * a pixel, at whatever depth between those of the range, is projected by each
 * of the others.  Along a ray the point's picture moves in one direction, so
 * both ends of the range are enough: with perspective the nearest surface and
 * infinity, which a sky has, and with parallel rays the nearest and the
 * farthest surface.  Pixels of a grid over the picture, its corners among
 * them, stand for all.
 */
camera_motion camera_motion_find(const camera_path *path, depth_range depths);

#endif
