/*
 * A renderer that adopts the library.  Somebody who had nothing but the
 * installed headers wrote this program first, and so it stays: with
 * adopter_renderer and adopter_scene, it includes the public headers, OpenCL
 * and the C library, and nothing of test/support.  What it expects is what the
 * headers say, and its own arithmetic.  It prints TAP by itself.
 */
#define _POSIX_C_SOURCE 200809L /* mkdtemp, unlinkat */
#include "test/system/adopter_renderer.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FRAMES = 6 };

#define PI 3.14159265358979323846
#define FAR_PLANE 100.0 /* world units */

static picture sequence[FRAMES]; /* the usual frames of a static camera */

/* --- comparisons --- */

/* The root mean square of what is shown minus the second usual frame, over that
 * frame's own, in four channels of the picture.  ao is apart from the light,
 * and the greater of both counts. */
static double distance(void) {
  const float *got = shown.light[0], *want = sequence[1].light[0];
  double difference[2] = {0}, all[2] = {0}; /* light, ao */
  for (size_t i = 0; i < sizeof shown / sizeof *got; ++i) {
    difference[i % 4 == 3] += pow(got[i] - want[i], 2);
    all[i % 4 == 3] += pow(want[i], 2);
  }
  return sqrt(fmax(difference[0] / all[0], difference[1] / all[1]));
}

/* --- sequences --- */

static double mean_red(const picture *of) {
  double sum = 0;
  for (int i = 0; i < PIXELS; ++i)
    sum += of->light[i][0];
  return sum / PIXELS;
}

/* Each frame waits for the last one's event, although it need not. */
static void check_bounces(lighting *l) {
  cl_event last = NULL, next;
  double mean[FRAMES];
  bool grows = true;
  for (int i = 0; i < FRAMES; ++i) {
    succeed(hbil_enqueue_frame(l->plan, self.queue, &l->frame, i > 0,
                               i ? &last : NULL, &next),
            "hbil_enqueue_frame");
    if (last)
      clReleaseEvent(last);
    last = next;
    read_picture(&sequence[i]);
    mean[i] = mean_red(&sequence[i]);
    grows = grows && (i == 0 || mean[i] > mean[i - 1]);
  }
  clReleaseEvent(last);
  check(grows, "light grows with every frame: %.4f %.4f .. %.4f", mean[0],
        mean[1], mean[FRAMES - 1]);
}

static void check_reset(lighting *l) {
  const hbil_sanitized *s = &l->sanitized;
  hbil_plan_reset(l->plan);
  run_frames(l, 1);
  check(shows(&sequence[0]), "after a reset comes the first frame");
  check(l->statistics.all.pixels == PIXELS &&
            l->statistics.sky.pixels == drawn.sky_pixels &&
            l->statistics.not_run[HBIL_PASS_REPROJECT],
        "statistics of a first frame, %zu pixels of sky",
        l->statistics.sky.pixels);
  check(s->depth + s->normal + s->albedo + s->direct + s->facing_away == 0,
        "nothing is sanitized");
}

/* Frames that nobody chains, on a queue that doesn't either. */
static void check_out_of_order(lighting *l) {
  const char *name = "out of order, the bits of the last frame";
  cl_event last = NULL;
  if (!self.out_of_order) {
    skip_check(name, "the device has no such queues");
    return;
  }
  hbil_plan_reset(l->plan);
  for (int i = 0; i < FRAMES; ++i)
    succeed(hbil_enqueue_frame(l->plan, self.out_of_order, &l->frame, 0, NULL,
                               i == FRAMES - 1 ? &last : NULL),
            "hbil_enqueue_frame");
  need(clWaitForEvents(1, &last) == CL_SUCCESS, "clWaitForEvents");
  clReleaseEvent(last);
  read_picture(&shown);
  check(shows(&sequence[FRAMES - 1]), "%s", name);
}

