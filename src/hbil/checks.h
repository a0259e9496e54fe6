/* What callers hand in with a frame or a view, checked before anything is
 * enqueued. */
#ifndef HBIL_CHECKS_H
#define HBIL_CHECKS_H

#include "buffers.h"
#include "staging.h"

/* What planes have to fit. */
typedef struct plane_rules {
  hbil_context *context;
  const hbil_config *config; /* size and formats, those of staged planes as the
                                passes see them */
  const staging *staged;
  memory_range lent; /* scratch memory, in which no plane may lie */
} plane_rules;

/* Those planes of a frame, and the projection of its depths. */
hbil_status check_planes(const plane_rules *rules, const hbil_frame *frame,
                         unsigned planes);

/* A wait list of a public function. */
hbil_status check_wait_list(hbil_context *context, const char *function,
                            cl_uint wait_count, const cl_event *wait_list);

/* That the queue is for the context's device, and has profiling if that is
 * asked for; *in_order tells its kind. */
hbil_status check_queue(hbil_context *context, cl_command_queue queue,
                        bool profiling, bool *in_order);

#endif
