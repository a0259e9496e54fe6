/*
 * hbil_stages.h: the buffers between the passes of a frame.
 *
 * Only callers who replace a pass by one of their own need this header.  They
 * enqueue the passes before it and those after it with hbil_enqueue_passes().
 * Their own pass reads and writes the buffers that hbil_plan_buffer() returns.
 * On other queues than in-order ones it waits for the event of the passes
 * before it, and the passes after it wait for its event.
 * examples/03_single_passes.c shows this.
 */
#ifndef HBIL_HBIL_STAGES_H
#define HBIL_HBIL_STAGES_H

#include "hbil/hbil.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------ */
/* Stages: the buffers between the passes                                    */

/*
 * A stage is the data between two passes: some planes of 32-bit floats.  The
 * values of a pixel, one per plane, are
 *   HISTORY           4: inverse depth 1/z of the last frame (0 or less: sky);
 *                        its light, RGB, of the kind that feedback selects
 *   CARRIED           4: light of the last frame, reprojected to this one, RGB;
 *                        weight (0: a hole, which push_pull fills; below 0:
 *                        sky, which it does not change)
 *   SPLIT             7: inverse depth (0 or less: no surface); unit normal XYZ
 *                        in view space, which faces the eye; radiance RGB
 *   GATHERED          7: AO; E_near RGB; bent normal XYZ in view space, of any
 *                        length.  Up to two more values follow, see below
 *   RESOLVED          7: the same at full resolution, with a bent normal of
 *                        length 1 or 0.  AO may be a rounding above 1 here; the
 *                        output is not
 *
 * Light of HISTORY, CARRIED, SLICES and PROBE_HISTORY is divided by the
 * exposure of its frame (hbil_frame.exposure); all other light is not.
 *
 * In orthographic views SPLIT has -z in place of the inverse depth, and there
 * is no surface below -5e29.
 *
 * GATHERED has two optional values.  The share of the hemisphere whose light is
 * unknown is stored with HBIL_FALLBACK_FRAME_MEAN, unless facing_fade[1] is -1;
 * recompose fills this light in.  The weight of the slice, 1 on average, is
 * stored behind it with a single slice and the filter; with
 * sampling.slice_frames above 1, that of all slices that are known, over their
 * number.  It is always a float.
 *
 * With the output glossy, GATHERED ends with five floats, sums over the lobes
 * of the pixel's half-slices: radiance RGB, the part of the lobe whose light is
 * known, and the whole lobe.  In RESOLVED, the first four over the fifth
 * follow the bent normal.
 *
 * AO and the bent normal are those of the near field.  Where the outputs show
 * others (hbil_model.ao_radius), gather and recompose write three stages more,
 * which have the values and the layouts of their namesakes without E_near,
 * unknown and glossy values:
 *   AO_GATHERED, AO_RESOLVED, AO_SLICES
 * Who replaces one of these passes writes both of its stages.  Of
 * error_estimate AO_RESOLVED has the first value.
 *
 * PROBE_HISTORY, of plans that have a cache_method, is what the light of the
 * radiance cache is averaged with in the next frame: plane_pitch floats in all,
 * row_pitch for each line of probes, in an order of their own.  It is copied as
 * a whole.
 *
 * SLICES, of plans with sampling.slice_frames above 1, is what the slices of
 * the last frames found.  It is copied as a whole, too: plane_pitch floats.
 *
 * SLICES and PROBE_HISTORY alternate between two buffers, and so does HISTORY
 * if an output is an HBIL_IMAGE.  Call hbil_plan_buffer() again after every
 * frame.
 *
 * With HBIL_STORAGE_PACKED, some stages are planes of 32-bit words:
 *   HISTORY    2: inverse depth (a float); light, as SPLIT's radiance
 *   CARRIED    2: light, as SPLIT's radiance; weight (a float)
 *   SPLIT      3: inverse depth (a float); normal; radiance
 *   GATHERED   3: AO; E_near; bent normal
 *
 *   normal     octahedral map: u in the low 16 bits, v in the high ones; two's
 *              complement over 32767.  Let z = |u| + |v| - 1.  If z is above 0,
 *              u and v move towards 0 by z.  Then n is (u, v, z), normalized
 *   radiance   red in the lowest byte, green, blue; times 2^(byte 3 - 127)
 *   AO         the low 16 bits, over 65535; byte 2: the unknown share, over
 *              255; byte 3: the exponent of E_near
 *   E_near     10 bits red (the lowest), green, blue; times 2^(exponent - 127)
 *   bent       x in the lowest 11 bits and y in the next 11, over 1023; z in
 *   normal     the highest 10, over 511; two's complement
 *
 * A plan stores only what its outputs need.  hbil_buffer.values is the number
 * of values that it has, from the first on:
 *   SPLIT               4 without radiance (packed: 2)
 *   GATHERED, RESOLVED  4 without bent normals (packed GATHERED: 2), and 1 with
 *                       AO alone (packed GATHERED: 1)
 * The weight of a single slice and glossy light come on top, as do the 1 or 2
 * values of error_estimate in RESOLVED.  If GATHERED has the unknown share and
 * there is an output `unknown`, RESOLVED ends with that share, filtered.
 * HISTORY and CARRIED exist if light is carried over: with a reprojection, and
 * with near_irradiance, indirect, beauty or glossy among the outputs
 * (far_irradiance too with HBIL_FAR_FRAME, and `unknown` where anything can be
 * a guess).
 *
 * Value p of pixel (x,y) has this index in full-resolution stages:
 *   p * plane_pitch + y * row_pitch + x + origin
 * SPLIT and GATHERED are layered.  Pixel (x,y) lies in layer 4 (y mod 4) +
 * (x mod 4), with this index:
 *   p * plane_pitch + layer * layer_pitch + (y/4) * row_pitch + x/4 + origin
 * The layers of SPLIT have padding around them that holds "no surface".  At
 * half resolution (hbil_config_resolution()), GATHERED has values only where x
 * and y are even.
 */
