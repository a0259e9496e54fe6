/* A folder in place of its frames. */
#ifndef HBIL_TOOL_FRAME_FOLDER_H
#define HBIL_TOOL_FRAME_FOLDER_H

#include "image/error.h"

/* Whether there is such a folder. */
int frame_folder_exists(const char *path);

/* The pattern of the one sequence of EXR files in a folder, such as
 * FOLDER/shot.####.exr, or its only EXR file.  Hidden files don't count.
 * malloc'd; NULL with `error` filled if there are none, or several sequences.
 */
char *frame_folder_pattern(const char *folder, image_error *error);

#endif