static void check_single_passes(lighting *l) {
  hbil_plan_reset(l->plan);
  for (int frame = 0; frame < 2; ++frame)
    for (int i = HBIL_PASS_REPROJECT; i <= HBIL_PASS_COMPOSITE; ++i)
      succeed(hbil_enqueue_passes(l->plan, self.queue, &l->frame, (hbil_pass)i,
                                  (hbil_pass)i, 0, NULL, NULL),
              hbil_pass_name((hbil_pass)i));
  read_picture(&shown);
  check(shows(&sequence[1]), "single passes, the bits of the second frame");
}

static void check_sequences(void) {
  lighting l = usual();
  make_plan(&l);
  check_bounces(&l);
  check_reset(&l);
  check_out_of_order(&l);
  check_single_passes(&l);
  free_plan(&l);
}

static void check_timings(void) {
  lighting l = usual();
  double ms[HBIL_PASS_COUNT];
  make_plan(&l);
  check(fails(hbil_plan_timings(l.plan, ms), HBIL_INVALID_CONFIG, self.hbil,
              "execution.profiling"),
        "timings need a setting");
  free_plan(&l);
  const cl_command_queue queue = clCreateCommandQueue(
      self.context, self.device, CL_QUEUE_PROFILING_ENABLE, NULL);
  need(queue != NULL, "clCreateCommandQueue");
  l.config.execution.profiling = CL_TRUE;
  make_plan(&l);
  succeed(hbil_enqueue_frame(l.plan, queue, &l.frame, 0, NULL, NULL),
          "hbil_enqueue_frame");
  succeed(hbil_plan_timings(l.plan, ms), "hbil_plan_timings");
  check(ms[HBIL_PASS_GATHER] > 0, "timings: %.2f ms of gathering",
        ms[HBIL_PASS_GATHER]);
  free_plan(&l);
  clReleaseCommandQueue(queue);
}

/* --- cameras --- */

/* One camera in the conventions of several renderers. */
static void check_cameras(void) {
  static const cl_uint columns =
      HBIL_MATRIX_COLUMN_MAJOR | HBIL_MATRIX_REVERSED_DEPTH;
  const convention same[] = {
      opengl,
      {-1,
       -1,
       {0, NEAR_PLANE},
       true,
       columns | HBIL_MATRIX_Y_DOWN},         /* Vulkan */
      {1, 1, {0, NEAR_PLANE}, true, columns}, /* Direct3D, DirectXMath */
      {1, 1, {0, NEAR_PLANE}, false, HBIL_MATRIX_REVERSED_DEPTH}}; /* by rows */
  lighting l = usual();
  hbil_camera own;
  double most = 0;
  bool one_picture = true;
  scene_camera_from_pose(&own, &looks_down);
  make_plan(&l);
  for (size_t i = 0; i < sizeof same / sizeof *same; ++i) {
    look(&l, &looks_down, &same[i]);
    most = fmax(most, scene_camera_distance(&l.frame.camera, &own));
    most = fmax(most, fabs(l.frame.hardware_depth[0]));
    most = fmax(most, fabs(l.frame.hardware_depth[1] - NEAR_PLANE));
    hbil_plan_reset(l.plan);
    run_frames(&l, 2);
    one_picture = one_picture && shows(&sequence[1]);
  }
  free_plan(&l);
  /* doubles: a few roundings of numbers up to 130, 3e-14 each */
  check(most < 1e-12, "OpenGL, Vulkan, Direct3D: one camera (%.0e)", most);
  check(one_picture, "OpenGL, Vulkan, Direct3D: one picture");
}

/* OpenGL without glClipControl(): clip space is -1..1, and what is nearer has
 * the smaller depth. */
static void check_signed_depth(void) {
  const double a = FAR_PLANE / (FAR_PLANE - NEAR_PLANE), b = -NEAR_PLANE * a;
  const convention usual_opengl = {-1,
                                   1,
                                   {2 * a - 1, 2 * b},
                                   true,
                                   HBIL_MATRIX_COLUMN_MAJOR |
                                       HBIL_MATRIX_SIGNED_DEPTH};
  lighting l = usual();
  look(&l, &looks_down, &usual_opengl);
  check(fabs(l.frame.hardware_depth[0] - a) < 1e-12 &&
            fabs(l.frame.hardware_depth[1] - b) < 1e-12,
        "A and B of a clip space from -1 to 1");
}

