/*
 * Pixels in the formats that the library reads, stored as renderers store them:
 * rounded to the nearest value that the format has.
 */
#ifndef HBIL_STORE_H
#define HBIL_STORE_H

#include <stdbool.h>
#include <stddef.h>

#include "hbil/hbil.h"

/* Bytes of a component. */
size_t scene_component_size(hbil_component component);
/* Whether a component is a word that holds all channels of a pixel. */
bool scene_is_word(hbil_component component);

/* Stores the channels of a pixel: as components that are `pitch` bytes apart,
 * or as a word, which has 3 channels.  Values are what the format's codes mean;
 * biased: what 2v - 1 of them means, for normals. */
void scene_store(hbil_component component, bool biased, const double *values,
                 int channels, size_t pitch, unsigned char *at);

/* The octahedral coordinates of a direction (HBIL_NORMAL_OCTAHEDRAL). */
void scene_octahedral(const double normal[3], double uv[2]);

/* The value of a depth buffer at planar depth z, where `projection` is
 * hbil_frame.hardware_depth; 0 and infinity: that of the far end. */
double scene_hardware_depth(const double projection[2], bool orthographic,
                            double z);

#endif
