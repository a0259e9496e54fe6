#define _GNU_SOURCE 1 /* renameat2() */
#include "image/rename_new.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

/* Whether the file system or the kernel can't do what was asked for. */
static int is_impossible(int why) {
  return why == ENOSYS || why == EINVAL || why == EPERM || why == ENOTSUP ||
         why == EOPNOTSUPP || why == EMLINK;
}

/* A second name, and then only that one.  Where the answer of a file server got
 * lost, the link is there although the call has failed. */
static int move_by_link(const char *from, const char *to) {
  struct stat status;
  if (link(from, to) != 0) {
    const int why = errno;
    if (why != EEXIST || stat(from, &status) != 0 || status.st_nlink != 2) {
      errno = why;
      return -1;
    }
  }
  unlink(from);
  return 0;
}

/* An empty file claims the name, and is replaced.  A process that is killed in
 * between leaves it. */
static int move_to_claim(const char *from, const char *to) {
  const int fd = open(to, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0)
    return -1;
  close(fd);
  if (rename(from, to) == 0)
    return 0;
  const int why = errno;
  unlink(to);
  errno = why;
  return -1;
}

int rename_new(const char *from, const char *to) {
#ifdef HBIL_HAS_RENAMEAT2
  if (renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0)
    return 0;
  if (!is_impossible(errno))
    return -1;
#endif
  if (move_by_link(from, to) == 0)
    return 0;
  return is_impossible(errno) ? move_to_claim(from, to) : -1;
}
