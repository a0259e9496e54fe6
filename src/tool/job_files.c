/* All files that a job reads and writes. */
#define _POSIX_C_SOURCE 200809L
#include "tool/job_files.h"

#include "image/formats.h"
#include "image/temporary.h"
#include "image/temporary_sweep.h"
#include "tool/file_uses.h"
#include "tool/paths.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ------------------------------------------------------------------------ */
/* Folders                                                                   */

/* Whether the results could be written, without leaving a trace. */
static int look_at_folder(const char *folder, image_error *error) {
  if (path_is_writable(folder))
    return 0;
  const char *why = strerror(errno);
  return image_fail(error,
                    "%s: output folder cannot be %s: %s; a folder in which you "
                    "may write is needed",
                    folder, access(folder, F_OK) == 0 ? "written" : "created",
                    why);
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
  char *parent = path_parent(path);
  if (!parent)
    return image_no_memory(error, path);
  int failed = access(parent, W_OK | X_OK);
  const int why = errno;
  /* its folder may be one that a dry run doesn't make */
  if (failed && s->dry_run && file_place_is_made_with(parent, s->output))
    failed = 0;
  free(parent);
  return failed ? image_fail(error,
                             "%s: cannot be written: %s; a folder in which "
                             "you may write is needed",
                             path, strerror(why))
                : 0;
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

/* ------------------------------------------------------------------------ */
/* What is read                                                              */

static int read_frame(file_uses *uses, const job_frame *f, const char *what,
                      image_error *error) {
  int failed = file_uses_read(uses, f->path, what, error);
  if (!failed && f->camera_path)
    failed = file_uses_read(uses, f->camera_path, "the camera file", error);
  for (int r = 0; r < ROLE_COUNT && !failed; r++)
    if (f->map.files[r])
      failed = file_uses_read(uses, f->map.files[r], "the pass", error);
  return failed;
}

static int read_frames(file_uses *uses, const job_frame *list, int count,
                       const char *what, image_error *error) {
  int failed = 0;
  for (int i = 0; i < count && !failed; i++)
    failed = read_frame(uses, &list[i], what, error);
  return failed;
}

static int add_read(const job *j, file_uses *uses, image_error *error) {
  const process_settings *s = j->settings;
  if (read_frames(uses, j->frames, j->count, "the frame", error) != 0 ||
      read_frames(uses, j->views, j->view_count, "the view", error) != 0 ||
      read_frames(uses, j->lights, j->light_count, "the light view", error) !=
          0 ||
      (j->decider &&
       read_frame(uses, j->decider, "the frame of --decide-by", error) != 0))
    return -1;
  /* the environment is a file exactly if its far field is HBIL_FAR_SH; the
   * first frame may change that later */
  if (j->config.model.far_field == HBIL_FAR_SH &&
      file_uses_read(uses, s->environment, "the environment map", error) != 0)
    return -1;
  return s->cache_load ? file_uses_read(uses, s->cache_load,
                                        "the cache of --cache-load", error)
                       : 0;
}

/* ------------------------------------------------------------------------ */
/* What is written                                                           */

static int write_previews(const job *j, const job_frame *f, file_uses *uses,
                          image_error *error) {
  int failed = 0;
  for (int l = 0; j->settings->preview && l < LAYER_COUNT && !failed; l++)
    if (j->layers >> l & 1)
      failed = file_uses_add(uses,
                             (file_use){.path = job_preview_path(f, (layer)l),
                                        .what = "a preview",
                                        .frame = f->path,
                                        .need = "another output folder is",
                                        .kind = FILE_PICTURE},
                             error);
  return failed;
}

static int write_frame(const job *j, const job_frame *f, file_uses *uses,
                       image_error *error) {
  return file_uses_add(uses,
                       (file_use){.path = job_result_path(f),
                                  .what = "the result",
                                  .frame = f->path,
                                  .need = "another output folder is",
                                  .kind = FILE_RESULT},
                       error) != 0
             ? -1
             : write_previews(j, f, uses, error);
}

/* Files beside the results. */
static int write_others(const job *j, file_uses *uses, image_error *error) {
  const process_settings *s = j->settings;
  const struct {
    const char *path, *option;
    file_kind kind;
  } others[] = {{s->contact_sheet, "--contact-sheet", FILE_PICTURE},
                {s->cache_save, "--cache-save", FILE_CACHE}};
  int failed =
      file_uses_add(uses,
                    (file_use){.path = job_history_path(j, (int)j->pre_roll),
                               .what = "the light to carry on",
                               .need = "another output folder is",
                               .kind = FILE_ABSENT},
                    error);
  for (size_t i = 0; i < sizeof others / sizeof *others && !failed; i++)
    if (others[i].path)
      failed = file_uses_write(uses, others[i].path, others[i].option,
                               "another name is", others[i].kind, error);
  return failed;
}

static int add_written(const job *j, file_uses *uses, image_error *error) {
  int failed = 0;
  for (int i = (int)j->pre_roll; i < j->count && !failed; i++)
    failed = write_frame(j, &j->frames[i], uses, error);
  return failed ? -1 : write_others(j, uses, error);
}

/* ------------------------------------------------------------------------ */
/* What is there already                                                     */

/* Whether the file of a result or preview that exists may be replaced. */
static int check_result(const process_settings *s, const file_use *use,
                        image_error *error) {
  /* a folder in its place is an error when it is written */
  const file_kind there = s->overwrite ? FILE_ABSENT : file_kind_of(use->path);
  if (there == FILE_ABSENT || there == FILE_IRREGULAR)
    return 0;
  if (!s->resume)
    return image_fail(error,
                      "%s: is there already; --overwrite to replace it, "
                      "--resume to continue an interrupted job, or another "
                      "output folder is needed",
                      use->path);
  if (there == use->kind || there == FILE_BLANK)
    return 0;
  return image_fail(error,
                    "%s: is not %s, and --resume replaces nothing else; "
                    "another output folder is needed, or --overwrite, which "
                    "would replace this file and all results",
                    use->path, file_kind_name(use->kind));
}

/* The same for a file that an option names. */
static int check_other(const process_settings *s, const file_use *use,
                       image_error *error) {
  const file_kind there = file_kind_of(use->path);
  if (there != FILE_ABSENT && there != FILE_IRREGULAR && !s->overwrite &&
      !s->resume)
    return image_fail(error,
                      "%s: is there already; --overwrite or another name is "
                      "needed",
                      use->path);
  return file_use_may_replace(use, there, error);
}

static int check_present(const process_settings *s, const file_uses *uses,
                         image_error *error) {
  int failed = 0;
  for (size_t i = 0; i < uses->count && !failed; i++) {
    const file_use *use = &uses->list[i];
    if (use->kind != FILE_ABSENT)
      failed = (use->frame ? check_result : check_other)(s, use, error);
  }
  return failed;
}

/* File systems have a limit for names, mostly 255 bytes.  What a job adds to a
 * frame's name may lead beyond it. */
static int check_lengths(const job *j, const file_uses *uses,
                         image_error *error) {
  const long limit = pathconf(j->settings->output, _PC_NAME_MAX);
  for (size_t i = 0; limit >= 0 && i < uses->count; i++) {
    const char *path = uses->list[i].path;
    const size_t length =
        strlen(strrchr(path, '/') ? strrchr(path, '/') + 1 : path);
    if (uses->list[i].frame && length > (size_t)limit)
      return image_fail(error,
                        "%s: cannot be written: its name has %zu bytes; a "
                        "frame's name with which it has at most %ld is needed",
                        path, length, limit);
  }
  return 0;
}

/* ------------------------------------------------------------------------ */
/* All of it                                                                 */

static int check_all(const job *j, file_uses *uses, image_error *error) {
  const process_settings *s = j->settings;
  if (add_read(j, uses, error) != 0 || add_written(j, uses, error) != 0 ||
      check_lengths(j, uses, error) != 0 ||
      check_parent(j, s->contact_sheet, error) != 0 ||
      check_parent(j, s->cache_save, error) != 0)
    return -1;
  if (!s->dry_run)
    sweep(j);
  return file_uses_check(uses, error) != 0 || check_present(s, uses, error) != 0
             ? -1
             : 0;
}

int job_files_prepare(job *j, image_error *error) {
  const process_settings *s = j->settings;
  file_uses uses = {0};
  if (((s->preview || s->contact_sheet) && formats_check(error) != 0) ||
      prepare_folder(j, error) != 0)
    return -1;
  const int failed = check_all(j, &uses, error);
  file_uses_free(&uses);
  return failed;
}
