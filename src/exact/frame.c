/*
 * A sequence of frames: the order of the passes.
 *
 *   HISTORY -reproject-> CARRIED -push/pull-> CARRIED
 *   inputs, CARRIED -split-> SPLIT -gather-> GATHERED
 *   inputs, SPLIT, GATHERED -estimate-> what the frame's surfaces send
 *   GATHERED -recompose-> RESOLVED -composite-> outputs, HISTORY
 * ao, bent_normal and cone_cosine may have a gather and a recompose of their
 * own.
 */
#include <string.h>

#include "exact/glossy.h"
#include "exact/lobe.h"
#include "exact/passes.h"
#include "exact/planes.h"
#include "exact/settings.h"

exact_status exact_state_create(exact_state *state, int width, int height) {
  const struct {
    exact_planes *planes;
    int count;
  } list[] = {{&state->history, HBIL_HISTORY_PLANES},
              {&state->carried, HBIL_CARRIED_PLANES},
              {&state->split, HBIL_SPLIT_PLANES},
              {&state->gathered, EXACT_GLOSSY_GATHERED},
              {&state->resolved, EXACT_RESOLVED_PLANES},
              {&state->out, EXACT_OUTPUT_PLANES}};
  exact_status status = EXACT_SUCCESS;
  memset(state, 0, sizeof(*state));
  for (size_t i = 0; i < sizeof(list) / sizeof(*list) && !status; ++i)
    status = exact_planes_create(list[i].planes, width, height, list[i].count);
  if (status)
    exact_state_free(state);
  return status;
}

void exact_state_free(exact_state *state) {
  exact_planes_free(&state->history);
  exact_planes_free(&state->carried);
  exact_planes_free(&state->split);
  exact_planes_free(&state->gathered);
  exact_planes_free(&state->resolved);
  exact_planes_free(&state->out);
}

/* An input has all of its planes or none; motion is checked where it is used.
 */
static bool is_complete(const exact_frame *frame) {
  static const int first[] = {EXACT_DEPTH, EXACT_NORMAL, EXACT_ALBEDO,
                              EXACT_F0,    EXACT_DIRECT, EXACT_EMISSION,
                              EXACT_MOTION};
  for (size_t i = 0; i + 1 < sizeof(first) / sizeof(*first); ++i)
    for (int p = first[i]; p < first[i + 1]; ++p)
      if (!frame->input[p] != !frame->input[first[i]])
        return false;
  return frame->input[EXACT_DEPTH] && frame->input[EXACT_NORMAL];
}

/* Everything before the gather. */
static exact_status prepare(exact_state *state, exact_frame *frame) {
  const hbil_config *config = frame->config;
  const bool carries = config->history.reprojection != HBIL_REPROJECTION_NONE &&
                       state->has_history;
  if (!exact_planes_fit(&state->out, config->width, config->height,
                        EXACT_OUTPUT_PLANES) ||
      !is_complete(frame))
    return EXACT_BAD_ARGUMENT;
  frame->previous = state->camera;
  frame->bounces = carries ? state->bounces : 0;
  if (carries) {
    exact_status status =
        exact_reproject(frame, &state->history, &state->carried);
    if (status == EXACT_SUCCESS)
      status = exact_push_pull(&state->carried);
    if (status != EXACT_SUCCESS)
      return status;
  }
  exact_split(frame, carries ? &state->carried : NULL, &state->split);
  return EXACT_SUCCESS;
}

/* The outputs of a search of their own.  how: NULL: at the kernels' samples. */
static exact_status finish_ao(exact_state *state, const exact_frame *frame,
                              const exact_dense *how) {
  hbil_config ao;
  exact_frame own = *frame;
  exact_planes gathered = {0}, resolved = {0};
  const int width = state->out.width, height = state->out.height;
  if (!exact_searches_ao(frame->config, &ao))
    return EXACT_SUCCESS;
  own.config = &ao;
  exact_status status =
      exact_planes_create(&gathered, width, height, HBIL_GATHERED_PLANES);
  if (status == EXACT_SUCCESS)
    status =
        exact_planes_create(&resolved, width, height, EXACT_RESOLVED_PLANES);
  if (status == EXACT_SUCCESS)
    status = how ? exact_gather_dense(&own, &state->split, how, &gathered)
                 : exact_gather(&own, &state->split, &gathered);
  if (status == EXACT_SUCCESS) {
    exact_recompose(&own, &state->split, &gathered, &resolved);
    exact_composite_ao(&own, &resolved, &state->out);
  }
  exact_planes_free(&gathered);
  exact_planes_free(&resolved);
  return status;
}

/* Everything after the gather. */
static exact_status finish(exact_state *state, exact_frame *frame,
                           const exact_dense *how) {
  exact_estimate_frame(frame, &state->split, &state->gathered);
  exact_recompose(frame, &state->split, &state->gathered, &state->resolved);
  exact_composite(frame, &state->resolved, &state->out, &state->history);
  if (exact_is_glossy(frame->config))
    exact_glossy(frame, &state->split, &state->resolved, NULL, &state->out);
  state->camera = frame->camera;
  state->bounces = frame->bounces + 1;
  state->has_history =
      frame->config->history.reprojection != HBIL_REPROJECTION_NONE;
  return finish_ao(state, frame, how);
}

exact_status exact_run_frame(exact_state *state, exact_frame *frame) {
  exact_status status = prepare(state, frame);
  if (status == EXACT_SUCCESS)
    status = exact_gather(frame, &state->split, &state->gathered);
  if (status == EXACT_SUCCESS)
    status = finish(state, frame, NULL);
  return status;
}

exact_status exact_run_frame_dense(exact_state *state, exact_frame *frame,
                                   const exact_dense *how) {
  hbil_config unfiltered = *frame->config;
  exact_status status = prepare(state, frame);
  exact_frame own = *frame;
  unfiltered.sampling.unfiltered = CL_TRUE;
  unfiltered.sampling.resolution = HBIL_RESOLUTION_FULL;
  own.config = &unfiltered;
  if (status == EXACT_SUCCESS)
    status = exact_gather_dense(&own, &state->split, how, &state->gathered);
  if (status == EXACT_SUCCESS)
    status = finish(state, &own, how);
  return status;
}
