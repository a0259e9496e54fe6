/* Messages of the programs on standard error. */
#include "tool/report.h"

#include "image/error.h"

/* The number of bytes of the character here, if it is UTF-8 and no control
 * character (C0, C1); otherwise 0. */
static size_t printable(const unsigned char *c) {
  /* the smallest second byte: below it, the form is overlong or a C1 */
  const unsigned least = *c == 0xe0 || *c == 0xc2 ? 0xa0
                         : *c == 0xf0             ? 0x90
                                                  : 0x80;
  const size_t length = *c < 0x80 ? 1 : *c < 0xe0 ? 2 : *c < 0xf0 ? 3 : 4;
  if (*c < ' ' || *c == 0x7f || (*c >= 0x80 && *c < 0xc2) || *c > 0xf4 ||
      (length > 1 && c[1] < least))
    return 0;
  for (size_t i = 1; i < length; i++)
    if ((c[i] & 0xc0) != 0x80)
      return 0;
  return length;
}

int report_text(const char *text, FILE *out) {
  int columns = 0;
  for (const unsigned char *c = (const unsigned char *)text; *c;) {
    const size_t length = printable(c);
    if (length > 0)
      columns += fwrite(c, length, 1, out) == 1;
    else if (*c == '\n')
      columns += fprintf(out, "\\n");
    else
      columns += fprintf(out, "\\x%02x", *c);
    c += length > 0 ? length : 1;
  }
  return columns;
}

int report_error(const image_error *error) {
  fputs("hbil: ", stderr);
  report_text(error->text, stderr);
  fputc('\n', stderr);
  return STATUS_BAD_INPUT;
}

void report_note(const char *path, const char *kind, const char *what) {
  fputs("hbil: ", stderr);
  report_text(path, stderr);
  fprintf(stderr, ": %s%s\n", kind, what);
}