/* --- the picture --- */

/* beauty by its formula in hbil_outputs; there is no F0 and no emission. */
static double beauty_error(const picture *of) {
  double most = 0;
  for (int i = 0; i < 3 * PIXELS; ++i) {
    const int pixel = i / 3, channel = i % 3;
    const double want =
        drawn.albedo[pixel][channel] / PI *
        ((double)drawn.direct[pixel][channel] + of->light[pixel][channel]);
    const double error = fabs(of->beauty[pixel][channel] - want);
    most = fmax(most, error / (want + 0.01));
  }
  return most;
}

static void check_picture(void) {
  const picture *of = &sequence[1];
  double red = 0, blue = 0;
  bool ao_is_valid = true;
  for (int i = 0; i < PIXELS; ++i) {
    const float ao = of->light[i][3], least = drawn.depth[i][0] == 0;
    ao_is_valid = ao_is_valid && ao >= least && ao <= 1;
    red += of->light[i][0];
    blue += of->light[i][2];
  }
  check(ao_is_valid, "ao is 0 to 1, and 1 at the sky");
  check(red > 2 * blue, "the red wall's light is reddish");
  /* floats: a few roundings, of which a division may take 2.5 ulp; 2e-7 was
   * measured */
  check(beauty_error(of) < 1e-5, "beauty is what its formula says (%.0e)",
        beauty_error(of));
}

/* --- formats --- */

/* Against planes of floats, normals have 1e-3 radians of error.  Direct light
 * has at most half of 1/256 of its brightest channel, and albedo half of 1/255
 * of 0.2, the least one.  Together that is 1.4 % of the light at worst; 5e-3
 * was measured. */
static void check_packed_formats(void) {
  lighting l = usual();
  l.config.inputs.normal = (hbil_plane_format){HBIL_RGB10A2_UNORM, 0};
  l.config.inputs.albedo = (hbil_plane_format){HBIL_UNORM8, 4};
  l.config.inputs.direct = (hbil_plane_format){HBIL_RGB9E5_FLOAT, 0};
  l.frame.normal.buffer = self.normal_rgb10;
  l.frame.albedo.buffer = self.albedo_rgb8;
  l.frame.direct.buffer = self.direct_rgb9e5;
  run_once(&l, 2);
  check(distance() < 0.014, "RGB10A2, UNORM8 and RGB9E5 are read (%.1e)",
        distance());
}

/* Walls are rebuilt exactly and the ball nearly, but not their edges: 2.3e-2
 * was measured. */
static void check_normals_from_depth(void) {
  lighting l = usual();
  l.config.inputs.normal.component = HBIL_NONE;
  l.frame.normal.buffer = NULL;
  run_once(&l, 2);
  check(distance() < 0.05, "normals are rebuilt from depth (%.1e)", distance());
}

enum { INPUT_IMAGES = 4, IMAGES = 7 };

static bool make_images(cl_mem images[IMAGES]) {
  void *const data[IMAGES] = {drawn.depth,  drawn.normal, drawn.albedo,
                              drawn.direct, drawn.black,  drawn.black,
                              drawn.black};
  const cl_image_format format = {CL_RGBA, CL_FLOAT};
  const cl_image_desc desc = {.image_type = CL_MEM_OBJECT_IMAGE2D,
                              .image_width = WIDTH,
                              .image_height = HEIGHT};
  bool made = true;
  for (int i = 0; i < IMAGES; ++i) {
    images[i] = clCreateImage(self.context, CL_MEM_COPY_HOST_PTR, &format,
                              &desc, data[i], NULL);
    made = made && images[i];
  }
  return made;
}

static void read_image(cl_mem image, plane out) {
  const size_t origin[3] = {0}, region[3] = {WIDTH, HEIGHT, 1};
  need(clEnqueueReadImage(self.queue, image, CL_TRUE, origin, region, 0, 0, out,
                          0, NULL, NULL) == CL_SUCCESS,
       "clEnqueueReadImage");
}

