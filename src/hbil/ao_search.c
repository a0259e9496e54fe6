/* The search for ao, bent_normal and cone_cosine where light goes by another
 * one (searches.h): gather, recompose once more, without light,
 * into buffers of their own. */
#include "passes.h"

#include "defines.h"
#include "searches.h"

hbil_status build_ao_search(hbil_plan *plan) {
  ao_search *s = &plan->ao;
  const bool programs[PROGRAM_COUNT] = {
      [PROGRAM_GATHER] = true, [PROGRAM_RECOMPOSE] = true};
  const bool kernels[KERNEL_COUNT] = {
      [KERNEL_GATHER] = true, [KERNEL_RECOMPOSE] = true};
  char defines[MOST_DEFINES];
  if (!searches_differ(&plan->config, &s->config))
    return HBIL_SUCCESS;
  layout_of_ao_search(&s->config, &plan->layout, &s->layout);
  const hbil_status status = write_defines(plan->context, &s->config,
                                           &s->layout, defines, sizeof defines);
  return status == HBIL_SUCCESS
             ? kernels_build(plan->context, plan->kernels.table, programs,
                             kernels, defines, &s->kernels)
             : status;
}

/* The plan as these passes see it. */
static hbil_plan view_of(const hbil_plan *plan) {
  hbil_plan view = *plan;
  view.config = plan->ao.config;
  view.layout = plan->ao.layout;
  view.steps = plan->ao_steps;
  view.buffers[BUFFER_STEPS] = plan->buffers[BUFFER_AO_STEPS];
  view.buffers[BUFFER_LIGHT] = plan->buffers[BUFFER_AO_LIGHT];
  view.buffers[BUFFER_RESOLVED] = plan->buffers[BUFFER_AO_RESOLVED];
  view.buffers[BUFFER_SLICES] = plan->buffers[BUFFER_AO_SLICES];
  view.buffers[BUFFER_SLICES_NEXT] = plan->buffers[BUFFER_AO_SLICES_NEXT];
  view.buffers[BUFFER_SPAN_STATES] = plan->buffers[BUFFER_AO_SPAN_STATES];
  return view;
}

/* What a pass notes in the view is what the plan's own pass has noted. */
hbil_status enqueue_ao_search(const hbil_plan *plan, commands *chain,
                              const hbil_frame *frame, pass_function *pass) {
  hbil_plan view = view_of(plan);
  trial_launches trial = {.launched = {false}}, *const plans = chain->trial;
  if (!plan->layout.ao_search)
    return HBIL_SUCCESS;
  chain->kernels = &plan->ao.kernels;
  chain->trial = plans ? &trial : NULL;
  const hbil_status status = pass(&view, chain, frame);
  chain->kernels = &plan->kernels;
  chain->trial = plans;
  return status;
}
