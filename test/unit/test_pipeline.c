/*
 * The program's pipeline: every item passes the stages in order, few are under
 * way at once, and after a failure what was done and what is reported are the
 * same in every run.
 */
#define _POSIX_C_SOURCE 200809L
#include "test/support/compare.h"

#include <pthread.h>
#include <stdio.h>
#include <time.h>

#include "tool/pipeline.h"

enum { ITEMS = 40, NONE = ITEMS };

/* What stages record, and what they are told to do. */
typedef struct watch {
  pthread_mutex_t lock;
  size_t done[PIPELINE_STAGES];   /* items */
  size_t fails[PIPELINE_STAGES];  /* the item at which a stage fails */
  unsigned slow[PIPELINE_STAGES]; /* microseconds an item takes there */
  size_t depth;
  size_t slots[PIPELINE_SLOTS]; /* the item that each holds */
  /* the item that is in each place behind a stage, from its beginning on */
  size_t places[PIPELINE_STAGES][PIPELINE_DEPTH];
  size_t most; /* items under way at once */
  pthread_t threads[PIPELINE_STAGES];
  int wrong; /* an item out of turn */
} watch;

static void work_for(unsigned microseconds) {
  const struct timespec time = {0, (long)microseconds * 1000};
  nanosleep(&time, NULL);
}

static int pass(watch *w, int stage, size_t item, image_error *error) {
  size_t *slot = &w->slots[item % PIPELINE_SLOTS];
  const size_t place = item % w->depth;
  pthread_mutex_lock(&w->lock);
  w->places[stage][place] = item;
  pthread_mutex_unlock(&w->lock);
  work_for(w->slow[stage]);
  pthread_mutex_lock(&w->lock);
  w->threads[stage] = pthread_self();
  w->wrong |= item != w->done[stage];
  w->wrong |= stage > 0 && (item >= w->done[stage - 1] || *slot != item ||
                            w->places[stage - 1][place] != item);
  if (stage == 0)
    *slot = item;
  const int failed = item == w->fails[stage];
  w->done[stage] += !failed;
  const size_t under_way = w->done[0] - w->done[PIPELINE_STAGES - 1];
  w->most = under_way > w->most ? under_way : w->most;
  pthread_mutex_unlock(&w->lock);
  return failed ? image_fail(error, "stage %d, item %zu", stage, item) : 0;
}

static int first(void *user, size_t item, image_error *error) {
  return pass(user, 0, item, error);
}

static int second(void *user, size_t item, image_error *error) {
  return pass(user, 1, item, error);
}

static int third(void *user, size_t item, image_error *error) {
  return pass(user, 2, item, error);
}

static watch quiet_watch(void) {
  return (watch){.lock = PTHREAD_MUTEX_INITIALIZER,
                 .depth = PIPELINE_DEPTH,
                 .fails = {NONE, NONE, NONE}};
}

static int run(watch *w, double (*seconds)[PIPELINE_STAGES],
               image_error *error) {
  const pipeline p = {.stages = {first, second, third},
                      .user = w,
                      .items = ITEMS,
                      .depth = w->depth,
                      .seconds = seconds};
  return pipeline_run(&p, error);
}

static void pass_every_stage(size_t depth, int slow) {
  watch w = quiet_watch();
  double seconds[ITEMS][PIPELINE_STAGES] = {{0.0}};
  image_error error;
  w.depth = depth;
  w.slow[slow] = 500;
  assert_int_equal(run(&w, seconds, &error), 0);
  assert_false(w.wrong);
  for (int s = 0; s < PIPELINE_STAGES; s++)
    assert_int_equal(w.done[s], ITEMS);
  assert_true(w.most <= 2 * depth);
  /* nanosleep() never sleeps for less */
  for (int i = 0; i < ITEMS; i++)
    assert_true(seconds[i][slow] >= 500e-6);
}

TEST(every_item_passes_every_stage_in_order) {
  for (size_t depth = 1; depth <= PIPELINE_DEPTH; depth++)
    for (int slow = 0; slow < PIPELINE_STAGES; slow++)
      pass_every_stage(depth, slow);
}

TEST(few_items_are_under_way) {
  watch w = quiet_watch();
  double seconds[ITEMS][PIPELINE_STAGES];
  image_error error;
  w.slow[PIPELINE_STAGES - 1] = 500;
  assert_int_equal(run(&w, seconds, &error), 0);
  assert_true(w.most <= PIPELINE_SLOTS);
  /* a stage that waits for a slow one has all its slots filled: sleeping that
   * long, the last one has been overtaken at least once in 40 items */
  assert_true(w.most > 1);
}

TEST(stages_have_threads_of_their_own) {
  watch w = quiet_watch();
  double seconds[ITEMS][PIPELINE_STAGES];
  image_error error;
  assert_int_equal(run(&w, seconds, &error), 0);
  assert_true(pthread_equal(w.threads[1], pthread_self()));
  assert_false(pthread_equal(w.threads[0], w.threads[1]));
  assert_false(pthread_equal(w.threads[2], w.threads[1]));
}

/* A failure at `item` of `stage`, whichever of the others is slow. */
static void fail_at(int stage, size_t item, int slow) {
  watch w = quiet_watch();
  double seconds[ITEMS][PIPELINE_STAGES];
  image_error error;
  char expected[64];
  w.fails[stage] = item;
  w.slow[slow] = 300;
  snprintf(expected, sizeof expected, "stage %d, item %zu", stage, item);
  assert_int_equal(run(&w, seconds, &error), -1);
  assert_string_equal(error.text, expected);
  assert_false(w.wrong);
  for (int s = stage; s < PIPELINE_STAGES; s++)
    assert_int_equal(w.done[s], item);
}

TEST(what_is_before_a_failure_is_done_and_nothing_behind) {
  static const size_t items[] = {0, 1, 17, ITEMS - 1};
  for (size_t i = 0; i < sizeof items / sizeof *items; i++)
    for (int stage = 0; stage < PIPELINE_STAGES; stage++)
      for (int slow = 0; slow < PIPELINE_STAGES; slow++)
        fail_at(stage, items[i], slow);
}

/* Items fail in all three stages. The first one of the sequence is reported,
 * even if another fails earlier in time. */
TEST(the_first_item_that_fails_is_told) {
  for (int slow = 0; slow < PIPELINE_STAGES; slow++) {
    watch w = quiet_watch();
    double seconds[ITEMS][PIPELINE_STAGES];
    image_error error;
    w.fails[0] = 7;
    w.fails[1] = 6;
    w.fails[2] = 5;
    w.slow[slow] = 300;
    assert_int_equal(run(&w, seconds, &error), -1);
    assert_string_equal(error.text, "stage 2, item 5");
    assert_int_equal(w.done[2], 5);
  }
}

TEST(nothing_to_do_is_done) {
  const pipeline p = {.stages = {first, second, third}, .depth = 1};
  assert_int_equal(pipeline_run(&p, NULL), 0);
}

int main(void) {
  return tests_run();
}
