/*
 * What host C and OpenCL C both read: structs that kernels take by value, the
 * order of planes, and the sampling pattern.
 *
 * The pattern is computed by the same expressions on both sides, with every
 * rounding spelled out (HBIL_FMA, no contraction elsewhere), so a reference on
 * the host visits exactly the pixels that the kernels visit.
 */
#ifndef HBIL_SHARED_H
#define HBIL_SHARED_H

#ifdef __OPENCL_VERSION__
typedef int hbil_int;
typedef uint hbil_uint;
typedef float hbil_float;
#define HBIL_FMA(a, b, c) fma((a), (b), (c))
#define HBIL_RINT(a) rint(a)
#define HBIL_SQRT(a) sqrt(a)
#define HBIL_FABS(a) fabs(a)
#define HBIL_GLOBAL global
#else
#include <CL/cl.h>
#include <math.h>
typedef cl_int hbil_int;
typedef cl_uint hbil_uint;
typedef cl_float hbil_float;
#define HBIL_FMA(a, b, c) fmaf((a), (b), (c))
#define HBIL_RINT(a) rintf(a)
#define HBIL_SQRT(a) sqrtf(a)
#define HBIL_FABS(a) fabsf(a)
#define HBIL_GLOBAL
#endif

/* The image is split into 4x4 interleaved layers (paper, 3.3). */
#define HBIL_SIDE 4
#define HBIL_LAYERS 16

/* Pixels of a layer row that share one reach, which a work-item of the gather
 * takes together on CPUs, and the padding left and right of each layer row: a
 * load of that many which begins anywhere in [-32, width rounded up to 32]
 * stays inside the row. */
#define HBIL_SPAN 32

/* Rows that a work-item of recompose takes on CPUs; a multiple of 4. */
#define HBIL_RECOMPOSE_ROWS 16

/* The most pixels that a vector holds. */
#define HBIL_WIDEST 16

/* Inverse depth of "nothing there": below every tangent plane, whatever the
 * scale of the scene, and far enough from FLT_MAX to take part in sums. */
#define HBIL_NOTHING (-1e30f)

/* Depths nearer than this are no surface, nor those as far as that: the
 * quotient of any two, times the longest ray and over the slope of a pixel, is
 * a float still. */
#define HBIL_NEAREST_DEPTH 1e-15f
#define HBIL_FARTHEST_DEPTH 1e15f

/* Light of an input that is brighter counts as none, like light that is
 * infinite: sums over a hemisphere, and over a picture's roots, are floats. */
#define HBIL_BRIGHTEST 1e30f

/* Normals that look away from the eye are bent back until their cosine with the
 * view direction is this: small enough to leave 89.99 degree planes alone,
 * large enough that the fp32 rounding of a normal (6e-8) is below 1e-3 of it,
 * and that a packed one (6.5e-5 off) still faces the eye. */
#define HBIL_MIN_COSINE 1e-4f

/* Recompose: a neighbour off the pixel's tangent plane by this share of its
 * inverse depth gets no weight, nor does one whose normal has a cosine with the
 * pixel's that is smaller than 1 by the second (33 degrees). */
#define HBIL_PLANE_TOLERANCE 0.02f
#define HBIL_TURN_TOLERANCE 0.16f

/* Finite thickness: sectors of a half-slice.  One less than a word has bits, so
 * that 1 << HBIL_SECTORS is still one. */
#define HBIL_SECTORS 31

