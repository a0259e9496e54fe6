/* The library's statistics of a frame, as text and as JSON. */
#ifndef HBIL_TOOL_STATISTICS_H
#define HBIL_TOOL_STATISTICS_H

#include "hbil/hbil.h"

#include <jansson.h>
#include <stdio.h>

/* What a frame left out, without an end of line. */
void statistics_print(const hbil_statistics *s, FILE *out);

/* The same as an object: "all", "sky", "open", "dark", "unused" and "cached",
 * each with "pixels" and "spans", and the list "not_run" of passes. */
json_t *statistics_json(const hbil_statistics *s);

/* "depth 3, motion 1": inputs with pixels that were sanitized, without an end
 * of line.  Prints `before` first if there are any; returns whether there are.
 */
int sanitized_print(const hbil_sanitized *s, const char *before, FILE *out);

/* The number of sanitized pixels of each input, as an object. */
json_t *sanitized_json(const hbil_sanitized *s);

#endif
