/* Does a job from its settings to the last file. */
#include "tool/process.h"

#include "image/clock.h"
#include "image/image.h"
#include "image/image_read.h"
#include "tool/frame_source.h"
#include "tool/job_camera.h"
#include "tool/beauty.h"
#include "tool/job_cuts.h"
#include "tool/job_files.h"
#include "tool/job_frames.h"
#include "tool/job_light.h"
#include "tool/paths.h"
#include "tool/report.h"
#include "tool/run_frames.h"
#include "tool/timings.h"
#include "tool/unknown.h"
#include "tool/job_cache.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* Making a job from settings and files                                      */

/* Near light has the bounces that this option stands in for. */
static int check_bounces(const job *j, image_error *error) {
  const hbil_ao_bounces bounces = j->config.model.ao_bounces;
  return bounces == HBIL_AO_BOUNCES_NONE ||
                 j->config.model.mode != HBIL_MODE_HBIL
             ? 0
             : image_fail(error,
                          "--ao-bounces %s: not with --mode hbil, whose near "
                          "light has these bounces; --mode gtao or hbao is "
                          "needed",
                          ao_bounces_words[bounces]);
}

static int choose_layers(job *j, image_error *error) {
  const process_settings *s = j->settings;
  const hbil_mode mode = j->config.model.mode;
  const unsigned possible = layers_possible(mode, s->exact);
  /* whether the mode could, and only the exact integral cannot */
  const int exact =
      s->exact && (layers_possible(mode, 0) & s->layers) == s->layers;
  char cannot[160], can[160];
  j->layers = s->layers ? s->layers : layers_of_mode(mode);
  if ((j->layers & ~possible) == 0)
    return 0;
  layers_names(j->layers & ~possible, cannot, sizeof cannot);
  layers_names(possible, can, sizeof can);
  return image_fail(error, "--layers %s: not with %s%s; some of %s are needed",
                    cannot, exact ? "--quality reference" : "--mode ",
                    exact ? "" : mode_words[mode], can);
}

/* Whether the user asks for a radiance cache. */
static int asks_for_cache(const process_settings *s) {
  return s->view_count || s->light_view_count || s->far || s->learn ||
         s->cache_load || s->cache_save;
}

/* Decides whether frames have a radiance cache.  Unasked, they have one if it
 * can know more than a frame itself, because the camera moves.  Only one mode
 * has light, and the paper has no cache.  Returns 0, or -1 with `error` filled.
 */
static int decide_about_cache(job *j, image_error *error) {
  const process_settings *s = j->settings;
  j->has_cache = 0;
  if (settings_without_cache(s) || s->exact ||
      j->config.model.mode != HBIL_MODE_HBIL)
    return 0;
  j->has_cache = asks_for_cache(s);
  return j->has_cache || s->paper || j->frames[0].map.how.from_depth
             ? 0
             : job_camera_moves(j, &j->has_cache, error);
}

/* Whether the file has the colours as half floats: direct light, or if there is
 * none, albedo. */
static int colours_are_half(const job_frame *f) {
  const channel_map *map = &f->map;
  const role r = map->count[ROLE_DIRECT] ? ROLE_DIRECT : ROLE_ALBEDO;
  image header;
  if (!map->count[r] ||
      image_read_header(map->files[r] ? map->files[r] : f->path, &header,
                        NULL) != 0)
    return 0;
  int half = 1;
  for (size_t c = 0; c < map->count[r]; c++) {
    const image_plane *plane = image_find(&header, map->names[r][c]);
    half &= plane && plane->type == IMAGE_HALF;
  }
  image_free(&header);
  return half;
}

static void choose_precision(job *j) {
  const layer_precision asked = j->settings->precision;
  j->half = asked == PRECISION_OF_FRAME ? colours_are_half(job_first(j))
                                        : asked == PRECISION_HALF;
}

static void configure(job *j) {
  channel_map_configure(&j->frames[0].map, &j->config);
  if (j->settings->exact) { /* see frame_source_read() */
    j->config.inputs.depth_kind = HBIL_DEPTH_PLANAR;
    j->config.inputs.depth_scale = 1.0f;
    j->config.inputs.sky_depth = INFINITY;
  }
  j->config.width = j->width;
  j->config.height = j->height;
  j->config.outputs.bent_normal_space = HBIL_SPACE_WORLD;
  j->config.execution.profiling = j->settings->timings ? CL_TRUE : CL_FALSE;
}

/* What is known beyond the frames. */
static int read_cache_inputs(job *j, image_error *error) {
  const process_settings *s = j->settings;
  if (settings_without_cache(s) || s->exact || !asks_for_cache(s) ||
      j->config.model.mode != HBIL_MODE_HBIL)
    return 0;
  if (j->frames[0].map.how.from_depth)
    return image_fail(error,
                      "--normals from-depth: not with --view, --learn, "
                      "--cache-load or --cache-save, whose radiance cache "
                      "needs normals");
  return views_check(j, error) != 0 ||
                 (s->cache_load &&
                  cache_file_read(s->cache_load, &j->loaded, error) != 0)
             ? -1
             : 0;
}

