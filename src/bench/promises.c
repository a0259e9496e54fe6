/* Adaptive sampling over scenes: whether what it promises is kept in their
 * frames, and what it costs beside the fastest number of samples for all of
 * them that keeps as much. */
#define _POSIX_C_SOURCE 200809L
#include "bench/bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct job {
  const bench_options *options;
  const device *device;
  int slices; /* of the exact integral */
  bench_configuration list[BENCH_MAX_CONFIGURATIONS];
  size_t count;
  bench_promises *out;
} job;

/* --- what is measured --- */

/* Every limit, of a short list those of it, and whatever could be taken in the
 * place of what is chosen. */
static void choose(job *j) {
  bench_configuration all[BENCH_MAX_CONFIGURATIONS];
  const size_t count = bench_configurations(0, all);
  const bench_configuration *any = &all[count - 1];
  for (size_t i = 0; i < count; i++)
    if (bench_is_adaptive(&all[i]) ? all[i].quick || !j->options->quick
                                   : bench_is_uniform_of(&all[i], any))
      j->list[j->count++] = all[i];
}

/* Whose frames a path's are: its folder, or the room. */
static char *scene_name(const char *path) {
  const char *slash = path ? strrchr(path, '/') : NULL;
  if (!path)
    return strdup("procedural room");
  return slash ? strndup(path, (size_t)(slash - path)) : strdup(".");
}

/* Frames of one folder are a scene's, in the order in which they are given. */
static int add_frame(const char *path, bench_promises *p, image_error *error) {
  bench_case *frame = &p->frame[p->frame_count++];
  char *name = scene_name(path);
  if (!name)
    return image_no_memory(error, "scenes");
  frame->path = path;
  while (frame->scene < p->scene_count &&
         strcmp(p->scene[frame->scene].name, name) != 0)
    frame->scene++;
  bench_scene *scene = &p->scene[frame->scene];
  if (frame->scene == p->scene_count) {
    scene->name = name;
    p->scene_count++;
  } else
    free(name);
  frame->index = scene->frames++;
  return 0;
}

static int add_frames(const job *j, image_error *error) {
  bench_promises *p = j->out;
  const unsigned given = j->options->frame_count;
  const size_t count = given > 0 ? given : 1;
  p->scene = calloc(count, sizeof *p->scene);
  p->frame = calloc(count, sizeof *p->frame);
  p->rows = calloc(count * j->count, sizeof *p->rows);
  if (!p->scene || !p->frame || !p->rows)
    return image_no_memory(error, "frames");
  for (size_t f = 0; f < count; f++) {
    if (add_frame(given > 0 ? j->options->frames[f] : NULL, p, error) != 0)
      return -1;
    p->frame[f].rows = p->rows + f * j->count;
  }
  return 0;
}

static int measure_rows(const job *j, const bench_content *content,
                        bench_row *rows, image_error *error) {
  bench_exact exact = {.slices = 0};
  bench_lab *lab = NULL;
  int failed =
      bench_exact_make(content, j->slices, j->list, 1, &exact, error) != 0 ||
      bench_lab_open(j->device, content, &lab, error) != 0;
  for (size_t i = 0; i < j->count && !failed; i++) {
    progress_count(content->name, i, j->count);
    failed = bench_lab_errors(lab, &exact, &j->list[i], &rows[i], error) != 0 ||
             bench_lab_times(lab, &j->list[i], j->options->runs, &rows[i],
                             error) != 0;
  }
  progress_count(content->name, j->count, j->count);
  bench_lab_close(lab);
  bench_exact_free(&exact);
  return failed ? -1 : 0;
}

static int measure_frame(const job *j, bench_case *frame, image_error *error) {
  bench_options options = *j->options;
  bench_content content;
  options.dump = frame->path;
  if (bench_content_load(&options, &content, error) != 0)
    return -1;
  frame->pixels = (double)bench_pixels(&content);
  const int failed = measure_rows(j, &content, frame->rows, error);
  bench_content_free(&content);
  return failed;
}

/* --- what comes of it --- */

static double off_95(const bench_row *row, const bench_configuration *limit) {
  return limit->most_ao > 0.0f ? row->ao_95 : row->light_95;
}

static double most_of(const bench_configuration *limit) {
  return (double)(limit->most_ao > 0.0f ? limit->most_ao : limit->most_light);
}

static const double room_pixels = 1280.0 * 720.0;

static double cost(const bench_case *frame, double milliseconds) {
  return 1e6 * milliseconds / frame->pixels;
}

/* The frame whose choice one of its scene goes by. */
static const bench_case *chooser(const bench_case *frame, unsigned every) {
  const bench_case *at = frame;
  while (at->scene != frame->scene ||
         at->index != frame->index - frame->index % every)
    at--;
  return at;
}