/* Planes of the stages (see hbil_plan_buffer() in hbil.h). */
enum {
  HBIL_SPLIT_W = 0,
  HBIL_SPLIT_NORMAL = 1, /* x, 2: y, 3: z */
  HBIL_SPLIT_RED = 4,    /* 5: green, 6: blue */
  HBIL_SPLIT_PLANES = 7
};
enum {
  HBIL_LIGHT_AO = 0,
  HBIL_LIGHT_RED = 1,  /* 2: green, 3: blue: E_near */
  HBIL_LIGHT_BENT = 4, /* x, 5: y, 6: z */
  HBIL_LIGHT_PLANES = 7,
  /* gathered only: share of the hemisphere whose light is unknown */
  HBIL_LIGHT_UNKNOWN = 7,
  /* with a single slice: how much of the hemisphere it stands for, 1 on average
   * (recompose), and 1 with more where a single one could have been chosen;
   * behind all others, whichever there are */
  HBIL_LIGHT_WEIGHT = 8,
  HBIL_GATHERED_PLANES = 9
};
/* The same in words of 32 bits.  HBIL_STORAGE_PACKED:
 *   normal    octahedral (Cigolle and others 2014), two snorm16, x low;
 *             the middle of the map looks along -z
 *   radiance  three mantissas of 8 bits, red lowest; in the highest byte
 *             the exponent of their unit, biased as in a float
 *   AO        unorm16; above it the unknown share, unorm8; in the highest
 *             byte the exponent of the unit of E_near
 *   E_near    three mantissas of 10 bits, red lowest
 *   bent      three snorm: 11 bits x, lowest, 11 bits y, 10 bits z; scaled
 *             to fit where a component is above 1
 * Light is rounded to the nearest.  The unknown share and bent normals are
 * dithered by the pixel's layer, so that the 16 layers together are off by 1/32
 * of a step at most.
 *
 * HBIL_STORAGE_FLOAT11: the same, but
 *   radiance  three floats without sign, 5 bits of exponent (biased by 15)
 *             above 6, 6 and 5 of mantissa: red the lowest 11 bits, green 11,
 *             blue 10
 *
 * HBIL_STORAGE_HALF: the normal is the same word, all else IEEE halves, two to
 * a word, the first one low:
 *   radiance  red, green; blue, 0
 *   gathered  AO, unknown share (or 0); red, green of E_near; its blue, bent x;
 *             bent y, z
 *
 * Values above the largest of a format become that one. */
enum {
  HBIL_PACKED_NORMAL = 1,
  HBIL_PACKED_RADIANCE = 2,
  HBIL_PACKED_SPLIT_PLANES = 3,
  HBIL_HALF_SPLIT_PLANES = 4
};
enum {
  HBIL_PACKED_AO = 0,
  HBIL_PACKED_NEAR = 1,
  HBIL_PACKED_BENT = 2,
  HBIL_PACKED_LIGHT_PLANES = 3
};
enum {
  HBIL_HALF_AO = 0,
  HBIL_HALF_NEAR = 1, /* two words */
  HBIL_HALF_BENT = 3,
  HBIL_HALF_LIGHT_PLANES = 4
};

enum { HBIL_HISTORY_W = 0, HBIL_HISTORY_RED = 1, HBIL_HISTORY_PLANES = 4 };
enum { HBIL_CARRIED_RED = 0, HBIL_CARRIED_WEIGHT = 3, HBIL_CARRIED_PLANES = 4 };

/* What the temporal filter keeps of a frame: what a pixel shows, the number of
 * frames it is the mean of (0: none), and from HBIL_TEMPORAL_LIGHT on the light
 * planes.  The normal is a word of 2 x 16 bits as in packed planes. */
enum {
  HBIL_TEMPORAL_W = 0,
  HBIL_TEMPORAL_NORMAL = 1,
  HBIL_TEMPORAL_FRAMES = 2,
  HBIL_TEMPORAL_LIGHT = 3
};

/* The estimate of unseen light (estimate.cl), and its weight beside what a
 * pixel itself sees, in hemispheres: measured on the public dumps (HACKING.md);
 * local light is the better guess where much is seen, the frame's where little
 * is. */
#define HBIL_UNSEEN_PRIOR 0.45f
enum { HBIL_ESTIMATE_SIZE = 36, HBIL_ESTIMATE_PARTS = 64 };

/* A caller's image, in components. */
typedef struct hbil_external_plane_args {
  hbil_uint offset, row, plane, unused;
} hbil_external_plane_args;

/* Camera and size.  fx, fy: pixels to one unit of the picture's plane, which is
 * one of ray slope; orthographic, a world unit. */
typedef struct hbil_view_args {
  hbil_int width, height;
  hbil_float fx, fy, cx, cy;
  hbil_float inv_fx, inv_fy;
} hbil_view_args;

/* The upper three rows of a rigid transform between two views. */
typedef struct hbil_transform_args {
  hbil_float m[12];
} hbil_transform_args;

/* A full-resolution set of planes, in floats. */
typedef struct hbil_plane_args {
  hbil_uint plane, row;
} hbil_plane_args;

/* Where history planes begin in their buffer; as many floats follow them.  What
 * is loaded for a vector begins and ends there at most: a window of three rows
 * and two vectors (places.clh) that holds a place in the picture, or a row and
 * a pixel before it.  Lanes whose source is not in the picture are masked. */
