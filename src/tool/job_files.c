/* All files that a job reads and writes. */
#include "tool/job_files.h"

#include "tool/file_uses.h"

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
                                        .of = f->path,
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
                                  .of = f->path,
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
  int failed = file_uses_add(
      uses,
      (file_use){.path = job_history_path(j, (int)j->settings->pre_roll),
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
  for (int i = (int)j->settings->pre_roll; i < j->count && !failed; i++)
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
      failed = (use->of ? check_result : check_other)(s, use, error);
  }
  return failed;
}

int job_files_check(const job *j, image_error *error) {
  file_uses uses = {0};
  const int failed = add_read(j, &uses, error) != 0 ||
                     add_written(j, &uses, error) != 0 ||
                     file_uses_check(&uses, error) != 0 ||
                     check_present(j->settings, &uses, error) != 0;
  file_uses_free(&uses);
  return failed ? -1 : 0;
}
