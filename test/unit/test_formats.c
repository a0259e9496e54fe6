/*
 * Every format of the inputs is read as hbil_formats.h defines it: codes on the
 * device against their values in double precision, all of them or a dense
 * sweep.
 */
#include <stdio.h>

#include "scene/store.h"
#include "test/support/stages.h"

#define EACH(list) sizeof(list) / sizeof(*(list))

/* A rounding to the nearest float, relative. */
#define ROUNDING 0x1p-24

/* An integer for each number that looks random, and a different one for each.
 */
static uint32_t scattered(uint32_t i) {
  i *= 2654435761u;
  return (i ^ i >> 15) * 2246822519u;
}

/* The placement and the bytes of an input, which must be written back. */
static unsigned char *input_bytes(setup *s, plane_id id, placement *p,
                                  size_t *size) {
  *p = place_plane(&s->config, id, s->layout + id);
  return buffer_bytes(s->device, plane_slot(&s->frame, id)->buffer, size);
}

static void put_code(const placement *p, unsigned char *at, uint32_t code) {
  const uint8_t byte = (uint8_t)code;
  const uint16_t two = (uint16_t)code;
  memcpy(at,
         p->size == 1   ? (void *)&byte
         : p->size == 2 ? (void *)&two
                        : (void *)&code,
         p->size);
}

/* ------------------------------------------------------------------------ */
/* Colours                                                                   */

/* Emission is shown by the sky as it is. */
static void start_sky(setup *s, hbil_component component, cl_uint stride,
                      cl_uint vector_width, int width) {
  setup_init(s, width, 256);
  setup_no_outputs(s);
  s->config.outputs.beauty = three_floats;
  s->config.inputs.emission = pitched_format(component, stride);
  s->config.execution.vector_width = vector_width;
  setup_start(s);
}

/* Codes of every value: of each component, or of each channel of a word. */
static void check_colours(hbil_component component, cl_uint stride,
                          cl_uint vector_width, int width, double roundings) {
  setup s;
  placement p;
  size_t size, wrong = 0;
  start_sky(&s, component, stride, vector_width, width);
  unsigned char *bytes = input_bytes(&s, PLANE_EMISSION, &p, &size);
  const bool word = scene_is_word(component);
  for (size_t i = 0; i < setup_pixels(&s); ++i)
    for (int c = 0; c < (word ? 1 : 3); ++c)
      put_code(&p,
               bytes +
                   placement_of(&p, c, i % s.config.width, i / s.config.width),
               word ? scattered((uint32_t)i)
                    : (uint32_t)i * (2u * (uint32_t)c + 1u));
  buffer_write(s.device, s.frame.emission.buffer, 0, size, bytes);
  /* the only pass that shows what it reads; others would have to be compiled */
  setup_run(&s, enqueue_composite);
  exact_planes out = outputs_read(&s);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < width; ++x) {
        const size_t at = placement_of(&p, word ? 0 : c, (size_t)x, (size_t)y);
        const double value = component_value(component, bytes + at, c);
        const double want = value >= 0.0 && value <= 1e30 ? value : 0.0;
        const double got = *exact_at(&out, EXACT_BEAUTY + c, x, y);
        wrong += !(fabs(got - want) <= roundings * ROUNDING * want);
      }
  assert_int_equal(wrong, 0);
  free(bytes);
  exact_planes_free(&out);
  setup_free(&s);
}

