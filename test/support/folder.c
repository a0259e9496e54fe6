#define _XOPEN_SOURCE 700 /* mkdtemp, nftw */
#include "test/support/folder.h"

#include "test/support/device.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *wanted;
static int found;

static int count_file(const char *path, const struct stat *what, int type,
                      struct FTW *where) {
  const size_t length = strlen(path), least = strlen(wanted);
  (void)what;
  (void)where;
  found += type == FTW_F && length >= least &&
           strcmp(path + length - least, wanted) == 0;
  return 0;
}

static int remove_entry(const char *path, const struct stat *what, int type,
                        struct FTW *where) {
  (void)what;
  (void)type;
  (void)where;
  return remove(path);
}

void folder_make(char path[MOST_PATH]) {
  const char *parent = getenv("TMPDIR");
  snprintf(path, MOST_PATH, "%s/hbil-test-XXXXXX", parent ? parent : "/tmp");
  if (!mkdtemp(path))
    hard_error("no folder");
}

void folder_remove(const char *path) {
  nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
}

int folder_count(const char *path, const char *ending) {
  wanted = ending;
  found = 0;
  if (nftw(path, count_file, 16, FTW_PHYS))
    hard_error("the folder cannot be read");
  return found;
}
