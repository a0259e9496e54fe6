/* hbil-bench truth: the pipeline's indirect light against path-traced light, on
 * folders of dumps. */
#include <math.h>
#include <stdlib.h>

#include "bench/report.h"
#include "bench/truth_measure.h"
#include "bench/truth_process.h"
#include "bench/truth_scene.h"
#include "tool/paths.h"
#include "tool/report.h"

/* Of a scene, in the order of the table's columns. */
typedef enum figure {
  FLOOR,
  ZERO, /* from here on RMSE over that of the floor */
  CONSTANT,
  PAPER,
  OURS,
  MEAN, /* of our light over the truth's */
  CHROMA,
  CHROMA_CONSTANT,
  RMSE, /* those that Markdown has not */
  PAPER_RMSE,
  PAPER_MEAN,
  PAPER_CHROMA,
  NOT_FINITE,
  FIGURES
} figure;

typedef struct row {
  truth_scene scene;
  truth_settings ours, paper;
  double figure[FIGURES];
} row;

typedef struct job {
  const bench_options *options;
  char *folder; /* of results, for as long as the command runs */
  row *rows;
  size_t count;
  size_t done, passes; /* of the pipeline, for the progress */
} job;

static const bench_column columns[] = {
    {"scene", "scene", BENCH_TEXT},
    {"floor", "floor, RMSE", 4},
    {"zero", "zero", 3},
    {"constant_mean", "constant mean", 0},
    {"paper", "`--model paper`", 3},
    {"ours", "ours", 3},
    {"mean_ratio", "mean, of the truth's", 3},
    {"chroma", "chroma", 4},
    {"chroma_constant_mean", "chroma of the constant mean", 4},
    {"rmse", NULL, 6},
    {"paper_rmse", NULL, 6},
    {"paper_mean_ratio", NULL, 3},
    {"paper_chroma", NULL, 4},
    {"not_finite", NULL, 0}};
_Static_assert(sizeof columns / sizeof *columns == FIGURES + 1,
               "a column for each figure");

/* --- measuring --- */

static int light(job *j, const process_settings *settings, char *const *files,
                 size_t count, const compare_side *truth,
                 const compare_mask *mask, truth_figures *out,
                 image_error *error) {
  compare_side answer = {.path = NULL};
  int failed = truth_process(settings, files, count, error);
  if (!failed)
    failed = truth_process_read(settings, files[count - 1], &answer, error);
  if (!failed)
    failed = truth_measure(&answer, truth, mask, out, error);
  compare_side_free(&answer);
  progress_count("passes of the pipeline", ++j->done, j->passes);
  return failed;
}

static int compare(job *j, row *r, const compare_side *truth,
                   const compare_mask *mask, image_error *error) {
  const truth_scene *s = &r->scene;
  double mean[3];
  truth_figures constant, zero, ours, paper;
  truth_mean_colour(truth, mask, mean);
  if (truth_measure_constant(mean, truth, mask, &constant, error) != 0 ||
      truth_measure_constant((const double[3]){0.0, 0.0, 0.0}, truth, mask,
                             &zero, error) != 0 ||
      light(j, &r->ours.settings, s->frames, s->count, truth, mask, &ours,
            error) != 0 ||
      light(j, &r->paper.settings, s->frames, s->count, truth, mask, &paper,
            error) != 0)
    return -1;
  const double least = constant.rmse;
  const double figures[FIGURES] = {[FLOOR] = least,
                                   [ZERO] = zero.rmse / least,
                                   [CONSTANT] = 1.0,
                                   [PAPER] = paper.rmse / least,
                                   [OURS] = ours.rmse / least,
                                   [MEAN] = ours.mean / constant.mean,
                                   [CHROMA] = ours.chroma,
                                   [CHROMA_CONSTANT] = constant.chroma,
                                   [RMSE] = ours.rmse,
                                   [PAPER_RMSE] = paper.rmse,
                                   [PAPER_MEAN] = paper.mean / constant.mean,
                                   [PAPER_CHROMA] = paper.chroma,
                                   [NOT_FINITE] = (double)ours.not_finite};
  for (int i = 0; i < FIGURES; i++)
    r->figure[i] = figures[i];
  return 0;
}

