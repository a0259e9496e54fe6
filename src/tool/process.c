/*
 * The main job: a sequence of captured frames in, layers of light out.
 *
 * Everything that can be known to be wrong is looked for before the first
 * pixel is read: all headers, all cameras, the output folder, the device.
 */
#define _POSIX_C_SOURCE 200809L
#include "tool/process.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

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
  config->facing_fade[0] = config->facing_fade[1] = -1.0f;
  config->back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  config->steps_per_side = 48;
}

void process_options_init(process_options *options) {
  memset(options, 0, sizeof *options);
  hbil_config_init(&options->config);
  source_options_init(&options->source);
  options->repeat = 1;
  options->horizon_cache_bytes = FORM_FACTORS_AS_IT_FITS;
  options->compression = EXR_COMPRESSION_OF_ZIP;
  /* three bounces before the first picture: the fourth adds a few per cent */
  options->warm_up = 3;
  /* unless the first frame shows otherwise (policy.c) */
  options->config.gather_emission = CL_FALSE;
  process_set_model(&options->config);
}

/* ------------------------------------------------------------------------ */
/* Names                                                                     */

char *process_join(const char *a, const char *between, const char *b) {
  const size_t size = strlen(a) + strlen(between) + strlen(b) + 1;
  char *text = malloc(size);
  if (text)
    snprintf(text, size, "%s%s%s", a, between, b);
  return text;
}

