/* Shows how far a long job is. */
#define _POSIX_C_SOURCE 200809L
#include "tool/progress.h"

#include "image/clock.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <unistd.h>

/* Seconds between two changes of the line. */
#define PACE 0.2

/* The threads share standard error.  `shown`: its last line is progress. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static int shown;

void progress_line_begin(void) {
  pthread_mutex_lock(&lock);
  if (shown)
    fputs("\r\033[K", stderr);
  shown = 0;
}

void progress_line_end(void) {
  pthread_mutex_unlock(&lock);
}

void progress_clear(void) {
  progress_line_begin();
  progress_line_end();
}

void progress_duration(double seconds, char *text, size_t size) {
  const double whole = fmin(fmax(seconds, 0.0), 1e12) + 0.5;
  const long long s = (long long)whole;
  if (s < 1)
    snprintf(text, size, "less than 1 s");
  else if (s < 60)
    snprintf(text, size, "%lld s", s);
  else if (s < 3600)
    snprintf(text, size, "%lld min %02lld s", s / 60, s % 60);
  else
    snprintf(text, size, "%lld h %02lld min", s / 3600, s % 3600 / 60);
}

void progress_start(progress *p, const char *what, double expected, int quiet) {
  *p = (progress){.what = what,
                  .quiet = quiet,
                  .terminal = isatty(STDERR_FILENO),
                  .start = seconds_now(),
                  .expected = expected,
                  .shown = -PACE};
}

/* The expected time loses weight against the measured time as the job goes on.
 */
static double time_left(const progress *p, double done) {
  const double elapsed = seconds_now() - p->start;
  return (1.0 - done) * (elapsed + (1.0 - done) * p->expected);
}

/* Whether it is time to change the line. */
static int is_due(progress *p) {
  const double elapsed = seconds_now() - p->start;
  if (elapsed < p->shown + PACE)
    return 0;
  p->shown = elapsed;
  return 1;
}

static void rewrite(progress *p, double done, const char *left) {
  if (!is_due(p))
    return;
  progress_line_begin();
  shown = 1;
  fprintf(stderr, "%s: %3.0f %%, %s left", p->what, 100.0 * done, left);
  progress_line_end();
}

static void print_tenth(progress *p, double done, const char *left) {
  const int tenth = (int)(10.0 * done + 1e-9);
  if (tenth <= p->tenth)
    return;
  p->tenth = tenth;
  progress_line_begin();
  if (tenth >= 10)
    fprintf(stderr, "hbil: %s: 100 %%\n", p->what);
  else
    fprintf(stderr, "hbil: %s: %d %%, %s left\n", p->what, 10 * tenth, left);
  progress_line_end();
}

void progress_show(progress *p, double done) {
  char left[32];
  if (p->quiet)
    return;
  progress_duration(time_left(p, done), left, sizeof left);
  if (p->terminal)
    rewrite(p, done, left);
  else
    print_tenth(p, done, left);
}

void progress_frames(progress *p, size_t done, size_t count) {
  enum { WIDTH = 24 };
  char bar[WIDTH + 1], left[32];
  const double elapsed = seconds_now() - p->start;
  if (done == 0 || done > count || !is_due(p))
    return;
  const size_t filled = done * WIDTH / count;
  for (size_t i = 0; i < WIDTH; i++)
    bar[i] = i < filled ? '#' : '.';
  bar[WIDTH] = '\0';
  progress_duration(elapsed * (double)(count - done) / (double)done, left,
                    sizeof left);
  progress_line_begin();
  shown = 1;
  fprintf(stderr, "[%s] %zu/%zu, %.3g frames/s, %s left", bar, done, count,
          (double)done / elapsed, left);
  progress_line_end();
}

void progress_count(const char *what, size_t done, size_t count) {
  if (isatty(STDERR_FILENO))
    fprintf(stderr, "\r%s: %zu of %zu\033[K%s", what, done, count,
            done == count ? "\n" : "");
}
