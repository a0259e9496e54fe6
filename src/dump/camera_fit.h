/*
 * The camera that a frame's positions tell.
 *
 * Each position and the pixel that shows it give two equations for the camera.
 * Some thousand of them are far more than it has unknowns, so single wrong ones
 * (mixtures at edges) are found and left out, and the place of a sample in its
 * pixel averages out.
 */
#ifndef HBIL_DUMP_CAMERA_FIT_H
#define HBIL_DUMP_CAMERA_FIT_H

#include "dump/gbuffer.h"
#include "image/camera_json.h"

/* A pixel's middle, and the position that it shows. */
typedef struct fit_point {
  double x, y, at[3];
  double depth; /* as the file has it, in camera units; 0: none */
} fit_point;

enum { FIT_POINTS = 2000 };

typedef struct fit_points {
  fit_point list[FIT_POINTS];
  size_t count;
  uint32_t width, height; /* of the picture */
} fit_points;

typedef struct camera_fit {
  int found;
  camera_file camera; /* in pixels of the planes */
  int mirrored;       /* 1: the world is left-handed; the camera is that of the
                         world with z's sign changed */
  double error;       /* pixels within which 90 % of the positions are seen */
} camera_fit;

/* Samples the positions of surfaces that fill their pixel. */
void camera_fit_points(const gbuffer *g, fit_points *out);

/* Finds a perspective or an orthographic camera; found 0 if there is none, or
 * if the positions don't tell it, for instance because all lie on one plane. */
camera_fit camera_fit_find(const fit_points *p);

/* Pixels within which 90 % of the positions are seen by that camera. */
double camera_fit_error(const fit_points *p, const camera_file *camera);

/* Error of a camera that fits.  A pixel's position may be that of any sample
 * that its filter reaches: LuxCore's are up to 2 pixels away in x and in y. */
#define CAMERA_FITS 3.0

/* Whether the picture is no perspective of any camera: "a fisheye", "a
 * panorama", or NULL if it is neither.  eye: where the camera stands, if the
 * depths don't tell. */
const char *camera_fit_name_projection(const fit_points *p,
                                       const double eye[3]);

#endif