/* Decides whether a place has a radiance cache, and the settings beside it. */
static int prepare_cache(job *j, image_error *error) {
  const process_settings *s = j->settings;
  hbil_config with_cache = j->config;
  hbil_cache_config cache;
  if (decide_about_cache(j, error) != 0)
    return -1;
  if (!j->has_cache)
    return 0;
  hbil_cache_config_init(&cache);
  cache.voxel_size = 1; /* decides about the radius, which is not read here */
  hbil_config_use_cache(&with_cache, &cache);
  j->config.model.cache_method =
      s->far ? (hbil_cache_method)s->far : HBIL_CACHE_METHOD_RAYS;
  if (!s->thickness_given && !s->paper)
    j->config.model.near_relative_thickness =
        with_cache.model.near_relative_thickness;
  return 0;
}

int job_prepare(job *j, const process_settings *settings, char *const *files,
                int count, image_error *error) {
  memset(j, 0, sizeof *j);
  j->settings = settings;
  j->config = settings->config;
  if (!settings->output)
    return image_fail(error, "no output folder; -o DIR is needed");
  if (count < 1)
    return image_fail(error, "no frame; one FRAME.exr or more is needed");
  j->frames = calloc((size_t)count, sizeof *j->frames);
  if (!j->frames)
    return image_no_memory(error, files[0]);
  j->count = count;
  j->pre_roll = settings->pre_roll;
  if (check_bounces(j, error) != 0 || choose_layers(j, error) != 0 ||
      job_frames_check(j, files, error) != 0 ||
      job_environment_read(j, error) != 0)
    return -1;
  if (settings->exact && j->frames[0].map.how.from_depth)
    return image_fail(error,
                      "--normals from-depth: not with --quality reference, "
                      "whose exact integral needs normals");
  configure(j);
  choose_precision(j);
  if (beauty_choose(j, error) != 0)
    return -1;
  /* after the output folder is made: in a/../b, a may be missing until then */
  return read_cache_inputs(j, error) != 0 || job_files_prepare(j, error) != 0 ||
                 job_cuts_find(j, error) != 0
             ? -1
             : 0;
}

/* ------------------------------------------------------------------------ */
/* Doing it                                                                  */

typedef struct process {
  job whole;
  job job; /* of the place that is being lit: a part of the whole */
  first_frame first;
  lighting lighting;
  resume resume;
  encoder encoder;
  frame_times times;
  int written;       /* frames, with --dry-run */
  double begun, lap; /* seconds_now(), and that of the last part's end */
  double learning;   /* milliseconds; -1: there is no cache */
  double parts[TIMING_PARTS];
} process;

/* What happened since the last call was this part of the job. */
static void end_part(process *p, timing_part part) {
  const double now = seconds_now();
  p->parts[part] += now - p->lap;
  p->lap = now;
}

/* Prints what would be done with a place's frames. */
static void print_frames(process *p) {
  const job *j = &p->job;
  for (int i = 0; i < j->count; i++) {
    const int finished = p->resume.finished[i];
    report_text(j->frames[i].path, stdout);
    fputs(" -> ", stdout);
    report_text(j->frames[i].stem, stdout);
    printf(".exr%s\n", job_is_pre_roll(j, i) ? " (pre-roll, not written)"
                       : finished            ? " (is there already)"
                                             : "");
    p->written += !finished;
  }
}

static void print_plan(const process *p) {
  const job *j = &p->job;
  char layers[160];
  for (int i = 0; i < j->view_count; i++) {
    report_text(j->views[i].path, stdout);
    puts(" (view)");
  }
  layers_names(j->layers, layers, sizeof layers);
  printf("%d of %d frames would be written, %u x %u pixels: %s\n", p->written,
         p->whole.count - (int)p->whole.pre_roll, j->width, j->height, layers);
  if (!j->settings->exact)
    printf("device %s, %.1f MiB on it\n", p->lighting.device.name,
           (double)lighting_memory(&p->lighting) / 1048576.0);
}

static int print_timings(const process *p, image_error *error) {
  const process_settings *s = p->whole.settings;
  const timing_report report = {
      .device = p->lighting.device.name,
      .width = p->whole.width,
      .height = p->whole.height,
      .repeat = s->repeat,
      .memory = lighting_memory(&p->lighting),
      .rows = p->times.rows,
      .count = (size_t)p->whole.count,
      .stages = (const double(*)[PIPELINE_STAGES])p->times.stages,
      .wall = p->times.wall,
      .computed = p->times.computed,
      .learning = p->learning,
      .parts = p->parts,
      .total = seconds_now() - p->begun,
  };
  if (!s->quiet) {
    timings_warn_sanitized(report.rows, report.count);
    unknown_report(&p->whole, p->job.has_cache, report.rows, report.count);
  }
  if (!s->quiet && !s->timings && report.computed > 1) {
    fputs("hbil: ", stderr);
    timings_summary(&report, stderr);
    fputc('\n', stderr);
  }
  if (!s->timings)
    return 0;
  if (s->json)
    return timings_json(&report, error);
  timings_table(&report);
  return 0;
}

