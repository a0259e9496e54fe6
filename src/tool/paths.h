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

/* Makes a folder and those of its parents that are missing.  *made: how many
 * were.  0, or -1 with errno set. */
int path_make_folders(const char *folder, unsigned *made);

/* Removes a folder and its parents, `made` in all, as far as they are empty. */
void path_remove_folders(const char *folder, unsigned made);

/* Whether files can be written in a folder or, if it doesn't exist, in the
 * nearest of its parents that does; if not, errno says why. */
int path_is_writable(const char *folder);

/* The folder, or the nearest of its parents that exists.  malloc'd; NULL if
 * memory runs out. */
char *path_existing(const char *folder);

#endif