/* Two frames with images for all planes, as `shown`; returns whether what ao
 * and beauty don't have is 1 in alpha. */
static bool run_with_images(const cl_mem images[IMAGES]) {
  static plane ao;
  const hbil_plane_format image = {HBIL_IMAGE, 0};
  lighting l = usual();
  hbil_config *c = &l.config;
  hbil_plane *const planes[IMAGES] = {&l.frame.depth,           &l.frame.normal,
                                      &l.frame.albedo,          &l.frame.direct,
                                      &l.frame.near_irradiance, &l.frame.ao,
                                      &l.frame.beauty};
  bool opaque = true;
  c->inputs.depth = c->inputs.normal = image;
  c->inputs.albedo = c->inputs.direct = image;
  c->outputs.near_irradiance = c->outputs.ao = c->outputs.beauty = image;
  for (int i = 0; i < IMAGES; ++i)
    *planes[i] = (hbil_plane){.buffer = images[i]};
  run_once(&l, 2);
  read_image(images[INPUT_IMAGES], shown.light);
  read_image(images[INPUT_IMAGES + 1], ao);
  read_image(images[INPUT_IMAGES + 2], shown.beauty);
  for (int i = 0; i < PIXELS; ++i) {
    opaque = opaque && shown.light[i][3] == 1 && ao[i][3] == 1 &&
             shown.beauty[i][3] == 1;
    shown.light[i][3] = ao[i][0];
    shown.beauty[i][3] = 0;
  }
  return opaque;
}

static void check_images(void) {
  const char *name = "images give what buffers give";
  cl_mem images[IMAGES];
  if (make_images(images)) {
    const bool opaque = run_with_images(images);
    check(opaque && distance() < 1e-6, "%s (%.0e)", name, distance());
  } else {
    skip_check(name, "no images of four floats");
  }
  for (int i = 0; i < IMAGES; ++i)
    if (images[i])
      clReleaseMemObject(images[i]);
}

/* --- mistakes that a message names --- */

static void check_wrong_matrices(void) {
  static const char *const depth = "HBIL_MATRIX_REVERSED_DEPTH";
  static const char *const order = "HBIL_MATRIX_COLUMN_MAJOR";
  static const cl_uint columns = HBIL_MATRIX_COLUMN_MAJOR;
  static const cl_uint reversed = HBIL_MATRIX_REVERSED_DEPTH;
  const struct {
    const char *word;
    convention said;
  } wrong[] = {{order, {-1, 1, {0, NEAR_PLANE}, true, reversed}},
               {order, {1, 1, {0, NEAR_PLANE}, false, columns | reversed}},
               {depth, {-1, 1, {0, NEAR_PLANE}, true, columns}},
               {depth, {-1, 1, {1, -NEAR_PLANE}, true, columns | reversed}}};
  lighting l = usual();
  bool good = true;
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
    good &=
        fails(scene_camera(&l.frame, &l.config, &looks_down, &wrong[i].said),
              HBIL_INVALID_ARGUMENT, NULL, wrong[i].word);
  check(good, "a wrong order of matrices or direction of depth is named");
}

static cl_mem too_small, write_only, some_scratch;

static void lose_normals(hbil_frame *f) {
  f->normal.buffer = NULL;
}

static void add_emission(hbil_frame *f) {
  f->emission = f->direct;
}

static void overlap_outputs(hbil_frame *f) {
  f->ao.offset = sizeof(float);
}

static void shrink_direct(hbil_frame *f) {
  f->direct.buffer = too_small;
}

static void shorten_rows(hbil_frame *f) {
  f->depth.row_pitch = 8;
}

static void lose_focal_length(hbil_frame *f) {
  f->camera.fx = 0;
}

static void read_what_is_for_writing(hbil_frame *f) {
  f->albedo.buffer = write_only;
}

static void write_what_is_for_reading(hbil_frame *f) {
  f->ao = f->depth;
}

