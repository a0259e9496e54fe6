/*
 * The camera file beside a dump: a JSON object with camera_to_world (4 x 4, row
 * by row), fx, fy, cx and cy.  resolution, projection, near, far and exposure
 * are optional.  An orthographic camera may have ortho_scale, as Blender
 * defines it, in place of fx and fy.
 */
#ifndef HBIL_IMAGE_CAMERA_JSON_H
#define HBIL_IMAGE_CAMERA_JSON_H

#include "image/error.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct camera_file {
  double camera_to_world[16]; /* OpenGL convention, row by row */
  int orthographic;           /* 1: all rays are parallel */
  /* Focal length in pixels; orthographic: pixels per world unit. */
  double fx, fy;
  /* Principal point in pixels from the display window's corner. */
  double cx, cy;
  uint32_t width, height; /* resolution; 0 if the file doesn't have it */
  double near, far;       /* clipping planes; 0 if the file doesn't have them */
  /* What the frame's light is multiplied by; 0 if the file doesn't have it */
  double exposure;
} camera_file;

/* A larger file is rejected before it is read completely. */
enum { CAMERA_FILE_MOST = 1 << 20 };

/* Exposures that are possible, as those of the library. */
#define CAMERA_LEAST_EXPOSURE 1e-12
#define CAMERA_MOST_EXPOSURE 1e12

int camera_read(const char *path, camera_file *out, image_error *error);

/* The resolution must be known, the clipping planes, which must be finite, need
 * not.  Fails if a number is not finite.  The file appears complete or not at
 * all. */
int camera_write(const char *path, const camera_file *camera,
                 image_error *error);

#ifdef __cplusplus
}
#endif

#endif
