/* The passes of a frame, as chains of commands.  Each file of passes writes the
 * arguments of its kernels and nothing else. */
#ifndef HBIL_PASSES_H
#define HBIL_PASSES_H

#include "lib/composite_args.h"
#include "plan.h"

typedef hbil_status pass_function(hbil_plan *plan, commands *chain,
                                  const hbil_frame *frame);

pass_function enqueue_import, enqueue_export;       /* import.c */
pass_function enqueue_reproject, enqueue_push_pull; /* reproject.c */
pass_function enqueue_split;                        /* split.c */
pass_function enqueue_gather;                       /* gather.c */
/* estimate.c: behind the gather, in the same pass */
pass_function enqueue_estimate;
pass_function enqueue_recompose, enqueue_composite; /* resolve.c */
/* probes.c: before composite, in the same pass */
pass_function enqueue_probes;
/* glossy.c: behind the probes, in the same pass */
pass_function enqueue_glossy;

/* ao_search.c: gather or recompose once more, for the outputs
 * that show another search than the near field's; and its kernels. */
hbil_status enqueue_ao_search(const hbil_plan *plan, commands *chain,
                              const hbil_frame *frame, pass_function *pass);
hbil_status build_ao_search(hbil_plan *plan);

/* The caller's planes that a plan's passes from `first` to `last` read or
 * write, as a set of bits. */
unsigned planes_of_passes(const hbil_plan *plan, hbil_pass first,
                          hbil_pass last);

/* Enqueues the passes from `first` to `last`, with import before them and
 * export behind them. */
hbil_status enqueue_passes(hbil_plan *plan, commands *chain,
                           const hbil_frame *frame, hbil_pass first,
                           hbil_pass last);

/* split.c: clears what kernels read around the pixels of layers, but do not
 * write. */
hbil_status clear_padding(const hbil_plan *plan, commands *chain);

/* composite_args.c: what composite takes of a frame, and the buffers of its
 * planes; null where there is none. */
hbil_composite_args composite_args(const hbil_plan *plan,
                                   const hbil_frame *frame,
                                   cl_mem plane[PLANE_COUNT]);

/* Vectors of pixels across the image. */
static inline size_t vectors_across(const hbil_plan *plan) {
  const size_t width = plan->config.execution.vector_width;
  return (plan->config.width + width - 1) / width;
}

/* Whether this frame is the last one again, except for its light. */
static inline bool is_still(const hbil_plan *plan, const hbil_frame *frame) {
  return frame->static_frame && plan->has_last;
}

/* Whether it leaves out what is known from the last one. */
static inline bool is_static(const hbil_plan *plan, const hbil_frame *frame) {
  return is_still(plan, frame) && plan->layout.skip & HBIL_SKIP_STATIC;
}

/* Whether this frame searches a part of its slices.  Static ones search all, so
 * that what they find is the same in each of them. */
static inline bool shares_slices(const hbil_plan *plan,
                                 const hbil_frame *frame) {
  return plan->layout.slice_frames > 1 && !is_still(plan, frame);
}

/* Whether gather and recompose may leave at once where no light has changed:
 * not in the first static frame behind one that shared slices. */
static inline bool may_rest(const hbil_plan *plan, const hbil_frame *frame) {
  return is_static(plan, frame) && plan->last_searched_all;
}

/* Notes that the host leaves a pass out. */
static inline hbil_status leave_out(hbil_plan *plan, hbil_pass pass) {
  plan->left_out[pass] = true;
  return HBIL_SUCCESS;
}

#endif
