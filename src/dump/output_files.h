/* Renderers that write each pass to a file of its own, whose name has the
 * pass's name in it: DEPTH.exr, room_DEPTH_0001.exr, image-depth.exr. */
#ifndef HBIL_DUMP_OUTPUT_FILES_H
#define HBIL_DUMP_OUTPUT_FILES_H

#include "dump/channel_map.h"
#include "image/error.h"
#include "image/image.h"

/* The source whose depth `path` is by its name and that of files beside it, or
 * DUMP_PLAIN. */
dump_kind output_files_recognise(const char *path);

/* 0, or -1 with `error` filled if the file is another pass than depth of such a
 * source; the frame's name is then that of the depth. */
int output_files_check(const char *path, image_error *error);

/* Takes the first pass of each role that has a file beside the frame.  Returns
 * 0, or -1 with `error` filled if such a file cannot be used. */
int output_files_take(const char *path, const image *header,
                      const pass_name *passes, channel_map *out,
                      image_error *error);

#endif
