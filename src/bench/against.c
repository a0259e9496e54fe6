/* Two sets of kernels in turns: what a change of them costs or gains, pass by
 * pass, on a machine that is never quiet. */
#define _POSIX_C_SOURCE 200809L
#include "bench/bench.h"

/* What is measured: the start, the default, models that have kernels of their
 * own, and many samples. */
static void choose(const bench_content *content,
                   bench_against out[BENCH_AGAINST]) {
  for (size_t i = 0; i < BENCH_AGAINST; i++)
    out[i] = (bench_against){.configuration = bench_default()};
  out[0].configuration = bench_first();
  out[2].configuration.model = BENCH_THICK_08;
  out[3].configuration.model = BENCH_GTAO;
  out[4].configuration.samples = 32;
  out[4].follows = content->frame[0].motion != NULL;
}

static int compare(const bench_content *content, bench_lab *const labs[2],
                   const char *kernels, unsigned runs, bench_against *out,
                   image_error *error) {
  bench_turn turns[2] = {{.lab = labs[0], .kernels = kernels},
                         {.lab = labs[1]}};
  bench_timing timing[2];
  bench_configure(content, &out->configuration, &turns[0].config);
  if (out->follows)
    turns[0].config.reprojection = HBIL_REPROJECTION_MOTION;
  turns[1].config = turns[0].config;
  if (bench_lab_turns(turns, 2, runs, timing, error) != 0)
    return -1;
  out->theirs = timing[0];
  out->own = timing[1];
  return 0;
}

int bench_against_measure(const bench_options *options, const device *d,
                          const bench_content *content, bench_against *out,
                          image_error *error) {
  bench_lab *labs[2] = {NULL, NULL};
  choose(content, out);
  int failed = bench_lab_open(d, content, &labs[0], error) != 0 ||
               bench_lab_open(d, content, &labs[1], error) != 0;
  for (size_t i = 0; i < BENCH_AGAINST && !failed; i++) {
    progress_count("against", i, BENCH_AGAINST);
    failed =
        compare(content, labs, options->against, options->runs, &out[i], error);
  }
  progress_count("against", BENCH_AGAINST, BENCH_AGAINST);
  bench_lab_close(labs[0]);
  bench_lab_close(labs[1]);
  return failed ? -1 : 0;
}

/* --- text --- */

static void print_pass(FILE *out, const char *name, double theirs, double own,
                       double ratio) {
  if (theirs > 0.0 || own > 0.0)
    fprintf(out, "  %-10s %9.3f %9.3f  %6.3f\n", name, theirs, own, ratio);
}

void bench_write_against_table(const bench_report *report, FILE *out) {
  bench_print_machine(&report->machine, out);
  fprintf(out, "content  %s, %u x %u pixels\n", report->content->name,
          report->content->width, report->content->height);
  for (size_t i = 0; i < BENCH_AGAINST; i++) {
    const bench_against *a = &report->against[i];
    char label[BENCH_LABEL];
    bench_label(&a->configuration, label, sizeof label);
    fprintf(out, "\n%s%s\n  %-10s %9s %9s  %6s\n", label,
            a->follows ? ", motion vectors" : "", "ms, least", "theirs", "own",
            "ratio");
    for (int p = 0; p < HBIL_PASS_COUNT; p++)
      print_pass(out, hbil_pass_name((hbil_pass)p), a->theirs.pass[p].low,
                 a->own.pass[p].low, a->own.pass_ratio[p]);
    print_pass(out, "total", a->theirs.total.low, a->own.total.low,
               a->own.total_ratio);
  }
  fprintf(out,
          "\nLeast of %u runs after %d of warm-up, in turns; ratio: own over "
          "theirs, the median over the turns.\n",
          report->runs, BENCH_WARM_UP);
}
