/*
 * hbil demo: a sequence that needs no files and no renderer.  Traces the
 * G-buffers of a small scene, writes them as a renderer would, and computes
 * their light as `hbil process` does.
 */
#define _POSIX_C_SOURCE 200809L
#include "dump/frame_camera.h"
#include "dump/pixel_ray.h"
#include "image/camera_json.h"
#include "image/error.h"
#include "image/exr_write.h"
#include "image/image.h"
#include "image/temporary_sweep.h"
#include "scene/scene.h"
#include "tool/commands.h"
#include "tool/demo_files.h"
#include "tool/device.h"
#include "tool/file_kind.h"
#include "tool/options.h"
#include "tool/process.h"
#include "tool/report.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { GBUFFER_PLANES = 18, SKY_WIDTH = 64, SKY_HEIGHT = 32 };
enum { FACE_SIZE = 160, LIGHT_VIEW_SIZE = 256 }; /* of a view, pixels */

static const char *const scene_names[] = {"room", "sky", "corner", NULL};

typedef struct demo_options {
  unsigned frames, width, height;
  int scene, orthographic, views, light_view;
  const char *output;
  const char *device;
} demo_options;

#define AT(field) offsetof(demo_options, field)

static const option_row rows[] = {
    {ROW_TEXT("output", AT(output), "DIR"), .letter = 'o',
     .help = "where everything goes ({})"},
    {ROW_NUMBER("frames", AT(frames), 1, 9999, "N"),
     .help = "length of the sequence ({})"},
    {.name = "size",
     .kind = OPTION_SIZE,
     .member = AT(width),
     .value = "WxH",
     .help = "pixels ({})"},
    {ROW_CHOICE("scene", AT(scene), scene_names),
     .help = "room: furnished, under a lamp; sky: in the open; corner: with a "
             "lamp behind the camera ({})"},
    {ROW_FLAG("views", AT(views)),
     .help = "also traces six pictures of what surrounds the camera, which "
             "light the frames, too (the views of `hbil process`)",
     .relations = {NOT_WITH(AT(light_view), 0,
                            "which lights the frames in another way")}},
    {ROW_FLAG("light-view", AT(light_view)),
     .help = "also traces a picture from where the light is; it lights the "
             "frames by reflective shadow maps (--far rsm --light-view of "
             "`hbil process`)"},
    {ROW_FLAG("orthographic", AT(orthographic)),
     .help = "seen by parallel rays"},
    {ROW_TEXT("device", AT(device), "NAME"),
     .help = "number in `hbil devices`, or part of a name"}};
static const option_group group = {.rows = rows,
                                   .count = sizeof rows / sizeof *rows};
static const option_command command = {
    .usage =
        "usage: hbil demo [options]\n\nTraces a short sequence of G-buffers, "
        "runs them through `hbil process` and says where the pictures are.",
    .groups = &group,
    .group_count = 1};

/* ------------------------------------------------------------------------ */
/* Files                                                                     */

static int make_folder(const char *path, image_error *error) {
  struct stat info;
  if (mkdir(path, 0777) == 0)
    return 0;
  int reason = errno;
  if (reason == EEXIST && stat(path, &info) == 0 && S_ISDIR(info.st_mode)) {
    temporary_sweep(path);
    return 0;
  }
  return image_fail(error,
                    "%s: cannot be made: %s; a folder that can be written "
                    "is needed",
                    path, strerror(reason));
}

/* ------------------------------------------------------------------------ */
/* The G-buffer                                                              */

/* Stores the sky's radiance as emission, as renderers do. */
static void fill_sky(scene_frame *f) {
  const double *m = f->camera.world_from_view;
  for (size_t i = 0; i < (size_t)f->width * f->height; ++i) {
    if (f->depth[i] > 0.0f)
      continue;
    const pixel_ray ray =
        pixel_ray_at(f->projection, &f->camera, i % f->width, i / f->width);
    const double *r = ray.along;
    double direction[3];
    float rgb[3];
    for (int k = 0; k < 3; ++k)
      direction[k] =
          m[4 * k] * r[0] + m[4 * k + 1] * r[1] + m[4 * k + 2] * r[2];
    scene_sky(direction, rgb);
    for (int k = 0; k < 3; ++k)
      f->emission[k][i] = rgb[k];
  }
}

/* The planes with the channel names of a dump.  The pixels stay the frame's
 * own. */
