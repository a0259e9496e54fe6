/*
 * Dumps of the project's own scenes, in any layout: a scene is traced, written
 * as a renderer would write it, and read back the way the program reads it.
 *
 * The usual order: dump_begin(), dump_add_ functions, dump_reading(),
 * comparisons, dump_done().  A program that is linked with this has its main(),
 * which runs the tests in a folder for dumps.
 */
#ifndef HBIL_TEST_DUMP_FILE_H
#define HBIL_TEST_DUMP_FILE_H

#include "test/support/compare.h"

#include "scene/scene.h"
#include "dump/frame_camera.h"
#include "dump/frame_check.h"
#include "dump/read_channel_map.h"
#include "dump/read_gbuffer.h"
#include "dump/settle.h"
#include "tool/source_arguments.h"

/* Size of the dumps of dump_begin(). */
enum { WIDTH = 120, HEIGHT = 68, PIXELS = WIDTH * HEIGHT };

/* Coordinate systems in which renderers write vectors. */
typedef enum axes {
  AXES_WORLD,
  AXES_MIRRORED,   /* a left-handed world, with x negated */
  AXES_OPENGL,     /* camera: y up, z backwards */
  AXES_LEFT_HANDED /* camera: y up, z forwards */
} axes;

/* A scene's frame and the file that is made of it. */
typedef struct dump {
  scene_frame s;
  image img;
  source_options options;
  char path[128];
  int json;         /* whether a camera file is written beside it */
  double near, far; /* the camera file's clipping planes; 0: it has none */
} dump;

/* The folder of all dumps, which main() creates and removes. */
extern char dump_folder[];

/* Whether scenes are seen by an orthographic camera. */
extern int dump_orthographic;
int dump_see_orthographic(void **state);
int dump_see_perspective(void **state);
/* Begins a test that holds for one of the cameras, or for both. */
#define TEST_WITH_ORTHOGRAPHIC_CAMERA(name)                                    \
  TEST_WITH(name, dump_see_orthographic, dump_see_perspective)
#define TEST_WITH_BOTH_CAMERAS(name)                                           \
  static void name(void **state);                                              \
  static void name##_flat(void **state) {                                      \
    name(state);                                                               \
  }                                                                            \
  TEST_ADD(name##_flat, #name " (orthographic)", dump_see_orthographic,        \
           dump_see_perspective)                                               \
  TEST(name)

/* --- writing --- */

dump dump_begin(scene_kind kind);
/* lens: vertical angle of view in radians, or the width in world units of an
 * orthographic picture; 0: the scene's own. */
dump dump_begin_sized(scene_kind kind, uint32_t width, uint32_t height,
                      double lens);
/* Begins with hbil's own channels depth and normal, which leave nothing to
 * guess. */
dump dump_begin_plain(scene_kind kind);
void dump_end(dump *d);

size_t dump_pixels(const dump *d);
int dump_is_sky(const dump *d, size_t i);
/* Length of a pixel's ray between planes of depth that are 1 apart. */
double dump_ray_length(const dump *d, size_t i);

extern const char *const letters_xyz[],
    *const letters_rgb[], *const letters_small_rgb[], *const letters_words[];

/* Adds the channel PASS.LETTER, all zero. */
float *dump_add_plane(dump *d, const char *pass, const char *letter);
/* The channel of that name, which must be there. */
float *dump_plane(dump *d, const char *name);
/* Planar depth times `scale`; `sky` where there is no surface. */
void dump_add_depth(dump *d, const char *pass, const char *letter, double scale,
                    float sky);
/* Distance along the ray from the plane `near`. */
void dump_add_ray(dump *d, const char *pass, const char *letter, double near,
                  float sky);
/* Directions (w = 0) or points (w = 1) of the world in other axes. */
void dump_add_vectors(dump *d, const char *pass, const char *const letters[3],
                      float *const in[3], axes a, double w);
/* A colour times `scale` and, unless NULL, times another colour. */
void dump_add_colour(dump *d, const char *pass, const char *const letters[3],
                     float *const in[3], float *const times[3], double scale);
/* Adds worldToCamera and worldToNDC to the header, and leaves out the camera
 * file.  The projection's x and y are scale times the slope, or the world units
 * of an orthographic picture, to the right and up, plus `middle`.  rows: the
 * matrices are stored for row vectors. */
void dump_add_matrices(dump *d, axes world, axes camera, double scale_x,
                       double scale_y, const double middle[2], int rows);
/* Writes the file and the camera beside it. */
void dump_write(dump *d);

/* --- reading --- */

typedef struct reading {
  channel_map map;
  frame_camera seen;
  camera_file camera;
  hbil_config config;
  gbuffer g;
  findings guessed;
  frame_check check;
} reading;

/* 0, or nonzero and an error. */
int dump_try_reading(const dump *d, reading *r, image_error *error);
/* Must succeed. */
reading dump_read(const dump *d);
/* Writes it first. */
reading dump_reading(dump *d);
void reading_free(reading *r);
/* Frees the reading and the dump. */
void dump_done(dump *d, reading *r);

/* Largest relative error of depth; infinite where surface and sky differ. */
double reading_depth_error(const dump *d, const reading *r);
/* Largest difference of a colour, where `counts` (NULL: everywhere) is above
 * 0. */
double reading_colour_error(const dump *d, const reading *r, role which,
                            float *const wanted[3], double scale,
                            const float *const counts[3]);
/* Difference relative to `b`, or absolute where that is below 1. */
double relative_difference(double a, double b);

void assert_no_findings(const reading *r);
/* Projection, depth, normals and camera are those of the scene, to `most`:
 * about ten roundings of floats for a conversion, more where float matrices
 * that are inverted and multiplied describe the camera. */
#define ROUNDING 2e-6
#define MATRIX_ROUNDING 2e-5
void assert_same_geometry(const dump *d, const reading *r, double most);
void assert_same_light(const dump *d, const reading *r);

#endif
