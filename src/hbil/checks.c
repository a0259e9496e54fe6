/* What a caller hands in with a frame, checked before anything is enqueued. */
#include "checks.h"

#include <math.h>
#include <string.h>

#include "buffers.h"
#include "overlap.h"

/* That kernels can take the buffer or image for this plane. */
static hbil_status check_memory(const plane_rules *rules, int plane,
                                cl_mem buffer, bool is_image,
                                memory_info *info) {
  hbil_context *context = rules->context;
  const char *name = plane_kinds[plane].name;
  const bool output = plane >= PLANE_FIRST_OUTPUT;
  const cl_int error = memory_read(buffer, info);
  if (error == CL_INVALID_MEM_OBJECT)
    return fail(context, HBIL_INVALID_FRAME, "%s.buffer: %s", name,
                cl_error_name(error));
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clGetMemObjectInfo");
  if (is_image && info->type != CL_MEM_OBJECT_IMAGE2D)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.buffer: not an image2d_t; the %s's format for it is "
                "HBIL_IMAGE",
                name, rules->owner);
  if (!is_image && info->type != CL_MEM_OBJECT_BUFFER)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.buffer: an image or a pipe; the %s's format for it needs "
                "a buffer",
                name, rules->owner);
  if (info->context != context->context)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.buffer: not of the %s's OpenCL context", name,
                rules->owner);
  if (info->flags & (output ? CL_MEM_READ_ONLY : CL_MEM_WRITE_ONLY))
    return fail(
        context, HBIL_INVALID_FRAME,
        output ? "%s.buffer: CL_MEM_READ_ONLY, but the %s writes this plane"
               : "%s.buffer: CL_MEM_WRITE_ONLY, but the %s reads this "
                 "plane",
        name, rules->owner);
  return HBIL_SUCCESS;
}

/* That the pixels are in the buffer, and can be addressed. */
static hbil_status check_extent(hbil_context *context, const char *name,
                                size_t component, const hbil_plane *given,
                                const plane_shape *shape, size_t bytes) {
  const size_t offset = given->offset;
  /* first, because multiples of such pitches may wrap around; those that the
   * size gives can't */
  if (given->row_pitch && shape->rows > 1 && shape->row > bytes)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.row_pitch: %zu bytes are more than its buffer of %zu", name,
                shape->row, bytes);
  if ((given->row_pitch || given->plane_pitch) && shape->images > 1 &&
      shape->image > bytes)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.plane_pitch: %zu bytes are more than its buffer of %zu",
                name, shape->image, bytes);
  const size_t needed = plane_extent(shape);
  if (offset > bytes || needed > bytes - offset)
    return fail(context, HBIL_INVALID_FRAME,
                "%s: offset %zu + %zu bytes do not fit in its buffer of %zu",
                name, offset, needed, bytes);
  if ((offset + needed) / component > UINT32_MAX)
    return fail(context, HBIL_INVALID_FRAME,
                "%s: components beyond 2^32 cannot be addressed", name);
  return HBIL_SUCCESS;
}

/* Finds out as well where the plane lies, if it exists. */
static hbil_status check_plane(const plane_rules *rules,
                               const hbil_frame *frame, int plane,
                               plane_region *region) {
  hbil_context *context = rules->context;
  const char *name = plane_kinds[plane].name;
  const hbil_plane *given = frame_plane(frame, plane);
  const hbil_plane_format *format = plane_format(rules->config, plane);
  const staging *staged = rules->staged;
  const bool is_image = staged->images & PLANE_BIT(plane);
  const bool is_rebuilt = !is_image && staged->planes & PLANE_BIT(plane);
  if (format->component == HBIL_NONE || is_rebuilt)
    return given->buffer
               ? fail(context, HBIL_INVALID_FRAME,
                      "%s.buffer: given, but the %s has no format for it", name,
                      rules->owner)
               : HBIL_SUCCESS;
  if (!given->buffer)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.buffer: missing, the %s has a format for it", name,
                rules->owner);
  if (is_image && (given->offset || given->row_pitch || given->plane_pitch))
    return fail(context, HBIL_INVALID_FRAME,
                "%s: offset, row_pitch and plane_pitch must be 0 with "
                "HBIL_IMAGE",
                name);
  const size_t size = component_size(format->component);
  if (given->offset % size || given->row_pitch % size ||
      given->plane_pitch % size)
    return fail(context, HBIL_INVALID_FRAME,
                "%s: offset %zu, row_pitch %zu, plane_pitch %zu; must be "
                "multiples of %zu bytes",
                name, given->offset, given->row_pitch, given->plane_pitch,
                size);
  const plane_shape shape = plane_shape_of(rules->config, plane, given);
  if (shape.row < plane_row_extent(&shape))
    return fail(context, HBIL_INVALID_FRAME,
                "%s.row_pitch: %zu bytes are less than a row of %u pixels, "
                "which has %zu",
                name, shape.row, (unsigned)rules->config->width,
                plane_row_extent(&shape));
  memory_info memory;
  hbil_status status =
      check_memory(rules, plane, given->buffer, is_image, &memory);
  if (status == HBIL_SUCCESS)
    status =
        is_image
            ? check_image(context, rules->config, staged, plane, given->buffer)
            : check_extent(context, name, size, given, &shape, memory.bytes);
  region->memory = memory.parent ? memory.parent : given->buffer;
  region->start = memory.origin + given->offset;
  region->shape = shape;
  return status;
}

