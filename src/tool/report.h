/* What the programs print on standard error: messages, and progress. */
#ifndef HBIL_TOOL_REPORT_H
#define HBIL_TOOL_REPORT_H

#include "image/error.h"

#include <stddef.h>
#include <stdio.h>

/* ------------------------------------------------------------------------ */
/* Progress                                                                  */

typedef struct progress {
  const char *what;
  int quiet, terminal;
  int tenth;                     /* the last tenth that was printed */
  double start, expected, shown; /* seconds */
} progress;

/* "3 min 20 s". */
void progress_duration(double seconds, char *text, size_t size);

/* expected: seconds that the job will probably take; 0: unknown. */
void progress_start(progress *p, const char *what, double expected, int quiet);

/* done: 0..1.  Rewrites the line, or prints one for every 10 %. */
void progress_show(progress *p, double done);

/* A bar with rate and time left, for a terminal. */
void progress_frames(progress *p, size_t done, size_t count);

/* Between these two calls the caller may print lines; other threads wait before
 * they show progress. */
void progress_line_begin(void);
void progress_line_end(void);

/* Removes the line that is shown. */
void progress_clear(void);

/* "WHAT: 3 of 8" as a line that counts up, only on a terminal. */
void progress_count(const char *what, size_t done, size_t count);

/* ------------------------------------------------------------------------ */
/* Messages                                                                  */

/* Exit statuses. */
enum { STATUS_OK = 0, STATUS_DIFFERS = 1, STATUS_BAD_INPUT = 2 };

/* Prints "hbil: TEXT" as one line.  Returns STATUS_BAD_INPUT. */
int report_error(const image_error *error);

/* Prints "hbil: PATH: KINDWHAT" as one line; kind is "" or "warning: ". */
void report_note(const char *path, const char *kind, const char *what);

/* Prints a text that comes from outside.  Control characters, and bytes that
 * aren't UTF-8, become \n and \xNN, so that it stays on one line and cannot
 * control a terminal.  Returns the number of columns. */
int report_text(const char *text, FILE *out);

#endif
