/*
 * The camera of a frame: from a JSON file, from the header's matrices, or from
 * the user's options.
 */
#ifndef HBIL_DUMP_FRAME_CAMERA_H
#define HBIL_DUMP_FRAME_CAMERA_H

#include "dump/channel_map.h"
#include "image/camera_json.h"
#include "image/error.h"
#include "image/image.h"

typedef struct frame_camera {
  camera_file file; /* pixels are counted from the display window's corner */
  int mirrored;     /* 1: z of its world changed its sign (header_camera.h) */
  int placed;       /* 1: its position and direction are known */
  int fitted;       /* 1: no file has it; positions tell it (fitted_camera.h) */
  const char *from; /* where it was found, for messages */
  char lens[160];   /* what --fov or --orthographic replaced; "": nothing */
} frame_camera;

/* FRAME.json for FRAME.exr; malloc'd, NULL if memory runs out. */
char *camera_file_beside(const char *frame);

/* The same camera as the library takes it. */
void camera_file_to_hbil(const camera_file *file, hbil_camera *out);

/*
 * Finds the camera of a frame: the JSON file `override` if it is not NULL, else
 * FRAME.EYE.json for an eye of a multi-view file, else FRAME.json, else the
 * header's matrices, else the one that the map's positions tell (also if
 * `override` is "positions"), else the options --fov and --orthographic, which
 * also replace the lens of any other (out->lens).  *file: NULL before; it
 * becomes the JSON file that was read, malloc'd, if one was (file may be NULL).
 * Returns 0, or -1 with `error` filled.
 */
int frame_camera_read(const char *frame, const image *header,
                      const channel_map *map, const char *override,
                      const source_options *options, frame_camera *out,
                      char **file, image_error *error);

/*
 * Fits the camera to the pixels of the map's window (*out) and stores it in the
 * map for conversions.  Returns 0, or -1 with `error` filled if the camera is
 * for another size, or if a conversion needs something unknown about it.
 */
int frame_camera_aim(const char *frame, const frame_camera *seen,
                     channel_map *map, camera_file *out, image_error *error);

/* Whether both cameras are of one kind, since a plan has one projection.  0, or
 * -1 with `error` filled.  first: the camera of the frame `of`. */
int frame_camera_same_projection(const char *frame, const camera_file *camera,
                                 const char *of, const camera_file *first,
                                 image_error *error);

#endif
