/* The temporal filter: what it takes off the sampling error of a sequence's
 * last frame, held still and arrived at in motion, and what it costs. */
#include "bench/bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Frames in the mean, one after the other. */
static const unsigned lengths[BENCH_TEMPORAL_LENGTHS] = {1, 2, 4, 8, 16};

enum { WANTED = 1u << LAYER_AO | 1u << LAYER_NEAR };

typedef struct job {
  const bench_options *options;
  const device *device;
  const bench_content *content; /* the last frame */
  channel_map map;
  camera_file camera; /* of the last frame, as the map */
  const bench_exact *exact;
  bench_model model;
  hbil_config config; /* the model's, without the filter */
  image result;
} job;

/* --- frames --- */

typedef struct captured {
  gbuffer g;
  camera_file camera;
} captured;

static const char *last_path(const bench_options *options) {
  return options->frames[options->frame_count - 1];
}

static int read_frame(const job *j, unsigned at, captured *out,
                      image_error *error) {
  enum {
    USED = 1u << ROLE_DEPTH | 1u << ROLE_NORMAL | 1u << ROLE_ALBEDO |
           1u << ROLE_DIRECT | 1u << ROLE_EMISSION | 1u << ROLE_BACKGROUND |
           1u << ROLE_MOTION
  };
  const char *path = j->options->frames[at];
  channel_map map;
  const int failed =
      bench_read_map(path, j->options->camera, &map, &out->camera, error) !=
          0 ||
      view_same_projection(path, &out->camera, last_path(j->options),
                           &j->camera, error) != 0 ||
      gbuffer_read(path, &map, USED, &out->g, error) != 0;
  const image *planes = &out->g.planes;
  channels_free(&map);
  if (failed || (planes->width == j->content->width &&
                 planes->height == j->content->height))
    return failed ? -1 : 0;
  image_fail(error,
             "%s: %u x %u pixels, but the last frame has %u x %u; frames of "
             "one size are needed",
             path, planes->width, planes->height, j->content->width,
             j->content->height);
  gbuffer_free(&out->g);
  return -1;
}

static int open_sequence(const job *j, unsigned length,
                         hbil_reprojection reprojection, sequence **out,
                         image_error *error) {
  hbil_config config = j->config;
  config.max_history_frames = length;
  config.reprojection = reprojection;
  return sequence_open(j->device, &config, 1, &j->map, WANTED, out, error);
}

static int run(job *j, sequence *s, const captured *frame, timing_row *row,
               image_error *error) {
  float environment[9][3];
  memcpy(environment, bench_environment(j->content, j->config.far_field),
         sizeof environment);
  return sequence_run(s, &frame->g, sequence_hash(s, &frame->g), &frame->camera,
                      environment, 1, &j->result, row, error);
}

/* Of the result; one bounce. */
static bench_deviation deviation_of(const job *j) {
  /* the planes of a layer lie one after the other in what is compared */
  const size_t pixels = bench_pixels(j->content);
  bench_deviation out = {NAN, NAN};
  float *light = malloc(3 * pixels * sizeof *light);
  out.ao = bench_ao_error(j->content, layers_plane(&j->result, LAYER_AO, 0),
                          j->exact->ao[j->model]);
  for (size_t c = 0; light && c < 3; c++)
    memcpy(light + c * pixels, layers_plane(&j->result, LAYER_NEAR, c),
           pixels * sizeof *light);
  if (light)
    out.light = bench_light_error(j->content, light, j->exact->light[j->model]);
  free(light);
  return out;
}

/* --- the last frame, again and again --- */

/* What the filter and the whole frame take, in the frames that look back. */
static void sum_up(double *pass, double *total, unsigned count,
                   bench_temporal *out) {
  double share[BENCH_TEMPORAL_MOST];
  for (unsigned i = 0; i < count; i++)
    share[i] = pass[i] / total[i];
  out->share = bench_spread_of(share, count).median;
  out->pass = bench_spread_of(pass, count);
}

