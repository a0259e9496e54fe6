/*
 * What host C and OpenCL C both read: the constants of the data layouts, the
 * order of the planes, and one struct of arguments for each pass.
 *
 * Every member is a 32-bit word, or one of two halves of a word, so that both
 * compilers lay a struct out alike;
 * HBIL_ASSERT_LAYOUT checks that in both.
 */
#ifndef HBIL_SHARED_H
#define HBIL_SHARED_H

#ifdef __OPENCL_VERSION__
typedef int hbil_int;
typedef short hbil_short;
typedef uint hbil_uint;
typedef float hbil_float;
#define HBIL_FMA(a, b, c) fma((a), (b), (c))
#define HBIL_RINT(a) rint(a)
#define HBIL_FABS(a) fabs(a)
/* For structs whose size is a multiple of 16 bytes; only kernels need it. */
#define HBIL_ALIGNED_16 __attribute__((aligned(16)))
/* An array of negative size stops the compiler. */
#define HBIL_ASSERT_LAYOUT(type, last, last_word, words)                       \
  typedef char                                                                 \
      type##_has_##words##_words[sizeof(type) == 4 * (words) &&                \
                                         __builtin_offsetof(type, last) ==     \
                                             4 * (last_word)                   \
                                     ? 1                                       \
                                     : -1];
