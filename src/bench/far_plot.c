/* Data and script of the providers' plot. */
#include "bench/far_plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/files.h"
#include "bench/opencl.h"
#include "bench/plot.h"

typedef struct plot {
  const char *name;
  const far_point *points;
} plot;

/* A block of gnuplot for each kind of error, with a first line that draws
 * nothing, and one for the labels above them. */
static void write_data(const void *context, FILE *out) {
  const far_point *points = ((const plot *)context)->points;
  for (int kind = 0; kind < 3; kind++) {
    fprintf(out, "NaN NaN \"\"\n");
    for (int p = 0; p < FAR_PROVIDERS; p++) {
      const double *error = points[p].error;
      const double at = kind < 2 ? error[kind] : fmax(error[0], error[1]);
      if (isfinite(at) && points[p].milliseconds > 0.0)
        fprintf(out, "%g %g \"%s\"\n", points[p].milliseconds, at,
                far_provider_name((far_provider)p));
    }
    fprintf(out, "\n\n");
  }
}

static void write_script(const void *context, FILE *out) {
  const plot *p = context;
  fprintf(out, "data = \"%s.dat\"\npicture = \"%s.png\"\n", p->name, p->name);
  fputs(bench_source_text("far.gnuplot"), out);
}

int far_plot_write(const bench_options *options,
                   const far_point points[FAR_PROVIDERS], int *made,
                   image_error *error) {
  const plot p = {options->name, points};
  char *data = bench_result_path(options->output, p.name, "dat");
  char *script = bench_result_path(options->output, p.name, "gnuplot");
  int failed = data && script ? 0 : image_no_memory(error, "the plot");
  failed =
      failed ||
      temporary_write(data, EXISTING_REPLACED, write_data, &p, error) != 0 ||
      temporary_write(script, EXISTING_REPLACED, write_script, &p, error) != 0;
  if (!failed)
    *made = bench_plot_draw(options->output, strrchr(script, '/') + 1);
  free(data);
  free(script);
  return failed ? -1 : 0;
}