static inline hbil_uint hbil_history_origin(const hbil_plane_args planes) {
  return 2u * planes.row + 2u * HBIL_WIDEST;
}

/* One level of the push/pull chain: where its planes lie, and its size. */
typedef struct hbil_chain_args {
  hbil_uint offset, plane, row;
  hbil_int width, height;
} hbil_chain_args;

/* A layered set of planes, in floats.  width, height: of a layer.  A row of the
 * image is contiguous, with its four layers one after the other, and in each
 * layer its planes: what a filter reads around a pixel lies on few pages.
 * row_extent: floats of a layer's row in one plane, padding included. */
typedef struct hbil_layer_args {
  hbil_uint plane, layer, row, origin, row_extent;
  hbil_int width, height;
} hbil_layer_args;

/* Half of the samples, every other one, stands for how much fewer samples would
 * find: a sample is in one of the halves, or in both. */
enum { HBIL_HALF_EVEN = 1, HBIL_HALF_ODD = 2 };

/* One sample of a half-slice, common to all pixels of a layer at one level. */
typedef struct hbil_step {
  hbil_int offset;   /* floats to the sample of a layer's pixel (x,y), from
                        where x + y row is in the planes */
  hbil_int dx, dy;   /* offset within the layer, in layer pixels */
  hbil_float ex, ey; /* the same from pixel to pixel, in units of ray slope */
  hbil_float inv_e;  /* 1 / |e| */
  hbil_float ux, uy; /* e / |e| */
  hbil_int halves;   /* of HBIL_HALF_ */
} hbil_step;

/* Words of the plan's flags: what kernels of a frame tell later ones. */
enum {
  HBIL_FLAG_HOLES = 0,   /* there is a hole to fill (push_pull.cl) */
  HBIL_FLAG_CHANGED = 1, /* a still frame's light is not the one before */
  HBIL_FLAGS = 2
};

/* Words of the plan's counts: pixels of a frame whose input could not be used
 * as it was (hbil_plan_sanitized()).  The first is written by reproject; then
 * come those of split; then those of what split has no use for, by composite.
 */
enum {
  HBIL_SANITIZED_MOTION = 0,
  HBIL_SANITIZED_DEPTH = 1,
  HBIL_SANITIZED_NORMAL = 2,
  HBIL_SANITIZED_SURFACE = 3, /* HBIL_SURFACE_ on */
  HBIL_SANITIZED_LATE = 7,    /* the same */
  HBIL_SANITIZED_WORDS = 11
};
enum {
  HBIL_SURFACE_ALBEDO = 0,
  HBIL_SURFACE_F0 = 1,
  HBIL_SURFACE_DIRECT = 2,
  HBIL_SURFACE_EMISSION = 3,
  HBIL_SURFACE_INPUTS = 4
};

/* A cell is 64x64 pixels: so many of a layer, a multiple of HBIL_WIDEST. */
#define HBIL_CELL 16
/* Cells to a block, each way. */
#define HBIL_BLOCK 4

/* Scatter on CPUs: pixels of a row of the last frame that are a run. */
#define HBIL_RUN 64
/* Runs of a row, a multiple of HBIL_WIDEST with empty ones at the end; rows of
 * this frame that one work-item owns. */
typedef struct hbil_runs_args {
  hbil_int row, band;
} hbil_runs_args;

/* A grid of bounds: where it lies, in words, and its size.  Two words a cell:
 * the largest inverse depth, as a float, and of HBIL_SOME_. */
typedef struct hbil_grid_args {
  hbil_uint offset;
  hbil_int width, height;
} hbil_grid_args;
#define HBIL_SOME_LIT 1u  /* a pixel sends light */
#define HBIL_SOME_DARK 2u /* pixels that are no sky send none */

/* group: 4*HBIL_WIDTH pixels of a row, which cells are made of;
 * whole: a single one; quadrants: where each block has a word of
 * hbil_quadrants(). */
typedef struct hbil_bounds_args {
  hbil_grid_args group, cell, block, whole;
  hbil_uint quadrants;
} hbil_bounds_args;

/* A half-slice stays in a quadrant about where it begins, which has that one's
 * row and column.  Its number. */
static inline hbil_uint hbil_quadrant(hbil_int right, hbil_int down) {
  return (hbil_uint)(2 * down + right);
}
/* In which of the four about column x, row y of a grid (i, j) is: a bit each,
 * the first for quadrant 0. */
