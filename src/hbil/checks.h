/* What a caller hands in with a frame, checked before anything is enqueued. */
#ifndef HBIL_CHECKS_H
#define HBIL_CHECKS_H

#include "plan.h"

/* The frame's camera, environment, static_frame, and those planes. */
hbil_status check_frame(hbil_plan *plan, const hbil_frame *frame,
                        unsigned planes);

/* A wait list of a public function. */
hbil_status check_wait_list(hbil_context *context, const char *function,
                            cl_uint wait_count, const cl_event *wait_list);

/* That the queue fits the plan; *in_order tells its kind. */
hbil_status check_queue(hbil_plan *plan, cl_command_queue queue,
                        bool *in_order);

#endif
