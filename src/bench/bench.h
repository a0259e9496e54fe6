/*
 * The bench: time and error of the library's settings, side by side with a
 * baseline and a bandwidth yardstick that are measured in the same run.
 *
 * Content is the procedural room or a captured frame.  Error is sampling error
 * (against the exact screen-space integral of the same model) and, where a
 * path-traced truth is given, model error.  As everywhere in the tool,
 * functions that can fail return 0 or fill an image_error.
 */
#ifndef HBIL_BENCH_H
#define HBIL_BENCH_H

#include <stdio.h>

#include "tool/tool.h"

enum {
  BENCH_WARM_UP = 2,      /* runs that are not counted */
  BENCH_MAX_RUNS = 1000,  /* --runs */
  BENCH_FRAMES = 2,       /* the camera moves between them */
  BENCH_TRUTH_BOUNCES = 4 /* still frames before the truth is looked at */
};

typedef struct bench_options {
  uint32_t width, height; /* of the room; 0: the default */
  const char *dump;       /* FRAME.exr, or NULL for the room */
  unsigned scale;         /* pixels in the place of one of a frame, in a row */
  const char *camera;     /* NULL: FRAME.json beside it */
  const char *truth;      /* path-traced indirect light of the dump, or NULL */
  const char *device;     /* see device_open() */
  const char *output;     /* folder */
  unsigned runs;          /* counted runs of every configuration */
  unsigned pixels;        /* most that errors are measured at; 0: the default */
  int quick;              /* few configurations, small */
  int scaling, skips;     /* that part alone */
  int probe;              /* see probe.c */
  const char *against;    /* that part alone: folder of other kernels */
  int temporal;           /* that part alone, of a sequence */
  int adaptive;           /* that part alone, of frames or the room */
  char *const *frames;
  unsigned frame_count;
} bench_options;

/* Measures, prints the tables, writes the files. */
int bench_run(const bench_options *options, image_error *error);

/* --- configurations.c: what is measured --- */

/* What a result should be; each has an exact integral of its own. */
typedef enum bench_model {
  BENCH_PAPER = 0, /* the library's defaults */
  BENCH_THICK_02,  /* the same, occluders as thick as 2 % of their depth */
  BENCH_THICK_08,
  BENCH_THICK_30,
  BENCH_TOOL, /* that of hbil process */
  BENCH_GTAO, /* AO alone */
  BENCH_HBAO, /* AO alone, within a radius */
  BENCH_MODELS
} bench_model;

typedef struct bench_configuration {
  cl_uint slices, samples;
  float growth;
  hbil_sample_grid lattice;
  int raw;   /* without recompose's filter */
  int quick; /* also part of the short list */
  bench_model model;
  const char *preset; /* its name, or NULL */
  hbil_storage storage;
  int plain; /* nothing is extrapolated */
  /* adaptive: what 95 % of the pixels may be off by; 0: any */
  float most_ao, most_light;
} bench_configuration;

/* Longest label, with its end. */
enum { BENCH_LABEL = 64 };
enum { BENCH_MAX_CONFIGURATIONS = 96 };

/* The list; those of the short one only if quick. */
size_t bench_configurations(int quick,
                            bench_configuration out[BENCH_MAX_CONFIGURATIONS]);
/* "tool", "thick .08"; empty for the paper. */
const char *bench_model_name(bench_model model);
/* Whether all there is is AO. */
int bench_is_ao_alone(bench_model model);
/* Whether occluders end and nothing else is different from the paper. */
int bench_is_thick(bench_model model);
int bench_is_adaptive(const bench_configuration *c);
/* Whether they differ in how many samples there are, and in nothing else. */
int bench_is_uniform_of(const bench_configuration *uniform,
                        const bench_configuration *adaptive);
/* Of the layers: "packed", "fp32", "half" or "float11". */
const char *bench_storage_name(const bench_configuration *c);
/* Whether the list has the same with fp32 layers: what others lose is shown. */
int bench_is_of_storage(const bench_configuration *c);
/* The setting that the others' cost is told in multiples of. */
bench_configuration bench_first(void);
/* What the library does by itself. */
bench_configuration bench_default(void);
int bench_is_default(const bench_configuration *c);
/* Whether hbil process does this by itself. */
int bench_is_tools_default(const bench_configuration *c);
/* "tool fast 1x8 full g2". */
void bench_label(const bench_configuration *c, char *text, size_t size);

