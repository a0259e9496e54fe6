/* Files of results: folders, names, and sections of a Markdown file. */
#ifndef HBIL_BENCH_FILES_H
#define HBIL_BENCH_FILES_H

#include "image/temporary.h"

/* Makes a folder that need not exist, and checks that files can be made in it.
 */
int bench_folder_make(const char *path, image_error *error);
/* DIR/NAME.SUFFIX; malloc'd, NULL when out of memory. */
char *bench_result_path(const char *folder, const char *name,
                        const char *suffix);

/* Whether the file has the lines <!-- hbil-bench NAME --> and, behind it,
 * <!-- end -->. */
int bench_section_check(const char *path, const char *name, image_error *error);
/* Replaces what stands between those two lines. */
int bench_section_replace(const char *path, const char *name,
                          file_writer *write, const void *context,
                          image_error *error);

#endif
