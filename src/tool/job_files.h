/* All files that a job reads and writes. */
#ifndef HBIL_TOOL_JOB_FILES_H
#define HBIL_TOOL_JOB_FILES_H

#include "image/error.h"
#include "tool/job.h"

/*
 * Makes the output folder and its parents if they are missing, and checks that
 * results and the contact sheet can be written.  A dry run only looks.
 *
 * Then it checks, before anything is written, that the job replaces none of the
 * files that it reads, writes none twice, and replaces nothing unasked:
 * existing files only with --overwrite or --resume, with the latter only its
 * own; the contact sheet replaces only pictures that hbil wrote, and
 * --cache-save only caches.  All names of the job are known.  0, or -1 with
 * `error` filled.
 */
int job_files_prepare(job *j, image_error *error);

#endif
