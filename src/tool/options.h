/* Reads command lines: options, and values that are numbers or words.  Messages
 * say what was given and what would be right. */
#ifndef HBIL_TOOL_OPTIONS_H
#define HBIL_TOOL_OPTIONS_H

#include "image/error.h"

#include <stddef.h>

struct option;

/* getopt_long() with messages of our own; letters begins with ':'.  argv[0] is
 * the command's name.  Returns -1 at the end, and '?' with `error` filled for
 * an option that is unknown or lacks its value. */
int option_next(int argc, char **argv, const char *letters,
                const struct option *options, image_error *error);

/* The functions below return 0, or -1 with `error` filled (NULL is allowed).
 * option: the option's name, for the message. */

/* Exactly `count` numbers, separated by commas.  "inf" is a number; "nan" and
 * what is too large for a float are not. */
int option_floats(const char *option, const char *text, float *out,
                  size_t count, image_error *error);
int option_unsigned(const char *option, const char *text, unsigned low,
                    unsigned high, unsigned *out, image_error *error);
/* WIDTHxHEIGHT, each from 1 to HBIL_MAX_SIZE. */
int option_size(const char *option, const char *text, unsigned *width,
                unsigned *height, image_error *error);
/* The index of text in a list of words that ends with NULL. */
int option_choice(const char *option, const char *text,
                  const char *const *words, int *out, image_error *error);

#endif
