/* What the programs print on standard error, and how they print texts. */
#define _POSIX_C_SOURCE 200809L
#include "tool/report.h"

#include "image/clock.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <unistd.h>

/* ------------------------------------------------------------------------ */
/* Progress                                                                  */

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

/* ------------------------------------------------------------------------ */
/* Messages                                                                  */

/* The number of bytes of the character here, if it is UTF-8 and no control
 * character (C0, C1); otherwise 0. */
static size_t printable(const unsigned char *c) {
  /* the smallest second byte: below it, the form is overlong or a C1 */
  const unsigned least = *c == 0xe0 || *c == 0xc2 ? 0xa0
                         : *c == 0xf0             ? 0x90
                                                  : 0x80;
  const size_t length = *c < 0x80 ? 1 : *c < 0xe0 ? 2 : *c < 0xf0 ? 3 : 4;
  if (*c < ' ' || *c == 0x7f || (*c >= 0x80 && *c < 0xc2) || *c > 0xf4 ||
      (length > 1 && c[1] < least))
    return 0;
  for (size_t i = 1; i < length; i++)
    if ((c[i] & 0xc0) != 0x80)
      return 0;
  return length;
}

int report_text(const char *text, FILE *out) {
  int columns = 0;
  for (const unsigned char *c = (const unsigned char *)text; *c;) {
    const size_t length = printable(c);
    if (length > 0)
      columns += fwrite(c, length, 1, out) == 1;
    else if (*c == '\n')
      columns += fprintf(out, "\\n");
    else
      columns += fprintf(out, "\\x%02x", *c);
    c += length > 0 ? length : 1;
  }
  return columns;
}

int report_error(const image_error *error) {
  fputs("hbil: ", stderr);
  report_text(error->text, stderr);
  fputc('\n', stderr);
  return STATUS_BAD_INPUT;
}

void report_note(const char *path, const char *kind, const char *what) {
  fputs("hbil: ", stderr);
  report_text(path, stderr);
  fprintf(stderr, ": %s", kind);
  report_text(what, stderr);
  fputc('\n', stderr);
}
