/* What OpenCL drivers need before they are asked, and why some are missing. */
#define _POSIX_C_SOURCE 200809L
#include "tool/drivers.h"

#include "image/regular_file.h"
#include "tool/paths.h"

#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

/* ------------------------------------------------------------------------ */
/* PoCL's folder for compiled kernels                                        */

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
  const char *parent = getenv("TMPDIR");
  struct stat status;
  snprintf(out, size, "%s/hbil-pocl-%ld", parent && *parent ? parent : "/tmp",
           (long)geteuid());
  if (mkdir(out, 0700) != 0 && errno != EEXIST)
    return 0;
  return lstat(out, &status) == 0 && S_ISDIR(status.st_mode) &&
         status.st_uid == geteuid() && (status.st_mode & 077) == 0 &&
         path_is_writable(out) && has_room(out);
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
  *note = NULL;
  used_folder(folder, sizeof folder);
  const int writable = path_is_writable(folder);
  const char *why = writable ? "less than 32 MiB of room" : strerror(errno);
  if (writable && has_room(folder))
    return 0;
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

/* ------------------------------------------------------------------------ */
/* The drivers that OpenCL's loader is told to load                          */

typedef struct check {
  driver_failure tell;
  void *user;
} check;

/* The loader may use the library, so it is never closed. */
static void check_library(const check *c, const char *file,
                          const char *library) {
  if (!dlopen(library, RTLD_LAZY | RTLD_LOCAL)) {
    const char *why = dlerror();
    c->tell(c->user, file, why ? why : library);
  }
}

/* The first line of an .icd file is the name of the driver's library. */
static void check_file(const check *c, const char *path) {
  char library[4096];
  const char *why = NULL;
  FILE *file = regular_file_stream(path, &why);
  const char *line = file ? fgets(library, sizeof library, file) : NULL;
  if (file)
    fclose(file);
  size_t length = line ? strlen(line) : 0;
  while (length && strchr(" \t\r\n", library[length - 1]))
    library[--length] = '\0';
  if (length)
    check_library(c, path, library);
  else
    c->tell(c->user, path, why ? why : "it names no library");
}

static int ends_with_icd(const char *name) {
  const size_t length = strlen(name);
  return length >= 4 && strcmp(name + length - 4, ".icd") == 0;
}

static int is_icd(const struct dirent *entry) {
  return ends_with_icd(entry->d_name);
}

static void check_folder(const check *c, const char *folder) {
  struct dirent **entries = NULL;
  const int count = scandir(folder, &entries, is_icd, alphasort);
  for (int i = 0; i < count; i++) {
    char *path = path_join(folder, "/", entries[i]->d_name);
    if (path)
      check_file(c, path);
    free(path);
    free(entries[i]);
  }
  free(entries);
}

static const char *not_empty(const char *variable, const char *otherwise) {
  const char *value = getenv(variable);
  return value && *value ? value : otherwise;
}

/* The variables are those of ocl-icd: OCL_ICD_VENDORS is a folder, an .icd file
 * there or elsewhere, or a library. */
void drivers_check(driver_failure tell, void *user) {
  const check c = {tell, user};
  const char *folder = not_empty("OPENCL_VENDOR_PATH", "/etc/OpenCL/vendors");
  const char *chosen = not_empty("OCL_ICD_VENDORS", folder);
  struct stat status;
  if (stat(chosen, &status) == 0 && S_ISDIR(status.st_mode)) {
    check_folder(&c, chosen);
  } else if (ends_with_icd(chosen)) {
    char *path = strchr(chosen, '/') ? NULL : path_join(folder, "/", chosen);
    check_file(&c, path && access(path, F_OK) == 0 ? path : chosen);
    free(path);
  } else if (chosen != folder) {
    check_library(&c, chosen, chosen);
  }
}
