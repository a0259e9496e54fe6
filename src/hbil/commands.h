/* The commands of one call: a chain, each waiting for the one before, and the
 * first for earlier calls on the same objects. */
#ifndef HBIL_COMMANDS_H
#define HBIL_COMMANDS_H

#include "plan.h"

/* The kernels that have had a trial launch: without and with an offset of their
 * rows, which compilers may tell apart. */
typedef struct trial_launches {
  bool launched[KERNEL_COUNT][2];
} trial_launches;

/* The objects whose order a chain follows: a plan, and the cache that its frame
 * uses; or a cache alone. */
enum { LINES = 2 };

typedef struct commands {
  hbil_context *context;
  hbil_plan *plan; /* NULL: commands of a cache */
  cl_kernel *kernels;
  timeline *line[LINES]; /* NULL: none */
  cl_command_queue queue;
  cl_uint wait_count; /* what the next command waits for */
  const cl_event *wait_list;
  bool in_order;
  bool events;          /* every command makes an event */
  bool enqueued;        /* a command has been */
  bool retained[LINES]; /* `queue`, for this call */
  bool reprojected;     /* by this call */
  hbil_pass pass;
  cl_event last; /* of the last command; owned */
  /* the wait list of the first command, if it isn't the caller's own: the tails
   * of the timelines, and a marker after the caller's list; the marker is owned
   */
  cl_uint befores;
  cl_event before[LINES + 1], marker;
  /* NULL except for trial launches (trial.h), which it counts */
  trial_launches *trial;
} commands;

/* A chain for a plan's commands in a queue. */
commands commands_of_plan(hbil_plan *plan, cl_command_queue queue);

/* Begins a chain whose queue and in_order are set: its first command will wait
 * for the caller's list and for earlier commands of the timelines.  Nothing is
 * enqueued and no event is made if these are in the same in-order queue. */
hbil_status begin_commands(commands *chain, cl_uint wait_count,
                           const cl_event *wait_list);

/* Makes the chain's commands, if there are any, the last ones of its timelines.
 * To be called after begin_commands(), whether or not that or a command failed.
 */
void end_commands(commands *chain);

/* Releases what a timeline holds. */
void timeline_end(timeline *line);

/* Enqueues a marker: later commands wait for what the chain waits for. */
hbil_status enqueue_marker(commands *chain);

/* Gives the caller the last command's event.  Passes that had nothing to do
 * enqueue a marker, so that the event and what comes later follow the wait
 * list.  event may be NULL. */
hbil_status finish_commands(commands *chain, cl_event *event);

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

/* Fills `bytes` of memory from `offset` on with copies of a word. */
hbil_status fill_memory(commands *chain, cl_mem memory, cl_uint word,
                        size_t offset, size_t bytes);

/* Fills a buffer of the plan with copies of a word. */
hbil_status enqueue_fill(commands *chain, int buffer, cl_uint word);

/* Sets one of HBIL_FLAG_. */
hbil_status set_flag(commands *chain, int flag, cl_uint value);

/* Clears `words` counts of sanitized pixels from `first` on. */
hbil_status clear_counts(commands *chain, int first, int words);

#endif
