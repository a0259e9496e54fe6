/*
 * Names of temporary files: .hbil-MACHINE-NUMBER.tmp.  They don't contain the
 * file's own name, which may be as long as names can be.
 */
#ifndef HBIL_IMAGE_TEMPORARY_NAME_H
#define HBIL_IMAGE_TEMPORARY_NAME_H

#ifdef __cplusplus
extern "C" {
#endif

/* Room for a name beside `path`, malloc'd; NULL if memory runs out. */
char *temporary_name_new(const char *path);

/* Draws a number, so that `name` is hardly that of any other file. */
void temporary_name_draw(char *name);

/* Whether a file in a folder is called so. */
int temporary_name_is(const char *name);

/* Whether the file was created on this machine since its last boot (without a
 * boot id: on a host of this name). Containers count as the machine that they
 * run on, since they share its locks. */
int temporary_name_is_local(const char *name);

#ifdef __cplusplus
}
#endif

#endif
