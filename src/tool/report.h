/* Messages of the programs hbil and hbil-bench on standard error. */
#ifndef HBIL_TOOL_REPORT_H
#define HBIL_TOOL_REPORT_H

#include "image/error.h"

#include <stdio.h>

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
