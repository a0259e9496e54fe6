/* The programs and kernels of one owner: a plan or a cache. */
#ifndef HBIL_KERNEL_SET_H
#define HBIL_KERNEL_SET_H

#include "program.h"

/*
 * An owner writes each of its programs and kernels once, in a list:
 *
 *   X(id, file, needed, members...)   a program: its enumerator, its file,
 *                                     whether this owner needs it, and further
 *                                     members of program_kind
 *   X(id, name, program, needed)      a kernel: its enumerator, its name in the
 *                                     text, its program's enumerator, and
 *                                     whether an owner with that program needs
 *                                     it
 *
 * `needed` are expressions; the owner's list says which names they use.  These
 * macros, put in place of X, make enumerators and arrays of the lists.
 */
#define LISTED_ENUMERATOR(id, ...) id,
#define LISTED_PROGRAM(id, file, needed, ...) [id] = {file, __VA_ARGS__},
#define LISTED_KERNEL(id, name, program, needed) [id] = {name, program},
#define PROGRAM_NEEDED(id, file, needed, ...) [id] = (needed),
#define KERNEL_NEEDED(id, name, program, needed) [id] = (needed),

/* More than any owner has. */
enum { MOST_PROGRAMS = 24, MOST_KERNELS = 32 };

typedef struct kernel_kind {
  const char *name;
  int program;
} kernel_kind;

typedef struct kernel_table {
  const program_kind *programs;
  const kernel_kind *kernels;
  int program_count, kernel_count;
} kernel_table;

typedef struct kernel_set {
  const kernel_table *table;
  cl_program programs[MOST_PROGRAMS]; /* NULL: not needed */
  cl_kernel kernels[MOST_KERNELS];
  binary_identity identity[MOST_PROGRAMS];
} kernel_set;

/* Builds the programs that are needed, and those of their kernels that are
 * needed.  The arrays have the order of the table.  defines: as in
 * program_build().  kernels_release() releases what a failure has left. */
hbil_status kernels_build(hbil_context *context, const kernel_table *table,
                          const bool needed_programs[],
                          const bool needed_kernels[], const char *defines,
                          kernel_set *set);

/* Stores the programs that were built, and shares all with later owners.  To be
 * called after the trial launches, because binaries may hold what was compiled
 * for these. */
void kernels_share(hbil_context *context, const kernel_set *set);

void kernels_release(const kernel_set *set);

#endif
