#include "test/support/history.h"

#include "test/support/packing.h"

void averaging_init(setup *s, int width, int height, cl_uint frames) {
  setup_scene(s, SCENE_ROOM, width, height, 0);
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
  s->config.sampling.slices = 1;
  s->config.sampling.steps_per_side = 6;
  s->config.sampling.unfiltered = CL_TRUE;
  s->config.inputs.motion.component = HBIL_NONE;
  s->config.history.max_frames = frames;
}

void averaging_load(setup *s, uint32_t scene, cl_uint index) {
  setup_load_scene(s, SCENE_ROOM, scene);
  s->frame.frame_index = index;
  setup_upload(s);
}

void same_bits(const exact_planes *got, const exact_planes *want) {
  assert_int_equal(count_different(got, want), 0);
}

history history_read(setup *s) {
  history h = {.bytes = NULL};
  size_t size;
  assert_success(s,
                 hbil_plan_buffer(s->plan, HBIL_STAGE_TEMPORAL_HISTORY, &h.at));
  h.bytes = buffer_bytes(s->device, h.at.buffer, &size);
  return h;
}

size_t history_offset(const history *h, int p, int x, int y) {
  return 4 * (h->at.origin + (size_t)p * h->at.plane_pitch +
              (size_t)y * h->at.row_pitch + (size_t)x);
}

double history_value(const history *h, int p, int x, int y) {
  float value;
  memcpy(&value, h->bytes + history_offset(h, p, x, y), sizeof value);
  return (double)value;
}

void history_normal(const history *h, int x, int y, double n[3]) {
  uint32_t word;
  memcpy(&word, h->bytes + history_offset(h, HISTORY_NORMAL, x, y),
         sizeof word);
  decode_normal(word, n);
}

enqueue_function *const passes_before_filter[] = {
    enqueue_reproject, enqueue_push_pull, enqueue_split, enqueue_gather,
    enqueue_recompose};
