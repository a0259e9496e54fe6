/*
 * The renderer that test_adopter stands for: TAP, its OpenCL device, the planes
 * of its scene, and how it hands frames to hbil.  Like test_adopter it has the
 * public headers of hbil alone.
 */
#ifndef TEST_SYSTEM_ADOPTER_RENDERER_H
#define TEST_SYSTEM_ADOPTER_RENDERER_H

#include <hbil/hbil_stages.h>

#include "test/system/adopter_scene.h"

/* --- TAP --- */

/* Prints a result with its name. */
__attribute__((format(printf, 2, 3))) void check(bool good, const char *format,
                                                 ...);
void skip_check(const char *name, const char *reason);

/* Prints how many results there are; the value for main() to return. */
int finish_checks(void);

/* End the program unless what it can't go on without is there. */
void need(bool good, const char *what);
void succeed(hbil_status status, const char *what);

/* Whether a call failed as it should, with a message that has a word. */
bool fails(hbil_status got, hbil_status want, const hbil_context *with,
           const char *word);

/* --- the renderer --- */

/* What the renderer has for as long as it runs. */
typedef struct renderer {
  cl_context context;
  cl_device_id device;
  cl_command_queue queue;        /* in order */
  cl_command_queue out_of_order; /* NULL: the device has none */
  hbil_context *hbil;
  /* the planes of `drawn` */
  cl_mem depth, normal, albedo, direct;
  cl_mem normal_rgb10, albedo_rgb8, direct_rgb9e5;
  cl_mem target; /* a picture */
} renderer;

/* What frames compute, in one buffer.  The first three channels of `light` are
 * the near irradiance, and the fourth is ao; that of `beauty` is not written.
 */
typedef struct picture {
  plane light, beauty;
} picture;

extern renderer self;
extern scene drawn;   /* as the camera that looks down sees it */
extern picture shown; /* by the last frames that were read */

/* ADOPTER_DEVICE=K in the environment is the K-th device of all platforms, from
 * 0 on, which is the default. */
void open_renderer(void);
void close_renderer(void);

/* A buffer of `size` bytes that holds `data` (NULL: anything), which the caller
 * releases. */
cl_mem make_buffer(cl_mem_flags flags, size_t size, void *data);

/* --- frames --- */

/* What the renderer hands to hbil, and what it gets. */
typedef struct lighting {
  hbil_config config;
  hbil_frame frame;
  hbil_plan *plan;
  hbil_statistics statistics;
  hbil_sanitized sanitized;
} lighting;

/* What most checks begin with, without a plan: planes of four floats. */
lighting usual(void);

/* Sets the frame's camera. */
void look(lighting *l, const pose *from, const convention *with);

void make_plan(lighting *l);
void free_plan(lighting *l);

void enqueue(lighting *l);
void read_picture(picture *out);

/* Runs some frames and reads picture and figures of the last one. */
void run_frames(lighting *l, int count);

/* The first frames of a plan that is gone afterwards. */
void run_once(lighting *l, int count);

/* Whether what is shown has the same bits. */
bool shows(const picture *want);

/* --- stages --- */

/* The first value of each pixel in a stage of full resolution. */
void read_stage(const lighting *l, hbil_stage stage, float out[PIXELS]);

/* From one plan to another one of the same configuration. */
void copy_stage(const lighting *from, const lighting *to, hbil_stage stage);

#endif
