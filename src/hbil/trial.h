/* Trial launches: what drivers compile at the first launch of a kernel. */
#ifndef HBIL_TRIAL_H
#define HBIL_TRIAL_H

#include "plan.h"

/* Launches every kernel of the plan once, in the work-groups and with the
 * numbers of work-items of frames.  Its arguments are those of pictures without
 * pixels, so it does nothing, and nothing that frames read is changed.  queue
 * must be in order. */
hbil_status launch_every_kernel(hbil_plan *plan, cl_command_queue queue);

#endif
