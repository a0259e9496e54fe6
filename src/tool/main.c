/* hbil: one program, a few commands. */
#include "tool/tool.h"

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
    {"bench", cmd_bench, "measure time and error on this machine"},
};

enum { COMMANDS = sizeof commands / sizeof *commands };

/* Bytes from here on that must not reach a terminal: one for C0 and DEL, two
 * for C1 in UTF-8. */
static int control(const unsigned char *c) {
  if (*c < ' ' || *c == 0x7f)
    return 1;
  return c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0 ? 2 : 0;
}

int tool_show(const char *text, FILE *out) {
  int columns = 0;
  for (const unsigned char *c = (const unsigned char *)text; *c; c++)
    if (*c == '\n')
      columns += fprintf(out, "\\n");
    else if (control(c) == 1)
      columns += fprintf(out, "\\x%02x", *c);
    else if (control(c) == 2) {
      columns += fprintf(out, "\\x%02x\\x%02x", c[0], c[1]);
      c++;
    } else
      columns += fputc(*c, out) >= 0;
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
  for (int i = 0; i < COMMANDS; i++)
    if (strcmp(argv[1], commands[i].name) == 0)
      return commands[i].run(argc - 1, argv + 1);
  image_fail(&error, "%s: no such command; hbil --help lists them", argv[1]);
  return tool_report(&error);
}
