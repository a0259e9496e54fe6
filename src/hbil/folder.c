/* A folder of stored programs: a file for each key. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "context.h"
#include "regular_file.h"

/* FOLDER/KEY and an ending, malloc'd; NULL without memory. */
static char *path_of(const hbil_context *context, const char *key,
                     const char *ending) {
  const char *folder = context->programs.folder;
  const size_t size = strlen(folder) + strlen(key) + strlen(ending) + 2;
  char *path = malloc(size);
  if (path)
    snprintf(path, size, "%s/%s%s", folder, key, ending);
  return path;
}

static size_t load_file(void *user, const char *key, void *data, size_t room) {
  char *path = path_of(user, key, ".bin");
  size_t size = 0;
  FILE *file = path ? open_regular_file(path, &size) : NULL;
  free(path);
  if (!file)
    return 0;
  if (room && fread(data, 1, room, file) != room)
    size = 0;
  fclose(file);
  return size;
}

/* Opens a file that nobody else has, beside `path`.  The name in `temporary`
 * has a number that hardly repeats; "x" makes sure. */
static FILE *open_temporary(const hbil_context *context, const char *key,
                            char **temporary) {
  char ending[24];
  snprintf(ending, sizeof ending, ".%08lx.tmp",
           ((unsigned long)time(NULL) * 1000003u + (unsigned long)clock() +
            (unsigned long)(size_t)temporary) &
               0xffffffffu);
  *temporary = path_of(context, key, ending);
  return *temporary ? fopen(*temporary, "wbx") : NULL;
}

/* Other processes see the whole file or none. */
static void store_file(void *user, const char *key, const void *data,
                       size_t size) {
  hbil_context *context = user;
  char *temporary = NULL, *path = path_of(context, key, ".bin");
  FILE *file = path ? open_temporary(context, key, &temporary) : NULL;
  const int why = file ? 0 : errno;
  bool stored = false;
  if (file) {
    stored = fwrite(data, 1, size, file) == size;
    stored = !fclose(file) && stored;
    /* an empty folder of that name is in the way */
    stored = stored &&
             (!rename(temporary, path) ||
              (errno == EISDIR && !remove(path) && !rename(temporary, path)));
    if (!stored)
      remove(temporary);
  }
  /* the others have the same reason, mostly */
  if (!stored && !context->programs.warned)
    warn(context,
         "%s and perhaps other programs cannot be stored in %s: %s; it must be "
         "a folder that exists, with room, where this process may write",
         key, context->programs.folder, why ? strerror(why) : "write error");
  context->programs.warned |= !stored;
  free(temporary);
  free(path);
}

hbil_status hbil_context_set_program_folder(hbil_context *context,
                                            const char *folder) {
  if (!context || !folder)
    return fail_null(context, __func__, context ? "folder" : "context");
  if (!*folder)
    return fail(context, HBIL_INVALID_ARGUMENT,
                "%s: folder: empty; must be the name of a folder", __func__);
  const size_t size = strlen(folder) + 1;
  char *copy = malloc(size);
  if (!copy)
    return fail(context, HBIL_OUT_OF_HOST_MEMORY, "no memory for a name");
  memcpy(copy, folder, size);
  const hbil_status status =
      hbil_context_set_program_store(context, load_file, store_file, context);
  if (status == HBIL_SUCCESS) {
    context->programs.folder = copy;
    context->programs.warned = false;
  } else {
    free(copy);
  }
  return status;
}
