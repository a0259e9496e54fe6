/*
 * The layer beauty of `--beauty replace`: the frame's own picture, in which the
 * light that hbil computes takes the place of the renderer's diffuse indirect
 * light.  What isn't diffuse stays: gloss, glass, smoke, the sky, alpha.
 */
#ifndef HBIL_TOOL_BEAUTY_H
#define HBIL_TOOL_BEAUTY_H

#include "dump/gbuffer.h"
#include "image/error.h"
#include "image/image.h"
#include "tool/job.h"

/* Decides by all frames what beauty is, says so, and adds its alpha to the
 * layers if all frames have one.  0, or -1 with `error` filled. */
int beauty_choose(job *j, image_error *error);

/* Fills in beauty and its alpha from what was read of a frame.  The layer
 * indirect is in the result or among the hidden layers, in radiance like the
 * renderer's. */
void beauty_replace(const gbuffer *g, const image *hidden, image *result);

#endif
