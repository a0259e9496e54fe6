/*
 * Planes that are image2d_t: the same frames as with buffers, and what is
 * rejected.
 */
#include "scene/store.h"
#include "test/support/layout.h"
#include "test/support/stages.h"

enum { WIDTH = 61, HEIGHT = 37, FRAMES = 4, LANES = 4 };

/* Formats that are tested, by what is left of a value. */
typedef struct kind {
  cl_channel_type type;
  size_t size;      /* bytes of a component */
  double direction; /* the largest error of a component of a unit vector */
} kind;

/* UNORM and SNORM: half a step, and as much again for a conversion that isn't
 * rounded to the nearest, as OpenCL allows up to 1.5 steps.  Half: 2^-11 of 1
 * at the nearest, twice that if truncated. */
static const kind floats = {CL_FLOAT, 4, 0.0},
                  halves = {CL_HALF_FLOAT, 2, 1.0 / 1024},
                  unorm8 = {CL_UNORM_INT8, 1, 1.5 * 2.0 / 255},
                  unorm16 = {CL_UNORM_INT16, 2, 1.5 * 2.0 / 65535},
                  snorm16 = {CL_SNORM_INT16, 2, 1.5 / 32767};

/* --- images of a setup's planes --- */

static cl_mem new_image(cl_mem_flags flags, const kind *k,
                        cl_channel_order order, size_t width, size_t height) {
  const cl_image_format format = {order, k->type};
  const cl_image_desc desc = {.image_type = CL_MEM_OBJECT_IMAGE2D,
                              .image_width = width,
                              .image_height = height};
  cl_int error;
  const cl_mem image =
      clCreateImage(shared_device.context, flags, &format, &desc, NULL, &error);
  /* rusticl 22.3 has few of the formats that OpenCL leaves to the driver */
  if (error == CL_IMAGE_FORMAT_NOT_SUPPORTED)
    skip();
  assert_int_equal(error, CL_SUCCESS);
  return image;
}

static void encode(const kind *k, bool is_direction, double v, void *to) {
  const float value = (float)v;
  unsigned char half[2];
  scene_store(HBIL_FLOAT16, false, &v, 1, sizeof half, half);
  const double unsigned_v = is_direction ? 0.5 * v + 0.5 : v;
  const uint8_t byte = (uint8_t)lrint(255.0 * fmin(fmax(unsigned_v, 0), 1));
  const uint16_t word = (uint16_t)lrint(65535.0 * fmin(fmax(unsigned_v, 0), 1));
  const int16_t snorm = (int16_t)lrint(32767.0 * fmin(fmax(v, -1), 1));
  const void *from = k->type == CL_FLOAT         ? (const void *)&value
                     : k->type == CL_HALF_FLOAT  ? (const void *)half
                     : k->type == CL_UNORM_INT8  ? (const void *)&byte
                     : k->type == CL_UNORM_INT16 ? (const void *)&word
                                                 : (const void *)&snorm;
  memcpy(to, from, k->size);
}

static double decode(const kind *k, bool is_direction, const void *from) {
  float value = 0.0f;
  uint16_t word = 0;
  int16_t snorm = 0;
  memcpy(&value, from, k->size < 4 ? 0 : 4);
  memcpy(&word, from, k->size < 2 ? 1 : 2); /* little endian, like PoCL's */
  memcpy(&snorm, from, k->size < 2 ? 1 : 2);
  const double scale = is_direction ? 2.0 : 1.0, shift = is_direction ? 1 : 0;
  switch (k->type) {
  case CL_FLOAT:
    return (double)value;
  case CL_HALF_FLOAT:
    return component_value(HBIL_FLOAT16, from, 0);
  case CL_UNORM_INT8:
    return scale * word / 255.0 - shift;
  case CL_UNORM_INT16:
    return scale * word / 65535.0 - shift;
  }
  return fmax(snorm / 32767.0, -1.0);
}

static bool is_direction(plane_id id) {
  return id == PLANE_NORMAL || id == PLANE_BENT;
}

/* Lanes of the images: one for planes of one channel, else four.  PoCL 3.1
 * reads wrong values from images of one half, and does not write them. */
static size_t lanes_of(plane_id id, const kind *k) {
  return plane_channels(id) == 1 && k != &halves ? 1 : LANES;
}

static void transfer(cl_mem image, bool write, void *bytes) {
  const size_t origin[3] = {0, 0, 0}, region[3] = {WIDTH, HEIGHT, 1};
  assert_int_equal(
      write ? clEnqueueWriteImage(shared_device.queue, image, CL_TRUE, origin,
                                  region, 0, 0, bytes, 0, NULL, NULL)
            : clEnqueueReadImage(shared_device.queue, image, CL_TRUE, origin,
                                 region, 0, 0, bytes, 0, NULL, NULL),
      CL_SUCCESS);
}