/* That no plane lies in scratch memory of the caller's. */
static hbil_status check_scratch(const plane_rules *rules,
                                 const plane_region regions[PLANE_COUNT]) {
  const memory_range *scratch = &rules->lent;
  for (int i = 0; i < PLANE_COUNT && scratch->memory; ++i)
    if (regions[i].memory == scratch->memory &&
        regions[i].start < scratch->start + scratch->bytes &&
        scratch->start < regions[i].start + plane_extent(&regions[i].shape))
      return fail(
          rules->context, HBIL_INVALID_FRAME,
          "%s: lies in the plan's scratch memory, which frames overwrite",
          plane_kinds[i].name);
  return HBIL_SUCCESS;
}

/* Pixels that alternate are only told apart if both planes have the same
 * distances between pixels and rows. */
static hbil_status overlapping(hbil_context *context, int plane, int other,
                               const plane_shape *a, const plane_shape *b) {
  const bool alike = a->row == b->row && a->pixel == b->pixel;
  return fail(context, HBIL_INVALID_FRAME,
              "%s: overlaps %s%s; an output needs bytes of its own",
              plane_kinds[plane].name, plane_kinds[other].name,
              alike ? ""
                    : ", or alternates with it at another pixel_pitch or "
                      "row_pitch");
}

/* That outputs have bytes of their own.  Planes that don't exist have no
 * memory. */
static hbil_status check_overlaps(hbil_context *context,
                                  const plane_region regions[PLANE_COUNT]) {
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT; ++i) {
    const char *name = plane_kinds[i].name;
    if (!regions[i].memory)
      continue;
    if (plane_overlaps_itself(&regions[i].shape))
      return fail(context, HBIL_INVALID_FRAME,
                  "%s.plane_pitch: with %zu bytes its channels overlap", name,
                  regions[i].shape.image);
    for (int k = 0; k < i; ++k)
      if (planes_overlap(&regions[i], &regions[k]))
        return overlapping(context, i, k, &regions[i].shape, &regions[k].shape);
  }
  return HBIL_SUCCESS;
}

static hbil_status check_hardware_depth(const plane_rules *rules,
                                        const hbil_frame *frame) {
  const double a = frame->hardware_depth[0], b = frame->hardware_depth[1];
  /* the kernels' quotients of both are floats */
  if (rules->config->inputs.depth_kind != HBIL_DEPTH_HARDWARE ||
      (isfinite((float)a) && isnormal((float)b)))
    return HBIL_SUCCESS;
  return fail(rules->context, HBIL_INVALID_FRAME,
              "hardware_depth: A = %g, B = %g; HBIL_DEPTH_HARDWARE needs those "
              "of the projection, finite, and B not 0 "
              "(hbil_camera_from_matrices())",
              a, b);
}

hbil_status check_planes(const plane_rules *rules, const hbil_frame *frame,
                         unsigned planes) {
  hbil_status status = check_hardware_depth(rules, frame);
  plane_region regions[PLANE_COUNT];
  memset(regions, 0, sizeof regions);
  for (int i = 0; i < PLANE_COUNT && status == HBIL_SUCCESS; ++i)
    if (planes & PLANE_BIT(i))
      status = check_plane(rules, frame, i, &regions[i]);
  if (status == HBIL_SUCCESS)
    status = check_scratch(rules, regions);
  if (status == HBIL_SUCCESS)
    status = check_overlaps(rules->context, regions);
  return status;
}

