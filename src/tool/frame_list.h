/* Which files a sequence has. */
#ifndef HBIL_TOOL_FRAME_LIST_H
#define HBIL_TOOL_FRAME_LIST_H

#include "image/error.h"

#include <stddef.h>

typedef struct frame_list {
  char **files; /* owned */
  size_t count;
  unsigned
      pre_roll; /* how many of the first ones come before those asked for */
} frame_list;

/*
 * Makes the list from arguments that are files, patterns, which have %d, %04d
 * or #### in their names, or folders, which stand for the pattern of what they
 * hold (frame_folder.h).  ranges: the numbers for the patterns, such as
 * "1-240x2,300", or NULL for all that exist, which must be equally spaced.
 * pre_roll: up to so many existing frames before the first number come first.
 * Returns 0, or -1 with `error` filled; missing frames are named.
 */
int frame_list_make(char *const *arguments, int count, const char *ranges,
                    unsigned pre_roll, frame_list *out, image_error *error);

/* Adds a file, all files of a pattern, whatever their numbers, or all that a
 * shell's wildcards match.  0, or -1 with `error` filled. */
int frame_list_add(const char *argument, frame_list *list, image_error *error);

void frame_list_free(frame_list *list);

#endif
