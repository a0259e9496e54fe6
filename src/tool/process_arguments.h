/* The command line of `hbil process`. */
#ifndef HBIL_TOOL_PROCESS_ARGUMENTS_H
#define HBIL_TOOL_PROCESS_ARGUMENTS_H

#include "image/error.h"
#include "tool/frame_list.h"
#include "tool/settings.h"

typedef struct process_arguments {
  process_settings settings;
  hbil_quality quality; /* the last one that was given, if any was */
  hbil_model_name model;
  const char *frames; /* the numbers for patterns (frame_list.h), or NULL */
  char *const *files; /* the arguments behind the options */
  int count;
  frame_list views;       /* settings.views, owned */
  frame_list light_views; /* likewise */
} process_arguments;

/* Reads the command line and checks that its options fit together.  Returns 0,
 * 1 if help is wanted, or -1 with `error` filled; process_arguments_free()
 * frees what it allocated in all cases. */
int process_arguments_read(int argc, char **argv, process_arguments *out,
                           image_error *error);
void process_arguments_free(process_arguments *a);

/* Prints the help. */
void process_help(void);

#endif
