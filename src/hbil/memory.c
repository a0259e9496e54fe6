/* The plan's buffers, and scratch memory that the caller lends. */
#include "memory.h"

#include "huge_pages.h"

cl_int memory_read(cl_mem buffer, memory_info *info) {
  const struct {
    cl_mem_info what;
    size_t size;
    void *value;
  } queries[] = {
      {CL_MEM_TYPE, sizeof info->type, &info->type},
      {CL_MEM_CONTEXT, sizeof info->context, &info->context},
      {CL_MEM_FLAGS, sizeof info->flags, &info->flags},
      {CL_MEM_SIZE, sizeof info->bytes, &info->bytes},
      {CL_MEM_ASSOCIATED_MEMOBJECT, sizeof info->parent, &info->parent},
      {CL_MEM_OFFSET, sizeof info->origin, &info->origin},
  };
  cl_int error = CL_SUCCESS;
  for (size_t i = 0;
       i < sizeof queries / sizeof *queries && error == CL_SUCCESS; ++i)
    error = clGetMemObjectInfo(buffer, queries[i].what, queries[i].size,
                               queries[i].value, NULL);
  return error;
}

hbil_status memory_limits(hbil_context *context, buffer_limits *limits) {
  cl_ulong largest = 0;
  cl_uint bits = 0;
  cl_int error = clGetDeviceInfo(context->device, CL_DEVICE_MAX_MEM_ALLOC_SIZE,
                                 sizeof largest, &largest, NULL);
  if (error == CL_SUCCESS)
    error = clGetDeviceInfo(context->device, CL_DEVICE_MEM_BASE_ADDR_ALIGN,
                            sizeof bits, &bits, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clGetDeviceInfo");
  limits->largest = largest < SIZE_MAX ? (size_t)largest : SIZE_MAX;
  limits->alignment = bits < 8 ? 1 : bits / 8;
  return HBIL_SUCCESS;
}

hbil_status check_lent(hbil_context *context, cl_mem scratch, size_t needed,
                       memory_range *lent) {
  memory_info info;
  const cl_int error = memory_read(scratch, &info);
  if (error == CL_INVALID_MEM_OBJECT)
    return fail(context, HBIL_INVALID_ARGUMENT, "scratch: %s",
                cl_error_name(error));
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clGetMemObjectInfo");
  if (info.type != CL_MEM_OBJECT_BUFFER)
    return fail(context, HBIL_INVALID_ARGUMENT,
                "scratch: an image or a pipe; must be a buffer");
  if (info.context != context->context)
    return fail(context, HBIL_INVALID_ARGUMENT,
                "scratch: not of the context's OpenCL context");
  if (info.flags & (CL_MEM_READ_ONLY | CL_MEM_WRITE_ONLY))
    return fail(context, HBIL_INVALID_ARGUMENT,
                "scratch: CL_MEM_READ_ONLY or CL_MEM_WRITE_ONLY; must be "
                "CL_MEM_READ_WRITE");
  if (info.bytes < needed)
    return fail(context, HBIL_INVALID_ARGUMENT,
                "scratch: %zu bytes; hbil_plan_memory() asks for %zu",
                info.bytes, needed);
  lent->memory = info.parent ? info.parent : scratch;
  lent->start = info.origin;
  lent->bytes = needed;
  return HBIL_SUCCESS;
}

cl_mem memory_create(const hbil_context *context, size_t bytes, cl_int *error) {
  cl_mem buffer = NULL;
  if (context->is_cpu)
    buffer = create_on_huge_pages(context->context, bytes);
  return buffer ? buffer
                : clCreateBuffer(context->context, CL_MEM_READ_WRITE, bytes,
                                 NULL, error);
}

static cl_mem create_buffer(const hbil_plan *plan, int buffer, cl_int *error) {
  const size_t bytes = plan->layout.bytes[buffer];
  if (!plan->lent.memory || !layout_is_scratch(buffer))
    return memory_create(plan->context, bytes, error);
  const cl_buffer_region part = {plan->lent.start + plan->layout.at[buffer],
                                 bytes};
  return clCreateSubBuffer(plan->lent.memory, CL_MEM_READ_WRITE,
                           CL_BUFFER_CREATE_TYPE_REGION, &part, error);
}

hbil_status allocate(hbil_plan *plan) {
  for (int i = 0; i < BUFFER_COUNT; ++i) {
    cl_int error = CL_SUCCESS;
    if (!plan->layout.bytes[i])
      continue;
    plan->buffers[i] = create_buffer(plan, i, &error);
    if (!plan->buffers[i])
      return fail_cl(plan->context, error,
                     plan->lent.memory ? "clCreateSubBuffer"
                                       : "clCreateBuffer");
  }
  return HBIL_SUCCESS;
}

static hbil_status clear_layers(commands *chain, int buffer,
                                const hbil_layer_args *layers, float nothing) {
  hbil_plan *plan = chain->plan;
  const hbil_clear_args args = {*layers, plan->layout.span, nothing};
  const argument list[] = {ARG(args), BUFFER_ARG(plan, buffer)};
  const size_t rows = HBIL_LAYERS * ((size_t)layers->height + 2);
  return LAUNCH(chain, KERNEL_CLEAR_PADDING, list, rows, 1, 1);
}

hbil_status clear_padding(commands *chain) {
  const layout *l = &chain->plan->layout;
  const hbil_status status =
      clear_layers(chain, BUFFER_SPLIT, &l->split, HBIL_NOTHING);
  return status == HBIL_SUCCESS
             ? clear_layers(chain, BUFFER_LIGHT, &l->light, 0.0f)
             : status;
}
