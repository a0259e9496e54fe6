/* The report as text and as comma-separated values. */
#include "bench/bench.h"

#include <math.h>
#include <string.h>

void bench_reference(const bench_report *report, char *text, size_t size) {
  snprintf(text, size, "exact integral, %d slices", report->exact_slices);
}

void bench_notes(const bench_report *report, FILE *out, const char *before,
                 const char *after) {
  char reference[64];
  bench_reference(report, reference, sizeof reference);
  fprintf(out,
          "%sSampling error is measured, after recompose and for one bounce, "
          "against the model's %s in double precision, every pixel that a "
          "slice crosses, at %zu pixels, as many in each of the 16 layers.%s",
          before, reference, report->content->compared_count, after);
  fprintf(out,
          "%sModels: none named: the library's defaults, the paper's; thick: "
          "occluders end after that share of their depth; tool: hbil process; "
          "gtao: AO alone; hbao: AO alone, radius %.3g.%s",
          before, (double)report->content->radius, after);
  fprintf(out,
          "%sE_near: RMSE over its mean; AO: RMSE.  Times: medians of %u runs "
          "after %d of warm-up, on the device.%s",
          before, report->runs, BENCH_WARM_UP, after);
  if (report->content->truth)
    fprintf(out,
            "%sModel error: RMSE of indirect light against the path tracer "
            "after %d bounces; zero has %.4g, the constant mean %.4g.%s",
            before, BENCH_TRUTH_BOUNCES,
            bench_model_error(report->content, NULL),
            bench_mean_error(report->content), after);
  if (report->content->note[0])
    fprintf(out, "%s%s%s", before, report->content->note, after);
}

/* --- text --- */

void bench_print_machine(const bench_machine *m, FILE *out) {
  fprintf(out, "device   %s, %u compute units\ndriver   %s, %s, %s\n",
          m->device, (unsigned)m->units, m->platform, m->version, m->driver);
}

static void print_head(const bench_report *report, FILE *out) {
  bench_print_machine(&report->machine, out);
  fprintf(out, "content  %s, %u x %u pixels, %u frame%s\n",
          report->content->name, report->content->width,
          report->content->height, report->content->frames,
          report->content->frames == 1 ? "" : "s");
}

static void print_yardsticks(const bench_report *report, FILE *out) {
  const bench_literal *l = &report->literal;
  const bench_copy *c = &report->copy;
  fprintf(out,
          "literal  %.2f ms (%.2f .. %.2f): the paper as it reads, one "
          "work-item a pixel, 2x8, unfiltered: E_near %.3g, AO %.3g\n",
          l->milliseconds.median, l->milliseconds.low, l->milliseconds.high,
          l->light_error, l->ao_error);
  fprintf(out, "copy     %.3f ms (%.3f .. %.3f) for %u planes: %.1f GB/s\n\n",
          c->milliseconds.median, c->milliseconds.low, c->milliseconds.high,
          c->planes, (double)c->bytes * 1e-6 / c->milliseconds.median);
}

static int label_width(const bench_report *report) {
  int width = 16;
  for (size_t i = 0; i < report->count; i++) {
    const int length = (int)strlen(report->rows[i].label);
    width = length > width ? length : width;
  }
  return width;
}

/* Two lines, so that columns stay narrow. */
static void print_names(const bench_report *report, FILE *out) {
  const int width = label_width(report) + 1;
  const char *model = report->content->truth ? "    model" : "";
  fprintf(out, "%-*s", width, "");
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    fprintf(out, " %9s", hbil_pass_name((hbil_pass)p));
  fprintf(out, " %9s %17s %6s %9s %9s %6s %6s %9s %8s%s\n", "total", "of total",
          "host", "literal", "literal", "gather", "total", "E_near", "AO",
          model);
  fprintf(out, "%-*s", width, "slices x samples");
  for (int p = 0; p < HBIL_PASS_COUNT + 1; p++)
    fprintf(out, " %9s", "ms");
  model = report->content->truth ? "    error" : "";
  fprintf(out, " %17s %6s %9s %9s %6s %6s %9s %8s%s\n", "min .. max", "ms",
          "/gather", "/total", "/start", "/start", "error", "error", model);
}

/* "-" where there is none. */
static void print_error(FILE *out, double value, int front) {
  if (isfinite(value))
    fprintf(out, " %8.4f%c", value, front ? '+' : ' ');
  else
    fprintf(out, " %8s ", "-");
}

