/* Prints the help of a command. */
#include "tool/options.h"

#include <stdio.h>
#include <string.h>

/* Columns: where the texts of options begin, and the last one of a line. */
enum { TEXT_COLUMN = 24, LAST_COLUMN = 73, TEXT_SIZE = 2048 };

/* Text that grows. */
typedef struct text {
  char at[TEXT_SIZE];
  size_t used;
} text;

static void add(text *t, const char *begin, size_t length) {
  if (length > sizeof t->at - 1 - t->used)
    length = sizeof t->at - 1 - t->used;
  memcpy(t->at + t->used, begin, length);
  t->used += length;
  t->at[t->used] = '\0';
}

static void add_text(text *t, const char *more) {
  add(t, more, strlen(more));
}

static void add_number(text *t, double number) {
  char digits[32];
  snprintf(digits, sizeof digits, "%g", number);
  add_text(t, digits);
}

/* The value of an option that isn't given.  defaults: the struct with the
 * row's member. */
static void add_default(text *t, const option_row *row, const void *defaults) {
  const void *member = (const char *)defaults + row->member;
  const float *numbers = member;
  switch (row->kind) {
  case OPTION_TEXT:
    add_text(t, *(const char *const *)member);
    break;
  case OPTION_NUMBER:
    add_number(t, *(const unsigned *)member);
    break;
  case OPTION_SIZE:
    add_number(t, ((const unsigned *)member)[0]);
    add_text(t, "x");
    add_number(t, ((const unsigned *)member)[1]);
    break;
  case OPTION_CHOICE:
    add_text(t, row->words[*(const int *)member - (int)row->low]);
    break;
  default:
    for (unsigned i = 0; i < row->high; i++) {
      add_text(t, i ? "," : "");
      add_number(t, (double)numbers[i]);
    }
  }
}

/* Whether braces hold what a number replaces. */
static int add_value(text *t, const option_command *c, const char *name,
                     size_t length) {
  for (size_t i = 0; i < c->value_count; i++)
    if (strlen(c->values[i].name) == length &&
        strncmp(c->values[i].name, name, length) == 0) {
      add_number(t, c->values[i].value);
      return 1;
    }
  return 0;
}

static void add_help(text *t, const option_command *c, const option_row *row,
                     const void *defaults) {
  for (const char *next = row->help; *next;) {
    const size_t plain = strcspn(next, "{");
    add(t, next, plain);
    next += plain;
    const size_t inner = *next ? strcspn(next + 1, "}") : 0;
    if (*next && inner == 0)
      add_default(t, row, defaults);
    else if (*next && !add_value(t, c, next + 1, inner)) {
      add(t, next++, 1); /* braces of the text */
      continue;
    }
    next += *next ? inner + 2 : 0;
  }
}

/* Prints a text that begins in `column`.  Each further line is indented by
 * `indent`.  Line ends stay. */
static void print_wrapped(const char *words, size_t column, size_t indent) {
  int begins = 1;
  while (*words) {
    const size_t length = strcspn(words, " \n"), spaces = strspn(words, " ");
    if (*words == '\n' ||
        (!begins &&
         column + spaces + strcspn(words + spaces, " \n") > LAST_COLUMN)) {
      printf("\n%*s", words[1] == '\n' ? 0 : (int)indent, "");
      column = indent;
      begins = 1;
      words += *words == '\n' ? 1 : spaces;
      continue;
    }
    const size_t part = spaces ? spaces : length;
    printf("%.*s", (int)part, words);
    column += part;
    begins = 0;
    words += part;
  }
  putchar('\n');
}

/* "  -o, --output DIR      ", or a line of its own if it is long. */
static void print_row(const option_command *c, const option_row *row,
                      const void *defaults) {
  text head = {.used = 0}, help = {.used = 0};
  add_text(&head, "  ");
  if (row->letter) {
    add(&head, "-", 1);
    add(&head, &row->letter, 1);
    add_text(&head, ", ");
  }
  add_text(&head, "--");
  add_text(&head, row->name);
  if (row->value || row->words)
    add_text(&head, " ");
  for (size_t i = 0; !row->value && row->words && row->words[i]; i++) {
    add_text(&head, i ? "|" : "");
    add_text(&head, row->words[i]);
  }
  if (row->value)
    add_text(&head, row->value);
  add_help(&help, c, row, defaults);
  printf("%-*s", TEXT_COLUMN - 1, head.at);
  if (head.used >= TEXT_COLUMN)
    printf("\n%*s", TEXT_COLUMN - 1, "");
  putchar(' ');
  print_wrapped(help.at, TEXT_COLUMN, TEXT_COLUMN);
}

static void print_group(const option_command *c, const option_group *group,
                        const void *defaults) {
  if (group->about) {
    putchar('\n');
    print_wrapped(group->about, 0, 0);
  }
  if (group->heading)
    printf("\n%s:\n", group->heading);
  for (size_t i = 0; i < group->count; i++)
    if ((c->accepts & group->rows[i].of) == group->rows[i].of)
      print_row(c, &group->rows[i], (const char *)defaults + group->base);
}

void options_help(const option_command *c, const void *defaults) {
  print_wrapped(c->usage, 0, 0);
  putchar('\n');
  for (size_t g = 0; g < c->group_count; g++) {
    print_group(c, &c->groups[g], defaults);
    if (g == 0)
      puts("  -h, --help            this text");
  }
  if (c->notes) {
    putchar('\n');
    print_wrapped(c->notes, 0, 0);
  }
}