static inline hbil_uint hbil_quadrants(hbil_int x, hbil_int y, hbil_int i,
                                       hbil_int j) {
  const hbil_uint across = (i <= x ? 5u : 0u) | (i >= x ? 10u : 0u);
  const hbil_uint down = (j <= y ? 3u : 0u) | (j >= y ? 12u : 0u);
  return across & down;
}
#define HBIL_ALL_QUADRANTS 15u

/* What a span of the gather had no need of, as bits of a byte, the values of
 * hbil_skip; so many bytes lie behind them with the number of sky pixels. */
enum {
  HBIL_SPAN_SKY = 1,
  HBIL_SPAN_OPEN = 2,
  HBIL_SPAN_DARK = 4,
  HBIL_SPAN_UNUSED = 8
};

/*
 * Adaptive sampling (judge.cl): of a few tiles, HBIL_SPAN pixels of a layer row
 * in all layers each, it is measured how far fewer samples are off from many.
 * The first number that is good enough, a rung of a ladder, is the frame's.
 */
enum {
  HBIL_MOST_RUNGS = 16, /* the ruler's comes behind them: what they are held
                           against */
  HBIL_MEASURED_TILES = 40
};
/* A number of slices and of samples.  The ladder is a buffer: Mesa's llvmpipe
 * can't index an argument. */
typedef struct hbil_rung {
  hbil_uint steps; /* where its own begin in the table */
  hbil_int slices, samples;
  /* what makes an error that 95 % of the pixels don't exceed of how much the
   * pixels differ that recompose brings together */
  hbil_float error_ao, error_near;
} hbil_rung;

/* What a rung came to: pixels that were measured, and those of them that are
 * off by more than the limits.  Where there is nothing but sky the first one
 * will do. */
enum { HBIL_TRIED_BEYOND = 0, HBIL_TRIED_PIXELS = 1, HBIL_TRIED = 2 };
static inline hbil_int hbil_good_enough(hbil_uint beyond, hbil_uint pixels) {
  return 20u * beyond <= pixels;
}

/* The limits: of AO, of E_near over its mean. */
typedef struct hbil_limit_args {
  hbil_float ao, near_irradiance;
} hbil_limit_args;

/* What judging a rung takes; the ruler has no limit. */
typedef struct hbil_judge_args {
  hbil_layer_args in, lit; /* split, light */
  hbil_int tiles, rung;
  hbil_limit_args limit;
} hbil_judge_args;

/* Of each block of 4x4 pixels in them the two that are judged: (1, 1) and
 * (2, 2), whose neighbours in the block are the most of those around. */
enum { HBIL_JUDGED = 2 };

/* Of each tile, what the ruler says of those: planes of HBIL_SPAN blocks each;
 * behind all of them of each tile the sum of E_near and the number of its
 * values. */
enum {
  HBIL_RULER_AO = 0,
  HBIL_RULER_RED = 1, /* 2: green, 3: blue */
  HBIL_RULER_PLANES = 4
};

/* Tiles of a layer row that many pixels wide. */
static inline hbil_int hbil_spans(hbil_int width) {
  return (width + HBIL_SPAN - 1) / HBIL_SPAN;
}

/* Column and row of tile i of so many that are measured: evenly down the
 * picture, and across it by the golden ratio, which leaves no gaps and meets no
 * period (Kronecker's sequence). */
static inline void hbil_measured_tile(hbil_int i, hbil_int count,
                                      hbil_int across, hbil_int rows,
                                      hbil_int *x, hbil_int *y) {
  const hbil_float turn = 0.618033989f * (hbil_float)(i + 1);
  *x = (hbil_int)((turn - (hbil_float)(hbil_int)turn) * (hbil_float)across);
  *y = (2 * i + 1) * rows / (2 * count);
}

/* Numbers of one frame that the gather needs. */
typedef struct hbil_gather_args {
  hbil_view_args view;
  hbil_layer_args split, light;
  hbil_float radius;    /* world units; unused where unlimited */
  hbil_float reach;     /* hbil_pattern_args.reach */
  hbil_float keep;      /* 1 - tolerance on a sampled inverse depth */
  hbil_float flat;      /* tolerance on the gradient, see gather.cl */
  hbil_float facing[2]; /* hbil_config.facing: the first, and the inverse of
                           how much higher the second is */
  hbil_float thickness; /* hbil_config.thickness; orthographic: the smaller of
                           both */
  hbil_float relative_thickness;
  hbil_float falloff; /* HBAO: an occluder at distance r weighs 1 - falloff r */
  hbil_float longest; /* length of the longest ray, to a corner; orthographic:
                         of the way there in the picture's plane */
  hbil_bounds_args bounds;
  hbil_uint spans;          /* of a layer's row */
  hbil_int slices, samples; /* hbil_config's */
  /* adaptive: rungs to choose from, tiles that are measured, and the rung that
   * this launch measures them with; below 0: it takes the rung that is good
   * enough for all */
  hbil_int rungs, tiles, measures;
  hbil_int dark; /* the same: it measures AO alone, so light is left out */
} hbil_gather_args;

