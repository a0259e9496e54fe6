#define _DEFAULT_SOURCE 1 /* flock() */
#include "image/temporary_sweep.h"
#include "image/temporary_name.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* Seconds after which nobody writes any more: a file takes seconds. */
enum { LONG_AGO = 3600 };

static int is_old(int fd) {
  struct stat status;
  return fstat(fd, &status) == 0 && time(NULL) - status.st_mtime > LONG_AGO;
}

/* Whether nobody writes the file.  It is locked afterwards, if it can be, so
 * that no job begins with it. */
static int is_left(int fd, const char *name) {
  if (flock(fd, LOCK_EX | LOCK_NB) == 0)
    return temporary_name_is_local(name) || is_old(fd);
  return errno != EWOULDBLOCK && errno != EINTR && is_old(fd);
}

static void sweep_file(int folder, const char *name) {
  struct stat status;
  /* some file systems lock for those alone who may write */
  int fd = openat(folder, name, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0)
    fd = openat(folder, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0)
    return;
  if (fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && is_left(fd, name))
    unlinkat(folder, name, 0);
  close(fd);
}

void temporary_sweep(const char *folder) {
  DIR *entries = opendir(folder);
  if (!entries)
    return;
  for (struct dirent *e; (e = readdir(entries));)
    if (temporary_name_is(e->d_name))
      sweep_file(dirfd(entries), e->d_name);
  closedir(entries);
}
