/* What a frame left out, read back and counted. */
#include "internal.h"

#include <stdlib.h>
#include <string.h>

/* Kernels don't see hbil.h. */
_Static_assert((int)HBIL_SPAN_SKY == (int)HBIL_SKIP_SKY &&
                   (int)HBIL_SPAN_OPEN == (int)HBIL_SKIP_OPEN &&
                   (int)HBIL_SPAN_DARK == (int)HBIL_SKIP_DARK &&
                   (int)HBIL_SPAN_UNUSED == (int)HBIL_SKIP_UNUSED,
               "one span's bits are hbil_skip's");

static hbil_status read_buffer(hbil_plan *plan, cl_command_queue queue,
                               int buffer, void *out) {
  const cl_int error =
      clEnqueueReadBuffer(queue, plan->buffers[buffer], CL_TRUE, 0,
                          plan->layout.bytes[buffer], out, 0, NULL, NULL);
  return error == CL_SUCCESS
             ? HBIL_SUCCESS
             : fail_cl(plan->context, error, "clEnqueueReadBuffer");
}

static hbil_status read_passes(hbil_plan *plan, cl_command_queue queue,
                               hbil_statistics *out) {
  cl_uint flags[HBIL_FLAGS];
  const hbil_status status = read_buffer(plan, queue, BUFFER_FLAGS, flags);
  if (status != HBIL_SUCCESS)
    return status;
  for (int p = 0; p < HBIL_PASS_COUNT; ++p) {
    const int flag =
        p == HBIL_PASS_PUSH_PULL ? HBIL_FLAG_HOLES : HBIL_FLAG_CHANGED;
    out->not_run[p] =
        plan->left_out[p] || (plan->may_leave_out[p] && !flags[flag]);
  }
  return HBIL_SUCCESS;
}

static void add(hbil_count *to, size_t pixels) {
  to->pixels += pixels;
  to->spans++;
}

/* A span of `inside` pixels of the picture. */
static void count_span(hbil_statistics *out, unsigned spared, size_t inside,
                       size_t sky) {
  add(&out->all, inside);
  out->sky.pixels += sky;
  if (spared & HBIL_SKIP_SKY)
    out->sky.spans++;
  if (spared & HBIL_SKIP_OPEN)
    add(&out->open, inside - sky);
  if (spared & HBIL_SKIP_DARK)
    add(&out->dark, inside - sky);
  if (spared & HBIL_SKIP_UNUSED)
    add(&out->unused, inside - sky);
}

static void count_strips(const hbil_plan *plan, const unsigned char *spans,
                         hbil_statistics *out) {
  const size_t across = plan->layout.spans;
  const size_t height = (size_t)plan->layout.split.height;
  const size_t count = across * height * HBIL_LAYERS;
  const size_t size = plan->config.vector_width == 1 ? 1 : HBIL_SPAN;
  const size_t by_factors = plan->by_factors ? plan->layout.factors.rows : 0;
  for (size_t i = 0; i < count; ++i) {
    const size_t layer = i / (across * height);
    const size_t y = HBIL_SIDE * (i / across % height) + layer / HBIL_SIDE;
    const size_t x = HBIL_SIDE * size * (i % across) + layer % HBIL_SIDE;
    if (x >= plan->config.width || y >= plan->config.height)
      continue;
    const size_t right = (plan->config.width - x + HBIL_SIDE - 1) / HBIL_SIDE;
    const size_t inside = right < size ? right : size;
    /* lanes outside the picture are sky, too */
    const size_t sky = spans[count + i] - (size - inside);
    count_span(out, spans[i], inside, sky);
    if (!spans[i] && i / across % height < by_factors)
      add(&out->by_factors, inside - sky);
  }
}

/* Of adaptive sampling. */
static hbil_status read_samples(hbil_plan *plan, cl_command_queue queue,
                                hbil_statistics *out) {
  const ladder *l = &plan->layout.ladder;
  cl_uint tried[HBIL_MOST_RUNGS][HBIL_TRIED];
  out->slices = plan->config.slices;
  out->steps_per_side = plan->config.steps_per_side;
  out->adaptive = l->count > 0;
  if (!l->count)
    return HBIL_SUCCESS;
  const hbil_status status = read_buffer(plan, queue, BUFFER_TRIED, tried);
  int good = 0;
  while (good + 1 < l->count &&
         !hbil_good_enough(tried[good][HBIL_TRIED_BEYOND],
                           tried[good][HBIL_TRIED_PIXELS]))
    ++good;
  out->slices = (cl_uint)l->rung[good].slices;
  out->steps_per_side = (cl_uint)l->rung[good].samples;
  out->kept_choice = plan->kept_choice;
  return status;
}

static hbil_status read_strips(hbil_plan *plan, cl_command_queue queue,
                               hbil_statistics *out) {
  unsigned char *spans = malloc(plan->layout.bytes[BUFFER_SPAN_STATES]);
  if (!spans)
    return fail(plan->context, HBIL_OUT_OF_HOST_MEMORY,
                "no memory to count in");
  const hbil_status status =
      read_buffer(plan, queue, BUFFER_SPAN_STATES, spans);
  if (status == HBIL_SUCCESS)
    count_strips(plan, spans, out);
  free(spans);
  return status;
}

hbil_status hbil_plan_statistics(hbil_plan *plan, cl_command_queue queue,
                                 hbil_statistics *out) {
  if (!plan || !queue || !out)
    return HBIL_INVALID_ARGUMENT;
  memset(out, 0, sizeof *out);
  if (!plan->has_last)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "hbil_plan_statistics: the plan has no frame yet");
  const cl_int error = clFinish(queue);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clFinish");
  hbil_status status = read_passes(plan, queue, out);
  if (status == HBIL_SUCCESS)
    status = read_strips(plan, queue, out);
  if (status == HBIL_SUCCESS)
    status = read_samples(plan, queue, out);
  if (status == HBIL_SUCCESS && out->not_run[HBIL_PASS_GATHER])
    out->sky = out->open = out->dark = out->unused = out->by_factors =
        (hbil_count){0, 0};
  return status;
}