/* Form factors (horizon_cache.clh): rows of a layer, from the first on, that
 * they are kept of; vectors of pixels in those of all layers; of each pixel,
 * factors at most; of each vector, entries at most. */
typedef struct hbil_factor_args {
  hbil_uint rows, vectors, factors, entries;
} hbil_factor_args;

/* Far field: SH coefficients already multiplied by the basis functions'
 * constants and by sqrt(4 pi / (2l+1)), see composite.cl; a constant radiance
 * in the first.  A struct for each channel, since Mesa takes an array of arrays
 * in an argument for smaller than it is. */
typedef struct hbil_sh_args {
  hbil_float sh[9];
} hbil_sh_args;
typedef struct hbil_environment_args {
  hbil_sh_args channel[3];
} hbil_environment_args;

/* What the pattern depends on. */
typedef struct hbil_pattern_args {
  hbil_int slices, samples, levels, lattice; /* lattice: 4 within a layer, 1 */
  hbil_float reach;  /* ray slope from image edge to edge, see hbil_level() */
  hbil_float growth; /* hbil_config.step_growth */
  hbil_float turn;   /* rotation of the directions, in slices, [0,1) */
  hbil_float shift;  /* shift of the samples, in steps, [0,1) */
} hbil_pattern_args;

/* Each further level reaches half as far. */
#define HBIL_MAX_LEVELS 12

/*
 * The level whose reach is the smallest that still covers `need` (a length in
 * ray slope: radius times the tile's largest inverse depth).
 */
static inline hbil_int hbil_level(hbil_float reach, hbil_float need,
                                  hbil_int levels) {
  hbil_int level = 0;
  while (level + 1 < levels && 0.5f * reach >= need) {
    reach *= 0.5f;
    ++level;
  }
  return level;
}

/*
 * Order in which the 16 pixels of a block take the 16 directions (4x4 Bayer
 * matrix: neighbours get directions far apart), and in which they take the 16
 * shifts along the slice (the same matrix, mirrored and turned, so that
 * direction and shift are not tied to each other).
 */
static inline hbil_int hbil_direction_slot(hbil_int layer) {
  /* Bayer: interleave the bits of (x xor y) and y, most significant last. */
  hbil_int x = layer & 3, y = layer >> 2, v = x ^ y;
  return ((v & 1) << 3) | ((y & 1) << 2) | (v & 2) | ((y & 2) >> 1);
}
static inline hbil_int hbil_shift_slot(hbil_int layer) {
  hbil_int x = layer & 3, y = layer >> 2;
  return (hbil_direction_slot((x << 2) | (3 - y)) * 5 + 3) & 15;
}

/*
 * cos and sin of pi v for v in [0,1), by polynomials on |angle| <= pi/4 (error
 * below 1e-7), so that host and device agree to the last bit.
 */
static inline void hbil_cos_sin_pi(hbil_float v, hbil_float *c, hbil_float *s) {
  hbil_int quarter = (hbil_int)HBIL_RINT(v * 2.0f); /* 0, 1, 2 */
  hbil_float a = HBIL_FMA((hbil_float)quarter, -0.5f, v) * 3.14159274f;
  hbil_float q = a * a;
  hbil_float p, r;
  p = HBIL_FMA(q, 2.75573192e-6f, -1.98412698e-4f); /* Taylor, 1/9!, 1/7! */
  p = HBIL_FMA(q, p, 8.33333333e-3f);
  p = HBIL_FMA(q, p, -1.66666667e-1f);
  p = HBIL_FMA(a * q, p, a);
  r = HBIL_FMA(q, 2.48015873e-5f, -1.38888889e-3f); /* 1/8!, 1/6! */
  r = HBIL_FMA(q, r, 4.16666667e-2f);
  r = HBIL_FMA(q, r, -0.5f);
  r = HBIL_FMA(q, r, 1.0f);
  *c = quarter == 0 ? r : quarter == 1 ? -p : -r;
  *s = quarter == 0 ? p : quarter == 1 ? r : -p;
}