/* --- content.c: what it is measured on --- */

/* Planes of a frame on the host. */
typedef enum bench_input {
  BENCH_DEPTH = 0,
  BENCH_NORMAL,
  BENCH_ALBEDO,
  BENCH_DIRECT,
  BENCH_EMISSION,
  BENCH_INPUTS
} bench_input;

typedef struct bench_frame {
  hbil_camera camera;
  float *plane[BENCH_INPUTS]; /* channels one after the other; NULL: none */
  float *motion;              /* since the frame before; two channels or NULL */
} bench_frame;

typedef struct bench_content {
  char name[512];
  char note[256]; /* what had to be assumed, or empty */
  uint32_t width, height;
  unsigned frames;
  bench_frame frame[BENCH_FRAMES];
  float environment[9][3]; /* of all far fields but `far` */
  float sky[9][3];         /* of that one */
  hbil_config config;      /* size, conventions, the paper's model */
  hbil_far_field far;      /* of the tool's model */
  float radius;            /* of HBAO */
  float *truth;            /* three planes, or NULL */
  /* One byte a pixel: whether sampling error is measured there.  As many in
   * each of the 16 layers. */
  unsigned char *compared;
  size_t compared_count;
} bench_content;

/* What goes with a far field, 9 x 3 numbers. */
const void *bench_environment(const bench_content *content, hbil_far_field far);
/* The content's settings with a configuration's model and sampling. */
void bench_configure(const bench_content *content, const bench_configuration *c,
                     hbil_config *config);

int bench_content_load(const bench_options *options, bench_content *out,
                       image_error *error);
/* What a frame's header tells; camera: NULL for the frame's own.  The map is to
 * be freed, also after a failure. */
int bench_read_map(const char *path, const char *camera, channel_map *map,
                   camera_file *out, image_error *error);
/* Gives back the planes, once they are on the device; the rest stays. */
void bench_content_drop_planes(bench_content *content);
void bench_content_free(bench_content *content);
/* enlarge.c: so many pixels for each, in both directions. */
int bench_content_enlarge(bench_content *content, unsigned times,
                          image_error *error);
size_t bench_input_channels(bench_input input);
size_t bench_pixels(const bench_content *content);
/* Whether a pixel of frame 0 shows a surface. */
int bench_is_surface(const bench_content *content, size_t pixel);

/* --- statistics.c --- */

typedef struct bench_spread {
  double median, low, high;
} bench_spread;

/* Sorts values. */
bench_spread bench_spread_of(double *values, unsigned count);

/* Sampling error of a result of frame 0, over the surfaces that are compared;
 * NAN where a value is not finite. */
double bench_ao_error(const bench_content *content, const float *ao,
                      const float *reference);
/* RMSE over all channels, divided by the reference's mean. */
double bench_light_error(const bench_content *content, const float *light,
                         const float *reference);
/* What 95 % of the same pixels are off by at most: of AO, of the worst channel
 * over the reference's mean. */
int bench_ao_95(const bench_content *content, const float *ao,
                const float *reference, double *out, image_error *error);
int bench_light_95(const bench_content *content, const float *light,
                   const float *reference, double *out, image_error *error);
/* RMSE against the truth where there is a surface and, channel by channel,
 * albedo above 0.02 (as hbil compare --mask has it); all of them need a truth.
 * indirect NULL: of zero. */
double bench_model_error(const bench_content *content, const float *indirect);
/* The same of each channel's mean everywhere. */
double bench_mean_error(const bench_content *content);

/* --- program.c: the bench's own kernels --- */

/* Generated from the .cl files in this folder; ends with a NULL name. */
typedef struct bench_source {
  const char *name;
  const char *text;
} bench_source;
extern const bench_source bench_sources[];

/* The kernel that FILE.cl defines under the same name. */
int bench_kernel(const device *d, const char *name, const char *defines,
                 cl_kernel *out, image_error *error);
