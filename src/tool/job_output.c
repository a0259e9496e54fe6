/* Checks where a job writes. */
#define _POSIX_C_SOURCE 200809L
#include "tool/job_output.h"

#include "image/error.h"
#include "image/formats.h"
#include "image/temporary.h"
#include "image/temporary_sweep.h"
#include "tool/paths.h"

#include <errno.h>
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
  temporary t;
  char *path = path_join(folder, "/", "result");
  if (!path)
    return image_no_memory(error, folder);
  const int failed = temporary_open(path, &t, NULL);
  const int why = errno;
  if (!failed)
    temporary_discard(&t);
  free(path);
  return failed
             ? image_fail(error,
                          "%s: output folder cannot be written: %s; a folder "
                          "in which you may write is needed",
                          folder, strerror(why))
             : 0;
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

/* What killed jobs have left where this one writes. */
static void sweep(const job *j) {
  const process_settings *s = j->settings;
  const char *const files[] = {s->contact_sheet, s->cache_save};
  temporary_sweep(s->output);
  for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
    char *folder = files[i] ? path_parent(files[i]) : NULL;
    if (folder)
      temporary_sweep(folder);
    free(folder);
  }
}

/* File systems have a limit for names, mostly 255 bytes.  What a job adds to a
 * frame's name may lead beyond it. */
static int check_length(const job *j, const char *path, image_error *error) {
  const long limit = pathconf(j->settings->output, _PC_NAME_MAX);
  const size_t length = strlen(strrchr(path, '/') + 1);
  return limit < 0 || length <= (size_t)limit
             ? 0
             : image_fail(error,
                          "%s: cannot be written: its name has %zu bytes; a "
                          "frame's name with which it has at most %ld is "
                          "needed",
                          path, length, limit);
}

/* A frame's files. */
static int check_frame(const job *j, const job_frame *f, image_error *error) {
  char *path = job_result_path(f);
  int failed =
      path ? check_length(j, path, error) : image_no_memory(error, f->path);
  free(path);
  for (int l = 0; l < LAYER_COUNT && j->settings->preview && !failed; l++) {
    if (!(j->layers >> l & 1))
      continue;
    path = job_preview_path(f, (layer)l);
    failed =
        path ? check_length(j, path, error) : image_no_memory(error, f->path);
    free(path);
  }
  return failed ? -1 : 0;
}

static int check_frames(const job *j, image_error *error) {
  for (int i = (int)j->settings->pre_roll; i < j->count; i++)
    if (check_frame(j, &j->frames[i], error) != 0)
      return -1;
  return 0;
}

int job_output_prepare(job *j, image_error *error) {
  const process_settings *s = j->settings;
  if ((s->preview || s->contact_sheet) && formats_check(error) != 0)
    return -1;
  if (prepare_folder(j, error) != 0 || check_frames(j, error) != 0 ||
      check_parent(j, s->contact_sheet, error) != 0 ||
      check_parent(j, s->cache_save, error) != 0)
    return -1;
  if (!s->dry_run)
    sweep(j);
  return 0;
}
