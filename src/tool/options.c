/* Reads command lines by tables of options, and checks them. */
#define _DEFAULT_SOURCE 1 /* ffs() */
#include "tool/options.h"

#include "hbil/hbil.h"
#include "image/error.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* getopt's value of the first option. */
enum { FIRST_OPTION = 256 };

/* The options that a command has. */
typedef struct option_list {
  const option_row *rows[OPTIONS_MOST];
  size_t count;
} option_list;

static option_list list_options(const option_command *c) {
  option_list l = {.count = 0};
  for (size_t g = 0; g < c->group_count; g++)
    for (size_t i = 0; i < c->groups[g].count; i++) {
      const option_row *row = &c->groups[g].rows[i];
      if (row->kind != OPTION_MORE &&
          (c->accepts & row->only_for) == row->only_for &&
          l.count < OPTIONS_MOST)
        l.rows[l.count++] = row;
    }
  return l;
}

/* ------------------------------------------------------------------------ */
/* Values                                                                    */

int option_floats(const char *option, const char *text, float *out,
                  size_t count, image_error *error) {
  const char *next = text;
  for (size_t i = 0; i < count; i++) {
    char *end;
    errno = 0;
    out[i] = strtof(next, &end);
    const int overflow = errno == ERANGE && isinf(out[i]);
    if (end == next || isnan(out[i]) || overflow ||
        *end != (i + 1 < count ? ',' : '\0'))
      return count == 1
                 ? image_fail(error, "%s %s: a number is needed", option, text)
                 : image_fail(error,
                              "%s %s: %zu numbers with commas between them are "
                              "needed",
                              option, text, count);
    next = end + 1;
  }
  return 0;
}

static int read_above(const char *option, const char *text, double bound,
                      float *out, size_t count, image_error *error) {
  if (option_floats(option, text, out, count, error) != 0)
    return -1;
  for (size_t i = 0; i < count; i++)
    if (!((double)out[i] > bound) || isinf(out[i]))
      return image_fail(error, "%s %s: finite numbers above %g are needed",
                        option, text, bound);
  return 0;
}

static int read_number(const char *option, const char *text, unsigned low,
                       unsigned high, unsigned *out, image_error *error) {
  char *end;
  const long long value = strtoll(text, &end, 10);
  if (end == text || *end || value < (long long)low || value > (long long)high)
    return image_fail(error, "%s %s: a whole number from %u to %u is needed",
                      option, text, low, high);
  *out = (unsigned)value;
  return 0;
}