/* Milliseconds of runs launches after the warm-up, by profiling events. */
int bench_time_kernel(const device *d, cl_kernel kernel, const size_t global[2],
                      const size_t local[2], unsigned runs, bench_spread *out,
                      image_error *error);
int bench_buffer(const device *d, size_t bytes, const void *content,
                 cl_mem *out, image_error *error);
int bench_cl_failed(const device *d, cl_int status, const char *doing,
                    image_error *error);

/* --- copy.c: the bandwidth yardstick --- */

typedef struct bench_copy {
  unsigned planes;
  size_t bytes; /* read and written, together */
  bench_spread milliseconds;
} bench_copy;

int bench_is_cpu(const device *d);
int bench_measure_copy(const device *d, size_t pixels, unsigned runs,
                       bench_copy *out, image_error *error);
/* Milliseconds of a copy that moves as many bytes. */
double bench_copy_time(const bench_copy *copy, double bytes);
/* Bytes that a pass has to move in all; 0 where it is not told. */
double bench_pass_bytes(const bench_content *content, hbil_pass pass);
/* The same of a reprojection by motion vectors. */
double bench_motion_bytes(const bench_content *content);

/* --- literal.c: the baseline --- */

typedef struct bench_literal {
  bench_spread milliseconds;
  double ao_error, light_error; /* of unfiltered pixels */
} bench_literal;

/* ao and light: the reference. */
int bench_measure_literal(const device *d, const bench_content *content,
                          unsigned runs, const float *ao, const float *light,
                          bench_literal *out, image_error *error);

/* --- exact.c: what sampling errors are measured against --- */

/* The exact integral of frame 0, one bounce, of every model in use. */
typedef struct bench_exact {
  int slices;
  float *ao[BENCH_MODELS];    /* NULL: the model is not in use */
  float *light[BENCH_MODELS]; /* E_near; NULL where AO is all */
} bench_exact;

int bench_exact_make(const bench_content *content, int slices,
                     const bench_configuration *list, size_t count,
                     bench_exact *out, image_error *error);
void bench_exact_free(bench_exact *exact);

/* --- lab.c: the library on the content --- */

typedef struct bench_row {
  bench_configuration configuration;
  char label[BENCH_LABEL];
  size_t memory; /* bytes on the device */
  bench_spread pass[HBIL_PASS_COUNT], total;
  bench_spread host; /* milliseconds in hbil_enqueue_frame() */
  /* over those of the first configuration, measured in turns */
  double gather_over_start, total_over_start;
  double ao_error, light_error; /* light: NAN where AO is all */
  double ao_95, light_95;       /* 95 % of the pixels are off by less */
  cl_uint slices, samples;      /* taken: fewer where adaptive */
  double choosing;              /* milliseconds of the gather; adaptive */
  double model_error;           /* NAN without a truth */
  int ao_front, light_front;    /* nothing of its model is faster and better */
  double ao_loss, light_loss;   /* off fp32 layers; NAN: not compared */
  /* Gather's time over that of the same sampling with endless occluders, both
   * measured in turns; NAN where occluders don't end. */
  double over_endless;
} bench_row;

typedef struct bench_lab bench_lab;

int bench_lab_open(const device *d, const bench_content *content,
                   bench_lab **out, image_error *error);
void bench_lab_close(bench_lab *lab);
/* Everything but times. */
int bench_lab_errors(bench_lab *lab, const bench_exact *exact,
                     const bench_configuration *c, bench_row *out,
                     image_error *error);
/* Fills in the times, once errors are there. */
int bench_lab_times(bench_lab *lab, const bench_configuration *c, unsigned runs,
                    bench_row *out, image_error *error);
/* Fills in what the row's storage loses. */
int bench_lab_loss(bench_lab *lab, const bench_configuration *c, bench_row *row,
                   image_error *error);
/* Fills in over_endless. */
int bench_lab_thickness(bench_lab *lab, const bench_configuration *c,
                        unsigned runs, bench_row *row, image_error *error);
/* What the estimate of unseen light adds to the split of a configuration of the
 * tool's model: milliseconds. */
int bench_lab_estimate(bench_lab *lab, const bench_configuration *c,
                       unsigned runs, double *out, image_error *error);
