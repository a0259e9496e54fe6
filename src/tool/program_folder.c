/* A folder of built programs that belongs to the user. */
#define _POSIX_C_SOURCE 200809L
#include "tool/program_folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* The programs of a job take half a MiB with Intel's runtime for CPUs, and of a
 * job with a radiance cache one. */
static const off_t most_bytes = (off_t)256 << 20;

struct program_folder {
  int descriptor;
  int has_stored;
};

program_folder *program_folder_open(const char *path) {
  struct stat status;
  mkdir(path, 0700);
  const int descriptor = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  program_folder *folder = NULL;
  if (descriptor >= 0 && fstat(descriptor, &status) == 0 &&
      status.st_uid == geteuid() && !(status.st_mode & (S_IWGRP | S_IWOTH)))
    folder = calloc(1, sizeof *folder);
  if (folder)
    folder->descriptor = descriptor;
  else if (descriptor >= 0)
    close(descriptor);
  return folder;
}

/* --- loading --- */

static int read_all(int file, char *data, size_t size) {
  while (size) {
    const ssize_t part = read(file, data, size);
    if (part == 0 || (part < 0 && errno != EINTR))
      return 0;
    data += part < 0 ? 0 : part;
    size -= part < 0 ? 0 : (size_t)part;
  }
  return 1;
}

/* The time of a file is that of its last use.  A FIFO must not block. */
size_t program_folder_load(void *user, const char *key, void *data,
                           size_t size) {
  const program_folder *folder = user;
  char name[64];
  struct stat status;
  size_t stored = 0;
  snprintf(name, sizeof name, "%s.bin", key);
  const int file = openat(folder->descriptor, name,
                          O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0)
    return 0;
  if (fstat(file, &status) == 0 && S_ISREG(status.st_mode) &&
      status.st_size <= most_bytes && read_all(file, data, size))
    stored = (size_t)status.st_size;
  if (size && stored)
    futimens(file, NULL);
  close(file);
  return stored;
}

/* --- storing --- */

static int write_all(int file, const char *data, size_t size) {
  while (size) {
    const ssize_t part = write(file, data, size);
    if (part < 0 && errno != EINTR)
      return 0;
    data += part < 0 ? 0 : part;
    size -= part < 0 ? 0 : (size_t)part;
  }
  return 1;
}

void program_folder_store(void *user, const char *key, const void *data,
                          size_t size) {
  program_folder *folder = user;
  char name[64], temporary[128];
  struct timespec now = {0, 0};
  clock_gettime(CLOCK_REALTIME, &now);
  snprintf(name, sizeof name, "%s.bin", key);
  /* a name that no other process and no earlier run has taken */
  snprintf(temporary, sizeof temporary, "%s.%ld-%ld%09ld.tmp", key,
           (long)getpid(), (long)now.tv_sec, now.tv_nsec);
  const int file = openat(folder->descriptor, temporary,
                          O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0)
    return;
  const int written = write_all(file, data, size);
  if (close(file) == 0 && written &&
      renameat(folder->descriptor, temporary, folder->descriptor, name) == 0)
    folder->has_stored = 1;
  else
    unlinkat(folder->descriptor, temporary, 0);
}

/* --- the limit --- */

typedef struct stored_file {
  char *name;
  struct timespec used;
  off_t bytes;
} stored_file;

typedef struct stored_files {
  stored_file *list;
  size_t count;
} stored_files;

static int ends_with(const char *text, const char *end) {
  const size_t length = strlen(text), other = strlen(end);
  return length >= other && strcmp(text + length - other, end) == 0;
}

/* Whether a name is KEY.bin or KEY.*.tmp.  A key ends with a hash of sixteen
 * digits, so that no file is taken for a program that isn't one. */
static int is_program(const char *name) {
  const size_t key = strcspn(name, "."), digits = 16;
  return key > digits && name[key - digits - 1] == '-' &&
         strspn(name + key - digits, "0123456789abcdef") == digits &&
         (strcmp(name + key, ".bin") == 0 || ends_with(name + key, ".tmp"));
}

static void add_file(const program_folder *folder, const char *name,
                     stored_files *all) {
  struct stat status;
  if (!is_program(name) ||
      fstatat(folder->descriptor, name, &status, AT_SYMLINK_NOFOLLOW) != 0 ||
      !S_ISREG(status.st_mode))
    return;
  stored_file *list = realloc(all->list, (all->count + 1) * sizeof *list);
  if (!list)
    return;
  all->list = list;
  list[all->count] =
      (stored_file){strdup(name), status.st_mtim, status.st_size};
  all->count += list[all->count].name != NULL;
}

static int latest_first(const void *a, const void *b) {
  const struct timespec *x = &((const stored_file *)a)->used;
  const struct timespec *y = &((const stored_file *)b)->used;
  if (x->tv_sec != y->tv_sec)
    return x->tv_sec > y->tv_sec ? -1 : 1;
  return x->tv_nsec == y->tv_nsec ? 0 : x->tv_nsec > y->tv_nsec ? -1 : 1;
}

static void delete_old_programs(const program_folder *folder) {
  stored_files all = {NULL, 0};
  off_t bytes = 0;
  const int descriptor =
      openat(folder->descriptor, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR *entries = descriptor >= 0 ? fdopendir(descriptor) : NULL;
  if (!entries) {
    if (descriptor >= 0)
      close(descriptor);
    return;
  }
  for (const struct dirent *e = readdir(entries); e; e = readdir(entries))
    add_file(folder, e->d_name, &all);
  closedir(entries);
  if (all.count)
    qsort(all.list, all.count, sizeof *all.list, latest_first);
  for (size_t i = 0; i < all.count; i++) {
    bytes += all.list[i].bytes;
    if (bytes > most_bytes)
      unlinkat(folder->descriptor, all.list[i].name, 0);
    free(all.list[i].name);
  }
  free(all.list);
}

void program_folder_close(program_folder *folder) {
  if (!folder)
    return;
  if (folder->has_stored)
    delete_old_programs(folder);
  close(folder->descriptor);
  free(folder);
}
