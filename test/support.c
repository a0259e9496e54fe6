#include "support.h"

#include <stdio.h>

gpu test_gpu;

/* ------------------------------------------------------------------------ */
/* Device                                                                    */

static void hard_error(const char *what) {
  fprintf(stderr, "test set-up: %s\n", what);
  exit(99);
}

static bool is_pocl(cl_platform_id platform) {
  char name[256] = "";
  clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof(name), name, NULL);
  return strstr(name, "Portable Computing Language") != NULL;
}

static cl_device_id find_device(void) {
  cl_platform_id platforms[16];
  cl_uint count = 0;
  cl_device_id found = NULL;
  if (clGetPlatformIDs(16, platforms, &count) != CL_SUCCESS || count == 0)
    hard_error("no OpenCL platform; install pocl-opencl-icd");
  for (cl_uint i = 0; i < count && i < 16; ++i) {
    cl_device_id device;
    if (clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 1, &device, NULL) !=
        CL_SUCCESS)
      continue;
    if (is_pocl(platforms[i]))
      return device;
    found = found ? found : device;
  }
  if (!found)
    hard_error("no OpenCL device; install pocl-opencl-icd");
  return found;
}

gpu gpu_open(void) {
  gpu g;
  cl_int error;
  g.device = find_device();
  g.context = clCreateContext(NULL, 1, &g.device, NULL, NULL, &error);
  if (error != CL_SUCCESS)
    hard_error("clCreateContext failed");
  g.queue = clCreateCommandQueue(g.context, g.device, 0, &error);
  if (error != CL_SUCCESS)
    hard_error("clCreateCommandQueue failed");
  if (hbil_context_create(g.context, g.device, &g.hbil) != HBIL_SUCCESS)
    hard_error("hbil_context_create failed");
  return g;
}

void gpu_close(gpu *g) {
  hbil_context_destroy(g->hbil);
  clReleaseCommandQueue(g->queue);
  clReleaseContext(g->context);
}

int gpu_finish(int failures) {
  gpu_close(&test_gpu);
  return failures;
}

/* ------------------------------------------------------------------------ */
/* Images                                                                    */

typedef struct image_info {
  const char *name;
  int channels, first;
  size_t format, image;
} image_info;

#define IMAGE(field, channels, first)                                          \
  {                                                                            \
#field, channels, first, offsetof(hbil_config, field),                     \
        offsetof(hbil_frame, field)                                            \
  }

static const image_info images[PLANE_COUNT] = {
    IMAGE(depth, 1, EXACT_DEPTH),
    IMAGE(normal, 3, EXACT_NORMAL),
    IMAGE(albedo, 3, EXACT_ALBEDO),
    IMAGE(f0, 3, EXACT_F0),
    IMAGE(direct, 3, EXACT_DIRECT),
    IMAGE(emission, 3, EXACT_EMISSION),
    IMAGE(motion, 2, EXACT_MOTION),
    IMAGE(near_irradiance, 3, EXACT_NEAR_IRRADIANCE),
    IMAGE(far_irradiance, 3, EXACT_FAR_IRRADIANCE),
    IMAGE(ao, 1, EXACT_AO),
    IMAGE(bent_normal, 3, EXACT_BENT_NORMAL),
    IMAGE(cone_cosine, 1, EXACT_CONE_COSINE),
    IMAGE(indirect, 3, EXACT_INDIRECT),
    IMAGE(beauty, 3, EXACT_BEAUTY)};

const char *image_name(image_id id) {
  return images[id].name;
}

int image_channels(image_id id) {
  return images[id].channels;
}

int image_first(image_id id) {
  return images[id].first;
}

hbil_plane_format *image_format(hbil_config *config, image_id id) {
  return (hbil_plane_format *)((char *)config + images[id].format);
}

hbil_plane *image_slot(hbil_frame *frame, image_id id) {
  return (hbil_plane *)((char *)frame + images[id].image);
}

float half_to_float(uint16_t half) {
  int exponent = half >> 10 & 31, mantissa = half & 1023;
  float sign = half & 0x8000 ? -1.0f : 1.0f;
  if (exponent == 31)
    return mantissa ? NAN : sign * INFINITY;
  if (exponent == 0)
    return sign * ldexpf((float)mantissa, -24);
  return sign * ldexpf((float)(mantissa + 1024), exponent - 25);
}

/* To nearest, ties to even. */
uint16_t float_to_half(float value) {
  uint16_t sign = signbit(value) ? 0x8000 : 0;
  float size = fabsf(value);
  int exponent;
  if (isnan(value))
    return 0x7e00;
  if (size >= 65520.0f)
    return sign | 0x7c00;
  if (size < ldexpf(1.0f, -14))
    return (uint16_t)(sign | (int)rintf(ldexpf(size, 24)));
  frexpf(size, &exponent);
  /* a mantissa that rounds up to 2048 carries into the exponent by itself */
  return (uint16_t)(sign + ((exponent + 13) << 10) +
                    (int)rintf(ldexpf(size, 11 - exponent)));
}

