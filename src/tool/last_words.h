/*
 * One line on standard error where something ends the process that is not ours
 * to catch: OpenCL drivers abort, or exit, without memory and without room on
 * the disk.  The line says what was being done, and the exit status is
 * STATUS_BAD_INPUT.  It costs no process and no time.
 */
#ifndef HBIL_TOOL_LAST_WORDS_H
#define HBIL_TOOL_LAST_WORDS_H

/* From the start of the program. */
void last_words_prepare(void);

/* What the OpenCL driver does from now on, as in "while it ..."; a string that
 * stays.  NULL: nothing, so that exit() is the program's own. */
void last_words_driver(const char *doing);

#endif
