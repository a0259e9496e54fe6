/* hbil devices: what --device can choose from. */
#include "image/error.h"
#include "tool/commands.h"
#include "tool/device.h"
#include "tool/drivers.h"
#include "tool/options.h"
#include "tool/report.h"

#include <stdio.h>

static const option_group none = {.count = 0};
static const option_command command = {
    .usage = "usage: hbil devices\n\nLists the OpenCL devices: index, name, "
             "kind.  --device of the other commands takes the index or a part "
             "of the name.",
    .groups = &none,
    .group_count = 1};

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
  options_given given;
  const int read = options_read(&command, argc, argv, NULL, &given, &error);
  if (read > 0)
    options_help(&command, NULL);
  return read < 0 ? report_error(&error) : read > 0 ? STATUS_OK : list();
}
