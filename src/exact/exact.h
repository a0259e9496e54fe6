/*
 * The exact integral: every pass of the method in double precision, on the CPU.
 *
 * The program and the bench run whole frames with it (exact_run_frame_dense())
 * to learn what the model's result is when nothing is sampled.  The tests hold
 * each kernel against the pass of the same name (exact/passes.h).
 *
 * It is written for clarity, not speed: directions and angles where the kernels
 * have slopes, full-resolution planes where the kernels have 4x4 layers.  Only
 * reprojection is in single precision, because its roundings are part of its
 * specification.  Compile with -ffp-contract=off.
 *
 * Nothing here prints or ends the process.  A function that can fail returns an
 * exact_status; what it was to fill then holds no result.  No function needs an
 * OpenCL device.  Functions may run in several threads at once, on different
 * objects.
 */
#ifndef HBIL_EXACT_H
#define HBIL_EXACT_H

#include <stdbool.h>
#include <stddef.h>

#include "hbil/hbil.h"

typedef enum exact_status {
  EXACT_SUCCESS = 0,
  EXACT_OUT_OF_MEMORY,
  EXACT_BAD_ARGUMENT /* a size or count out of range, or planes of sizes or
                        counts that do not go together */
} exact_status;

/* "out of memory" and the like; a constant string. */
const char *exact_status_text(exact_status status);

/* ------------------------------------------------------------------------ */
/* Planes                                                                    */

/* `count` planes of width x height values, plane after plane, top row first. */
typedef struct exact_planes {
  int width, height, count;
  double *values; /* owned; NULL in planes that were never created, or freed */
} exact_planes;

/* All values zero.  width, height and count: 1 or more.  Leaves empty planes,
 * which may be freed, if it fails. */
exact_status exact_planes_create(exact_planes *planes, int width, int height,
                                 int count);
void exact_planes_free(exact_planes *planes);
/* The address of a value; nothing is checked. */
static inline double *exact_at(const exact_planes *planes, int plane, int x,
                               int y) {
  const size_t row = (size_t)plane * (size_t)planes->height + (size_t)y;
  return planes->values + row * (size_t)planes->width + (size_t)x;
}

/* ------------------------------------------------------------------------ */
/* Frames                                                                    */

/* A frame's input planes: the first one of each input. */
enum {
  EXACT_DEPTH = 0,
  EXACT_NORMAL = 1,    /* x, 2: y, 3: z */
  EXACT_ALBEDO = 4,    /* red, 5: green, 6: blue; so are those that follow */
  EXACT_F0 = 7,        /* reflectance at normal incidence */
  EXACT_DIRECT = 10,   /* direct light, before direct_scale */
  EXACT_EMISSION = 13, /* radiance */
  EXACT_MOTION = 16,   /* x, 17: y, before motion_scale */
  EXACT_INPUT_PLANES = 18
};

/* The output planes: the first one of each output.  Units as in hbil_config. */
enum {
  EXACT_NEAR_IRRADIANCE = 0,
  EXACT_FAR_IRRADIANCE = 3,
  EXACT_AO = 6,
  EXACT_BENT_NORMAL = 7,
  EXACT_CONE_COSINE = 10,
  EXACT_INDIRECT = 11,
  EXACT_BEAUTY = 14,
  EXACT_ERROR_ESTIMATE = 17, /* of AO, 18: of E_near */
  EXACT_UNKNOWN = 19,
  EXACT_GLOSSY = 20,
  EXACT_OUTPUT_PLANES = 23
};

/* What the frame's surfaces send on average (estimate.c): sums over an eighth
 * of the pixels of nine polynomials, times radiance after all bounces, and
 * times 1; the radiance that near light lacks of that; and what the sky does
 * not light of the open directions where the sun shines, and whether it does
 * (0..1). */
typedef struct exact_estimate {
  double light[3][9], weight[9];
  double lacks[3];
  double unlit, sun;
} exact_estimate;

/* What a radiance cache knows around a frame (exact/cache.h). */
struct exact_probes;

/* A frame as the passes see it.  All pointers are the caller's. */
typedef struct exact_frame {
  const hbil_config *config;
  hbil_camera camera;
  hbil_camera previous; /* of the frame before; exact_run_frame() sets it */
  /* config->width x config->height values each, whatever the formats of the
   * configuration: normals in three channels, and planar depth in place of
   * hardware depth.  Depth and normal are needed,
   * motion for HBIL_REPROJECTION_MOTION; of the others all planes may be NULL:
   * albedo is then 1, and everything else 0. */
  const float *input[EXACT_INPUT_PLANES];
  float environment[9][3]; /* as hbil_frame has it */
  float sky_share;         /* as hbil_frame has it */
  float exposure;          /* as hbil_frame has it */
  /* Of AO and E_near: error_estimate over the standard deviation of what
   * recompose averages.  They are measured figures of the library. */
  double error_factors[2];
  unsigned frame_index;    /* rotates the sampling pattern */
  exact_estimate estimate; /* exact_run_frame() sets it, and `bounces`: how */
  unsigned bounces;        /* often the carried light was carried over */
  const struct exact_probes *probes; /* NULL: there is no radiance cache */
} exact_frame;

/* How the exact gather runs. */
typedef struct exact_dense {
  int slices;         /* 1 or more; 256 or more for an exact result */
  bool equal_weights; /* weighs all slices alike, which is a bias at wide fields
                         of view; for a test that shows it */
  bool at_centres;    /* samples are the centres of pixels, beside the line of
                         the slice: what a plan comes to with ever more steps,
                         however few pixels there are */
  int threads;        /* 0: one for each CPU */
  /* One byte per pixel; pixels whose byte is 0 are left out, and their values
   * stay as they are.  NULL: every pixel. */
  const unsigned char *mask;
  /* Called in the calling thread now and then, with the rows that are done.
   * May be NULL. */
  void (*progress)(void *user, int done, int count);
  void *user;
} exact_dense;

/* ------------------------------------------------------------------------ */
/* Sequences of frames                                                       */

/* The planes of a sequence's last frame, and its camera.  The planes' layouts
 * are those of kernels/shared.h; `out` has EXACT_OUTPUT_PLANES. */
typedef struct exact_state {
  bool has_history; /* the next frame reprojects `history` */
  unsigned bounces; /* that the light of `history` has had */
  hbil_camera camera;
  exact_planes history, carried, split, gathered, resolved, out;
} exact_state;

/* A sequence without history.  Leaves an empty state, which may be freed, if it
 * fails. */
exact_status exact_state_create(exact_state *state, int width, int height);
void exact_state_free(exact_state *state);

/* Runs all passes with the settings' sampling pattern.  The frame has the
 * state's size.  After a failure the state's planes are of no use until
 * has_history is false. */
exact_status exact_run_frame(exact_state *state, exact_frame *frame);
/* The same with the exact gather.  The filter of recompose is left out, because
 * there is no 4x4 pattern to hide. */
exact_status exact_run_frame_dense(exact_state *state, exact_frame *frame,
                                   const exact_dense *how);

/* ------------------------------------------------------------------------ */
/* Time                                                                      */

/* CPUs of this machine that are online, 1 to 1024. */
int exact_cpu_count(void);

/* Predicts how many seconds exact_gather_dense() takes for so many pixels of a
 * frame, on all CPUs, from a pilot run over some 400 of them.  0 where that
 * cannot be told: out of memory, for instance. */
double exact_predict_seconds(const exact_frame *frame, int slices,
                             size_t pixels);

#endif
