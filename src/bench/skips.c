/* hbil-bench skips: what a frame costs that has less to do. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/report.h"
#include "bench/settings.h"

enum {
  /* Static frames before one that is timed as a late one. */
  SETTLE = 80,
  SECOND = 60 /* frames */
};

typedef struct job {
  const bench_options *options;
  const bench_device *device;
  bench_content content;
  bench_fixture *fixture; /* of the content as it is */
  bench_report *report;
} job;

static const bench_column columns[] = {
    {"name", "frame", BENCH_TEXT},
    {"total_ms", "frame, ms", 3},
    {"total_ratio", "of the whole frame", 3},
    {"gather_ms", "gather, ms", 3},
    {"gather_ratio", "of the whole gather", 3},
    {"left_out", "left out", BENCH_TEXT}};

/* --- the report --- */

/* "sky 50 % of pixels, no reproject", "" where nothing was left out. */
static void describe(const hbil_statistics *s, char *text, size_t size) {
  const struct {
    const char *name;
    size_t pixels;
  } shares[] = {{"sky", s->sky.pixels},
                {"open", s->open.pixels},
                {"dark", s->dark.pixels},
                {"unused", s->unused.pixels}};
  size_t used = 0;
  *text = '\0';
  for (size_t i = 0; i < sizeof shares / sizeof *shares; i++)
    if (shares[i].pixels && used < size)
      used += (size_t)snprintf(
          text + used, size - used, "%s%s %.1f %% of pixels", used ? ", " : "",
          shares[i].name,
          100.0 * (double)shares[i].pixels / (double)s->all.pixels);
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    if (s->not_run[p] && used < size)
      used += (size_t)snprintf(text + used, size - used, "%sno %s",
                               used ? ", " : "", hbil_pass_name((hbil_pass)p));
}

static void report_row(const job *j, const char *name, double milliseconds,
                       double total_ratio, double gather_ratio,
                       const bench_timing *t) {
  char left_out[256];
  describe(&t->statistics, left_out, sizeof left_out);
  bench_report_row(j->report);
  bench_report_text(j->report, name);
  bench_report_number(j->report, milliseconds);
  bench_report_number(j->report, total_ratio);
  bench_report_number(
      j->report, isnan(gather_ratio) ? NAN : t->pass[HBIL_PASS_GATHER].median);
  bench_report_number(j->report, gather_ratio);
  bench_report_text(j->report, left_out);
}

/* --- frames --- */

/* The default setting on the content as it is. */
static bench_turn whole_frame(const job *j) {
  const bench_setting standard = bench_setting_default(&j->content);
  bench_turn turn = {.fixture = j->fixture};
  bench_setting_apply(&standard, &j->content, &turn.config);
  return turn;
}

static int compare(const job *j, const char *name, bench_turn whole,
                   bench_turn less, image_error *error) {
  const bench_turn turns[2] = {whole, less};
  bench_timing timing[2];
  if (bench_time_turns(turns, 2, j->options->runs, timing, error) != 0)
    return -1;
  report_row(j, name, timing[1].total.median, timing[1].total_ratio,
             timing[1].pass_ratio[HBIL_PASS_GATHER], &timing[1]);
  return 0;
}

/* What it costs to look for work to skip where there is none.  Positions of
 * buffers in memory matter as much as that, so two pairs of plans are
 * averaged. */
static int nothing_to_skip(const job *j, image_error *error) {
  const bench_turn whole = whole_frame(j);
  bench_turn turns[4] = {whole, whole, whole, whole};
  bench_timing t[4];
  turns[0].config.execution.skip = turns[2].config.execution.skip = 0;
  if (bench_time_turns(turns, 4, j->options->runs, t, error) != 0)
    return -1;
  const int gather = HBIL_PASS_GATHER;
  report_row(j, "as it is, beside one without skips", t[1].total.median,
             0.5 * (t[1].total_ratio + t[3].total_ratio / t[2].total_ratio),
             0.5 * (t[1].pass_ratio[gather] +
                    t[3].pass_ratio[gather] / t[2].pass_ratio[gather]),
             &t[1]);
  return 0;
}

static int static_frames(const job *j, const char *name, unsigned settle,
                         image_error *error) {
  bench_turn less = whole_frame(j);
  less.play = BENCH_PLAY_STATIC;
  less.settle = settle;
  return compare(j, name, whole_frame(j), less, error);
}

/* Light spreads at first, and may stop changing then: the mean of a second's
 * frames, which have no common median. */
static int static_second(const job *j, image_error *error) {
  bench_turn turns[2] = {whole_frame(j), whole_frame(j)};
  bench_timing t[2];
  turns[1].play = BENCH_PLAY_STATIC;
  if (bench_time_turns(turns, 2, SECOND, t, error) != 0)
    return -1;
  report_row(j, "static for a second", t[1].mean, t[1].mean / t[0].mean, NAN,
             &t[1]);
  return 0;
}

