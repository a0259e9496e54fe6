/* How far a long job is: one line that changes on a terminal, plain lines
 * elsewhere. */
#define _POSIX_C_SOURCE 200809L
#include "tool/tool.h"

#include <math.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

/* Seconds between two changes of the line. */
#define PACE 0.2

double progress_clock(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
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
                  .start = progress_clock(),
                  .expected = expected,
                  .shown = -PACE};
}

/* What was expected counts less and less against what was measured. */
static double time_left(const progress *p, double done) {
  const double elapsed = progress_clock() - p->start;
  return (1.0 - done) * (elapsed + (1.0 - done) * p->expected);
}

static void rewrite(progress *p, double done, const char *left) {
  const double elapsed = progress_clock() - p->start;
  if (elapsed < p->shown + PACE)
    return;
  p->shown = elapsed;
  p->dirty = 1;
  fprintf(stderr, "\r%s: %3.0f %%, %s left\033[K", p->what, 100.0 * done, left);
}

static void print_tenth(progress *p, double done, const char *left) {
  const int tenth = (int)(10.0 * done + 1e-9);
  if (tenth <= p->tenth)
    return;
  p->tenth = tenth;
  if (tenth >= 10)
    fprintf(stderr, "hbil: %s: 100 %%\n", p->what);
  else
    fprintf(stderr, "hbil: %s: %d %%, %s left\n", p->what, 10 * tenth, left);
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

void progress_clear(progress *p) {
  if (p->dirty)
    fputs("\r\033[K", stderr);
  p->dirty = 0;
}

void progress_count(const char *what, size_t done, size_t count) {
  if (isatty(STDERR_FILENO))
    fprintf(stderr, "\r%s: %zu of %zu\033[K%s", what, done, count,
            done == count ? "\n" : "");
}
