/* See buffers.h. */
#include "buffers.h"

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

hbil_status buffer_create(hbil_context *context, size_t bytes, cl_mem *out) {
  cl_int error = CL_SUCCESS;
  *out = NULL;
  if (context->is_cpu)
    *out = create_on_huge_pages(context->context, bytes);
  if (!*out)
    *out = clCreateBuffer(context->context, CL_MEM_READ_WRITE, bytes, NULL,
                          &error);
  return *out ? HBIL_SUCCESS : fail_cl(context, error, "clCreateBuffer");
}

hbil_status buffer_create_in(hbil_context *context, const memory_range *lent,
                             size_t start, size_t bytes, cl_mem *out) {
  const cl_buffer_region part = {lent->start + start, bytes};
  cl_int error = CL_SUCCESS;
  *out = clCreateSubBuffer(lent->memory, CL_MEM_READ_WRITE,
                           CL_BUFFER_CREATE_TYPE_REGION, &part, &error);
  return *out ? HBIL_SUCCESS : fail_cl(context, error, "clCreateSubBuffer");
}

void buffers_release(cl_mem const buffers[], int count) {
  for (int i = 0; i < count; ++i)
    if (buffers[i])
      clReleaseMemObject(buffers[i]);
}
