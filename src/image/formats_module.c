/* Loads the module of other formats. */
#define _POSIX_C_SOURCE 200809L
#include "image/formats_module.h"

#include <dlfcn.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define MODULE "hbil-formats.so"

static pthread_once_t once = PTHREAD_ONCE_INIT;
static const formats_table *table; /* NULL: there is none */
static char why[1024];

/* Takes the module with that path, or with that name where the system looks
 * for libraries.  Returns 1 if it is ours, of our version. */
static int take(const char *path) {
  void *module = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  const formats_table *found = module ? dlsym(module, "hbil_formats") : NULL;
  if (found && strcmp(found->version, HBIL_PACKAGE_VERSION) == 0) {
    table = found;
    return 1;
  }
  const char *message = module ? "it is of another version" : dlerror();
  snprintf(why, sizeof why, "%s", message ? message : path);
  if (module)
    dlclose(module);
  return 0;
}

/* The folder of the running program, without a slash at the end; returns 0 if
 * that isn't known. */
static int own_folder(char *out, size_t size) {
  const ssize_t length = readlink("/proc/self/exe", out, size - 1);
  out[length > 0 ? length : 0] = '\0';
  char *slash = strrchr(out, '/');
  if (!slash)
    return 0;
  *slash = '\0';
  return 1;
}

/* The folder of modules, as seen from an installed program that was moved
 * together with it: both paths begin alike, and the program's ends in the rest
 * of its own.  Returns 0 if the program is elsewhere, as it is in tests. */
static int moved_folder(const char *own, char *out, size_t size) {
  static const char programs[] = HBIL_BINDIR, modules[] = HBIL_MODULE_DIR;
  size_t same = 0;
  for (size_t i = 0; programs[i] && programs[i] == modules[i]; i++)
    if (programs[i] == '/')
      same = i;
  const size_t rest = strlen(programs + same), length = strlen(own);
  if (length < rest || strcmp(own + length - rest, programs + same) != 0)
    return 0;
  return snprintf(out, size, "%.*s%s", (int)(length - rest), own,
                  modules + same) < (int)size;
}

static int take_from(const char *folder) {
  char path[PATH_MAX + sizeof "/" MODULE];
  snprintf(path, sizeof path, "%s/" MODULE, folder);
  return access(path, R_OK) == 0 && take(path);
}

/* In a build tree the module is beside the program, or where libtool's scripts
 * have the system look for libraries. */
static void load(void) {
  char own[PATH_MAX], moved[PATH_MAX];
  const int known = own_folder(own, sizeof own);
  if ((known && take_from(own)) || take(MODULE) ||
      (known && moved_folder(own, moved, sizeof moved) && take_from(moved)))
    return;
  take(HBIL_MODULE_DIR "/" MODULE);
}

const formats_table *formats_module(image_error *error) {
  pthread_once(&once, load);
  if (!table)
    image_fail(error,
               "PNG, TIFF and HDR files need a module that cannot be loaded: "
               "%s; a complete installation of hbil is needed",
               why);
  return table;
}