static void lose_depth_scale(hbil_frame *f) {
  f->hardware_depth[1] = 0;
}

static void write_to_scratch(hbil_frame *f) {
  f->ao.buffer = some_scratch;
}

static bool rejects_frame(lighting *l, void (*spoil)(hbil_frame *),
                          const char *word) {
  const hbil_frame good = l->frame;
  cl_event event = NULL;
  spoil(&l->frame);
  const hbil_status status =
      hbil_enqueue_frame(l->plan, self.queue, &l->frame, 0, NULL, &event);
  l->frame = good;
  return fails(status, HBIL_INVALID_FRAME, self.hbil, word) && !event;
}

/* Wrong frames between the first and the second one, which don't notice. */
static void check_wrong_frames(void) {
  static const struct {
    const char *word;
    void (*spoil)(hbil_frame *);
  } wrong[] = {{"normal.buffer: missing", lose_normals},
               {"emission", add_emission},
               {"overlap", overlap_outputs},
               {"direct: offset", shrink_direct},
               {"row_pitch", shorten_rows},
               {"fx", lose_focal_length},
               {"WRITE_ONLY", read_what_is_for_writing},
               {"READ_ONLY", write_what_is_for_reading},
               {"hardware_depth", lose_depth_scale}};
  lighting l = usual();
  bool good = true;
  /* a channel of the last pixel, of which one byte is missing */
  too_small = make_buffer(CL_MEM_READ_ONLY, sizeof(plane) - 5, NULL);
  write_only = make_buffer(CL_MEM_WRITE_ONLY, sizeof(plane), NULL);
  make_plan(&l);
  run_frames(&l, 1);
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
    good &= rejects_frame(&l, wrong[i].spoil, wrong[i].word);
  check(good, "wrong frames are rejected, each by name");
  read_picture(&shown);
  good = shows(&sequence[0]);
  run_frames(&l, 1);
  check(good && shows(&sequence[1]), "they change nothing");
  free_plan(&l);
  clReleaseMemObject(too_small);
  clReleaseMemObject(write_only);
}

static void lose_width(hbil_config *c) {
  c->width = 0;
}

static void ask_for_many_slices(hbil_config *c) {
  c->sampling.slices = 33;
}

static void lose_depth(hbil_config *c) {
  c->inputs.depth.component = HBIL_NONE;
}

static void sign_light(hbil_config *c) {
  c->inputs.direct.component = HBIL_SNORM8;
}

static void ask_gtao_for_light(hbil_config *c) {
  c->model.mode = HBIL_MODE_GTAO;
}

static void grow_struct(hbil_config *c) {
  c->struct_size *= 2;
}

static void ask_for_nothing(hbil_config *c) {
  memset(&c->outputs, 0, sizeof c->outputs);
}

static void check_wrong_configurations(void) {
  static const struct {
    const char *word;
    void (*spoil)(hbil_config *);
  } wrong[] = {{"width", lose_width},
               {"slices", ask_for_many_slices},
               {"inputs.depth", lose_depth},
               {"inputs.direct", sign_light},
               {"outputs.near_irradiance", ask_gtao_for_light},
               {"struct_size", grow_struct},
               {"no output", ask_for_nothing}};
  bool good = true;
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    lighting l = usual();
    hbil_plan *made = (hbil_plan *)&l; /* anything but NULL */
    wrong[i].spoil(&l.config);
    good &= fails(hbil_plan_create(self.hbil, &l.config, &made),
                  HBIL_INVALID_CONFIG, self.hbil, wrong[i].word);
    good = good && !made;
  }
  check(good, "wrong configurations are rejected, each by name");
}

static void check_null_arguments(void) {
  const hbil_status want = HBIL_INVALID_ARGUMENT;
  lighting l = usual();
  hbil_context *made = self.hbil;
  hbil_status got = hbil_context_create(NULL, self.device, &made);
  bool good = fails(got, want, NULL, "context") && !made;
  got = hbil_enqueue_frame(NULL, self.queue, &l.frame, 0, NULL, NULL);
  good &= fails(got, want, NULL, "plan");
  got = hbil_plan_create(self.hbil, NULL, &l.plan);
  good &= fails(got, want, self.hbil, "config");
  got = hbil_plan_memory(self.hbil, &l.config, NULL);
  good &= fails(got, want, self.hbil, "out");
  check(good, "null arguments are named");
}