static void print_row(const bench_report *report, const bench_row *row,
                      FILE *out) {
  const double literal = report->literal.milliseconds.median;
  const double gather = row->pass[HBIL_PASS_GATHER].median;
  fprintf(out, "%-*s%c", label_width(report), row->label,
          bench_is_default(&row->configuration)         ? '*'
          : bench_is_tools_default(&row->configuration) ? 't'
                                                        : ' ');
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    fprintf(out, " %9.3f", row->pass[p].median);
  fprintf(out, " %9.3f %7.2f .. %6.2f %6.3f %9.1f %9.1f %6.2f %6.2f",
          row->total.median, row->total.low, row->total.high, row->host.median,
          literal / gather, literal / row->total.median, row->gather_over_start,
          row->total_over_start);
  print_error(out, row->light_error, row->light_front);
  print_error(out, row->ao_error, row->ao_front);
  if (report->content->truth)
    print_error(out, row->model_error, 0);
  fputc('\n', out);
}

/* --- what is compared in turns --- */

static void print_thickness(const bench_report *report, FILE *out) {
  int any = 0;
  for (size_t i = 0; i < report->count; i++) {
    const bench_row *row = &report->rows[i];
    if (!isfinite(row->over_endless))
      continue;
    if (!any++)
      fputs("\ngather's time over that with endless occluders, in turns:\n",
            out);
    fprintf(out, "  %-*s %6.2f\n", label_width(report), row->label,
            row->over_endless);
  }
}

/* What each storage loses against fp32, and what it costs. */
static void print_storages(const bench_report *report, FILE *out) {
  fprintf(out,
          "\nlayers against fp32, E_near over its mean:\n  %-*s %9s %9s "
          "%9s %9s %9s\n",
          label_width(report), "", "E_near", "AO", "gather ms", "total ms",
          "MiB");
  for (size_t i = 0; i < report->count; i++) {
    const bench_row *row = &report->rows[i];
    if (isfinite(row->light_loss))
      fprintf(out, "  %-*s %9.2g %9.2g %9.3f %9.3f %9.1f\n",
              label_width(report), row->label, row->light_loss, row->ao_loss,
              row->pass[HBIL_PASS_GATHER].median, row->total.median,
              (double)row->memory / 1048576.0);
  }
}

static void print_share(const bench_report *report, const bench_row *row,
                        FILE *out) {
  fprintf(out, "%.1f %% of the frame, %s",
          100.0 * report->estimate / row->total.median, row->label);
}

/* At the tool's default, and where the frame is the shortest. */
static void print_estimate(const bench_report *report, FILE *out) {
  const bench_row *shortest = NULL, *standard = NULL;
  for (size_t i = 0; i < report->count; i++) {
    const bench_row *row = &report->rows[i];
    if (row->configuration.model != BENCH_TOOL)
      continue;
    if (bench_is_tools_default(&row->configuration))
      standard = row;
    if (!shortest || row->total.median < shortest->total.median)
      shortest = row;
  }
  if (!standard || !isfinite(report->estimate))
    return;
  fprintf(out, "\nestimate: %.2f ms, ", report->estimate);
  print_share(report, standard, out);
  if (shortest != standard) {
    fputs("; ", out);
    print_share(report, shortest, out);
  }
  fputc('\n', out);
}

static void print_copies(const bench_report *report, const char *name,
                         double milliseconds, double bytes, FILE *out) {
  fprintf(out, "  %-18s %6.2f (%.3f ms, %.1f MiB)", name,
          milliseconds / bench_copy_time(&report->copy, bytes), milliseconds,
          bytes / 1048576.0);
}

/* One pass of the default (or first) configuration. */
static void print_ratio(const bench_report *report, const bench_row *row,
                        hbil_pass pass, FILE *out) {
  print_copies(report, hbil_pass_name(pass), row->pass[pass].median,
               bench_pass_bytes(report->content, pass), out);
  fputc('\n', out);
}

/* In a plan of its own. */
static void print_motion(const bench_report *report, FILE *out) {
  if (!isfinite(report->motion.median))
    return;
  print_copies(report, "reproject (motion)", report->motion.median,
               bench_motion_bytes(report->content), out);
  fputs(", aim: at most 1.5\n", out);
}

/* Images of half floats beside such of floats, in turns. */
static void print_halves(const bench_report *report, FILE *out) {
  const bench_timing *halves = &report->halves[1];
  const bench_configuration first = bench_first();
  char label[BENCH_LABEL];
  bench_label(&first, label, sizeof label);
  fprintf(out,
          "images of half floats but for depth, %s: frame %.3f ms "
          "(%.3f .. %.3f), %.3f of that with floats; split %.3f, composite "
          "%.3f\n",
          label, halves->total.median, halves->total.low, halves->total.high,
          halves->total_ratio, halves->pass_ratio[HBIL_PASS_SPLIT],
          halves->pass_ratio[HBIL_PASS_COMPOSITE]);
}

