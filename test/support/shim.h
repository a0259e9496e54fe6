/*
 * A layer between a test program and OpenCL.  In a program that is linked with
 * it, all OpenCL calls of the library and of the test pass through here: they
 * are counted, one can be made to fail, references to objects are counted, and
 * buffers can be surrounded with guard bytes.
 */
#ifndef HBIL_TEST_SHIM_H
#define HBIL_TEST_SHIM_H

#include <stdbool.h>
#include <stddef.h>

#include "hbil/hbil.h"

/* Makes the nth call from now on return `error` without being executed.  Calls
 * that release are executed nevertheless, since no caller could release the
 * object again.  0: no call fails. */
void shim_fail(int nth, cl_int error);
/* Name of the call that has failed since; NULL: none yet. */
const char *shim_failed(void);

/* References to OpenCL objects that have been taken and not yet released.
 * Releasing more than was taken aborts the program. */
long shim_references(void);

/* true: from now on each source is built once, and its program is handed out
 * again whenever the same source comes.  For tests that create plans of one
 * configuration many times.  false: releases those programs. */
void shim_reuse_programs(bool reuse);

/* true: from now on no source is built, and every kernel is one that does
 * nothing.  Plans can be created within milliseconds, but not run. */
void shim_skip_builds(bool skip);

/* From now on kernels run in work-groups of this size, in x and y, and rows of
 * work-groups run from the last to the first.  Rounding up to whole groups adds
 * work-items, which kernels must ignore.  NULL: the library's own groups. */
void shim_use_groups(const size_t *group);

/* true: from now on buffers are created with guard bytes before and behind
 * them, and everything in them is a not-a-number at first.  A buffer's guards
 * stay until it is released. */
void shim_guard_buffers(bool guard);
/* Number of guard bytes that have changed. */
size_t shim_overwritten(cl_command_queue queue);

/* Buffers that were created since shim_start_counting(). */
typedef struct shim_buffers {
  size_t bytes;
  int count;
} shim_buffers;
void shim_start_counting(void);
shim_buffers shim_created(void);

#endif