/* --- mistakes that figures show --- */

/* Says that the world's normals are those of the view. */
static void check_wrong_space(void) {
  lighting l = usual();
  l.config.inputs.normal_space = HBIL_SPACE_VIEW;
  run_once(&l, 1);
  check(l.sanitized.facing_away > PIXELS / 10,
        "in a wrong space, %zu normals face away", l.sanitized.facing_away);
}

/* Says that the lowest row is the first one.  A camera that looks down wouldn't
 * tell: it faces the floor all the same.  A level one does where the floor
 * is seen by a cosine of 0.2 or more. */
static void check_wrong_rows(void) {
  static scene level;
  convention upside_down = opengl;
  lighting l = usual();
  scene_draw(&level, &is_level);
  upside_down.flags |= HBIL_MATRIX_Y_DOWN;
  l.frame.depth.buffer = make_buffer(0, sizeof(plane), level.depth);
  l.frame.normal.buffer = make_buffer(0, sizeof(plane), level.normal);
  look(&l, &is_level, &opengl);
  run_once(&l, 1);
  const size_t right = l.sanitized.facing_away;
  look(&l, &is_level, &upside_down);
  run_once(&l, 1);
  check(right == 0 && l.sanitized.facing_away > PIXELS / 10,
        "with rows from the wrong end, %zu normals face away",
        l.sanitized.facing_away);
  clReleaseMemObject(l.frame.depth.buffer);
  clReleaseMemObject(l.frame.normal.buffer);
}

/* Gives A and B of a depth that isn't reversed: no depth is the far end's. */
static void check_wrong_depth(void) {
  lighting l = usual();
  l.frame.hardware_depth[0] = 1;
  l.frame.hardware_depth[1] = -NEAR_PLANE;
  run_once(&l, 1);
  check(drawn.sky_pixels > 0 && l.statistics.sky.pixels == 0,
        "with a wrong A and B, there is no sky");
}

/* --- stored programs --- */

static void count_message(hbil_message_kind kind, const char *message,
                          void *user) {
  int *counts = user;
  printf("# %s: %s\n", kind == HBIL_MESSAGE_ERROR ? "error" : "warning",
         message);
  ++counts[kind];
}

/* Frames of a context with a folder of programs.  The context goes before the
 * plan, and the plan while its last frame is under way.  Returns the number of
 * warnings, or -1 if anything is wrong. */
static int warnings_with_folder(const char *folder) {
  int counts[2] = {0}; /* by hbil_message_kind */
  hbil_context *own;
  lighting l = usual();
  succeed(hbil_context_create(self.context, self.device, &own),
          "hbil_context_create");
  succeed(hbil_context_set_callback(own, count_message, counts),
          "hbil_context_set_callback");
  succeed(hbil_context_set_program_folder(own, folder),
          "hbil_context_set_program_folder");
  succeed(hbil_plan_create(own, &l.config, &l.plan), "hbil_plan_create");
  hbil_context_destroy(own);
  run_frames(&l, 2);
  const bool second = shows(&sequence[1]);
  enqueue(&l);
  free_plan(&l);
  read_picture(&shown);
  const bool good = second && shows(&sequence[2]);
  return good && counts[HBIL_MESSAGE_ERROR] == 0 ? counts[HBIL_MESSAGE_WARNING]
                                                 : -1;
}

/* Removes a folder and returns how many files it had, or -1. */
static int remove_folder(const char *folder) {
  DIR *open = opendir(folder);
  const struct dirent *entry = open ? readdir(open) : NULL;
  int files = 0;
  for (; entry; entry = readdir(open))
    if (unlinkat(dirfd(open), entry->d_name, 0) == 0)
      ++files;
  if (open)
    closedir(open);
  return rmdir(folder) == 0 ? files : -1;
}

