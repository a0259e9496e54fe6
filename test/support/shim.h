/*
 * A layer between the test programs and OpenCL, which all OpenCL calls of the
 * library and of the test pass through.  One call can be made to fail,
 * references to objects are counted, buffers can be surrounded with guard
 * bytes, and no program is built twice in a process.
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
/* How many calls are left until the one that fails. */
int shim_remaining(void);

/* References to OpenCL objects that have been taken and not yet released.
 * Releasing more than was taken aborts the program. */
long shim_references(void);
/* Events that commands have made so far. */
long shim_events_made(void);

/* true: from now on no source is built, and every kernel is one that does
 * nothing.  Plans can be created within milliseconds, but not run. */
void shim_skip_builds(bool skip);
/* Begins a test that creates plans but runs none, so that it needs no kernel.
 * (Under valgrind they would be compiled for its own idea of a processor.) */
#define TEST_WITHOUT_KERNELS(name)                                             \
  TEST_WITH(name, shim_begin_skipping, shim_end_skipping)
int shim_begin_skipping(void **state), shim_end_skipping(void **state);

/* true: from now on plans and caches of a context share programs, as they do
 * without the shim.  Else each builds its own, so that what a test sees doesn't
 * depend on what was created before it. */
void shim_share_programs(bool share);

/* From now on kernels run in work-groups of this size, in x and y, and rows of
 * work-groups run from the last to the first.  Rounding up to whole groups adds
 * work-items, which kernels must ignore.  NULL: the library's own groups. */
void shim_use_groups(const size_t *group);

/* From now on no kernel but the one of this name is launched, so that no driver
 * compiles the others; NULL: all are. */
void shim_launch_only(const char *kernel);

/* The value that argument `index` of a kernel of this name was last set to: so
 * a test gets at buffers that the library doesn't show, and at what it computes
 * for a kernel.  Fails the program unless the value has that size. */
void shim_argument(const char *kernel, cl_uint index, size_t size, void *value);
/* Whether it was ever set. */
bool shim_has_argument(const char *kernel, cl_uint index);

/* From now on clGetDeviceInfo() answers one question by `size` bytes at
 * `value`, which must stay valid; NULL: it answers all by itself. */
void shim_answer(cl_device_info what, const void *value, size_t size);

/* true: from now on buffers, but for those in memory of the caller's, are
 * created with guard bytes before and behind them, and everything in them is a
 * not-a-number at first.  A buffer's guards stay until it is released. */
void shim_guard_buffers(bool guard);
/* Number of guard bytes that have changed. */
size_t shim_overwritten(cl_command_queue queue);

/* Adapts the shim to oclgrind 21.10.  Buffers are filled by writing all of
 * them, because oclgrind takes a filled part of a buffer for uninitialized,
 * whatever is stored there later, and a part that is written behind the
 * buffer's beginning as well.  Releases of objects that were never seen here
 * are oclgrind's own. */
void shim_under_oclgrind(bool is_oclgrind);

/* Buffers that were created since shim_start_counting(). */
typedef struct shim_buffers {
  size_t bytes;
  int count;
  int hosted; /* those that were given a pointer of the caller's */
} shim_buffers;
void shim_start_counting(void);
shim_buffers shim_created(void);
/* Destructors of memory objects that are yet to be called. */
long shim_destructors(void);

#endif