static size_t component_size(hbil_component component) {
  return component == HBIL_FLOAT32 ? 4 : component == HBIL_FLOAT16 ? 2 : 1;
}

/* Where an image's components lie, in bytes. */
typedef struct placement {
  hbil_component component;
  size_t size, offset, pixel, row, plane, end;
} placement;

static placement place(const setup *s, image_id id) {
  const image_layout *layout = s->layout + id;
  hbil_config config = s->config;
  const hbil_plane_format *format = image_format(&config, id);
  size_t channels = (size_t)images[id].channels;
  size_t stride = format->stride ? format->stride : channels;
  placement p;
  p.component = format->component;
  p.size = component_size(format->component);
  p.offset = layout->offset * p.size;
  p.pixel = stride * p.size;
  p.row = config.width * p.pixel + layout->row_extra * p.size;
  p.plane = p.size;
  if (stride == 1)
    p.plane = p.row * config.height + layout->plane_extra * p.size;
  p.end = p.offset + p.row * config.height +
          (stride == 1 ? p.plane * (channels - 1) : 0);
  return p;
}

static size_t position(const placement *p, int channel, size_t x, size_t y) {
  return p->offset + (size_t)channel * p->plane + y * p->row + x * p->pixel;
}

static void encode(const placement *p, unsigned char *at, float value) {
  uint16_t half = float_to_half(value);
  if (p->component == HBIL_FLOAT32)
    memcpy(at, &value, 4);
  else if (p->component == HBIL_FLOAT16)
    memcpy(at, &half, 2);
  else
    *at = (unsigned char)lrintf(fminf(fmaxf(value, 0.0f), 1.0f) * 255.0f);
}

static float decode(const placement *p, const unsigned char *at) {
  float value;
  uint16_t half;
  if (p->component == HBIL_UNORM8)
    return (float)*at / 255.0f;
  if (p->component == HBIL_FLOAT16) {
    memcpy(&half, at, 2);
    return half_to_float(half);
  }
  memcpy(&value, at, 4);
  return value;
}

/* ------------------------------------------------------------------------ */
/* A plan and all around it                                                  */

static const hbil_plane_format single = {HBIL_FLOAT32, 1};
static const hbil_plane_format triple = {HBIL_FLOAT32, 3};

static bool has_image(const setup *s, image_id id) {
  hbil_config config = s->config;
  return image_format(&config, id)->component != HBIL_NONE;
}

static size_t pixels_of(const setup *s) {
  return (size_t)s->config.width * s->config.height;
}

void setup_init(setup *s, int width, int height) {
  memset(s, 0, sizeof(*s));
  s->gpu = &test_gpu;
  hbil_config_init(&s->config);
  /* exact planes: the packed ones have tests of their own, test_storage.c */
  s->config.storage = HBIL_STORAGE_FLOAT32;
  hbil_frame_init(&s->frame);
  s->config.width = (cl_uint)width;
  s->config.height = (cl_uint)height;
  for (image_id id = 0; id < PLANE_FIRST_OUTPUT; ++id)
    *image_format(&s->config, id) = image_channels(id) == 3 ? triple : single;
  s->config.f0.component = HBIL_NONE;
  s->config.near_irradiance = s->config.bent_normal = triple;
  s->config.ao = single;
  setup_camera(s, 60.0);
  for (int p = 0; p < EXACT_INPUT_PLANES; ++p) {
    s->input[p] = calloc(pixels_of(s), sizeof(float));
    assert_non_null(s->input[p]);
  }
}

void setup_camera(setup *s, double fov_y_degrees) {
  hbil_camera *camera = &s->frame.camera;
  memset(camera, 0, sizeof(*camera));
  camera->cx = 0.5 * s->config.width;
  camera->cy = 0.5 * s->config.height;
  camera->fx = camera->cy / tan(fov_y_degrees * PI / 360.0);
  camera->fy = camera->fx;
  for (int i = 0; i < 4; ++i)
    camera->world_from_view[5 * i] = 1.0;
}

void setup_flatten(setup *s, double width) {
  s->config.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  s->frame.camera.fx = s->frame.camera.fy = s->config.width / width;
}

void setup_load_scene(setup *s, scene_kind kind, uint32_t index) {
  setup_load_view(s, kind, 0.0, index); /* the scene's own */
}

