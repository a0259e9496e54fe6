/*
 * In front of OpenCL: a test program that is linked with this has the library's
 * OpenCL calls, and its own, pass through here.  They are counted, one of them
 * can be made to fail, references to objects are kept books on, and buffers can
 * be made with guards around them.
 */
#ifndef HBIL_TEST_SHIM_H
#define HBIL_TEST_SHIM_H

#include "support.h"

/* The nth call from now on fails with `error`, and is not passed on; releases
 * are, since nobody could make up for them.  0: none fails. */
void shim_fail(int nth, cl_int error);
/* The call that has failed since; NULL: none yet. */
const char *shim_failed(void);

/* References to OpenCL objects that have been taken and not been given back.
 * Giving back more than was taken aborts. */
long shim_held(void);

/* From now on no source is built a second time, but what it first became is
 * handed out again: for tests of one configuration that would build it often.
 * false: lets go of what is kept. */
void shim_keep_programs(bool keep);

/* From now on kernels run in work-groups of this size, in x and y, and their
 * rows of groups from the last to the first: an order that no kernel may ask
 * for.  There are as many work-items more as whole groups take, which kernels
 * ignore.  NULL: as the library has it. */
void shim_use_groups(const size_t *group);

/* From now on buffers are made with guards before and behind them, and begin
 * full of not-a-numbers, as the guards are.  A buffer keeps its guards until it
 * is released. */
void shim_guard_buffers(bool guard);
/* Bytes of guards that are no longer what they were. */
size_t shim_trespasses(cl_command_queue queue);

/* Buffers made since the count began. */
typedef struct shim_buffers {
  size_t bytes;
  int count;
} shim_buffers;
void shim_start_counting(void);
shim_buffers shim_made(void);

#endif
