/*
 * The drivers that OpenCL's loader is told to load.  It says nothing of those
 * that it can't load; here is why.
 */
#ifndef HBIL_TOOL_DRIVERS_H
#define HBIL_TOOL_DRIVERS_H

/* Receives the .icd file of a driver that can't be loaded, and the reason. */
typedef void (*driver_failure)(void *user, const char *file, const char *why);

/* Loads all drivers that are installed, as the loader does, and tells of those
 * that can't be loaded. */
void drivers_check(driver_failure tell, void *user);

#endif
