/* Stores built programs between runs where the driver doesn't. */
#define _POSIX_C_SOURCE 200809L
#include "tool/program_folder.h"

#include "image/temporary.h"
#include "image/temporary_sweep.h"
#include "tool/device.h"
#include "tool/paths.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ------------------------------------------------------------------------ */
/* A folder of programs                                                      */

/* The programs of a job take half a MiB with Intel's runtime for CPUs, and of a
 * job with a radiance cache one. */
static const off_t most_bytes = (off_t)256 << 20;

struct program_folder {
  int descriptor; /* of the folder that was checked */
  char *path;
  int has_stored;
};

/* Takes over the malloc'd path.  Makes the folder if its parent exists.
 * Programs are executed, so the folder must belong to the user, and nobody else
 * may have the right to write there. */
static program_folder *open_folder(char *path) {
  struct stat status;
  mkdir(path, 0700);
  const int descriptor = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  program_folder *folder = NULL;
  if (descriptor >= 0 && fstat(descriptor, &status) == 0 &&
      status.st_uid == geteuid() && !(status.st_mode & (S_IWGRP | S_IWOTH)))
    folder = calloc(1, sizeof *folder);
  if (folder) {
    *folder = (program_folder){.descriptor = descriptor, .path = path};
    return folder;
  }
  if (descriptor >= 0)
    close(descriptor);
  free(path);
  return NULL;
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
static size_t load(void *user, const char *key, void *data, size_t size) {
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

/* Of a program, only its user reads anything. */
static int write_program(const temporary *t, const void *data, size_t size) {
  FILE *out = fchmod(t->fd, 0600) == 0 ? temporary_stream(t) : NULL;
  const int written = out && fwrite(data, 1, size, out) == size;
  return out && fclose(out) == 0 && written;
}

static void store(void *user, const char *key, const void *data, size_t size) {
  program_folder *folder = user;
  char name[64];
  temporary t;
  snprintf(name, sizeof name, "/%s.bin", key);
  char *path = path_join(folder->path, name, "");
  if (path && temporary_open(path, &t, NULL) == 0) {
    if (!write_program(&t, data, size))
      temporary_discard(&t);
    else if (temporary_commit(&t, path, EXISTING_REPLACED, NULL) == 0)
      folder->has_stored = 1;
  }
  free(path);
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

/* Whether a name is KEY.bin.  A key ends with a hash of sixteen digits, so that
 * no file is taken for a program that isn't one. */
static int is_program(const char *name) {
  const size_t key = strcspn(name, "."), digits = 16;
  return key > digits && name[key - digits - 1] == '-' &&
         strspn(name + key - digits, "0123456789abcdef") == digits &&
         strcmp(name + key, ".bin") == 0;
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
  if (folder->has_stored) {
    temporary_sweep(folder->path);
    delete_old_programs(folder);
  }
  close(folder->descriptor);
  free(folder->path);
  free(folder);
}

/* ------------------------------------------------------------------------ */
/* Which folder                                                              */

/* Platforms for which nothing is stored.  All others have programs stored: if
 * such a driver has a cache of its own, that costs disk space only. */
static const char *const excluded[] = {
    "Portable Computing Language", /* ~/.cache/pocl, POCL_CACHE_DIR */
    "NVIDIA CUDA",                 /* ~/.nv/ComputeCache, CUDA_CACHE_PATH */
    "rusticl", /* Mesa: ~/.cache/mesa_shader_cache, MESA_SHADER_CACHE_DIR */
    /* A simulator: its own command line has build options, which the key of a
     * program doesn't have. */
    "Oclgrind",
};

static int is_excluded(const char *platform) {
  for (size_t i = 0; i < sizeof excluded / sizeof *excluded; i++)
    if (strcmp(platform, excluded[i]) == 0)
      return 1;
  return 0;
}

/* An absolute path, as the XDG base directory specification demands. */
static const char *folder_of(const char *variable) {
  const char *folder = getenv(variable);
  return folder && folder[0] == '/' ? folder : NULL;
}

/* The user's folder of caches, made if its parent exists. */
static char *user_caches(void) {
  const char *own = folder_of("XDG_CACHE_HOME"), *home = folder_of("HOME");
  char *folder = own    ? path_join(own, "", "")
                 : home ? path_join(home, "/", ".cache")
                        : NULL;
  if (folder)
    mkdir(folder, 0700);
  return folder;
}

/* malloc'd; NULL: none. */
static char *path_of(const char *platform) {
  const char *chosen = getenv("HBIL_PROGRAM_DIR");
  if (chosen)
    return *chosen ? path_join(chosen, "", "") : NULL;
  char *caches = is_excluded(platform) ? NULL : user_caches();
  char *path = caches ? path_join(caches, "/", "hbil") : NULL;
  free(caches);
  return path;
}

program_folder *program_folder_of_device(hbil_context *context,
                                         cl_device_id id) {
  char name[256];
  device_platform(id, name);
  char *path = path_of(name);
  program_folder *folder = path ? open_folder(path) : NULL;
  if (folder && hbil_context_set_program_store(context, load, store, folder) !=
                    HBIL_SUCCESS) {
    program_folder_close(folder);
    folder = NULL;
  }
  return folder;
}