static char *result_stem(const char *folder, const char *frame) {
  const char *slash = strrchr(frame, '/');
  char *stem = process_join(folder, "/", slash ? slash + 1 : frame);
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

/* What is there already: an input, which nothing replaces, or a result. */
static int check_present(process *p, const job *j, const char *result,
                         const struct stat *status) {
  for (int i = 0; i < p->count; i++)
    if (p->jobs[i].disk == status->st_dev && p->jobs[i].inode == status->st_ino)
      return image_fail(&p->error,
                        "%s: its result would overwrite %s; another output "
                        "folder is needed",
                        j->path, p->jobs[i].path);
  if (!p->options->overwrite && !p->options->resume)
    return image_fail(&p->error,
                      "%s: is there already; --overwrite to replace it, "
                      "--resume to keep what is right of the sequence, or "
                      "another output folder is needed",
                      result);
  return 0;
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
    if (view_aim(j->path, &j->view, &j->map, &j->camera, &p->error) != 0 ||
        view_same_projection(j->path, &j->camera, p->jobs[0].path,
                             &p->jobs[0].camera, &p->error) != 0)
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

/* No result may take the place of an input, of another result or, unless that
 * is asked for, of what is there. */
static int check_name(process *p, job *j) {
  struct stat status;
  j->stem = result_stem(p->options->output, j->path);
  char *result = j->stem ? process_join(j->stem, "", ".exr") : NULL;
  if (!result)
    return image_no_memory(&p->error, j->path);
  int failed =
      stat(result, &status) == 0 ? check_present(p, j, result, &status) : 0;
  for (const job *before = p->jobs; before < j && !failed; before++)
    if (strcmp(before->stem, j->stem) == 0)
      failed = image_fail(&p->error,
                          "%s: its result would overwrite that of %s; "
                          "different file names are needed",
                          j->path, before->path);
  free(result);
  return failed;
}

void process_warn(const char *path, const char *what) {
  progress_line_begin();
  note(path, "warning: ", what);
  progress_line_end();
}

/* Not an error: occlusion and bent cones need no light. */
static void warn_of_darkness(const process *p) {
  const channel_map *map = &p->jobs[0].map;
  if (!p->options->quiet && p->config.mode == HBIL_MODE_HBIL &&
      !map->count[ROLE_DIRECT] && !map->count[ROLE_EMISSION])
    process_warn(p->jobs[0].path,
                 "no direct light and no emission; near light will be "
                 "black");
}

static void name_job(job *j, const char *path) {
  struct stat status;
  j->path = path;
  if (stat(path, &status) == 0) {
    j->disk = status.st_dev;
    j->inode = status.st_ino;
  }
}

static int check_jobs(process *p, char *const *files) {
  for (int i = 0; i < p->count; i++)
    name_job(&p->jobs[i], files[i]);
  for (int i = 0; i < p->count; i++)
    if (check_header(p, &p->jobs[i]) != 0 || check_name(p, &p->jobs[i]) != 0)
      return -1;
  warn_of_darkness(p);
  return aim(p) != 0 || settle(p) != 0 ? -1 : 0;
}

/* The folder that a path is in; malloc'd. */
static char *parent_of(const char *path) {
  size_t length = strlen(path);
  while (length > 1 && path[length - 1] == '/')
    length--;
  while (length > 0 && path[length - 1] != '/')
    length--;
  return length ? strndup(path, length) : strdup(".");
}

/* Whether results could be written, without a trace. */
static int look_at_folder(process *p) {
  const char *folder = p->options->output;
  char *parent = parent_of(folder);
  if (!parent)
    return image_no_memory(&p->error, folder);
  const int there = access(folder, F_OK) == 0;
  const int usable = access(there ? folder : parent, W_OK | X_OK) == 0;
  free(parent);
  return usable ? 0
                : image_fail(&p->error,
                             "%s: output folder cannot be %s: %s; a folder in "
                             "which you may write is needed",
                             folder, there ? "written" : "created",
                             strerror(errno));
}

/* Writes a file and takes it away again: asking for permissions would miss
 * read-only and special file systems. */
static int probe_folder(process *p) {
  char name[48];
  snprintf(name, sizeof name, "/.hbil-probe%ld", (long)getpid());
  char *probe = process_join(p->options->output, "", name);
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
  if (p->options->dry_run)
    return look_at_folder(p);
  p->folder_created = mkdir(p->options->output, 0777) == 0;
  if (!p->folder_created && errno != EEXIST)
    return image_fail(&p->error,
                      "%s: output folder cannot be created: %s; a folder that "
                      "exists, or whose parent does, is needed",
                      p->options->output, strerror(errno));
  return probe_folder(p);
}

/* Before hours of work, not behind them. */
static int check_sheet(process *p) {
  const char *path = p->options->contact_sheet;
  if (!path)
    return 0;
  if (access(path, F_OK) == 0 && !p->options->overwrite && !p->options->resume)
    return image_fail(&p->error,
                      "%s: is there already; --overwrite or another name is "
                      "needed",
                      path);
  /* its folder may be the one that would be made */
  if (p->options->dry_run && access(p->options->output, F_OK) != 0)
    return 0;
  char *parent = parent_of(path);
  if (!parent)
    return image_no_memory(&p->error, path);
  const int writable = access(parent, W_OK | X_OK) == 0;
  free(parent);
  return writable ? 0
                  : image_fail(&p->error,
                               "%s: cannot be written: %s; a folder in which "
                               "you may write is needed",
                               path, strerror(errno));
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
  const unsigned possible = layers_possible(p->config.mode, p->options->exact);
  const unsigned asked = p->options->layers;
  const int exact = p->options->exact &&
                    (layers_possible(p->config.mode, 0) & asked) == asked;
  char cannot[64], can[64];
  p->layers = asked ? asked : layers_of_mode(p->config.mode);
  if ((p->layers & ~possible) == 0)
    return 0;
  layers_names(p->layers & ~possible, cannot, sizeof cannot);
  layers_names(possible, can, sizeof can);
  return image_fail(&p->error,
                    "--layers %s: not with %s%s; some of %s are needed", cannot,
                    exact ? "--quality reference" : "--mode ",
                    exact ? "" : mode_name(p), can);
}

static void configure(process *p) {
  const channel_map *map = &p->jobs[0].map;
  channels_conventions(map, &p->config);
  p->config.width = p->width;
  p->config.height = p->height;
  p->config.bent_normal_space = HBIL_SPACE_WORLD;
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
  if (exact_sequence_check(&p->config, &p->error) != 0 || choose_model(p) != 0)
    return -1;
  return exact_sequence_open(&p->config, &p->jobs[0].map, p->layers, &work,
                             &p->exact, &p->error);
}

/* Frames that hand light on to each other are a sequence, which changes little
 * from one to the next; others may have nothing to do with each other. */
static unsigned choose_every(const process *p) {
  if (p->options->choose_every)
    return p->options->choose_every;
  return p->config.reprojection == HBIL_REPROJECTION_NONE ? 1 : CHOOSE_EVERY;
}

/* Whether the process may have any memory.  Where it may not, PoCL, which
 * allocates when a buffer is first used, aborts on one that is too large. */
static int is_unlimited(void) {
  struct rlimit limit;
  return getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
}

/* Device memory for form factors, bytes.  A frame's first run may have moved,
 * the second keeps them, and those after it gain; memory that is new to the
 * process takes as long as three of them gain (HACKING.md). */
static size_t horizon_cache_bytes(const process *p) {
  const unsigned long long mebibyte = 1u << 20, enough = 1024;
  const process_options *o = p->options;
  const unsigned runs = o->repeat + (p->count == 1 ? o->warm_up : 0);
  const unsigned long long quarter = device_memory(p->device.id) / 4;
  unsigned long long bytes = 0;
  if (o->horizon_cache_bytes != FORM_FACTORS_AS_IT_FITS)
    bytes = o->horizon_cache_bytes * mebibyte;
  else if (runs >= 8 && is_unlimited())
    bytes = quarter < enough * mebibyte ? quarter : enough * mebibyte;
  return bytes < SIZE_MAX ? (size_t)bytes : SIZE_MAX;
}

static int open_sequence(process *p) {
  return sequence_open(&p->device, &p->config, choose_every(p), &p->jobs[0].map,
                       p->layers, &p->sequence, &p->error);
}

static int open_library(process *p) {
  if (device_open(p->options->device, p->options->timings, &p->device,
                  &p->error) != 0 ||
      choose_model(p) != 0)
    return -1;
  p->config.horizon_cache_bytes = horizon_cache_bytes(p);
  if (open_sequence(p) == 0)
    return 0;
  /* what nobody has asked for may not be what a job fails for */
  if (!p->config.horizon_cache_bytes ||
      p->options->horizon_cache_bytes != FORM_FACTORS_AS_IT_FITS)
    return -1;
  p->config.horizon_cache_bytes = 0;
  return open_sequence(p);
}

/* ------------------------------------------------------------------------ */
/* The job                                                                   */

static int prepare_light(process *p) {
  char which[sizeof p->device.name + sizeof p->device.driver + 1];
  snprintf(which, sizeof which, "%s %s", p->device.name, p->device.driver);
  p->settings =
      resume_settings(p->options, &p->config, p->layers, p->environment, which);
  p->end = p->count;
  p->light.size = p->exact ? exact_sequence_light_size(p->exact)
                           : sequence_light_size(p->sequence);
  p->light.bytes = p->light.size ? malloc(p->light.size) : NULL;
  if (p->light.size && !p->light.bytes)
    return image_no_memory(&p->error, p->jobs[0].path);
  return p->options->resume ? process_resume(p) : 0;
}

static int prepare(process *p, char *const *files) {
  if (!p->options->output)
    return image_fail(&p->error, "no output folder; -o DIR is needed");
  if (p->count < 1)
    return image_fail(&p->error, "no frame; one FRAME.exr or more is needed");
  p->jobs = calloc((size_t)p->count, sizeof *p->jobs);
  p->rows = calloc((size_t)p->count, sizeof *p->rows);
  p->seconds = calloc((size_t)p->count, sizeof *p->seconds);
  if (!p->jobs || !p->rows || !p->seconds)
    return image_no_memory(&p->error, files[0]);
  if (choose_layers(p) != 0 || check_jobs(p, files) != 0 ||
      load_environment(p) != 0 || prepare_folder(p) != 0 || check_sheet(p) != 0)
    return -1;
  configure(p);
  if ((p->options->exact ? open_exact(p) : open_library(p)) != 0)
    return -1;
  return prepare_light(p);
}

/* What would be done, in place of doing it. */
static void tell_plan(const process *p) {
  char layers[64];
  int written = 0;
  for (int i = 0; i < p->count; i++) {
    const job *j = &p->jobs[i];
    tool_show(j->path, stdout);
    fputs(" -> ", stdout);
    tool_show(j->stem, stdout);
    printf(".exr%s\n", j->finished ? " (is there already)" : "");
    written += !j->finished;
  }
  layers_names(p->layers, layers, sizeof layers);
  printf("%d of %d frames would be written, %u x %u pixels: %s\n", written,
         p->count, p->width, p->height, layers);
  if (!p->exact)
    printf("device %s, %.1f MiB on it\n", p->device.name,
           (double)sequence_memory(p->sequence) / 1048576.0);
}

static int print_timings(process *p) {
  const timing_report report = {
      .device = p->device.name,
      .width = p->width,
      .height = p->height,
      .repeat = p->options->repeat,
      .memory = p->exact ? 0 : sequence_memory(p->sequence),
      .rows = p->rows,
      .count = (size_t)p->count,
      .stages = p->seconds,
      .wall = p->wall,
      .lit = p->lit,
  };
  if (!p->options->quiet && !p->options->timings && p->lit > 1) {
    fputs("hbil: ", stderr);
    timings_summary(&report, stderr);
    fputc('\n', stderr);
  }
  if (!p->options->timings)
    return 0;
  if (p->options->json)
    return timings_json(&report, &p->error);
  timings_table(&report);
  return 0;
}

static int run(process *p) {
  if (p->options->dry_run) {
    tell_plan(p);
    return 0;
  }
  return process_frames(p) != 0 || print_timings(p) != 0 ? -1 : 0;
}

static void release(process *p) {
  sequence_close(p->sequence);
  exact_sequence_close(p->exact);
  device_close(&p->device);
  for (int i = 0; p->jobs && i < p->count; i++) {
    free(p->jobs[i].stem);
    channels_free(&p->jobs[i].map);
  }
  free(p->jobs);
  free(p->rows);
  free(p->seconds);
  free(p->light.bytes);
}

int process_run(const process_options *options, char *const *files, int count) {
  process p = {.options = options, .config = options->config, .count = count};
  const int failed = prepare(&p, files) != 0 || run(&p) != 0;
  if (failed && p.folder_created)
    rmdir(options->output); /* succeeds only while nothing is in it */
  release(&p);
  return failed ? tool_report(&p.error) : TOOL_OK;
}
