/* hbil process: computes the light of a sequence. */
#include "image/error.h"
#include "tool/commands.h"
#include "tool/frame_list.h"
#include "tool/process.h"
#include "tool/process_arguments.h"
#include "tool/process_help.h"
#include "tool/report.h"

int cmd_process(int argc, char **argv) {
  process_arguments a;
  frame_list list;
  image_error error;
  const int read = process_arguments_read(argc, argv, &a, &error);
  if (read > 0) {
    process_help();
    return STATUS_OK;
  }
  if (read < 0 ||
      frame_list_make(a.files, a.count, a.frames, &list, &error) != 0)
    return report_error(&error);
  const int failed =
      process_run(&a.settings, list.files, (int)list.count, &error);
  frame_list_free(&list);
  return failed ? report_error(&error) : STATUS_OK;
}