static int hold_still(job *j, const captured *last, bench_temporal *out,
                      image_error *error) {
  const unsigned most = lengths[BENCH_TEMPORAL_LENGTHS - 1];
  double pass[BENCH_TEMPORAL_MOST], total[BENCH_TEMPORAL_MOST];
  sequence *s = NULL;
  int failed = open_sequence(j, most, HBIL_REPROJECTION_NONE, &s, error);
  for (unsigned n = 1, at = 0; n <= most && !failed; n++) {
    timing_row row;
    failed = run(j, s, last, &row, error);
    if (failed)
      break;
    total[n - 1] = 0.0;
    for (int p = 0; p < HBIL_PASS_COUNT; p++)
      total[n - 1] += row.milliseconds[p];
    pass[n - 1] = row.milliseconds[HBIL_PASS_TEMPORAL];
    if (n == lengths[at])
      out->still[at++] = deviation_of(j);
  }
  if (!failed)
    sum_up(pass + 1, total + 1, most - 1, out);
  sequence_close(s);
  return failed;
}

/* --- the whole sequence --- */

static int move(job *j, unsigned length, hbil_reprojection reprojection,
                bench_deviation *out, image_error *error) {
  sequence *s = NULL;
  int failed = open_sequence(j, length, reprojection, &s, error);
  for (unsigned i = 0; i < j->options->frame_count && !failed; i++) {
    captured frame;
    timing_row row;
    failed = read_frame(j, i, &frame, error);
    if (failed)
      break;
    failed = run(j, s, &frame, &row, error);
    gbuffer_free(&frame.g);
  }
  if (!failed)
    *out = deviation_of(j);
  sequence_close(s);
  return failed;
}

/* Light is carried over with motion vectors, more than the one bounce of the
 * reference: of AO alone. */
static int move_both_ways(job *j, unsigned at, bench_temporal *out,
                          image_error *error) {
  out->followed[at].ao = out->followed[at].light = NAN;
  if (move(j, lengths[at], HBIL_REPROJECTION_NONE, &out->moving[at], error) !=
      0)
    return -1;
  if (j->map.count[ROLE_MOTION] < 2)
    return 0;
  const int failed =
      move(j, lengths[at], HBIL_REPROJECTION_MOTION, &out->followed[at], error);
  out->followed[at].light = NAN;
  return failed;
}

static int measure_model(job *j, const bench_configuration *c,
                         bench_temporal *out, image_error *error) {
  captured last;
  j->model = c->model;
  bench_configure(j->content, c, &j->config);
  bench_label(c, out->label, sizeof out->label);
  if (read_frame(j, j->options->frame_count - 1, &last, error) != 0)
    return -1;
  int failed = hold_still(j, &last, out, error);
  gbuffer_free(&last.g);
  for (unsigned at = 0; at < BENCH_TEMPORAL_LENGTHS && !failed; at++)
    failed = move_both_ways(j, at, out, error);
  return failed;
}

/* --- all --- */

/* The library's default, and what hbil process does by itself. */
static void choose(bench_configuration list[BENCH_TEMPORALS]) {
  process_options tool;
  process_options_init(&tool);
  list[0] = list[1] = bench_default();
  list[1].model = BENCH_TOOL;
  list[1].samples = tool.config.steps_per_side;
}

/* The last frame's: all have the same channels. */
static int read_last(job *j, image_error *error) {
  const char *path = last_path(j->options);
  if (bench_read_map(path, j->options->camera, &j->map, &j->camera, error) != 0)
    return -1;
  return j->map.count[ROLE_DIRECT]
             ? 0
             : image_fail(error, "%s: has no direct light, which is needed",
                          path);
}

