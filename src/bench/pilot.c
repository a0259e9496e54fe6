/* hbil-bench pilot: the first frames of a process; and starting that process.
 */
#define _POSIX_C_SOURCE 200809L
#include "bench/pilot.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/fixture.h"
#include "bench/settings.h"

/* --- in that process --- */

static int first_frames(bench_fixture *f, const bench_device *device,
                        const hbil_config *config, bench_pilot_times *out,
                        image_error *error) {
  bench_trial t;
  double before = bench_clock();
  int failed = bench_trial_open(f, config, NULL, &t, error);
  out->plan = bench_clock() - before;
  for (unsigned i = 0; i < BENCH_PILOT_FRAMES && !failed; i++) {
    before = bench_clock();
    failed = bench_trial_run(&t, i % 2, 0, 0, error);
    clFinish(device->queue);
    out->frame[i] = bench_clock() - before;
  }
  bench_trial_close(&t);
  return failed;
}

static int measure(const bench_options *options, const bench_device *device,
                   const bench_content *content, bench_pilot_times *out,
                   image_error *error) {
  const bench_setting standard = bench_setting_default(content);
  bench_turn turn = {.fixture = NULL};
  bench_timing timing;
  bench_setting_apply(&standard, content, &turn.config);
  const int failed =
      bench_fixture_open(device, content, &turn.fixture, error) != 0 ||
      first_frames(turn.fixture, device, &turn.config, out, error) != 0 ||
      bench_time_turns(&turn, 1, options->runs, &timing, error) != 0;
  bench_fixture_close(turn.fixture);
  if (failed)
    return -1;
  out->units = device->units;
  out->total = timing.total.median;
  out->gather = timing.pass[HBIL_PASS_GATHER].median;
  return 0;
}

static int run(const bench_options *options, const bench_device *device,
               struct bench_report *report, image_error *error) {
  bench_content content;
  bench_pilot_times t;
  (void)report;
  if (bench_content_load(options, 2, 0, &content, error) != 0)
    return -1;
  const int failed = measure(options, device, &content, &t, error);
  bench_content_free(&content);
  if (!failed)
    printf("units %u plan %.6f frames %.6f %.6f %.6f total %.6f gather %.6f\n",
           t.units, t.plan, t.frame[0], t.frame[1], t.frame[2], t.total,
           t.gather);
  return failed;
}

const bench_command bench_pilot = {
    .name = "pilot",
    .about = "the first frames of a process (started by scaling)",
    .details =
        "How long do a new plan and its first three frames take?  Prints one\n"
        "line of milliseconds.  hbil-bench scaling starts this several "
        "times.\n",
    .accepts = BENCH_TAKES_ROOM | BENCH_TAKES_TIMES,
    .runs = 9,
    .run = run};

/* --- starting it --- */

/* Names travel in the environment, so that the shell need not quote them.  The
 * two variables of PoCL that limit its threads are for its versions before and
 * after 4. */
static FILE *open_pipe(const bench_options *options, uint32_t width,
                       uint32_t height, unsigned runs, bench_pilot_kind kind) {
  static const char *const before[] = {
      [BENCH_PILOT_USUAL] = "exec",
      [BENCH_PILOT_SINGLE_THREAD] =
          "export POCL_MAX_PTHREAD_COUNT=1 POCL_CPU_MAX_CU_COUNT=1; exec",
      [BENCH_PILOT_COLD] =
          ("cache=$(mktemp -d) || exit; trap 'rm -rf \"$cache\"' 0;"
           "export POCL_CACHE_DIR=\"$cache\";")};
  char command[512];
  if (setenv("HBIL_BENCH_PROGRAM", options->program, 1) != 0 ||
      setenv("HBIL_BENCH_DEVICE", options->device ? options->device : "", 1) !=
          0)
    return NULL;
  snprintf(command, sizeof command,
           "%s \"$HBIL_BENCH_PROGRAM\" pilot --size %ux%u --runs %u %s",
           before[kind], width, height, runs,
           options->device ? "--device \"$HBIL_BENCH_DEVICE\"" : "");
  fflush(NULL);
  return popen(command, "r");
}

int bench_pilot_start(const bench_options *options, uint32_t width,
                      uint32_t height, unsigned runs, bench_pilot_kind kind,
                      bench_pilot_times *out, image_error *error) {
  FILE *in = open_pipe(options, width, height, runs, kind);
  if (!in)
    return image_fail(error, "%s: cannot be started once more",
                      options->program);
  const int read =
      fscanf(in, "units %u plan %lf frames %lf %lf %lf total %lf gather %lf",
             &out->units, &out->plan, &out->frame[0], &out->frame[1],
             &out->frame[2], &out->total, &out->gather);
  return pclose(in) == 0 && read == 7
             ? 0
             : image_fail(error, "hbil-bench pilot has failed");
}
