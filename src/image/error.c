#include "image/error.h"

#include <stdarg.h>
#include <stdio.h>

int image_fail(image_error *error, const char *format, ...) {
  if (error) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
  }
  return -1;
}

int image_no_memory(image_error *error, const char *path) {
  return image_fail(error,
                    "%s: not enough memory; a smaller image or a machine with "
                    "more memory is needed",
                    path);
}