typedef enum hbil_stage {
  HBIL_STAGE_HISTORY = 0,
  HBIL_STAGE_CARRIED = 1,
  HBIL_STAGE_SPLIT = 2,
  HBIL_STAGE_GATHERED = 3,
  HBIL_STAGE_RESOLVED = 4,
  HBIL_STAGE_SLICES = 5,
  HBIL_STAGE_AO_GATHERED = 6,
  HBIL_STAGE_AO_RESOLVED = 7,
  HBIL_STAGE_AO_SLICES = 8,
  HBIL_STAGE_PROBE_HISTORY = 9
} hbil_stage;

typedef struct hbil_buffer {
  cl_mem buffer;  /* owned by the plan; not retained for the caller */
  cl_uint values; /* per pixel */
  size_t plane_pitch, layer_pitch, row_pitch, origin; /* in floats or words */
} hbil_buffer;

/* Returns the buffer of a stage and the layout of its values.  The status is
 * HBIL_INVALID_ARGUMENT if the plan has no such stage. */
HBIL_API hbil_status hbil_plan_buffer(const hbil_plan *plan, hbil_stage stage,
                                      hbil_buffer *out);

/* Enqueues the passes of a frame from `first` to `last`, of HBIL_PASS_REPROJECT
 * to HBIL_PASS_COMPOSITE, in their order.  All else is as in
 * hbil_enqueue_frame(), which enqueues all of them.  Images are copied, and
 * normals rebuilt, as far as these passes use them.  Only the planes that they
 * use are checked.  With HBIL_PASS_COMPOSITE, the frame becomes the plan's last
 * one.  Passes that have nothing to do, such as reproject without a history,
 * give an event that follows the wait list, and what comes after them follows
 * it, too.  HBIL_INVALID_ARGUMENT if `first` and `last` are no such passes. */
HBIL_API hbil_status hbil_enqueue_passes(
    hbil_plan *plan, cl_command_queue queue, const hbil_frame *frame,
    hbil_pass first, hbil_pass last, cl_uint wait_count,
    const cl_event *wait_list, cl_event *event);

/* What the next frame takes from the last one. */
typedef struct hbil_last_frame {
  hbil_camera camera; /* that saw it; all zero: there was none */
  /* How many bounces the light of HISTORY has had: 1 after a first frame, at
   * most 256.  The guess of unseen light depends on it (HBIL_FAR_FRAME).
   * 0: HISTORY holds nothing. */
  cl_uint bounces;
  /* CL_TRUE: SLICES, and AO_SLICES where the plan has it, hold what its slices
   * found.  CL_FALSE behind static frames, which search all slices. */
  cl_bool has_slices;
  cl_bool has_probes; /* CL_TRUE: PROBE_HISTORY holds its light */
} hbil_last_frame;

/* Returns what the next frame will take.  Behind hbil_plan_follow(), and before
 * a frame, that is in the buffers of the plan that is followed.
 * HBIL_INVALID_ARGUMENT if plan or out is null. */
HBIL_API hbil_status hbil_plan_last_frame(const hbil_plan *plan,
                                          hbil_last_frame *out);

/* Lets the next frame start from `last`, which hbil_plan_last_frame() returned
 * for a plan of the same configuration, perhaps in an earlier process.  The
 * caller writes HISTORY, PROBE_HISTORY, SLICES and AO_SLICES, as far as `last`
 * has them, into the buffers that hbil_plan_buffer() returns, before or after
 * this call.  What the plan itself has no stage for counts as missing, and
 * bounces above 256 as 256.  If `last` is all zero, there was no frame, and the
 * next one is a first frame.  The next frame's static_frame is ignored.
 * Returns HBIL_INVALID_ARGUMENT if plan or last is null, and HBIL_INVALID_FRAME
 * if the camera is invalid; then the plan is as before. */
HBIL_API hbil_status hbil_plan_adopt_history(hbil_plan *plan,
                                             const hbil_last_frame *last);

#ifdef __cplusplus
}
#endif

#endif
