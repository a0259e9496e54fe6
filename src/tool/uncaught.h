/* Exceptions that leave a thread of an OpenCL driver. */
#ifndef HBIL_TOOL_UNCAUGHT_H
#define HBIL_TOOL_UNCAUGHT_H

#ifdef __cplusplus
extern "C" {
#endif

/* Has `end` called for an exception that nobody catches, with what is wrong, as
 * in "the process ran out of memory".  It must not return. */
void uncaught_prepare(void (*end)(const char *why));

#ifdef __cplusplus
}
#endif

#endif
