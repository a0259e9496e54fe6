/* How time and memory grow, as text and as comma-separated values. */
#include "bench/bench.h"

#include <math.h>

static const char *const stages[BENCH_STAGES] = {"history", "carried", "split",
                                                 "gathered", "resolved"};
static const char *const frames[BENCH_START_FRAMES] = {"first", "second",
                                                       "third"};

static const bench_size *base_of(const bench_scaling *s) {
  return &s->size[s->base];
}

static double mebibytes(size_t bytes) {
  return (double)bytes / 1048576.0;
}

static double memory_ratio(const bench_memory *memory) {
  return (double)memory->plan / (double)memory->planes;
}

/* --- text --- */

static void print_time(const bench_scaling *s, const bench_size *size,
                       FILE *out) {
  const bench_timing *t = &size->timing;
  fprintf(out, " %9.3f %9.3f %6.3f %8.2f %8.2f %8.3f %8.3f\n", t->total.median,
          t->pass[HBIL_PASS_GATHER].median, t->host.median,
          bench_size_cost(size, t->total.median),
          bench_size_cost(size, t->pass[HBIL_PASS_GATHER].median),
          bench_size_ratio(s, size, t->total_ratio),
          bench_size_ratio(s, size, t->pass_ratio[HBIL_PASS_GATHER]));
}

static void print_sizes(const bench_scaling *s, FILE *out) {
  const bench_size *base = base_of(s);
  fprintf(out,
          "\n%-13s %9s %9s %6s %17s %17s\n%-13s %9s %9s %6s %8s %8s   "
          "to %u x %u\n",
          "pixels", "frame", "gather", "host", "frame   gather",
          "frame   gather", "", "ms", "ms", "ms", "ns/pixel", "ns/pixel",
          base->width, base->height);
  for (size_t i = 0; i < BENCH_SIZES; i++) {
    const bench_size *size = &s->size[i];
    fprintf(out, "%5u x %-5u", size->width, size->height);
    if (size->skipped[0])
      fprintf(out, " %s\n", size->skipped);
    else
      print_time(s, size, out);
  }
}

static void print_samplings(const bench_scaling *s, FILE *out) {
  const bench_size *base = base_of(s);
  fprintf(out, "\n%-13s %9s %9s   %u x %u pixels\n%-13s %9s %9s %6s\n",
          "slices x", "gather", "a sample", base->width, base->height,
          "samples", "ms", "ms", "to the first");
  for (size_t i = 0; i < BENCH_SAMPLINGS; i++) {
    const bench_sampling *sampling = &s->sampling[i];
    const double gather = sampling->timing.pass[HBIL_PASS_GATHER].median;
    fprintf(out, "%5u x %-5u %9.3f %9.4f %6.3f\n", 2u,
            (unsigned)sampling->samples, gather, gather / sampling->samples,
            bench_sampling_ratio(s, sampling));
  }
}

static void print_threads(const bench_scaling *s, FILE *out) {
  const bench_threads *t = &s->threads;
  fprintf(out, "\nthreads       ");
  if (t->left_out[0]) {
    fprintf(out, "%s\n", t->left_out);
    return;
  }
  fprintf(out, "%9s %9s   medians, %u process%s each, in turns\n", "frame ms",
          "gather ms", s->rounds, s->rounds == 1 ? "" : "es");
  for (int i = 0; i < 2; i++)
    fprintf(out, "%5u         %9.3f %9.3f\n", i ? t->count : 1u,
            t->total[i].median, t->gather[i].median);
  fprintf(out, "times faster  %9.3f %9.3f\n", t->total_gain, t->gather_gain);
}

static void print_opening(const bench_scaling *s, FILE *out) {
  const bench_opening *o = &s->opening;
  fprintf(out, "\nnew process, kernels in the cache: ");
  if (o->left_out[0]) {
    fprintf(out, "%s\n", o->left_out);
    return;
  }
  fprintf(out, "plan %.1f ms", o->plan.median);
  for (int i = 0; i < BENCH_START_FRAMES; i++)
    fprintf(out, ", %s frame %.1f", frames[i], o->frame[i].median);
  fprintf(out, "; first less second %.1f (%.1f .. %.1f)\n", o->extra.median,
          o->extra.low, o->extra.high);
}

static void print_memory(const bench_scaling *s, FILE *out) {
  fprintf(out, "\n%-13s %9s %9s\n%-13s %9s %9s %6s\n", "memory", "plan",
          "planes", "pixels", "MiB", "MiB", "ratio");
  for (size_t i = 0; i < BENCH_SIZES; i++) {
    const bench_size *size = &s->size[i];
    if (size->memory.plan)
      fprintf(out, "%5u x %-5u %9.1f %9.1f %6.3f\n", size->width, size->height,
              mebibytes(size->memory.plan), mebibytes(size->memory.planes),
              memory_ratio(&size->memory));
  }
  fputs("planes: words of 32 bits a pixel, without padding and tables:", out);
  for (int i = 0; i < BENCH_STAGES; i++)
    fprintf(out, " %s %zu%s,", stages[i], s->planes.values[i],
            i == HBIL_STAGE_CARRIED ? " in all its halved levels" : "");
  fprintf(out, " reprojection's targets %zu\n", s->planes.scatter);
}

