/* Refusals of the library and of OpenCL, as the tool's user reads them: with
 * the option, the file or the device's limit in place of a member of a struct.
 */
#ifndef HBIL_TOOL_REFUSAL_H
#define HBIL_TOOL_REFUSAL_H

#include "hbil/hbil.h"
#include "image/error.h"
#include "tool/device.h"

/* Reports why a call of the library failed.  device: NULL if none is in use.
 * path: the file that was being worked on, or NULL.  context: that of the call;
 * NULL: the call had none.  Always returns -1, with `error` filled. */
int refusal(const device *d, const char *path, hbil_status status,
            const hbil_context *context, image_error *error);

/* The same for a call of OpenCL; doing: "making a buffer". */
int refusal_of_opencl(const device *d, const char *path, cl_int status,
                      const char *doing, image_error *error);

#endif
