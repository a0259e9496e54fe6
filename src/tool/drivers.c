/* The drivers that OpenCL's loader is told to load. */
#define _POSIX_C_SOURCE 200809L
#include "tool/drivers.h"

#include "tool/paths.h"

#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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
  FILE *file = fopen(path, "r");
  const char *line = file ? fgets(library, sizeof library, file) : NULL;
  const int why = file ? 0 : errno;
  if (file)
    fclose(file);
  size_t length = line ? strlen(line) : 0;
  while (length && strchr(" \t\r\n", library[length - 1]))
    library[--length] = '\0';
  if (length)
    check_library(c, path, library);
  else
    c->tell(c->user, path, why ? strerror(why) : "it names no library");
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