void bench_write_scaling_table(const bench_report *report, FILE *out) {
  const bench_scaling *s = report->scaling;
  bench_print_machine(&report->machine, out);
  fprintf(out,
          "scaling  procedural room, %s; medians of %u runs after %d of "
          "warm-up, each in turns with what it is compared to\n",
          s->label, s->runs, BENCH_WARM_UP);
  print_sizes(s, out);
  print_samplings(s, out);
  print_threads(s, out);
  print_opening(s, out);
  print_memory(s, out);
  fputc('\n', out);
}

/* --- comma-separated values --- */

/* One row; what it has no value for is NAN or 0. */
typedef struct csv_row {
  const char *part;
  const bench_size *size;
  cl_uint samples;
  unsigned threads;
  bench_spread frame, gather;
  double host, frame_cost, gather_cost, frame_ratio, gather_ratio;
  const bench_memory *memory;
  const char *note;
} csv_row;

static const bench_spread nothing = {NAN, NAN, NAN};

static csv_row row_of(const bench_scaling *s, const char *part) {
  return (csv_row){.part = part,
                   .size = base_of(s),
                   .samples = s->sampling[0].samples,
                   .frame = nothing,
                   .gather = nothing,
                   .host = NAN,
                   .frame_cost = NAN,
                   .gather_cost = NAN,
                   .frame_ratio = NAN,
                   .gather_ratio = NAN,
                   .note = ""};
}

static void write_where(const bench_report *report, FILE *out) {
  bench_write_machine(out, &report->machine);
  fprintf(out, ",%u\n", report->scaling->runs);
}

static void write_row(const bench_report *report, const csv_row *row,
                      FILE *out) {
  fprintf(out, "%s,%u,%u,2,%u,%u", row->part, row->size->width,
          row->size->height, (unsigned)row->samples,
          row->threads ? row->threads : (unsigned)report->machine.units);
  bench_write_spread(out, row->frame);
  bench_write_spread(out, row->gather);
  bench_write_number(out, row->host);
  bench_write_number(out, row->frame_cost);
  bench_write_number(out, row->gather_cost);
  bench_write_number(out, row->frame_ratio);
  bench_write_number(out, row->gather_ratio);
  if (row->memory)
    fprintf(out, ",%zu,%zu,", row->memory->plan, row->memory->planes);
  else
    fputs(",,,", out);
  bench_write_quoted(out, row->note);
  write_where(report, out);
}

static void write_sizes(const bench_report *report, FILE *out) {
  const bench_scaling *s = report->scaling;
  for (size_t i = 0; i < BENCH_SIZES; i++) {
    const bench_size *size = &s->size[i];
    csv_row row = row_of(s, "size");
    row.size = size;
    row.memory = &size->memory;
    row.note = size->skipped;
    if (!size->skipped[0]) {
      row.frame = size->timing.total;
      row.gather = size->timing.pass[HBIL_PASS_GATHER];
      row.host = size->timing.host.median;
      row.frame_cost = bench_size_cost(size, row.frame.median);
      row.gather_cost = bench_size_cost(size, row.gather.median);
      row.frame_ratio = bench_size_ratio(s, size, size->timing.total_ratio);
      row.gather_ratio =
          bench_size_ratio(s, size, size->timing.pass_ratio[HBIL_PASS_GATHER]);
    }
    write_row(report, &row, out);
  }
}

static void write_samplings(const bench_report *report, FILE *out) {
  const bench_scaling *s = report->scaling;
  for (size_t i = 0; i < BENCH_SAMPLINGS; i++) {
    const bench_sampling *sampling = &s->sampling[i];
    csv_row row = row_of(s, "samples");
    row.samples = sampling->samples;
    row.frame = sampling->timing.total;
    row.gather = sampling->timing.pass[HBIL_PASS_GATHER];
    row.host = sampling->timing.host.median;
    row.gather_ratio = bench_sampling_ratio(s, sampling);
    write_row(report, &row, out);
  }
}

static void write_threads(const bench_report *report, FILE *out) {
  const bench_threads *t = &report->scaling->threads;
  for (int i = 0; i < 2; i++) {
    csv_row row = row_of(report->scaling, "threads");
    row.note = t->left_out;
    if (!t->left_out[0]) {
      row.threads = i ? t->count : 1;
      row.frame = t->total[i];
      row.gather = t->gather[i];
      row.frame_ratio = i ? t->total_gain : 1.0;
      row.gather_ratio = i ? t->gather_gain : 1.0;
    }
    write_row(report, &row, out);
  }
}

static void write_opening(const bench_report *report, FILE *out) {
  const bench_opening *o = &report->scaling->opening;
  const bench_spread parts[] = {o->plan, o->frame[0], o->frame[1], o->frame[2],
                                o->extra};
  static const char *const names[] = {"start plan", "start first",
                                      "start second", "start third",
                                      "start first less second"};
  for (int i = 0; i < 5; i++) {
    csv_row row = row_of(report->scaling, names[i]);
    row.note = o->left_out;
    if (!o->left_out[0])
      row.frame = parts[i];
    write_row(report, &row, out);
  }
}

void bench_write_scaling_csv(const bench_report *report, FILE *out) {
  fputs("part,width,height,slices,samples,threads,frame_ms,frame_min_ms,"
        "frame_max_ms,gather_ms,gather_min_ms,gather_max_ms,host_ms,"
        "frame_ns_per_pixel,gather_ns_per_pixel,frame_ratio,gather_ratio,"
        "plan_bytes,plane_bytes,note,device,compute_units,driver,version,"
        "runs\n",
        out);
  write_sizes(report, out);
  write_samplings(report, out);
  write_threads(report, out);
  write_opening(report, out);
}
