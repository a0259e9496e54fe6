#define _POSIX_C_SOURCE 200809L
#include "image/regular_file.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int regular_file_open(const char *path, const char **why) {
  struct stat status;
  /* O_NONBLOCK: a FIFO is opened at once; it changes nothing for files */
  const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
  if (fd < 0 || fstat(fd, &status) != 0)
    *why = strerror(errno);
  else if (S_ISDIR(status.st_mode))
    *why = strerror(EISDIR);
  else if (!S_ISREG(status.st_mode))
    *why = "not a regular file";
  else
    return fd;
  if (fd >= 0)
    close(fd);
  return -1;
}

FILE *regular_file_stream(const char *path, const char **why) {
  const int fd = regular_file_open(path, why);
  FILE *file = fd < 0 ? NULL : fdopen(fd, "rb");
  if (fd >= 0 && !file) {
    *why = strerror(errno);
    close(fd);
  }
  return file;
}