/* 256 x 256 pixels have all codes of 16 bits. */
TEST(every_code_of_a_colour_is_read) {
  /* derived: the roundings of a reciprocal and of a product; the parts of a
   * float are taken over exactly.  sRGB: what the header of
   * decode_srgb8() says */
  const struct {
    hbil_component component;
    double roundings;
  } all[] = {{HBIL_UNORM8, 2},          {HBIL_UNORM16, 4},
             {HBIL_FLOAT16, 0},         {HBIL_RGB10A2_UNORM, 8},
             {HBIL_R11G11B10_FLOAT, 0}, {HBIL_RGB9E5_FLOAT, 0},
             {HBIL_SRGB8, 12.5}};
  const cl_uint lanes[] = {16, 1, 4, 8};
  /* in each layout, by each width of vectors, though not in all combinations */
  for (size_t i = 0; i < EACH(all); ++i) {
    check_colours(all[i].component, i & 1 ? 0 : 1, 0, 256, all[i].roundings);
    check_colours(all[i].component, i & 1 ? 1 : 4, lanes[i % 4], 251,
                  all[i].roundings);
  }
}

/* ------------------------------------------------------------------------ */
/* Normals                                                                   */

static double normal_value(hbil_component component, const unsigned char *at,
                           int channel) {
  const double v = component_value(component, at, channel);
  const bool unorm = component == HBIL_UNORM8 || component == HBIL_UNORM16 ||
                     component == HBIL_RGB10A2_UNORM;
  return unorm ? 2.0 * v - 1.0 : v;
}

/* The unit normal in view space of what is stored, and its length. */
static double wanted_normal(const setup *s, const placement *p,
                            const unsigned char *bytes, int x, int y,
                            double n[3]) {
  const bool word = s->config.inputs.normal.component == HBIL_RGB10A2_UNORM;
  const bool map = s->config.inputs.normal_encoding == HBIL_NORMAL_OCTAHEDRAL;
  double length = 0.0;
  for (int c = 0; c < (map ? 2 : 3); ++c)
    n[c] = normal_value(
        p->component,
        bytes + placement_of(p, word ? 0 : c, (size_t)x, (size_t)y), c);
  if (map)
    octahedral_normal((const double[2]){n[0], n[1]}, n);
  if (s->config.inputs.normal_space == HBIL_SPACE_WORLD)
    n[1] = -n[1], n[2] = -n[2]; /* turned about x */
  for (int c = 0; c < 3; ++c)
    length += n[c] * n[c];
  length = sqrt(length);
  for (int c = 0; c < 3; ++c)
    n[c] /= length;
  return length;
}

/* Codes of 8 bits in all pairs, and others all over their range. */
static void store_normals(setup *s, const placement *p, unsigned char *bytes) {
  for (uint32_t i = 0; i < setup_pixels(s); ++i)
    for (int c = 0; c < (p->component == HBIL_RGB10A2_UNORM ? 1 : 3); ++c) {
      const uint32_t x = i % s->config.width, y = i / s->config.width;
      uint32_t code = scattered(3u * i + (uint32_t)c);
      const double real = code * 0x1p-31 - 1.0;
      if (p->size == 1 && c < 2)
        code = c == 0 ? x : y;
      if (c == 2 && s->config.inputs.normal_encoding == HBIL_NORMAL_OCTAHEDRAL)
        continue;
      if (p->component == HBIL_FLOAT32 || p->component == HBIL_FLOAT16)
        scene_store(p->component, false, &real, 1, 0,
                    bytes + placement_of(p, c, x, y));
      else
        put_code(p, bytes + placement_of(p, c, x, y), code);
    }
}

