/* PoCL's folder for compiled kernels. */
#ifndef HBIL_TOOL_DRIVER_CACHE_H
#define HBIL_TOOL_DRIVER_CACHE_H

#include "image/error.h"

/*
 * PoCL has no device if it can't write there, and ends the process if the disk
 * is full.  If that folder can't be written or lacks room, this function sets
 * POCL_CACHE_DIR of this process to a folder that belongs to this user alone.
 * Call it before PoCL is asked for devices. *note: a sentence about the new
 * folder, malloc'd, or NULL if the old one stays. Returns 0, also if the old
 * folder lacks room and stays because no other can be made; -1 with `error`
 * filled if no folder can be written.
 */
int driver_cache_prepare(char **note, image_error *error);

#endif
