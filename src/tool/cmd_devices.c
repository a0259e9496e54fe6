/* hbil devices: what --device can choose from. */
#include "image/error.h"
#include "tool/commands.h"
#include "tool/device.h"
#include "tool/drivers.h"
#include "tool/options.h"
#include "tool/report.h"

#include <getopt.h>
#include <stdio.h>

static const struct option options[] = {
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static void tell(void *user, const char *file, const char *why) {
  (void)user;
  report_note(file, "", why);
}

/* What is not in the list, although its driver is installed, is told, too. */
static int list(void) {
  image_error error;
  if (device_list(&error) != 0)
    return report_error(&error);
  drivers_check(tell, NULL);
  return STATUS_OK;
}

int cmd_devices(int argc, char **argv) {
  image_error error;
  switch (option_next(argc, argv, ":h", options, &error)) {
  case 'h':
    puts("usage: hbil devices\n"
         "\n"
         "Lists the OpenCL devices: index, name, kind.  --device of the other\n"
         "commands takes the index or a part of the name.");
    return STATUS_OK;
  case '?':
    return report_error(&error);
  default:
    return list();
  }
}
