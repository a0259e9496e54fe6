/* Removes what killed jobs have left. */
#ifndef HBIL_IMAGE_TEMPORARY_SWEEP_H
#define HBIL_IMAGE_TEMPORARY_SWEEP_H

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Removes the temporary files of a folder whose jobs have ended, whatever jobs
 * they were.  A living job holds a lock on its file.  Locks of other machines
 * may not show, so files of other machines, and files where locks don't work,
 * must also be unchanged for an hour.  What can't be removed stays.
 */
void temporary_sweep(const char *folder);

#ifdef __cplusplus
}
#endif

#endif