void setup_load_view(setup *s, scene_kind kind, double fov_y_degrees,
                     uint32_t index) {
  scene_frame f;
  size_t size = pixels_of(s) * sizeof(float);
  const bool orthographic =
      s->config.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  if (orthographic ? scene_render_orthographic(kind, s->config.width,
                                               s->config.height, 0.0, index, &f)
                   : scene_render(kind, s->config.width, s->config.height,
                                  fov_y_degrees * PI / 180.0, index, &f))
    hard_error("scene_render: out of memory");
  s->frame.camera = f.camera;
  memcpy(s->input[EXACT_DEPTH], f.depth, size);
  for (int c = 0; c < 3; ++c) {
    memcpy(s->input[EXACT_NORMAL + c], f.normal[c], size);
    memcpy(s->input[EXACT_ALBEDO + c], f.albedo[c], size);
    memcpy(s->input[EXACT_DIRECT + c], f.direct[c], size);
    memcpy(s->input[EXACT_EMISSION + c], f.emission[c], size);
  }
  for (int c = 0; c < 2; ++c)
    memcpy(s->input[EXACT_MOTION + c], f.motion[c], size);
  scene_free(&f);
}

void setup_scene(setup *s, scene_kind kind, int width, int height,
                 uint32_t index) {
  setup_init(s, width, height);
  s->config.normal_space = HBIL_SPACE_WORLD;
  setup_load_scene(s, kind, index);
}

