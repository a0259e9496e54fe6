/*
 * A plan with everything around it: its configuration, a frame, the planes on
 * the device and the same input values for the exact integral.
 *
 * The usual order: one of the setup_ functions that prepare, changes of
 * `config` and `input`, setup_start(), setup_run(), setup_free().
 */
#ifndef HBIL_TEST_FIXTURE_H
#define HBIL_TEST_FIXTURE_H

#include "test/support/compare.h"
#include "test/support/device.h"
#include "test/support/layout.h"

#include "scene/scene.h"

/* In a function that spoils a struct in the way `which`, an int, and returns
 * the field that a message must name: one way. */
#define SPOIL(field, statement)                                                \
  do                                                                           \
    if (which-- == 0) {                                                        \
      statement;                                                               \
      return field;                                                            \
    }                                                                          \
  while (0)

/* Formats of planes of floats. */
extern const hbil_plane_format one_float, three_floats;

typedef struct setup {
  device_fixture *device;
  hbil_config config;
  hbil_frame frame;
  hbil_plan *plan;
  plane_layout layout[PLANE_COUNT];
  size_t bytes[PLANE_COUNT];
  float *input[EXACT_INPUT_PLANES];
  exact_frame job; /* for the exact integral; setup_upload() updates it */
} setup;

/* --- preparing --- */

/* Inputs: float depth, normal, albedo, direct, emission and motion, all zero.
 * Outputs: near_irradiance, ao and bent_normal.  The paper's model with 2 x 8
 * samples a side, stored as floats.  The camera has a vertical field of view of
 * 60 degrees. */
void setup_init(setup *s, int width, int height);
/* The same with the inputs and the camera of a scene's frame. */
void setup_scene(setup *s, scene_kind kind, int width, int height,
                 uint32_t index);
/* A plan with every pass and every skip that compiles fast: packed, all
 * outputs, unseen light estimated.  vector_width 0: the device's own. */
void setup_every_pass(setup *s, hbil_reprojection reprojection,
                      cl_uint vector_width, int width, int height);
/* All outputs, as planes of floats, but for glossy. */
void setup_all_outputs(setup *s);
/* No output at all. */
void setup_no_outputs(setup *s);
/* A mode, without the outputs that it doesn't have. */
void setup_mode(setup *s, hbil_mode mode);

/* --- inputs and camera --- */

/* Replaces camera and inputs by those of another frame of the scene, in the
 * configured projection. */
void setup_load_scene(setup *s, scene_kind kind, uint32_t index);
/* The same with another vertical field of view. */
void setup_load_view(setup *s, scene_kind kind, double fov_y_degrees,
                     uint32_t index);
/* A camera at the origin that looks along +z. */
void setup_camera(setup *s, double fov_y_degrees);
/* Makes the camera orthographic, `width` world units wide, until another camera
 * is loaded.  The planes stay as they are. */
void setup_flatten(setup *s, double width);
/* The ray through a pixel's centre: z is 1, for either projection. */
void setup_ray(const setup *s, int x, int y, double ray[3]);
/* Fills an input plane (EXACT_DEPTH...). */
void setup_fill(setup *s, int plane, float value);
/* The plane through (0, 0, 3) with that normal, as depth and normals; sky where
 * it lies behind the eye or beyond the largest half float. */
void setup_plane(setup *s, const double normal[3]);
/* A unit normal that is tilted away from the eye, in radians. */
void tilted_normal(double tilt, double azimuth, double normal[3]);
size_t setup_pixels(const setup *s);
/* Bytes of device memory that a plan of the configuration takes. */
size_t setup_memory(const setup *s);

/* --- running --- */

/* Creates the plan and the buffers, which must succeed, then uploads.  The plan
 * launches no kernel until it is run, because most tests run few of a plan's
 * kernels, and PoCL compiles those that are launched. */
void setup_start(setup *s);
/* The same, with the trial launches that plans make for programs. */
void setup_start_compiled(setup *s);
/* Writes the inputs to the device and replaces them by what the device sees:
 * the values after rounding to the plane's format. */
void setup_upload(setup *s);
void setup_free(setup *s);

typedef hbil_status enqueue_function(hbil_plan *, cl_command_queue,
                                     const hbil_frame *, cl_uint,
                                     const cl_event *, cl_event *);
/* One pass each, as hbil_enqueue_frame() enqueues all of them. */
enqueue_function enqueue_reproject, enqueue_push_pull, enqueue_split,
    enqueue_gather, enqueue_recompose, enqueue_composite;
enum { PASSES = 6 };
/* These, in their order. */
extern enqueue_function *const passes[PASSES];
/* Enqueues a pass or a frame and waits; must succeed. */
void setup_run(setup *s, enqueue_function *pass);
/* hbil_last_frame.bounces of the plan. */
cl_uint setup_bounces(const setup *s);
/* Fails with the context's message unless `status` is HBIL_SUCCESS. */
void assert_success(const setup *s, hbil_status status);

/* All outputs (EXACT_OUTPUT_PLANES planes); 0 where the plan has no such
 * output. Fails when a byte outside a plane was written. */
exact_planes outputs_read(setup *s);
/* Those of the next frame, which must succeed. */
exact_planes frame_outputs(setup *s);
/* Ends the setup, too. */
exact_planes last_outputs(setup *s);
/* Starts, and returns those of the first frame. */
exact_planes first_outputs(setup *s);
/* Compares every output of the plan with `want`: relative RMSE of at most 1e-4
 * (measured: 9.1e-6 at 3 x 5 pixels); 1e-3 for the cone's cosine (3.5e-4),
 * whose sqrt(1 - AO) has half of the digits left where AO is 1. */
void check_frame_outputs(setup *s, const exact_planes *want);

#endif