static void check_normals(hbil_component component,
                          hbil_normal_encoding encoding, bool turned,
                          cl_uint stride, cl_uint vector_width) {
  setup s;
  placement p;
  size_t size, wrong = 0, seen = 0;
  setup_init(&s, 256, 256);
  setup_flatten(&s, 4.0); /* all rays are along z */
  setup_fill(&s, EXACT_DEPTH, 3.0f);
  s.config.inputs.normal = pitched_format(component, stride);
  s.config.inputs.normal_encoding = encoding;
  s.config.execution.vector_width = vector_width;
  if (turned) {
    s.config.inputs.normal_space = HBIL_SPACE_WORLD;
    s.frame.camera.world_from_view[5] = -1.0;
    s.frame.camera.world_from_view[10] = -1.0;
  }
  setup_start(&s);
  unsigned char *bytes = input_bytes(&s, PLANE_NORMAL, &p, &size);
  store_normals(&s, &p, bytes);
  buffer_write(s.device, s.frame.normal.buffer, 0, size, bytes);
  setup_run(&s, enqueue_split);
  exact_planes got = stage_read(&s, HBIL_STAGE_SPLIT);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      double want[3];
      const double length = wanted_normal(&s, &p, bytes, x, y, want);
      if (length < 0.05 || want[2] > -0.001)
        continue; /* faces away, and is turned */
      ++seen;
      /* derived: up to six roundings of components up to 1, of which the
       * length is made; half as many again for the unit length */
      for (int c = 0; c < 3; ++c)
        wrong += !(fabs(*exact_at(&got, HBIL_SPLIT_NORMAL + c, x, y) -
                        want[c]) <= (6.0 / length + 3.0) * ROUNDING);
    }
  assert_int_equal(wrong, 0);
  assert_true(seen > 256 * 256 / 5);
  free(bytes);
  exact_planes_free(&got);
  setup_free(&s);
}

TEST(every_normal_is_read) {
  const hbil_component all[] = {HBIL_FLOAT32,      HBIL_FLOAT16, HBIL_UNORM8,
                                HBIL_UNORM16,      HBIL_SNORM8,  HBIL_SNORM16,
                                HBIL_RGB10A2_UNORM};
  const cl_uint lanes[] = {8, 16, 1, 4};
  for (cl_uint i = 0; i < EACH(all); ++i)
    check_normals(all[i], HBIL_NORMAL_XYZ, i & 1, i & 2 ? 1 : 4,
                  i < 4 ? 0 : lanes[i % 4]);
  /* single pixels compile fastest */
  for (cl_uint i = 0; i < EACH(all) - 1; ++i) {
    check_normals(all[i], HBIL_NORMAL_OCTAHEDRAL, i & 1, i & 1 ? 1 : 2, 0);
    check_normals(all[i], HBIL_NORMAL_OCTAHEDRAL, !(i & 1), i & 1 ? 1 : 2, 1);
  }
}

/* ------------------------------------------------------------------------ */
/* Hardware depth                                                            */

#define NEAR_PLANE 0.1
#define FAR_PLANE 500.0

typedef enum clip_range { CLIP_0_1, CLIP_1_0, CLIP_1_1 } clip_range;

typedef struct projection {
  clip_range range;
  bool orthographic, endless;
} projection;

/* As hbil_frame.hardware_depth documents them. */
static void set_projection(hbil_frame *frame, projection p) {
  const double n = NEAR_PLANE, f = FAR_PLANE;
  double a, b;
  if (p.orthographic) {
    a = p.range == CLIP_0_1   ? -n / (f - n)
        : p.range == CLIP_1_0 ? f / (f - n)
                              : -(f + n) / (f - n);
    b = (p.range == CLIP_1_0 ? -1.0 : 1.0) / (f - n);
  } else if (p.endless) {
    a = p.range == CLIP_1_0 ? 0.0 : 1.0;
    b = p.range == CLIP_1_0 ? n : -n;
  } else {
    a = p.range == CLIP_0_1   ? f / (f - n)
        : p.range == CLIP_1_0 ? -n / (f - n)
                              : (f + n) / (f - n);
    b = (p.range == CLIP_1_0 ? f : -f) * n / (f - n);
  }
  frame->hardware_depth[0] = a;
  frame->hardware_depth[1] = p.range == CLIP_1_1 ? 2.0 * b : b;
}

