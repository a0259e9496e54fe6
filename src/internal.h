/* What the library's own files share; nothing here is public. */
#ifndef HBIL_INTERNAL_H
#define HBIL_INTERNAL_H

#include <stdbool.h>

#include "hbil/hbil.h"
#include "hbil_shared.h"

/* In the static library internals would meet the names of programs. */
#define camera_between hbil_internal_camera_between
#define camera_check hbil_internal_camera_check
#define camera_from_world hbil_internal_camera_from_world
#define camera_to_world hbil_internal_camera_to_world
#define camera_view hbil_internal_camera_view
#define cl_error_name hbil_internal_cl_error_name
#define config_ends hbil_internal_config_ends
#define config_refuses hbil_internal_config_refuses
#define config_format hbil_internal_config_format
#define config_take hbil_internal_config_take
#define fail hbil_internal_fail
#define fail_cl hbil_internal_fail_cl
#define far_field_args hbil_internal_far_field_args
#define format_stride hbil_internal_format_stride
#define frame_plane hbil_internal_frame_image
#define frame_take hbil_internal_frame_take
#define plane_kinds hbil_internal_image_kinds
#define kernel_sources hbil_internal_kernel_sources
#define ladder_of hbil_internal_ladder_of
#define ladder_on hbil_internal_ladder_on
#define layout_compute hbil_internal_layout_compute
#define program_build hbil_internal_program_build
#define status_of hbil_internal_status_of

/* Images of a frame, inputs first. */
enum {
  PLANE_DEPTH,
  PLANE_NORMAL,
  PLANE_ALBEDO,
  PLANE_F0,
  PLANE_DIRECT,
  PLANE_EMISSION,
  PLANE_MOTION,
  PLANE_NEAR,
  PLANE_FAR,
  PLANE_AO,
  PLANE_BENT,
  PLANE_CONE,
  PLANE_INDIRECT,
  PLANE_BEAUTY,
  PLANE_ERROR,
  PLANE_COUNT,
  PLANE_FIRST_OUTPUT = PLANE_NEAR
};

/* Name, channels and place in the public structs of one image. */
typedef struct plane_kind {
  const char *name;   /* as in hbil_config and hbil_frame */
  const char *define; /* prefix of its build defines */
  cl_uint channels;
  size_t format_at; /* offset in hbil_config */
  size_t image_at;  /* offset in hbil_frame */
} plane_kind;
extern const plane_kind plane_kinds[PLANE_COUNT];

const hbil_plane_format *config_format(const hbil_config *config, int image);
const hbil_plane *frame_plane(const hbil_frame *frame, int image);
/* Whether the light of any sample may be refused. */
bool config_refuses(const hbil_config *config);
/* Whether occluders have a thickness. */
bool config_ends(const hbil_config *config);
/* Components from a pixel to the next: stride, or its default. */
cl_uint format_stride(const hbil_config *config, int image);

/* --- context.c --- */

struct hbil_context {
  cl_context context;
  cl_device_id device;
  char *message; /* NULL: none */
  cl_uint vector_width;
  size_t group[2];   /* work-group of every kernel */
  bool exact_divide; /* CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT */
};

/* Sets the context's message; returns `status`, so that a failing function
 * ends with `return fail(...)`. */
