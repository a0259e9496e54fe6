/*
 * What a command has found: tables and notes, written once as Markdown and once
 * as JSON.  Both name the machine, the driver, the version and the date.
 *
 * Rows are filled cell by cell, from left to right.  Functions that add to a
 * report don't fail; bench_report_write() tells when memory has run out.
 */
#ifndef HBIL_BENCH_REPORT_H
#define HBIL_BENCH_REPORT_H

#include <stdio.h>

#include "bench/command.h"
#include "bench/opencl.h"

typedef struct bench_report bench_report;

typedef struct bench_column {
  const char *key;   /* in JSON */
  const char *title; /* in Markdown, with its unit; NULL: in JSON alone */
  int digits;        /* behind the decimal point; BENCH_TEXT for words */
} bench_column;

enum { BENCH_TEXT = -1, BENCH_TABLES = 6 };

/* NULL when out of memory. */
bench_report *bench_report_new(const bench_command *command,
                               const bench_device *device);
void bench_report_free(bench_report *r);

/* What was measured: "procedural room", 1280 x 720 pixels.  runs: of which
 * times are medians; with 0, or without a subject, the report says nothing of
 * times. */
void bench_report_subject(bench_report *r, const char *content, uint32_t width,
                          uint32_t height, unsigned runs);
/* Begins a table of at most BENCH_TABLES; columns must outlive the report. */
void bench_report_table(bench_report *r, const char *key, const char *title,
                        const bench_column *columns, size_t count);
/* Begins a row of the last table. */
void bench_report_row(bench_report *r);
/* The next cells of the row.  A number that is not finite is an empty cell, and
 * null in JSON.  Markdown leaves out columns whose cells are
 * all empty. */
void bench_report_text(bench_report *r, const char *text);
void bench_report_number(bench_report *r, double value);
/* Median, lowest and highest, as three cells. */
void bench_report_spread(bench_report *r, bench_spread s);
/* A whole sentence below the tables, as printf does. */
void bench_report_note(bench_report *r, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* Creates the folder of the results, and looks for the section that --markdown
 * replaces, so that a mistake is told before anything is measured. */
int bench_report_check(const bench_options *options, image_error *error);
/* Prints the report, writes DIR/NAME.md and DIR/NAME.json, and replaces the
 * section of --markdown. */
int bench_report_write(const bench_report *r, const bench_options *options,
                       image_error *error);

#endif
