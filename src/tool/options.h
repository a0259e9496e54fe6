/*
 * Options of a command line.  A row describes one option: its name, the member
 * that it sets, its range or words, its help, and which other options it needs
 * or excludes.  The parser, the checks and the help read the rows; manual and
 * completion come from the help (doc/help.awk).
 *
 * The members are those of a struct of the command, its arguments, which is
 * smaller than OPTION_ARGUMENTS.  An option is known by its member: by the
 * offset of that in the arguments.
 */
#ifndef HBIL_TOOL_OPTIONS_H
#define HBIL_TOOL_OPTIONS_H

#include "image/error.h"

#include <stddef.h>

typedef enum option_kind {
  OPTION_OTHER = 0, /* only row.set reads it */
  OPTION_TEXT,      /* const char * */
  OPTION_FLAG,      /* no value; an int becomes 1 */
  OPTION_CLEAR,     /* no value; an int becomes 0 */
  OPTION_NUMBER,    /* unsigned: a whole number from `low` to `high` */
  OPTION_FLOATS,    /* float: `high` numbers with commas between them */
  OPTION_ABOVE,     /* the same; they are finite and above `low` */
  OPTION_SIZE,      /* two unsigned: WIDTHxHEIGHT */
  OPTION_CHOICE,    /* an enum: `low` + the index in `words`.  Choices from
                     * `high` on switch something off, if it isn't 0 */
  OPTION_MORE       /* no option: more help about the one before */
} option_kind;

/* What an option needs or excludes.  why is NULL behind the last one. */
typedef struct option_relation {
  size_t other;     /* the other option */
  unsigned choices; /* only these of it, 1 << choice each; 0: whatever it is */
  int needed;       /* 1: it is needed; 0: it is excluded */
  const char *why;  /* excluded: "which has no ..."; needed: what the message
                     * says behind its name, "" or " FILE" */
} option_relation;

enum { OPTION_RELATIONS = 6, OPTIONS_MOST = 96, OPTION_ARGUMENTS = 2048 };

/* Reads a value, or does what follows from one that has been stored.  text:
 * NULL for options without a value.  0, or -1 with `error` filled. */
typedef int option_setter(const char *text, void *arguments,
                          image_error *error);

typedef struct option_row {
  const char *name; /* without dashes */
  option_kind kind;
  size_t member; /* its offset in the arguments */
  unsigned low, high;
  const char *const *words; /* of a choice; ends with NULL */
  const char *value;        /* its name in the help; NULL: the words */
  char letter;              /* its short form, or 0 */
  unsigned
      only_for;     /* commands take it whose `accepts` has all of these bits */
  const char *help; /* without line ends; see option_value */
  option_setter *set;  /* NULL: there is nothing more to do */
  const char *library; /* the library's names of the member, with spaces between
                        * them: its messages begin with one of them */
  option_relation relations[OPTION_RELATIONS];
} option_row;

/* The designators of a row. */
#define ROW_OTHER(option, offset, setter, text)                                \
  .name = option, .member = offset, .set = setter, .value = text
#define ROW_TEXT(option, offset, text)                                         \
  .name = option, .kind = OPTION_TEXT, .member = offset, .value = text
#define ROW_FLAG(option, offset)                                               \
  .name = option, .kind = OPTION_FLAG, .member = offset
#define ROW_NUMBER(option, offset, least, most, text)                          \
  .name = option, .kind = OPTION_NUMBER, .member = offset, .low = least,       \
  .high = most, .value = text
#define ROW_FLOATS(option, offset, count, text)                                \
  .name = option, .kind = OPTION_FLOATS, .member = offset, .high = count,      \
  .value = text
#define ROW_CHOICE(option, offset, list)                                       \
  .name = option, .kind = OPTION_CHOICE, .member = offset, .words = list
#define ROW_MORE(option, text)                                                 \
  .name = option, .kind = OPTION_MORE, .value = text

/* Relations of a row. */
#define NOT_WITH(option, choices, because)                                     \
  { option, choices, 0, because }
#define NEEDS(option, choices, what)                                           \
  { option, choices, 1, what }

/* Rows below one heading. */
typedef struct option_group {
  const char *about;   /* a paragraph in front of the heading, or NULL */
  const char *heading; /* NULL: none */
  const option_row *rows;
  size_t count;
} option_group;

/* A number that help texts name in braces, such as {levels}.  {} stands for the
 * option's default. */
typedef struct option_value {
  const char *name;
  double value;
} option_value;

typedef struct option_command {
  const char *usage; /* the help in front of the options: "usage: ..." */
  const option_group *groups;
  size_t group_count;
  const char *notes; /* the help behind the options, or NULL */
  const option_value *values;
  size_t value_count;
  unsigned accepts; /* see option_row.only_for */
} option_command;

/* Which options were given, by the offsets of their members. */
typedef struct options_given {
  char member[OPTION_ARGUMENTS];
} options_given;

/* Reads a command line into `arguments`, which have the defaults, and checks
 * that the options fit together.  argv[0] is the command's name; optind is then
 * the index of the first argument that is no option.  Returns 0, 1 if help is
 * wanted, or -1 with `error` filled. */
int options_read(const option_command *c, int argc, char **argv,
                 void *arguments, options_given *given, image_error *error);

/* Prints the help.  defaults: arguments that nothing has changed. */
void options_help(const option_command *c, const void *defaults);

/* Single values.  0, or -1 with `error` filled (NULL is allowed).  option: its
 * name with dashes, for the message. */

/* Exactly `count` numbers, separated by commas.  "inf" is a number; "nan" and
 * what is too large for a float are not. */
int option_floats(const char *option, const char *text, float *out,
                  size_t count, image_error *error);
/* The index of text in a list of words that ends with NULL. */
int option_choice(const char *option, const char *text,
                  const char *const *words, int *out, image_error *error);

#endif
