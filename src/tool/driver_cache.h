/* PoCL's folder for compiled kernels. */
#ifndef HBIL_TOOL_DRIVER_CACHE_H
#define HBIL_TOOL_DRIVER_CACHE_H

#include "image/error.h"

/*
 * PoCL has no device if it can't write there, and ends the process if the disk
 * is full.  So another folder, of this user alone, takes its place
 * (POCL_CACHE_DIR of this process) where it can't be written or lacks room.
 * PoCL must not have been asked for devices yet.  *note: a sentence on that,
 * malloc'd, or NULL if all is well.  0, or -1 with `error` filled if no folder
 * can be written.
 */
int driver_cache_prepare(char **note, image_error *error);

#endif
