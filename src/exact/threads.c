/*
 * Rows of a picture, shared among threads: thread i of n takes every n-th row
 * from row i on, so that all of them get the same mix of content.  A row
 * depends on no other, so the result does not depend on the number of threads.
 */
#define _POSIX_C_SOURCE 200809L
#include "exact/threads.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <unistd.h>

typedef struct worker {
  const exact_rows *rows;
  atomic_int *done;
  int first, step; /* rows */
  void *scratch;
  pthread_t thread;
  bool is_running;
} worker;

int exact_cpu_count(void) {
  const long cpus = sysconf(_SC_NPROCESSORS_ONLN);
  return cpus < 1 ? 1 : cpus > 1024 ? 1024 : (int)cpus;
}

static void report(const worker *w) {
  const exact_rows *rows = w->rows;
  if (rows->progress)
    rows->progress(rows->progress_user, atomic_load(w->done), rows->height);
}

static void run_share(const worker *w, bool reports) {
  for (int y = w->first; y < w->rows->height; y += w->step) {
    w->rows->run(w->rows->user, y, w->scratch);
    atomic_fetch_add(w->done, 1);
    if (reports)
      report(w);
  }
}

static void *run_thread(void *argument) {
  run_share(argument, false);
  return NULL;
}

static void run_all(worker *workers, int count) {
  for (int i = 1; i < count; ++i)
    workers[i].is_running =
        pthread_create(&workers[i].thread, NULL, run_thread, workers + i) == 0;
  for (int i = 0; i < count; ++i)
    if (!workers[i].is_running)
      run_share(workers + i, true);
  for (int i = 0; i < count; ++i)
    if (workers[i].is_running)
      pthread_join(workers[i].thread, NULL);
  report(workers);
}

exact_status exact_run_rows(const exact_rows *rows) {
  const int count = rows->threads > 0 ? rows->threads : exact_cpu_count();
  worker *workers = calloc((size_t)count, sizeof(*workers));
  exact_status status = workers ? EXACT_SUCCESS : EXACT_OUT_OF_MEMORY;
  atomic_int done = 0;
  for (int i = 0; i < count && status == EXACT_SUCCESS; ++i) {
    const worker w = {.rows = rows, .done = &done, .first = i, .step = count};
    workers[i] = w;
    workers[i].scratch = calloc(1, rows->scratch_size + 1);
    if (!workers[i].scratch)
      status = EXACT_OUT_OF_MEMORY;
  }
  if (status == EXACT_SUCCESS)
    run_all(workers, count);
  for (int i = 0; workers && i < count; ++i)
    free(workers[i].scratch);
  free(workers);
  return status;
}
