/* Three stages that work at the same time: three counters under one lock. */
#define _POSIX_C_SOURCE 200809L
#include "tool/pipeline.h"

#include "image/clock.h"
#include "image/error.h"

#include <pthread.h>
#include <string.h>

typedef struct run {
  const pipeline *pipeline;
  pthread_mutex_t lock;
  pthread_cond_t changed;
  size_t done[PIPELINE_STAGES]; /* items that have left the stage */
  size_t failed;                /* the first item that failed, or the end */
  image_error *error;           /* of that item */
} run;

typedef struct worker {
  run *run;
  int stage;
} worker;

static int is_ready(const run *r, int stage, size_t item) {
  return (stage == 0 || item < r->done[stage - 1]) &&
         (stage == PIPELINE_STAGES - 1 ||
          item < r->done[stage + 1] + r->pipeline->depth);
}

/* Waits for an item.  Returns 0 if it is not to be done. */
static int begin(run *r, int stage, size_t item) {
  pthread_mutex_lock(&r->lock);
  while (item < r->failed && !is_ready(r, stage, item))
    pthread_cond_wait(&r->changed, &r->lock);
  const int wanted = item < r->failed;
  pthread_mutex_unlock(&r->lock);
  return wanted;
}

static void fail(run *r, size_t item, const image_error *error) {
  if (item >= r->failed)
    return;
  r->failed = item;
  if (r->error)
    *r->error = *error;
}

static void end(run *r, int stage, size_t item, const image_error *error) {
  pthread_mutex_lock(&r->lock);
  if (error)
    fail(r, item, error);
  else
    r->done[stage] = item + 1;
  pthread_cond_broadcast(&r->changed);
  pthread_mutex_unlock(&r->lock);
}

static void work(run *r, int stage) {
  const pipeline *p = r->pipeline;
  image_error error;
  int failed = 0;
  for (size_t i = 0; i < p->items && !failed && begin(r, stage, i); i++) {
    const double start = seconds_now();
    failed = p->stages[stage](p->user, i, &error);
    p->seconds[i][stage] = seconds_now() - start;
    end(r, stage, i, failed ? &error : NULL);
  }
}

static void *work_beside(void *user) {
  const worker *w = user;
  work(w->run, w->stage);
  return NULL;
}

/* Starts threads for the first and the last stage.  Returns how many started.
 */
static int start(worker *workers, pthread_t *threads, int *status) {
  int started = 0;
  while (started < 2 &&
         (*status = pthread_create(&threads[started], NULL, work_beside,
                                   &workers[started])) == 0)
    started++;
  return started;
}

int pipeline_run(const pipeline *p, image_error *error) {
  run r = {.pipeline = p, .failed = p->items, .error = error};
  worker workers[2] = {{&r, 0}, {&r, PIPELINE_STAGES - 1}};
  pthread_t threads[2];
  image_error why;
  int status = 0;
  pthread_mutex_init(&r.lock, NULL);
  pthread_cond_init(&r.changed, NULL);
  const int started = start(workers, threads, &status);
  if (started < 2) {
    image_fail(&why,
               "no thread for reading and writing: %s; fewer processes are "
               "needed",
               strerror(status));
    end(&r, 0, 0, &why);
  }
  work(&r, 1);
  for (int i = 0; i < started; i++)
    pthread_join(threads[i], NULL);
  pthread_cond_destroy(&r.changed);
  pthread_mutex_destroy(&r.lock);
  return r.failed < p->items ? -1 : 0;
}