static int measure(job *j, row *r, image_error *error) {
  compare_side truth;
  compare_mask mask = {.albedo = 0};
  const char *last = r->scene.frames[r->scene.count - 1];
  int failed = truth_scene_read(&r->scene, &truth, error);
  if (!failed)
    failed = compare_mask_read(last, 1, &truth.planes, &mask, error);
  if (!failed)
    failed = compare(j, r, &truth, &mask, error);
  compare_mask_free(&mask);
  compare_side_free(&truth);
  return failed;
}

/* --- all scenes --- */

static int check(const row *r, image_error *error) {
  const truth_scene *s = &r->scene;
  compare_side truth;
  uint32_t width, height;
  if (truth_process_check(&r->ours.settings, s->frames, s->count, &width,
                          &height, error) != 0)
    return -1;
  int failed = truth_scene_read(s, &truth, error);
  const image *light = &truth.planes;
  if (!failed && (light->width != width || light->height != height))
    failed = image_fail(error,
                        "%s: %u x %u pixels, but %s has %u x %u; the truth of "
                        "this frame is needed",
                        s->truth, light->width, light->height,
                        s->frames[s->count - 1], width, height);
  compare_side_free(&truth);
  return failed;
}

static void free_row(row *r) {
  truth_settings_free(&r->ours);
  truth_settings_free(&r->paper);
  truth_scene_free(&r->scene);
}

/* A scene and its settings. */
static int find(const job *j, const char *argument, row *r,
                image_error *error) {
  if (truth_scene_find(argument, &r->scene, error) != 0)
    return -1;
  char *folder = path_parent(r->scene.frames[r->scene.count - 1]);
  if (!folder)
    return image_no_memory(error, argument);
  const int failed =
      truth_settings_read(j->options, folder, 0, &r->ours, error) != 0 ||
      truth_settings_read(j->options, folder, 1, &r->paper, error) != 0;
  free(folder);
  return failed ? -1 : 0;
}

/* Mistakes are told before anything takes time. */
static int prepare(job *j, image_error *error) {
  j->rows = calloc(j->options->frame_count, sizeof *j->rows);
  if (!j->rows)
    return image_no_memory(error, "truth");
  for (; j->count < j->options->frame_count; j->count++)
    if (find(j, j->options->frames[j->count], &j->rows[j->count], error) != 0) {
      free_row(&j->rows[j->count]);
      return -1;
    }
  j->folder = truth_folder_make(error);
  if (!j->folder)
    return -1;
  for (size_t i = 0; i < j->count; i++) {
    row *r = &j->rows[i];
    r->ours.settings.output = r->paper.settings.output = j->folder;
    if (check(r, error) != 0)
      return -1;
  }
  j->passes = 2 * j->count;
  return 0;
}

static int measure_all(job *j, image_error *error) {
  if (prepare(j, error) != 0)
    return -1;
  for (size_t i = 0; i < j->count; i++)
    if (measure(j, &j->rows[i], error) != 0)
      return -1;
  return 0;
}

/* --- the report --- */

/* Less is rounding: the chroma of a scene without colours. */
static const double least_figure = 1e-6;

/* NAN where all figures are too small. */
static double geometric_mean(const job *j, figure f) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < j->count; i++)
    if (j->rows[i].figure[f] > least_figure) {
      sum += log(j->rows[i].figure[f]);
      count += 1.0;
    }
  return exp(sum / count);
}

/* The largest; of means, that which is off by the largest factor. */
static double worst(const job *j, figure f) {
  const int is_mean = f == MEAN || f == PAPER_MEAN;
  double most = -INFINITY, out = NAN;
  for (size_t i = 0; i < j->count; i++) {
    const double value = j->rows[i].figure[f];
    const double off = is_mean ? fabs(log(value)) : value;
    if (off > most) {
      most = off;
      out = value;
    }
  }
  return out;
}

static void report_summary(const job *j, const char *name,
                           double (*of)(const job *, figure),
                           bench_report *report) {
  bench_report_row(report);
  bench_report_text(report, name);
  for (int f = 0; f < FIGURES; f++)
    bench_report_number(report,
                        f == FLOOR || f >= RMSE ? NAN : of(j, (figure)f));
}