hbil_status check_flag(hbil_context *context, hbil_status wrong,
                       const char *name, cl_bool flag) {
  return flag <= CL_TRUE
             ? HBIL_SUCCESS
             : fail(context, wrong, "%s: %u; must be CL_TRUE or CL_FALSE", name,
                    (unsigned)flag);
}

hbil_status check_exposure(hbil_context *context, hbil_status wrong,
                           float exposure) {
  const double e = (double)exposure;
  return e == 0.0 || (e >= LEAST_EXPOSURE && e <= MOST_EXPOSURE)
             ? HBIL_SUCCESS
             : fail(context, wrong, "exposure: %g; must be 0, for 1, or %g..%g",
                    e, LEAST_EXPOSURE, MOST_EXPOSURE);
}

hbil_status check_environment(hbil_context *context, hbil_status wrong,
                              hbil_far_field far_field,
                              const float environment[9][3]) {
  const bool sh = far_field == HBIL_FAR_SH;
  const int count = sh ? 9 : far_field == HBIL_FAR_NONE ? 0 : 1;
  for (int i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) {
      const float v = environment[i][c];
      if (!(fabsf(v) <= HBIL_BRIGHTEST) || (!sh && v < 0.0f))
        return fail(context, wrong,
                    "environment[%d][%d]: %g; must be finite%s, at most %g", i,
                    c, (double)v, sh ? "" : " and not negative",
                    (double)HBIL_BRIGHTEST);
    }
  return HBIL_SUCCESS;
}

hbil_status check_wait_list(hbil_context *context, const char *function,
                            cl_uint wait_count, const cl_event *wait_list) {
  for (cl_uint i = 0; wait_list && i < wait_count; ++i) {
    cl_context of_event = NULL;
    const cl_int error = wait_list[i]
                             ? clGetEventInfo(wait_list[i], CL_EVENT_CONTEXT,
                                              sizeof of_event, &of_event, NULL)
                             : CL_INVALID_EVENT;
    if (error == CL_INVALID_EVENT)
      return fail(context, HBIL_INVALID_ARGUMENT,
                  "%s: wait_list[%u]: %s; must be an event", function,
                  (unsigned)i, wait_list[i] ? cl_error_name(error) : "null");
    if (error != CL_SUCCESS)
      return fail_cl(context, error, "clGetEventInfo");
    if (of_event != context->context)
      return fail(context, HBIL_INVALID_ARGUMENT,
                  "%s: wait_list[%u]: an event of another OpenCL context; must "
                  "be of that of hbil_context_create()",
                  function, (unsigned)i);
  }
  if (!wait_count != !wait_list)
    return fail(context, HBIL_INVALID_ARGUMENT,
                "%s: wait_list is %s and wait_count %u; wait_list must be null "
                "if wait_count is 0, and only then",
                function, wait_list ? "given" : "null", (unsigned)wait_count);
  return HBIL_SUCCESS;
}

hbil_status check_queue(hbil_context *context, cl_command_queue queue,
                        bool profiling, bool *in_order) {
  cl_context of_queue = NULL;
  cl_device_id device = NULL;
  cl_command_queue_properties properties = 0;
  cl_int error = clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof of_queue,
                                       &of_queue, NULL);
  if (error == CL_SUCCESS)
    error = clGetCommandQueueInfo(queue, CL_QUEUE_DEVICE, sizeof device,
                                  &device, NULL);
  if (error == CL_SUCCESS)
    error = clGetCommandQueueInfo(queue, CL_QUEUE_PROPERTIES, sizeof properties,
                                  &properties, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clGetCommandQueueInfo");
  if (of_queue != context->context || device != context->device)
    return fail(context, HBIL_INVALID_ARGUMENT,
                "queue: not of the OpenCL context and device of "
                "hbil_context_create()");
  if (profiling && !(properties & CL_QUEUE_PROFILING_ENABLE))
    return fail(context, HBIL_INVALID_ARGUMENT,
                "queue: profiling needs CL_QUEUE_PROFILING_ENABLE");
  *in_order = !(properties & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
  return HBIL_SUCCESS;
}