static void print_ratios(const bench_report *report, FILE *out) {
  const bench_row *row = &report->rows[0];
  for (size_t i = 0; i < report->count; i++)
    if (bench_is_default(&report->rows[i].configuration))
      row = &report->rows[i];
  fprintf(out, "\ntimes of a copy of its bytes, %s:\n", row->label);
  print_motion(report, out);
  print_ratio(report, row, HBIL_PASS_SPLIT, out);
  print_ratio(report, row, HBIL_PASS_PUSH_PULL, out);
  print_ratio(report, row, HBIL_PASS_COMPOSITE, out);
  fprintf(out, "device memory, %s: %.1f MiB\n", row->label,
          (double)row->memory / 1048576.0);
  print_halves(report, out);
}

/* --- adaptive sampling beside uniform --- */

static double off_95(const bench_row *row, int ao) {
  return ao ? row->ao_95 : row->light_95;
}

/* The fastest uniform row of as good a 95 %, or NULL. */
static const bench_row *uniform_within(const bench_report *report,
                                       const bench_row *adaptive, int ao,
                                       double limit) {
  const bench_row *best = NULL;
  for (size_t i = 0; i < report->count; i++) {
    const bench_row *row = &report->rows[i];
    if (bench_is_uniform_of(&row->configuration, &adaptive->configuration) &&
        off_95(row, ao) <= limit &&
        (!best || row->pass[HBIL_PASS_GATHER].median <
                      best->pass[HBIL_PASS_GATHER].median))
      best = row;
  }
  return best;
}

/* Where each frame chooses, and where as many do as in the tool. */
static void print_uniform(const bench_row *row, const bench_row *uniform,
                          FILE *out) {
  const double each = row->pass[HBIL_PASS_GATHER].median;
  if (uniform)
    fprintf(out, "  %3ux%-3u %6.1f ms %5.2f %5.2f",
            (unsigned)uniform->configuration.slices,
            (unsigned)uniform->configuration.samples,
            uniform->pass[HBIL_PASS_GATHER].median,
            each / uniform->pass[HBIL_PASS_GATHER].median,
            (each - (1.0 - 1.0 / CHOOSE_EVERY) * row->choosing) /
                uniform->pass[HBIL_PASS_GATHER].median);
  else
    fprintf(out, "  %-28s", "none");
}

static void print_adaptive(const bench_report *report, FILE *out) {
  int named = 0;
  for (size_t i = 0; i < report->count; i++) {
    const bench_row *row = &report->rows[i];
    const bench_configuration *c = &row->configuration;
    if (!bench_is_adaptive(c))
      continue;
    if (!named++)
      fprintf(out,
              "\nadaptive sampling, the gather alone, and its time over that "
              "of the fastest uniform setting: where each frame chooses, and "
              "where one in %d does\n%-24s %7s %-24s  %-28s  %s\n",
              CHOOSE_EVERY, "", "95 % of", " samples gather choosing",
              "within the limit", "as good a 95 %");
    const int ao = c->most_ao > 0.0f;
    const double limit = (double)(ao ? c->most_ao : c->most_light);
    fprintf(out, "%-24s %7.3f %4ux%-3u %6.1f %8.1f", row->label,
            off_95(row, ao), (unsigned)row->slices, (unsigned)row->samples,
            row->pass[HBIL_PASS_GATHER].median, row->choosing);
    print_uniform(row, uniform_within(report, row, ao, limit), out);
    print_uniform(row, uniform_within(report, row, ao, off_95(row, ao)), out);
    fputc('\n', out);
  }
}

void bench_write_table(const bench_report *report, FILE *out) {
  print_head(report, out);
  print_yardsticks(report, out);
  print_names(report, out);
  for (size_t i = 0; i < report->count; i++)
    print_row(report, &report->rows[i], out);
  fprintf(out,
          "* the library's default   t the tool's   + on the Pareto front, "
          "error against total, of its model\n");
  print_storages(report, out);
  print_thickness(report, out);
  print_estimate(report, out);
  print_adaptive(report, out);
  print_ratios(report, out);
  fputc('\n', out);
  bench_notes(report, out, "", "\n");
}

/* --- comma-separated values --- */

void bench_write_quoted(FILE *out, const char *text) {
  fputc('"', out);
  for (; *text; text++) {
    if (*text == '"')
      fputc('"', out);
    fputc((unsigned char)*text < ' ' ? ' ' : *text, out);
  }
  fputc('"', out);
}

