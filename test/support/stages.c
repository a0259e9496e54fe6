#include "test/support/stages.h"

#include "exact/glossy.h"
#include "exact/planes.h"
#include "exact/settings.h"
#include "test/support/packing.h"

enum { MOST_VALUES = EXACT_RESOLVED_PLANES + 3 };

/* A stage's buffer, copied to the host. */
typedef struct stage_bytes {
  hbil_buffer b;
  hbil_stage stage;
  size_t size;
  float *floats;
  int plain; /* values from the first on that are those of exact planes 0.., or
                words that hold these */
  /* Which exact plane each value is, and how many planes there are. */
  int plane[MOST_VALUES], planes;
} stage_bytes;

/* Whether the share that back-facing samples block is known. */
static bool has_unknown(const setup *s) {
  return s->config.model.back_facing_fallback == HBIL_FALLBACK_FRAME_MEAN &&
         s->config.model.facing_fade[1] > -1.0f;
}

/* The last `count` values that aren't taken yet are exact planes from `first`
 * on. */
static void take(stage_bytes *t, int count, int first) {
  for (int i = count - 1; i >= 0; --i)
    t->plane[--t->plain] = first + i;
  if (t->planes < first + count)
    t->planes = first + count;
}

static void take_resolved(const setup *s, stage_bytes *t) {
  const hbil_outputs *outputs = &s->config.outputs;
  if (has_unknown(s) && outputs->unknown.component)
    take(t, 1, HBIL_LIGHT_UNKNOWN);
  if (outputs->error_estimate.component)
    take(t, gathers_light(s) ? 2 : 1, EXACT_RESOLVED_ERRORS);
  if (outputs->glossy.component)
    take(t, HBIL_GLOSSY_PLANES, EXACT_GLOSSY_PLANES);
}

static void take_gathered(const setup *s, stage_bytes *t) {
  if (s->config.outputs.glossy.component)
    take(t, HBIL_GATHERED_GLOSSY_PLANES, EXACT_GLOSSY_PLANES);
  if (exact_weighs_slices(&s->config))
    take(t, 1, HBIL_LIGHT_WEIGHT);
}

bool gathers_light(const setup *s) {
  hbil_buffer split;
  if (s->config.model.mode != HBIL_MODE_HBIL)
    return false;
  assert_success(s, hbil_plan_buffer(s->plan, HBIL_STAGE_SPLIT, &split));
  return split.values > (s->config.sampling.storage == HBIL_STORAGE_FLOAT32
                             ? HBIL_SPLIT_RED
                             : HBIL_PACKED_RADIANCE);
}

/* The stage whose values and layout a stage has. */
static hbil_stage like(hbil_stage stage) {
  return stage == HBIL_STAGE_AO_GATHERED   ? HBIL_STAGE_GATHERED
         : stage == HBIL_STAGE_AO_RESOLVED ? HBIL_STAGE_RESOLVED
                                           : stage;
}

static bool is_packed(const setup *s, hbil_stage stage) {
  stage = like(stage);
  return s->config.sampling.storage != HBIL_STORAGE_FLOAT32 &&
         stage != HBIL_STAGE_RESOLVED;
}

static int plain_planes(const setup *s, hbil_stage stage, int words);

static stage_bytes stage_open(setup *s, hbil_stage stage) {
  stage_bytes t = {.stage = like(stage)};
  assert_success(s, hbil_plan_buffer(s->plan, stage, &t.b));
  stage = t.stage;
  t.plain = (int)t.b.values;
  assert_true(t.plain <= MOST_VALUES);
  if (stage == HBIL_STAGE_GATHERED)
    take_gathered(s, &t);
  if (stage == HBIL_STAGE_RESOLVED)
    take_resolved(s, &t);
  const int plain =
      is_packed(s, stage) ? plain_planes(s, stage, t.plain) : t.plain;
  if (t.planes < plain)
    t.planes = plain;
  t.floats = (float *)(void *)buffer_bytes(s->device, t.b.buffer, &t.size);
  for (int i = 0; i < t.plain; ++i)
    t.plane[i] = i;
  return t;
}

