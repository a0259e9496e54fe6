/*
 * The main job: a sequence of captured frames in, layers of light out.
 *
 * Everything that can be known to be wrong is looked for before the first
 * pixel is read: all headers, all cameras, the output folder, the device.
 */
#define _POSIX_C_SOURCE 200809L
#include "tool/exact.h"
#include "tool/resume.h"
#include "tool/tool.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* One frame of the job. */
typedef struct job {
  const char *path;
  char *stem; /* DIR/NAME, without .exr */
  channel_map map;
  view view;
  camera_file camera; /* of the pixels that are lit */
  uint64_t key;       /* resume.h; 0: not known yet */
  int finished;       /* its result is there */
} job;

typedef struct process {
  const process_options *options;
  hbil_config config;
  unsigned layers;
  float environment[9][3];
  job *jobs;
  timing_row *rows;
  int count;
  image_window window;    /* pixels that are lit: all that any frame has */
  image_window shown;     /* pixels that are written */
  uint32_t width, height; /* of window */
  int folder_created;
  device device;
  sequence *sequence; /* one of both */
  exact_sequence *exact;
  float exposure;
  uint64_t settings;  /* the key before the first frame */
  resume_light light; /* what frames hand on */
  int first, end;     /* of the frames that are lit */
  int warned;         /* of what a frame's pixels show */
  image_error error;
} process;

const char *const process_modes[] = {"hbil", "gtao", "hbao", NULL};
const char *const process_falloffs[] = {"linear", "soft", "none", NULL};

/*
 * Where a picture is worth more than a millisecond the tool departs from the
 * library's defaults, which are the paper's: occluders end 8 % of their depth
 * behind their front, all light that is seen counts, and what is not seen is
 * estimated.  Chosen on the four public scenes (HACKING.md).
 */
void process_set_model(hbil_config *config) {
  config->relative_thickness = 0.08f;
  config->facing[0] = config->facing[1] = -1.0f;
  config->refused = HBIL_REFUSED_FRAME;
  config->samples = 48;
}

void process_options_init(process_options *options) {
  memset(options, 0, sizeof *options);
  hbil_config_init(&options->config);
  source_options_init(&options->source);
  options->repeat = 1;
  /* three bounces before the first picture: the fourth adds a few per cent */
  options->warm_up = 3;
  /* unless the first frame shows otherwise (policy.c) */
  options->config.gather_emission = CL_FALSE;
  process_set_model(&options->config);
}

/* ------------------------------------------------------------------------ */
/* Names                                                                     */

/* The three, one after the other; malloc'd. */
static char *join(const char *a, const char *between, const char *b) {
  const size_t size = strlen(a) + strlen(between) + strlen(b) + 1;
  char *text = malloc(size);
  if (text)
    snprintf(text, size, "%s%s%s", a, between, b);
  return text;
}

static char *result_stem(const char *folder, const char *frame) {
  const char *slash = strrchr(frame, '/');
  char *stem = join(folder, "/", slash ? slash + 1 : frame);
  if (stem) {
    char *dot = strrchr(stem, '.');
    if (dot && dot > strrchr(stem, '/') + 1)
      *dot = '\0';
  }
  return stem;
}

/* ------------------------------------------------------------------------ */
/* Before any work                                                           */

/* Every frame must have what the first has: the kernels are built for it. */
static int check_roles(process *p, const job *j) {
  for (int r = 0; r < ROLE_COUNT; r++)
    if (p->jobs[0].map.count[r] && !j->map.count[r] && r != ROLE_POSITION)
      return image_fail(&p->error,
                        "%s: has no %s, which %s has; the same channels in "
                        "every frame are needed",
                        j->path, role_name((role)r), p->jobs[0].path);
  if (p->config.reprojection == HBIL_REPROJECTION_MOTION &&
      !j->map.count[ROLE_MOTION])
    return image_fail(&p->error,
                      "%s: has no motion vectors; Vector.{X,Y} (Blender's "
                      "Vector pass), motion.{X,Y} or another --reprojection "
                      "is needed",
                      j->path);
  const float *scale = j->map.how.motion_scale;
  if (p->config.reprojection == HBIL_REPROJECTION_MOTION && scale[0] == 0.0f &&
      scale[1] == 0.0f)
    return image_fail(&p->error,
                      "%s: how many pixels a unit of its motion is isn't "
                      "known of %s; --motion-scale X,Y is needed",
                      j->path, dump_kind_name(j->map.kind));
  return 0;
}

