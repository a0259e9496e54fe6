/* What each far-field method costs. */
#ifndef HBIL_BENCH_FAR_METHODS_H
#define HBIL_BENCH_FAR_METHODS_H

#include "bench/fixture.h"
#include "bench/report.h"

/* Times all methods in turns on the content's frames, each with a cache of its
 * own, and adds a table of them.  Returns 0, or -1 with `error` filled. */
int bench_far_methods(const bench_options *options, const bench_device *device,
                      const bench_content *content, bench_fixture *fixture,
                      bench_report *report, image_error *error);

#endif