static void report_scenes(const job *j, bench_report *report) {
  bench_report_table(report, "scenes", "Indirect light against path tracing",
                     columns, sizeof columns / sizeof *columns);
  for (size_t i = 0; i < j->count; i++) {
    bench_report_row(report);
    bench_report_text(report, j->rows[i].scene.name);
    for (int f = 0; f < FIGURES; f++)
      bench_report_number(report, j->rows[i].figure[f]);
  }
  report_summary(j, "geometric mean", geometric_mean, report);
  report_summary(j, "worst", worst, report);
}

static void report_notes(const job *j, bench_report *report) {
  double not_finite = 0.0;
  char words[512] = "";
  size_t used = 0;
  for (size_t i = 0; i < j->count; i++)
    not_finite += j->rows[i].figure[NOT_FINITE];
  for (int i = 0; i < j->options->process_count && used < sizeof words; i++)
    used += (size_t)snprintf(words + used, sizeof words - used, " %s",
                             j->options->process[i]);
  bench_report_note(
      report,
      "The floor is the RMSE of the constant mean, the truth's own mean colour "
      "everywhere; zero, `--model paper` and ours are RMSE over it.  chroma is "
      "the RMSE of (R, G, B) / (R + G + B), weighted by the truth's luminance; "
      "its geometric mean is that of scenes with colours.  The worst mean is "
      "off by the largest factor.");
  bench_report_note(report, "Options of hbil process:%s.",
                    *words ? words : " none");
  if (not_finite > 0.0)
    bench_report_note(report,
                      "%.0f values of ours are not finite; they are "
                      "left out.",
                      not_finite);
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.options = options};
  (void)device; /* hbil process opens it by its name */
  const int failed = measure_all(&j, error);
  if (!failed) {
    report_scenes(&j, report);
    report_notes(&j, report);
  }
  for (size_t i = 0; i < j.count; i++)
    free_row(&j.rows[i]);
  free(j.rows);
  truth_folder_remove(j.folder);
  return failed;
}

const bench_command bench_truth = {
    .name = "truth",
    .about = "indirect light against path-traced truth, scene by scene",
    .details =
        "How far is the light of hbil process from that of a path tracer, and\n"
        "how far are trivial answers?  FOLDER is one of\n"
        "  a folder of frame_NNNN.exr with cameras, and truth_avg_NNNN.exr of\n"
        "  the last one.  Without that file, the light in that frame is the\n"
        "  truth.  Without any, it is the last truth_avg_NNNN.exr in the "
        "folder\n"
        "  above, if frame_NNNN there has the camera of the last one;\n"
        "  a folder with NAME.exr, its camera and NAME_truth.exr;\n"
        "  FOLDER/NAME of such a NAME.exr.  If there is no NAME_truth.exr,\n"
        "  NAME loses parts from the last _ on until there is one.\n"
        "Truth is the layer DiffInd or indirect, or else R, G, B.\n"
        "\n"
        "OPTIONS are those of hbil process, which runs over all frames:\n"
        "  hbil-bench truth FOLDER... -- --environment none\n"
        "  hbil-bench truth FOLDER... -- --far cones \\\n"
        "    --view '{scene}/views/face_*.exr'\n"
        "{scene} stands for the scene's folder.  Behind --view, *, ? and "
        "[...]\n"
        "match names as in a shell; here alone, not in hbil process.\n"
        "\n"
        "Pixels and channels are those of hbil compare --mask.  The floor is\n"
        "the RMSE of the constant mean, the truth's mean colour everywhere.\n"
        "Divided by that floor are the RMSE of no light (zero), of OPTIONS "
        "with\n"
        "--model paper (without a radiance cache), and of OPTIONS (ours).\n"
        "Chroma is the error of colour alone: with c = (R,G,B) / (R+G+B), the\n"
        "root of the mean of |c - c_truth|^2, weighted by the truth's\n"
        "luminance, over pixels with all channels and a luminance of the "
        "truth\n"
        "above a thousandth of its mean.  Negative values count as 0, and "
        "black\n"
        "as grey.  The worst mean is that which is off by the largest "
        "factor.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_FOLDERS,
    .run = run};
