/* See kernel_table.h. */
#include "kernel_table.h"

#include "context.h"
#include "defines.h"

static bool is_needed(const bool *needed, int kernel) {
  return !needed || needed[kernel];
}

static bool program_is_needed(const kernel_table *table, const bool *needed,
                              int program) {
  for (int i = 0; i < table->kernel_count; ++i)
    if (table->kernels[i].program == program && is_needed(needed, i))
      return true;
  return false;
}

hbil_status kernels_build(hbil_context *context, const kernel_table *table,
                          const bool *needed, const hbil_config *config,
                          const layout *l, cl_program programs[],
                          cl_kernel kernels[], binary_identity identity[]) {
  char defines[MOST_DEFINES];
  hbil_status status =
      write_defines(context, config, l, defines, sizeof defines);
  for (int i = 0; i < table->program_count && status == HBIL_SUCCESS; ++i)
    if (program_is_needed(table, needed, i))
      status = program_build(context, &table->programs[i], defines,
                             &programs[i], &identity[i]);
  for (int i = 0; i < table->kernel_count && status == HBIL_SUCCESS; ++i) {
    const kernel_kind *kind = &table->kernels[i];
    cl_int error = CL_SUCCESS;
    if (!is_needed(needed, i))
      continue;
    kernels[i] = clCreateKernel(programs[kind->program], kind->name, &error);
    if (!kernels[i])
      status = fail_cl(context, error, "clCreateKernel(%s)", kind->name);
  }
  return status;
}

void kernels_store(hbil_context *context, const kernel_table *table,
                   const cl_program programs[],
                   const binary_identity identity[]) {
  for (int i = 0; i < table->program_count; ++i)
    if (programs[i])
      binary_store(context, programs[i], &identity[i]);
}

void kernels_release(const kernel_table *table, const cl_program programs[],
                     const cl_kernel kernels[]) {
  for (int i = 0; i < table->kernel_count; ++i)
    if (kernels[i])
      clReleaseKernel(kernels[i]);
  for (int i = 0; i < table->program_count; ++i)
    if (programs[i])
      clReleaseProgram(programs[i]);
}

hbil_status run_first_commands(hbil_context *context, first_commands *enqueue,
                               void *object) {
  cl_int error = CL_SUCCESS;
  cl_command_queue queue =
      clCreateCommandQueue(context->context, context->device, 0, &error);
  if (!queue)
    return fail_cl(context, error, "clCreateCommandQueue");
  const hbil_status status = enqueue(object, queue);
  error = clFinish(queue);
  clReleaseCommandQueue(queue);
  return status == HBIL_SUCCESS && error != CL_SUCCESS
             ? fail_cl(context, error, "clFinish")
             : status;
}
