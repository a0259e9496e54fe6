/* The passes of a frame, in their order. */
#include "passes.h"

/* Planes of the caller that passes read or write. */
enum {
  SURFACE = PLANE_BIT(PLANE_DEPTH) | PLANE_BIT(PLANE_ALBEDO) |
            PLANE_BIT(PLANE_F0) | PLANE_BIT(PLANE_DIRECT) |
            PLANE_BIT(PLANE_EMISSION),
  OUTPUTS = (PLANE_BIT(PLANE_COUNT) - 1) & ~INPUT_PLANES
};

static const struct {
  hbil_pass pass;
  const char *name;
  pass_function *enqueue;
  unsigned planes;
  bool searches; /* a part of both searches (searches.h) */
} passes[HBIL_PASS_COUNT] = {
    {HBIL_PASS_IMPORT, "import", enqueue_import, 0, false},
    {HBIL_PASS_REPROJECT, "reproject", enqueue_reproject,
     PLANE_BIT(PLANE_DEPTH) | PLANE_BIT(PLANE_MOTION), false},
    {HBIL_PASS_PUSH_PULL, "push_pull", enqueue_push_pull, 0, false},
    {HBIL_PASS_SPLIT, "split", enqueue_split, SURFACE | PLANE_BIT(PLANE_NORMAL),
     false},
    {HBIL_PASS_GATHER, "gather", enqueue_gather,
     (SURFACE & ~PLANE_BIT(PLANE_DEPTH)) | PLANE_BIT(PLANE_MOTION), true},
    {HBIL_PASS_RECOMPOSE, "recompose", enqueue_recompose, 0, true},
    {HBIL_PASS_COMPOSITE, "composite", enqueue_composite, SURFACE | OUTPUTS,
     false},
    {HBIL_PASS_EXPORT, "export", enqueue_export, 0, false},
};

const char *hbil_pass_name(hbil_pass pass) {
  for (int i = 0; i < HBIL_PASS_COUNT; ++i)
    if (passes[i].pass == pass)
      return passes[i].name;
  return NULL;
}

static bool is_among(hbil_pass pass, hbil_pass first, hbil_pass last) {
  return pass == HBIL_PASS_IMPORT || pass == HBIL_PASS_EXPORT ||
         (pass >= first && pass <= last);
}

unsigned planes_of_passes(const hbil_plan *plan, hbil_pass first,
                          hbil_pass last) {
  unsigned planes = 0;
  for (int i = 0; i < HBIL_PASS_COUNT; ++i)
    if (is_among(passes[i].pass, first, last))
      planes |=
          passes[i].pass == HBIL_PASS_GATHER && plan->layout.slice_frames == 1
              ? passes[i].planes & ~PLANE_BIT(PLANE_MOTION)
              : passes[i].planes;
  return planes;
}

hbil_status enqueue_passes(hbil_plan *plan, commands *chain,
                           const hbil_frame *frame, hbil_pass first,
                           hbil_pass last) {
  hbil_status status = HBIL_SUCCESS;
  plan->planes_in_use = planes_of_passes(plan, first, last);
  plan->reprojected = false;
  for (int i = 0; i < HBIL_PASS_COUNT && status == HBIL_SUCCESS; ++i) {
    const hbil_pass pass = passes[i].pass;
    if (!is_among(pass, first, last))
      continue;
    chain->owner = (int)pass;
    plan->left_out[pass] = plan->may_leave_out[pass] = false;
    status = passes[i].enqueue(plan, chain, frame);
    if (status == HBIL_SUCCESS && passes[i].searches)
      status = enqueue_ao_search(plan, chain, frame, passes[i].enqueue);
  }
  return status;
}