/* Frames may have pixels in different places of the same picture. */
static int check_size(process *p, const job *j) {
  const image_window *first = &p->jobs[0].map.display, *own = &j->map.display;
  if (j == p->jobs)
    p->window = j->map.data;
  p->window = image_window_union(p->window, j->map.data);
  if (own->width != first->width || own->height != first->height)
    return image_fail(&p->error,
                      "%s: %u x %u pixels, but %s has %u x %u; frames of one "
                      "size are needed",
                      j->path, own->width, own->height, p->jobs[0].path,
                      first->width, first->height);
  return 0;
}

static int check_header(process *p, job *j) {
  const process_options *o = p->options;
  image header;
  if (image_read_header(j->path, &header, &p->error) != 0)
    return -1;
  const int failed =
      channels_map(j->path, &header, &o->source, &j->map, &p->error) != 0 ||
      channels_check(&j->map, j->path, &p->error) != 0 ||
      check_roles(p, j) != 0 ||
      view_read(j->path, &header, o->camera, &o->source, &j->view, &p->error) !=
          0 ||
      check_size(p, j) != 0;
  image_free(&header);
  return failed ? -1 : 0;
}

/* Once it is known which pixels are lit: pixels beyond the picture's edges
 * help those inside, and aren't written. */
static int aim(process *p) {
  p->width = p->window.width;
  p->height = p->window.height;
  p->shown = image_window_common(p->window, p->jobs[0].map.display);
  if (!p->shown.width)
    return image_fail(&p->error,
                      "%s: none of its pixels lie in its display window; a "
                      "data window that overlaps it is needed",
                      p->jobs[0].path);
  for (job *j = p->jobs; j < p->jobs + p->count; j++) {
    j->map.window = p->window;
    if (view_aim(j->path, &j->view, &j->map, &j->camera, &p->error) != 0)
      return -1;
  }
  return 0;
}

static void note(const char *path, const char *kind, const char *what) {
  fputs("hbil: ", stderr);
  tool_show(path, stderr);
  fprintf(stderr, ": %s%s\n", kind, what);
}

/* What the first frame shows goes for all. */
static int settle(process *p) {
  selfcheck found;
  if (selfcheck_settle(p->jobs[0].path, &p->jobs[0].map, &found, &p->error) !=
      0)
    return -1;
  for (int i = 0; !p->options->quiet && i < found.count; i++)
    note(p->jobs[0].path, "", found.text[i]);
  for (job *j = p->jobs + 1; j < p->jobs + p->count; j++) {
    const double near = j->map.how.near, far = j->map.how.far;
    j->map.how = p->jobs[0].map.how;
    j->map.how.near = near;
    j->map.how.far = far;
  }
  return 0;
}