/* Makes the kernels, and checks the first frame meanwhile.  A job that is
 * resumed may not need that frame. */
static int open_lighting(process *p, image_error *error) {
  const process_settings *s = p->job.settings;
  if (!s->resume)
    first_frame_begin(&p->first, &p->job);
  else
    held_planes_free(&p->job.held);
  return lighting_open(&p->lighting, &p->job, error);
}

/* Reading the first frame is a part by itself, within others. */
static void move_to_read(process *p, timing_part from, double seconds) {
  p->parts[from] -= seconds;
  p->parts[TIMING_READ] += seconds;
}

static int choose_light(process *p, image_error *error) {
  const int failed = job_light_decide(&p->job, &p->first, error) != 0 ||
                     job_cache_choose(&p->job, error) != 0;
  end_part(p, TIMING_CHOOSE);
  move_to_read(p, TIMING_CHOOSE, p->first.seconds);
  return failed ? -1 : 0;
}

static int open_whole(process *p, const process_settings *settings,
                      char *const *files, int count, image_error *error) {
  if (job_prepare(&p->whole, settings, files, count, error) != 0 ||
      frame_times_make(&p->times, &p->whole, error) != 0 ||
      lighting_prepare(&p->lighting, &p->whole, error) != 0)
    return -1;
  end_part(p, TIMING_OPEN);
  move_to_read(p, TIMING_OPEN, p->whole.held.seconds);
  p->encoder.whole = &p->whole;
  p->encoder.lines = settings->exact;
  return 0;
}

static int open_place(process *p, int place, image_error *error) {
  p->job = job_of_place(&p->whole, place);
  if (place == 0) { /* what is held of the first frame moves to the place */
    memset(&p->whole.held, 0, sizeof p->whole.held);
    if (p->job.frames[0].map.held)
      p->job.frames[0].map.held = &p->job.held;
  }
  if (prepare_cache(&p->job, error) != 0 || choose_light(p, error) != 0 ||
      open_lighting(p, error) != 0)
    return -1;
  end_part(p, TIMING_BUILD);
  return resume_open(&p->resume, &p->job, &p->lighting, error);
}

static void close_place(process *p) {
  first_frame_free(&p->first);
  resume_close(&p->resume);
  held_planes_free(&p->job.held);
  memset(&p->first, 0, sizeof p->first);
}

/* Computes and writes what is missing of a place. */
static int light_place(process *p, image_error *error) {
  p->lap = seconds_now();
  if (resume_uses_cache(&p->resume) && lighting_learn(&p->lighting, error) != 0)
    return -1;
  if (p->lighting.cache)
    p->learning = fmax(p->learning, 0.0) +
                  1e3 * job_cache_learning_seconds(p->lighting.cache);
  end_part(p, TIMING_LEARN);
  if (run_frames(&p->job, &p->first, &p->lighting, &p->resume, &p->encoder,
                 &p->times, error) != 0)
    return -1;
  end_part(p, TIMING_FRAMES);
  return p->job.settings->cache_save ? lighting_save(&p->lighting, error) : 0;
}

static int run_place(process *p, int place, image_error *error) {
  const int is_last = place + 1 == p->whole.place_count;
  int failed = open_place(p, place, error);
  if (!failed && p->whole.settings->dry_run) {
    failed = first_frame_tell(&p->first, error);
    if (!failed)
      print_frames(p);
  } else if (!failed)
    failed = light_place(p, error);
  close_place(p);
  if (!is_last)
    lighting_end(&p->lighting);
  return failed;
}

static int run(process *p, image_error *error) {
  for (int i = 0; i < p->whole.place_count; i++)
    if (run_place(p, i, error) != 0)
      return -1;
  if (p->whole.settings->dry_run) {
    print_plan(p);
    return 0;
  }
  return encoder_finish(&p->encoder, error) != 0 || print_timings(p, error) != 0
             ? -1
             : 0;
}

int process_run(const process_settings *settings, char *const *files, int count,
                image_error *error) {
  process p = {.whole = {.settings = settings},
               .begun = seconds_now(),
               .learning = -1.0};
  p.lap = p.begun;
  const int failed =
      open_whole(&p, settings, files, count, error) != 0 || run(&p, error) != 0;
  if (failed)
    path_remove_folders(settings->output, p.whole.folders_made);
  encoder_close(&p.encoder);
  frame_times_free(&p.times);
  lighting_close(&p.lighting);
  job_free(&p.whole);
  return failed ? -1 : 0;
}