/* Pixel 0 has the far end, 1 the near one; floats crowd towards both ends. */
static uint32_t depth_code(hbil_component component, projection p, uint32_t i) {
  const bool reversed = p.range == CLIP_1_0;
  const double low = p.range == CLIP_1_1 ? -1.0 : 0.0;
  const double share = scattered(i) * 0x1p-32;
  const double crowded = pow(10.0, -12.0 * share);
  double d = i % 3 == 0 ? share : i % 3 == 1 ? crowded : 1.0 - crowded;
  d = low + (1.0 - low) * d;
  if (i < 2)
    d = (i == 0) != reversed ? 1.0 : low;
  if (component == HBIL_FLOAT32 || component == HBIL_FLOAT16) {
    unsigned char bytes[4];
    uint32_t code = 0;
    scene_store(component, false, &d, 1, 0, bytes);
    memcpy(&code, bytes, component == HBIL_FLOAT32 ? 4 : 2);
    return code;
  }
  if (component == HBIL_UNORM16)
    return i < 2 ? (uint32_t)(d * 65535.0) : i;
  /* those at the far end, and from all over; above them a stencil */
  const uint32_t largest = 0xffffffu;
  const uint32_t code = i < 2   ? (uint32_t)(d * 16777215.0)
                        : i % 2 ? (reversed ? i : largest - i)
                                : scattered(i) & largest;
  return code | scattered(i + 7u) << 24;
}

static void check_depths(hbil_component component, projection p, cl_uint stride,
                         cl_uint vector_width, int width) {
  setup s;
  placement place;
  size_t size, wrong = 0, skies = 0;
  setup_init(&s, width, 256);
  if (p.orthographic)
    setup_flatten(&s, 4.0);
  set_projection(&s.frame, p);
  /* as in whole frames below, so that both have the same kernels */
  s.config.inputs.normal_space = HBIL_SPACE_WORLD;
  s.config.inputs.depth = pitched_format(component, stride);
  s.config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
  s.config.execution.vector_width = vector_width;
  setup_start(&s);
  unsigned char *bytes = input_bytes(&s, PLANE_DEPTH, &place, &size);
  for (uint32_t i = 0; i < setup_pixels(&s); ++i)
    put_code(
        &place,
        bytes + placement_of(&place, 0, i % s.config.width, i / s.config.width),
        depth_code(component, p, i));
  buffer_write(s.device, s.frame.depth.buffer, 0, size, bytes);
  setup_run(&s, enqueue_split);
  exact_planes split = stage_read(&s, HBIL_STAGE_SPLIT);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < width; ++x) {
      const double d = component_value(
          component, bytes + placement_of(&place, 0, (size_t)x, (size_t)y), 0);
      const double want = hardware_depth_w(&s.config, &s.frame, d);
      const double got = *exact_at(&split, HBIL_SPLIT_W, x, y);
      const bool sky = p.range == CLIP_1_0 ? d <= 0.0 : d >= 1.0;
      skies += sky;
      /* derived: the difference, the scale, the far end's w and the sum are
       * rounded, and a float's difference from 1 counts up to three times */
      const double unit =
          p.orthographic && p.range != CLIP_0_1 ? FAR_PLANE : fabs(want);
      wrong += sky ? got != (double)HBIL_NOTHING
                   : !(fabs(got - want) <= 6.0 * ROUNDING * unit);
    }
  assert_int_equal(wrong, 0);
  assert_true(skies > 0);
  free(bytes);
  exact_planes_free(&split);
  setup_free(&s);
}

TEST(every_hardware_depth_is_read) {
  const projection all[] = {{CLIP_0_1, false, false}, {CLIP_0_1, false, true},
                            {CLIP_1_0, false, false}, {CLIP_1_0, false, true},
                            {CLIP_0_1, true, false},  {CLIP_1_0, true, false}};
  const hbil_component formats[] = {HBIL_FLOAT32, HBIL_FLOAT16, HBIL_UNORM16,
                                    HBIL_UNORM24};
  const cl_uint lanes[] = {0, 8, 4, 1};
  for (cl_uint f = 0; f < EACH(formats); ++f)
    for (cl_uint i = 0; i < EACH(all); ++i)
      check_depths(formats[f], all[i], 1 + f % 2, lanes[f], 251);
  for (int i = 0; i < 4; ++i)
    check_depths(HBIL_FLOAT32, (projection){CLIP_1_1, i & 1, i & 2}, 1, 0,
                 i & 1 ? 251 : 256);
}

