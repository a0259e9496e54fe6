/* What a caller hands in with a frame, checked before anything is enqueued. */
#include "checks.h"

#include <math.h>
#include <string.h>

#include "camera.h"
#include "planes.h"

static hbil_status check_plane(hbil_plan *plan, const hbil_frame *frame,
                               int plane) {
  hbil_context *context = plan->context;
  const char *name = plane_kinds[plane].name;
  const hbil_plane *given = frame_plane(frame, plane);
  const hbil_plane_format *format = plane_format(&plan->config, plane);
  if (format->component == HBIL_NONE)
    return given->buffer
               ? fail(context, HBIL_INVALID_FRAME,
                      "%s.buffer: given, but the plan has no format for it",
                      name)
               : HBIL_SUCCESS;
  if (!given->buffer)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.buffer: missing, the plan has a format for it", name);
  const size_t size = component_size(format->component);
  const size_t stride = format_stride(&plan->config, plane);
  if (given->offset % size || given->row_pitch % size ||
      given->plane_pitch % size)
    return fail(context, HBIL_INVALID_FRAME,
                "%s: offset, row_pitch and plane_pitch must be multiples of "
                "%zu bytes",
                name, size);
  size_t row, channel, bytes = 0;
  plane_pitches(&plan->config, plane, given, &row, &channel);
  if (row < size * ((plan->config.width - 1) * stride + 1))
    return fail(context, HBIL_INVALID_FRAME,
                "%s.row_pitch: %zu bytes are less than a row of %u pixels",
                name, row, (unsigned)plan->config.width);
  const cl_int error = clGetMemObjectInfo(given->buffer, CL_MEM_SIZE,
                                          sizeof bytes, &bytes, NULL);
  if (error == CL_INVALID_MEM_OBJECT)
    return fail(context, HBIL_INVALID_FRAME, "%s.buffer: %s", name,
                cl_error_name(error));
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clGetMemObjectInfo");
  const size_t needed = plane_extent(&plan->config, plane, row, channel);
  if (given->offset > bytes || needed > bytes - given->offset)
    return fail(context, HBIL_INVALID_FRAME,
                "%s: offset %zu + %zu bytes do not fit in its buffer of %zu",
                name, given->offset, needed, bytes);
  if ((given->offset + needed) / size > UINT32_MAX)
    return fail(context, HBIL_INVALID_FRAME,
                "%s: components beyond 2^32 cannot be addressed", name);
  return HBIL_SUCCESS;
}

static hbil_status check_environment(hbil_plan *plan, const hbil_frame *frame) {
  const bool sh = plan->config.model.far_field == HBIL_FAR_SH;
  const int count = plan->config.model.far_field == HBIL_FAR_NONE ? 0
                    : sh                                          ? 9
                                                                  : 1;
  for (int i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) {
      const float v = frame->environment[i][c];
      if (!isfinite(v) || (!sh && v < 0.0f))
        return fail(plan->context, HBIL_INVALID_FRAME,
                    "environment[%d][%d]: %g; must be %s", i, c, (double)v,
                    sh ? "finite" : "finite and not negative");
    }
  return HBIL_SUCCESS;
}

static hbil_status check_hardware_depth(hbil_plan *plan,
                                        const hbil_frame *frame) {
  const float a = frame->hardware_depth[0], b = frame->hardware_depth[1];
  if (plan->config.inputs.depth_kind != HBIL_DEPTH_HARDWARE ||
      (isfinite(a) && isnormal(b)))
    return HBIL_SUCCESS;
  return fail(plan->context, HBIL_INVALID_FRAME,
              "hardware_depth: %g, %g; HBIL_DEPTH_HARDWARE needs the finite A "
              "and B, not 0, of the projection",
              (double)a, (double)b);
}

/* What can be checked of static_frame. */
static hbil_status check_still(hbil_plan *plan, const hbil_frame *frame) {
  if (!frame->static_frame || !plan->has_last)
    return HBIL_SUCCESS;
  if (memcmp(&frame->camera, &plan->last_camera, sizeof frame->camera))
    return fail(
        plan->context, HBIL_INVALID_FRAME,
        "static_frame: CL_TRUE, but camera is not that of the frame before");
  if (frame->frame_index != plan->last_index &&
      !plan->config.history.max_frames)
    return fail(plan->context, HBIL_INVALID_FRAME,
                "static_frame: CL_TRUE, but frame_index is %u, that of the "
                "frame before was "
                "%u; one pattern is needed",
                (unsigned)frame->frame_index, (unsigned)plan->last_index);
  return HBIL_SUCCESS;
}

hbil_status check_frame(hbil_plan *plan, const hbil_frame *frame,
                        unsigned planes) {
  hbil_status status = camera_check(plan->context, &frame->camera);
  if (status == HBIL_SUCCESS)
    status = check_still(plan, frame);
  if (status == HBIL_SUCCESS)
    status = check_environment(plan, frame);
  if (status == HBIL_SUCCESS)
    status = check_hardware_depth(plan, frame);
  for (int i = 0; i < PLANE_COUNT && status == HBIL_SUCCESS; ++i)
    if (planes & PLANE_BIT(i))
      status = check_plane(plan, frame, i);
  return status;
}

hbil_status check_queue(hbil_plan *plan, cl_command_queue queue,
                        bool *in_order) {
  cl_context context = NULL;
  cl_device_id device = NULL;
  cl_command_queue_properties properties = 0;
  cl_int error = clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof context,
                                       &context, NULL);
  if (error == CL_SUCCESS)
    error = clGetCommandQueueInfo(queue, CL_QUEUE_DEVICE, sizeof device,
                                  &device, NULL);
  if (error == CL_SUCCESS)
    error = clGetCommandQueueInfo(queue, CL_QUEUE_PROPERTIES, sizeof properties,
                                  &properties, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clGetCommandQueueInfo");
  if (context != plan->context->context || device != plan->context->device)
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "queue: not of the plan's OpenCL context and device");
  if (plan->config.execution.profiling &&
      !(properties & CL_QUEUE_PROFILING_ENABLE))
    return fail(plan->context, HBIL_INVALID_ARGUMENT,
                "queue: profiling needs CL_QUEUE_PROFILING_ENABLE");
  *in_order = !(properties & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
  return HBIL_SUCCESS;
}
