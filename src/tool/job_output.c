/* Checks where a job writes. */
#define _POSIX_C_SOURCE 200809L
#include "tool/job_output.h"

#include "image/error.h"
#include "image/formats.h"
#include "tool/paths.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Whether the results could be written, without leaving a trace. */
static int look_at_folder(const char *folder, image_error *error) {
  char *there = path_existing(folder);
  struct stat status;
  if (!there)
    return image_no_memory(error, folder);
  const int is_own = strcmp(there, folder) == 0;
  int usable = stat(there, &status) == 0 && access(there, W_OK | X_OK) == 0;
  if (usable && !S_ISDIR(status.st_mode)) {
    usable = 0;
    errno = ENOTDIR;
  }
  free(there);
  return usable ? 0
                : image_fail(error,
                             "%s: output folder cannot be %s: %s; a folder in "
                             "which you may write is needed",
                             folder, is_own ? "written" : "created",
                             strerror(errno));
}

/* Writes a file and removes it.  Permissions alone don't show read-only and
 * special file systems. */
static int try_to_write(const char *folder, image_error *error) {
  char name[48];
  snprintf(name, sizeof name, "/.hbil-test%ld", (long)getpid());
  char *path = path_join(folder, "", name);
  if (!path)
    return image_no_memory(error, folder);
  const int fd = open(path, O_WRONLY | O_CREAT | O_EXCL, 0600);
  const int why = errno;
  if (fd >= 0) {
    close(fd);
    unlink(path);
  }
  free(path);
  /* there it is if another machine tries at this moment */
  if (fd >= 0 || why == EEXIST)
    return 0;
  return image_fail(error,
                    "%s: output folder cannot be written: %s; a folder in "
                    "which you may write is needed",
                    folder, strerror(why));
}

static int prepare_folder(job *j, image_error *error) {
  const char *folder = j->settings->output;
  if (j->settings->dry_run)
    return look_at_folder(folder, error);
  if (path_make_folders(folder, &j->folders_made) != 0)
    return image_fail(error,
                      "%s: output folder cannot be created: %s; a folder in "
                      "which you may write is needed",
                      folder, strerror(errno));
  return try_to_write(folder, error);
}

/* Checks the folder of a file that the job writes beside the results; NULL is
 * allowed. */
static int check_parent(const job *j, const char *path, image_error *error) {
  const process_settings *s = j->settings;
  if (!path)
    return 0;
  /* its folder may be the one that a dry run doesn't make */
  if (s->dry_run && access(s->output, F_OK) != 0)
    return 0;
  char *parent = path_parent(path);
  if (!parent)
    return image_no_memory(error, path);
  const int writable = access(parent, W_OK | X_OK) == 0;
  free(parent);
  return writable ? 0
                  : image_fail(error,
                               "%s: cannot be written: %s; a folder in which "
                               "you may write is needed",
                               path, strerror(errno));
}

int job_output_prepare(job *j, image_error *error) {
  const process_settings *s = j->settings;
  if ((s->preview || s->contact_sheet) && formats_check(error) != 0)
    return -1;
  return prepare_folder(j, error) != 0 ||
                 check_parent(j, s->contact_sheet, error) != 0 ||
                 check_parent(j, s->cache_save, error) != 0
             ? -1
             : 0;
}