/* Depths from the near to the far plane, 1e5 times as far, as floats.  Against
 * A and B that were never rounded. */
static void check_far_plane(bool reversed) {
  enum { SIZE = 32 };
  const double n = 0.1, f = 1e4;
  const double a = (reversed ? -n : f) / (f - n);
  const double b = (reversed ? f : -f) * n / (f - n);
  double worst = 0.0;
  setup s;
  placement place;
  size_t size;
  setup_init(&s, SIZE, SIZE);
  s.config.inputs.normal_space = HBIL_SPACE_WORLD;
  s.config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
  s.frame.hardware_depth[0] = a;
  s.frame.hardware_depth[1] = b;
  setup_start(&s);
  unsigned char *bytes = input_bytes(&s, PLANE_DEPTH, &place, &size);
  for (size_t i = 0; i < SIZE * SIZE; ++i) {
    const double d = a + b / (n * pow(f / n, (double)i / (SIZE * SIZE)));
    scene_store(HBIL_FLOAT32, false, &d, 1, 0,
                bytes + placement_of(&place, 0, i % SIZE, i / SIZE));
  }
  buffer_write(s.device, s.frame.depth.buffer, 0, size, bytes);
  setup_run(&s, enqueue_split);
  exact_planes split = stage_read(&s, HBIL_STAGE_SPLIT);
  for (size_t i = 0; i < SIZE * SIZE; ++i) {
    const size_t x = i % SIZE, y = i / SIZE;
    const double d =
        component_value(HBIL_FLOAT32, bytes + placement_of(&place, 0, x, y), 0);
    const double want = (d - a) / b;
    worst = fmax(worst,
                 fabs(*exact_at(&split, HBIL_SPLIT_W, (int)x, (int)y) - want) /
                     want);
  }
  /* Derived: the scale and the far end's w are rounded, and the sum.  0..1: the
   * difference of a float from 1 is exact from 0.5 on.  Measured: 9.8e-8; with
   * A and B as floats 1.3e-3. */
  check_at_most(reversed ? "1..0" : "0..1", worst, 3.0 * ROUNDING);
  free(bytes);
  exact_planes_free(&split);
  setup_free(&s);
}

TEST(far_planes_cost_no_digits) {
  check_far_plane(false);
  check_far_plane(true);
}

/* NaN and what is too near are counted; the far end, what is beyond it, and
 * what lies beyond sky_depth are sky. */
TEST(unusable_hardware_depths_are_sky) {
  for (int i = 0; i < 4; ++i) {
    const bool reversed = i & 1, endless = i & 2;
    const float end = reversed ? 0.0f : 1.0f, out = reversed ? -1.0f : 1.0f;
    /* the nearest one is at 1e-18, the last but one at 30 */
    const float values[] = {end,
                            NAN,
                            end + 0.5f * out,
                            end - out * 1e17f,
                            out * INFINITY,
                            -out * INFINITY,
                            end - out * 0.1f / 30.0f,
                            end - out * 0.1f / 5.0f};
    setup s;
    hbil_sanitized counts;
    setup_init(&s, 8, 1);
    set_projection(
        &s.frame, (projection){reversed ? CLIP_1_0 : CLIP_0_1, false, endless});
    s.config.inputs.normal_space = HBIL_SPACE_WORLD;
    s.config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
    s.config.inputs.sky_depth = 20.0f;
    setup_fill(&s, EXACT_NORMAL + 2, -1.0f);
    setup_start(&s);
    buffer_write(s.device, s.frame.depth.buffer, 0, sizeof values, values);
    setup_run(&s, hbil_enqueue_frame);
    exact_planes split = stage_read(&s, HBIL_STAGE_SPLIT);
    for (int x = 0; x < 8; ++x)
      assert_int_equal(*exact_at(&split, HBIL_SPLIT_W, x, 0) > 0.0, x == 7);
    assert_success(&s, hbil_plan_sanitized(s.plan, s.device->queue, &counts));
    assert_int_equal(counts.depth, 3);
    exact_planes_free(&split);
    setup_free(&s);
  }
}

