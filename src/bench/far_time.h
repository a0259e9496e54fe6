/* What each provider of far light costs. */
#ifndef HBIL_BENCH_FAR_TIME_H
#define HBIL_BENCH_FAR_TIME_H

#include "bench/far_provider.h"
#include "bench/fixture.h"
#include "bench/report.h"

/* Medians in milliseconds; NAN where the provider has no such part. */
typedef struct far_time {
  double cache;  /* a frame's injection and update, as in hbil process */
  double build;  /* what the provider adds to an update of the cache, or reading
                    the light view */
  double use;    /* what it adds to the frame: probes, and their light */
  double frame;  /* the frame with its own part */
  double whole;  /* all of these that the provider needs */
  double memory; /* of the cache with this provider, MiB */
} far_time;

/* Measures all providers in turns on the content's frames.  Returns 0, or -1
 * with `error` filled. */
int far_times_measure(const bench_options *options, const bench_device *device,
                      const bench_content *content, bench_fixture *fixture,
                      far_time out[FAR_PROVIDERS], image_error *error);

/* Adds a table of them, and a note of what they contain. */
void far_times_report(const far_time times[FAR_PROVIDERS],
                      bench_report *report);
/* The note alone. */
void far_times_note(bench_report *report);

#endif