static int ao_alone(const job *j, image_error *error) {
  bench_setting gtao = bench_setting_default(&j->content);
  bench_turn less = {.fixture = j->fixture};
  gtao.model = BENCH_MODEL_GTAO;
  bench_setting_apply(&gtao, &j->content, &less.config);
  return compare(j, "AO alone", whole_frame(j), less, error);
}

/* --- content with less in it --- */

static void upper_half_is_sky(bench_content *c, bench_frame *frame) {
  memset(frame->plane[BENCH_DEPTH], 0,
         (size_t)c->height / 2 * c->width * sizeof(float));
}

/* Seen straight on. */
static void one_wall(bench_content *c, bench_frame *frame) {
  const size_t pixels = bench_pixels(c);
  float *normal = frame->plane[BENCH_NORMAL];
  c->config.inputs.depth_kind = HBIL_DEPTH_PLANAR;
  c->config.inputs.normal_space = HBIL_SPACE_VIEW;
  for (int i = 0; i < 3; i++)
    c->config.inputs.normal_scale[i] = 1.0f;
  for (size_t i = 0; i < pixels; i++) {
    frame->plane[BENCH_DEPTH][i] = 2.0f;
    normal[i] = normal[pixels + i] = 0.0f;
    normal[2 * pixels + i] = -1.0f;
  }
}

/* A quarter of the width and of the height has light. */
static void light_in_a_corner(bench_content *c, bench_frame *frame) {
  const size_t pixels = bench_pixels(c);
  for (int p = BENCH_DIRECT; p <= BENCH_EMISSION; p++)
    for (size_t i = 0; frame->plane[p] && i < 3 * pixels; i++)
      if (i % pixels % c->width >= c->width / 4 ||
          i % pixels / c->width >= c->height / 4)
        frame->plane[p][i] = 0.0f;
}

/* one_bounce: without light that is carried over, which would reach all of the
 * picture. */
static int changed_content(const job *j, const char *name,
                           void (*change)(bench_content *, bench_frame *),
                           int one_bounce, image_error *error) {
  bench_content content;
  bench_turn whole = whole_frame(j), less = whole;
  less.fixture = NULL;
  int failed = bench_content_load(j->options, 2, 0, &content, error);
  for (unsigned f = 0; f < content.frames && !failed; f++)
    change(&content, &content.frame[f]);
  if (!failed)
    failed = bench_fixture_open(j->device, &content, &less.fixture, error);
  less.config.inputs.depth_kind = content.config.inputs.depth_kind;
  less.config.inputs.normal_space = content.config.inputs.normal_space;
  memcpy(less.config.inputs.normal_scale, content.config.inputs.normal_scale,
         sizeof less.config.inputs.normal_scale);
  if (one_bounce)
    whole.config.history.reprojection = less.config.history.reprojection =
        HBIL_REPROJECTION_NONE;
  if (!failed)
    failed = compare(j, name, whole, less, error);
  bench_fixture_close(less.fixture);
  bench_content_free(&content);
  return failed;
}

/* --- all --- */

static int measure(job *j, image_error *error) {
  return nothing_to_skip(j, error) != 0 ||
                 changed_content(j, "upper half is sky", upper_half_is_sky, 0,
                                 error) != 0 ||
                 changed_content(j, "a wall seen straight on", one_wall, 0,
                                 error) != 0 ||
                 changed_content(j, "light in a corner, one bounce",
                                 light_in_a_corner, 1, error) != 0 ||
                 static_frames(j, "static, light spreads", 0, error) != 0 ||
                 static_frames(j, "static, after 80 frames", SETTLE, error) !=
                     0 ||
                 static_second(j, error) != 0 || ao_alone(j, error) != 0
             ? -1
             : 0;
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.options = options, .device = device, .report = report};
  if (bench_content_load(options, 2, 0, &j.content, error) != 0)
    return -1;
  bench_report_subject(report, j.content.name, j.content.width,
                       j.content.height, options->runs);
  bench_report_table(report, "frames", "Frames with less to do", columns,
                     sizeof columns / sizeof *columns);
  int failed = bench_fixture_open(device, &j.content, &j.fixture, error);
  if (!failed)
    failed = measure(&j, error);
  bench_report_note(report,
                    "Each frame is timed in turns with the whole one, in which "
                    "all the work is done.  The row of a second has means of "
                    "%d frames.  The late static frame comes after %d others.  "
                    "Its gather is left out if light no longer changes then.",
                    (int)SECOND, (int)SETTLE);
  bench_fixture_close(j.fixture);
  bench_content_free(&j.content);
  return failed;
}

const bench_command bench_skips = {
    .name = "skips",
    .about = "what a frame costs that needs less, and what is left out",
    .details =
        "What does a frame cost that needs less: sky, open walls, darkness,\n"
        "nothing that moves, AO alone?  Each is timed in turns with a whole\n"
        "frame.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_TIMES |
               BENCH_TAKES_FRAMES,
    .runs = 9,
    .run = run};