/* Writes an input of the setup to an image. */
static void write_input(const setup *s, plane_id id, const kind *k,
                        cl_mem image) {
  const size_t lanes = lanes_of(id, k);
  unsigned char *bytes = calloc((size_t)WIDTH * HEIGHT * lanes, k->size);
  assert_non_null(bytes);
  for (size_t i = 0; i < WIDTH * HEIGHT; ++i)
    for (int c = 0; c < plane_channels(id); ++c)
      encode(k, is_direction(id), (double)s->input[plane_first(id) + c][i],
             bytes + (i * lanes + (size_t)c) * k->size);
  transfer(image, true, bytes);
  free(bytes);
}

/* Reads an output; other channels must be 0, and alpha 1. */
static void read_output(plane_id id, const kind *k, cl_mem image,
                        exact_planes *out) {
  const size_t lanes = lanes_of(id, k);
  unsigned char *bytes = malloc((size_t)WIDTH * HEIGHT * lanes * k->size);
  assert_non_null(bytes);
  transfer(image, false, bytes);
  for (size_t i = 0; i < WIDTH * HEIGHT; ++i)
    for (size_t c = 0; c < lanes; ++c) {
      const unsigned char *at = bytes + (i * lanes + c) * k->size;
      if (c < (size_t)plane_channels(id))
        *exact_at(out, plane_first(id) + (int)c, (int)(i % WIDTH),
                  (int)(i / WIDTH)) = decode(k, is_direction(id), at);
      else
        assert_true(decode(k, false, at) == (c == 3 ? 1.0 : 0.0));
    }
  free(bytes);
}

/* --- two plans: with buffers and with images --- */

typedef struct pair {
  setup s;            /* with buffers */
  hbil_config config; /* with images */
  hbil_frame frame;
  hbil_plan *plan;
  const kind *kinds[PLANE_COUNT]; /* NULL: a buffer */
} pair;

static void pair_begin(pair *p, const kind *inputs, const kind *outputs) {
  setup_scene(&p->s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  setup_all_outputs(&p->s);
  p->s.config.outputs.glossy = three_floats;
  p->s.config.history.reprojection = HBIL_REPROJECTION_MOTION;
  p->plan = NULL;
  for (plane_id id = 0; id < PLANE_COUNT; ++id)
    p->kinds[id] = id < PLANE_FIRST_OUTPUT ? inputs : outputs;
  p->kinds[PLANE_F0] = NULL;
}

/* Creates both plans and all planes. */
static void pair_start(pair *p) {
  setup_start(&p->s);
  p->config = p->s.config;
  p->frame = p->s.frame;
  for (plane_id id = 0; id < PLANE_COUNT; ++id)
    if (p->kinds[id]) {
      const hbil_plane image = {
          .buffer = new_image(
              id < PLANE_FIRST_OUTPUT ? CL_MEM_READ_ONLY : CL_MEM_WRITE_ONLY,
              p->kinds[id], lanes_of(id, p->kinds[id]) == 1 ? CL_R : CL_RGBA,
              WIDTH, HEIGHT)};
      *plane_format(&p->config, id) = (hbil_plane_format){HBIL_IMAGE, 0};
      *plane_slot(&p->frame, id) = image;
    }
  assert_success(&p->s,
                 hbil_plan_create(p->s.device->hbil, &p->config, &p->plan));
}

static void pair_upload(pair *p) {
  setup_upload(&p->s);
  p->frame.camera = p->s.frame.camera;
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id)
    if (p->kinds[id])
      write_input(&p->s, id, p->kinds[id], plane_slot(&p->frame, id)->buffer);
}

static void run(pair *p, enqueue_function *pass) {
  assert_success(&p->s,
                 pass(p->plan, p->s.device->queue, &p->frame, 0, NULL, NULL));
  assert_int_equal(clFinish(p->s.device->queue), CL_SUCCESS);
}

static exact_planes image_outputs(pair *p) {
  exact_planes out = checked_planes(WIDTH, HEIGHT, EXACT_OUTPUT_PLANES);
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    read_output(id, p->kinds[id], plane_slot(&p->frame, id)->buffer, &out);
  return out;
}

static void pair_end(pair *p) {
  hbil_plan_destroy(p->plan);
  for (plane_id id = 0; id < PLANE_COUNT; ++id)
    if (p->kinds[id])
      clReleaseMemObject(plane_slot(&p->frame, id)->buffer);
  setup_free(&p->s);
}

