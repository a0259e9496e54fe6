/* Names of files. */
#ifndef HBIL_TOOL_PATHS_H
#define HBIL_TOOL_PATHS_H

/* Three texts, one behind the other.  malloc'd; NULL if memory runs out. */
char *path_join(const char *a, const char *between, const char *b);

/* FOLDER/NAME for FRAME = .../NAME.exr.  malloc'd; NULL if memory runs out. */
char *path_stem_in(const char *folder, const char *frame);

/* The folder that a path is in, without a slash at its end.  malloc'd; NULL if
 * memory runs out. */
char *path_parent(const char *path);

#endif
