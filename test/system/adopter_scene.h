/*
 * What test_adopter has for a renderer: a ray caster that draws a G-buffer on
 * the host, and the matrices that such a renderer has for its camera.
 *
 * The scene: a grey floor, a bluish back wall, a brightly lit red wall on the
 * left, a green ball on the floor, and sky above the walls.  The world's y is
 * up.  Depth is that of a depth buffer, reversed, without a far plane.
 */
#ifndef TEST_SYSTEM_ADOPTER_SCENE_H
#define TEST_SYSTEM_ADOPTER_SCENE_H

#include <hbil/hbil.h>

#include <stdbool.h>

enum { WIDTH = 160, HEIGHT = 96, PIXELS = WIDTH * HEIGHT };

#define NEAR_PLANE 0.1 /* world units in front of the eye */

/* Four floats a pixel, as a renderer's textures have them. */
typedef float plane[PIXELS][4];

/* Where the camera stands, and its axes: right, up, forward. */
typedef struct pose {
  double eye[3];
  double axes[3][3];
} pose;

extern const pose looks_down; /* by 16 degrees */
extern const pose is_level;   /* looks along the world's -z */

typedef struct scene {
  plane depth;      /* the first channel */
  plane normal;     /* world space */
  plane albedo;     /* 0 at the sky */
  plane direct;     /* irradiance; what it is at the sky doesn't matter */
  plane sky_light;  /* emission, if only the sky emits */
  plane wall_light; /* emission, if only the red wall emits */
  plane black;
  /* normal, albedo and direct once more, in words that hold a pixel */
  cl_uint normal_rgb10[PIXELS];
  cl_uint albedo_rgb8[PIXELS];
  cl_uint direct_rgb9e5[PIXELS];
  size_t sky_pixels;
} scene;

void scene_draw(scene *out, const pose *from);

/* The conventions of a renderer's matrices, and what it says of them. */
typedef struct convention {
  double along;    /* view space looks along z: 1, along -z: -1 */
  double up;       /* y of clip space is up: 1, down: -1 */
  double depth[2]; /* z/w of clip space is depth[0] + depth[1] / distance */
  bool by_columns; /* how the matrices lie in memory */
  cl_uint flags;   /* a sum of hbil_matrix_convention */
} convention;

extern const convention opengl; /* after glClipControl() with zero to one */

/* The camera of a frame from a renderer's matrices; as
 * hbil_camera_from_matrices(), which is what it calls. */
hbil_status scene_camera(hbil_frame *frame, const hbil_config *config,
                         const pose *from, const convention *with);

/* The same camera by hbil_camera_from_opengl(). */
void scene_camera_from_pose(hbil_camera *camera, const pose *from);

/* The greatest difference of two cameras' members. */
double scene_camera_distance(const hbil_camera *a, const hbil_camera *b);

#endif
