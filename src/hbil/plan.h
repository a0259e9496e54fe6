/* A plan: the kernels and buffers of one configuration, and the state that its
 * frames hand on. */
#ifndef HBIL_PLAN_H
#define HBIL_PLAN_H

#include "context.h"
#include "layout.h"

enum {
  PROGRAM_REPROJECT,
  PROGRAM_PUSH_PULL,
  PROGRAM_LAYERS,
  PROGRAM_SPLIT,
  PROGRAM_ESTIMATE,
  PROGRAM_GATHER,
  PROGRAM_GATHER_AND_CACHE,
  PROGRAM_REGATHER,
  PROGRAM_RECOMPOSE,
  PROGRAM_TEMPORAL,
  PROGRAM_PROBE_RAYS,
  PROGRAM_PROBE_CONES,
  PROGRAM_PROBE_LPV,
  PROGRAM_PROBE_RSM,
  PROGRAM_FILTER_PROBES,
  PROGRAM_PROBE_GLOSSY,
  PROGRAM_GLOSSY,
  PROGRAM_COMPOSITE,
  PROGRAM_IMPORT,
  PROGRAM_EXPORT,
  PROGRAM_NORMALS_FROM_DEPTH,
  PROGRAM_COUNT
};

enum {
  KERNEL_REPROJECT,
  KERNEL_FIND_HOLES,
  KERNEL_PUSH,
  KERNEL_PULL,
  KERNEL_CLEAR_PADDING,
  KERNEL_SPLIT,
  KERNEL_RELIGHT,
  KERNEL_BOUND_CELLS,
  KERNEL_BOUND_QUADRANTS,
  KERNEL_ESTIMATE_PART,
  KERNEL_ESTIMATE_LANES,
  KERNEL_ESTIMATE_SUM,
  KERNEL_ESTIMATE_FILL,
  KERNEL_PATTERN,
  KERNEL_GATHER,
  KERNEL_GATHER_AND_CACHE,
  KERNEL_REGATHER,
  KERNEL_RECOMPOSE,
  KERNEL_TEMPORAL,
  KERNEL_PROBE_RAYS,
  KERNEL_PROBE_CONES,
  KERNEL_PROBE_LPV,
  KERNEL_PROBE_RSM,
  KERNEL_FILTER_PROBES,
  KERNEL_PROBE_GLOSSY,
  KERNEL_GLOSSY,
  KERNEL_COMPOSITE,
  KERNEL_IMPORT_IMAGE,
  KERNEL_EXPORT_IMAGE,
  KERNEL_NORMALS_FROM_DEPTH,
  KERNEL_COUNT
};

/* The most commands of a frame, for the profiling events: two for each level of
 * the push/pull chain, one for each staged plane, and the others. */
enum { MAX_LAUNCHES = 2 * MAX_CHAIN + PLANE_COUNT + 30 };

/* A part of a buffer that is nobody's sub-buffer. */
typedef struct memory_range {
  cl_mem memory;
  size_t start, bytes;
} memory_range;

/* The commands on one object, which run one after the other, whatever queues
 * they go to.  The next one waits for `tail`; NULL: for all that is in `queue`
 * so far. */
typedef struct timeline {
  cl_command_queue queue; /* of the last command, retained; NULL: none yet */
  bool in_order;          /* that queue */
  cl_event tail;
} timeline;

/* The light of more bounces differs by less than a rounding: 0.9^n < 2^-24. */
enum { MOST_BOUNCES = 256 };

struct hbil_plan {
  hbil_context *context;
  hbil_config config; /* formats: as the passes see them (import.h) */
  layout layout;
  cl_mem buffers[BUFFER_COUNT];
  memory_range lent; /* the caller's scratch memory; memory is null: none */
  cl_program programs[PROGRAM_COUNT];
  cl_kernel kernels[KERNEL_COUNT];
  timeline line; /* of the plan's commands */
  /* light of the last frame, and where it was seen from */
  bool has_history;
  cl_uint bounces; /* that this light has had, 1 .. MOST_BOUNCES */
  hbil_camera history_camera;
  int history; /* which of its buffers holds the last frame */
  /* the temporal filter: which of its two buffers holds the last frame, and
   * whether the other one has been written since the last composite */
  bool has_temporal, temporal_written;
  int temporal;
  hbil_camera temporal_camera;
  /* the last frame that was composed */
  bool has_last;
  cl_uint static_frames; /* in a row so far, up to HBIL_EXACT_STATIC_FRAMES */
  hbil_camera last_camera;
  cl_uint last_index;
  /* passes of the frame that is being enqueued: whether the host left them out,
   * and whether the device may have */
  bool left_out[HBIL_PASS_COUNT], may_leave_out[HBIL_PASS_COUNT];
  /* whether the last gather has filled the horizon cache, and whether that of
   * the frame that is being enqueued reads it */
  bool cache_filled, cache_used;
  /* of the last frame's staged depths and normals (gather.c); 0: of floats */
  float depth_rounding, normal_rounding;
  /* what the table of steps was last made for */
  bool has_steps;
  hbil_view_args steps_view;
  hbil_pattern_args steps_pattern;
  /* profiling */
  int launches;
  cl_event events[MAX_LAUNCHES];
  cl_int events_error; /* why some are missing */
  hbil_pass event_pass[MAX_LAUNCHES];
};

#endif