/* The uniform setting of a frame that is what was chosen. */
static const bench_row *row_of(const job *j, const bench_case *frame,
                               const bench_row *chosen) {
  for (size_t i = 0; i < j->count; i++)
    if (!bench_is_adaptive(&j->list[i]) &&
        j->list[i].slices == chosen->slices &&
        j->list[i].samples == chosen->samples)
      return &frame->rows[i];
  return NULL;
}

static int more(const bench_row *a, cl_uint slices, cl_uint samples) {
  return a->slices * a->samples > slices * samples;
}

static void add_taken(const bench_row *row, const bench_configuration *limit,
                      bench_taken *out) {
  if (out->frames++ == 0 || !more(row, out->least[0], out->least[1])) {
    out->least[0] = row->slices;
    out->least[1] = row->samples;
  }
  if (more(row, out->most[0], out->most[1])) {
    out->most[0] = row->slices;
    out->most[1] = row->samples;
  }
  out->worst = fmax(out->worst, off_95(row, limit));
  out->beyond += off_95(row, limit) > most_of(limit);
}

/* Of limit i, where one of so many frames chooses. */
static int add_way(const job *j, size_t i, unsigned every, bench_way *out,
                   image_error *error) {
  const bench_promises *p = j->out;
  out->taken = calloc(p->scene_count, sizeof *out->taken);
  if (!out->taken)
    return image_no_memory(error, "scenes");
  for (size_t f = 0; f < p->frame_count; f++) {
    const bench_case *frame = &p->frame[f];
    const double share =
        1.0 / p->scene[frame->scene].frames / (double)p->scene_count;
    const bench_row *row = row_of(j, frame, &chooser(frame, every)->rows[i]);
    if (!row)
      return image_fail(error, "adaptive sampling chose what the bench has no "
                               "row of; one for each of its choices is needed");
    add_taken(row, &j->list[i], &out->taken[frame->scene]);
    out->gather += share * cost(frame, row->pass[HBIL_PASS_GATHER].median);
    for (int size = 0; size < BENCH_CASE_SIZES; size++)
      out->choosing[size] +=
          share * 1e6 * frame->rows[i].choosing /
          (size == BENCH_OWN_SIZE ? frame->pixels : room_pixels) / every;
  }
  for (size_t s = 0; s < p->scene_count; s++)
    out->beyond += out->taken[s].beyond;
  return 0;
}

/* A setting's mean over the scenes; NAN where it isn't within the limit in each
 * frame. */
static double uniform_cost(const job *j, size_t at,
                           const bench_configuration *limit) {
  const bench_promises *p = j->out;
  double sum = 0.0;
  for (size_t f = 0; f < p->frame_count; f++) {
    const bench_case *frame = &p->frame[f];
    const bench_row *row = &frame->rows[at];
    if (!(off_95(row, limit) <= most_of(limit)))
      return NAN;
    sum += cost(frame, row->pass[HBIL_PASS_GATHER].median) /
           p->scene[frame->scene].frames;
  }
  return sum / (double)p->scene_count;
}

static void find_uniform(const job *j, bench_promise *out) {
  out->uniform_cost = NAN;
  for (size_t i = 0; i < j->count; i++) {
    const double found =
        bench_is_adaptive(&j->list[i]) ? NAN : uniform_cost(j, i, &out->limit);
    if (found < out->uniform_cost ||
        (isnan(out->uniform_cost) && !isnan(found))) {
      out->uniform_cost = found;
      out->uniform = j->list[i];
    }
  }
}

static int sum_up(const job *j, image_error *error) {
  static const unsigned every[BENCH_WAYS] = {1, CHOOSE_EVERY};
  bench_promises *p = j->out;
  for (size_t i = 0; i < j->count; i++) {
    if (!bench_is_adaptive(&j->list[i]))
      continue;
    bench_promise *out = &p->promise[p->count++];
    out->limit = j->list[i];
    find_uniform(j, out);
    for (int w = 0; w < BENCH_WAYS; w++)
      if (add_way(j, i, every[w], &out->way[w], error) != 0)
        return -1;
  }
  return 0;
}

int bench_promises_measure(const bench_options *options, const device *d,
                           int slices, bench_promises *out,
                           image_error *error) {
  job j = {.options = options, .device = d, .slices = slices, .out = out};
  memset(out, 0, sizeof *out);
  choose(&j);
  out->row_count = j.count;
  if (add_frames(&j, error) != 0)
    return -1;
  for (size_t f = 0; f < out->frame_count; f++)
    if (measure_frame(&j, &out->frame[f], error) != 0)
      return -1;
  return sum_up(&j, error);
}

