/*
 * hbil_stages.h: what the passes of a frame exchange.  Only callers who replace
 * a pass by one of their own need it.
 *
 * Such a caller enqueues the other passes one by one (hbil_enqueue_reproject()
 * and so on), in their order and on one queue or chained by events, and reads
 * or writes the buffers that hbil_plan_buffer() gives.
 * examples/03_single_passes.c does this.
 */
#ifndef HBIL_HBIL_STAGES_H
#define HBIL_HBIL_STAGES_H

#include "hbil/hbil.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------ */
/* Stages: between the passes                                                */

/*
 * The stages are planes of 32-bit floats.  Values per pixel:
 *   HISTORY    4: inverse depth 1/z of the last frame (<= 0: sky), carried RGB
 *   CARRIED    4: RGB of the last frame seen from this one, weight (0: a hole;
 *              below 0: the sky, which push_pull does not change)
 *   SPLIT      7: inverse depth w (<= 0: no surface), view-space unit normal
 * XYZ that faces the eye, radiance RGB.  Orthographic views have -z in the
 * place of inverse depth (below -5e29: no surface), here and in
 *              TEMPORAL_HISTORY
 *   GATHERED   7: AO, E_near RGB, bent normal XYZ (view space, any length).
 * With HBIL_FALLBACK_FRAME_MEAN, unless facing_fade[1] is -1, an eighth: the
 * share of the hemisphere whose light is unknown.  With a single slice and the
 * filter one more, the last, which is a float in any storage: the slice's
 * weight, 1 on average RESOLVED   7: the same in full resolution; unknown light
 * is filled in; after the temporal pass, the mean over frames TEMPORAL_HISTORY
 *             10: of the last frame that was composed: inverse depth (<= 0:
 * sky), normal (a word as in packed SPLIT), number of frames (0: the pixel does
 * not count), then as RESOLVED, but the bent normal has any length.  One of two
 * buffers: ask again after every frame
 *
 * With HBIL_STORAGE_PACKED, SPLIT and GATHERED hold words of 32 bits instead,
 * in planes that lie the same way: SPLIT      3: inverse depth, a float;
 * normal; radiance GATHERED   3: AO, above it the unknown share, in byte 3
 * E_near's exponent; E_near; bent normal normal     u low, v high, two's
 * complement over 32767: n is (u, v, z) divided by its length, z = |u|+|v|-1;
 * where z > 0, u and v are first made smaller by z, with their signs unchanged
 *     radiance   red in the lowest byte, green, blue, times 2^(byte 3 - 127)
 *     E_near     10 bits red, lowest, green, blue, times 2^(exponent - 127)
 *     AO         16 bits over 65535; the unknown share 8 bits over 255
 *     bent       x: the lowest 11 bits, y: the next 11, both over 1023; z: the
 *                highest 10 over 511; two's complement
 *
 * A plan stores only what its outputs need: hbil_buffer.values tells how many
 * of these values, from the first on, it has.  SPLIT has 4 without radiance (2
 * words); GATHERED and RESOLVED have 4 without bent normals (2 words) and 1
 * with AO alone (1 word); a single slice's weight comes on top;
 * TEMPORAL_HISTORY has 3 more than RESOLVED.  HISTORY and CARRIED exist where
 * light is carried over: with a reprojection, and an output among
 * near_irradiance, indirect and beauty.
 *
 * Value p of pixel (x,y) of a full-resolution plane is at float index
 *   p * plane_pitch + y * row_pitch + x + origin
 * SPLIT and GATHERED are layered: pixel (x,y) lies in layer 4 (y mod 4) + (x
 * mod 4), at p * plane_pitch + layer * layer_pitch + (y/4) * row_pitch + x/4 +
 * origin Around every layer of SPLIT there is padding that holds "no surface".
 */
typedef enum hbil_stage {
  HBIL_STAGE_HISTORY = 0,
  HBIL_STAGE_CARRIED = 1,
  HBIL_STAGE_SPLIT = 2,
  HBIL_STAGE_GATHERED = 3,
  HBIL_STAGE_RESOLVED = 4,
  HBIL_STAGE_TEMPORAL_HISTORY = 5
} hbil_stage;

typedef struct hbil_buffer {
  cl_mem buffer; /* owned by the plan */
  cl_uint values;
  size_t plane_pitch, layer_pitch, row_pitch, origin; /* in floats or words */
} hbil_buffer;

/* The buffer of a stage, and how its values lie.  HBIL_INVALID_ARGUMENT where
 * the plan has no such stage. */
HBIL_API hbil_status hbil_plan_buffer(const hbil_plan *plan, hbil_stage stage,
                                      hbil_buffer *out);

#ifdef __cplusplus
}
#endif

#endif
