/* Reads back a frame's timings, statistics and counts of sanitized pixels. */
#include "plan.h"
#include "lib/sampling_pattern.h"

#include <stdlib.h>
#include <string.h>

/* Kernels don't see hbil.h. */
_Static_assert((int)HBIL_SPAN_SKY == (int)HBIL_SKIP_SKY &&
                   (int)HBIL_SPAN_OPEN == (int)HBIL_SKIP_OPEN &&
                   (int)HBIL_SPAN_DARK == (int)HBIL_SKIP_DARK &&
                   (int)HBIL_SPAN_UNUSED == (int)HBIL_SKIP_UNUSED,
               "the bits of a span are those of hbil_skip");

/* Begins to read what the last frame has left, for the public `function`: reads
 * wait for all of the plan's commands.  Since they block, later commands need
 * not wait for them.  end_commands() ends it. */
static hbil_status begin_reading(const char *function, hbil_plan *plan,
                                 cl_command_queue queue, const void *out,
                                 commands *chain) {
  if (!plan || !queue || !out)
    return fail_null(plan ? plan->context : NULL, function,
                     !plan    ? "plan"
                     : !queue ? "queue"
                              : "out");
  if (!plan->has_last)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "%s: the plan has no last frame; one must have been enqueued "
                "since the plan was made or reset, without a failure",
                function);
  *chain = commands_of_plan(plan, queue);
  const hbil_status status = begin_commands(chain, 0, NULL);
  if (status != HBIL_SUCCESS)
    end_commands(chain);
  return status;
}

