/* The names of all files that hbil demo writes. */
#ifndef HBIL_TOOL_DEMO_FILES_H
#define HBIL_TOOL_DEMO_FILES_H

#include "image/error.h"

typedef struct demo_files {
  const char *output; /* folder of the results */
  char *folder;       /* of the G-buffers */
  char **frames;
  unsigned frame_count;
  char **views;
  unsigned view_count;
  char *light_view; /* NULL: there is none */
  char *sky;        /* likewise */
} demo_files;

/* What a demo has. */
typedef struct demo_content {
  unsigned frames, views;
  int light_view, sky;
} demo_content;

/* Names the files.  0, or -1 with `error` filled; demo_files_free() frees the
 * names in both cases. */
int demo_files_name(const char *output, const demo_content *content,
                    demo_files *out, image_error *error);
void demo_files_free(demo_files *files);

/* Checks that whatever of them exists was written by an earlier demo into the
 * same folder.  0, or -1 with `error` filled. */
int demo_files_check(const demo_files *files, image_error *error);

#endif
