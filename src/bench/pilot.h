/* A plan in a process of its own, for what a process does only once: loading
 * the kernels, and choosing how many threads OpenCL has. */
#ifndef HBIL_BENCH_PILOT_H
#define HBIL_BENCH_PILOT_H

#include "bench/command.h"

/* The second frame is the first with history, and loads further kernels. */
enum { BENCH_PILOT_FRAMES = 3 };

/* Milliseconds. */
typedef struct bench_pilot_times {
  unsigned units; /* compute units of the device in that process */
  double plan, frame[BENCH_PILOT_FRAMES]; /* by the wall clock, until done */
  double total, gather; /* device times of later frames, medians */
} bench_pilot_times;

typedef enum bench_pilot_kind {
  BENCH_PILOT_USUAL,
  BENCH_PILOT_SINGLE_THREAD, /* with one CPU thread, which PoCL understands */
  BENCH_PILOT_COLD /* without compiled kernels: PoCL's cache is empty */
} bench_pilot_kind;

/* Runs `hbil-bench pilot` on the room. */
int bench_pilot_start(const bench_options *options, uint32_t width,
                      uint32_t height, unsigned runs, bench_pilot_kind kind,
                      bench_pilot_times *out, image_error *error);

#endif
