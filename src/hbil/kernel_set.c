/* The programs and kernels of one owner: a plan or a cache. */
#include "kernel_set.h"

#include "shared_programs.h"

hbil_status kernels_build(hbil_context *context, const kernel_table *table,
                          const bool needed_programs[],
                          const bool needed_kernels[], const char *defines,
                          kernel_set *set) {
  hbil_status status = HBIL_SUCCESS;
  set->table = table;
  for (int i = 0; i < table->program_count && status == HBIL_SUCCESS; ++i)
    if (needed_programs[i])
      status = program_build(context, &table->programs[i], defines,
                             &set->programs[i], &set->identity[i]);
  for (int i = 0; i < table->kernel_count && status == HBIL_SUCCESS; ++i) {
    const kernel_kind *kind = &table->kernels[i];
    cl_int error = CL_SUCCESS;
    if (!needed_programs[kind->program] || !needed_kernels[i])
      continue;
    set->kernels[i] =
        clCreateKernel(set->programs[kind->program], kind->name, &error);
    if (!set->kernels[i])
      status = fail_cl(context, error, "clCreateKernel(%s)", kind->name);
  }
  return status;
}

void kernels_share(hbil_context *context, const kernel_set *set) {
  for (int i = 0; i < MOST_PROGRAMS; ++i)
    if (set->programs[i]) {
      binary_store(context, set->programs[i], &set->identity[i]);
      share_program(context, set->programs[i], &set->identity[i]);
    }
}

void kernels_release(const kernel_set *set) {
  for (int i = 0; i < MOST_KERNELS; ++i)
    if (set->kernels[i])
      clReleaseKernel(set->kernels[i]);
  for (int i = 0; i < MOST_PROGRAMS; ++i)
    if (set->programs[i])
      clReleaseProgram(set->programs[i]);
}
