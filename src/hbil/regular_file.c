/* Opens regular files and nothing else. */
#define _POSIX_C_SOURCE 200809L
#include "regular_file.h"

#include <fcntl.h>
#include <stdint.h>
#include <sys/stat.h>
#include <unistd.h>

FILE *open_regular_file(const char *path, size_t *size) {
  struct stat status;
  /* O_NONBLOCK: a FIFO is opened at once; it changes nothing for files */
  const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
  const int usable = fd >= 0 && fstat(fd, &status) == 0 &&
                     S_ISREG(status.st_mode) &&
                     (uintmax_t)status.st_size < SIZE_MAX;
  FILE *file = usable ? fdopen(fd, "rb") : NULL;
  if (file)
    *size = (size_t)status.st_size;
  else if (fd >= 0)
    close(fd);
  return file;
}