/* All passes decode depth: frames of a moving camera are those of the same
 * depths as planar floats (measured: 9.7e-8). */
static exact_planes moving_frames(hbil_depth_kind kind, clip_range range,
                                  hbil_reprojection reprojection, bool flat) {
  setup s;
  setup_init(&s, 61, 43);
  if (flat)
    s.config.inputs.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  setup_load_scene(&s, SCENE_SKY, 0);
  s.config.inputs.normal_space = HBIL_SPACE_WORLD;
  s.config.inputs.depth_kind = kind;
  s.config.inputs.sky_depth = 0.99f * (float)FAR_PLANE;
  s.config.history.reprojection = reprojection;
  s.config.outputs.beauty = three_floats;
  set_projection(&s.frame, (projection){range, flat, false});
  setup_start(&s);
  for (uint32_t frame = 0; frame < 3; ++frame) {
    setup_load_scene(&s, SCENE_SKY, frame);
    setup_upload(&s);
    setup_run(&s, hbil_enqueue_frame);
  }
  return last_outputs(&s);
}

TEST(all_passes_decode_hardware_depth) {
  for (int i = 0; i < 4; ++i) {
    const hbil_reprojection how =
        i & 1 ? HBIL_REPROJECTION_MOTION : HBIL_REPROJECTION_CAMERA;
    exact_planes want = moving_frames(HBIL_DEPTH_PLANAR, CLIP_1_0, how, i & 2);
    exact_planes got = moving_frames(HBIL_DEPTH_HARDWARE,
                                     i & 2 ? CLIP_0_1 : CLIP_1_0, how, i & 2);
    check_at_most("beauty", relative_rmse(&got, &want, EXACT_BEAUTY, 3), 1e-5);
    check_at_most("AO", relative_rmse(&got, &want, EXACT_AO, 1), 1e-5);
    planes_free(&want, &got);
  }
}

/* ------------------------------------------------------------------------ */
/* Motion                                                                    */

static exact_planes moved_light(hbil_component component) {
  setup s;
  setup_scene(&s, SCENE_ROOM, 61, 43, 0);
  s.config.history.reprojection = HBIL_REPROJECTION_MOTION;
  s.config.inputs.motion = pitched_format(component, 2);
  s.config.inputs.motion_scale[0] = s.config.inputs.motion_scale[1] = 64.0f;
  setup_start(&s);
  for (uint32_t frame = 0; frame < 2; ++frame) {
    setup_load_scene(&s, SCENE_ROOM, frame);
    /* both formats get the multiples of 1/32767 */
    for (int c = 0; c < 2; ++c)
      for (size_t i = 0; i < setup_pixels(&s); ++i) {
        float *v = s.input[EXACT_MOTION + c] + i;
        *v = (float)(rint(fmax(fmin((double)*v / 64.0, 1.0), -1.0) * 32767.0) /
                     32767.0);
      }
    setup_upload(&s);
    setup_run(&s, hbil_enqueue_frame);
  }
  exact_planes out = stage_read(&s, HBIL_STAGE_CARRIED);
  setup_free(&s);
  return out;
}

TEST(snorm_motion_is_read) {
  exact_planes want = moved_light(HBIL_FLOAT32);
  exact_planes got = moved_light(HBIL_SNORM16);
  /* measured: 3.7e-9 */
  check_at_most("carried light", relative_rmse(&got, &want, 0, 4), 1e-7);
  planes_free(&want, &got);
}

