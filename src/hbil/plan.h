/* A plan: the kernels and buffers of one configuration, and the state that its
 * frames hand on. */
#ifndef HBIL_PLAN_H
#define HBIL_PLAN_H

#include "buffers.h"
#include "layout.h"
#include "timeline.h"

/*
 * The programs and kernels of a plan (kernel_set.h).  l is the plan's layout,
 * and the other names in the conditions are those of build_kernels().
 *
 * The gather waits for its samples, so many work-items that spill some of their
 * registers are faster than few that spill none: 1.00 ms with 64 on an H200,
 * 1.03 with 80, 1.09 with 96 and 1.23 with 110, which it would take.
 */
#define PLAN_PROGRAMS(X)                                                       \
  X(PROGRAM_REPROJECT, "reproject", l->history, .relaxed = false)              \
  X(PROGRAM_PUSH_PULL, "push_pull", l->history, .relaxed = false)              \
  X(PROGRAM_LAYERS, "layers", true, .relaxed = false)                          \
  X(PROGRAM_SPLIT, "split", true, .relaxed = false)                            \
  X(PROGRAM_ESTIMATE, "estimate", l->estimate, .relaxed = false)               \
  X(PROGRAM_GATHER, "gather", true, .relaxed = true, .registers = 64)          \
  X(PROGRAM_RECOMPOSE, "recompose", true, .relaxed = true)                     \
  X(PROGRAM_PROBE_RAYS, "cache/probe_rays", method == HBIL_CACHE_METHOD_RAYS,  \
    .relaxed = true)                                                           \
  X(PROGRAM_PROBE_CONES, "cache/probe_cones",                                  \
    method == HBIL_CACHE_METHOD_CONES, .relaxed = true,                        \
    .defines = "-DHBIL_WIDTH=1")                                               \
  X(PROGRAM_PROBE_LPV, "cache/probe_lpv", method == HBIL_CACHE_METHOD_LPV,     \
    .relaxed = false, .defines = "-DHBIL_WIDTH=1")                             \
  X(PROGRAM_PROBE_RSM, "cache/probe_rsm", method == HBIL_CACHE_METHOD_RSM,     \
    .relaxed = true, .defines = "-DHBIL_WIDTH=1")                              \
  X(PROGRAM_FILTER_PROBES, "cache/filter_probes", l->probes, .relaxed = true)  \
  X(PROGRAM_FOLLOW_PROBES, "cache/follow_probes", l->probes, .relaxed = true,  \
    .defines = "-DHBIL_WIDTH=1")                                               \
  X(PROGRAM_PROBE_GLOSSY, "cache/probe_glossy", l->probes && l->glossy,        \
    .relaxed = true)                                                           \
  X(PROGRAM_GLOSSY, "glossy", l->glossy, .relaxed = false)                     \
  X(PROGRAM_COMPOSITE, "composite", true, .relaxed = false)                    \
  X(PROGRAM_IMPORT, "import", imports, .relaxed = false)                       \
  X(PROGRAM_EXPORT, "export", exports, .relaxed = false)                       \
  X(PROGRAM_NORMALS_FROM_DEPTH, "normals_from_depth", rebuilds_normals,        \
    .relaxed = false)

