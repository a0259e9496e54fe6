/* Gives a file another name, unless a file has that name already. */
#ifndef HBIL_IMAGE_RENAME_NEW_H
#define HBIL_IMAGE_RENAME_NEW_H

#ifdef __cplusplus
extern "C" {
#endif

/* 0, or -1 with errno set: EEXIST if there is such a file.  Of several
 * processes that want one name, exactly one gets it, on every file system. */
int rename_new(const char *from, const char *to);

#ifdef __cplusplus
}
#endif

#endif
