/* Staged planes: inputs and outputs that the passes don't read or write where
 * the caller has them.  A staged plane has a buffer of the plan's, planar and
 * of floats, which the passes take for the caller's plane.  Inputs are brought
 * there before a frame's first pass, outputs are copied from there after its
 * last one.  Staged are images, and normals that are rebuilt from depth. */
#ifndef HBIL_IMPORT_H
#define HBIL_IMPORT_H

#include "commands.h"

/* Finds the staged planes of a checked configuration and gives them the format
 * that the passes see.  Fails if there are images and the device has none. */
hbil_status stage_planes(hbil_context *context, hbil_config *config,
                         staging *out);

/* That the size and the format of an image suit that plane. */
hbil_status check_image(hbil_plan *plan, int plane, cl_mem image);

/* The frame as the passes see it. */
hbil_frame staged_frame(const hbil_plan *plan, const hbil_frame *given);

/* Fills those of `planes` that are staged inputs.  staged: given, as
 * staged_frame() returns it. */
hbil_status enqueue_import(commands *chain, const hbil_frame *given,
                           const hbil_frame *staged, unsigned planes);

/* Launches the kernels of both, as trial launches. */
hbil_status try_import(commands *chain, const hbil_frame *frame);

/* Copies those of `planes` that are staged outputs to the caller. */
hbil_status enqueue_export(commands *chain, const hbil_frame *given,
                           unsigned planes);

#endif
