/* Work that is left out: what a frame costs where there is less to do, beside
 * the whole one, in turns. */
#include "bench/bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Light has settled to the last bit by then (23 frames in the room). */
enum { SETTLED = 80 };

typedef struct job {
  const bench_options *options;
  const device *device;
  const bench_content *content;
  bench_lab *lab; /* of the content as it is */
  bench_skip *out;
} job;

/* --- contents with less in them --- */

static int copy_planes(const bench_content *from, bench_content *out,
                       image_error *error) {
  const size_t plane = bench_pixels(from) * sizeof(float);
  *out = *from;
  out->truth = NULL;
  out->compared = NULL;
  for (unsigned f = 0; f < BENCH_FRAMES; f++) {
    out->frame[f].motion = NULL;
    for (int i = 0; i < BENCH_INPUTS; i++)
      out->frame[f].plane[i] = NULL;
  }
  for (unsigned f = 0; f < from->frames; f++)
    for (int i = 0; i < BENCH_INPUTS; i++) {
      const size_t bytes = plane * bench_input_channels((bench_input)i);
      if (!from->frame[f].plane[i])
        continue;
      out->frame[f].plane[i] = malloc(bytes);
      if (!out->frame[f].plane[i])
        return image_no_memory(error, from->name);
      memcpy(out->frame[f].plane[i], from->frame[f].plane[i], bytes);
    }
  return 0;
}

static void upper_half_is_sky(bench_content *c) {
  for (unsigned f = 0; f < c->frames; f++)
    memset(c->frame[f].plane[BENCH_DEPTH], 0,
           (size_t)c->height / 2 * c->width * sizeof(float));
}

/* Seen straight on. */
static void one_wall(bench_content *c) {
  const size_t pixels = bench_pixels(c);
  c->config.depth_kind = HBIL_DEPTH_PLANAR;
  c->config.normal_space = HBIL_SPACE_VIEW;
  for (unsigned f = 0; f < c->frames; f++)
    for (size_t i = 0; i < pixels; i++) {
      float *normal = c->frame[f].plane[BENCH_NORMAL];
      c->frame[f].plane[BENCH_DEPTH][i] = 2.0f;
      normal[i] = normal[pixels + i] = 0.0f;
      normal[2 * pixels + i] = -1.0f;
    }
}

/* A quarter of the width and of the height. */
static void light_in_a_corner(bench_content *c) {
  const size_t pixels = bench_pixels(c);
  for (unsigned f = 0; f < c->frames; f++)
    for (int p = BENCH_DIRECT; p <= BENCH_EMISSION; p++)
      for (size_t i = 0; c->frame[f].plane[p] && i < 3 * pixels; i++)
        if (i % pixels % c->width >= c->width / 4 ||
            i % pixels / c->width >= c->height / 4)
          c->frame[f].plane[p][i] = 0.0f;
}

/* --- cases --- */

/* The library's default on the content. */
static bench_turn full_turn(const job *j) {
  const bench_configuration standard = bench_default();
  bench_turn turn = {.lab = j->lab};
  bench_configure(j->content, &standard, &turn.config);
  return turn;
}

static int compare_runs(bench_turn full, bench_turn less, unsigned runs,
                        bench_skip *out, image_error *error) {
  const bench_turn turns[2] = {full, less};
  bench_timing timing[2];
  if (bench_lab_turns(turns, 2, runs, timing, error) != 0)
    return -1;
  out->full = timing[0];
  out->timing = timing[1];
  return 0;
}

static int compare(const job *j, bench_turn full, bench_turn less,
                   bench_skip *out, image_error *error) {
  return compare_runs(full, less, j->options->runs, out, error);
}

/* Where buffers and machine code come to lie is worth as much as what is
 * measured here: of several pairs of plans, either one first, the median. */
static int with_nothing_to_skip(const job *j, bench_skip *out,
                                image_error *error) {
  enum { PAIRS = 8 };
  double total[PAIRS], gather[PAIRS];
  bench_turn full = full_turn(j);
  full.config.skip = 0;
  for (int i = 0; i < PAIRS; i++) {
    const int swapped = i % 2;
    if (compare(j, swapped ? full_turn(j) : full, swapped ? full : full_turn(j),
                out, error) != 0)
      return -1;
    const double *pass = out->timing.pass_ratio;
    total[i] = out->timing.total_ratio;
    gather[i] = pass[HBIL_PASS_GATHER];
    if (swapped) {
      const bench_timing first = out->full;
      total[i] = 1.0 / total[i];
      gather[i] = 1.0 / gather[i];
      out->full = out->timing;
      out->timing = first;
    }
  }
  out->timing.total_ratio = bench_spread_of(total, PAIRS).median;
  out->timing.pass_ratio[HBIL_PASS_GATHER] =
      bench_spread_of(gather, PAIRS).median;
  return 0;
}

/* `change`d content beside the content as it is; bounces: whether light is
 * carried over. */
static int with_content(const job *j, void (*change)(bench_content *),
                        int bounces, bench_skip *out, image_error *error) {
  bench_content content;
  bench_lab *lab = NULL;
  int failed = copy_planes(j->content, &content, error);
  if (!failed)
    change(&content);
  failed = failed || bench_lab_open(j->device, &content, &lab, error) != 0;
  bench_turn full = full_turn(j), less = full;
  less.lab = lab;
  less.config.depth_kind = content.config.depth_kind;
  less.config.normal_space = content.config.normal_space;
  if (!bounces)
    full.config.reprojection = less.config.reprojection =
        HBIL_REPROJECTION_NONE;
  if (!failed)
    failed = compare(j, full, less, out, error);
  bench_lab_close(lab);
  bench_content_free(&content);
  return failed ? -1 : 0;
}

