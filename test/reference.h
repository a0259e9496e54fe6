/*
 * Every pass of hbil once more, on the CPU, plainly: what the kernels are held
 * against.  Double precision, except for the two reprojections, which are
 * specified in float to the last bit (compile with -ffp-contract=off).
 *
 * The gather is written with points, directions and angles (METHOD section 2),
 * not with the slopes that the kernels use.  Planes are full resolution; there
 * are no layers here beyond the choice of each pixel's sampling pattern.
 */
#ifndef HBIL_TEST_REFERENCE_H
#define HBIL_TEST_REFERENCE_H

#include <stdbool.h>

#include "hbil/hbil.h"
#include "hbil_shared.h"

/* `count` planes of width x height values, plane after plane. */
typedef struct ref_planes {
  int width, height, count;
  double *values;
} ref_planes;

/* All zero.  Ends the program when out of memory. */
ref_planes ref_planes_new(int width, int height, int count);
void ref_planes_free(ref_planes *planes);
double *ref_at(const ref_planes *planes, int plane, int x, int y);

/* First planes of the inputs and of the outputs of a frame. */
enum {
  REF_DEPTH = 0,
  REF_NORMAL = 1,
  REF_ALBEDO = 4,
  REF_F0 = 7,
  REF_DIRECT = 10,
  REF_EMISSION = 13,
  REF_MOTION = 16,
  REF_INPUT_PLANES = 18
};
enum {
  REF_NEAR = 0,
  REF_FAR = 3,
  REF_AO = 6,
  REF_BENT = 7,
  REF_CONE = 10,
  REF_INDIRECT = 11,
  REF_RADIANCE = 14,
  REF_OUTPUT_PLANES = 17
};

/* What the frame's surfaces send on average: sums over every 4th pixel in x and
 * y of (sqrt L, 1) times the order-2 polynomials of the turned normal. */
typedef struct ref_estimate {
  double sum[4][9];
} ref_estimate;

/* All that a pass may look at besides the planes it is handed.  An input that
 * does not exist is NULL. */
typedef struct ref_job {
  const hbil_config *config;
  hbil_camera camera, previous;
  const float *input[REF_INPUT_PLANES];
  float environment[9][3];
  unsigned index;
  ref_estimate estimate; /* for the FRAME settings: ref_estimate_frame() */
} ref_job;

/* The pattern and view that the specification derives from a job. */
hbil_pattern_args ref_pattern(const ref_job *job);
hbil_view_args ref_view(const hbil_config *config, const hbil_camera *camera);

/* HISTORY -> CARRIED, by scatter or motion as configured. */
void ref_reproject(const ref_job *job, const ref_planes *history,
                   ref_planes *carried);
/* Fills the holes of CARRIED. */
void ref_push_pull(ref_planes *carried);
/* Inputs and CARRIED (NULL: no history) -> SPLIT. */
void ref_split(const ref_job *job, const ref_planes *carried,
               ref_planes *split);
/* SPLIT -> the job's estimate, which the passes below look at where refused or
 * far light comes from the frame. */
void ref_estimate_frame(ref_job *job, const ref_planes *split);
/* The frame's mean radiance towards a receiver of that normal. */
double ref_frame_light(const ref_job *job, int channel, const double normal[3]);
/* SPLIT -> GATHERED. */
void ref_gather(const ref_job *job, const ref_planes *split,
                ref_planes *gathered);
/*
 * The same without sampling error: equally spaced slices, each crossing every
 * pixel of its line: in every column (every row where the line is steep in
 * pixels) the one pixel whose centre is nearest.  So each pixel of a column
 * owns the directions through its own cell: none is left out, none is counted
 * twice.  It is looked at in its centre, at its true offset.  Occluders of
 * finite thickness cover intervals here, not sectors.
 */
typedef struct ref_dense {
  int slices;         /* any number from 1; 256 or more for an exact result */
  bool equal_weights; /* leaves the slices' weight J out, which is wrong */
  int threads;        /* 0: two */
  /* One byte per pixel, 0: leave the pixel out (its values stay as they are);
   * NULL: every pixel. */
  const unsigned char *wanted;
  /* Called now and then from the calling thread with the rows that are done;
   * may be NULL. */
  void (*progress)(void *user, int done, int count);
  void *user;
} ref_dense;

void ref_gather_dense(const ref_job *job, const ref_planes *split,
                      const ref_dense *how, ref_planes *gathered);
/* Whether a pixel's slice is weighed against its neighbours': GATHERED has
 * HBIL_LIGHT_WEIGHT then, which is 0 otherwise. */
bool ref_weighs_slices(const hbil_config *config);

/* What a pixel counts beside another in recompose's filter, by depth and
 * normal; 0 where either shows no surface. */
double ref_guide(const ref_job *job, const ref_planes *split, int x, int y,
                 int dx, int dy);
/* SPLIT, GATHERED -> RESOLVED. */
void ref_recompose(const ref_job *job, const ref_planes *split,
                   const ref_planes *gathered, ref_planes *resolved);
/* RESOLVED -> outputs and the next frame's HISTORY. */
void ref_composite(const ref_job *job, const ref_planes *resolved,
                   ref_planes *out, ref_planes *history);

/* A sequence of frames: the planes of the last one, and its camera. */
typedef struct ref_state {
  bool has_history;
  hbil_camera camera;
  ref_planes history, carried, split, gathered, resolved, out;
} ref_state;

void ref_state_init(ref_state *state, int width, int height);
void ref_state_free(ref_state *state);
/* Runs all passes; job->previous comes from the state. */
void ref_frame(ref_state *state, ref_job *job);
/* The same with the dense gather, and without the 4x4 pattern's filter, which
 * it doesn't need. */
void ref_frame_dense(ref_state *state, ref_job *job, const ref_dense *how);

/* Order-2 real spherical harmonics at a unit direction, hbil's order. */
void ref_sh_basis(const double d[3], double y[9]);

#define PI 3.14159265358979323846

#endif