static hbil_status read_passes(const hbil_plan *plan, const commands *chain,
                               hbil_statistics *out) {
  cl_uint flags[HBIL_FLAGS];
  const hbil_status status =
      read_memory(chain, plan->buffers[BUFFER_FLAGS], sizeof flags, flags);
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
static void count_span(hbil_statistics *out, unsigned skipped, size_t inside,
                       size_t sky) {
  add(&out->all, inside);
  out->sky.pixels += sky;
  if (skipped & HBIL_SKIP_SKY)
    out->sky.spans++;
  if (skipped & HBIL_SKIP_OPEN)
    add(&out->open, inside - sky);
  if (skipped & HBIL_SKIP_DARK)
    add(&out->dark, inside - sky);
  if (skipped & HBIL_SKIP_UNUSED)
    add(&out->unused, inside - sky);
}

static void count_spans(const hbil_plan *plan, const unsigned char *spans,
                        hbil_statistics *out) {
  const size_t across = plan->layout.spans;
  const size_t height = (size_t)plan->layout.split.height;
  const size_t count = across * height * HBIL_LAYERS;
  const size_t size = plan->layout.taken;
  for (size_t i = 0; i < count; ++i) {
    const size_t layer = i / (across * height);
    const size_t y = HBIL_SIDE * (i / across % height) + layer / HBIL_SIDE;
    const size_t x = HBIL_SIDE * size * (i % across) + layer % HBIL_SIDE;
    if (x >= plan->config.width || y >= plan->config.height ||
        !hbil_is_gathered((cl_int)layer, plan->layout.pattern.gathered))
      continue;
    const size_t right = (plan->config.width - x + HBIL_SIDE - 1) / HBIL_SIDE;
    const size_t inside = right < size ? right : size;
    /* lanes outside the picture are sky, too */
    const size_t sky = spans[count + i] - (size - inside);
    count_span(out, spans[i], inside, sky);
  }
}

static hbil_status read_spans(const hbil_plan *plan, const commands *chain,
                              hbil_statistics *out) {
  const size_t bytes = plan->layout.bytes[BUFFER_SPAN_STATES];
  unsigned char *spans = malloc(bytes);
  if (!spans)
    return fail(plan->context, HBIL_OUT_OF_HOST_MEMORY,
                "no memory to count in");
  const hbil_status status =
      read_memory(chain, plan->buffers[BUFFER_SPAN_STATES], bytes, spans);
  if (status == HBIL_SUCCESS)
    count_spans(plan, spans, out);
  free(spans);
  return status;
}

hbil_status hbil_plan_statistics(hbil_plan *plan, cl_command_queue queue,
                                 hbil_statistics *out) {
  commands chain;
  if (out)
    memset(out, 0, sizeof *out);
  hbil_status status = begin_reading(__func__, plan, queue, out, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  status = read_passes(plan, &chain, out);
  if (status == HBIL_SUCCESS)
    status = read_spans(plan, &chain, out);
  end_commands(&chain);
  if (status == HBIL_SUCCESS && out->not_run[HBIL_PASS_GATHER])
    out->sky = out->open = out->dark = out->unused = (hbil_count){0, 0};
  return status;
}

hbil_status hbil_plan_sanitized(hbil_plan *plan, cl_command_queue queue,
                                hbil_sanitized *out) {
  cl_uint words[HBIL_SANITIZED_WORDS];
  commands chain;
  if (out)
    memset(out, 0, sizeof *out);
  hbil_status status = begin_reading(__func__, plan, queue, out, &chain);
  if (status != HBIL_SUCCESS)
    return status;
  status =
      read_memory(&chain, plan->buffers[BUFFER_SANITIZED], sizeof words, words);
  end_commands(&chain);
  if (status != HBIL_SUCCESS)
    return status;
  size_t *const surface[HBIL_SURFACE_INPUTS] = {
      [HBIL_SURFACE_ALBEDO] = &out->albedo,
      [HBIL_SURFACE_F0] = &out->f0,
      [HBIL_SURFACE_DIRECT] = &out->direct,
      [HBIL_SURFACE_EMISSION] = &out->emission};
  out->depth = words[HBIL_SANITIZED_DEPTH];
  out->normal = words[HBIL_SANITIZED_NORMAL];
  out->facing_away = words[HBIL_SANITIZED_AWAY];
  for (int i = 0; i < HBIL_SURFACE_INPUTS; ++i)
    *surface[i] =
        words[HBIL_SANITIZED_SURFACE + i] + words[HBIL_SANITIZED_LATE + i];
  /* a first frame and a static one read no motion */
  if (!plan->left_out[HBIL_PASS_REPROJECT])
    out->motion = words[HBIL_SANITIZED_MOTION];
  return HBIL_SUCCESS;
}

/* Adds one command's time to its pass. */
static hbil_status add_time(const hbil_plan *plan, int command,
                            double *milliseconds) {
  cl_ulong start = 0, end = 0;
  const cl_event event = plan->times.events[command];
  cl_int error = clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START,
                                         sizeof start, &start, NULL);
  if (error == CL_SUCCESS)
    error = clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof end,
                                    &end, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clGetEventProfilingInfo");
  milliseconds[plan->times.owner[command]] += (double)(end - start) * 1e-6;
  return HBIL_SUCCESS;
}

hbil_status hbil_plan_timings(hbil_plan *plan,
                              double milliseconds[HBIL_PASS_COUNT]) {
  if (!plan || !milliseconds)
    return fail_null(plan ? plan->context : NULL, __func__,
                     plan ? "milliseconds" : "plan");
  memset(milliseconds, 0, HBIL_PASS_COUNT * sizeof *milliseconds);
  if (!plan->config.execution.profiling)
    return fail(plan->context, HBIL_INVALID_CONFIG,
                "execution.profiling: CL_FALSE; timings need CL_TRUE");
  if (plan->times.error != CL_SUCCESS)
    return fail_cl(plan->context, plan->times.error, "clRetainEvent");
  if (!plan->times.count)
    return HBIL_SUCCESS;
  const cl_int error =
      clWaitForEvents((cl_uint)plan->times.count, plan->times.events);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clWaitForEvents");
  hbil_status status = HBIL_SUCCESS;
  for (int i = 0; i < plan->times.count && status == HBIL_SUCCESS; ++i)
    status = add_time(plan, i, milliseconds);
  return status;
}
