/* Which file a path leads to, whether that file exists or not. */
#ifndef HBIL_TOOL_FILE_PLACE_H
#define HBIL_TOOL_FILE_PLACE_H

#include <sys/types.h>

typedef struct file_place {
  dev_t disk; /* with inode: the file, or the nearest folder that exists */
  ino_t inode;
  char *rest; /* the way from that folder; "" if the file exists; owned */
} file_place;

/* Follows links, also one to a file that doesn't exist.  Two paths have the
 * same place if a file written to one of them is found at the other.  0, or -1
 * if memory runs out; file_place_free() frees the place in both cases. */
int file_place_find(const char *path, file_place *out);
void file_place_free(file_place *place);

/* An order of places: negative, 0 for the same place, or positive. */
int file_place_compare(const file_place *a, const file_place *b);

#endif