static image gbuffer_image(const scene_frame *f,
                           image_plane planes[GBUFFER_PLANES]) {
  static const char *const names[GBUFFER_PLANES] = {
      "depth.Z",    "normal.X",   "normal.Y", "normal.Z",   "position.X",
      "position.Y", "position.Z", "albedo.R", "albedo.G",   "albedo.B",
      "direct.R",   "direct.G",   "direct.B", "emission.R", "emission.G",
      "emission.B", "motion.X",   "motion.Y"};
  float *const pixels[GBUFFER_PLANES] = {
      f->depth,       f->normal[0],   f->normal[1],   f->normal[2],
      f->position[0], f->position[1], f->position[2], f->albedo[0],
      f->albedo[1],   f->albedo[2],   f->direct[0],   f->direct[1],
      f->direct[2],   f->emission[0], f->emission[1], f->emission[2],
      f->motion[0],   f->motion[1]};
  for (int i = 0; i < GBUFFER_PLANES; ++i) {
    snprintf(planes[i].name, sizeof planes[i].name, "%s", names[i]);
    planes[i].pixels = pixels[i];
  }
  return (image){.width = f->width,
                 .height = f->height,
                 .count = GBUFFER_PLANES,
                 .planes = planes,
                 .key = FILE_DEMO_KEY};
}

/* JSON cameras have OpenGL's convention: y up, looking along -z.  Adding 0
 * turns -0 into 0, which reads better. */
static camera_file camera_of(const scene_frame *f) {
  static const double sign[4] = {1.0, -1.0, -1.0, 1.0};
  const hbil_camera *c = &f->camera;
  camera_file out = {.orthographic =
                         f->projection == HBIL_PROJECTION_ORTHOGRAPHIC,
                     .fx = c->fx,
                     .fy = c->fy,
                     .cx = c->cx,
                     .cy = c->cy,
                     .width = f->width,
                     .height = f->height};
  for (int i = 0; i < 16; ++i)
    out.camera_to_world[i] = c->world_from_view[i] * sign[i % 4] + 0.0;
  return out;
}

/* Writes path, which ends in .exr, and the camera beside it. */
static int write_frame(const scene_frame *f, const char *path,
                       image_error *error) {
  image_plane planes[GBUFFER_PLANES] = {{.pixels = NULL}};
  image img = gbuffer_image(f, planes);
  if (exr_write(path, &img, NULL, error) != 0)
    return -1;
  char *json = camera_file_beside(path);
  if (json == NULL)
    return image_no_memory(error, path);
  camera_file camera = camera_of(f);
  int failed = camera_write(json, &camera, error);
  free(json);
  return failed;
}

/* Writes a traced frame and frees it. */
static int store_frame(scene_frame *f, const char *path, image_error *error) {
  fill_sky(f);
  int failed = write_frame(f, path, error);
  scene_free(f);
  return failed;
}

static int trace_frame(const demo_options *o, unsigned index, const char *path,
                       image_error *error) {
  scene_frame f;
  int (*const render)(scene_kind, uint32_t, uint32_t, double, uint32_t,
                      scene_frame *) =
      o->orthographic ? scene_render_orthographic : scene_render;
  if (render((scene_kind)o->scene, o->width, o->height, 0.0, index, &f) != 0)
    return image_no_memory(error, path);
  return store_frame(&f, path, error);
}

static int trace_views(const demo_options *o, const demo_files *files,
                       image_error *error) {
  for (unsigned i = 0; i < files->view_count; ++i) {
    scene_frame f;
    if (scene_render_face((scene_kind)o->scene, FACE_SIZE, (int)i, 0, &f) != 0)
      return image_no_memory(error, files->views[i]);
    if (store_frame(&f, files->views[i], error) != 0)
      return -1;
  }
  return 0;
}

static int trace_light_view(const demo_options *o, const demo_files *files,
                            image_error *error) {
  scene_frame f;
  if (!files->light_view)
    return 0;
  if (scene_render_from_light((scene_kind)o->scene, LIGHT_VIEW_SIZE, 0, &f) !=
      0)
    return image_no_memory(error, files->light_view);
  return store_frame(&f, files->light_view, error);
}

static int trace_frames(const demo_options *o, const demo_files *files,
                        image_error *error) {
  const char *tracing = "tracing G-buffers";
  for (unsigned i = 0; i < o->frames; ++i) {
    progress_count(tracing, i, o->frames);
    if (trace_frame(o, i, files->frames[i], error) != 0)
      return -1;
  }
  progress_count(tracing, o->frames, o->frames);
  return 0;
}

/* Writes the sky as a latitude-longitude map; see
 * hbil_environment_from_latlong(). */