hbil_status fail(hbil_context *context, hbil_status status, const char *format,
                 ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* What an OpenCL error is to the caller. */
hbil_status status_of(cl_int error);
/* The same as fail() for a failed OpenCL call `call`. */
hbil_status fail_cl(hbil_context *context, cl_int error, const char *call);
const char *cl_error_name(cl_int error);

/* --- settings.c --- */

/* A caller's struct, which may be an older header's and smaller, as a copy of
 * this library's size; what it lacks is as the init function has it.  All that
 * is handed in goes through these.  A size that no header has had is refused;
 * of a config also what is out of range, naming the field and its range. */
hbil_status config_take(hbil_context *context, const hbil_config *given,
                        hbil_config *own);
hbil_status frame_take(hbil_context *context, const hbil_frame *given,
                       hbil_frame *own);

/* --- program.c --- */

typedef struct program_kind {
  const char *name; /* of its file, without .cl */
  bool fast;    /* relaxed arithmetic: where results may differ in rounding */
  bool images;  /* reads or writes callers' images */
  bool places;  /* reads what another frame has left */
  bool factors; /* gathers light by form factors */
  bool guide;   /* filters pixels, or judges what that leaves */
  const char *defines; /* of its own; NULL: none */
} program_kind;

/* Most characters that the defines of a plan take. */
enum { MOST_DEFINES = 3072 };

/* The program of one pass, built with those of `defines`, "-DNAME=VALUE" with
 * spaces between, that its text names. */
hbil_status program_build(hbil_context *context, const program_kind *kind,
                          const char *defines, cl_program *out);

/* --- kernel_sources.c (generated from kernels/) --- */

typedef struct kernel_source {
  const char *name; /* file name */
  const char *text;
} kernel_source;
extern const kernel_source kernel_sources[]; /* ends with a NULL name */

/* --- camera.c --- */

hbil_status camera_check(hbil_context *context, const hbil_camera *camera);
hbil_view_args camera_view(const hbil_camera *camera,
                           const hbil_config *config);
/* to_from_from: the view space of `from` to that of `to`. */
hbil_transform_args camera_between(const hbil_camera *from,
                                   const hbil_camera *to);
hbil_transform_args camera_to_world(const hbil_camera *camera);
hbil_transform_args camera_from_world(const hbil_camera *camera);

/* --- farfield.c --- */

hbil_environment_args far_field_args(const hbil_config *config,
                                     const float environment[9][3]);

/* --- ladder.c --- */

/* Numbers of samples that adaptive sampling chooses from, and the table of
 * steps that holds those of all: in entries. */
enum { LADDER_RULER = HBIL_MOST_RUNGS }; /* what they are held against */
typedef struct ladder {
  int count; /* 0: the first one's are taken */
  hbil_rung rung[LADDER_RULER + 1];
  hbil_limit_args limit[LADDER_RULER + 1]; /* of those that are judged */
  size_t steps;
} ladder;

/* Whether hbil_config.max_error asks for it. */
bool ladder_on(const hbil_config *config);
ladder ladder_of(const hbil_config *config, int levels);

/* --- layout.c --- */

/* The device buffers of a plan. */
enum {
  BUFFER_HISTORY,
  BUFFER_CARRIED, /* level 0 of the push/pull chain and all coarser ones */
  BUFFER_NEAREST, /* scatter's depths and sources */
  BUFFER_LANDING, /* rows at which runs of the last frame land */
  BUFFER_FLAGS,   /* HBIL_FLAG_: what kernels tell later ones */
  BUFFER_SPLIT,
  BUFFER_LIGHT,
  BUFFER_RESOLVED,
  BUFFER_TEMPORAL,      /* by the temporal filter, of one frame */
  BUFFER_TEMPORAL_NEXT, /* of the other */
  BUFFER_STEPS,
  BUFFER_ESTIMATE,    /* the estimate, then its parts */
  BUFFER_BOUNDS,      /* grids of what is nearest and what shines */
  BUFFER_USES,        /* where light has a use */
  BUFFER_SPAN_STATES, /* what the gather had no need of */
  BUFFER_SANITIZED,   /* HBIL_SANITIZED_: what inputs could not be used as is */
  BUFFER_RULER,       /* adaptive: what many samples see, HBIL_RULER_ */
  BUFFER_TRIED,       /* adaptive: how far rungs are off, HBIL_TRIED_ */
  BUFFER_FACTORS,     /* form factors of a still frame (horizon_cache.clh) */
  BUFFER_LADDER,      /* numbers of samples */
  BUFFER_COUNT
};

enum {
  KERNEL_SCATTER_ROWS,
  KERNEL_SCATTER_BANDS,
  KERNEL_SCATTER_DEPTH,
  KERNEL_SCATTER_INDEX,
  KERNEL_SCATTER_FETCH,
  KERNEL_FOLLOW_MOTION,
  KERNEL_FIND_HOLES,
  KERNEL_PUSH,
  KERNEL_PULL,
  KERNEL_CLEAR_LAYERS,
  KERNEL_SPLIT,
  KERNEL_RELIGHT,
  KERNEL_BOUND_CELLS,
  KERNEL_BOUND_QUADRANTS,
  KERNEL_ESTIMATE_PART,
  KERNEL_ESTIMATE_SUM,
  KERNEL_PATTERN,
  KERNEL_GATHER,
  KERNEL_GATHER_FACTORS,
  KERNEL_REGATHER,
  KERNEL_JUDGE_RULER,
  KERNEL_JUDGE_RUNG,
  KERNEL_RECOMPOSE,
  KERNEL_TEMPORAL,
  KERNEL_COMPOSITE,
  KERNEL_COUNT
};

enum { PROGRAM_COUNT = 14 };

/* log2(HBIL_MAX_SIZE) + 1: levels of the largest push/pull chain. */
enum { MAX_CHAIN = 15 };
_Static_assert(1 << (MAX_CHAIN - 1) == HBIL_MAX_SIZE, "MAX_CHAIN");

/* Sizes and layouts; everything a configuration decides before any device
 * memory is touched. */
typedef struct layout {
  size_t bytes[BUFFER_COUNT]; /* 0: not needed */
  hbil_plane_args planes;     /* full-resolution planes */
  hbil_runs_args runs;        /* of scatter's bands */
  hbil_layer_args split, light;
  int chain_count;
  hbil_chain_args chain[MAX_CHAIN];
  /* what must be computed; unknown: the share of refused light */
  bool radiance, bent, history, unknown, estimate;
  bool counts_late; /* composite shows inputs that split has no use for */
  cl_uint skip;     /* of hbil_config.skip what can come to anything here */
  hbil_bounds_args bounds;
  bool quadrants; /* whether the gather asks for those of the bounds */
  hbil_factor_args factors;
  size_t spans;              /* of the gather, in a row of a layer */
  hbil_far_field far_field;  /* NONE where nothing shows it */
  hbil_pattern_args pattern; /* without turn, shift, reach */
  cl_uint line;              /* pixels that one of composite's items takes */
  cl_uint error_plane;       /* of RESOLVED, where errors begin */
  cl_uint weight_plane;      /* of GATHERED, what slices weigh; 0: none */
  cl_int tiles;              /* that adaptive sampling measures */
  ladder ladder;
} layout;

/* Whether scatter needs no atomics: CPUs.  As below, config.vector_width must
 * not be 0. */
bool layout_has_bands(const hbil_config *config);
void layout_compute(const hbil_config *config, layout *out);

/* --- plan.c --- */

/* Most kernel launches in a frame, for the profiling events. */
enum { MAX_LAUNCHES = 2 * MAX_CHAIN + 24 + 3 * (HBIL_MOST_RUNGS + 1) };

struct hbil_plan {
  hbil_context *context;
  hbil_config config;
  layout layout;
  cl_mem buffers[BUFFER_COUNT];
  cl_program programs[PROGRAM_COUNT];
  cl_kernel kernels[KERNEL_COUNT];
  bool has_history;
  hbil_camera history_camera;
  /* what the temporal filter keeps: which of the two buffers holds it, and
   * whether the other one has been written since the last composite */
  bool has_kept, kept_anew;
  int kept;
  hbil_camera kept_camera;
  /* the last frame that was composed */
  bool has_last;
  hbil_camera last_camera;
  cl_uint last_index;
  /* passes of the frame that is being enqueued: whether the host left them out,
   * and whether the device may have */
  bool left_out[HBIL_PASS_COUNT], may_leave_out[HBIL_PASS_COUNT];
  /* adaptive: the frame that is being enqueued measures nothing */
  bool kept_choice;
  /* form factors: whether the last gather has left some, and whether that of
   * the frame that is being enqueued uses them */
  bool has_factors, by_factors;
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
