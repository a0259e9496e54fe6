/* PoCL's folder for compiled kernels. */
#define _POSIX_C_SOURCE 200809L
#include "tool/driver_cache.h"

#include "tool/paths.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

/* Bytes.  A job's kernels take 3 MiB, and the compiler's files as much again.
 */
static const unsigned long long least_room = 32ull << 20;

enum { MOST_FOLDER = 4096 };

/* As PoCL chooses it. */
static void used_folder(char *out, unsigned size) {
  const char *own = getenv("POCL_CACHE_DIR"), *xdg = getenv("XDG_CACHE_HOME");
  const char *home = getenv("HOME");
  if (own)
    snprintf(out, size, "%s", own);
  else if (xdg && *xdg)
    snprintf(out, size, "%s/pocl/kcache", xdg);
  else if (home)
    snprintf(out, size, "%s/.cache/pocl/kcache", home);
  else
    snprintf(out, size, "/tmp/pocl/kcache");
}

/* Whether files can be written in a folder, which need not exist; if not,
 * *why says why. */
static int can_write(const char *folder, const char **why) {
  struct stat status;
  char *there = path_existing(folder);
  int usable = there && stat(there, &status) == 0;
  if (usable && !S_ISDIR(status.st_mode)) {
    usable = 0;
    errno = ENOTDIR;
  }
  usable = usable && access(there, W_OK | X_OK) == 0;
  *why = usable ? NULL : strerror(errno);
  free(there);
  return usable;
}

/* Whether there is room for compiled kernels, as far as that is known. */
static int has_room(const char *folder) {
  struct statvfs disk;
  char *there = path_existing(folder);
  const int full =
      there && statvfs(there, &disk) == 0 &&
      (unsigned long long)disk.f_bavail * disk.f_frsize < least_room;
  free(there);
  return !full;
}

/* Makes a folder of this user alone, since what is in there is executed. */
static int make_own(char *out, unsigned size) {
  const char *parent = getenv("TMPDIR"), *why;
  struct stat status;
  snprintf(out, size, "%s/hbil-pocl-%ld", parent && *parent ? parent : "/tmp",
           (long)geteuid());
  if (mkdir(out, 0700) != 0 && errno != EEXIST)
    return 0;
  return lstat(out, &status) == 0 && S_ISDIR(status.st_mode) &&
         status.st_uid == geteuid() && (status.st_mode & 077) == 0 &&
         can_write(out, &why) && has_room(out);
}

static char *note_of(const char *folder, const char *why, const char *own) {
  static const char format[] =
      "PoCL's folder for compiled kernels, %s, can't be used (%s); they go to "
      "%s";
  const size_t size =
      sizeof format + strlen(folder) + strlen(why) + strlen(own);
  char *note = malloc(size);
  if (note)
    snprintf(note, size, format, folder, why, own);
  return note;
}

int driver_cache_prepare(char **note, image_error *error) {
  char folder[MOST_FOLDER], own[MOST_FOLDER];
  const char *why;
  *note = NULL;
  used_folder(folder, sizeof folder);
  const int writable = can_write(folder, &why);
  if (writable && has_room(folder))
    return 0;
  if (writable)
    why = "less than 32 MiB of room";
  if (make_own(own, sizeof own) && setenv("POCL_CACHE_DIR", own, 1) == 0) {
    *note = note_of(folder, why, own);
    return 0;
  }
  /* it may have all kernels already */
  if (writable)
    return 0;
  return image_fail(error,
                    "%s: PoCL's folder for compiled kernels cannot be written: "
                    "%s; POCL_CACHE_DIR must name one in which you may write",
                    folder, why);
}
