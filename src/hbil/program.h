/* OpenCL programs, one per pass. */
#ifndef HBIL_PROGRAM_H
#define HBIL_PROGRAM_H

#include <stdbool.h>

#include "binary.h"

typedef struct program_kind {
  const char *name;    /* of its file, without .cl */
  bool relaxed;        /* relaxed arithmetic: results may differ in rounding */
  const char *defines; /* of its own, beside the owner's or instead of them;
                          NULL: none */
  int registers;       /* the most of a work-item where the compiler takes a
                          limit; 0: as many as it likes */
} program_kind;

/* The most characters that the defines of an owner take. */
enum { MOST_DEFINES = 4096 };

/* Builds the program of one pass.  `defines` has all defines of a plan or a
 * cache as
 * "-DNAME=VALUE" with spaces between; the program gets those that its text
 * names outside of comments.  So plans that differ in nothing that a program
 * reads share it in the driver's cache.  #include "..." lines of the kernel
 * files are expanded here, each file once.  Therefore a file that is included
 * under a condition must not be the first to include another one.  If the
 * context shares this program or has it stored, that is used; identity is for
 * kernels_share(). */
hbil_status program_build(hbil_context *context, const program_kind *kind,
                          const char *defines, cl_program *out,
                          binary_identity *identity);

/* Warns of kernels that HBIL_KERNEL_DIR puts in place of the embedded ones. */
void program_report_folder(hbil_context *context);

/* --- kernel_sources.c (generated from kernels/) --- */

typedef struct kernel_source {
  const char *name; /* path below kernels/ */
  const char *text;
} kernel_source;
extern const kernel_source kernel_sources[]; /* ends with a NULL name */

#endif