/* --- the same frames --- */

/* The last frame is a static one. */
static void load_frame(pair *p, int frame) {
  const bool still = frame == FRAMES - 1;
  setup_load_scene(&p->s, SCENE_ROOM, (uint32_t)(still ? frame - 1 : frame));
  for (int c = 0; c < 2 && still; ++c)
    setup_fill(&p->s, EXACT_MOTION + c, 0.0f);
  p->s.frame.static_frame = p->frame.static_frame = still;
  pair_upload(p);
}

static void frames_have_the_same_bits(pair *p) {
  pair_start(p);
  for (int frame = 0; frame < FRAMES; ++frame) {
    load_frame(p, frame);
    setup_run(&p->s, hbil_enqueue_frame);
    run(p, hbil_enqueue_frame);
    exact_planes want = outputs_read(&p->s), got = image_outputs(p);
    assert_int_equal(count_different(&got, &want), 0);
    planes_free(&want, &got);
  }
  pair_end(p);
}

TEST(float_images_give_the_same_bits) {
  pair p;
  pair_begin(&p, &floats, &floats);
  frames_have_the_same_bits(&p);
}

TEST(so_they_do_with_shared_slices) {
  pair p;
  pair_begin(&p, &floats, &floats);
  p.s.config.sampling.slice_frames = 2;
  frames_have_the_same_bits(&p);
}

/* Numbers that a conversion might change. */
TEST(special_values_give_the_same_bits) {
  pair p;
  pair_begin(&p, &floats, &floats);
  pair_start(&p);
  load_frame(&p, 0);
  const float values[] = {NAN,   INFINITY, -INFINITY, -0.0f,
                          -1.0f, 1e-30f,   3e38f};
  for (int plane = 0; plane < EXACT_INPUT_PLANES; ++plane)
    for (size_t i = 0; i < 7; ++i)
      p.s.input[plane][(size_t)(31 * plane + 300) * (i + 1) %
                       (WIDTH * HEIGHT)] = values[i];
  pair_upload(&p);
  setup_run(&p.s, hbil_enqueue_frame);
  run(&p, hbil_enqueue_frame);
  exact_planes want = outputs_read(&p.s), got = image_outputs(&p);
  assert_int_equal(count_different(&got, &want), 0);
  planes_free(&want, &got);
  pair_end(&p);
}

TEST(passes_one_by_one_give_the_same_bits) {
  pair p;
  pair_begin(&p, &floats, &floats);
  pair_start(&p);
  for (int frame = 0; frame < 2; ++frame) {
    load_frame(&p, frame);
    setup_run(&p.s, hbil_enqueue_frame);
    for (int i = 0; i < PASSES; ++i)
      run(&p, passes[i]);
  }
  exact_planes want = outputs_read(&p.s), got = image_outputs(&p);
  assert_int_equal(count_different(&got, &want), 0);
  planes_free(&want, &got);
  pair_end(&p);
}

/* --- formats with fewer bits --- */

TEST(inputs_of_half_images_are_those_of_half_planes) {
  pair p;
  pair_begin(&p, &halves, &floats);
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id)
    plane_format(&p.s.config, id)->component =
        p.kinds[id] ? HBIL_FLOAT16 : HBIL_NONE;
  frames_have_the_same_bits(&p);
}

TEST(colours_of_unorm_images_are_those_of_unorm_planes) {
  pair p;
  pair_begin(&p, NULL, &floats);
  p.kinds[PLANE_ALBEDO] = &unorm8;
  p.s.config.inputs.albedo.component = HBIL_UNORM8;
  pair_start(&p);
  load_frame(&p, 0);
  setup_run(&p.s, hbil_enqueue_frame);
  run(&p, hbil_enqueue_frame);
  exact_planes want = outputs_read(&p.s), got = image_outputs(&p);
  /* v / 255 and v (1 / 255) differ by a rounding */
  check_at_most("outputs", relative_rmse(&got, &want, 0, EXACT_OUTPUT_PLANES),
                1e-6);
  planes_free(&want, &got);
  pair_end(&p);
}

