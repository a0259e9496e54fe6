/*
 * The passes of a frame, each with its double-precision version, the stage that
 * it writes, and how far it may be off.
 */
#ifndef HBIL_TEST_PASS_ROWS_H
#define HBIL_TEST_PASS_ROWS_H

#include "test/support/draw.h"

/* Runs a frame that draw_frame() has uploaded, pass by pass, and compares what
 * each pass writes with what the exact pass makes of the device's own stages
 * before it.  index: of the frame, in the plan's sequence.  planted: stages are
 * replaced by random values before the passes that read them. */
void check_passes(setup *s, drawn *d, uint32_t index, bool planted);

#endif
