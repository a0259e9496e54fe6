/* Reads command lines. */
#include "tool/options.h"

#include "hbil/hbil.h"
#include "image/error.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int option_next(int argc, char **argv, const char *letters,
                const struct option *options, image_error *error) {
  opterr = 0;
  const int at = optind;
  const int found = getopt_long(argc, argv, letters, options, NULL);
  if (found == ':')
    image_fail(error, "%s: %s needs a value; --help lists the options", argv[0],
               argv[optind - 1]);
  else if (found == '?')
    image_fail(error, "%s: %s is not understood; --help lists the options",
               argv[0], argv[optind > at ? optind - 1 : at]);
  return found == ':' ? '?' : found;
}

int option_floats(const char *option, const char *text, float *out,
                  size_t count, image_error *error) {
  const char *at = text;
  for (size_t i = 0; i < count; i++) {
    char *end;
    errno = 0;
    out[i] = strtof(at, &end);
    const int overflow = errno == ERANGE && isinf(out[i]);
    if (end == at || isnan(out[i]) || overflow ||
        *end != (i + 1 < count ? ',' : '\0'))
      return count == 1
                 ? image_fail(error, "%s %s: a number is needed", option, text)
                 : image_fail(error,
                              "%s %s: %zu numbers with commas between them are "
                              "needed",
                              option, text, count);
    at = end + 1;
  }
  return 0;
}

int option_unsigned(const char *option, const char *text, unsigned low,
                    unsigned high, unsigned *out, image_error *error) {
  char *end;
  const long long value = strtoll(text, &end, 10);
  if (end == text || *end || value < (long long)low || value > (long long)high)
    return image_fail(error, "%s %s: a whole number from %u to %u is needed",
                      option, text, low, high);
  *out = (unsigned)value;
  return 0;
}

int option_size(const char *option, const char *text, unsigned *width,
                unsigned *height, image_error *error) {
  char end;
  if (sscanf(text, "%5ux%5u%c", width, height, &end) != 2 || *width < 1 ||
      *width > HBIL_MAX_SIZE || *height < 1 || *height > HBIL_MAX_SIZE)
    return image_fail(error,
                      "%s %s: WIDTHxHEIGHT is needed, each from 1 to %d, such "
                      "as 1280x720",
                      option, text, HBIL_MAX_SIZE);
  return 0;
}

int option_choice(const char *option, const char *text,
                  const char *const *words, int *out, image_error *error) {
  char list[256] = "";
  for (int i = 0; words[i]; i++) {
    if (strcmp(text, words[i]) == 0) {
      *out = i;
      return 0;
    }
    const size_t used = strlen(list);
    snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", words[i]);
  }
  return image_fail(error, "%s %s: one of %s is needed", option, text, list);
}