/*
 * Direction u (unit, ray-slope space) of a slice in a layer.  The half-slices
 * go along u and -u.  Over the 16 layers the directions are equally spaced.
 */
static inline void hbil_slice_direction(hbil_int layer, hbil_int slice,
                                        const hbil_pattern_args p,
                                        hbil_float *ux, hbil_float *uy) {
  hbil_float t =
      ((hbil_float)hbil_direction_slot(layer) + 0.5f) * 0.0625f + p.turn;
  t = t >= 1.0f ? t - 1.0f : t;
  hbil_cos_sin_pi(((hbil_float)slice + t) / (hbil_float)p.slices, ux, uy);
}

/*
 * Pixel offset of sample k (0..samples-1) along (ux, uy) (already negated for
 * the second half-slice).
 *
 * With t = (k + shift)/samples in (0,1), the distance is reach * t /
 * (1 + growth (1-t)): equal steps for growth 0, steps growing from
 * 1/(1+growth) to (1+growth) times the mean otherwise.  No two samples of a
 * half-slice share a pixel: sample k is at least k+1 lattice steps away.
 */
static inline void hbil_sample_offset(hbil_int layer, hbil_int k,
                                      hbil_int level, hbil_float ux,
                                      hbil_float uy, const hbil_view_args v,
                                      const hbil_pattern_args p, hbil_int *x,
                                      hbil_int *y) {
  hbil_float lattice = (hbil_float)p.lattice;
  /* pixels per unit of slope along u, and the larger of its components */
  hbil_float px = ux * v.fx, py = uy * v.fy;
  hbil_float ax = HBIL_FABS(px), ay = HBIL_FABS(py);
  hbil_float major = ax > ay ? ax : ay;
  /* no pixel of the image is farther along u than this */
  hbil_float to_x =
      (hbil_float)v.width / (ax > 1e-6f * major ? ax : 1e-6f * major);
  hbil_float to_y =
      (hbil_float)v.height / (ay > 1e-6f * major ? ay : 1e-6f * major);
  hbil_float edge = to_x < to_y ? to_x : to_y;
  hbil_float reach = p.reach;
  hbil_float t, least, d;
  hbil_int i;
  for (i = 0; i < level; ++i)
    reach *= 0.5f;
  reach = reach < edge ? reach : edge;
  t = ((hbil_float)hbil_shift_slot(layer) + 0.5f) * 0.0625f + p.shift;
  t = t >= 1.0f ? t - 1.0f : t;
  t = ((hbil_float)k + t) / (hbil_float)p.samples;
  d = reach * t / HBIL_FMA(p.growth, 1.0f - t, 1.0f);
  least = (hbil_float)(k + 1) * lattice / major;
  d = d > least ? d : least;
  *x = (hbil_int)HBIL_RINT(d * px / lattice) * p.lattice;
  *y = (hbil_int)HBIL_RINT(d * py / lattice) * p.lattice;
}

/* Pixels that an offset spans along its longer axis. */
static inline hbil_int hbil_offset_length(hbil_int x, hbil_int y) {
  /* absolute values of floats: those of ints are an intrinsic that oclgrind
   * doesn't know */
  x = (hbil_int)HBIL_FABS((hbil_float)x);
  y = (hbil_int)HBIL_FABS((hbil_float)y);
  return x > y ? x : y;
}

/*
 * The halves that sample k belongs to; before, after: hbil_offset_length() of
 * the samples on either side of it, 0 before the first, its own after the last.
 * What its half would miss without it is extrapolated to the share of the
 * pixels around it that no sample meets: where every pixel is met there is
 * nothing to extrapolate, and the sample is in both.  In between, so is that
 * share of the 16 layers.
 */
static inline hbil_int hbil_sample_halves(hbil_int layer, hbil_int k,
                                          hbil_int samples, hbil_int before,
                                          hbil_int after) {
  hbil_int met = k + 1 < samples ? 2 : 1;
  /* (slot + 1/2) / 16 of the layers' places lie above the share that is met */
  if ((2 * hbil_shift_slot(layer) + 1) * (after - before) < 32 * met)
    return HBIL_HALF_EVEN | HBIL_HALF_ODD;
  return k & 1 ? HBIL_HALF_ODD : HBIL_HALF_EVEN;
}

#endif