static void check_stored_programs(void) {
  char folder[] = "/tmp/hbil-adopter-XXXXXX";
  need(mkdtemp(folder) != NULL, "mkdtemp");
  const int not_stored = warnings_with_folder("/no/such");
  const int stored = warnings_with_folder(folder);
  const int loaded = warnings_with_folder(folder);
  const int files = remove_folder(folder);
  check(not_stored == 1, "programs that can't be stored are told once");
  check(files > 1 && stored == 0 && loaded == 0,
        "%d programs are stored, then loaded", files);
}

/* --- memory --- */

/* Other passes of the renderer use the memory between two frames. */
static void check_lent_memory(void) {
  hbil_memory needed;
  lighting l = usual();
  succeed(hbil_plan_memory(self.hbil, &l.config, &needed), "hbil_plan_memory");
  const cl_mem less = make_buffer(0, needed.scratch - 1, NULL);
  bool good = fails(hbil_plan_create_in(self.hbil, &l.config, less, &l.plan),
                    HBIL_INVALID_ARGUMENT, self.hbil, "scratch");
  clReleaseMemObject(less);
  some_scratch = make_buffer(0, needed.scratch, NULL);
  succeed(hbil_plan_create_in(self.hbil, &l.config, some_scratch, &l.plan),
          "hbil_plan_create_in");
  run_frames(&l, 1);
  need(clEnqueueFillBuffer(self.queue, some_scratch, "~", 1, 0, needed.scratch,
                           0, NULL, NULL) == CL_SUCCESS,
       "clEnqueueFillBuffer");
  run_frames(&l, 1);
  check(shows(&sequence[1]), "%zu bytes of lent memory may change in between",
        needed.scratch);
  good &= rejects_frame(&l, write_to_scratch, "scratch");
  check(good, "lent memory that is too small, or an output as well, is named");
  free_plan(&l);
  clReleaseMemObject(some_scratch);
}

/* --- stages --- */

/* The stages of a last frame: the ao that it has shown, but for roundings above
 * 1, and the inverse of its distances. */
static void check_stages(void) {
  static float ao[PIXELS], inverse[PIXELS];
  lighting l = usual();
  hbil_buffer none;
  bool same_ao = true, same_depth = true;
  make_plan(&l);
  run_frames(&l, 1);
  read_stage(&l, HBIL_STAGE_RESOLVED, ao);
  read_stage(&l, HBIL_STAGE_HISTORY, inverse);
  for (int i = 0; i < PIXELS; ++i) {
    const float depth = drawn.depth[i][0];
    if (depth == 0) {
      same_depth = same_depth && inverse[i] <= 0;
      continue;
    }
    same_ao = same_ao && fabsf(ao[i] - shown.light[i][3]) < 1e-6f;
    same_depth = same_depth && fabs(inverse[i] * NEAR_PLANE - depth) < 1e-7;
  }
  check(same_ao, "HBIL_STAGE_RESOLVED has the last frame's ao");
  check(same_depth, "HBIL_STAGE_HISTORY has its inverse depths");
  const hbil_status got =
      hbil_plan_buffer(l.plan, HBIL_STAGE_PROBE_HISTORY, &none);
  check(
      fails(got, HBIL_INVALID_ARGUMENT, self.hbil, "HBIL_STAGE_PROBE_HISTORY"),
      "a stage that a plan doesn't have is named");
  free_plan(&l);
}

/* --- a history that another plan adopts --- */

static cl_uint bounces_of(const lighting *l) {
  hbil_last_frame last;
  succeed(hbil_plan_last_frame(l->plan, &last), "hbil_plan_last_frame");
  return last.bounces;
}

/* The third frame of a plan, by another one that has seen none.  The camera
 * moves before it, and all that depends on the past is on. */