static float *stage_at(const stage_bytes *t, int plane, int x, int y) {
  const hbil_buffer *b = &t->b;
  const size_t i = (size_t)x, j = (size_t)y;
  size_t at = (size_t)plane * b->plane_pitch + b->origin;
  if (t->stage == HBIL_STAGE_SPLIT || t->stage == HBIL_STAGE_GATHERED)
    at += (4 * (j % 4) + i % 4) * b->layer_pitch + j / 4 * b->row_pitch + i / 4;
  else
    at += j * b->row_pitch + i;
  assert_true(at < t->size / sizeof(float));
  return t->floats + at;
}

/* ------------------------------------------------------------------------ */
/* Packed stages                                                             */

/* The number of planes that FLOAT32 would have in place of so many words. */
static int plain_planes(const setup *s, hbil_stage stage, int words) {
  if (stage == HBIL_STAGE_HISTORY)
    return HBIL_HISTORY_PLANES;
  if (stage == HBIL_STAGE_CARRIED)
    return HBIL_CARRIED_PLANES;
  if (stage == HBIL_STAGE_SPLIT)
    return words > HBIL_PACKED_RADIANCE ? HBIL_SPLIT_PLANES : HBIL_SPLIT_RED;
  if (words == 1)
    return HBIL_LIGHT_RED;
  if (has_unknown(s))
    return HBIL_LIGHT_UNKNOWN + 1;
  return words == HBIL_PACKED_BENT ? HBIL_LIGHT_BENT : HBIL_LIGHT_PLANES;
}

static packed_pixel packed_at(const stage_bytes *t, int x, int y) {
  packed_pixel p = {{0, 0, 0, 0}, {0.0}};
  for (int i = 0; i < t->plain; ++i)
    memcpy(p.word + i, stage_at(t, i, x, y), sizeof(*p.word));
  switch (t->stage) {
  case HBIL_STAGE_HISTORY:
    decode_history(&p);
    break;
  case HBIL_STAGE_CARRIED:
    decode_carried(&p);
    break;
  case HBIL_STAGE_SPLIT:
    decode_split(&p);
    break;
  default:
    decode_gathered(&p);
  }
  return p;
}

static void encode(hbil_stage stage, int x, int y, packed_pixel *p) {
  switch (stage) {
  case HBIL_STAGE_HISTORY:
    encode_history(p);
    break;
  case HBIL_STAGE_CARRIED:
    encode_carried(p);
    break;
  case HBIL_STAGE_SPLIT:
    encode_split(p);
    break;
  default:
    encode_gathered(p, x, y);
  }
}

static void read_packed(const stage_bytes *t, const exact_planes *out) {
  for (int y = 0; y < out->height; ++y)
    for (int x = 0; x < out->width; ++x) {
      packed_pixel p = packed_at(t, x, y);
      for (int i = 0; i < out->count && i < HBIL_GATHERED_PLANES; ++i)
        *exact_at(out, i, x, y) = p.value[i];
    }
}

static void write_packed(const stage_bytes *t, const exact_planes *planes) {
  for (int y = 0; y < planes->height; ++y)
    for (int x = 0; x < planes->width; ++x) {
      packed_pixel p = packed_at(t, x, y);
      for (int i = 0; i < planes->count && i < HBIL_GATHERED_PLANES; ++i)
        p.value[i] = *exact_at(planes, i, x, y);
      encode(t->stage, x, y, &p);
      for (int i = 0; i < t->plain; ++i)
        memcpy(stage_at(t, i, x, y), p.word + i, sizeof(*p.word));
    }
}

/* ------------------------------------------------------------------------ */

