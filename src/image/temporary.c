#define _POSIX_C_SOURCE 200809L
#include "image/temporary.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The process id separates two processes that write the same file.  mkstemp()
 * would do that too, but only the id shows whether the file is still being
 * written or was left behind by a process that died. */
char *temporary_name(const char *path, image_error *error) {
  const size_t size = strlen(path) + 32;
  char *name = malloc(size);
  if (!name) {
    image_no_memory(error, path);
    return NULL;
  }
  snprintf(name, size, "%s.tmp%ld", path, (long)getpid());
  return name;
}

void temporary_discard(char *name) {
  if (name)
    unlink(name);
  free(name);
}

int temporary_commit(char *name, const char *path, image_error *error) {
  if (rename(name, path) != 0) {
    image_fail(error, "%s: cannot be written: %s", path, strerror(errno));
    temporary_discard(name);
    return -1;
  }
  free(name);
  return 0;
}
