/*
 * What the test programs share: an OpenCL device, a plan with its images on
 * both sides, planes in and out of buffers, and measures of difference.
 *
 * A missing OpenCL device ends the program with status 99: it is an error of
 * the set-up, never a reason to skip.
 */
#ifndef HBIL_TEST_SUPPORT_H
#define HBIL_TEST_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "checked_exact.h"
#include "scene/scene.h"

/* ------------------------------------------------------------------------ */
/* Device                                                                    */

typedef struct gpu {
  cl_device_id device;
  cl_context context;
  cl_command_queue queue;
  hbil_context *hbil;
} gpu;

/* PoCL's device if there is one, else the first of any platform. */
gpu gpu_open(void);
void gpu_close(gpu *g);
/* Runs a group of tests between the opening and closing of `test_gpu`; the
 * value for main() to return. */
#define RUN_WITH_GPU(tests)                                                    \
  (test_gpu = gpu_open(),                                                      \
   gpu_finish(cmocka_run_group_tests((tests), NULL, NULL)))
extern gpu test_gpu;
int gpu_finish(int failures);

/* ------------------------------------------------------------------------ */
/* Images                                                                    */

typedef enum image_id {
  PLANE_DEPTH,
  PLANE_NORMAL,
  PLANE_ALBEDO,
  PLANE_F0,
  PLANE_DIRECT,
  PLANE_EMISSION,
  PLANE_MOTION,
  PLANE_NEAR,
  PLANE_FAR,
  PLANE_AO,
  PLANE_BENT,
  PLANE_CONE,
  PLANE_INDIRECT,
  PLANE_BEAUTY,
  PLANE_COUNT
} image_id;

#define PLANE_FIRST_OUTPUT PLANE_NEAR

const char *image_name(image_id id);
int image_channels(image_id id);
/* First plane, of inputs (EXACT_DEPTH...) or outputs
 * (EXACT_NEAR_IRRADIANCE...). */
int image_first(image_id id);
hbil_plane_format *image_format(hbil_config *config, image_id id);
hbil_plane *image_slot(hbil_frame *frame, image_id id);

/* Room left around an image, in components. */
typedef struct image_layout {
  size_t offset, row_extra, plane_extra;
} image_layout;

/* ------------------------------------------------------------------------ */
/* A plan and all around it                                                  */

typedef struct setup {
  gpu *gpu;
  hbil_config config;
  hbil_frame frame;
  hbil_plan *plan;
  image_layout layout[PLANE_COUNT];
  size_t bytes[PLANE_COUNT];
  float *input[EXACT_INPUT_PLANES];
  exact_frame job; /* for the reference; kept up to date by setup_upload() */
} setup;

/* fp32 depth, normal, albedo, direct, emission, motion; planar motion; outputs
 * near_irradiance, ao and bent; a camera with a vertical field of view of 60
 * degrees. */
void setup_init(setup *s, int width, int height);
/* The same, and the inputs of a scene's frame. */
void setup_scene(setup *s, scene_kind kind, int width, int height,
                 uint32_t index);
/* Replaces camera and inputs by those of another frame of the scene, in the
 * config's projection. */
void setup_load_scene(setup *s, scene_kind kind, uint32_t index);
/* The same with another vertical field of view. */
void setup_load_view(setup *s, scene_kind kind, double fov_y_degrees,
                     uint32_t index);
/* Camera looking along +z from the origin. */
void setup_camera(setup *s, double fov_y_degrees);
/* What the planes hold is seen by an orthographic camera instead, in a picture
 * that is so many world units wide; until the camera is loaded anew. */
void setup_flatten(setup *s, double width);
/* All outputs, fp32 with the channel count as stride. */
void setup_all_outputs(setup *s);
/* A plan of every pass and every skip that is as cheap as can be: packed, all
 * outputs, unseen light estimated.  vector_width 0: the device's own. */