/* Reprojection by the content's motion vectors, in a plan that is the
 * configuration's otherwise: milliseconds, NAN where there are none. */
int bench_lab_motion(bench_lab *lab, const bench_configuration *c,
                     unsigned runs, bench_spread *out, image_error *error);

/* --- lab.c: what scaling needs --- */

/* A plan that is measured in turns with others. */
typedef struct bench_turn {
  bench_lab *lab;
  hbil_config config;
  int still;           /* frame 0 over and over, and said to be */
  int first_only;      /* frame 0 over and over */
  unsigned settled;    /* so many frames before the first that is timed */
  const char *kernels; /* folder that they are read from, or NULL; one for all
                          turns of a lab */
} bench_turn;

typedef struct bench_timing {
  bench_spread total, pass[HBIL_PASS_COUNT], host; /* milliseconds */
  /* over the first one's, turn by turn: medians */
  double total_ratio, pass_ratio[HBIL_PASS_COUNT];
  double mean;             /* of total */
  hbil_statistics skipped; /* by the last frame */
} bench_timing;

/* Frames with images of floats, and those with images of half floats but for
 * depth. */
int bench_lab_halves(bench_lab *lab, const bench_configuration *c,
                     unsigned runs, bench_timing out[2], image_error *error);

enum { BENCH_MAX_TURNS = 8 };

int bench_lab_turns(const bench_turn *list, size_t count, unsigned runs,
                    bench_timing *out, image_error *error);

/* Three, since there is no history to reproject before the second, which loads
 * those kernels. */
enum { BENCH_START_FRAMES = 3 };

/* Milliseconds, by the clock on the wall, until a new plan is made and until
 * each of its first frames is done. */
typedef struct bench_start {
  double plan, frame[BENCH_START_FRAMES];
} bench_start;

int bench_lab_start(bench_lab *lab, const hbil_config *config, bench_start *out,
                    image_error *error);

/* What passes exchange: words of 32 bits a pixel. */
enum { BENCH_STAGES = HBIL_STAGE_RESOLVED + 1 };
typedef struct bench_planes {
  size_t values[BENCH_STAGES]; /* as in hbil_buffer */
  size_t scatter;              /* depth and index of what lands on a pixel */
} bench_planes;

int bench_lab_planes(bench_lab *lab, const hbil_config *config,
                     bench_planes *out, image_error *error);

/* Bytes on the device. */
typedef struct bench_memory {
  size_t plan;   /* hbil_plan_memory() */
  size_t planes; /* the same words without padding and tables */
  size_t images; /* inputs and outputs of the bench */
} bench_memory;

/* Of a configuration of any size; nothing is allocated. */
int bench_lab_memory(bench_lab *lab, const hbil_config *config,
                     const bench_planes *planes, bench_memory *out,
                     image_error *error);

/* --- probe.c: a plan in a process of its own --- */

/* What `hbil bench --probe` tells. */
typedef struct bench_probe {
  unsigned units; /* the device's compute units in that process */
  bench_start start;
  double total, gather; /* milliseconds, medians */
} bench_probe;

/* Measures in this process and prints JSON. */
int bench_probe_print(const bench_options *options, image_error *error);
/* In a process of its own, for what is decided once a process: how many threads
 * PoCL uses, and which kernels are loaded. */
int bench_probe_run(const bench_options *options, uint32_t width,
                    uint32_t height, int single_thread, bench_probe *out,
                    image_error *error);

/* --- scaling.c: how time and memory grow --- */

enum {
  BENCH_SIZES = 5,
  BENCH_SAMPLINGS = 5,
  BENCH_ROUNDS = 5,                    /* of processes */
  BENCH_REASON = IMAGE_ERROR_SIZE + 16 /* longest reason, with its end */
};

typedef struct bench_size {
  uint32_t width, height;
  char skipped[BENCH_REASON]; /* why, or empty */
  bench_timing timing;
  bench_memory memory;
} bench_size;

typedef struct bench_sampling {
  cl_uint samples;
  bench_timing timing;
} bench_sampling;

