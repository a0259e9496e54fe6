/* hbil process: computes the light of a sequence. */
#include "image/error.h"
#include "tool/commands.h"
#include "tool/frame_list.h"
#include "tool/process.h"
#include "tool/process_arguments.h"
#include "tool/report.h"

int cmd_process(int argc, char **argv) {
  process_arguments a;
  frame_list list = {NULL, 0, 0};
  image_error error;
  int status = STATUS_OK;
  const int read = process_arguments_read(argc, argv, &a, &error);
  if (read > 0)
    process_help();
  else if (read < 0 || frame_list_make(a.files, a.count, a.frames,
                                       a.settings.pre_roll, &list, &error) != 0)
    status = report_error(&error);
  else {
    a.settings.is_part = a.frames != NULL;
    a.settings.pre_roll = list.pre_roll;
    if (process_run(&a.settings, list.files, (int)list.count, &error) != 0)
      status = report_error(&error);
  }
  frame_list_free(&list);
  process_arguments_free(&a);
  return status;
}
