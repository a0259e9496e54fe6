/* hbil: one program, a few commands. */
#define _POSIX_C_SOURCE 200809L
#include "tool/tool.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

typedef struct command {
  const char *name;
  int (*run)(int argc, char **argv);
  const char *about;
} command;

static const command commands[] = {
    {"process", cmd_process, "light a sequence of G-buffers"},
    {"info", cmd_info, "tell what is understood of a G-buffer file"},
    {"compare", cmd_compare, "measure the difference of two images"},
    {"devices", cmd_devices, "list the OpenCL devices"},
    {"demo", cmd_demo, "make a small sequence and light it"},
};

enum { COMMANDS = sizeof commands / sizeof *commands };

/* Bytes of the character here if it is UTF-8 and can be shown: no control
 * character of C0 or C1.  Otherwise 0. */
static size_t showable(const unsigned char *c) {
  /* least second byte: no longer form than needed, no C1 */
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

int tool_show(const char *text, FILE *out) {
  int columns = 0;
  for (const unsigned char *c = (const unsigned char *)text; *c;) {
    const size_t length = showable(c);
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

int tool_report(const image_error *error) {
  fputs("hbil: ", stderr);
  tool_show(error->text, stderr);
  fputc('\n', stderr);
  return TOOL_BAD_INPUT;
}

static void usage(void) {
  puts("usage: hbil COMMAND [options] ...\n"
       "\n"
       "Near-field indirect light, ambient occlusion and bent cones from\n"
       "G-buffers, through OpenCL.\n");
  for (int i = 0; i < COMMANDS; i++)
    printf("  %-9s %s\n", commands[i].name, commands[i].about);
  puts("\n"
       "  --help    this text; after a command, that command's options\n"
       "  --version the version\n"
       "\n"
       "Exit status: 0 done, 1 a comparison is over its limit, 2 bad input.");
}

/* What was said must have arrived. */
static int finish(int status) {
  image_error error;
  if (fflush(stdout) == 0 && !ferror(stdout))
    return status;
  image_fail(&error, "standard output cannot be written: %s", strerror(errno));
  return tool_report(&error);
}

int main(int argc, char **argv) {
  image_error error;
  if (argc < 2) {
    image_fail(&error, "no command; hbil --help lists them");
    return tool_report(&error);
  }
  if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
    usage();
    return TOOL_OK;
  }
  if (strcmp(argv[1], "--version") == 0) {
    printf("hbil %s\n", hbil_version());
    return TOOL_OK;
  }
  signal(SIGXFSZ, SIG_IGN); /* a file's size has an end: told as any error */
  for (int i = 0; i < COMMANDS; i++)
    if (strcmp(argv[1], commands[i].name) == 0)
      return finish(commands[i].run(argc - 1, argv + 1));
  image_fail(&error, "%s: no such command; hbil --help lists them", argv[1]);
  return tool_report(&error);
}