#define PLAN_KERNELS(X)                                                        \
  X(KERNEL_REPROJECT, "reproject", PROGRAM_REPROJECT, true)                    \
  X(KERNEL_FIND_HOLES, "find_holes", PROGRAM_PUSH_PULL, true)                  \
  X(KERNEL_PUSH, "push", PROGRAM_PUSH_PULL, true)                              \
  X(KERNEL_PULL, "pull", PROGRAM_PUSH_PULL, true)                              \
  X(KERNEL_CLEAR_PADDING, "clear_padding", PROGRAM_LAYERS, true)               \
  X(KERNEL_SPLIT, "split", PROGRAM_SPLIT, true)                                \
  X(KERNEL_RELIGHT, "relight", PROGRAM_SPLIT, relights)                        \
  X(KERNEL_BOUND_CELLS, "bound_cells", PROGRAM_LAYERS, bounds)                 \
  X(KERNEL_BOUND_QUADRANTS, "bound_quadrants", PROGRAM_LAYERS, bounds)         \
  X(KERNEL_ESTIMATE_PART, "estimate_part", PROGRAM_ESTIMATE, true)             \
  X(KERNEL_ESTIMATE_LANES, "estimate_lanes", PROGRAM_ESTIMATE,                 \
    l->estimate_lanes > 1)                                                     \
  X(KERNEL_ESTIMATE_SUM, "estimate_sum", PROGRAM_ESTIMATE, true)               \
  X(KERNEL_ESTIMATE_FILL, "estimate_fill", PROGRAM_ESTIMATE, true)             \
  X(KERNEL_PATTERN, "make_pattern", PROGRAM_LAYERS, true)                      \
  X(KERNEL_GATHER, "gather", PROGRAM_GATHER, true)                             \
  X(KERNEL_RECOMPOSE, "recompose", PROGRAM_RECOMPOSE, true)                    \
  X(KERNEL_PROBE_RAYS, "probe_rays", PROGRAM_PROBE_RAYS, true)                 \
  X(KERNEL_PROBE_CONES, "probe_cones", PROGRAM_PROBE_CONES, true)              \
  X(KERNEL_PROBE_LPV, "probe_lpv", PROGRAM_PROBE_LPV, true)                    \
  X(KERNEL_PROBE_RSM, "probe_rsm", PROGRAM_PROBE_RSM, true)                    \
  X(KERNEL_FILTER_PROBES, "filter_probes", PROGRAM_FILTER_PROBES, true)        \
  X(KERNEL_FOLLOW_PROBES, "follow_probes", PROGRAM_FOLLOW_PROBES, true)        \
  X(KERNEL_PROBE_GLOSSY, "probe_glossy", PROGRAM_PROBE_GLOSSY, true)           \
  X(KERNEL_GLOSSY, "glossy", PROGRAM_GLOSSY, true)                             \
  X(KERNEL_COMPOSITE, "composite", PROGRAM_COMPOSITE, true)                    \
  X(KERNEL_IMPORT_IMAGE, "import_image", PROGRAM_IMPORT, true)                 \
  X(KERNEL_EXPORT_IMAGE, "export_image", PROGRAM_EXPORT, true)                 \
  X(KERNEL_NORMALS_FROM_DEPTH, "normals_from_depth",                           \
    PROGRAM_NORMALS_FROM_DEPTH, true)

enum { PLAN_PROGRAMS(LISTED_ENUMERATOR) PROGRAM_COUNT };
enum { PLAN_KERNELS(LISTED_ENUMERATOR) KERNEL_COUNT };
_Static_assert((int)PROGRAM_COUNT <= (int)MOST_PROGRAMS, "MOST_PROGRAMS");
_Static_assert((int)KERNEL_COUNT <= (int)MOST_KERNELS, "MOST_KERNELS");

/* A frame has two commands for each level of the push/pull chain, one for each
 * staged plane, and some 30 others. */
_Static_assert(2 * MAX_CHAIN + (int)PLANE_COUNT + 30 <= (int)MOST_TIMED,
               "MOST_TIMED");

/* The light of more bounces differs by less than a rounding: 0.9^n < 2^-24. */
enum { MOST_BOUNCES = 256 };

/* The search for ao, bent_normal and cone_cosine where the plan has one of its
 * own (ao_search.c).  Its buffers are the plan's. */
typedef struct ao_search {
  hbil_config config;
  layout layout;
  kernel_set kernels;
} ao_search;

/* A history of the last frame in one of two buffers.  A frame writes the other
 * one, which composite makes the history, so a frame that fails leaves none. */