void setup_every_pass(setup *s, hbil_reprojection reprojection,
                      cl_uint vector_width, int width, int height);
void setup_fill(setup *s, int plane, float value);
/* Creates plan and buffers (must succeed), then uploads. */
void setup_start(setup *s);
/* Brings inputs to the device and replaces them by what the device sees:
 * the values after rounding to the image's format. */
void setup_upload(setup *s);
void setup_free(setup *s);

typedef hbil_status enqueue_function(hbil_plan *, cl_command_queue,
                                     const hbil_frame *, cl_uint,
                                     const cl_event *, cl_event *);
/* Enqueues and waits; must succeed. */
void setup_run(setup *s, enqueue_function *pass);
void assert_success(const setup *s, hbil_status status);

/* A stage's planes in full resolution; written planes leave padding alone.
 * Packed ones are decoded and encoded on the way: whatever the storage, the
 * planes are those of FLOAT32. */
exact_planes stage_read(setup *s, hbil_stage stage);
void stage_write(setup *s, hbil_stage stage, const exact_planes *planes);

/* The words of packed storages in double, from their description in
 * shared.h alone. */
uint32_t encode_normal(const double n[3]);
void decode_normal(uint32_t word, double n[3]); /* unit length */
/* What a mantissa of so many bits counts, where the largest channel is `most`.
 */
double packed_unit(double most, int bits);
/* A float of 5 exponent bits and so many of mantissa, without sign; encoded to
 * the nearest, which is never infinite. */
double decode_small(uint32_t bits, int mantissa);
uint32_t encode_small(double value, int mantissa);

/* GATHERED of the split inputs, its mean over frames of index 0..turns-1, which
 * turn the pattern: a plan has 32 slices at most, this has `turns` times as
 * many. */
exact_planes gathered_over_turns(setup *s, int turns);
/* All outputs (EXACT_OUTPUT_PLANES); fails when a byte outside the image was
 * touched.  Outputs without format stay 0. */
exact_planes outputs_read(setup *s);
/* Every byte of a plan's buffer or a caller's image; the caller frees. */
unsigned char *buffer_bytes(setup *s, cl_mem buffer, size_t *size);
cl_mem buffer_new(gpu *g, size_t size, const void *bytes);

/* ------------------------------------------------------------------------ */
/* Numbers                                                                   */

/* Root of the mean squared difference over planes [first, first + count),
 * relative to the reference's root mean square; infinite when `got` holds a
 * value that is not finite. */
double relative_rmse(const exact_planes *got, const exact_planes *want,
                     int first, int count);
/* Largest difference. */
double largest_error(const exact_planes *got, const exact_planes *want,
                     int first, int count);
double largest_value(const exact_planes *planes, int first, int count);
/* Number of values that differ. */
size_t count_different(const exact_planes *got, const exact_planes *want);

/* Form factors of so many rows of a layer, of all that it has. */
void setup_keep_rows(setup *s, size_t rows, size_t of);

/* Fails above the limit; with HBIL_TEST_VERBOSE set, tells the value. */
void check_at_most(const char *what, double value, double limit);

/* A seeded generator: uniform in [0,1). */
typedef struct random_state {
  uint64_t state;
} random_state;
double random_unit(random_state *r);

float half_to_float(uint16_t half);
uint16_t float_to_half(float value);

/* Every output that the plan has against the reference's.  Relative RMSE at
 * most 1e-4 (the requirement is 1e-3; measured: 9.1e-6 at 3x5 pixels), of the
 * cone, whose sqrt(1 - AO) keeps half of the digits where AO is 1, 1e-3
 * (3.5e-4). */
void check_frame_outputs(setup *s, const exact_planes *want);

/* ------------------------------------------------------------------------ */
/* Vectors                                                                   */

double dot(const double a[3], const double b[3]);
void cross(const double a[3], const double b[3], double out[3]);
/* a + s b */
void add(const double a[3], double s, const double b[3], double out[3]);
void normalize(double v[3]);

#endif
