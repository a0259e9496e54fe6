/*
 * Prints one line on standard error when an OpenCL driver or a crash ends the
 * process. Drivers abort or exit when memory or disk space runs out. The line
 * says what the driver was doing, and the exit status is STATUS_BAD_INPUT.
 * Signal handlers do this, so no second process is needed.
 */
#ifndef HBIL_TOOL_LAST_WORDS_H
#define HBIL_TOOL_LAST_WORDS_H

/* From the start of the program. */
void last_words_prepare(void);

/* What the OpenCL driver does from now on, as in "while it ..."; a string that
 * stays.  NULL: nothing, so that exit() is the program's own. */
void last_words_driver(const char *doing);

#endif