static int write_sky(const char *path, image_error *error) {
  const double pi = 3.14159265358979323846;
  static float pixels[3][SKY_HEIGHT * SKY_WIDTH];
  image_plane planes[3] = {{.name = "R", .pixels = pixels[0]},
                           {.name = "G", .pixels = pixels[1]},
                           {.name = "B", .pixels = pixels[2]}};
  for (int i = 0; i < SKY_HEIGHT * SKY_WIDTH; ++i) {
    double polar = (i / SKY_WIDTH + 0.5) * pi / SKY_HEIGHT;
    double azimuth = 2.0 * pi * (0.5 - (i % SKY_WIDTH + 0.5) / SKY_WIDTH);
    double direction[3] = {sin(polar) * cos(azimuth), sin(polar) * sin(azimuth),
                           cos(polar)};
    float rgb[3];
    scene_sky(direction, rgb);
    for (int k = 0; k < 3; ++k)
      pixels[k][i] = rgb[k];
  }
  image img = {.width = SKY_WIDTH,
               .height = SKY_HEIGHT,
               .count = 3,
               .planes = planes,
               .key = FILE_DEMO_KEY};
  return exr_write(path, &img, NULL, error);
}

/* ------------------------------------------------------------------------ */
/* The command                                                               */

static void name_results(const demo_options *o, const char *folder) {
  unsigned last = o->frames;
  printf("\nlook at, of the last frame:\n"
         "  %s/frame_%04u.beauty.png    the final picture\n"
         "  %s/frame_%04u.indirect.png  the indirect light alone\n"
         "  %s/frame_%04u.ao.png        ambient visibility\n"
         "  %s/frame_%04u.exr           all layers\n"
         "and at what it was made of: %s/frame_%04u.exr and .json\n",
         o->output, last, o->output, last, o->output, last, o->output, last,
         folder, last);
}

static int process(const demo_options *o, const demo_files *files,
                   image_error *error) {
  process_settings s;
  process_settings_init(&s);
  s.output = o->output;
  s.device = o->device;
  /* what the walls outside the picture may send into the room */
  s.environment = files->sky                 ? files->sky
                  : o->scene == SCENE_CORNER ? "frame"
                                             : "0.12,0.11,0.1";
  s.views = files->views;
  s.view_count = files->view_count;
  s.light_views = (char *const *)&files->light_view;
  s.light_view_count = files->light_view ? 1 : 0;
  s.far = files->light_view ? HBIL_CACHE_METHOD_RSM : 0;
  s.preview = s.timings = s.overwrite = 1;
  s.config.history.reprojection = HBIL_REPROJECTION_MOTION;
  return process_run(&s, files->frames, (int)o->frames, error);
}

/* Before a sequence is traced for which there is no device. */
static int check_device(const demo_options *o, image_error *error) {
  device d;
  if (device_open(o->device, 1, &d, error) != 0)
    return -1;
  if (d.note)
    report_note(d.name, "", d.note);
  device_close(&d);
  return 0;
}

/* Makes the folders and the G-buffers and computes their light. */
static int run(const demo_options *o, const demo_files *files,
               image_error *error) {
  if (demo_files_check(files, error) != 0 || check_device(o, error) != 0 ||
      make_folder(o->output, error) != 0 ||
      make_folder(files->folder, error) != 0 ||
      trace_frames(o, files, error) != 0 || trace_views(o, files, error) != 0 ||
      trace_light_view(o, files, error) != 0 ||
      (files->sky && write_sky(files->sky, error) != 0) ||
      process(o, files, error) != 0)
    return -1;
  name_results(o, files->folder);
  return 0;
}

int cmd_demo(int argc, char **argv) {
  demo_options o = {
      .frames = 8, .width = 640, .height = 360, .output = "./demo"};
  demo_files files;
  options_given given;
  image_error error;
  const int read = options_read(&command, argc, argv, &o, &given, &error);
  if (read > 0) {
    options_help(&command, &o);
    return STATUS_OK;
  }
  if (read == 0 && optind < argc)
    image_fail(&error, "demo: %s: no files are taken; see hbil demo --help",
               argv[optind]);
  if (read < 0 || optind < argc)
    return report_error(&error);
  const demo_content content = {.frames = o.frames,
                                .views = o.views ? SCENE_FACES : 0,
                                .light_view = o.light_view,
                                .sky = o.scene == SCENE_SKY};
  const int failed = demo_files_name(o.output, &content, &files, &error) != 0 ||
                     run(&o, &files, &error) != 0;
  demo_files_free(&files);
  return failed ? report_error(&error) : STATUS_OK;
}