void bench_promises_free(bench_promises *p) {
  for (size_t s = 0; s < p->scene_count; s++)
    free(p->scene[s].name);
  for (size_t i = 0; i < p->count; i++)
    for (int w = 0; w < BENCH_WAYS; w++)
      free(p->promise[i].way[w].taken);
  free(p->scene);
  free(p->frame);
  free(p->rows);
  memset(p, 0, sizeof *p);
}

/* --- text --- */

static const char *short_name(const char *name) {
  const char *slash = strrchr(name, '/');
  return slash ? slash + 1 : name;
}

enum { LIMIT_NAME = 32 };

static void limit_name(const bench_configuration *limit,
                       char text[LIMIT_NAME]) {
  snprintf(text, LIMIT_NAME, "%s %g", limit->most_ao > 0.0f ? "AO" : "E_near",
           most_of(limit));
}

static void print_head(const bench_promises *p, FILE *out) {
  fprintf(out,
          "\nadaptive sampling, scenes: %zu, frames: %zu; the gather, "
          "nanoseconds a pixel, means over the scenes\n",
          p->scene_count, p->frame_count);
  fprintf(out, "%-12s %-28s %-28s %-15s %-13s %s\n%-12s", "95 % within",
          "   each frame chooses", "   one in so many: the tool's", "  uniform",
          " of uniform", " at 1280x720", "");
  for (int w = 0; w < BENCH_WAYS; w++)
    fprintf(out, " %8s %9s %-9s", "gather", "choosing", " beyond");
  fprintf(out, " %15s  %5s %5s  %5s %5s\n", "", "each", "one", "each", "one");
}

static void print_cost(const bench_promises *p, const bench_promise *a,
                       FILE *out) {
  char name[LIMIT_NAME];
  limit_name(&a->limit, name);
  fprintf(out, "%-12s", name);
  for (int w = 0; w < BENCH_WAYS; w++)
    fprintf(out, " %8.2f %9.2f %3zu of %-3zu", a->way[w].gather,
            a->way[w].choosing[BENCH_OWN_SIZE], a->way[w].beyond,
            p->frame_count);
  if (isnan(a->uniform_cost)) {
    fputs("  none\n", out);
    return;
  }
  fprintf(out, " %2ux%-3u %8.2f", (unsigned)a->uniform.slices,
          (unsigned)a->uniform.samples, a->uniform_cost);
  for (int size = 0; size < BENCH_CASE_SIZES; size++)
    fprintf(out, "  %5.2f %5.2f", bench_way_ratio(a, 0, size),
            bench_way_ratio(a, 1, size));
  fputc('\n', out);
}

static void print_taken(const bench_taken *t, FILE *out) {
  char text[32];
  if (t->least[0] == t->most[0] && t->least[1] == t->most[1])
    snprintf(text, sizeof text, "%ux%u", (unsigned)t->most[0],
             (unsigned)t->most[1]);
  else
    snprintf(text, sizeof text, "%ux%u - %ux%u", (unsigned)t->least[0],
             (unsigned)t->least[1], (unsigned)t->most[0], (unsigned)t->most[1]);
  fprintf(out, " %13s %6.3f", text, t->worst);
}

static void print_scenes(const bench_promises *p, FILE *out) {
  fprintf(out,
          "\nsamples, and what 95 %% of the pixels of the worst frame are "
          "within, where one frame in %d chooses\n%-12s",
          CHOOSE_EVERY, "");
  for (size_t s = 0; s < p->scene_count; s++)
    fprintf(out, " %20.20s", short_name(p->scene[s].name));
  fputc('\n', out);
  for (size_t i = 0; i < p->count; i++) {
    char name[LIMIT_NAME];
    limit_name(&p->promise[i].limit, name);
    fprintf(out, "%-12s", name);
    for (size_t s = 0; s < p->scene_count; s++)
      print_taken(&p->promise[i].way[1].taken[s], out);
    fputc('\n', out);
  }
}

double bench_way_ratio(const bench_promise *p, int way, int size) {
  return (p->way[way].gather + p->way[way].choosing[size]) / p->uniform_cost;
}

void bench_write_promises_table(const bench_report *report, FILE *out) {
  bench_print_machine(&report->machine, out);
  print_head(report->promises, out);
  for (size_t i = 0; i < report->promises->count; i++)
    print_cost(report->promises, &report->promises->promise[i], out);
  print_scenes(report->promises, out);
  fprintf(out,
          "beyond: frames of which more than 5 %% of the pixels are off by "
          "more, of the exact integral of %d slices; uniform: the fastest that "
          "is within the limit in all frames; of uniform: gather and choosing "
          "over its time; at 1280x720: the same with so many pixels, for "
          "choosing takes as long whatever their number\n",
          report->exact_slices);
}
