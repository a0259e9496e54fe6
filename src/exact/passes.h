/*
 * The passes one by one, as a test runs them against the kernels.
 *
 * Layouts of the planes that passes exchange (SPLIT, GATHERED, RESOLVED,
 * HISTORY, CARRIED) are in kernels/shared.h.  All planes of a call have
 * the size of frame->config.  Passes that return nothing cannot fail; they do
 * not check what they are given.
 */
#ifndef HBIL_EXACT_PASSES_H
#define HBIL_EXACT_PASSES_H

#include "exact/exact.h"
#include "lib/estimate_args.h"
#include "shared.h"

/* The arguments of the sampling pattern, and the camera, as the kernels get
 * them. */
hbil_pattern_args exact_pattern(const exact_frame *frame);
hbil_view_args exact_view(const hbil_config *config, const hbil_camera *camera);

/* HISTORY of the previous frame, of any size, -> CARRIED, by the cameras or by
 * motion vectors as configured.  Writes every pixel. */
exact_status exact_reproject(const exact_frame *frame,
                             const exact_planes *history,
                             exact_planes *carried);
/* Fills the holes of CARRIED, where its weight is 0. */
exact_status exact_push_pull(exact_planes *carried);
/* Inputs and CARRIED (NULL: no history) -> SPLIT. */
void exact_split(const exact_frame *frame, const exact_planes *carried,
                 exact_planes *split);
/* SPLIT, GATHERED and inputs -> frame->estimate, which recompose and composite
 * use for light that the screen does not show. */
void exact_estimate_frame(exact_frame *frame, const exact_planes *split,
                          const exact_planes *gathered);
/* The estimate: what the frame's surfaces send towards a receiver with that
 * view-space normal, after all bounces.  channel: 0 red, 1 green, 2 blue. */
double exact_frame_radiance(const exact_frame *frame, int channel,
                            const double normal[3]);

/* SPLIT -> GATHERED, at the samples that the kernels take.  GATHERED has
 * HBIL_LIGHT_PLANES or more planes; the further ones are written where they are
 * there and the settings use them.  Pixels that aren't gathered get zeros. */
exact_status exact_gather(const exact_frame *frame, const exact_planes *split,
                          exact_planes *gathered);
/* The same without sampling error: every pixel on the line of each slice. */
exact_status exact_gather_dense(const exact_frame *frame,
                                const exact_planes *split,
                                const exact_dense *how, exact_planes *gathered);
/* Whether recompose weighs a pixel's slice against its neighbours': GATHERED
 * then has HBIL_LIGHT_WEIGHT, which is 0 otherwise. */
bool exact_weighs_slices(const hbil_config *config);

/* SPLIT, GATHERED -> RESOLVED.  RESOLVED has HBIL_LIGHT_PLANES or more planes;
 * HBIL_LIGHT_UNKNOWN is written where it is there and the settings use it, and
 * so are the planes of exact/glossy.h. */
void exact_recompose(const exact_frame *frame, const exact_planes *split,
                     const exact_planes *gathered, exact_planes *resolved);
/* RESOLVED -> outputs and the next frame's HISTORY.  Without HBIL_LIGHT_UNKNOWN
 * in RESOLVED, that share counts as 0. */
void exact_composite(const exact_frame *frame, const exact_planes *resolved,
                     exact_planes *out, exact_planes *history);
/* RESOLVED of a search of its own (exact_searches_ao()) -> ao, its error,
 * bent_normal and cone_cosine.  To be called behind exact_composite(). */
void exact_composite_ao(const exact_frame *frame, const exact_planes *resolved,
                        exact_planes *out);

/* The real orthonormal spherical harmonics of bands 0 to 2 at a unit direction,
 * in the order of hbil_frame.environment. */
void exact_sh_basis(const double direction[3], double basis[9]);

#endif