/* Normals as (n+1)/2, and bent normals, each within its quantisation. */
TEST(directions_keep_their_sign) {
  static const kind *const kinds[] = {&unorm8, &unorm16, &snorm16, &halves};
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
    pair p;
    pair_begin(&p, NULL, &floats);
    p.kinds[PLANE_NORMAL] = p.kinds[PLANE_BENT] = kinds[i];
    pair_start(&p);
    load_frame(&p, 0);
    setup_run(&p.s, hbil_enqueue_frame);
    run(&p, hbil_enqueue_frame);
    exact_planes want = stage_read(&p.s, HBIL_STAGE_SPLIT);
    hbil_plan *const buffers = p.s.plan;
    p.s.plan = p.plan;
    exact_planes got = stage_read(&p.s, HBIL_STAGE_SPLIT);
    p.s.plan = buffers;
    /* the vector's length is off as much as a component, hence twice */
    check_at_most("normals", largest_error(&got, &want, HBIL_SPLIT_NORMAL, 3),
                  2.0 * kinds[i]->direction);
    planes_free(&want, &got);
    pair_end(&p);
  }
}

TEST(outputs_keep_their_values) {
  static const kind *const kinds[] = {&halves, &unorm8, &unorm16, &snorm16};
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
    pair p;
    pair_begin(&p, NULL, kinds[i]);
    p.s.config.model.far_field = HBIL_FAR_FRAME; /* for `unknown` */
    pair_start(&p);
    load_frame(&p, 0);
    setup_run(&p.s, hbil_enqueue_frame);
    run(&p, hbil_enqueue_frame);
    exact_planes want = outputs_read(&p.s), got = image_outputs(&p);
    check_at_most("bent normals",
                  largest_error(&got, &want, EXACT_BENT_NORMAL, 3),
                  kinds[i]->direction);
    check_at_most("ao", largest_error(&got, &want, EXACT_AO, 1),
                  kinds[i]->direction);
    assert_true(largest_value(&want, EXACT_UNKNOWN, 1) > 0.1);
    check_at_most("unknown", largest_error(&got, &want, EXACT_UNKNOWN, 1),
                  kinds[i]->direction);
    planes_free(&want, &got);
    pair_end(&p);
  }
}

/* Light beyond the largest half is that, as in half planes. */
TEST(bright_light_is_clipped_in_halves) {
  pair p;
  pair_begin(&p, NULL, &halves);
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    plane_format(&p.s.config, id)->component = HBIL_FLOAT16;
  p.s.config.inputs.direct_scale = 1e9f;
  pair_start(&p);
  load_frame(&p, 0);
  setup_run(&p.s, hbil_enqueue_frame);
  run(&p, hbil_enqueue_frame);
  exact_planes want = outputs_read(&p.s), got = image_outputs(&p);
  assert_true(largest_value(&want, EXACT_BEAUTY, 3) == 65504.0);
  assert_true(largest_value(&got, EXACT_BEAUTY, 3) == 65504.0);
  planes_free(&want, &got);
  pair_end(&p);
}

/* --- memory, timings --- */

/* Bytes that the device aligns buffers to. */
static size_t base_alignment(void) {
  cl_uint bits;
  assert_int_equal(clGetDeviceInfo(shared_device.id,
                                   CL_DEVICE_MEM_BASE_ADDR_ALIGN, sizeof bits,
                                   &bits, NULL),
                   CL_SUCCESS);
  return bits / 8;
}

/* Bytes of the plan's own plane of floats.  Rows are multiples of 64 floats for
 * any vector width, since WIDTH is 61. */
static size_t plane_of_plan(int channels, size_t alignment) {
  const size_t bytes = (size_t)channels * 64 * HEIGHT * sizeof(float);
  return (bytes + alignment - 1) / alignment * alignment;
}

TEST(memory_and_times_are_counted) {
  pair p;
  hbil_buffer history;
  size_t with, without, second, planes = 0;
  double ms[HBIL_PASS_COUNT];
  cl_int error;
  device_fixture profiled = shared_device;
  profiled.queue = clCreateCommandQueue(shared_device.context, shared_device.id,
                                        CL_QUEUE_PROFILING_ENABLE, &error);
  assert_int_equal(error, CL_SUCCESS);
  pair_begin(&p, &floats, &floats);
  p.s.device = &profiled;
  p.s.config.execution.profiling = CL_TRUE;
  pair_start(&p);
  load_frame(&p, 0);
  without = setup_memory(&p.s);
  hbil_memory images;
  assert_success(&p.s, hbil_plan_memory(profiled.hbil, &p.config, &images));
  with = images.persistent + images.scratch;
  for (plane_id id = 0; id < PLANE_COUNT; ++id)
    if (p.kinds[id])
      planes += plane_of_plan(plane_channels(id), base_alignment());
  assert_success(&p.s, hbil_plan_buffer(p.plan, HBIL_STAGE_HISTORY, &history));
  assert_int_equal(clGetMemObjectInfo(history.buffer, CL_MEM_SIZE,
                                      sizeof second, &second, NULL),
                   CL_SUCCESS);
  /* outputs in images need a second history */
  assert_int_equal(with - without, planes + second);
  setup_run(&p.s, hbil_enqueue_frame);
  assert_success(&p.s, hbil_plan_timings(p.s.plan, ms));
  assert_true(ms[HBIL_PASS_IMPORT] == 0.0 && ms[HBIL_PASS_EXPORT] == 0.0);
  run(&p, hbil_enqueue_frame);
  assert_success(&p.s, hbil_plan_timings(p.plan, ms));
  assert_true(ms[HBIL_PASS_IMPORT] > 0.0 && ms[HBIL_PASS_EXPORT] > 0.0);
  assert_string_equal(hbil_pass_name(HBIL_PASS_IMPORT), "import");
  assert_string_equal(hbil_pass_name(HBIL_PASS_EXPORT), "export");
  pair_end(&p);
  clReleaseCommandQueue(profiled.queue);
}

