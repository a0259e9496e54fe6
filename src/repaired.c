/* What of a frame's inputs could not be used as it was, read back. */
#include "internal.h"

#include <string.h>

hbil_status hbil_plan_sanitized(hbil_plan *plan, cl_command_queue queue,
                                hbil_sanitized *out) {
  cl_uint words[HBIL_SANITIZED_WORDS];
  if (!plan || !queue || !out)
    return HBIL_INVALID_ARGUMENT;
  memset(out, 0, sizeof *out);
  if (!plan->has_last)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "hbil_plan_sanitized: the plan has no frame yet");
  cl_int error = clFinish(queue);
  if (error == CL_SUCCESS)
    error = clEnqueueReadBuffer(queue, plan->buffers[BUFFER_SANITIZED], CL_TRUE,
                                0, sizeof words, words, 0, NULL, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "reading the counts of repairs");
  size_t *const surface[HBIL_SURFACE_INPUTS] = {
      [HBIL_SURFACE_ALBEDO] = &out->albedo,
      [HBIL_SURFACE_F0] = &out->f0,
      [HBIL_SURFACE_DIRECT] = &out->direct,
      [HBIL_SURFACE_EMISSION] = &out->emission};
  out->depth = words[HBIL_SANITIZED_DEPTH];
  out->normal = words[HBIL_SANITIZED_NORMAL];
  for (int i = 0; i < HBIL_SURFACE_INPUTS; ++i)
    *surface[i] =
        words[HBIL_SANITIZED_SURFACE + i] + words[HBIL_SANITIZED_LATE + i];
  /* a frame that follows none, or stands still, has looked at no motion; where
   * no light is carried over, the temporal filter has */
  if (!plan->left_out[HBIL_PASS_REPROJECT] ||
      (plan->config.max_history_frames && !plan->layout.history))
    out->motion = words[HBIL_SANITIZED_MOTION];
  return HBIL_SUCCESS;
}
