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

/* Runs `hbil-bench pilot` on the room.  single_thread: with one CPU thread,
 * which PoCL understands. */
int bench_pilot_start(const bench_options *options, uint32_t width,
                      uint32_t height, unsigned runs, int single_thread,
                      bench_pilot_times *out, image_error *error);

#endif