/* Pixels that aren't gathered have no values; here they get zeros. */
static void clear_left_out(const setup *s, exact_planes *gathered) {
  for (int y = 0; y < gathered->height; ++y)
    for (int x = 0; x < gathered->width; ++x)
      if (!exact_is_gathered(&s->config, x, y))
        exact_planes_clear(gathered, x, y);
}

exact_planes stage_read(setup *s, hbil_stage stage) {
  stage_bytes t = stage_open(s, stage);
  exact_planes out =
      checked_planes((int)s->config.width, (int)s->config.height, t.planes);
  const bool packed = is_packed(s, stage);
  if (packed)
    read_packed(&t, &out);
  for (int i = packed ? t.plain : 0; i < (int)t.b.values; ++i)
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x)
        *exact_at(&out, t.plane[i], x, y) = (double)*stage_at(&t, i, x, y);
  if (like(stage) == HBIL_STAGE_GATHERED)
    clear_left_out(s, &out);
  free(t.floats);
  return out;
}

void stage_write(setup *s, hbil_stage stage, const exact_planes *planes) {
  stage_bytes t = stage_open(s, stage);
  const bool packed = is_packed(s, stage);
  if (packed)
    write_packed(&t, planes);
  for (int i = packed ? t.plain : 0; i < (int)t.b.values; ++i)
    for (int y = 0; t.plane[i] < planes->count && y < planes->height; ++y)
      for (int x = 0; x < planes->width; ++x)
        *stage_at(&t, i, x, y) = (float)*exact_at(planes, t.plane[i], x, y);
  buffer_write(s->device, t.b.buffer, 0, t.size, t.floats);
  free(t.floats);
}

bool stage_has(setup *s, hbil_stage stage, int plane) {
  hbil_buffer b;
  if (hbil_plan_buffer(s->plan, stage, &b) != HBIL_SUCCESS)
    return false;
  stage_bytes t = stage_open(s, stage);
  free(t.floats);
  bool has =
      plane < (is_packed(s, stage) ? plain_planes(s, stage, t.plain) : t.plain);
  for (int i = t.plain; i < (int)t.b.values; ++i)
    has |= t.plane[i] == plane;
  return has;
}

exact_planes stage_gathered(setup *s) {
  setup_run(s, enqueue_split);
  setup_run(s, enqueue_gather);
  return stage_read(s, HBIL_STAGE_GATHERED);
}

exact_planes stage_gathered_mean(setup *s, int frames) {
  exact_planes sum = {0, 0, 0, NULL};
  setup_run(s, enqueue_split);
  for (int frame = 0; frame < frames; ++frame) {
    s->frame.frame_index = (cl_uint)frame;
    setup_run(s, enqueue_gather);
    exact_planes one = stage_read(s, HBIL_STAGE_GATHERED);
    if (frame == 0)
      sum = checked_planes(one.width, one.height, one.count);
    for (size_t i = 0; i < count_values(&one); ++i)
      sum.values[i] += one.values[i] / frames;
    exact_planes_free(&one);
  }
  return sum;
}

exact_planes expected_split(const setup *s) {
  exact_planes split = checked_planes((int)s->config.width,
                                      (int)s->config.height, HBIL_SPLIT_PLANES);
  exact_split(&s->job, NULL, &split);
  return split;
}

/* how: NULL for the plan's samples. */
static exact_planes gather(const setup *s, const exact_dense *how) {
  exact_planes split = expected_split(s);
  exact_planes out =
      checked_planes(split.width, split.height, HBIL_GATHERED_PLANES);
  if (how)
    checked_gather_dense(&s->job, &split, how, &out);
  else
    checked_gather(&s->job, &split, &out);
  exact_planes_free(&split);
  return out;
}

exact_planes expected_gathered(const setup *s) {
  return gather(s, NULL);
}

exact_planes expected_gathered_densely(const setup *s, const exact_dense *how) {
  return gather(s, how);
}