static int with_half_sky(const job *j, bench_skip *out, image_error *error) {
  return with_content(j, upper_half_is_sky, 1, out, error);
}

static int with_one_wall(const job *j, bench_skip *out, image_error *error) {
  return with_content(j, one_wall, 1, out, error);
}

/* A single bounce: with more of them light is everywhere. */
static int with_a_lit_corner(const job *j, bench_skip *out,
                             image_error *error) {
  return with_content(j, light_in_a_corner, 0, out, error);
}

static int standing_still(const job *j, unsigned settled,
                          size_t horizon_cache_bytes, bench_skip *out,
                          image_error *error) {
  bench_turn still = full_turn(j);
  still.still = 1;
  still.settled = settled;
  still.config.horizon_cache_bytes = horizon_cache_bytes;
  return compare(j, full_turn(j), still, out, error);
}

static int while_light_spreads(const job *j, bench_skip *out,
                               image_error *error) {
  return standing_still(j, 0, 0, out, error);
}

static int with_form_factors(const job *j, bench_skip *out,
                             image_error *error) {
  return standing_still(j, 0, SIZE_MAX, out, error);
}

static int once_light_has_settled(const job *j, bench_skip *out,
                                  image_error *error) {
  if (standing_still(j, SETTLED, 0, out, error) != 0)
    return -1;
  if (!out->timing.skipped.not_run[HBIL_PASS_GATHER])
    out->name = "still, light unsettled";
  return 0;
}

/* A second of standing still, at 60 frames a second: light spreads at first,
 * then nothing is new.  All of these frames together. */
static int for_a_second(const job *j, bench_skip *out, image_error *error) {
  bench_turn still = full_turn(j);
  still.still = 1;
  if (compare_runs(full_turn(j), still, 60, out, error) != 0)
    return -1;
  out->timing.total_ratio = out->timing.mean / out->full.mean;
  out->timing.total.median = out->timing.mean;
  out->timing.pass_ratio[HBIL_PASS_GATHER] = NAN;
  return 0;
}

static int with_ao_alone(const job *j, bench_skip *out, image_error *error) {
  bench_turn ao = full_turn(j);
  ao.config.mode = HBIL_MODE_GTAO;
  ao.config.far_field = HBIL_FAR_NONE;
  return compare(j, full_turn(j), ao, out, error);
}

int bench_skips_measure(const bench_options *options, const device *d,
                        const bench_content *content, bench_skip *out,
                        image_error *error) {
  static const struct {
    const char *name;
    double frame_aim, gather_aim;
    int (*measure)(const job *, bench_skip *, image_error *);
  } cases[BENCH_SKIPS] = {
      {"as it is", 1.03, NAN, with_nothing_to_skip},
      {"upper half sky", NAN, 0.55, with_half_sky},
      {"a wall seen straight on", NAN, 0.15, with_one_wall},
      {"lit in a corner", NAN, 0.8, with_a_lit_corner},
      {"still, light spreading", 0.65, NAN, while_light_spreads},
      {"the same, form factors", 0.65, NAN, with_form_factors},
      {"still, light settled", 0.65, NAN, once_light_has_settled},
      {"still for a second", 0.65, NAN, for_a_second},
      {"AO alone", 0.6, NAN, with_ao_alone},
  };
  job j = {.options = options, .device = d, .content = content, .out = out};
  int failed = bench_lab_open(d, content, &j.lab, error);
  for (size_t i = 0; i < BENCH_SKIPS && !failed; i++) {
    progress_count("skips", i, BENCH_SKIPS);
    out[i] = (bench_skip){.name = cases[i].name,
                          .frame_aim = cases[i].frame_aim,
                          .gather_aim = cases[i].gather_aim};
    failed = cases[i].measure(&j, &out[i], error);
  }
  progress_count("skips", BENCH_SKIPS, BENCH_SKIPS);
  bench_lab_close(j.lab);
  return failed ? -1 : 0;
}

/* --- text --- */

/* Frames that differ have no median that says anything. */
static void print_time(FILE *out, double milliseconds, double ratio) {
  if (isnan(ratio))
    fprintf(out, " %9s", "-");
  else
    fprintf(out, " %9.3f", milliseconds);
}

static void print_ratio(FILE *out, double ratio, double aim) {
  if (isnan(ratio))
    fprintf(out, " %6s", "-");
  else
    fprintf(out, " %6.3f", ratio);
  if (isnan(aim))
    fputs("       ", out);
  else
    fprintf(out, " <=%-4.3g", aim);
}

void bench_write_skips_table(const bench_report *report, FILE *out) {
  bench_print_machine(&report->machine, out);
  fprintf(out, "content  %s, %u x %u pixels\n\n%-24s %9s %14s %9s %14s  %s\n",
          report->content->name, report->content->width,
          report->content->height, "skips, 2x8 full g2", "frame ms", "/whole",
          "gather ms", "/whole", "left out");
  for (int i = 0; i < BENCH_SKIPS; i++) {
    const bench_skip *s = &report->skips[i];
    fprintf(out, "%-24s %9.3f", s->name, s->timing.total.median);
    print_ratio(out, s->timing.total_ratio, s->frame_aim);
    const double gather = s->timing.pass_ratio[HBIL_PASS_GATHER];
    print_time(out, s->timing.pass[HBIL_PASS_GATHER].median, gather);
    print_ratio(out, gather, s->gather_aim);
    fputs("  ", out);
    timings_print_skipped(&s->timing.skipped, out);
    fputc('\n', out);
  }
  fprintf(
      out,
      "whole: the content with everything there is to do; the first row's, "
      "without looking for what can be left out, of eight pairs of plans; a "
      "second: means of 60 frames; unsettled: light still spread after %d\n",
      SETTLED);
}