static int read_size(const char *option, const char *text, unsigned out[2],
                     image_error *error) {
  char end;
  if (sscanf(text, "%5ux%5u%c", &out[0], &out[1], &end) != 2 || out[0] < 1 ||
      out[0] > HBIL_MAX_SIZE || out[1] < 1 || out[1] > HBIL_MAX_SIZE)
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

static int read_value(const option_row *row, const char *text, void *arguments,
                      image_error *error) {
  void *member = (char *)arguments + row->member;
  char option[64];
  int failed = 0, index = 0;
  snprintf(option, sizeof option, "--%s", row->name);
  switch (row->kind) {
  case OPTION_TEXT:
    *(const char **)member = text;
    break;
  case OPTION_FLAG:
  case OPTION_CLEAR:
    *(int *)member = row->kind == OPTION_FLAG;
    break;
  case OPTION_NUMBER:
    failed = read_number(option, text, row->low, row->high, member, error);
    break;
  case OPTION_FLOATS:
    failed = option_floats(option, text, member, row->high, error);
    break;
  case OPTION_ABOVE:
    failed = read_above(option, text, row->low, member, row->high, error);
    break;
  case OPTION_SIZE:
    failed = read_size(option, text, member, error);
    break;
  case OPTION_CHOICE:
    failed = option_choice(option, text, row->words, &index, error);
    *(int *)member = (int)row->low + index;
    break;
  default:
    break;
  }
  return failed || !row->set ? failed : row->set(text, arguments, error);
}

/* ------------------------------------------------------------------------ */
/* Options that fit together                                                 */

/* The words and the state of a command line. */
typedef struct request {
  option_list options;
  const char *arguments;
  const options_given *given;
} request;

static int value_of(const request *r, const option_row *row) {
  int value;
  memcpy(&value, r->arguments + row->member, sizeof value);
  return value;
}

/* Whether an option was given and asks for something: 0 and some choices
 * don't.  choices: 0, or those that it must be one of. */
static int is_asked(const request *r, const option_row *row, unsigned choices) {
  if (!r->given->member[row->member])
    return 0;
  if (row->kind == OPTION_NUMBER)
    return value_of(r, row) != 0;
  if (row->kind != OPTION_CHOICE)
    return 1;
  return choices     ? (int)(choices >> value_of(r, row) & 1)
         : row->high ? value_of(r, row) < (int)row->high
                     : 1;
}

static int report(const request *r, const option_row *row,
                  const option_row *other, const option_relation *relation,
                  image_error *error) {
  const int choice = relation->needed    ? ffs((int)relation->choices) - 1
                     : relation->choices ? value_of(r, other)
                                         : 0;
  const char *word =
      relation->choices ? other->words[choice - (int)other->low] : "";
  const char *space = *word ? " " : "";
  return relation->needed
             ? image_fail(error, "--%s: --%s%s%s%s is needed with it",
                          row->name, other->name, space, word, relation->why)
             : image_fail(error,
                          "--%s: not with --%s%s%s, %s; one or the other is "
                          "needed",
                          row->name, other->name, space, word, relation->why);
}

static int check_row(const request *r, const option_row *row,
                     image_error *error) {
  const option_relation *relation = row->relations;
  for (int i = 0; i < OPTION_RELATIONS && relation[i].why; i++)
    for (size_t k = 0; k < r->options.count; k++) {
      const option_row *other = r->options.rows[k];
      if (other->member == relation[i].other &&
          is_asked(r, other, relation[i].choices) != relation[i].needed)
        return report(r, row, other, &relation[i], error);
    }
  return 0;
}

static int check(const request *r, image_error *error) {
  for (size_t i = 0; i < r->options.count; i++)
    if (is_asked(r, r->options.rows[i], 0) &&
        check_row(r, r->options.rows[i], error) != 0)
      return -1;
  return 0;
}

/* ------------------------------------------------------------------------ */
/* The command line                                                          */

/* The options as getopt_long() takes them: a table, and the letters. */
static void make_getopt_table(const option_list *l, struct option *out,
                              char *letters) {
  *letters++ = ':'; /* a missing value is told by ':' */
  *letters++ = 'h';
  for (size_t i = 0; i < l->count; i++) {
    const option_row *row = l->rows[i];
    const int bare = row->kind == OPTION_FLAG || row->kind == OPTION_CLEAR;
    out[i] = (struct option){row->name, bare ? no_argument : required_argument,
                             NULL, FIRST_OPTION + (int)i};
    if (row->letter)
      *letters++ = row->letter;
    if (row->letter && !bare)
      *letters++ = ':';
  }
  *letters = '\0';
  out[l->count] = (struct option){"help", no_argument, NULL, 'h'};
  out[l->count + 1] = (struct option){NULL, 0, NULL, 0};
}

/* Takes an option that getopt_long() has found. */
static int take(const option_list *l, int found, void *arguments,
                options_given *given, image_error *error) {
  size_t i = found >= FIRST_OPTION ? (size_t)(found - FIRST_OPTION) : 0;
  while (found < FIRST_OPTION && l->rows[i]->letter != found)
    i++;
  given->member[l->rows[i]->member] = 1;
  return read_value(l->rows[i], optarg, arguments, error);
}

int options_read(const option_command *c, int argc, char **argv,
                 void *arguments, options_given *given, image_error *error) {
  const request r = {list_options(c), arguments, given};
  struct option table[OPTIONS_MOST + 2];
  char letters[2 * OPTIONS_MOST + 3];
  int found, last = optind;
  memset(given, 0, sizeof *given);
  opterr = 0;
  make_getopt_table(&r.options, table, letters);
  while ((found = getopt_long(argc, argv, letters, table, NULL)) != -1) {
    if (found == 'h')
      return 1;
    if (found == ':' || found == '?')
      return image_fail(error, "%s: %s %s; --help lists the options", argv[0],
                        argv[optind > last ? optind - 1 : last],
                        found == ':' ? "needs a value" : "is not an option");
    if (take(&r.options, found, arguments, given, error) != 0)
      return -1;
    last = optind;
  }
  return check(&r, error);
}