static int same_file(const char *a, const char *b) {
  struct stat one, other;
  return stat(a, &one) == 0 && stat(b, &other) == 0 &&
         one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

/* No result may take the place of an input or of another result. */
static int check_name(process *p, job *j) {
  j->stem = result_stem(p->options->output, j->path);
  char *result = j->stem ? join(j->stem, "", ".exr") : NULL;
  if (!result)
    return image_no_memory(&p->error, j->path);
  int failed = 0;
  for (int i = 0; i < p->count && !failed; i++)
    if (same_file(p->jobs[i].path, result))
      failed = image_fail(&p->error,
                          "%s: its result would overwrite %s; another output "
                          "folder is needed",
                          j->path, p->jobs[i].path);
  for (const job *before = p->jobs; before < j && !failed; before++)
    if (strcmp(before->stem, j->stem) == 0)
      failed = image_fail(&p->error,
                          "%s: its result would overwrite that of %s; "
                          "different file names are needed",
                          j->path, before->path);
  free(result);
  return failed;
}

static void warn(const char *path, const char *what) {
  note(path, "warning: ", what);
}

/* Not an error: occlusion and bent cones need no light. */
static void warn_of_darkness(const process *p) {
  const channel_map *map = &p->jobs[0].map;
  if (!p->options->quiet && p->config.mode == HBIL_MODE_HBIL &&
      !map->count[ROLE_DIRECT] && !map->count[ROLE_EMISSION])
    warn(p->jobs[0].path, "no direct light and no emission; near light will be "
                          "black");
}

static int check_jobs(process *p, char *const *files) {
  for (int i = 0; i < p->count; i++)
    p->jobs[i].path = files[i];
  for (int i = 0; i < p->count; i++)
    if (check_header(p, &p->jobs[i]) != 0 || check_name(p, &p->jobs[i]) != 0)
      return -1;
  warn_of_darkness(p);
  return aim(p) != 0 || settle(p) != 0 ? -1 : 0;
}

/* Writes a file and takes it away again: asking for permissions would miss
 * read-only and special file systems. */
static int probe_folder(process *p) {
  char name[48];
  snprintf(name, sizeof name, "/.hbil-probe%ld", (long)getpid());
  char *probe = join(p->options->output, "", name);
  if (!probe)
    return image_no_memory(&p->error, p->options->output);
  const int fd = open(probe, O_WRONLY | O_CREAT | O_EXCL, 0600);
  const int why = errno;
  if (fd >= 0) {
    close(fd);
    unlink(probe);
  }
  free(probe);
  if (fd >= 0)
    return 0;
  return image_fail(&p->error,
                    "%s: output folder cannot be written: %s; a folder in "
                    "which you may write is needed",
                    p->options->output, strerror(why));
}

static int prepare_folder(process *p) {
  p->folder_created = mkdir(p->options->output, 0777) == 0;
  if (!p->folder_created && errno != EEXIST)
    return image_fail(&p->error,
                      "%s: output folder cannot be created: %s; a folder that "
                      "exists, or whose parent does, is needed",
                      p->options->output, strerror(errno));
  return probe_folder(p);
}

static int check_environment(process *p) {
  const float *values = &p->environment[0][0];
  for (size_t i = 0; i < sizeof p->environment / sizeof *values; i++)
    if (!isfinite(values[i]))
      return image_fail(&p->error,
                        "--environment %s: not finite; finite radiance is "
                        "needed",
                        p->options->environment);
  return 0;
}

/* A latitude-longitude map, as spherical harmonics. */
static int load_map(process *p) {
  const char *path = p->options->environment;
  float *rgb = NULL;
  uint32_t width, height;
  if (formats_read_rgb(path, &rgb, &width, &height, &p->error) != 0)
    return -1;
  const hbil_status status = hbil_environment_from_latlong(
      rgb, width, height, 0, NULL, p->environment);
  free(rgb);
  if (status != HBIL_SUCCESS)
    return image_fail(&p->error, "%s: %s", path, hbil_status_string(status));
  p->config.far_field = HBIL_FAR_SH;
  return 0;
}

static const char *mode_name(const process *p) {
  return process_modes[p->config.mode];
}

/* Far light that the mode has no means for. */
static int check_far_field(process *p) {
  const hbil_mode mode = p->config.mode;
  const hbil_far_field far = p->config.far_field;
  if (mode != HBIL_MODE_HBIL && far == HBIL_FAR_FRAME)
    return image_fail(&p->error,
                      "--environment frame: not with --mode %s, which looks at "
                      "no light; none or R,G,B is needed",
                      mode_name(p));
  if (mode == HBIL_MODE_HBAO && far == HBIL_FAR_SH)
    return image_fail(&p->error,
                      "--environment %s: a map is not possible with --mode "
                      "hbao, which has no bent cone; none or R,G,B is needed",
                      p->options->environment);
  return 0;
}

static int read_environment(process *p) {
  const char *text = p->options->environment;
  if (text && !strcmp(text, "frame")) {
    p->config.far_field = HBIL_FAR_FRAME;
    return 0;
  }
  float constant[3];
  if (!text || !strcmp(text, "none"))
    return 0;
  if (option_floats("", text, constant, 3, NULL) == 0) {
    memcpy(p->environment[0], constant, sizeof constant);
    p->config.far_field = HBIL_FAR_CONSTANT;
  } else if (load_map(p) != 0)
    return -1;
  return check_environment(p);
}

static int load_environment(process *p) {
  return read_environment(p) != 0 || check_far_field(p) != 0 ? -1 : 0;
}

/* All that the mode has, or what was asked for. */
static int choose_layers(process *p) {
  const unsigned possible = layers_of_mode(p->config.mode);
  const unsigned asked = p->options->layers;
  char cannot[64], can[64];
  p->layers = asked ? asked : possible;
  if ((p->layers & ~possible) == 0)
    return 0;
  layers_names(p->layers & ~possible, cannot, sizeof cannot);
  layers_names(possible, can, sizeof can);
  return image_fail(&p->error,
                    "--layers %s: not with --mode %s; some of %s are needed",
                    cannot, mode_name(p), can);
}

static void configure(process *p) {
  const channel_map *map = &p->jobs[0].map;
  channels_conventions(map, &p->config);
  p->config.width = p->width;
  p->config.height = p->height;
  p->config.bent_space = HBIL_SPACE_WORLD;
  p->config.profiling = p->options->timings ? CL_TRUE : CL_FALSE;
}

/* What the user left open, decided by what the first frame shows. */
static void decide(process *p, const gbuffer *first, const char **far,
                   const char **emission) {
  hbil_camera camera;
  gbuffer_hbil_camera(&p->jobs[0].camera, &camera);
  if (!p->options->environment)
    policy_far_field(first, &p->config, p->environment, far);
  if (!p->options->emission_given)
    policy_emission(first, &camera, &p->config, emission);
}

static int look_at_first(process *p, const char **far, const char **emission) {
  const job *first = p->jobs;
  gbuffer g;
  if (gbuffer_read(first->path, &first->map,
                   1u << ROLE_DEPTH | 1u << ROLE_NORMAL | 1u << ROLE_DIRECT |
                       1u << ROLE_EMISSION | 1u << ROLE_BACKGROUND,
                   &g, &p->error) != 0)
    return -1;
  decide(p, &g, far, emission);
  gbuffer_free(&g);
  return 0;
}

/* Settings that depend on what the dumps hold, and a line for each. */
static int choose_model(process *p) {
  const char *far = "none: this --mode looks at no light", *emission = NULL;
  if (p->config.mode == HBIL_MODE_HBIL &&
      !(p->options->environment && p->options->emission_given) &&
      look_at_first(p, &far, &emission) != 0)
    return -1;
  if (!p->options->quiet && !p->options->environment)
    fprintf(stderr, "hbil: light of unblocked directions: %s\n", far);
  if (!p->options->quiet && emission)
    fprintf(stderr, "hbil: emission: %s\n", emission);
  return 0;
}

/* Runs of all frames together. */
static unsigned count_runs(const process *p) {
  return (unsigned)p->count * p->options->repeat + p->options->warm_up;
}

static int open_exact(process *p) {
  const exact_work work = {.frames = (unsigned)p->count,
                           .runs = count_runs(p),
                           .quiet = p->options->quiet};
  if (exact_check(&p->config, &p->error) != 0 || choose_model(p) != 0)
    return -1;
  return exact_open(&p->config, &p->jobs[0].map, p->layers, &work, &p->exact,
                    &p->error);
}

static int open_library(process *p) {
  if (device_open(p->options->device, p->options->timings, &p->device,
                  &p->error) != 0 ||
      choose_model(p) != 0)
    return -1;
  return sequence_open(&p->device, &p->config, &p->jobs[0].map, p->layers,
                       &p->sequence, &p->error);
}

/* ------------------------------------------------------------------------ */
/* What is there already                                                     */

static int find_key(process *p, job *j) {
  if (j->key)
    return 0;
  j->key = j == p->jobs ? p->settings : j[-1].key;
  return resume_frame(j->path, &j->map, &j->camera, &j->key, &p->error);
}

static char *preview_path(const job *j, layer l) {
  char *stem = join(j->stem, ".", layer_table[l].name);
  char *path = stem ? join(stem, "", ".png") : NULL;
  free(stem);
  return path;
}

static int has_previews(const process *p, const job *j) {
  int all = 1;
  for (int l = 0; l < LAYER_COUNT && all; l++) {
    char *path = p->layers >> l & 1 ? preview_path(j, (layer)l) : NULL;
    all = !(p->layers >> l & 1) || (path && access(path, F_OK) == 0);
    free(path);
  }
  return all;
}

static int look_for_result(process *p, job *j) {
  char *path = join(j->stem, "", ".exr");
  if (!path)
    return image_no_memory(&p->error, j->path);
  const int failed = find_key(p, j);
  j->finished = !failed && resume_is_finished(path, j->key) &&
                (!p->options->preview || has_previews(p, j));
  free(path);
  return failed;
}

/* Light that was saved behind a frame up to which nothing is missing. */
static int give_light(process *p, int missing) {
  int from = missing - 1;
  if (!p->light.size || !resume_load(p->options->output, &p->light))
    return 0;
  while (from >= 0 && p->jobs[from].key != p->light.key)
    from--;
  if (from < 0)
    return 0;
  const camera_file *camera = &p->jobs[from].camera;
  p->first = from + 1;
  p->exposure = p->light.exposure;
  if (!p->exact)
    return sequence_give_light(p->sequence, camera, p->environment,
                               p->light.bytes, &p->error);
  exact_give_light(p->exact, camera, p->light.bytes);
  return 0;
}

/* Whether a frame must be lit though its result may be there: for those that
 * come after it, and for the exposure of their previews. */
static int is_needed(const process *p, const job *j) {
  const int i = (int)(j - p->jobs);
  return !j->finished || (i >= p->first && i < p->end &&
                          (p->light.size || (p->options->preview && i == 0)));
}

static void expect(process *p) {
  unsigned frames = 0, runs = 0;
  for (int i = p->first; i < p->end; i++)
    if (is_needed(p, &p->jobs[i])) {
      frames++;
      runs += p->options->repeat + (i == 0 ? p->options->warm_up : 0);
    }
  exact_expect(p->exact, frames, runs);
}

/* Leaves out what need not be done again. */
static int resume(process *p) {
  int missing = p->count;
  resume_sweep(p->options->output);
  p->end = 0;
  for (int i = 0; i < p->count; i++) {
    if (look_for_result(p, &p->jobs[i]) != 0)
      return -1;
    if (p->jobs[i].finished)
      continue;
    p->end = i + 1;
    missing = i < missing ? i : missing;
  }
  if (give_light(p, missing) != 0)
    return -1;
  if (p->exact)
    expect(p);
  return 0;
}

static int prepare_light(process *p) {
  char which[sizeof p->device.name + sizeof p->device.driver + 1];
  snprintf(which, sizeof which, "%s %s", p->device.name, p->device.driver);
  p->settings =
      resume_settings(p->options, &p->config, p->layers, p->environment, which);
  p->end = p->count;
  p->light.size =
      p->exact ? exact_light_size(p->exact) : sequence_light_size(p->sequence);
  p->light.bytes = p->light.size ? malloc(p->light.size) : NULL;
  if (p->light.size && !p->light.bytes)
    return image_no_memory(&p->error, p->jobs[0].path);
  return p->options->resume ? resume(p) : 0;
}

static int prepare(process *p, char *const *files) {
  if (!p->options->output)
    return image_fail(&p->error, "no output folder; -o DIR is needed");
  if (p->count < 1)
    return image_fail(&p->error, "no frame; one FRAME.exr or more is needed");
  p->jobs = calloc((size_t)p->count, sizeof *p->jobs);
  p->rows = calloc((size_t)p->count, sizeof *p->rows);
  if (!p->jobs || !p->rows)
    return image_no_memory(&p->error, files[0]);
  if (choose_layers(p) != 0 || check_jobs(p, files) != 0 ||
      load_environment(p) != 0 || prepare_folder(p) != 0)
    return -1;
  configure(p);
  if ((p->options->exact ? open_exact(p) : open_library(p)) != 0)
    return -1;
  return prepare_light(p);
}

/* ------------------------------------------------------------------------ */
/* The frames                                                                */

static int write_preview(process *p, const job *j, const image *result,
                         layer l) {
  char *path = preview_path(j, l);
  const int failed =
      path ? preview_write(path, result, l, p->exposure, &p->error)
           : image_no_memory(&p->error, j->path);
  free(path);
  return failed;
}

static int write_previews(process *p, const job *j, const image *result) {
  for (int l = 0; l < LAYER_COUNT; l++)
    if (p->layers >> l & 1 && write_preview(p, j, result, (layer)l) != 0)
      return -1;
  return 0;
}

/* "[3/8] DIR/frame.exr" */
static void tell(const process *p, const job *j, const char *path) {
  if (p->options->quiet)
    return;
  fprintf(stderr, "[%d/%d] ", (int)(j - p->jobs) + 1, p->count);
  tool_show(path, stderr);
  fputs(j->finished ? " is there already\n" : "\n", stderr);
}

/* Writes it unless it is there. */
static int write_result(process *p, const job *j, image *result) {
  char *path = join(j->stem, "", ".exr");
  if (!path)
    return image_no_memory(&p->error, j->path);
  resume_sign(result, j->key);
  const int failed = j->finished ? 0 : exr_write(path, result, NULL, &p->error);
  if (!failed)
    tell(p, j, path);
  free(path);
  return failed;
}

/* For the frames that are left, should this process not live to do them. */
static int save_light(process *p, const job *j) {
  if (!p->light.size || j + 1 >= p->jobs + p->end)
    return 0;
  p->light.key = j->key;
  p->light.exposure = p->exposure;
  if (p->exact)
    exact_take_light(p->exact, p->light.bytes);
  else if (sequence_take_light(p->sequence, p->light.bytes, &p->error) != 0)
    return -1;
  return resume_save(p->options->output, &p->light, &p->error);
}

/* Through the library or without it. */
static int light_planes(process *p, const job *j, const gbuffer *g,
                        image *result) {
  timing_row *row = &p->rows[j - p->jobs];
  const unsigned runs =
      p->options->repeat + (j == p->jobs ? p->options->warm_up : 0);
  row->frame = j->path;
  if (!p->exact)
    return sequence_run(p->sequence, g, &j->camera, p->environment, runs,
                        result, row, &p->error);
  exact_run(p->exact, g, &j->camera, p->environment, runs, result);
  return 0;
}

/* The same pixels of a smaller window; its planes are new ones. */
static int crop(const process *p, const image *whole, image *out) {
  const image_window *to = &p->shown;
  *out = (image){.width = to->width, .height = to->height};
  for (size_t i = 0; i < whole->count; i++) {
    const image_plane *plane = image_add(out, whole->planes[i].name);
    if (!plane) {
      image_free(out);
      return -1;
    }
    image_place(whole->planes[i].pixels, p->window, plane->pixels, *to);
  }
  return 0;
}

/* Bent normals go back into the world that the dump's header has. */
static void mirror_bent(image *result) {
  float *z = layers_plane(result, LAYER_BENT, 2);
  for (size_t i = 0; z && i < (size_t)result->width * result->height; i++)
    z[i] = -z[i];
}

/* Told for the first frame that has any; the others are alike. */
static void look_for_mistakes(process *p, const job *j, const gbuffer *g) {
  selfcheck found;
  if (p->options->quiet || p->warned)
    return;
  selfcheck_frame(g, &p->config, &j->map.camera, &found);
  for (int i = 0; i < found.count; i++)
    warn(j->path, found.text[i]);
  p->warned = found.count > 0;
}

static int light_frame(process *p, const job *j, image *result) {
  enum {
    USED = 1 << ROLE_DEPTH | 1 << ROLE_NORMAL | 1 << ROLE_ALBEDO |
           1 << ROLE_DIRECT | 1 << ROLE_EMISSION | 1 << ROLE_BACKGROUND
  };
  const int moved = p->config.reprojection == HBIL_REPROJECTION_MOTION;
  gbuffer g;
  if (gbuffer_read(j->path, &j->map, USED | (moved ? 1u << ROLE_MOTION : 0u),
                   &g, &p->error) != 0)
    return -1;
  look_for_mistakes(p, j, &g);
  const int failed = light_planes(p, j, &g, result);
  gbuffer_free(&g);
  if (!failed && j->view.mirrored)
    mirror_bent(result);
  return failed;
}

/* What comes of a frame that is lit. */
static int write_frame(process *p, const job *j, image *result) {
  result->x = p->shown.x;
  result->y = p->shown.y;
  result->display = p->jobs[0].map.display;
  if (j == p->jobs && p->options->preview)
    p->exposure = preview_exposure(result);
  if (p->options->preview && !j->finished && write_previews(p, j, result) != 0)
    return -1;
  return write_result(p, j, result);
}

static int run_frame(process *p, job *j, image *result) {
  if (find_key(p, j) != 0)
    return -1;
  if (!is_needed(p, j))
    return write_result(p, j, result);
  if (light_frame(p, j, result) != 0)
    return -1;
  image seen = *result;
  const int whole = p->shown.width == p->width && p->shown.height == p->height;
  if (!whole && crop(p, result, &seen) != 0)
    return image_no_memory(&p->error, j->path);
  const int failed = write_frame(p, j, &seen);
  if (!whole)
    image_free(&seen);
  return failed ? -1 : save_light(p, j);
}

static int run_frames(process *p) {
  image result;
  int failed = 0;
  if (layers_image(p->layers, p->width, p->height, &result) != 0)
    return image_no_memory(&p->error, p->jobs[0].path);
  for (int i = 0; i < p->count && !failed; i++)
    failed = run_frame(p, &p->jobs[i], &result);
  image_free(&result);
  if (!failed && p->light.size)
    resume_done(p->options->output);
  return failed;
}

static int print_timings(process *p) {
  if (!p->options->timings)
    return 0;
  const timing_report report = {
      .device = p->device.name,
      .width = p->width,
      .height = p->height,
      .repeat = p->options->repeat,
      .memory = sequence_memory(p->sequence),
      .rows = p->rows,
      .count = (size_t)p->count,
  };
  if (p->options->json)
    return timings_json(&report, &p->error);
  timings_table(&report);
  return 0;
}

static void release(process *p) {
  sequence_close(p->sequence);
  exact_close(p->exact);
  device_close(&p->device);
  for (int i = 0; p->jobs && i < p->count; i++) {
    free(p->jobs[i].stem);
    channels_free(&p->jobs[i].map);
  }
  free(p->jobs);
  free(p->rows);
  free(p->light.bytes);
}

int process_run(const process_options *options, char *const *files, int count) {
  process p = {.options = options, .config = options->config, .count = count};
  const int failed =
      prepare(&p, files) != 0 || run_frames(&p) != 0 || print_timings(&p) != 0;
  if (failed && p.folder_created)
    rmdir(options->output); /* succeeds only while nothing is in it */
  release(&p);
  return failed ? tool_report(&p.error) : TOOL_OK;
}
