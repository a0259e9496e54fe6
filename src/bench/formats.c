/* hbil-bench formats: what it costs in accuracy to hand a plane over in fewer
 * bits. */
#include <math.h>
#include <stdlib.h>

#include "bench/content.h"
#include "bench/fixture.h"
#include "bench/report.h"
#include "bench/settings.h"
#include "scene/store.h"

/* How depth is stored. */
typedef enum depth_form {
  AS_IT_IS,        /* and what isn't depth */
  NEAR_TO_FAR,     /* hardware depth 0..1 */
  REVERSED,        /* 1..0 */
  REVERSED_ENDLESS /* 1..0, the far plane at infinity */
} depth_form;

typedef struct form {
  bench_input input;
  const char *plane, *name;
  hbil_component component;
  hbil_normal_encoding encoding;
  depth_form depth;
  int bits; /* a pixel */
} form;

#define XYZ HBIL_NORMAL_XYZ
#define MAP HBIL_NORMAL_OCTAHEDRAL
static const form forms[] = {
    {BENCH_NORMAL, "normal", "FLOAT16", HBIL_FLOAT16, XYZ, AS_IT_IS, 48},
    {BENCH_NORMAL, "", "SNORM16", HBIL_SNORM16, XYZ, AS_IT_IS, 48},
    {BENCH_NORMAL, "", "UNORM16", HBIL_UNORM16, XYZ, AS_IT_IS, 48},
    {BENCH_NORMAL, "", "RGB10A2_UNORM", HBIL_RGB10A2_UNORM, XYZ, AS_IT_IS, 32},
    {BENCH_NORMAL, "", "SNORM8", HBIL_SNORM8, XYZ, AS_IT_IS, 24},
    {BENCH_NORMAL, "", "UNORM8", HBIL_UNORM8, XYZ, AS_IT_IS, 24},
    {BENCH_NORMAL, "normal, octahedral", "FLOAT16", HBIL_FLOAT16, MAP, AS_IT_IS,
     32},
    {BENCH_NORMAL, "", "SNORM16", HBIL_SNORM16, MAP, AS_IT_IS, 32},
    {BENCH_NORMAL, "", "SNORM8", HBIL_SNORM8, MAP, AS_IT_IS, 16},
    {BENCH_NORMAL, "", "UNORM8", HBIL_UNORM8, MAP, AS_IT_IS, 16},
    {BENCH_DEPTH, "depth, planar", "FLOAT16", HBIL_FLOAT16, XYZ, AS_IT_IS, 16},
    {BENCH_DEPTH, "hardware, 0..1", "FLOAT32", HBIL_FLOAT32, XYZ, NEAR_TO_FAR,
     32},
    {BENCH_DEPTH, "", "UNORM24", HBIL_UNORM24, XYZ, NEAR_TO_FAR, 24},
    {BENCH_DEPTH, "", "UNORM16", HBIL_UNORM16, XYZ, NEAR_TO_FAR, 16},
    {BENCH_DEPTH, "hardware, 1..0", "FLOAT32", HBIL_FLOAT32, XYZ, REVERSED, 32},
    {BENCH_DEPTH, "", "UNORM24", HBIL_UNORM24, XYZ, REVERSED, 24},
    {BENCH_DEPTH, "", "FLOAT16", HBIL_FLOAT16, XYZ, REVERSED, 16},
    {BENCH_DEPTH, "1..0, far plane at infinity", "FLOAT32", HBIL_FLOAT32, XYZ,
     REVERSED_ENDLESS, 32},
    {BENCH_ALBEDO, "albedo", "FLOAT16", HBIL_FLOAT16, XYZ, AS_IT_IS, 48},
    {BENCH_ALBEDO, "", "UNORM16", HBIL_UNORM16, XYZ, AS_IT_IS, 48},
    {BENCH_ALBEDO, "", "RGB10A2_UNORM", HBIL_RGB10A2_UNORM, XYZ, AS_IT_IS, 32},
    {BENCH_ALBEDO, "", "UNORM8", HBIL_UNORM8, XYZ, AS_IT_IS, 24},
    {BENCH_DIRECT, "direct", "FLOAT16", HBIL_FLOAT16, XYZ, AS_IT_IS, 48},
    {BENCH_DIRECT, "", "RGB9E5_FLOAT", HBIL_RGB9E5_FLOAT, XYZ, AS_IT_IS, 32},
    {BENCH_DIRECT, "", "R11G11B10_FLOAT", HBIL_R11G11B10_FLOAT, XYZ, AS_IT_IS,
     32},
};
enum { FORMS = sizeof forms / sizeof *forms };

