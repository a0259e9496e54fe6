/* Findings about a dump. */
#include "dump/findings.h"

#include "image/error.h"

#include <stdarg.h>
#include <stdio.h>

void findings_add(findings *out, const char *format, ...) {
  va_list arguments;
  if (out->count == FINDINGS_MAX)
    return;
  va_start(arguments, format);
  vsnprintf(out->text[out->count++], sizeof *out->text, format, arguments);
  va_end(arguments);
}