/* ------------------------------------------------------------------------ */
/* What is accepted                                                          */

/* The bits of the components that a plane can have. */
static unsigned allowed(plane_id id, bool hardware, bool octahedral) {
  const unsigned floats = 1u << HBIL_FLOAT32 | 1u << HBIL_FLOAT16;
  const unsigned unorms = 1u << HBIL_UNORM8 | 1u << HBIL_UNORM16;
  if (id == PLANE_DEPTH)
    return floats | (hardware ? 1u << HBIL_UNORM16 | 1u << HBIL_UNORM24 : 0u);
  if (id == PLANE_NORMAL)
    return floats | unorms | 1u << HBIL_SNORM8 | 1u << HBIL_SNORM16 |
           (octahedral ? 0u : 1u << HBIL_RGB10A2_UNORM);
  if (id == PLANE_MOTION)
    return floats | 1u << HBIL_SNORM16;
  return id < PLANE_FIRST_OUTPUT
             ? floats | unorms | 1u << HBIL_RGB10A2_UNORM |
                   1u << HBIL_R11G11B10_FLOAT | 1u << HBIL_RGB9E5_FLOAT |
                   1u << HBIL_SRGB8
             : floats;
}

TEST(every_plane_has_its_formats) {
  /* those of buffers; test_images is about HBIL_IMAGE */
  const int components = HBIL_SRGB8 + 1;
  for (int i = 0; i < 4 * PLANE_COUNT * components; ++i) {
    setup s;
    hbil_memory memory;
    char field[64];
    const plane_id id = (plane_id)(i / components % PLANE_COUNT);
    const hbil_component component = (hbil_component)(i % components);
    const bool hardware = i / components / PLANE_COUNT & 1,
               octahedral = i / components / PLANE_COUNT & 2;
    if (component == HBIL_NONE || component == HBIL_IMAGE)
      continue;
    setup_init(&s, 8, 8);
    s.config.inputs.depth_kind =
        hardware ? HBIL_DEPTH_HARDWARE : HBIL_DEPTH_PLANAR;
    s.config.inputs.normal_encoding = (hbil_normal_encoding)octahedral;
    *plane_format(&s.config, id) = (hbil_plane_format){component, 0};
    snprintf(field, sizeof field, "%s.%s.component: %d (",
             id < PLANE_FIRST_OUTPUT ? "inputs" : "outputs", plane_name(id),
             (int)component);
    const hbil_status status =
        hbil_plan_memory(s.device->hbil, &s.config, &memory);
    if (allowed(id, hardware, octahedral) & 1u << component)
      assert_success(&s, status);
    else {
      const char *message = hbil_context_message(s.device->hbil);
      assert_int_equal(status, HBIL_INVALID_CONFIG);
      assert_ptr_equal(strstr(message, field), message);
      assert_non_null(strstr(message, "HBIL_FLOAT16"));
    }
    setup_free(&s);
  }
}

TEST(projections_without_depth_are_rejected) {
  const double bad[][2] = {{0.0, 0.0},      {NAN, 1.0},  {1.0, INFINITY},
                           {INFINITY, 1.0}, {1.0, NAN},  {1.0, 1e-39},
                           {1.0, 1e39},     {1e39, 1.0}, {1.0, -1e-300}};
  setup s;
  setup_init(&s, 8, 8);
  s.config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
  set_projection(&s.frame, (projection){CLIP_1_0, false, true});
  setup_start(&s);
  for (size_t i = 0; i < EACH(bad); ++i) {
    memcpy(s.frame.hardware_depth, bad[i], sizeof bad[i]);
    assert_int_equal(
        hbil_enqueue_frame(s.plan, s.device->queue, &s.frame, 0, NULL, NULL),
        HBIL_INVALID_FRAME);
    assert_non_null(
        strstr(hbil_context_message(s.device->hbil), "hardware_depth: "));
  }
  setup_free(&s);
}
