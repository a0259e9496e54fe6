/* See cache.h. */
#include "test/support/cache.h"

#include "test/support/packing.h"
#include "test/support/shim.h"

/* Some thirty voxels across the room. */
#define VOXEL_SIZE 0.1137

static const double world_turn[9] = {
    0.4934886460395535,  -0.45035926880694593, 0.744073575145443,
    0.5498865994070586,  0.8243771119105122,   0.13426505558269358,
    -0.6738647371858757, 0.34289780745545134,  0.654467271618417};

/* Turns a direction or a point of the world. */
static void turn(double v[3]) {
  const double before[3] = {v[0], v[1], v[2]};
  for (int r = 0; r < 3; ++r)
    v[r] = world_turn[3 * r] * before[0] + world_turn[3 * r + 1] * before[1] +
           world_turn[3 * r + 2] * before[2];
}

/* ------------------------------------------------------------------------ */
/* A cache                                                                   */

void cache_prepare(cache_fixture *f, cl_uint vector_width) {
  memset(f, 0, sizeof *f);
  hbil_cache_config_init(&f->config);
  f->vector_width = vector_width;
  f->config.voxels = 32;
  f->config.levels = 3;
  f->config.voxel_size = VOXEL_SIZE;
  double centre[3] = {0.1, 0.7, 1.3};
  turn(centre);
  memcpy(f->config.centre, centre, sizeof centre);
}

void cache_start(cache_fixture *f, const setup *like) {
  hbil_status status;
  f->config.inputs = like->config.inputs;
  f->config.gather_emission = like->config.model.gather_emission;
  shim_answer(CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT, &f->vector_width,
              sizeof f->vector_width);
  status =
      hbil_context_create(shared_device.context, shared_device.id, &f->context);
  shim_answer(0, NULL, 0);
  assert_int_equal(status, HBIL_SUCCESS);
  status = hbil_cache_create(f->context, &f->config, &f->cache);
  if (status != HBIL_SUCCESS)
    fail_msg("%s", hbil_context_message(f->context));
}

void cache_free(cache_fixture *f) {
  hbil_cache_destroy(f->cache);
  hbil_context_destroy(f->context);
}

void cache_end(cache_fixture *f, setup *s, exact_cache *cache) {
  setup_free(s);
  cache_free(f);
  exact_cache_free(cache);
}

static void check(const cache_fixture *f, hbil_status status) {
  if (status != HBIL_SUCCESS)
    fail_msg("%s: %s", hbil_status_string(status),
             hbil_context_message(f->context));
  assert_int_equal(clFinish(shared_device.queue), CL_SUCCESS);
}

hbil_view cache_view(const setup *s, hbil_view_light light) {
  hbil_view view;
  assert_int_equal(hbil_view_from_frame(&view, &s->config, &s->frame),
                   HBIL_SUCCESS);
  view.light = light;
  return view;
}

void cache_inject(cache_fixture *f, const setup *s, hbil_view_light light) {
  const hbil_view view = cache_view(s, light);
  check(f, hbil_enqueue_cache_inject(f->cache, shared_device.queue, &view, 1, 0,
                                     NULL, NULL));
}

void cache_update(cache_fixture *f, const hbil_cache_update *update) {
  check(f, hbil_enqueue_cache_update(f->cache, shared_device.queue, update, 0,
                                     NULL, NULL));
}

hbil_cache_update cache_bounces(cl_uint bounces) {
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  update.bounces = bounces;
  return update;
}

void cache_touch(cache_fixture *f) {
  hbil_cache_change none;
  hbil_cache_change_init(&none);
  check(f, hbil_enqueue_cache_forget(f->cache, shared_device.queue, &none, 0,
                                     NULL, NULL));
}

void cache_move(cache_fixture *f, const double centre[3]) {
  check(f, hbil_enqueue_cache_move(f->cache, shared_device.queue, centre, 0,
                                   NULL, NULL));
}

/* ------------------------------------------------------------------------ */
/* Views                                                                     */

void view_prepare(setup *s, scene_kind kind, int width, int height,
                  uint32_t index, hbil_projection projection) {
  setup_init(s, width, height);
  s->config.inputs.normal_space = HBIL_SPACE_WORLD;
  s->config.inputs.projection = projection;
  setup_load_scene(s, kind, index);
  double *m = s->frame.camera.world_from_view;
  for (int c = 0; c < 4; ++c) {
    double column[3] = {m[c], m[4 + c], m[8 + c]};
    turn(column);
    for (int r = 0; r < 3; ++r)
      m[4 * r + c] = column[r];
  }
  for (size_t i = 0; i < setup_pixels(s); ++i) {
    double n[3];
    for (int c = 0; c < 3; ++c)
      n[c] = (double)s->input[EXACT_NORMAL + c][i];
    turn(n);
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] = (float)n[c];
  }
}

void view_start(setup *s, scene_kind kind, int width, int height,
                uint32_t index, hbil_projection projection) {
  view_prepare(s, kind, width, height, index, projection);
  shim_skip_builds(true);
  setup_start(s);
  shim_skip_builds(false);
}