/* --- what is rejected --- */

/* Enqueues a frame with another object in the place of a plane. */
static void rejected(pair *p, plane_id id, cl_mem object, const char *why) {
  const hbil_plane good = *plane_slot(&p->frame, id);
  plane_slot(&p->frame, id)->buffer = object;
  assert_int_equal(
      hbil_enqueue_frame(p->plan, p->s.device->queue, &p->frame, 0, NULL, NULL),
      HBIL_INVALID_FRAME);
  const char *message = hbil_context_message(p->s.device->hbil);
  if (strncmp(message, plane_name(id), strlen(plane_name(id))) ||
      !strstr(message, why))
    fail_msg("%s: \"%s\" has no \"%s\"", plane_name(id), message, why);
  *plane_slot(&p->frame, id) = good;
}

static void rejected_image(pair *p, plane_id id, cl_mem image,
                           const char *why) {
  rejected(p, id, image, why);
  clReleaseMemObject(image);
}

TEST(other_objects_are_rejected_by_name) {
  static const kind integers = {CL_UNSIGNED_INT8, 1, 0.0};
  pair p;
  cl_int error;
  pair_begin(&p, &floats, &floats);
  pair_start(&p);
  load_frame(&p, 0);
  rejected(&p, PLANE_DEPTH, NULL, "missing");
  rejected(&p, PLANE_DEPTH, p.s.frame.depth.buffer, "image2d_t");
  rejected(&p, PLANE_AO, p.s.frame.ao.buffer, "image2d_t");
  rejected_image(&p, PLANE_DEPTH,
                 new_image(CL_MEM_READ_ONLY, &floats, CL_R, WIDTH + 1, HEIGHT),
                 "62 x 37 pixels; must be 61 x 37");
  rejected_image(
      &p, PLANE_BEAUTY,
      new_image(CL_MEM_READ_WRITE, &floats, CL_RGBA, WIDTH, HEIGHT - 1),
      "61 x 36 pixels; must be 61 x 37");
  rejected_image(&p, PLANE_ALBEDO,
                 new_image(CL_MEM_READ_ONLY, &floats, CL_R, WIDTH, HEIGHT),
                 "1 channels; must have 3");
  rejected_image(&p, PLANE_ALBEDO,
                 new_image(CL_MEM_READ_ONLY, &integers, CL_RGBA, WIDTH, HEIGHT),
                 "type 0x10da");
  rejected_image(&p, PLANE_ALBEDO,
                 new_image(CL_MEM_WRITE_ONLY, &floats, CL_RGBA, WIDTH, HEIGHT),
                 "CL_MEM_WRITE_ONLY");
  rejected_image(&p, PLANE_AO,
                 new_image(CL_MEM_READ_ONLY, &floats, CL_R, WIDTH, HEIGHT),
                 "CL_MEM_READ_ONLY");
  p.frame.albedo.row_pitch = 16 * WIDTH;
  rejected(&p, PLANE_ALBEDO, p.frame.albedo.buffer, "must be 0");
  p.frame.albedo.row_pitch = 0;
  const cl_context others =
      clCreateContext(NULL, 1, &shared_device.id, NULL, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  const cl_image_format format = {CL_R, CL_FLOAT};
  const cl_image_desc desc = {.image_type = CL_MEM_OBJECT_IMAGE2D,
                              .image_width = WIDTH,
                              .image_height = HEIGHT};
  rejected_image(&p, PLANE_DEPTH,
                 clCreateImage(others, 0, &format, &desc, NULL, &error),
                 "context");
  clReleaseContext(others);
  run(&p, hbil_enqueue_frame); /* as it was */
  pair_end(&p);
}
