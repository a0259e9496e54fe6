/* What OpenCL drivers need before they are asked, and why some are missing. */
#ifndef HBIL_TOOL_DRIVERS_H
#define HBIL_TOOL_DRIVERS_H

#include "image/error.h"

/* ------------------------------------------------------------------------ */
/* PoCL's folder for compiled kernels                                        */

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

/* ------------------------------------------------------------------------ */
/* The drivers that OpenCL's loader is told to load                          */

/* Receives the .icd file of a driver that can't be loaded, and the reason. */
typedef void (*driver_failure)(void *user, const char *file, const char *why);

/* Loads all drivers that are installed, as the loader does, and tells of those
 * that can't be loaded. */
void drivers_check(driver_failure tell, void *user);

#endif
