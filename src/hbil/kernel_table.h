/* The programs and kernels of plans and caches, by their tables, and the first
 * commands of both. */
#ifndef HBIL_KERNEL_TABLE_H
#define HBIL_KERNEL_TABLE_H

#include "layout.h"
#include "program.h"

typedef struct kernel_kind {
  const char *name; /* in the text of its program */
  int program;      /* its index in the table's programs */
} kernel_kind;

typedef struct kernel_table {
  const program_kind *programs;
  const kernel_kind *kernels;
  int program_count, kernel_count;
} kernel_table;

/* Builds the kernels of a table that are needed, and the programs that these
 * are in; the others stay NULL.  needed: one for each kernel; NULL: all are.
 * config and l decide the defines.  programs, kernels and identity have the
 * order of the table; kernels_release() releases what a failure has left. */
hbil_status kernels_build(hbil_context *context, const kernel_table *table,
                          const bool *needed, const hbil_config *config,
                          const layout *l, cl_program programs[],
                          cl_kernel kernels[], binary_identity identity[]);

/* Stores the programs that were built.  To be called after the trial launches,
 * because binaries may hold what was compiled for these. */
void kernels_store(hbil_context *context, const kernel_table *table,
                   const cl_program programs[],
                   const binary_identity identity[]);

void kernels_release(const kernel_table *table, const cl_program programs[],
                     const cl_kernel kernels[]);

/* Enqueues the first commands of an object in a queue, which is in order. */
typedef hbil_status first_commands(void *object, cl_command_queue queue);

/* Runs them in a queue of their own, and waits. */
hbil_status run_first_commands(hbil_context *context, first_commands *enqueue,
                               void *object);

#endif