typedef struct bench_threads {
  char left_out[BENCH_REASON];      /* why, or empty */
  unsigned count;                   /* as many as there are */
  bench_spread total[2], gather[2]; /* with one, with all */
  double total_gain, gather_gain;   /* medians over the rounds */
} bench_threads;

typedef struct bench_opening {
  char left_out[BENCH_REASON]; /* why, or empty */
  bench_spread plan, frame[BENCH_START_FRAMES];
  bench_spread extra; /* first frame less the second */
} bench_opening;

typedef struct bench_scaling {
  char label[BENCH_LABEL]; /* of what is measured */
  unsigned runs, rounds;   /* rounds: of processes */
  size_t base;             /* the size that the others are told by */
  bench_size size[BENCH_SIZES];
  bench_sampling sampling[BENCH_SAMPLINGS];
  bench_planes planes;
  bench_threads threads;
  bench_opening opening;
} bench_scaling;

int bench_scaling_measure(const bench_options *options, const device *d,
                          bench_scaling *out, image_error *error);

/* Nanoseconds a pixel. */
double bench_size_cost(const bench_size *size, double milliseconds);
/* Cost a pixel over that of the base. */
double bench_size_ratio(const bench_scaling *scaling, const bench_size *size,
                        double ratio);
/* Cost a sample over that of the fewest. */
double bench_sampling_ratio(const bench_scaling *scaling,
                            const bench_sampling *sampling);

/* --- skips.c: work that is left out --- */

enum { BENCH_SKIPS = 9 };

typedef struct bench_skip {
  const char *name;
  double frame_aim, gather_aim; /* times the full frame's at most, or NAN */
  bench_timing full, timing;    /* in turns */
} bench_skip;

int bench_skips_measure(const bench_options *options, const device *d,
                        const bench_content *content, bench_skip *out,
                        image_error *error);

/* --- against.c: two sets of kernels --- */

enum { BENCH_AGAINST = 5 };

typedef struct bench_against {
  bench_configuration configuration;
  int follows;              /* motion vectors */
  bench_timing theirs, own; /* in turns */
} bench_against;

int bench_against_measure(const bench_options *options, const device *d,
                          const bench_content *content, bench_against *out,
                          image_error *error);

/* --- temporal.c: means over frames --- */

enum {
  BENCH_TEMPORALS = 2, /* settings */
  BENCH_TEMPORAL_LENGTHS = 5,
  BENCH_TEMPORAL_MOST = 16
};

typedef struct bench_deviation {
  double ao, light;
} bench_deviation;

typedef struct bench_temporal {
  char label[BENCH_LABEL];
  /* by how many frames are averaged; followed: by motion vectors */
  bench_deviation still[BENCH_TEMPORAL_LENGTHS];
  bench_deviation moving[BENCH_TEMPORAL_LENGTHS];
  bench_deviation followed[BENCH_TEMPORAL_LENGTHS];
  bench_spread pass; /* milliseconds */
  double share;      /* of the frame's time */
} bench_temporal;

/* content: the last of options->frames. */
int bench_temporal_measure(const bench_options *options, const device *d,
                           const bench_content *content, int slices,
                           bench_temporal *out, image_error *error);

/* --- promises.c: adaptive sampling over scenes --- */

enum {
  BENCH_WAYS = 2, /* each frame chooses; one in CHOOSE_EVERY does */
  /* Choosing looks at as many pixels whatever the picture's size: what it is a
   * pixel is told for the frames as they are, and for larger ones. */
  BENCH_OWN_SIZE = 0,
  BENCH_ROOM_SIZE, /* 1280x720 */
  BENCH_CASE_SIZES
};

typedef struct bench_scene {
  char *name; /* folder of its frames */
  unsigned frames;
} bench_scene;

typedef struct bench_case {
  const char *path; /* NULL: the room */
  size_t scene;
  unsigned index; /* in the scene */
  double pixels;
  bench_row *rows;
} bench_case;

/* What a scene's frames are gathered with. */
typedef struct bench_taken {
  unsigned frames, beyond;   /* beyond: off by more than the limit */
  cl_uint least[2], most[2]; /* slices, samples */
  double worst;              /* of the frames: what 95 % are within */
} bench_taken;

