/* Commands in OpenCL queues.  Those of one call are a chain: each waits for the
 * one before, and the first for earlier calls on the same objects. */
#ifndef HBIL_TIMELINE_H
#define HBIL_TIMELINE_H

#include "kernel_set.h"

/* The commands on one object, which run one after the other, whatever queues
 * they go to.  The next one waits for `tail`; NULL: for all that is in `queue`
 * so far. */
typedef struct timeline {
  cl_command_queue queue; /* of the last command, retained; NULL: none yet */
  bool in_order;          /* that queue */
  cl_event tail;
} timeline;

/* The objects whose order a chain follows: a plan, the cache that its frame
 * uses, and the plan that it follows; or a cache alone. */
enum { LINES = 3 };

/* The events of commands whose times somebody asks for. */
enum { MOST_TIMED = 80 };
typedef struct command_times {
  int count;
  cl_event events[MOST_TIMED];
  int owner[MOST_TIMED]; /* commands.owner */
  cl_int error;          /* why some are missing */
} command_times;

/* The kernels that have had a trial launch. */
typedef struct trial_launches {
  bool launched[MOST_KERNELS];
} trial_launches;

typedef struct commands {
  hbil_context *context;
  const kernel_set *kernels;
  timeline *line[LINES]; /* NULL: none */
  cl_command_queue queue;
  cl_uint wait_count; /* what the next command waits for */
  const cl_event *wait_list;
  bool in_order;
  bool events;          /* every command makes an event */
  bool enqueued;        /* a command has been */
  bool retained[LINES]; /* `queue`, for this call */
  command_times *times; /* NULL: nobody asks */
  int owner;            /* whose times the next commands' are */
  cl_event last;        /* of the last command; owned */
  /* the wait list of the first command, if it isn't the caller's own: the tails
   * of the timelines, and a marker after the caller's list; the marker is owned
   */
  cl_uint befores;
  cl_event before[LINES + 1], marker;
  /* NULL except for trial launches, which it counts */
  trial_launches *trial;
} commands;

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
/* Enqueues a kernel with x * y * z work-items, rounded up to whole groups,
 * which kernels ignore.
 *
 * In trial launches each kernel is enqueued once, so that drivers compile it
 * which do so at the first launch.  Their values are all 0: pictures have no
 * pixels, so no work-item has anything to do. */
hbil_status launch_kernel(commands *chain, int kernel, const argument *args,
                          cl_uint count, size_t x, size_t y, size_t z);

#define LAUNCH(chain, kernel, args, x, y, z)                                   \
  launch_kernel((chain), (kernel), (args),                                     \
                (cl_uint)(sizeof(args) / sizeof *(args)), (x), (y), (z))

/* Fills `bytes` of memory from `offset` on with copies of a word. */
hbil_status fill_memory(commands *chain, cl_mem memory, cl_uint word,
                        size_t offset, size_t bytes);

/* Reads `bytes` of a buffer to the host, and waits for that. */
hbil_status read_memory(const commands *chain, cl_mem memory, size_t bytes,
                        void *out);

/* Drops the events, when another frame begins. */
void forget_times(command_times *times);

/* Enqueues the first commands of an object in a queue, which is in order. */
typedef hbil_status first_commands(void *object, cl_command_queue queue);

/* Runs them in a queue of their own, and waits. */
hbil_status run_first_commands(hbil_context *context, first_commands *enqueue,
                               void *object);

#endif
