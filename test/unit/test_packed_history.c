/*
 * Packed storage of what goes from frame to frame: HISTORY and CARRIED lose no
 * more than their words may, and reprojection and split lose nothing else
 * (test_push_pull: nor does push/pull).
 */
#include "test/support/packing.h"
#include "test/support/random.h"
#include "test/support/stages.h"

#define WIDTH 61
#define HEIGHT 37

static const cl_uint widths[] = {1, 4, 8, 16};
#define WIDTHS (sizeof widths / sizeof *widths)

/* A plan with a history, whose frame is uploaded. */
static void start(setup *s, hbil_storage storage, cl_uint vector_width) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s->config.sampling.storage = storage;
  s->config.sampling.slices = s->config.sampling.steps_per_side = 1;
  s->config.execution.vector_width = vector_width;
  setup_start(s);
  setup_run(s, hbil_enqueue_frame);
  s->job.previous = s->frame.camera;
}

/* ------------------------------------------------------------------------ */
/* composite                                                                 */

/* The history that composite writes of the same resolved light. */
static exact_planes written_history(hbil_storage storage, cl_uint vector_width,
                                    exact_planes *resolved) {
  setup s;
  start(&s, storage, vector_width);
  if (!resolved->values)
    *resolved = stage_read(&s, HBIL_STAGE_RESOLVED);
  stage_write(&s, HBIL_STAGE_RESOLVED, resolved);
  setup_run(&s, enqueue_composite);
  exact_planes history = stage_read(&s, HBIL_STAGE_HISTORY);
  setup_free(&s);
  return history;
}

static void history_loses_no_more_than_its_words(void **state) {
  (void)state;
  for (size_t i = 0; i < WIDTHS; ++i) {
    exact_planes resolved = {0, 0, 0, NULL};
    exact_planes want =
        written_history(HBIL_STORAGE_FLOAT32, widths[i], &resolved);
    exact_planes got =
        written_history(HBIL_STORAGE_PACKED, widths[i], &resolved);
    for (int y = 0; y < HEIGHT; ++y)
      for (int x = 0; x < WIDTH; ++x)
        assert_true(*exact_at(&got, HBIL_HISTORY_W, x, y) ==
                    *exact_at(&want, HBIL_HISTORY_W, x, y));
    check_at_most(
        "history, losses",
        packed_losses(&got, &want, HBIL_HISTORY_RED, PACKED_RADIANCE_BITS, 0.0),
        PACKED_LOSS_LIMIT);
    exact_planes_free(&resolved);
    exact_planes_free(&want);
    exact_planes_free(&got);
  }
}

/* ------------------------------------------------------------------------ */
/* reproject                                                                 */

/* The camera moves a little. */
static void words_are_carried_over_as_they_are(void **state) {
  (void)state;
  for (size_t i = 0; i < WIDTHS; ++i) {
    setup s;
    start(&s, HBIL_STORAGE_PACKED, widths[i]);
    s.frame.camera.world_from_view[3] += 0.125;
    s.job.camera = s.frame.camera;
    exact_planes history = stage_read(&s, HBIL_STAGE_HISTORY);
    exact_planes want = checked_planes(WIDTH, HEIGHT, HBIL_CARRIED_PLANES);
    checked_reproject(&s.job, &history, &want);
    setup_run(&s, enqueue_reproject);
    exact_planes got = stage_read(&s, HBIL_STAGE_CARRIED);
    assert_int_equal(count_different(&got, &want), 0);
    exact_planes_free(&history);
    exact_planes_free(&want);
    exact_planes_free(&got);
    setup_free(&s);
  }
}

/* ------------------------------------------------------------------------ */
/* split                                                                     */

/* Light of all sizes, in the planes of CARRIED. */
static exact_planes random_light(void) {
  random_state r = {23};
  exact_planes p = checked_planes(WIDTH, HEIGHT, HBIL_CARRIED_PLANES);
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      const double scale = ldexp(1.0, (int)(12.0 * random_unit(&r)) - 6);
      for (int c = 0; c < 3; ++c)
        *exact_at(&p, c, x, y) = scale * random_unit(&r);
      *exact_at(&p, HBIL_CARRIED_WEIGHT, x, y) = 1.0;
    }
  return p;
}

/* SPLIT of a frame whose carried light is that of `carried`, as words have it.
 */
static exact_planes split_with(hbil_storage storage, cl_uint vector_width,
                               exact_planes *carried) {
  setup s;
  start(&s, storage, vector_width);
  stage_write(&s, HBIL_STAGE_CARRIED, carried);
  if (storage == HBIL_STORAGE_PACKED) {
    exact_planes_free(carried);
    *carried = stage_read(&s, HBIL_STAGE_CARRIED);
  }
  setup_run(&s, enqueue_split);
  exact_planes split = stage_read(&s, HBIL_STAGE_SPLIT);
  setup_free(&s);
  return split;
}

static void carried_light_is_added(void **state) {
  (void)state;
  for (size_t i = 0; i < WIDTHS; ++i) {
    exact_planes carried = random_light();
    exact_planes got = split_with(HBIL_STORAGE_PACKED, widths[i], &carried);
    exact_planes want = split_with(HBIL_STORAGE_FLOAT32, widths[i], &carried);
    check_at_most(
        "radiance, losses",
        packed_losses(&got, &want, HBIL_SPLIT_RED, PACKED_RADIANCE_BITS, 0.0),
        PACKED_LOSS_LIMIT);
    exact_planes_free(&carried);
    exact_planes_free(&got);
    exact_planes_free(&want);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(history_loses_no_more_than_its_words),
      cmocka_unit_test(words_are_carried_over_as_they_are),
      cmocka_unit_test(carried_light_is_added)};
  return RUN_WITH_DEVICE(tests);
}
