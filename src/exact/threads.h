/* Rows of a picture, shared among threads. */
#ifndef HBIL_EXACT_THREADS_H
#define HBIL_EXACT_THREADS_H

#include "exact/exact.h"

/* What is done for each row, once, in any order.  scratch: the thread's own. */
typedef void exact_row_function(void *user, int y, void *scratch);

typedef struct exact_rows {
  exact_row_function *run;
  void *user;
  int height;
  int threads;         /* 0: one for each CPU */
  size_t scratch_size; /* bytes for each thread; 0: none */
  void (*progress)(void *user, int done, int count); /* as in exact_dense */
  void *progress_user;
} exact_rows;

/* Runs all rows.  The calling thread takes its share, and that of threads that
 * cannot be started: that is no failure. */
exact_status exact_run_rows(const exact_rows *rows);

#endif