void cache_fill(cache_fixture *f, exact_cache *cache, scene_kind kind,
                hbil_view_light light, setup *last) {
  const double unit = ldexp(cache->voxel_size, cache->levels - 1);
  double centre[3];
  view_start(last, kind, 160, 90, 0, HBIL_PROJECTION_PERSPECTIVE);
  cache_start(f, last);
  cache_inject(f, last, light);
  setup_free(last);
  for (int i = 0; i < 3; ++i)
    centre[i] = unit * (double)(cache->middle[i] + i - 1);
  assert_int_equal(exact_cache_move(cache, centre), EXACT_SUCCESS);
  cache_move(f, centre);
  view_start(last, kind, 160, 90, 5, HBIL_PROJECTION_PERSPECTIVE);
  cache_inject(f, last, light);
}

/* ------------------------------------------------------------------------ */
/* What is on the device                                                     */

/* Kernels that take the buffers, and which argument they are. */
static const struct {
  const char *kernel;
  cl_uint index;
} taken[CACHE_BUFFERS] = {[CACHE_STATES] = {"update_radiance", 1},
                          [CACHE_CLEARANCE] = {"clearance_along_x", 2},
                          [CACHE_VOXELS] = {"update_radiance", 2},
                          [CACHE_RADIANCE] = {"update_radiance", 3},
                          [CACHE_UNLIT] = {"mean_part", 3},
                          [CACHE_MEANS] = {"mean_sum", 0},
                          [CACHE_TEXELS] = {"read_view", 1},
                          [CACHE_RATIOS] = {"change_ratio", 1}};

cl_mem cache_memory(cache_buffer which) {
  cl_mem buffer;
  shim_argument(taken[which].kernel, taken[which].index, sizeof buffer,
                &buffer);
  return buffer;
}

void *cache_read(cache_buffer which, size_t *bytes) {
  return buffer_bytes(&shared_device, cache_memory(which), bytes);
}

void light_of_word(uint32_t word, double light[3], double *unit) {
  *unit = ldexp(1.0, (int)(word >> 24) - 127);
  for (int c = 0; c < 3; ++c)
    light[c] = (double)((word >> (8 * c)) & 255u) * *unit;
}

exact_cache checked_cache(const cache_fixture *f) {
  exact_cache cache;
  assert_int_equal(exact_cache_create(&cache, &f->config), EXACT_SUCCESS);
  return cache;
}

void cache_import(exact_cache *like) {
  uint32_t *states = cache_read(CACHE_STATES, NULL);
  float *voxels = cache_read(CACHE_VOXELS, NULL);
  uint32_t *radiance = cache_read(CACHE_RADIANCE, NULL);
  unsigned char *unlit = cache_read(CACHE_UNLIT, NULL);
  for (size_t i = 0; i < exact_cache_count(like); ++i) {
    const exact_place place = exact_cache_place(like, i);
    exact_voxel *voxel = exact_cache_at(like, &place);
    double unit;
    assert_int_equal(exact_cache_number(like, &place), i);
    voxel->state = (int)(states[i / 16] >> (2 * (i % 16)) & 3u);
    for (int k = 0; k < HBIL_VOXEL_FLOATS; ++k)
      voxel->value[k] = (double)voxels[HBIL_VOXEL_FLOATS * i + (size_t)k];
    light_of_word(radiance[i], voxel->radiance, &unit);
    voxel->unlit = unlit[i] ? (unlit[i] - 1) / 254.0 : -1.0;
  }
  free(states);
  free(voxels);
  free(radiance);
  free(unlit);
}

exact_texel texel_of_words(const uint32_t word[HBIL_TEXEL_WORDS]) {
  exact_texel texel;
  float depth;
  double n[3], unit;
  memcpy(&depth, word + HBIL_TEXEL_DEPTH, sizeof depth);
  decode_normal(word[HBIL_TEXEL_NORMAL], n);
  texel.depth = (double)depth;
  texel.normal = vec(n[0], n[1], n[2]);
  for (int c = 0; c < 3; ++c)
    texel.reflectance[c] =
        (double)(word[HBIL_TEXEL_REFLECTANCE] >> (10 * c) & 1023u) / 1023.0;
  light_of_word(word[HBIL_TEXEL_SENT], texel.sent, &unit);
  return texel;
}

exact_texel *cache_texels(int *width, int *height) {
  hbil_cache_view_args args;
  shim_argument("read_view", 0, sizeof args, &args);
  uint32_t *words = cache_read(CACHE_TEXELS, NULL);
  const size_t count = (size_t)args.width * (size_t)args.height;
  exact_texel *texels = calloc(count, sizeof *texels);
  assert_non_null(texels);
  for (size_t i = 0; i < count; ++i)
    texels[i] = texel_of_words(words + HBIL_TEXEL_WORDS * i);
  free(words);
  *width = args.width;
  *height = args.height;
  return texels;
}
