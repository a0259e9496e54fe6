#define _DEFAULT_SOURCE 1 /* flock() */
#include "image/temporary.h"
#include "image/rename_new.h"
#include "image/temporary_name.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* How often a name is drawn. */
enum { MOST_TRIES = 100 };

/* Locks the file.  A job that sweeps may have found it before it was locked,
 * and then holds the lock and removes it.  Returns whether the file still has
 * its name.  Where locks don't work, temporary_sweep() goes by age. */
static int lock(int fd) {
  struct stat status;
  while (flock(fd, LOCK_EX) != 0 && errno == EINTR)
    ;
  return fstat(fd, &status) == 0 && status.st_nlink > 0;
}

int temporary_open(const char *path, temporary *out, image_error *error) {
  int tries = 0;
  out->fd = -1;
  out->name = temporary_name_new(path);
  if (!out->name)
    return image_no_memory(error, path);
  do {
    temporary_name_draw(out->name);
    /* O_EXCL: not even a symbolic link may have the name */
    out->fd = open(out->name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (out->fd >= 0 && lock(out->fd))
      return 0;
    if (out->fd >= 0) {
      close(out->fd);
      errno = EEXIST;
    }
  } while (errno == EEXIST && ++tries < MOST_TRIES);
  image_fail(error, "%s: cannot be written: %s", path, strerror(errno));
  free(out->name);
  return -1;
}

FILE *temporary_stream(const temporary *t) {
  const int copy = fcntl(t->fd, F_DUPFD_CLOEXEC, 0);
  FILE *file = copy < 0 ? NULL : fdopen(copy, "wb");
  const int why = errno;
  if (copy >= 0 && !file)
    close(copy);
  errno = why;
  return file;
}

/* The lock ends after the temporary name does, so no job sweeps it. */
static void close_all(temporary *t) {
  close(t->fd);
  free(t->name);
  t->name = NULL;
  t->fd = -1;
}

void temporary_discard(temporary *t) {
  unlink(t->name);
  close_all(t);
}

int temporary_commit(temporary *t, const char *path, existing_file existing,
                     image_error *error) {
  const int failed = existing == EXISTING_STAYS ? rename_new(t->name, path)
                                                : rename(t->name, path);
  if (failed) {
    if (existing == EXISTING_STAYS && errno == EEXIST)
      image_fail(
          error,
          "%s: is there already: another job has written it meanwhile, "
          "and it is left alone; another name or output folder is needed",
          path);
    else
      image_fail(error, "%s: cannot be written: %s", path, strerror(errno));
    temporary_discard(t);
    return -1;
  }
  close_all(t);
  return 0;
}

int temporary_write(const char *path, existing_file existing,
                    file_writer *write, const void *content,
                    image_error *error) {
  temporary t;
  if (temporary_open(path, &t, error) != 0)
    return -1;
  FILE *out = temporary_stream(&t);
  int failed = out == NULL;
  if (out) {
    write(content, out);
    failed = fflush(out) != 0 || ferror(out) != 0;
    const int why = errno;
    if (fclose(out) != 0)
      failed = 1;
    else
      errno = why;
  }
  if (!failed)
    return temporary_commit(&t, path, existing, error);
  image_fail(error, "%s: cannot be written: %s", path, strerror(errno));
  temporary_discard(&t);
  return -1;
}
