/* The pipeline of hbil process in a folder that is gone afterwards. */
#define _POSIX_C_SOURCE 200809L
#include "bench/truth_process.h"

#include <dirent.h>
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/colour.h"
#include "tool/layers.h"
#include "tool/paths.h"
#include "tool/process.h"

/* --- settings --- */

static int check_own(const process_arguments *a, image_error *error) {
  const process_settings *s = &a->settings;
  const struct {
    int given;
    const char *name;
  } own[] = {{a->count > 0, a->count > 0 ? a->files[0] : ""},
             {a->frames != NULL, "--frames"},
             {s->output != NULL, "--output"},
             {s->layers != 0, "--layers"},
             {s->copy_channels, "--copy-channels"},
             {s->device != NULL, "--device (it belongs in front of --)"},
             {s->resume, "--resume"},
             {s->dry_run, "--dry-run"},
             {s->preview, "--preview"},
             {s->contact_sheet != NULL, "--contact-sheet"},
             {s->cache_save != NULL, "--cache-save"},
             {s->timings, s->json ? "--json" : "--timings"}};
  for (size_t i = 0; i < sizeof own / sizeof *own; i++)
    if (own[i].given)
      return image_fail(error,
                        "truth: behind --: %s: not here; options of hbil "
                        "process that change the light are needed",
                        own[i].name);
  return 0;
}

/* The words that the parser of hbil process reads; getopt changes their order,
 * not what they own. */
static int read_words(const truth_words *words, int paper,
                      process_arguments *out, image_error *error) {
  static char name[] = "truth: behind --", model_option[] = "--model",
              model[] = "paper";
  char **all = calloc(words->count + 4, sizeof *all);
  int count = 0;
  if (!all)
    return image_no_memory(error, name);
  all[count++] = name; /* which begins the parser's messages */
  for (size_t i = 0; i < words->count; i++)
    all[count++] = words->words[i];
  if (paper) {
    all[count++] = model_option;
    all[count++] = model;
  }
  optind = 0; /* getopt starts anew */
  const int read = process_arguments_read(count, all, out, error);
  int failed = read < 0;
  if (read > 0)
    failed = image_fail(error,
                        "%s: --help: not here; hbil process --help "
                        "lists the options",
                        name);
  if (!failed)
    failed = check_own(out, error);
  free(all);
  return failed ? -1 : 0;
}

int truth_settings_read(const bench_options *options, const char *folder,
                        int paper, truth_settings *out, image_error *error) {
  memset(out, 0, sizeof *out);
  if (truth_words_make(options->process, (size_t)options->process_count, folder,
                       &out->words, error) != 0 ||
      read_words(&out->words, paper, &out->arguments, error) != 0)
    return -1;
  process_settings *s = &out->settings;
  *s = out->arguments.settings;
  s->device = options->device;
  s->layers = 1u << LAYER_INDIRECT;
  s->quiet = 1;
  s->overwrite = 1;
  if (paper && !settings_without_cache(s))
    s->far = FAR_IS_ENVIRONMENT;
  return 0;
}

void truth_settings_free(truth_settings *s) {
  process_arguments_free(&s->arguments);
  truth_words_free(&s->words);
  memset(s, 0, sizeof *s);
}

/* --- the folder --- */

char *truth_folder_make(image_error *error) {
  const char *parent = getenv("TMPDIR");
  char *path =
      path_join(parent && *parent ? parent : "/tmp", "/", "hbil-truth.XXXXXX");
  if (!path) {
    image_no_memory(error, "truth");
    return NULL;
  }
  if (mkdtemp(path))
    return path;
  image_fail(error, "%s: no temporary folder can be made: %s", path,
             strerror(errno));
  free(path);
  return NULL;
}

void truth_folder_remove(char *folder) {
  DIR *list = folder ? opendir(folder) : NULL;
  for (const struct dirent *e; list && (e = readdir(list)) != NULL;) {
    char *path = path_join(folder, "/", e->d_name);
    if (path)
      unlink(path); /* "." and ".." stay */
    free(path);
  }
  if (list)
    closedir(list);
  if (folder)
    rmdir(folder);
  free(folder);
}

/* --- running --- */

int truth_process_check(const process_settings *settings, char *const *files,
                        size_t count, uint32_t *width, uint32_t *height,
                        image_error *error) {
  job j;
  const int failed = job_prepare(&j, settings, files, (int)count, error);
  *width = j.shown.width;
  *height = j.shown.height;
  job_free(&j);
  return failed;
}

int truth_process(const process_settings *settings, char *const *files,
                  size_t count, image_error *error) {
  return process_run(settings, files, (int)count, error) != 0 ? -1 : 0;
}

int truth_process_read(const process_settings *settings, const char *file,
                       compare_side *out, image_error *error) {
  const char *const layers[] = {"indirect", NULL};
  memset(out, 0, sizeof *out);
  char *stem = path_stem_in(settings->output, file);
  char *path = stem ? path_join(stem, "", ".exr") : NULL;
  const int failed = path ? bench_colour_read(path, layers, out, error)
                          : image_no_memory(error, file);
  free(path);
  free(stem);
  return failed;
}