int bench_temporal_measure(const bench_options *options, const device *d,
                           const bench_content *content, int slices,
                           bench_temporal *out, image_error *error) {
  bench_configuration list[BENCH_TEMPORALS];
  bench_exact exact = {.slices = 0};
  job j = {
      .options = options, .device = d, .content = content, .exact = &exact};
  choose(list);
  if (read_last(&j, error) != 0)
    return -1;
  int failed =
      layers_image(WANTED, content->width, content->height, &j.result) != 0
          ? image_no_memory(error, content->name)
          : bench_exact_make(content, slices, list, BENCH_TEMPORALS, &exact,
                             error);
  for (int i = 0; i < BENCH_TEMPORALS && !failed; i++)
    failed = measure_model(&j, &list[i], &out[i], error);
  bench_exact_free(&exact);
  image_free(&j.result);
  channels_free(&j.map);
  return failed ? -1 : 0;
}

/* --- text --- */

static void print_number(FILE *out, double value) {
  if (isnan(value))
    fprintf(out, " %8s", "-");
  else
    fprintf(out, " %8.4f", value);
}

void bench_write_temporal_table(const bench_report *report, FILE *out) {
  bench_print_machine(&report->machine, out);
  fprintf(out, "content  %s, %u x %u pixels\n", report->content->name,
          report->content->width, report->content->height);
  for (int i = 0; i < BENCH_TEMPORALS; i++) {
    const bench_temporal *t = &report->temporal[i];
    fprintf(out, "\n%-24s %8s %8s %8s %8s %8s\n", t->label, "still", "",
            "moving", "", "motion");
    fprintf(out, "%-24s %8s %8s %8s %8s %8s\n", "frames", "AO", "E_near", "AO",
            "E_near", "AO");
    for (int n = 0; n < BENCH_TEMPORAL_LENGTHS; n++) {
      fprintf(out, "%-24u", lengths[n]);
      print_number(out, t->still[n].ao);
      print_number(out, t->still[n].light);
      print_number(out, t->moving[n].ao);
      print_number(out, t->moving[n].light);
      print_number(out, t->followed[n].ao);
      fputc('\n', out);
    }
    fprintf(out, "the filter takes %.3f ms, %.1f %% of a frame\n",
            t->pass.median, 100.0 * t->share);
  }
  fputs("RMSE against the exact integral in the last frame, of E_near over its "
        "mean; still:\nthat frame over and over; moving: the whole sequence, "
        "looked up by the cameras;\nmotion: by motion vectors\n",
        out);
}

static void write_deviations(FILE *out, const char *name,
                             const bench_deviation *list) {
  fprintf(out, "      \"%s\": [", name);
  for (int n = 0; n < BENCH_TEMPORAL_LENGTHS; n++) {
    fprintf(out, "%s{\"frames\": %u, \"ao\": %.6g", n ? ", " : "", lengths[n],
            list[n].ao);
    if (!isnan(list[n].light))
      fprintf(out, ", \"light\": %.6g", list[n].light);
    fputc('}', out);
  }
  fputs("],\n", out);
}

void bench_write_temporal_json(const bench_report *report, FILE *out) {
  fputs("{\n  \"device\": ", out);
  bench_write_quoted(out, report->machine.device);
  fputs(",\n  \"content\": ", out);
  bench_write_quoted(out, report->content->name);
  fprintf(out, ",\n  \"width\": %u,\n  \"height\": %u,\n  \"settings\": [",
          report->content->width, report->content->height);
  for (int i = 0; i < BENCH_TEMPORALS; i++) {
    const bench_temporal *t = &report->temporal[i];
    fprintf(out, "%s\n    {\n      \"label\": ", i ? "," : "");
    bench_write_quoted(out, t->label);
    fputs(",\n", out);
    write_deviations(out, "still", t->still);
    write_deviations(out, "moving", t->moving);
    if (!isnan(t->followed[0].ao))
      write_deviations(out, "motion", t->followed);
    fprintf(out, "      \"milliseconds\": %.6g,\n      \"share\": %.6g\n    }",
            t->pass.median, t->share);
  }
  fputs("\n  ]\n}\n", out);
}