static void check_adoption(void) {
  static picture third;
  lighting first = usual();
  first.config.sampling.slices = first.config.sampling.slice_frames = 2;
  first.config.model.far_field = HBIL_FAR_FRAME;
  lighting second = first;
  make_plan(&first);
  make_plan(&second);
  run_frames(&first, 2);
  copy_stage(&first, &second, HBIL_STAGE_HISTORY);
  copy_stage(&first, &second, HBIL_STAGE_SLICES);
  hbil_last_frame last;
  succeed(hbil_plan_last_frame(first.plan, &last), "hbil_plan_last_frame");
  succeed(hbil_plan_adopt_history(second.plan, &last),
          "hbil_plan_adopt_history");
  first.frame.camera.world_from_view[3] += 0.01; /* world units */
  second.frame.camera = first.frame.camera;
  run_frames(&first, 1);
  third = shown;
  run_frames(&second, 1);
  check(bounces_of(&first) == 3 && bounces_of(&second) == 3,
        "three frames are three bounces, two of which may be adopted");
  check(shows(&third),
        "a plan that adopts a history has the next frame's bits");
  hbil_plan_reset(second.plan);
  run_frames(&second, 1);
  check(!shows(&third), "a plan without it has not");
  free_plan(&first);
  free_plan(&second);
}

/* --- settings that the first frame decides --- */

static hbil_host_plane host_plane(plane from, int channels) {
  hbil_host_plane out = {.pixel_pitch = 16};
  for (int i = 0; i < channels; ++i)
    out.channel[i] = &from[0][i];
  return out;
}

static void check_suggestions(void) {
  const hbil_source not_seen = HBIL_SOURCE_NOT_SEEN;
  const hbil_source in_direct = HBIL_SOURCE_IN_DIRECT;
  const hbil_source not_in_direct = HBIL_SOURCE_NOT_IN_DIRECT;
  const struct {
    const char *name;
    plane *direct, *emission;
    hbil_source sky, lamps;
    hbil_far_field far_field;
    cl_bool gather_emission;
  } cases[] = {{"a sky in direct light", &drawn.direct, &drawn.sky_light,
                in_direct, not_seen, HBIL_FAR_FRAME, CL_FALSE},
               {"a sky alone", &drawn.black, &drawn.sky_light, not_in_direct,
                not_seen, HBIL_FAR_CONSTANT, CL_FALSE},
               {"no sky", &drawn.direct, &drawn.black, not_seen, not_seen,
                HBIL_FAR_FRAME, CL_FALSE},
               {"a lamp alone", &drawn.black, &drawn.wall_light, not_seen,
                not_in_direct, HBIL_FAR_FRAME, CL_TRUE},
               {"everything emits", &drawn.black, &drawn.direct, not_in_direct,
                not_in_direct, HBIL_FAR_CONSTANT, CL_TRUE}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    const hbil_host_planes planes = {.depth = host_plane(drawn.depth, 1),
                                     .direct = host_plane(*cases[i].direct, 3),
                                     .emission =
                                         host_plane(*cases[i].emission, 3)};
    hbil_sources found = {.sky = not_seen};
    lighting l = usual();
    succeed(hbil_config_suggest(&planes, &l.config, &l.frame, &found),
            "hbil_config_suggest");
    check(found.sky == cases[i].sky && found.lamps == cases[i].lamps &&
              l.config.model.far_field == cases[i].far_field &&
              l.config.model.gather_emission == cases[i].gather_emission,
          "suggested: %s (sky %d, lamps %d)", cases[i].name, (int)found.sky,
          (int)found.lamps);
  }
}

int main(void) {
  open_renderer();
  check_sequences(); /* first: the others compare with its frames */
  check_timings();
  check_cameras();
  check_signed_depth();
  check_picture();
  check_packed_formats();
  check_normals_from_depth();
  check_images();
  check_wrong_matrices();
  check_wrong_frames();
  check_wrong_configurations();
  check_null_arguments();
  check_wrong_space();
  check_wrong_rows();
  check_wrong_depth();
  check_stored_programs();
  check_lent_memory();
  check_stages();
  check_adoption();
  check_suggestions();
  close_renderer();
  return finish_checks();
}
