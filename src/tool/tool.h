/*
 * The program `hbil`: what its files share.  It uses the library through
 * hbil.h only, and files through image.h only.
 *
 * Functions that can fail return 0, or fill an image_error with one sentence.
 */
#ifndef HBIL_TOOL_H
#define HBIL_TOOL_H

#include <jansson.h>
#include <stdio.h>

#include "hbil/hbil.h"
#include "image/image.h"

/* Exit statuses. */
enum { TOOL_OK = 0, TOOL_DIFFERS = 1, TOOL_BAD_INPUT = 2 };

/* Sub-commands; argv[0] is the command's own name. */
int cmd_process(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_compare(int argc, char **argv);
int cmd_devices(int argc, char **argv);
int cmd_demo(int argc, char **argv);

/* "hbil: TEXT" as one line on standard error; returns TOOL_BAD_INPUT. */
int tool_report(const image_error *error);

/* Names come from outside: control characters, and what isn't UTF-8, are
 * written as \n and \xNN, so that a line stays one.  Returns how many columns
 * it took. */
int tool_show(const char *text, FILE *out);

/* --- options.c: reading what stands on the command line --- */

struct option;

/*
 * getopt_long() with the tool's own messages.  Every command has --help, which
 * the caller gives the value 'h'.  An option that is unknown or lacks its value
 * fills error and gives '?'; the end gives -1.
 */
int option_next(int argc, char **argv, const char *letters,
                const struct option *options, image_error *error);

/* Exactly count numbers, separated by commas; "inf" is one, "nan" and what is
 * too large for a float are not. */
int option_floats(const char *option, const char *text, float *out,
                  size_t count, image_error *error);
int option_unsigned(const char *option, const char *text, unsigned low,
                    unsigned high, unsigned *out, image_error *error);
/* WIDTHxHEIGHT, as large as a frame may be. */
int option_size(const char *option, const char *text, unsigned *width,
                unsigned *height, image_error *error);
/* The place of text in a NULL-terminated list of words. */
int option_choice(const char *option, const char *text,
                  const char *const *words, int *out, image_error *error);

/* --- frames.c: which files a sequence has --- */

typedef struct frame_list {
  char **files;
  size_t count;
} frame_list;

/*
 * Files as they are, and patterns with %d, %04d or #### in their names: those
 * numbers of `ranges` ("1-240x2,300"), or, where that is NULL, all that are
 * there.  Missing frames are refused, and named.
 */
int frames_list(char *const *arguments, int count, const char *ranges,
                frame_list *out, image_error *error);
void frames_free(frame_list *list);

/* --- sources.c: whose dump it is, and what its channels mean --- */

/* In the order of --source's words. */
typedef enum dump_kind {
  DUMP_PLAIN = 0, /* "generic": names that speak, hbil's own conventions */
  DUMP_CYCLES,    /* Blender's pass names and conventions */
  DUMP_PBRT,
  DUMP_MITSUBA,
  DUMP_ARNOLD,
  DUMP_VRAY,
  DUMP_RENDERMAN,
  DUMP_UNREAL,
  DUMP_KINDS
} dump_kind;

typedef enum role {
  ROLE_DEPTH = 0,
  ROLE_NORMAL,
  ROLE_ALBEDO,
  ROLE_DIRECT,
  ROLE_EMISSION,
  ROLE_BACKGROUND, /* radiance of the sky, where it is a pass of its own */
  ROLE_MOTION,
  ROLE_POSITION,
  ROLE_COUNT
} role;

enum { ROLE_CHANNELS = 3 };

typedef enum depth_kind {
  DEPTH_PLANAR = 0, /* along the camera's axis */
  DEPTH_RAY,        /* distance from the eye */
  DEPTH_POSITION,   /* taken from positions */
  DEPTH_DEVICE,     /* 0 at the near plane, 1 at the far one */
  DEPTH_REVERSED    /* 1 at the near plane, 0 at the far one */
} depth_kind;

/* Camera space is OpenGL's, y up and z backwards; what runs otherwise is
 * flipped. */
typedef enum dump_space { SPACE_WORLD = 0, SPACE_CAMERA } dump_space;

typedef enum direct_kind {
  DIRECT_IRRADIANCE = 0,
  DIRECT_LIGHT,   /* irradiance / pi: radiance of a white surface */
  DIRECT_RADIANCE /* with the albedo in it */
} direct_kind;

/* What names don't tell for sure, and the pixels of a first frame may. */
enum {
  UNSURE_DEPTH = 1,   /* planar or along the ray */
  UNSURE_NORMALS = 2, /* encoded, or in which space */
  UNSURE_SKY = 4      /* the depth where there is nothing */
};

typedef struct conventions {
  depth_kind depth;
  dump_space normals, positions;
  direct_kind direct;
  int backwards; /* depth counts backwards from 0 */
  int from_near; /* distances along the ray begin at the near plane */
  int encoded;   /* normals are stored as (n + 1) / 2 */
  unsigned
      flips; /* axes of normals and positions to be turned: 1 x, 2 y, 4 z */
  unsigned unsure;
  float background;                   /* depths from here on are sky */
  float motion_scale[2], motion_zero; /* of (value - zero), to pixels */
  double unit;      /* of depths and positions, in units of the camera */
  double near, far; /* clipping planes, for DEPTH_DEVICE; 0: not known */
} conventions;

typedef struct pass_name {
  role role;
  const char *pass; /* "": the file's own channels; "*.T": any pass's T */
} pass_name;

typedef struct source_info {
  const char *word, *about;
  const pass_name *passes;  /* best first */
  const char *const *marks; /* parts of names that nobody else has */
  conventions how;
} source_info;

extern const source_info source_table[DUMP_KINDS];

/* The words of an option's values, as in option_choice(). */
extern const char *const source_words[], *const depth_words[];

/* What the user says about the source; see source_options_init(). */
typedef struct source_options {
  int source, depth, normals, encoded, positions, direct,
      gamma; /* -1: not said */
  const char *map;
  unsigned flips;
  float fov, orthographic; /* 0: not said; the latter: world units */
  float background;        /* NaN: not said */
  float unit, clip[2];     /* 0: not said; clip: by the far plane */
  float motion_scale[2];   /* 0: not said */
} source_options;

void source_options_init(source_options *options);
/* Rows of a getopt table, whose values source_option() takes. */
enum {
  SOURCE_OPTION = 512,
  SOURCE_MAP,
  SOURCE_DEPTH,
  SOURCE_NORMALS,
  SOURCE_POSITIONS,
  SOURCE_DIRECT,
  SOURCE_COLOURS,
  SOURCE_FLIP,
  SOURCE_UNIT,
  SOURCE_BACKGROUND,
  SOURCE_CLIP,
  SOURCE_FOV,
  SOURCE_ORTHOGRAPHIC,
  SOURCE_MOTION,
  SOURCE_END
};
#define SOURCE_OPTIONS                                                         \
  {"source", required_argument, NULL, SOURCE_OPTION},                          \
      {"map", required_argument, NULL, SOURCE_MAP},                            \
      {"depth", required_argument, NULL, SOURCE_DEPTH},                        \
      {"normals", required_argument, NULL, SOURCE_NORMALS},                    \
      {"positions", required_argument, NULL, SOURCE_POSITIONS},                \
      {"direct", required_argument, NULL, SOURCE_DIRECT},                      \
      {"colours", required_argument, NULL, SOURCE_COLOURS},                    \
      {"flip", required_argument, NULL, SOURCE_FLIP},                          \
      {"unit-scale", required_argument, NULL, SOURCE_UNIT},                    \
      {"background", required_argument, NULL, SOURCE_BACKGROUND},              \
      {"clip", required_argument, NULL, SOURCE_CLIP},                          \
      {"fov", required_argument, NULL, SOURCE_FOV},                            \
      {"orthographic", required_argument, NULL, SOURCE_ORTHOGRAPHIC}, {        \
    "motion-scale", required_argument, NULL, SOURCE_MOTION                     \
  }
int source_option(int option, const char *text, source_options *out,
                  image_error *error);
void source_usage(void);

/* --- channels.c: which channel is what --- */

/* How a frame is read: whose it is, where its planes are, what they mean. */
typedef struct channel_map {
  dump_kind kind;
  conventions how;
  size_t count[ROLE_COUNT]; /* channels of each role; 0: not in the file */
  char names[ROLE_COUNT][ROLE_CHANNELS][256];
  char *files[ROLE_COUNT]; /* where it is not the frame's own file; owned */
  int gamma[ROLE_COUNT];   /* the file's colours are sRGB */
  int is_beauty;           /* direct light is called as a finished picture is */
  hbil_camera camera;      /* for conversions; fx 0: not known */
  hbil_projection projection; /* of the camera */
  int mirrored;               /* z of world space is to be turned, see view */
  image_window data;          /* where the file has pixels */
  image_window display;       /* what is to be seen */
  image_window window;        /* what the planes are to cover; data at first */
} channel_map;

const char *role_name(role r);
const char *dump_kind_name(dump_kind kind);
/* As nothing but the kind tells. */
void channels_init(channel_map *out, dump_kind kind);
/* Guesses what is not said.  path: of the frame, whose header it is. */
int channels_map(const char *path, const image *header,
                 const source_options *options, channel_map *out,
                 image_error *error);
void channels_free(channel_map *map);
/* What cannot be done without: depth and normals. */
int channels_check(const channel_map *map, const char *path,
                   image_error *error);
/* Sets how inputs are read once they are planes of a gbuffer. */
void channels_conventions(const channel_map *map, hbil_config *config);

/* --- gbuffer.c: one captured frame on the host --- */

/* FRAME.json for FRAME.exr; malloc'd, NULL when out of memory. */
char *gbuffer_camera_name(const char *frame);

typedef struct gbuffer {
  channel_map map;
  image planes;
} gbuffer;

/* Reads the roles in the bit mask that the map has, and makes of them what
 * channels_conventions() says.  Where there is a background it is added to the
 * emission. */
int gbuffer_read(const char *path, const channel_map *map, unsigned roles,
                 gbuffer *out, image_error *error);
void gbuffer_free(gbuffer *g);
/* Channel i of a role, or NULL. */
const float *gbuffer_plane(const gbuffer *g, role r, size_t i);
/* Whether a depth is that of a surface, as the library takes it. */
int gbuffer_is_surface(float depth, float background);

/* Where a pixel looks, in view space: at planar depth z it sees from + z along.
 */
typedef struct gbuffer_ray {
  double from[3], along[3];
} gbuffer_ray;

gbuffer_ray gbuffer_look(hbil_projection projection, const hbil_camera *camera,
                         size_t x, size_t y);

/* --- convert.c: what the library doesn't take as it is --- */

/* Planes as they were read, whose map then has what came of them. */
int convert_planes(const char *path, gbuffer *g, image_error *error);
/* What each axis of vectors of that space is multiplied by. */
void convert_signs(const channel_map *map, dump_space space, float sign[3]);
/* Whether depth is taken as it is. */
int convert_is_straight(const conventions *how);

/* --- view.c: the camera of a frame --- */

typedef struct view {
  camera_file file; /* pixels are counted from the display window's corner */
  int mirrored;     /* its world's z was turned, to be right-handed */
  int placed;       /* where it stands is known */
  const char *from; /* what it was taken from */
} view;

/* The camera of a frame: `override`, the frame's name with .json, or what its
 * header tells; and --fov or --orthographic. */
int view_read(const char *frame, const image *header, const char *override,
              const source_options *options, view *out, image_error *error);
/* The camera as it counts pixels of the map's window, also for the map's own
 * conversions, which must be possible with it. */
int view_aim(const char *frame, const view *v, channel_map *map,
             camera_file *out, image_error *error);
void gbuffer_hbil_camera(const camera_file *file, hbil_camera *out);
/* A plan has one projection: that of `first`, whose frame is `of`. */
int view_same_projection(const char *frame, const camera_file *camera,
                         const char *of, const camera_file *first,
                         image_error *error);

/* --- selfcheck.c: does it fit together --- */

enum { SELFCHECK_FINDINGS = 12 };

/* What is likely wrong, and the option that puts it right. */
typedef struct selfcheck {
  double agreement; /* mean cosine of normals and the depth's own; NaN */
  double facing;    /* share of normals that face the eye */
  double positions; /* largest error of rebuilt positions, a share of their
                       distance, orthographic: of the picture's width; NaN */
  double low, high; /* depths along the axis */
  double surface;   /* share of the pixels */
  int count;
  char text[SELFCHECK_FINDINGS][256];
} selfcheck;

/* Decides by a first frame's pixels what its names left unsure; the decisions
 * are the findings. */
int selfcheck_settle(const char *path, channel_map *map, selfcheck *out,
                     image_error *error);
void selfcheck_frame(const gbuffer *g, const hbil_config *config,
                     const hbil_camera *camera, selfcheck *out);

/* --- policy.c: what to take for light that the screen doesn't show --- */

/* Chooses config->far_field by the first frame; *reason says why. */
void policy_far_field(const gbuffer *first, hbil_config *config,
                      float environment[9][3], const char **reason);
/* Chooses config->gather_emission: whether direct light holds already what the
 * lamps in the first frame send.  *reason is NULL where there are none. */
void policy_emission(const gbuffer *first, const hbil_camera *camera,
                     hbil_config *config, const char **reason);

/* --- layers.c: what is written --- */

typedef enum layer {
  LAYER_NEAR = 0,
  LAYER_FAR,
  LAYER_INDIRECT,
  LAYER_AO,
  LAYER_BENT,
  LAYER_CONE,
  LAYER_BEAUTY,
  LAYER_ERROR, /* only where it is asked for */
  LAYER_COUNT
} layer;

typedef struct layer_info {
  const char *name;
  const char *components; /* one letter for each channel */
  size_t format, image;   /* offsets in hbil_config and hbil_frame */
} layer_info;

extern const layer_info layer_table[LAYER_COUNT];

/* What a mode can compute. */
unsigned layers_of_mode(hbil_mode mode);
/* The same and those that are written only where they are asked for; exact:
 * with --quality reference. */
unsigned layers_possible(hbil_mode mode, int exact);
/* "AO, indirect" of a bit mask. */
void layers_names(unsigned layers, char *text, size_t size);
/* "AO,indirect" -> bit mask. */
int layers_parse(const char *text, unsigned *out, image_error *error);
/* A zeroed image with the planes of these layers, in the table's order. */
int layers_image(unsigned layers, uint32_t width, uint32_t height, image *out);
/* The plane of channel i of a layer, or NULL. */
float *layers_plane(const image *img, layer l, size_t i);

/* --- formats.c: what a job reads and writes --- */

typedef struct input_info {
  role role;
  size_t format, image; /* offsets in hbil_config and hbil_frame */
} input_info;

enum { INPUTS = 6 }; /* the last one is motion */
extern const input_info input_table[INPUTS];

/* Channels of an input that a job with these settings uses; 0: none. */
size_t formats_channels(const hbil_config *config, const channel_map *map,
                        int input);
/* Fills in the formats: everything is planes of floats. */
void formats_choose(hbil_config *config, const channel_map *map,
                    unsigned layers);

/* --- progress.c: how far a long job is --- */

typedef struct progress {
  const char *what;
  int quiet, terminal;
  int tenth;                     /* told last, not on a terminal */
  double start, expected, shown; /* seconds */
} progress;

/* Seconds since any time. */
double progress_clock(void);
/* "3 min 20 s". */
void progress_duration(double seconds, char *text, size_t size);
void progress_start(progress *p, const char *what, double expected, int quiet);
/* done: 0..1.  A line that is rewritten, or one every 10 %. */
void progress_show(progress *p, double done);
/* Frames: a bar with rate and time left, for a terminal. */
void progress_frames(progress *p, size_t done, size_t count);
/* Between these two standard error is the caller's, at the beginning of a line;
 * any thread may show its progress meanwhile, and waits. */
void progress_line_begin(void);
void progress_line_end(void);
/* Takes a line that is shown away. */
void progress_clear(void);
/* "WHAT: 3 of 8" as a line that counts up, on a terminal only. */
void progress_count(const char *what, size_t done, size_t count);

/* --- device.c --- */

typedef struct device {
  cl_device_id id;
  cl_context context;
  cl_command_queue queue;
  char name[256], driver[256];
} device;

/* wanted: an index of `hbil devices`, a part of the name, or NULL (the first
 * GPU, else the first device). */
int device_open(const char *wanted, int profiling, device *out,
                image_error *error);
void device_close(device *d);
/* Bytes of its global memory; 0 where it doesn't say. */
unsigned long long device_memory(cl_device_id id);
/* Lists all devices on standard output. */
int device_list(image_error *error);

/* --- sequence.c: frames through the library --- */

typedef struct sequence sequence;

/* config: settings; formats are filled in from map and layers.  With max_error
 * every so many runs it is chosen anew how many samples are taken. */
int sequence_open(const device *d, const hbil_config *config,
                  unsigned choose_every, const channel_map *map,
                  unsigned layers, sequence **out, image_error *error);
void sequence_close(sequence *s);
/* Device memory of the plan, bytes. */
size_t sequence_memory(const sequence *s);

/* What is known of a frame that has run. */
typedef struct timing_row {
  const char *frame;
  double milliseconds[HBIL_PASS_COUNT];
  hbil_statistics skipped;
  hbil_sanitized repaired;
} timing_row;

/* Runs a frame `repeat` times and reads the layers into result's planes.
 * row, but for its name, is filled (of the last run) if config.profiling is
 * set. Runs but the first of a frame, and a frame that is the last one again,
 * are still frames (hbil.h). */
int sequence_run(sequence *s, const gbuffer *g, uint64_t hash,
                 const camera_file *camera, float environment[9][3],
                 unsigned repeat, image *result, timing_row *row,
                 image_error *error);

/* The planes that sequence_run() uploads, as one number, by which it knows the
 * last frame again.  May be called by another thread meanwhile. */
uint64_t sequence_hash(const sequence *s, const gbuffer *g);

/* The light that the last frame hands on to the next, and the number of samples
 * that was chosen: bytes on this device with these settings, 0 where nothing is
 * carried.  Given back to another sequence of the same device and settings,
 * with the camera of that frame, the next frame comes out as it would have
 * here, bit by bit. */
size_t sequence_light_size(const sequence *s);
int sequence_take_light(sequence *s, void *bytes, image_error *error);
int sequence_give_light(sequence *s, const camera_file *camera,
                        float environment[9][3], void *bytes,
                        image_error *error);

/* --- preview.c: pictures for the eye --- */

/* One exposure for everything that is light, from one frame's layers. */
float preview_exposure(const image *result);
/* A layer as it is shown; 0, or -1 when out of memory. */
int preview_picture(const image *result, layer l, float exposure, picture *out);
int preview_write(const char *path, const image *result, layer l,
                  float exposure, image_error *error);
/* values: one per pixel, 0..limit from black over red to white, with a legend
 * below. */
int preview_heatmap(const char *path, const float *values, uint32_t width,
                    uint32_t height, float limit, image_error *error);

/* Warns that pictures have no labels. */
void preview_no_font(void);

/* --- timings.c --- */

typedef struct timing_report {
  const char *device;
  uint32_t width, height;
  unsigned repeat;
  size_t memory; /* bytes on the device */
  const timing_row *rows;
  size_t count;
  const double (*stages)[3]; /* seconds: decode, device, encode */
  double wall;               /* seconds for all frames */
  size_t lit;                /* frames that were not there already */
} timing_report;

/* One line without its end: how fast it was, and which stage kept the others
 * waiting. */
void timings_summary(const timing_report *report, FILE *out);
void timings_table(const timing_report *report);
int timings_json(const timing_report *report, image_error *error);
/* What a frame left out, in a line without its end; and as an object. */
void timings_print_skipped(const hbil_statistics *s, FILE *out);
json_t *timings_skipped_json(const hbil_statistics *s);

/* --- process.c: the main job --- */

enum { MOST_FORM_FACTORS = 1 << 20, FORM_FACTORS_AS_IT_FITS };

/* Runs of a sequence, of which one chooses how many samples the next ones, too,
 * are gathered with. */
enum { CHOOSE_EVERY = 4 };

typedef struct process_options {
  const char *output;        /* folder; must be given */
  const char *camera;        /* NULL: FRAME.json beside FRAME.exr */
  source_options source;     /* how frames are read */
  const char *environment;   /* "R,G,B", an image file, or NULL */
  const char *device;        /* see device_open() */
  const char *contact_sheet; /* a PNG of frames and layers, or NULL */
  unsigned layers;           /* bit mask; 0: all that the mode has */
  int emission_given;        /* config.gather_emission is the user's word */
  unsigned repeat;           /* runs of every frame, at least 1 */
  unsigned warm_up;          /* more runs of the first frame, for its bounces */
  unsigned choose_every;     /* runs, with config.max_error; 0: as it fits */
  unsigned horizon_cache_bytes;      /* MiB, or FORM_FACTORS_AS_IT_FITS */
  int preview, timings, json, quiet; /* flags */
  int resume;      /* results of the same settings and frames are kept */
  int overwrite;   /* results that are there are replaced; else refused */
  int keep;        /* the frames' own channels go into the results, too */
  int half;        /* layers are stored as half floats */
  int compression; /* of the results, a place in exr_compressions */
  int dry_run;     /* only tell what would be done */
  int exact;       /* the exact integral on the CPU in place of the library */
  hbil_config config; /* settings; formats and size are filled in */
} process_options;

/* All layers, no preview, the tool's model. */
void process_options_init(process_options *options);
/* What the tool takes for occluders and unseen light. */
void process_set_model(hbil_config *config);
/* Names on the command line, in the enums' order, ending with NULL. */
extern const char *const process_modes[];
extern const char *const process_falloffs[];

/* Runs the frames in order and writes the results; reports what goes wrong
 * itself.  Returns the exit status. */
int process_run(const process_options *options, char *const *files, int count);

#endif
