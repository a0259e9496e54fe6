/* Pictures of what a radiance cache knows, seen from a frame's camera. */
#ifndef HBIL_TOOL_CACHE_PICTURE_H
#define HBIL_TOOL_CACHE_PICTURE_H

#include "exact/saved_cache.h"
#include "image/picture.h"
#include "image/window.h"
#include "tool/job.h"

/*
 * Makes a picture of the pixels of f that are in `shown`, width x height pixels
 * large: the radiance of the voxel that a pixel's ray meets, tone-mapped with
 * this exposure; grey where it leaves the cache through what views have seen;
 * dark stripes where it passes through what no view has seen.  0, or -1 if
 * memory runs out.
 */
int cache_picture(const exact_saved_cache *cache, const job_frame *f,
                  const image_window *shown, uint32_t width, uint32_t height,
                  float exposure, picture *out);

#endif
