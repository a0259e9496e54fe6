#include "test/support/pair.h"

void pair_start(pair *p, prepare_function *prepare, cl_uint skip) {
  prepare(&p->with);
  prepare(&p->without);
  p->without.config.execution.skip &= ~skip;
  setup_start(&p->with);
  setup_start(&p->without);
}

void pair_free(pair *p) {
  setup_free(&p->with);
  setup_free(&p->without);
}

void run_frame(setup *s) {
  setup_upload(s);
  setup_run(s, hbil_enqueue_frame);
}

hbil_statistics statistics_of(setup *s) {
  hbil_statistics out;
  assert_success(s, hbil_plan_statistics(s->plan, s->device->queue, &out));
  return out;
}

void assert_same_outputs(setup *a, setup *b) {
  exact_planes one = outputs_read(a), two = outputs_read(b);
  assert_int_equal(count_different(&one, &two), 0);
  planes_free(&one, &two);
}

hbil_statistics pair_compare(pair *p) {
  const size_t pixels = (size_t)p->with.config.width * p->with.config.height;
  for (int i = 0; i < EXACT_INPUT_PLANES; ++i)
    memcpy(p->without.input[i], p->with.input[i], pixels * sizeof(float));
  run_frame(&p->with);
  run_frame(&p->without);
  assert_same_outputs(&p->with, &p->without);
  return statistics_of(&p->with);
}

size_t pixel_at(int x, int y) {
  return (size_t)y * WIDTH + (size_t)x;
}

void pair_sized_wall(setup *s, uint32_t width, uint32_t height) {
  setup_init(s, width, height);
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
  s->config.sampling.storage = HBIL_STORAGE_PACKED;
  s->config.inputs.normal_space = HBIL_SPACE_WORLD; /* as scenes have them */
  setup_all_outputs(s);
  setup_camera(s, 40.0);
}

void pair_wall(setup *s) {
  pair_sized_wall(s, WIDTH, HEIGHT);
}

void pair_fill_wall(setup *s) {
  setup_fill(s, EXACT_DEPTH, 2.0f);
  setup_fill(s, EXACT_NORMAL, 0.0f);
  setup_fill(s, EXACT_NORMAL + 1, 0.0f);
  setup_fill(s, EXACT_NORMAL + 2, -1.0f);
  for (int c = 0; c < 3; ++c) {
    setup_fill(s, EXACT_ALBEDO + c, 0.5f);
    setup_fill(s, EXACT_DIRECT + c, 1.0f + (float)c);
    setup_fill(s, EXACT_EMISSION + c, 0.0f);
  }
}