typedef struct job {
  const bench_device *device;
  bench_content content;
  hbil_config config;
  bench_fixture *fixture;
  bench_report *report;
  double nearest, farthest;      /* planar depths of surfaces */
  float *ao, *light;             /* with float planes */
  float *other_ao, *other_light; /* with one plane in another format */
  unsigned char *bytes;          /* of that plane: up to 12 a pixel */
} job;

static const bench_column columns[] = {{"plane", "plane", BENCH_TEXT},
                                       {"format", "format", BENCH_TEXT},
                                       {"bits", "bits a pixel", 0},
                                       {"ao", "AO", 6},
                                       {"light", "E_near", 6}};

/* --- a plane in another format --- */

/* Planar depth of a pixel. */
static double planar_depth(const job *j, size_t pixel) {
  const bench_frame *frame = &j->content.frame[j->content.measured];
  const hbil_camera *camera = &frame->camera;
  const double depth = (double)frame->plane[BENCH_DEPTH][pixel];
  const size_t width = j->content.width;
  const double x = ((double)(pixel % width) + 0.5 - camera->cx) / camera->fx;
  const double y = ((double)(pixel / width) + 0.5 - camera->cy) / camera->fy;
  return j->content.config.inputs.depth_kind == HBIL_DEPTH_RAY
             ? depth / sqrt(x * x + y * y + 1.0)
             : depth;
}

static void find_depths(job *j) {
  j->nearest = INFINITY;
  for (size_t i = 0; i < bench_pixels(&j->content); i++)
    if (bench_is_surface(&j->content, i)) {
      j->nearest = fmin(j->nearest, planar_depth(j, i));
      j->farthest = fmax(j->farthest, planar_depth(j, i));
    }
}

/* The near and the far plane lie so far off the surfaces, as they do where one
 * pair serves a whole world. */
static const double margin = 20.0;

/* hbil_frame.hardware_depth. */
static void project(const job *j, depth_form how, double out[2]) {
  const double n = j->nearest / margin, f = j->farthest * margin;
  const int flat =
      j->content.config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  double a = how == NEAR_TO_FAR ? f / (f - n) : -n / (f - n);
  double b = (how == NEAR_TO_FAR ? -f : f) * n / (f - n);
  if (flat) {
    a = how == NEAR_TO_FAR ? -n / (f - n) : f / (f - n);
    b = (how == NEAR_TO_FAR ? 1.0 : -1.0) / (f - n);
  } else if (how == REVERSED_ENDLESS) {
    a = 0.0;
    b = n;
  }
  out[0] = a;
  out[1] = b;
}

/* Returns the bytes of the plane. */
static size_t store(const job *j, const form *f, const double projection[2]) {
  const bench_frame *frame = &j->content.frame[j->content.measured];
  const size_t pixels = bench_pixels(&j->content);
  const int inputs = (int)bench_input_channels(f->input);
  const int map = f->encoding == HBIL_NORMAL_OCTAHEDRAL;
  const int biased =
      f->input == BENCH_NORMAL &&
      (f->component == HBIL_UNORM8 || f->component == HBIL_UNORM16 ||
       f->component == HBIL_RGB10A2_UNORM);
  const size_t size = scene_component_size(f->component);
  const size_t pitch =
      scene_is_word(f->component) ? size : size * (size_t)(map ? 2 : inputs);
  for (size_t i = 0; i < pixels; i++) {
    double v[3];
    for (int c = 0; c < inputs; c++)
      v[c] = (double)frame->plane[f->input][(size_t)c * pixels + i];
    if (map) {
      const double normal[3] = {v[0], v[1], v[2]};
      scene_octahedral(normal, v);
    }
    if (f->depth != AS_IT_IS)
      v[0] = scene_hardware_depth(
          projection,
          j->content.config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC,
          bench_is_surface(&j->content, i) ? planar_depth(j, i) : 0.0);
    scene_store(f->component, biased, v, map ? 2 : inputs, size,
                j->bytes + i * pitch);
  }
  return pixels * pitch;
}

static void set_form(const form *f, hbil_config *config) {
  hbil_inputs *in = &config->inputs;
  hbil_plane_format *format = f->input == BENCH_NORMAL   ? &in->normal
                              : f->input == BENCH_DEPTH  ? &in->depth
                              : f->input == BENCH_ALBEDO ? &in->albedo
                                                         : &in->direct;
  format->component = f->component;
  in->normal_encoding = f->encoding;
  if (f->depth != AS_IT_IS)
    in->depth_kind = HBIL_DEPTH_HARDWARE;
}

