/* Prints the help of a command. */
#define _POSIX_C_SOURCE 200809L
#include "tool/options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Columns: where the texts of options begin, and the last one of a line. */
enum { TEXT_COLUMN = 24, LAST_COLUMN = 73 };

/* The value of an option that isn't given. */
static void write_default(const option_row *row, const void *defaults,
                          FILE *out) {
  const void *member = (const char *)defaults + row->member;
  const unsigned *whole = member;
  const float *numbers = member;
  switch (row->kind) {
  case OPTION_TEXT:
    fputs(*(const char *const *)member, out);
    break;
  case OPTION_NUMBER:
    fprintf(out, "%u", *whole);
    break;
  case OPTION_SIZE:
    fprintf(out, "%ux%u", whole[0], whole[1]);
    break;
  case OPTION_CHOICE:
    fputs(row->words[*whole - row->low], out);
    break;
  default:
    for (unsigned i = 0; i < row->high; i++)
      fprintf(out, "%s%g", i ? "," : "", (double)numbers[i]);
  }
}

/* Writes what stands for a name in braces.  Returns whether there is such a
 * name; other braces belong to the text. */
static int write_value(const option_command *c, const char *name, size_t length,
                       FILE *out) {
  for (size_t i = 0; i < c->value_count; i++)
    if (strlen(c->values[i].name) == length &&
        strncmp(c->values[i].name, name, length) == 0)
      return fprintf(out, "%g", c->values[i].value) > 0;
  return 0;
}

static void write_help(const option_command *c, const option_row *row,
                       const void *defaults, FILE *out) {
  for (const char *next = row->help; *next; next++) {
    const size_t inner = *next == '{' ? strcspn(next + 1, "}") : 0;
    if (strncmp(next, "{}", 2) == 0)
      write_default(row, defaults, out);
    else if (!inner || !write_value(c, next + 1, inner, out)) {
      putc(*next, out);
      continue;
    }
    next += inner + 1;
  }
}

/* "-o, --output DIR" */
static void write_head(const option_row *row, FILE *out) {
  if (row->letter)
    fprintf(out, "-%c, ", row->letter);
  fprintf(out, "--%s", row->name);
  if (row->value)
    fprintf(out, " %s", row->value);
  for (size_t i = 0; !row->value && row->words && row->words[i]; i++)
    fprintf(out, "%c%s", i ? '|' : ' ', row->words[i]);
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

/* The text is on lines of its own if the head is long. */
static void print_row(const option_command *c, const option_row *row,
                      const void *defaults) {
  char *text = NULL;
  size_t size, head;
  FILE *out = open_memstream(&text, &size);
  if (!out)
    return;
  write_head(row, out);
  head = (size_t)ftell(out);
  putc('\0', out);
  write_help(c, row, defaults, out);
  if (fclose(out) == 0) {
    printf("  %-*s", TEXT_COLUMN - 2, text);
    if (head + 2 >= TEXT_COLUMN)
      printf("\n%*s", TEXT_COLUMN, "");
    print_wrapped(text + head + 1, TEXT_COLUMN, TEXT_COLUMN);
  }
  free(text);
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
    if ((c->accepts & group->rows[i].only_for) == group->rows[i].only_for)
      print_row(c, &group->rows[i], defaults);
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
