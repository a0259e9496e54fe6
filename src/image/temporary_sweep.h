/* Removes what killed jobs have left. */
#ifndef HBIL_IMAGE_TEMPORARY_SWEEP_H
#define HBIL_IMAGE_TEMPORARY_SWEEP_H

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Removes a folder's temporary files that no living job is writing, no matter
 * which job made them. A living job holds a lock on its file. Locks that other
 * machines hold may be invisible here. So files of other machines, files from
 * before a restart, and files where locks don't work must also be unchanged for
 * an hour.  What can't be removed stays.
 */
void temporary_sweep(const char *folder);

#ifdef __cplusplus
}
#endif

#endif