/* --- frames --- */

/* Runs the measured frame; f: NULL for float planes. */
static int light(job *j, const form *f, float *ao, float *near_light,
                 image_error *error) {
  bench_trial t;
  hbil_config config = j->config;
  cl_mem buffer = NULL;
  if (f)
    set_form(f, &config);
  int failed = bench_trial_open(j->fixture, &config, NULL, &t, error);
  if (!failed && f) {
    project(j, f->depth, t.hardware_depth);
    const size_t size = store(j, f, t.hardware_depth);
    failed = bench_buffer_new(j->device, size, j->bytes, &buffer, error);
    t.replaced[f->input] = buffer;
  }
  failed = failed ||
           bench_trial_run(&t, j->content.measured, 0, 0, error) != 0 ||
           bench_trial_read(&t, BENCH_AO, ao, error) != 0 ||
           bench_trial_read(&t, BENCH_NEAR, near_light, error) != 0;
  bench_trial_close(&t);
  if (buffer)
    clReleaseMemObject(buffer);
  return failed ? -1 : 0;
}

static int measure(job *j, const form *f, image_error *error) {
  const bench_frame *frame = &j->content.frame[j->content.measured];
  if (!frame->plane[f->input])
    return 0;
  if (light(j, f, j->other_ao, j->other_light, error) != 0)
    return -1;
  bench_report_row(j->report);
  bench_report_text(j->report, f->plane);
  bench_report_text(j->report, f->name);
  bench_report_number(j->report, f->bits);
  bench_report_number(j->report,
                      bench_ao_error(&j->content, j->other_ao, j->ao));
  bench_report_number(j->report,
                      bench_light_error(&j->content, j->other_light, j->light));
  return 0;
}

/* quick: some of them. */
static int measure_all(job *j, int quick, image_error *error) {
  if (light(j, NULL, j->ao, j->light, error) != 0)
    return -1;
  bench_report_table(j->report, "formats", "Formats of inputs", columns,
                     sizeof columns / sizeof *columns);
  for (int i = 0; i < FORMS; i += quick ? 8 : 1) {
    bench_progress("formats", (size_t)i + 1, FORMS);
    if (measure(j, &forms[i], error) != 0)
      return -1;
  }
  bench_report_note(
      j->report,
      "RMSE against the same frame with all planes in FLOAT32, of E_near over "
      "its mean; one bounce.  One plane at a time has another format.  "
      "Hardware "
      "depth has its near plane at %.4g and its far plane at %.4g; surfaces "
      "lie "
      "at %.4g to %.4g.",
      j->nearest / margin, j->farthest * margin, j->nearest, j->farthest);
  return 0;
}

static int run(const bench_options *options, const bench_device *device,
               bench_report *report, image_error *error) {
  job j = {.device = device, .report = report};
  if (bench_content_load(options, 1, 0, &j.content, error) != 0)
    return -1;
  const bench_setting setting = bench_setting_default(&j.content);
  const size_t pixels = bench_pixels(&j.content);
  bench_report_subject(report, j.content.name, j.content.width,
                       j.content.height, 0);
  bench_setting_apply(&setting, &j.content, &j.config);
  find_depths(&j);
  float *planes = malloc(8 * pixels * sizeof *planes);
  j.bytes = malloc(12 * pixels);
  int failed = planes && j.bytes ? 0 : image_no_memory(error, j.content.name);
  if (!failed) {
    j.ao = planes;
    j.light = planes + pixels;
    j.other_ao = planes + 4 * pixels;
    j.other_light = planes + 5 * pixels;
  }
  failed = failed ||
           bench_fixture_open(device, &j.content, &j.fixture, error) != 0 ||
           measure_all(&j, options->quick, error) != 0;
  bench_fixture_close(j.fixture);
  bench_content_free(&j.content);
  free(planes);
  free(j.bytes);
  return failed ? -1 : 0;
}

const bench_command bench_formats = {
    .name = "formats",
    .about = "the error of each format that inputs can have",
    .details =
        "How far are results off if a plane is handed over in fewer bits than\n"
        "FLOAT32?  FRAME.exr is a captured frame; without any, it is the "
        "room.\n",
    .accepts = BENCH_TAKES_REPORT | BENCH_TAKES_ROOM | BENCH_TAKES_FRAMES |
               BENCH_TAKES_ERRORS,
    .run = run};