#else
#include <hbil/hbil_base.h>
#include <math.h>
#include <stddef.h>
typedef cl_int hbil_int;
typedef cl_short hbil_short;
typedef cl_uint hbil_uint;
typedef cl_float hbil_float;
#define HBIL_FMA(a, b, c) fmaf((a), (b), (c))
#define HBIL_RINT(a) rintf(a)
#define HBIL_FABS(a) fabsf(a)
#define HBIL_ALIGNED_16
#define HBIL_ASSERT_LAYOUT(type, last, last_word, words)                       \
  _Static_assert(sizeof(type) == 4 * (words) &&                                \
                     offsetof(type, last) == 4 * (last_word),                  \
                 #type);
#endif

/* --- constants of the layouts --------------------------------------------- */

/* The image is split into 4x4 interleaved layers (Mayaux 2018, 3.3). */
#define HBIL_SIDE 4
#define HBIL_LAYERS 16
/* A span: neighbouring pixels of a layer's row with one radius of influence in
 * pixels; a work-item of the gather on CPUs.  The padding left and right of
 * each layer row is as long, so that a load of a span that begins anywhere in
 * [-32, width rounded up to 32] stays inside.  Narrow pictures have shorter
 * ones. */
#define HBIL_SPAN 32

/* Rows that one work-item of recompose takes on CPUs; a multiple of 4. */
#define HBIL_RECOMPOSE_ROWS 16

/* The most pixels that a vector holds. */
#define HBIL_WIDEST 16

/* The inverse depth that stands for "no surface": below every tangent plane,
 * whatever the scale of the scene, and far enough from FLT_MAX to take part in
 * sums. */
#define HBIL_NOTHING (-1e30f)

/* Depths from the nearest up to the farthest are surfaces.  The quotient of any
 * two of them, times the longest ray and over the slope of a pixel, is still a
 * finite float. */
#define HBIL_NEAREST_DEPTH 1e-15f
#define HBIL_FARTHEST_DEPTH 1e15f

/* Light of an input that is brighter than this counts as 0, like infinite
 * light.  So sums over a hemisphere, and over the square roots of a picture,
 * are finite floats. */
#define HBIL_BRIGHTEST 1e30f

/* Radiance of surfaces with less albedo tells nothing of the light on them: the
 * least half float above 0, below the least code of any other format. */
#define HBIL_LEAST_ALBEDO 0x1p-24f

/* A normal that faces away from the eye is turned back until its cosine with
 * the view direction is this.  It leaves planes up to 89.99 degrees alone; the
 * fp32 rounding of a normal (6e-8) is below 1e-3 of it, and a packed normal
 * (off by up to 6.5e-5) still faces the eye. */
#define HBIL_MIN_COSINE 1e-4f

/* Recompose gives no weight to a neighbour whose distance from the pixel's
 * tangent plane is this share of the pixel's inverse depth or more ... */
#define HBIL_PLANE_TOLERANCE 0.02f
/* ... nor to one whose normal has a cosine with the pixel's normal of 1 minus
 * this or less (33 degrees).  Both: measured, doc/measurements.md. */
#define HBIL_TURN_TOLERANCE 0.16f

/* Sectors of a half-slice where occluders have a thickness.  One less than a
 * word has bits, so that 1 << HBIL_SECTORS is still a bit. */
#define HBIL_SECTORS 31

/* --- planes of the stages (hbil_stages.h has the layouts) ----------------- */

enum {
  HBIL_SPLIT_W = 0,      /* inverse depth */
  HBIL_SPLIT_NORMAL = 1, /* x, 2: y, 3: z; view space, unit length */
  HBIL_SPLIT_RED = 4,    /* 5: green, 6: blue; radiance */
  HBIL_SPLIT_PLANES = 7
};
enum {
  HBIL_LIGHT_AO = 0,
  HBIL_LIGHT_RED = 1,  /* 2: green, 3: blue: E_near */
  HBIL_LIGHT_BENT = 4, /* x, 5: y, 6: z */
  HBIL_LIGHT_PLANES = 7,
  /* share of the hemisphere that surfaces facing away block, whose light is
   * unknown; resolved: behind the other planes, only if it is an output */
  HBIL_LIGHT_UNKNOWN = 7,
  /* gathered with a single slice only, behind all other planes: how much of the
   * hemisphere the slice stands for, 1 on average; or the same of all slices
   * that are known, over their number, where frames share them */
  HBIL_LIGHT_WEIGHT = 8,
  HBIL_GATHERED_PLANES = 9
};

/* HBIL_STORAGE_PACKED: the same in words of 32 bits.
 *   normal    octahedral (Cigolle et al. 2014), two snorm16, x low; the middle
 *             of the map looks along -z
 *   radiance  three mantissas of 8 bits, red lowest; the highest byte is the
 *             exponent of their unit, biased as in a float
 *   AO        unorm16; above it the unknown share, unorm8; the highest byte is
 *             the exponent of the unit of E_near
 *   E_near    three mantissas of 10 bits, red lowest
 *   bent      three snorm: 11 bits x, lowest, 11 bits y, 10 bits z; scaled to
 *             fit where a component is above 1
 * Light is rounded to the nearest.  The unknown share and bent normals are
 * dithered from site to site (hbil_site()), so their mean over n sites is off
 * by at most 1/(2 n) of a step.  Values that are too large become the largest.
 */
enum {
  HBIL_PACKED_NORMAL = 1,
  HBIL_PACKED_RADIANCE = 2,
  HBIL_PACKED_SPLIT_PLANES = 3
};
enum {
  HBIL_PACKED_AO = 0,
  HBIL_PACKED_NEAR = 1,
  HBIL_PACKED_BENT = 2,
  HBIL_PACKED_LIGHT_PLANES = 3
};

/* In packed storage, a word of radiance replaces red, green and blue, and the
 * weight is the second plane (CARRIED_WEIGHT of lib/radiance.clh). */
enum {
  HBIL_HISTORY_W = 0,
  HBIL_HISTORY_RED = 1,
  HBIL_HISTORY_PLANES = 4,
  HBIL_PACKED_HISTORY_PLANES = 2
};
enum {
  HBIL_CARRIED_RED = 0,
  HBIL_CARRIED_WEIGHT = 3,
  HBIL_CARRIED_PLANES = 4,
  HBIL_PACKED_CARRIED_PLANES = 2
};

/* What the gather hands on to the next frame where frames share slices: what a
 * pixel shows, and the light of sets of slices, each with its weight.  The
 * normal is a word of 2 x 16 bits, as in packed planes. */
enum { HBIL_PAST_W = 0, HBIL_PAST_NORMAL = 1, HBIL_PAST_SETS = 2 };

/* --- what several passes take --------------------------------------------- */

/* A plane of the caller, in components: its first one, and the distances from
 * row to row and from channel to channel. */
typedef struct hbil_external_plane_args {
  hbil_uint offset, row, plane, unused;
} hbil_external_plane_args;
HBIL_ASSERT_LAYOUT(hbil_external_plane_args, unused, 3, 4)

/* The caller's planes that tell what surfaces send. */
typedef struct hbil_surface_args {
  hbil_external_plane_args albedo, f0, direct, emission;
  hbil_float direct_scale; /* as in hbil_config */
} hbil_surface_args;
HBIL_ASSERT_LAYOUT(hbil_surface_args, direct_scale, 16, 17)

/* How values of the depth input are read (lib/depth.clh).  Planar depth and
 * distances from the eye: `scale` times the value.  Hardware depth:
 * w is base + scale (value - end), orthographic: base + scale value; `end` is
 * the value of the far end. */
typedef struct hbil_depth_args {
  hbil_float sky_depth; /* as in hbil_config */
  hbil_float end, base, scale;
} hbil_depth_args;
HBIL_ASSERT_LAYOUT(hbil_depth_args, scale, 3, 4)

/* Size and intrinsics.  fx and fy are pixels to a unit of ray slope; in
 * orthographic views, to a world unit. */
typedef struct hbil_view_args {
  hbil_int width, height;
  hbil_float fx, fy, cx, cy;
  hbil_float inv_fx, inv_fy;
} hbil_view_args;
HBIL_ASSERT_LAYOUT(hbil_view_args, inv_fy, 7, 8)

/* The upper three rows of a rigid transform between two views. */
typedef struct hbil_transform_args {
  hbil_float m[12];
} hbil_transform_args;
HBIL_ASSERT_LAYOUT(hbil_transform_args, m, 0, 12)

/* Full-resolution planes: distances in floats. */
typedef struct hbil_plane_args {
  hbil_uint plane, row;
} hbil_plane_args;
HBIL_ASSERT_LAYOUT(hbil_plane_args, row, 1, 2)

/* Where history planes begin in their buffer; as many floats follow them.  What
 * a vector loads begins and ends there at most: a window of three rows and two
 * vectors (lib/plane_addressing.clh) that holds a place in the picture, or a
 * row and a pixel before it.  Lanes whose source is outside of the picture are
 * masked. */
static inline hbil_uint hbil_history_origin(const hbil_plane_args planes) {
  return 2u * planes.row + 2u * HBIL_WIDEST;
}

/* Layered planes: distances in floats.  width, height: of a layer.  One row of
 * the image is contiguous: it holds the rows of its four layers one after the
 * other, and for each layer its planes, so that what a filter reads around a
 * pixel lies on few pages.  row_extent: floats of a layer's row in one plane,
 * padding included. */
typedef struct hbil_layer_args {
  hbil_uint plane, layer, row, origin, row_extent;
  hbil_int width, height;
} hbil_layer_args;
HBIL_ASSERT_LAYOUT(hbil_layer_args, height, 6, 7)

/* One sample of a half-slice, common to all pixels of a layer at one level.
 * What is read together is 16 bytes, which GPUs read at once. */
typedef struct hbil_step {
  hbil_int offset;   /* floats from x + y * row to the sample of pixel (x,y) */
  hbil_short dx, dy; /* offset within the layer, in layer pixels */
  /* e, the offset from pixel to pixel in units of ray slope: |e|, 1 / |e| and
   * e / |e| */
  hbil_float e, inv_e, ux, uy;
  /* for occluders of finite thickness, which stand for their steps
   * (hbil_sample_extent()) */
  hbil_int nearer, farther; /* as offset: the pixels that tell the slope */
  hbil_short farther_dx, farther_dy; /* as dx and dy */
  hbil_float slope_x, slope_y; /* as e: from the sample to the farther one */
  /* of a plane through the sample, at the ends of the step: (1 + gain) times
   * its excess, and reach times what it rises along this offset */
  hbil_float near_gain, near_reach, far_gain, far_reach;
  hbil_float beside; /* pixels of the step on either side */
} HBIL_ALIGNED_16 hbil_step;
HBIL_ASSERT_LAYOUT(hbil_step, beside, 15, 16)

/* Words of the plan's flags: what kernels of a frame tell later ones. */
enum {
  HBIL_FLAG_HOLES = 0,   /* there is a hole to fill (push_pull.cl) */
  HBIL_FLAG_CHANGED = 1, /* a static frame's light has changed */
  HBIL_FLAGS = 2
};

/* Words of the plan's counts of sanitized pixels (hbil_plan_sanitized()).  The
 * first one is written by reproject; then come those of split; then those of
 * the inputs that split doesn't read, written by composite. */
enum {
  HBIL_SANITIZED_MOTION = 0,
  HBIL_SANITIZED_DEPTH = 1,
  HBIL_SANITIZED_NORMAL = 2,
  HBIL_SANITIZED_AWAY = 3,    /* normals that face away */
  HBIL_SANITIZED_SURFACE = 4, /* HBIL_SURFACE_ on */
  HBIL_SANITIZED_LATE = 8,    /* HBIL_SURFACE_ on */
  HBIL_SANITIZED_WORDS = 12
};
enum {
  HBIL_SURFACE_ALBEDO = 0,
  HBIL_SURFACE_F0 = 1,
  HBIL_SURFACE_DIRECT = 2,
  HBIL_SURFACE_EMISSION = 3,
  HBIL_SURFACE_INPUTS = 4
};

/* --- bounds: what the gather can skip ------------------------------------- */

/* A cell is 64x64 pixels: so many of a layer, a multiple of HBIL_WIDEST. */
#define HBIL_CELL 16
/* Rows of a row block, in pixels; a divisor of a cell's. */
#define HBIL_ROW_BLOCK 4
/* Cells to a block, each way. */
#define HBIL_BLOCK 4

/* A grid of bounds: where it lies, in words, and its size.  Two words a cell:
 * the largest inverse depth, as a float, and bits of HBIL_SOME_. */
typedef struct hbil_grid_args {
  hbil_uint offset;
  hbil_int width, height;
} hbil_grid_args;
HBIL_ASSERT_LAYOUT(hbil_grid_args, height, 2, 3)
#define HBIL_SOME_LIT 1u  /* a pixel sends light */
#define HBIL_SOME_DARK 2u /* surfaces that send no light */

/* group: 4*HBIL_WIDTH pixels of a row, which cells are made of; whole: a single
 * cell; quadrants: where each block has a word of hbil_quadrants()
 * (lib/quadrants.clh). */
typedef struct hbil_bounds_args {
  hbil_grid_args group, cell, block, whole;
  hbil_uint quadrants;
} hbil_bounds_args;
HBIL_ASSERT_LAYOUT(hbil_bounds_args, quadrants, 12, 13)

/* The work that was left out for a span of the gather, as bits of a byte.  The
 * values are those of hbil_skip.  As many bytes follow with the number of sky
 * pixels. */
enum {
  HBIL_SPAN_SKY = 1,
  HBIL_SPAN_OPEN = 2,
  HBIL_SPAN_DARK = 4,
  HBIL_SPAN_UNUSED = 8
};

/* --- the passes ----------------------------------------------------------- */

/* clear_padding.cl.  nothing: what the first plane of the padding holds. */
typedef struct hbil_clear_args {
  hbil_layer_args layers;
  hbil_uint span; /* columns of padding, left and right */
  hbil_float nothing;
} hbil_clear_args;
HBIL_ASSERT_LAYOUT(hbil_clear_args, nothing, 8, 9)

/* view: this frame's; before: the last one's; back: from this view to it. */
typedef struct hbil_reproject_args {
  hbil_view_args view, before;
  hbil_transform_args back;
  hbil_plane_args planes, history; /* of carried light, and of the history */
  hbil_external_plane_args depth, motion;
  hbil_float motion_scale[2];
  hbil_float ratio[2]; /* pixels of the last frame to one of this, x and y */
  hbil_depth_args decode;
  hbil_float disocclusion_threshold; /* as in hbil_config */
} hbil_reproject_args;
HBIL_ASSERT_LAYOUT(hbil_reproject_args, disocclusion_threshold, 48, 49)

/* One level of the push/pull chain: where its planes lie, and its size. */
typedef struct hbil_chain_args {
  hbil_uint offset, plane, row;
  hbil_int width, height;
} hbil_chain_args;
HBIL_ASSERT_LAYOUT(hbil_chain_args, height, 4, 5)

typedef struct hbil_push_pull_args {
  hbil_chain_args fine, coarse;
} hbil_push_pull_args;
HBIL_ASSERT_LAYOUT(hbil_push_pull_args, coarse, 5, 10)

/* split, and relight for the light alone. */
typedef struct hbil_split_args {
  hbil_view_args view;
  hbil_transform_args to_view; /* from world space, for normals */
  hbil_layer_args layers;
  hbil_plane_args planes; /* of carried light; relight: of the history */
  hbil_grid_args groups;  /* of the bounds */
  hbil_external_plane_args depth, normal;
  hbil_surface_args surface;
  hbil_depth_args decode;
  hbil_float exposure; /* as in hbil_frame, not 0 */
  hbil_int has_history;
  hbil_int steady; /* relight: ignore falls by a rounding */
} hbil_split_args;
HBIL_ASSERT_LAYOUT(hbil_split_args, steady, 63, 64)

/* Each cell of the coarse grid covers across x down cells of the fine one. */
typedef struct hbil_bound_cells_args {
  hbil_grid_args fine, coarse;
  hbil_int across, down;
  hbil_int is_static; /* leave at once unless HBIL_FLAG_CHANGED is set */
} hbil_bound_cells_args;
HBIL_ASSERT_LAYOUT(hbil_bound_cells_args, is_static, 8, 9)

typedef struct hbil_bound_quadrants_args {
  hbil_bounds_args bounds;
  hbil_int is_static; /* leave at once unless HBIL_FLAG_CHANGED is set */
} hbil_bound_quadrants_args;
HBIL_ASSERT_LAYOUT(hbil_bound_quadrants_args, is_static, 13, 14)

/* What the sampling pattern depends on. */
typedef struct hbil_pattern_args {
  hbil_int slices, steps, levels;
  hbil_int grid;     /* pixels between places of samples: 4 in a layer, or 1 */
  hbil_float reach;  /* ray slope from image edge to edge, see hbil_level() */
  hbil_float growth; /* hbil_config.step_growth */
  hbil_float turn;   /* rotation of the directions, in slices, [0,1) */
  hbil_float shift;  /* shift of the samples, in steps, [0,1) */
  hbil_int gathered; /* layers: 16 or 4, see hbil_is_gathered() */
} hbil_pattern_args;
HBIL_ASSERT_LAYOUT(hbil_pattern_args, gathered, 8, 9)

/* The table of steps (pattern.cl). */
typedef struct hbil_make_pattern_args {
  hbil_view_args view;
  hbil_pattern_args pattern;
  hbil_layer_args split;
} hbil_make_pattern_args;
HBIL_ASSERT_LAYOUT(hbil_make_pattern_args, split, 17, 24)

/* gather */
typedef struct hbil_gather_args {
  hbil_view_args view;
  hbil_layer_args split, light;
  hbil_float radius;    /* world units; unused where unlimited */
  hbil_float reach;     /* hbil_pattern_args.reach */
  hbil_float nearness;  /* 1 minus the tolerance on a sample's inverse depth */
  hbil_float half_step; /* of hardware depth, in w: how far a w may be off */
  hbil_float flatness;  /* tolerance on the gradient, see gather/search.clh */
  hbil_float facing[2]; /* hbil_config.facing_fade[0]; inverse of the fade's
                           width */
  hbil_float thickness; /* hbil_config.thickness; orthographic: the smaller of
                           both thicknesses */
  hbil_float relative_thickness;
  hbil_float falloff; /* HBAO: an occluder at distance r weighs 1 - falloff r */
  hbil_float longest; /* length of the longest ray, to a corner; orthographic:
                         of the way there in the picture's plane */
  hbil_bounds_args bounds;
  hbil_uint spans;        /* of a layer's row */
  hbil_int slices, steps; /* hbil_config's */
  hbil_int is_static;     /* leave at once unless HBIL_FLAG_CHANGED is set */
  hbil_float lobe;        /* k of the output `glossy` at normal view */
  /* where frames share slices: the last frame's view; from this view to it, and
   * from it; the buffer that frames hand on; hbil_frame.exposure and its
   * inverse; whether there is a last frame */
  hbil_view_args before;
  hbil_transform_args back, forth;
  hbil_layer_args past;
  hbil_external_plane_args motion;
  hbil_float motion_scale[2];
  hbil_float disocclusion_threshold;
  hbil_float exposure, per_exposure;
  hbil_int has_past;
} hbil_gather_args;
HBIL_ASSERT_LAYOUT(hbil_gather_args, has_past, 99, 100)

/* Factors that turn the standard deviation of the light that recompose brings
 * together into an error that 95 % of the pixels don't exceed. */
typedef struct hbil_error_args {
  hbil_float ao, near_irradiance;
} hbil_error_args;
HBIL_ASSERT_LAYOUT(hbil_error_args, near_irradiance, 1, 2)

typedef struct hbil_recompose_args {
  hbil_view_args view;
  hbil_layer_args split, light;
  hbil_plane_args planes; /* of the result */
  hbil_error_args errors;
  hbil_int is_static; /* leave at once unless HBIL_FLAG_CHANGED is set */
} hbil_recompose_args;
HBIL_ASSERT_LAYOUT(hbil_recompose_args, is_static, 26, 27)

/* Far field: SH coefficients, already multiplied by the constants of the basis
 * functions and by sqrt(4 pi / (2l+1)) (composite.cl); a constant radiance in
 * the first one.  Each channel is a struct, because Mesa's rusticl computes a
 * wrong size for an array of arrays in an argument. */
typedef struct hbil_sh_args {
  hbil_float sh[9];
} hbil_sh_args;
typedef struct hbil_environment_args {
  hbil_sh_args channel[3];
} hbil_environment_args;
HBIL_ASSERT_LAYOUT(hbil_environment_args, channel, 0, 27)

/* The grid of probes (lib/probe_grid.clh): cells of `spacing` pixels, and
 * `lines` of `columns` probes each; columns 0: there are none. */
typedef struct hbil_probe_grid_args {
  hbil_int spacing, columns, lines;
} hbil_probe_grid_args;
HBIL_ASSERT_LAYOUT(hbil_probe_grid_args, lines, 2, 3)

#endif
