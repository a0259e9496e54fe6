/* hbil: one program with a few commands. */
#define _POSIX_C_SOURCE 200809L
#include "hbil/hbil.h"
#include "image/error.h"
#include "tool/commands.h"
#include "tool/last_words.h"
#include "tool/report.h"

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
    {"process", cmd_process, "compute the indirect light of G-buffers"},
    {"info", cmd_info, "tell what is understood of a G-buffer file"},
    {"compare", cmd_compare, "measure the difference of two images"},
    {"devices", cmd_devices, "list the OpenCL devices"},
    {"demo", cmd_demo, "make a small sequence and compute its light"},
};

enum { COMMANDS = sizeof commands / sizeof *commands };

static void usage(void) {
  puts("usage: hbil COMMAND [options] ...\n"
       "\n"
       "Near-field indirect light, ambient occlusion and bent cones from\n"
       "G-buffers, through OpenCL.\n");
  for (int i = 0; i < COMMANDS; i++)
    printf("  %-21s %s\n", commands[i].name, commands[i].about);
  puts("\n"
       "  --help                this text; after a command, that command's "
       "options\n"
       "  --version             the version\n"
       "\n"
       "Exit status: 0 if all was done; 1 if hbil compare found more than\n"
       "--max-rmse; 2 for bad input and whatever else went wrong, after one\n"
       "line on standard error that begins with hbil: and says what.");
}

/* Output that could not be written is an error. */
static int finish(int status) {
  image_error error;
  if (fflush(stdout) == 0 && !ferror(stdout))
    return status;
  image_fail(&error, "standard output cannot be written: %s", strerror(errno));
  return report_error(&error);
}

int main(int argc, char **argv) {
  image_error error;
  if (argc < 2) {
    image_fail(&error, "no command; hbil --help lists them");
    return report_error(&error);
  }
  if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
    usage();
    return STATUS_OK;
  }
  if (strcmp(argv[1], "--version") == 0) {
    printf("hbil %s\n", hbil_version());
    return STATUS_OK;
  }
  /* writing beyond the limit of a file's size is then an error like others */
  signal(SIGXFSZ, SIG_IGN);
  last_words_prepare();
  for (int i = 0; i < COMMANDS; i++)
    if (strcmp(argv[1], commands[i].name) == 0)
      return finish(commands[i].run(argc - 1, argv + 1));
  image_fail(&error, "%s: no such command; hbil --help lists them", argv[1]);
  return report_error(&error);
}