typedef struct alternating {
  bool has, written;  /* there is one; the other buffer has been written */
  int last;           /* which buffer it is in */
  hbil_camera camera; /* that saw it */
} alternating;

/* What a table of steps was last made for. */
typedef struct step_table {
  bool is_made;
  hbil_view_args view;
  hbil_pattern_args pattern;
} step_table;

struct hbil_plan {
  int references; /* of the caller and of each plan that follows it */
  hbil_context *context;
  hbil_config config; /* formats: as the passes see them (staging.h) */
  layout layout;
  cl_mem buffers[BUFFER_COUNT];
  memory_range lent; /* the caller's scratch memory; memory is null: none */
  kernel_set kernels;
  ao_search ao;        /* if layout.ao_search */
  timeline line;       /* of the plan's commands */
  command_times times; /* of the last frame's passes, with profiling */
  /* light of the last frame, and where it was seen from */
  bool has_history;
  cl_uint bounces; /* that this light has had, 1 .. MOST_BOUNCES */
  hbil_camera history_camera;
  int history;  /* which of its buffers holds the last frame */
  bool adopted; /* that light came from hbil_plan_adopt_history() */
  /* else the cache of that frame, which may be gone, and its `changes` then */
  const hbil_cache *last_cache;
  cl_uint last_cache_changes;
  /* the plan whose history the next frame reads, retained; NULL: its own */
  hbil_plan *followed;
  alternating slices, probes;
  /* the last frame that was composed */
  bool has_last;
  cl_uint static_frames; /* in a row so far, up to HBIL_EXACT_STATIC_FRAMES */
  hbil_camera last_camera;
  cl_uint last_index;
  float last_exposure;
  /* whether the frame that is being enqueued, and the last one, searched all
   * slices */
  bool searched_all, last_searched_all;
  /* passes of the frame that is being enqueued: whether the host left them out,
   * and whether the device may have */
  bool left_out[HBIL_PASS_COUNT], may_leave_out[HBIL_PASS_COUNT];
  /* of the call that enqueues them: the caller's planes that they use, and
   * whether reproject is among them */
  unsigned planes_in_use;
  bool reprojected;
  /* of the last frame's staged depths and normals (gather.c); 0: of floats */
  float depth_rounding, normal_rounding;
  step_table steps, ao_steps;
};

/* A chain for a plan's commands in a queue. */
commands commands_of_plan(hbil_plan *plan, cl_command_queue queue);

/* A buffer of the plan, as an argument of a kernel. */
#define BUFFER_ARG(plan, i) ARG((plan)->buffers[i])

/* A plane of the frame as a kernel takes it: plane_bind(), or the plan's own
 * buffer where the plane is staged. */
cl_mem bind_plane(const hbil_plan *plan, const hbil_frame *frame, int plane,
                  hbil_external_plane_args *args);

/* The planes that tell what surfaces send, in the same way. */
typedef struct surface_buffers {
  cl_mem albedo, f0, direct, emission;
} surface_buffers;
surface_buffers bind_surface(const hbil_plan *plan, const hbil_frame *frame,
                             hbil_surface_args *args);

/* Sets one of HBIL_FLAG_. */
hbil_status set_flag(const hbil_plan *plan, commands *chain, int flag,
                     cl_uint value);

/* Clears `words` counts of sanitized pixels from `first` on. */
hbil_status clear_counts(const hbil_plan *plan, commands *chain, int first,
                         int words);

/* The buffer of the history that composite writes. */
int next_history(const hbil_plan *plan);

/* The value of hbil_last_frame.bounces. */
cl_uint plan_bounces(const hbil_plan *plan);

/* NULL is allowed. */
void plan_retain(hbil_plan *plan);
void plan_release(hbil_plan *plan);

/* Makes the frame the plan's last one, when all its passes are enqueued. */
void remember_frame(hbil_plan *plan, const hbil_frame *frame);

#endif
