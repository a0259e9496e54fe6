/*
 * estimate_args: the estimate of unseen light (estimate.cl), as the host, the
 * kernels and the exact integral need it.
 */
#ifndef HBIL_ESTIMATE_ARGS_H
#define HBIL_ESTIMATE_ARGS_H

#include "shared.h"

/* Weight of the frame's mean radiance, in hemispheres, relative to what a pixel
 * sees itself.  Chosen with hbil_model.offscreen_light (doc/measurements.md).
 */
#define HBIL_UNSEEN_PRIOR 1.0f
/* What is added to the weight of each surface, of about 1, in the mean for a
 * receiver, which makes it positive everywhere. */
#define HBIL_UNSEEN_EVEN 0.1f
/* The most of its light that a bounce may return to the frame's surfaces, so
 * the series of all bounces is at most 10. */
#define HBIL_UNSEEN_GAIN 0.9f
/* How much of the first bounce's unevenness later bounces still have, 0..1.  A
 * quarter leaves the first frame's light within 2 % of that after 40 frames on
 * twelve dumps; 0 and 1 don't (doc/measurements.md). */
#define HBIL_UNSEEN_COUPLING 0.25f
/* A part of the pixels, of HBIL_ESTIMATE_PARTS, that sends more than this many
 * times the typical light counts as so many: it has a few very bright ones. */
#define HBIL_UNSEEN_SPIKE 4.0f

/* A pixel whose direct light is more than what the open directions can get from
 * the sky is lit by something else, the sun for instance, and does not tell how
 * much of the sky it sees.  This counts from 0 at 1 times to fully at 1.5. */
#define HBIL_LIT_SLOPE 2.0f
/* The sun shines if that is so at this share of the surfaces or more; not at
 * all up to the lower one, which errors of AO alone may reach. */
#define HBIL_SUN_NONE 0.03f
#define HBIL_SUN_FULL 0.15f
/* The mean unlit part of the other pixels acts as if this share of the open
 * directions, all lit by the sky, were added, so few pixels decide little. */
#define HBIL_DARK_PRIOR 0.05f

/* Values of the estimate, then its sums over the picture, then those of the
 * parts. */
enum {
  /* means of nine polynomials, three channels and the weight */
  HBIL_FILL_LIGHT = 0,
  HBIL_FILL_WEIGHT = 27,
  HBIL_FILL_LACKS = 36,  /* radiance that near light lacks of all bounces;
                            three channels */
  HBIL_FILL_UNLIT = 39,  /* of open directions, where the sun shines */
  HBIL_FILL_SUN = 40,    /* 0: no sun .. 1: it shines */
  HBIL_FILL_UNSEEN = 41, /* offscreen_light of hbil_config */
  HBIL_FILL_SIZE = 42
};
enum {
  HBIL_SUM_LIGHT = 0,        /* radiance of the first bounce, polynomials */
  HBIL_SUM_WEIGHT = 27,      /* the polynomials; the first is the number of
                                surfaces */
  HBIL_SUM_REFLECTANCE = 36, /* three channels */
  HBIL_SUM_OPEN = 39,        /* AO */
  HBIL_SUM_BEHIND = 40,      /* the share that back-facing samples block */
  /* over pixels, as far as they tell how much of the sky they see: AO, times
   * the unlit part, times its square */
  HBIL_SUM_DARK = 41,
  HBIL_SUM_LIT = 44,      /* over the others: 1 */
  HBIL_SUM_LIT_OPEN = 45, /* and AO */
  HBIL_SUM_NEAR = 46,     /* E_near / pi, three channels */
  HBIL_ESTIMATE_SUMS = 49
};
enum {
  HBIL_ESTIMATE_PARTS = 64,
  HBIL_ESTIMATE_BLOCK = 16, /* pixels of a layer's row that are used or not */
  /* Work-items of a part in kernels of single pixels: 16 pixels of each of 16
   * rows at a time.  Fewer where there are fewer rows.  With vectors it is one
   * work-item, which writes the part's sums itself. */
  HBIL_ESTIMATE_LANES = 256,
  HBIL_ESTIMATE_SIZE =
      HBIL_FILL_SIZE + HBIL_ESTIMATE_SUMS * (1 + HBIL_ESTIMATE_PARTS),
  /* and behind that, the sums of the lanes, lane by lane of each part */
  HBIL_ESTIMATE_LANES_SIZE =
      HBIL_ESTIMATE_SUMS * HBIL_ESTIMATE_PARTS * HBIL_ESTIMATE_LANES
};

/* Part `part` takes pixels of layer part % 16, in every fourth row from this
 * one on. */
static inline hbil_int hbil_estimate_row(hbil_int part) {
  return part / 16;
}

/* Whether block `block`, of 4 HBIL_ESTIMATE_BLOCK pixels, of the picture's row
 * y is used; an eighth of the blocks are.  A part's rows are 16 apart; y / 16
 * makes them use different blocks. */
static inline hbil_int hbil_estimate_uses(hbil_int block, hbil_int y) {
  return (block + 3 * (y + y / 16)) % 8 == 0;
}

typedef struct hbil_estimate_args {
  hbil_layer_args split, light;
  hbil_int width, height; /* of the picture */
  hbil_surface_args surface;
  hbil_float sky[3];       /* radiance of the sky that `direct` contains */
  hbil_float sky_share;    /* as in hbil_frame */
  hbil_float unseen_light; /* offscreen_light of hbil_config */
  hbil_int bounces;        /* as hbil_last_frame has it */
  hbil_int is_static;      /* reuse the sums unless HBIL_FLAG_CHANGED is set */
} hbil_estimate_args;
HBIL_ASSERT_LAYOUT(hbil_estimate_args, is_static, 39, 40)

#endif
