/* Refusals of the library and of OpenCL. */
#include "tool/refusal.h"

#include "tool/process_options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* The option                                                                */

/* "model.radius: -1; must be positive" becomes "--radius: -1; must be
 * positive".  Returns 0 if no option is meant. */
static int report_option(const char *message, image_error *error) {
  const char *colon = strchr(message, ':');
  const char *option = colon ? process_option_of(message) : NULL;
  if (option)
    image_fail(error, "--%s%s", option, colon);
  return option != NULL;
}

/* ------------------------------------------------------------------------ */
/* The file and the device                                                   */

/* Without the name of the function that some messages begin with. */
static const char *without_function(const char *message) {
  const size_t length =
      strspn(message, "abcdefghijklmnopqrstuvwxyz_0123456789");
  return strncmp(message, "hbil_", 5) == 0 &&
                 strncmp(message + length, ": ", 2) == 0
             ? message + length + 2
             : message;
}

/* "lit.exr: device NAME" or one of both; "the library" for neither. */
static void name_place(const device *d, const char *path, char *out,
                       size_t size) {
  if (!d && !path)
    snprintf(out, size, "the library");
  else
    snprintf(out, size, "%s%s%s%s", path ? path : "", path && d ? ": " : "",
             d ? "device " : "", d ? d->name : "");
}

static int report_memory(const device *d, const char *place,
                         const char *message, image_error *error) {
  char limit[64] = "";
  if (d)
    snprintf(limit, sizeof limit, "; it has %llu MiB",
             device_memory(d->id) >> 20);
  return image_fail(error,
                    "%s: not enough memory: %s%s; smaller frames, a smaller "
                    "--cache-size, or more memory are needed",
                    place, message, limit);
}

int refusal(const device *d, const char *path, hbil_status status,
            const hbil_context *context, image_error *error) {
  char place[IMAGE_ERROR_SIZE / 2];
  const char *text = without_function(hbil_context_message(context));
  const char *message = *text ? text : hbil_status_string(status);
  const int is_about_file =
      path && (status == HBIL_INVALID_FRAME || status == HBIL_INVALID_ARGUMENT);
  if (report_option(message, error))
    return -1;
  name_place(is_about_file ? NULL : d, path, place, sizeof place);
  if (status == HBIL_OUT_OF_DEVICE_MEMORY || status == HBIL_OUT_OF_HOST_MEMORY)
    return report_memory(status == HBIL_OUT_OF_DEVICE_MEMORY ? d : NULL, place,
                         message, error);
  const char *kernels = getenv("HBIL_KERNEL_DIR");
  if (status == HBIL_BUILD_FAILED && kernels && *kernels)
    return image_fail(error, "%s: HBIL_KERNEL_DIR %s: %s", place, kernels,
                      message);
  return image_fail(error, "%s: %s", place, message);
}

int refusal_of_opencl(const device *d, const char *path, cl_int status,
                      const char *doing, image_error *error) {
  char place[IMAGE_ERROR_SIZE / 2], message[128];
  name_place(d, path, place, sizeof place);
  snprintf(message, sizeof message, "OpenCL error %d while %s", (int)status,
           doing);
  if (status == CL_MEM_OBJECT_ALLOCATION_FAILURE ||
      status == CL_OUT_OF_RESOURCES || status == CL_INVALID_BUFFER_SIZE ||
      status == CL_OUT_OF_HOST_MEMORY)
    return report_memory(d, place, message, error);
  return image_fail(error, "%s: %s", place, message);
}