void setup_all_outputs(setup *s) {
  for (image_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    *image_format(&s->config, id) = image_channels(id) == 3 ? triple : single;
}

void setup_every_pass(setup *s, hbil_reprojection reprojection,
                      cl_uint vector_width, int width, int height) {
  setup_scene(s, SCENE_ROOM, width, height, 0);
  setup_all_outputs(s);
  s->config.storage = HBIL_STORAGE_PACKED;
  s->config.slices = 1;
  s->config.steps_per_side = 6;
  s->config.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.far_field = HBIL_FAR_FRAME;
  s->config.reprojection = reprojection;
  s->config.vector_width = vector_width;
}

void setup_keep_rows(setup *s, size_t rows, size_t of) {
  size_t with, without;
  s->config.horizon_cache_bytes = 0;
  assert_success(s, hbil_plan_memory(s->gpu->hbil, &s->config, &without));
  s->config.horizon_cache_bytes = SIZE_MAX;
  assert_success(s, hbil_plan_memory(s->gpu->hbil, &s->config, &with));
  /* but for a byte, a row more */
  s->config.horizon_cache_bytes = (with - without) / of * (rows + 1) - 1;
}

void setup_fill(setup *s, int plane, float value) {
  for (size_t i = 0; i < pixels_of(s); ++i)
    s->input[plane][i] = value;
}

cl_mem buffer_new(gpu *g, size_t size, const void *bytes) {
  cl_int error;
  cl_mem buffer =
      clCreateBuffer(g->context, CL_MEM_READ_WRITE, size, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  if (bytes)
    assert_int_equal(clEnqueueWriteBuffer(g->queue, buffer, CL_TRUE, 0, size,
                                          bytes, 0, NULL, NULL),
                     CL_SUCCESS);
  return buffer;
}

/* Bytes that are no part of an image: not-a-numbers in every format. */
#define CANARY 0xff
#define CANARY_BYTES 64

static void make_image(setup *s, image_id id) {
  const image_layout *layout = s->layout + id;
  hbil_plane *image = image_slot(&s->frame, id);
  placement p = place(s, id);
  unsigned char *bytes;
  s->bytes[id] = p.end + CANARY_BYTES;
  bytes = malloc(s->bytes[id]);
  assert_non_null(bytes);
  memset(bytes, CANARY, s->bytes[id]);
  image->buffer = buffer_new(s->gpu, s->bytes[id], bytes);
  image->offset = p.offset;
  image->row_pitch = layout->row_extra ? p.row : 0;
  image->plane_pitch = layout->plane_extra ? p.plane : 0;
  free(bytes);
}

void assert_success(const setup *s, hbil_status status) {
  if (status != HBIL_SUCCESS)
    fail_msg("%s: %s", hbil_status_string(status),
             hbil_context_message(s->gpu->hbil));
}

void setup_start(setup *s) {
  assert_success(s, hbil_plan_create(s->gpu->hbil, &s->config, &s->plan));
  for (image_id id = 0; id < PLANE_COUNT; ++id)
    if (has_image(s, id))
      make_image(s, id);
  setup_upload(s);
}

static void upload_image(setup *s, image_id id) {
  size_t size, width = s->config.width;
  cl_mem buffer = image_slot(&s->frame, id)->buffer;
  unsigned char *bytes = buffer_bytes(s, buffer, &size);
  placement p = place(s, id);
  for (int c = 0; c < images[id].channels; ++c)
    for (size_t i = 0; i < pixels_of(s); ++i) {
      unsigned char *at = bytes + position(&p, c, i % width, i / width);
      float *value = s->input[images[id].first + c] + i;
      encode(&p, at, *value);
      *value = decode(&p, at);
    }
  assert_int_equal(clEnqueueWriteBuffer(s->gpu->queue, buffer, CL_TRUE, 0, size,
                                        bytes, 0, NULL, NULL),
                   CL_SUCCESS);
  free(bytes);
}

void setup_upload(setup *s) {
  s->job.config = &s->config;
  s->job.camera = s->frame.camera;
  s->job.frame_index = s->frame.frame_index;
  memcpy(s->job.environment, s->frame.environment, sizeof(s->job.environment));
  for (image_id id = 0; id < PLANE_FIRST_OUTPUT; ++id) {
    bool has = has_image(s, id);
    if (has)
      upload_image(s, id);
    for (int c = 0; c < images[id].channels; ++c)
      s->job.input[images[id].first + c] =
          has ? s->input[images[id].first + c] : NULL;
  }
}

void setup_free(setup *s) {
  hbil_plan_destroy(s->plan);
  for (image_id id = 0; id < PLANE_COUNT; ++id)
    if (image_slot(&s->frame, id)->buffer)
      clReleaseMemObject(image_slot(&s->frame, id)->buffer);
  for (int p = 0; p < EXACT_INPUT_PLANES; ++p)
    free(s->input[p]);
}

void setup_run(setup *s, enqueue_function *pass) {
  assert_success(s, pass(s->plan, s->gpu->queue, &s->frame, 0, NULL, NULL));
  assert_int_equal(clFinish(s->gpu->queue), CL_SUCCESS);
}

unsigned char *buffer_bytes(setup *s, cl_mem buffer, size_t *size) {
  unsigned char *bytes;
  assert_int_equal(
      clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof(*size), size, NULL),
      CL_SUCCESS);
  bytes = malloc(*size);
  assert_non_null(bytes);
  assert_int_equal(clEnqueueReadBuffer(s->gpu->queue, buffer, CL_TRUE, 0, *size,
                                       bytes, 0, NULL, NULL),
                   CL_SUCCESS);
  return bytes;
}

/* Float index of a value in a stage's buffer. */
static size_t stage_index(const hbil_buffer *b, hbil_stage stage, int plane,
                          int x, int y) {
  size_t at = (size_t)plane * b->plane_pitch + b->origin;
  size_t i = (size_t)x, j = (size_t)y;
  if (stage == HBIL_STAGE_SPLIT || stage == HBIL_STAGE_GATHERED)
    return at + (4 * (j % 4) + i % 4) * b->layer_pitch + j / 4 * b->row_pitch +
           i / 4;
  return at + j * b->row_pitch + i;
}

static hbil_buffer stage_buffer(setup *s, hbil_stage stage) {
  hbil_buffer buffer;
  assert_success(s, hbil_plan_buffer(s->plan, stage, &buffer));
  return buffer;
}

/* --- packed planes, from their description in shared.h --- */

/* Cigolle and others 2014: |x| + |y| + |z| = 1, and what lies behind is folded
 * outwards over the diagonals. */
static double folded(double a, double b) {
  return copysign(1.0 - fabs(b), a);
}

uint32_t encode_normal(const double n[3]) {
  double size = fabs(n[0]) + fabs(n[1]) + fabs(n[2]), u = 0.0, v = 0.0;
  if (size > 0.0) {
    double x = n[0] / size, y = n[1] / size;
    u = n[2] > 0.0 ? folded(x, y) : x;
    v = n[2] > 0.0 ? folded(y, x) : y;
  }
  return ((uint32_t)lrint(u * 32767.0) & 0xffff) | (uint32_t)lrint(v * 32767.0)
                                                       << 16;
}

/* Two's complement in some of a word's bits. */
static double signed_bits(uint32_t word, int low, int bits) {
  int32_t value = (int32_t)(word >> low & ((1u << bits) - 1));
  return value >> (bits - 1) ? value - (1 << bits) : value;
}

void decode_normal(uint32_t word, double n[3]) {
  double u = signed_bits(word, 0, 16) / 32767.0;
  double v = signed_bits(word, 16, 16) / 32767.0;
  n[2] = fabs(u) + fabs(v) - 1.0;
  n[0] = n[2] > 0.0 ? folded(u, v) : u;
  n[1] = n[2] > 0.0 ? folded(v, u) : v;
  normalize(n);
}

double packed_unit(double most, int bits) {
  /* the exponent of a float's smallest normal number is the lowest there is */
  if (!(most > 0.0))
    return 0.0;
  const double unit = ldexp(1.0, (int)fmax(ilogb(most) + 1 - bits, -126));
  /* what rounds up to the next power of two has that one's unit */
  return most / unit < ldexp(1.0, bits) - 0.5 ? unit : 2.0 * unit;
}

/* Three mantissas; the exponent of their unit, biased as in a float. */
static uint32_t encode_light(const double light[3], int bits,
                             uint32_t *exponent) {
  double most = fmax(light[0], fmax(light[1], light[2]));
  double unit = packed_unit(most, bits);
  uint32_t word = 0;
  *exponent = 0;
  if (!(most > 0.0))
    return 0;
  for (int c = 0; c < 3; ++c)
    word |= (uint32_t)floor(light[c] / unit + 0.5) << (bits * c);
  *exponent = (uint32_t)(ilogb(unit) + 127);
  return word;
}

static void decode_light(uint32_t word, int bits, uint32_t exponent,
                         double light[3]) {
  for (int c = 0; c < 3; ++c)
    light[c] =
        ldexp(word >> (bits * c) & ((1u << bits) - 1), (int)exponent - 127);
}

static double layer_dither(int x, int y) {
  return ((hbil_direction_slot(4 * (y % 4) + x % 4) ^ 8) + 0.5) / 16.0;
}

/* `b` is no longer than 1: what a test plants. */
static uint32_t encode_bent(const double b[3], double dither) {
  uint32_t x = (uint32_t)(int)floor(b[0] * 1023.0 + dither);
  uint32_t y = (uint32_t)(int)floor(b[1] * 1023.0 + dither);
  uint32_t z = (uint32_t)(int)floor(b[2] * 511.0 + dither);
  return (x & 0x7ff) | (y & 0x7ff) << 11 | z << 22;
}

static void decode_bent(uint32_t word, double b[3]) {
  b[0] = signed_bits(word, 0, 11) / 1023.0;
  b[1] = signed_bits(word, 11, 11) / 1023.0;
  b[2] = signed_bits(word, 22, 10) / 511.0;
}

double decode_small(uint32_t bits, int mantissa) {
  int exponent = (int)(bits >> mantissa & 31);
  double fraction = ldexp(bits & ((1u << mantissa) - 1), -mantissa);
  assert_true(exponent < 31); /* infinity, not-a-numbers */
  return exponent ? ldexp(1.0 + fraction, exponent - 15) : ldexp(fraction, -14);
}

uint32_t encode_small(double value, int mantissa) {
  const double most = ldexp(2.0 - ldexp(1.0, -mantissa), 15);
  const double v = fmin(fmax(value, 0.0), most);
  const int exponent = v > 0.0 ? (int)fmax(ilogb(v), -14.0) : -14;
  /* a unit more than the largest mantissa is the next power of two */
  return (uint32_t)lrint(ldexp(v, mantissa - exponent)) +
         ((uint32_t)(exponent + 14) << mantissa);
}

static double decode_half(uint32_t word, int low) {
  double size = decode_small(word >> low & 0x7fff, 10);
  return word >> low & 0x8000 ? -size : size;
}

static uint32_t encode_half(double value) {
  return encode_small(fabs(value), 10) | (signbit(value) ? 0x8000 : 0);
}

static uint32_t encode_halves(double low, double high) {
  return encode_half(low) | encode_half(high) << 16;
}

/* A pixel's words, and the values that FLOAT32 keeps in their place. */
typedef struct packed_pixel {
  uint32_t word[4];
  double value[HBIL_GATHERED_PLANES];
} packed_pixel;

static void decode_radiance(hbil_storage storage, const uint32_t *word,
                            double light[3]) {
  if (storage == HBIL_STORAGE_PACKED) {
    decode_light(*word, 8, *word >> 24, light);
  } else if (storage == HBIL_STORAGE_HALF) {
    light[0] = decode_half(word[0], 0);
    light[1] = decode_half(word[0], 16);
    light[2] = decode_half(word[1], 0);
  } else {
    light[0] = decode_small(*word & 0x7ff, 6);
    light[1] = decode_small(*word >> 11 & 0x7ff, 6);
    light[2] = decode_small(*word >> 22, 5);
  }
}

static void encode_radiance(hbil_storage storage, const double light[3],
                            uint32_t *word) {
  uint32_t exponent;
  if (storage == HBIL_STORAGE_PACKED) {
    *word = encode_light(light, 8, &exponent);
    *word |= exponent << 24;
  } else if (storage == HBIL_STORAGE_HALF) {
    word[0] = encode_halves(light[0], light[1]);
    word[1] = encode_halves(light[2], 0.0);
  } else {
    *word = encode_small(light[0], 6) | encode_small(light[1], 6) << 11 |
            encode_small(light[2], 5) << 22;
  }
}

static void decode_split(hbil_storage storage, packed_pixel *p) {
  float w;
  memcpy(&w, p->word, sizeof(w));
  p->value[HBIL_SPLIT_W] = (double)w;
  decode_normal(p->word[HBIL_PACKED_NORMAL], p->value + HBIL_SPLIT_NORMAL);
  decode_radiance(storage, p->word + HBIL_PACKED_RADIANCE,
                  p->value + HBIL_SPLIT_RED);
}

static void encode_split(hbil_storage storage, packed_pixel *p) {
  float w = (float)p->value[HBIL_SPLIT_W];
  memcpy(p->word, &w, sizeof(w));
  p->word[HBIL_PACKED_NORMAL] = encode_normal(p->value + HBIL_SPLIT_NORMAL);
  encode_radiance(storage, p->value + HBIL_SPLIT_RED,
                  p->word + HBIL_PACKED_RADIANCE);
}

static void decode_halves_gathered(packed_pixel *p) {
  static const int planes[8] = {HBIL_LIGHT_AO,       HBIL_LIGHT_UNKNOWN,
                                HBIL_LIGHT_RED,      HBIL_LIGHT_RED + 1,
                                HBIL_LIGHT_RED + 2,  HBIL_LIGHT_BENT,
                                HBIL_LIGHT_BENT + 1, HBIL_LIGHT_BENT + 2};
  for (int i = 0; i < 8; ++i)
    p->value[planes[i]] = decode_half(p->word[i / 2], i % 2 * 16);
}

static void encode_halves_gathered(packed_pixel *p) {
  const double *near_irradiance = p->value + HBIL_LIGHT_RED;
  const double *bent = p->value + HBIL_LIGHT_BENT;
  p->word[HBIL_HALF_AO] =
      encode_halves(p->value[HBIL_LIGHT_AO], p->value[HBIL_LIGHT_UNKNOWN]);
  p->word[HBIL_HALF_NEAR] =
      encode_halves(near_irradiance[0], near_irradiance[1]);
  p->word[HBIL_HALF_NEAR + 1] = encode_halves(near_irradiance[2], bent[0]);
  p->word[HBIL_HALF_BENT] = encode_halves(bent[1], bent[2]);
}

static void decode_gathered(packed_pixel *p) {
  p->value[HBIL_LIGHT_AO] = (p->word[HBIL_PACKED_AO] & 0xffff) / 65535.0;
  p->value[HBIL_LIGHT_UNKNOWN] = (p->word[HBIL_PACKED_AO] >> 16 & 0xff) / 255.0;
  decode_light(p->word[HBIL_PACKED_NEAR], 10, p->word[HBIL_PACKED_AO] >> 24,
               p->value + HBIL_LIGHT_RED);
  decode_bent(p->word[HBIL_PACKED_BENT], p->value + HBIL_LIGHT_BENT);
}

static void encode_gathered(double dither, packed_pixel *p) {
  uint32_t exponent;
  p->word[HBIL_PACKED_NEAR] =
      encode_light(p->value + HBIL_LIGHT_RED, 10, &exponent);
  p->word[HBIL_PACKED_AO] =
      (uint32_t)lrint(p->value[HBIL_LIGHT_AO] * 65535.0) |
      (uint32_t)floor(fmin(p->value[HBIL_LIGHT_UNKNOWN], 0.999) * 255.0 +
                      dither)
          << 16 |
      exponent << 24;
  p->word[HBIL_PACKED_BENT] = encode_bent(p->value + HBIL_LIGHT_BENT, dither);
}

static void decode_pixel(hbil_storage storage, hbil_stage stage,
                         packed_pixel *p) {
  if (stage == HBIL_STAGE_SPLIT)
    decode_split(storage, p);
  else if (storage == HBIL_STORAGE_HALF)
    decode_halves_gathered(p);
  else
    decode_gathered(p);
}

static void encode_pixel(hbil_storage storage, hbil_stage stage, double dither,
                         packed_pixel *p) {
  if (stage == HBIL_STAGE_SPLIT)
    encode_split(storage, p);
  else if (storage == HBIL_STORAGE_HALF)
    encode_halves_gathered(p);
  else
    encode_gathered(dither, p);
}

static bool is_packed(const setup *s, hbil_stage stage) {
  return s->config.storage != HBIL_STORAGE_FLOAT32 &&
         (stage == HBIL_STAGE_SPLIT || stage == HBIL_STAGE_GATHERED);
}

/* Planes that FLOAT32 would have in place of those words. */
static int plain_planes(const setup *s, hbil_stage stage, int words) {
  const bool half = s->config.storage == HBIL_STORAGE_HALF;
  bool unknown = s->config.back_facing_fallback == HBIL_FALLBACK_FRAME_MEAN &&
                 s->config.facing_fade[1] > -1.0f;
  if (stage == HBIL_STAGE_SPLIT)
    return words > HBIL_PACKED_RADIANCE ? HBIL_SPLIT_PLANES : HBIL_SPLIT_RED;
  if (words == 1)
    return HBIL_LIGHT_RED;
  if (unknown)
    return HBIL_LIGHT_UNKNOWN + 1;
  return words == (half ? HBIL_HALF_BENT : HBIL_PACKED_BENT)
             ? HBIL_LIGHT_BENT
             : HBIL_LIGHT_PLANES;
}

/* --- stages --- */

/* A stage's buffer, brought here. */
typedef struct stage_bytes {
  hbil_buffer b;
  hbil_stage stage;
  hbil_storage storage;
  size_t size;
  float *floats;
  int weight; /* plane of a single slice's weights, behind b.values; 0: none */
} stage_bytes;

static stage_bytes stage_open(setup *s, hbil_stage stage) {
  stage_bytes t;
  t.b = stage_buffer(s, stage);
  t.stage = stage;
  t.storage = s->config.storage;
  t.weight = 0;
  if (stage == HBIL_STAGE_GATHERED && exact_weighs_slices(&s->config))
    t.weight = (int)--t.b.values;
  t.floats = (float *)(void *)buffer_bytes(s, t.b.buffer, &t.size);
  return t;
}

static float *stage_at(const stage_bytes *t, int plane, int x, int y) {
  size_t index = stage_index(&t->b, t->stage, plane, x, y);
  assert_true(index < t->size / sizeof(float));
  return t->floats + index;
}

static packed_pixel packed_at(const stage_bytes *t, int x, int y) {
  packed_pixel p = {{0, 0, 0, 0}, {0.0}};
  for (int i = 0; i < (int)t->b.values; ++i)
    memcpy(p.word + i, stage_at(t, i, x, y), sizeof(*p.word));
  decode_pixel(t->storage, t->stage, &p);
  return p;
}

static void read_packed(const stage_bytes *t, const exact_planes *out) {
  for (int y = 0; y < out->height; ++y)
    for (int x = 0; x < out->width; ++x) {
      packed_pixel p = packed_at(t, x, y);
      for (int i = 0; i < out->count; ++i)
        *exact_at(out, i, x, y) = p.value[i];
    }
}

static void write_packed(const stage_bytes *t, const exact_planes *planes) {
  for (int y = 0; y < planes->height; ++y)
    for (int x = 0; x < planes->width; ++x) {
      packed_pixel p = packed_at(t, x, y);
      for (int i = 0; i < planes->count; ++i)
        p.value[i] = *exact_at(planes, i, x, y);
      encode_pixel(t->storage, t->stage, layer_dither(x, y), &p);
      for (int i = 0; i < (int)t->b.values; ++i)
        memcpy(stage_at(t, i, x, y), p.word + i, sizeof(*p.word));
    }
}

exact_planes stage_read(setup *s, hbil_stage stage) {
  stage_bytes t = stage_open(s, stage);
  int count = (int)t.b.values;
  exact_planes out;
  if (is_packed(s, stage))
    count = plain_planes(s, stage, count);
  if (t.weight)
    count = HBIL_GATHERED_PLANES;
  out = checked_planes((int)s->config.width, (int)s->config.height, count);
  if (is_packed(s, stage))
    read_packed(&t, &out);
  else
    for (int p = 0; p < (int)t.b.values; ++p)
      for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x)
          *exact_at(&out, p, x, y) = (double)*stage_at(&t, p, x, y);
  for (int y = 0; t.weight && y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      *exact_at(&out, HBIL_LIGHT_WEIGHT, x, y) =
          (double)*stage_at(&t, t.weight, x, y);
  free(t.floats);
  return out;
}

void stage_write(setup *s, hbil_stage stage, const exact_planes *planes) {
  stage_bytes t = stage_open(s, stage);
  /* a plan keeps only those planes that its outputs need */
  int count = planes->count < (int)t.b.values ? planes->count : (int)t.b.values;
  if (is_packed(s, stage))
    write_packed(&t, planes);
  else
    for (int p = 0; p < count; ++p)
      for (int y = 0; y < planes->height; ++y)
        for (int x = 0; x < planes->width; ++x)
          *stage_at(&t, p, x, y) = (float)*exact_at(planes, p, x, y);
  for (int y = 0; t.weight && y < planes->height; ++y)
    for (int x = 0; x < planes->width; ++x)
      *stage_at(&t, t.weight, x, y) =
          (float)*exact_at(planes, HBIL_LIGHT_WEIGHT, x, y);
  assert_int_equal(clEnqueueWriteBuffer(s->gpu->queue, t.b.buffer, CL_TRUE, 0,
                                        t.size, t.floats, 0, NULL, NULL),
                   CL_SUCCESS);
  free(t.floats);
}

exact_planes gathered_over_turns(setup *s, int turns) {
  exact_planes sum = {0, 0, 0, NULL};
  setup_run(s, hbil_enqueue_split);
  for (int turn = 0; turn < turns; ++turn) {
    exact_planes one;
    size_t total;
    s->frame.frame_index = (cl_uint)turn;
    setup_run(s, hbil_enqueue_gather);
    one = stage_read(s, HBIL_STAGE_GATHERED);
    total = (size_t)one.width * (size_t)one.height * (size_t)one.count;
    if (turn == 0)
      sum = checked_planes(one.width, one.height, one.count);
    for (size_t i = 0; i < total; ++i)
      sum.values[i] += one.values[i] / turns;
    exact_planes_free(&one);
  }
  return sum;
}

/* Takes an output's values and overwrites them with the canary. */
static void take_output(setup *s, image_id id, unsigned char *bytes,
                        exact_planes *out) {
  placement p = place(s, id);
  for (int c = 0; c < images[id].channels; ++c)
    for (int y = 0; y < out->height; ++y)
      for (int x = 0; x < out->width; ++x) {
        unsigned char *at = bytes + position(&p, c, (size_t)x, (size_t)y);
        *exact_at(out, images[id].first + c, x, y) = (double)decode(&p, at);
        memset(at, CANARY, p.size);
      }
}

exact_planes outputs_read(setup *s) {
  exact_planes out = checked_planes((int)s->config.width, (int)s->config.height,
                                    EXACT_OUTPUT_PLANES);
  for (image_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id) {
    size_t size;
    unsigned char *bytes;
    if (!has_image(s, id))
      continue;
    bytes = buffer_bytes(s, image_slot(&s->frame, id)->buffer, &size);
    take_output(s, id, bytes, &out);
    for (size_t i = 0; i < size; ++i)
      if (bytes[i] != CANARY)
        fail_msg("%s: byte %zu outside the image was written", images[id].name,
                 i);
    free(bytes);
  }
  return out;
}

/* ------------------------------------------------------------------------ */
/* Numbers                                                                   */

/* Values of planes [first, first + count) and where they begin. */
static size_t range_of(const exact_planes *planes, int first, int count,
                       size_t *total) {
  size_t plane = (size_t)planes->width * (size_t)planes->height;
  *total = plane * (size_t)count;
  return plane * (size_t)first;
}

double relative_rmse(const exact_planes *got, const exact_planes *want,
                     int first, int count) {
  size_t total, start = range_of(want, first, count, &total);
  double off = 0.0, size = 0.0;
  for (size_t i = start; i < start + total; ++i) {
    double d = got->values[i] - want->values[i];
    off += d * d;
    size += want->values[i] * want->values[i];
  }
  if (!isfinite(off))
    return INFINITY;
  return size > 0.0 ? sqrt(off / size) : sqrt(off);
}

double largest_error(const exact_planes *got, const exact_planes *want,
                     int first, int count) {
  size_t total, start = range_of(want, first, count, &total);
  double largest = 0.0;
  for (size_t i = start; i < start + total; ++i) {
    double d = fabs(got->values[i] - want->values[i]);
    if (!isfinite(d))
      return INFINITY;
    largest = d > largest ? d : largest;
  }
  return largest;
}

double largest_value(const exact_planes *planes, int first, int count) {
  size_t total, start = range_of(planes, first, count, &total);
  double largest = 0.0;
  for (size_t i = start; i < start + total; ++i)
    largest = fmax(largest, fabs(planes->values[i]));
  return largest;
}

size_t count_different(const exact_planes *got, const exact_planes *want) {
  size_t total, different = 0;
  range_of(want, 0, want->count, &total);
  assert_int_equal(got->count, want->count);
  for (size_t i = 0; i < total; ++i)
    different += !(got->values[i] == want->values[i]);
  return different;
}

void check_at_most(const char *what, double value, double limit) {
  if (getenv("HBIL_TEST_VERBOSE"))
    fprintf(stderr, "%s: %.3g (limit %.3g)\n", what, value, limit);
  if (!(value <= limit))
    fail_msg("%s: %.9g is above %.9g", what, value, limit);
}

double random_unit(random_state *r) {
  uint64_t z = r->state += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

/* ------------------------------------------------------------------------ */
/* Frames and vectors                                                        */

#define SEQUENCE_LIMIT 1e-4
#define CONE_LIMIT 1e-3

void check_frame_outputs(setup *s, const exact_planes *want) {
  exact_planes got = outputs_read(s);
  for (image_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    if (image_format(&s->config, id)->component != HBIL_NONE)
      check_at_most(
          image_name(id),
          relative_rmse(&got, want, image_first(id), image_channels(id)),
          id == PLANE_CONE ? CONE_LIMIT : SEQUENCE_LIMIT);
  exact_planes_free(&got);
}

double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void cross(const double a[3], const double b[3], double out[3]) {
  for (int c = 0; c < 3; ++c)
    out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

/* a + s b */
void add(const double a[3], double s, const double b[3], double out[3]) {
  for (int c = 0; c < 3; ++c)
    out[c] = a[c] + s * b[c];
}

void normalize(double v[3]) {
  double size = sqrt(dot(v, v));
  for (int c = 0; c < 3; ++c)
    v[c] /= size;
}