typedef struct bench_way {
  /* nanoseconds a pixel, means over the scenes */
  double gather, choosing[BENCH_CASE_SIZES];
  size_t beyond;      /* frames */
  bench_taken *taken; /* of each scene */
} bench_way;

typedef struct bench_promise {
  bench_configuration limit;
  bench_way way[BENCH_WAYS];
  bench_configuration uniform; /* fastest within the limit in all frames */
  double uniform_cost;         /* nanoseconds a pixel; NAN: there is none */
} bench_promise;

typedef struct bench_promises {
  bench_scene *scene;
  bench_case *frame;
  bench_row *rows;
  size_t scene_count, frame_count, row_count; /* rows of a frame */
  size_t count;                               /* of promises */
  bench_promise promise[BENCH_MAX_CONFIGURATIONS];
} bench_promises;

/* Of options->frames, or of the room.  To be freed, also after a failure. */
int bench_promises_measure(const bench_options *options, const device *d,
                           int slices, bench_promises *out, image_error *error);
void bench_promises_free(bench_promises *p);
/* Time with choosing over the uniform setting's. */
double bench_way_ratio(const bench_promise *p, int way, int size);

/* --- reports --- */

typedef struct bench_machine {
  char device[256], platform[256], version[256], driver[256];
  cl_uint units;
} bench_machine;

typedef struct bench_report {
  bench_machine machine;
  const bench_content *content;
  unsigned runs;
  int exact_slices;
  bench_copy copy;
  bench_literal literal;
  const bench_row *rows;
  size_t count;
  double estimate;        /* milliseconds of the estimate of unseen light */
  bench_spread motion;    /* of reprojection by motion vectors */
  bench_timing halves[2]; /* the first configuration, see bench_lab_halves() */
  const bench_scaling *scaling;
  const bench_skip *skips;
  const bench_against *against;
  const bench_temporal *temporal;
  const bench_promises *promises;
} bench_report;

/* What errors are measured against: "exact integral, 128 slices". */
void bench_reference(const bench_report *report, char *text, size_t size);
/* What the reference is and what a user should know, in one sentence each. */
void bench_notes(const bench_report *report, FILE *out, const char *before,
                 const char *after);

/* What all tables begin with. */
void bench_print_machine(const bench_machine *m, FILE *out);
/* In quotes, which are doubled inside. */
void bench_write_quoted(FILE *out, const char *text);
/* Device, compute units, driver, version; a comma before each. */
void bench_write_machine(FILE *out, const bench_machine *machine);
/* Behind a comma; empty where there is none. */
void bench_write_number(FILE *out, double value);
void bench_write_spread(FILE *out, bench_spread s);

void bench_write_table(const bench_report *report, FILE *out);
void bench_write_csv(const bench_report *report, FILE *out);
void bench_write_json(const bench_report *report, FILE *out);
void bench_write_svg(const bench_report *report, FILE *out);
/* scaling_report.c: only report->scaling and the machine. */
void bench_write_scaling_table(const bench_report *report, FILE *out);
void bench_write_scaling_csv(const bench_report *report, FILE *out);
void bench_write_scaling_json(const bench_report *report, FILE *out);

/* skips.c, json.c: only report->skips, runs, content and the machine. */
void bench_write_skips_table(const bench_report *report, FILE *out);
void bench_write_skips_json(const bench_report *report, FILE *out);

/* against.c: only report->against, runs, content and the machine. */
void bench_write_against_table(const bench_report *report, FILE *out);

/* temporal.c: only report->temporal, content and the machine. */
void bench_write_temporal_table(const bench_report *report, FILE *out);
void bench_write_temporal_json(const bench_report *report, FILE *out);

/* promises.c, json.c: only report->promises, runs, exact_slices and the
 * machine. */
void bench_write_promises_table(const bench_report *report, FILE *out);
void bench_write_promises_json(const bench_report *report, FILE *out);

/* --- picture.c --- */

/* FOLDER/bench.png from FOLDER/bench.svg by rsvg-convert.  *made: 0 where the
 * program is missing or fails, which is no error. */
int bench_write_png(const char *folder, int *made, image_error *error);

#endif
