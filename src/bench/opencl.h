/* An OpenCL device with a profiling queue, and the bench's own kernels. */
#ifndef HBIL_BENCH_OPENCL_H
#define HBIL_BENCH_OPENCL_H

#include "bench/statistics.h"
#include "hbil/hbil.h"
#include "image/error.h"

typedef struct bench_device {
  cl_device_id id;
  cl_context context;
  cl_command_queue queue; /* in order, with profiling */
  char name[256], platform[256], version[256], driver[256];
  cl_uint units;   /* compute units */
  cl_ulong memory; /* bytes of global memory */
  int is_cpu;
} bench_device;

/* wanted: an index over all platforms' devices, a part of a name, or NULL: the
 * first GPU, else the first device. */
int bench_device_open(const char *wanted, bench_device *out,
                      image_error *error);
void bench_device_close(bench_device *d);

/* "device NAME: OpenCL error STATUS while DOING"; returns -1. */
int bench_opencl_failed(const bench_device *d, cl_int status, const char *doing,
                        image_error *error);

/* A buffer of so many bytes; content: what to fill it with, or NULL. */
int bench_buffer_new(const bench_device *d, size_t bytes, const void *content,
                     cl_mem *out, image_error *error);

/* Files that are embedded in the program, generated from this folder's .cl and
 * .gnuplot files; the list ends with a NULL name. */
typedef struct bench_source {
  const char *name, *text;
} bench_source;
extern const bench_source bench_sources[];
/* The text of a file that is embedded under that name. */
const char *bench_source_text(const char *name);

/* The kernel NAME of the embedded file NAME.cl. */
int bench_kernel_new(const bench_device *d, const char *name,
                     const char *defines, cl_kernel *out, image_error *error);
/* Milliseconds of `runs` launches after the warm-up, by profiling events. */
int bench_kernel_time(const bench_device *d, cl_kernel kernel,
                      const size_t global[2], const size_t local[2],
                      unsigned runs, bench_spread *out, image_error *error);

#endif
