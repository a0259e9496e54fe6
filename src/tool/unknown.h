/* How much of a job's light is a guess: the mean of the layer `unknown`. */
#ifndef HBIL_TOOL_UNKNOWN_H
#define HBIL_TOOL_UNKNOWN_H

#include "dump/gbuffer.h"
#include "tool/job.h"
#include "tool/sequence.h"

/* Sets the row's `surfaces` and `unknown` from the pixels that are written.
 * share: the layer, over j->window; NULL: nothing is a guess, and both become
 * 0. */
void unknown_measure(const job *j, const gbuffer *g, const float *share,
                     timing_row *row);

/* The mean over all surfaces of these frames; *surfaces: their number. */
double unknown_mean(const timing_row *rows, size_t count, size_t *surfaces);

/* Prints the mean of a whole job as a line on standard error, and a warning if
 * it is large, with what would help; nothing without surfaces.  has_cache: the
 * last place had one. */
void unknown_report(const job *whole, int has_cache, const timing_row *rows,
                    size_t count);

#endif
