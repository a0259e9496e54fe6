/* The commands of one call: a chain, each waiting for the one before, and the
 * first for the plan's commands of earlier calls. */
#ifndef HBIL_COMMANDS_H
#define HBIL_COMMANDS_H

#include "plan.h"

/* The kernels that have had a trial launch: without and with an offset of their
 * rows, which compilers may tell apart. */
typedef struct trial_launches {
  bool launched[KERNEL_COUNT][2];
} trial_launches;

typedef struct commands {
  hbil_plan *plan;
  cl_command_queue queue;
  cl_uint wait_count; /* what the next command waits for */
  const cl_event *wait_list;
  bool in_order;
  bool events;      /* every command makes an event */
  bool enqueued;    /* a command has been */
  bool retained;    /* `queue`, for this call */
  bool reprojected; /* by this call */
  hbil_pass pass;
  cl_event last; /* of the last command; owned */
  /* the wait list of the first command, if it isn't the caller's own: the
   * plan's tail, and a marker after the caller's list; the marker is owned */
  cl_event before[2];
  /* NULL except for trial launches (trial.h), which it counts */
  trial_launches *trial;
} commands;

/* Begins a chain whose plan, queue and in_order are set: its first command will
 * wait for the caller's list and for the plan's earlier commands.  Nothing is
 * enqueued and no event is made if these are in the same in-order queue. */
hbil_status begin_commands(commands *chain, cl_uint wait_count,
                           const cl_event *wait_list);

/* Makes the chain's commands, if there are any, the plan's last ones.  To be
 * called after begin_commands(), whether or not that or a command failed. */
void end_commands(commands *chain);

/* Enqueues a marker: the plan's later commands wait for what the chain waits
 * for. */
hbil_status enqueue_marker(commands *chain);

/* A kernel's argument. */
typedef struct argument {
  size_t size;
  const void *value;
  bool is_memory; /* a buffer, no value */
} argument;

#define ARG(x)                                                                 \
  { sizeof(x), &(x), _Generic((x), cl_mem : true, default : false) }
/* A buffer of the plan. */
#define BUFFER_ARG(plan, i) ARG((plan)->buffers[i])

/* Enqueues a kernel with x * y * z work-items, rounded up to whole groups,
 * which kernels ignore; rows of work-items from `top` on. */
hbil_status launch_rows(commands *chain, int kernel, const argument *args,
                        cl_uint count, size_t top, size_t x, size_t y,
                        size_t z);

#define LAUNCH_ROWS(chain, kernel, args, top, x, y, z)                         \
  launch_rows((chain), (kernel), (args),                                       \
              (cl_uint)(sizeof(args) / sizeof *(args)), (top), (x), (y), (z))
#define LAUNCH(chain, kernel, args, x, y, z)                                   \
  LAUNCH_ROWS(chain, kernel, args, 0, x, y, z)

/* Fills a buffer with copies of a word. */
hbil_status enqueue_fill(commands *chain, int buffer, cl_uint word);

/* Sets one of HBIL_FLAG_. */
hbil_status set_flag(commands *chain, int flag, cl_uint value);

/* Clears `words` counts of sanitized pixels from `first` on. */
hbil_status clear_counts(commands *chain, int first, int words);

#endif