void bench_write_machine(FILE *out, const bench_machine *m) {
  fputc(',', out);
  bench_write_quoted(out, m->device);
  fprintf(out, ",%u,", (unsigned)m->units);
  bench_write_quoted(out, m->driver);
  fputc(',', out);
  bench_write_quoted(out, m->version);
}

static void write_where(const bench_report *report, FILE *out) {
  char reference[64];
  bench_write_machine(out, &report->machine);
  fputc(',', out);
  bench_write_quoted(out, report->content->name);
  fprintf(out, ",%u,%u,%u,", report->content->width, report->content->height,
          report->runs);
  bench_reference(report, reference, sizeof reference);
  bench_write_quoted(out, reference);
  fputc('\n', out);
}

static void write_names(FILE *out) {
  fputs("label,model,preset,slices,samples,growth,lattice,raw,storage,"
        "extrapolate,max_ao_error,max_light_error,slices_taken,samples_taken,"
        "default",
        out);
  for (int p = 0; p < HBIL_PASS_COUNT; p++) {
    const char *name = hbil_pass_name((hbil_pass)p);
    fprintf(out, ",%s_ms,%s_min_ms,%s_max_ms", name, name, name);
  }
  fputs(",total_ms,total_min_ms,total_max_ms,host_ms,device_bytes,"
        "literal_over_gather,literal_over_total,gather_over_start,"
        "total_over_start,"
        "gather_over_endless,"
        "light_error,ao_error,model_error,light_95,ao_95,light_loss,ao_loss,"
        "light_front,ao_front,"
        "device,compute_units,driver,version,content,width,height,runs,"
        "reference\n",
        out);
}

void bench_write_number(FILE *out, double value) {
  if (isfinite(value))
    fprintf(out, ",%.6g", value);
  else
    fputc(',', out);
}

void bench_write_spread(FILE *out, bench_spread s) {
  bench_write_number(out, s.median);
  bench_write_number(out, s.low);
  bench_write_number(out, s.high);
}

static void write_row(const bench_report *report, const bench_row *row,
                      FILE *out) {
  const bench_configuration *c = &row->configuration;
  const double literal = report->literal.milliseconds.median;
  const double gather = row->pass[HBIL_PASS_GATHER].median;
  const char *model = bench_model_name(c->model);
  fprintf(out, "%s,%s,%s,%u,%u,%g,%s,%d,%s,%d", row->label,
          *model ? model : "paper", c->preset ? c->preset : "",
          (unsigned)c->slices, (unsigned)c->samples, (double)c->growth,
          c->lattice == HBIL_GRID_FULL_RESOLUTION ? "full" : "layer", c->raw,
          bench_storage_name(c), !c->plain);
  bench_write_number(out, c->most_ao > 0.0f ? (double)c->most_ao : NAN);
  bench_write_number(out, c->most_light > 0.0f ? (double)c->most_light : NAN);
  fprintf(out, ",%u,%u", (unsigned)row->slices, (unsigned)row->samples);
  fprintf(out, ",%d", bench_is_default(c));
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    bench_write_spread(out, row->pass[p]);
  bench_write_spread(out, row->total);
  bench_write_number(out, row->host.median);
  fprintf(out, ",%zu", row->memory);
  bench_write_number(out, literal / gather);
  bench_write_number(out, literal / row->total.median);
  bench_write_number(out, row->gather_over_start);
  bench_write_number(out, row->total_over_start);
  bench_write_number(out, row->over_endless);
  bench_write_number(out, row->light_error);
  bench_write_number(out, row->ao_error);
  bench_write_number(out, row->model_error);
  bench_write_number(out, row->light_95);
  bench_write_number(out, row->ao_95);
  bench_write_number(out, row->light_loss);
  bench_write_number(out, row->ao_loss);
  fprintf(out, ",%d,%d", row->light_front, row->ao_front);
  write_where(report, out);
}

/* The baseline has a kernel, but no settings and no passes. */
static void write_literal(const bench_report *report, FILE *out) {
  fputs("literal,paper,,2,8,0,full,1,fp32,0,,,2,8,0", out);
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    fputs(",,,", out);
  bench_write_spread(out, report->literal.milliseconds);
  fputs(",,,,,,,", out);
  bench_write_number(out, report->literal.light_error);
  bench_write_number(out, report->literal.ao_error);
  fputs(",,,,,,0,0", out);
  write_where(report, out);
}

void bench_write_csv(const bench_report *report, FILE *out) {
  write_names(out);
  for (size_t i = 0; i < report->count; i++)
    write_row(report, &report->rows[i], out);
  write_literal(report, out);
}
