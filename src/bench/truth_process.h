/* The pipeline of hbil process, whose results lie in a folder that is gone
 * afterwards. */
#ifndef HBIL_BENCH_TRUTH_PROCESS_H
#define HBIL_BENCH_TRUTH_PROCESS_H

#include <stddef.h>
#include <stdint.h>

#include "bench/command.h"
#include "bench/truth_words.h"
#include "image/error.h"
#include "tool/compare_sides.h"
#include "tool/process_arguments.h"

/* Settings, and what they point at. */
typedef struct truth_settings {
  process_settings settings;
  process_arguments arguments; /* owned */
  truth_words words;           /* owned */
} truth_settings;

/*
 * Reads options->process by the parser of hbil process, and behind them
 * `--model paper` if paper is set, which leaves the radiance cache out, too.
 * folder: that of the scene (truth_words.h).  Options that say where results go
 * or what is printed are errors.  Returns 0, or -1 with `error` filled;
 * truth_settings_free() frees them in both cases.
 */
int truth_settings_read(const bench_options *options, const char *folder,
                        int paper, truth_settings *out, image_error *error);
void truth_settings_free(truth_settings *s);

/* Makes an empty folder for settings->output.  malloc'd; NULL with `error`
 * filled on failure. */
char *truth_folder_make(image_error *error);
/* Removes it with all files in it, and frees the name.  NULL is allowed. */
void truth_folder_remove(char *folder);

/* Looks for everything that hbil process would find wrong before its first
 * pixel, and tells the size of results.  0, or -1 with `error` filled. */
int truth_process_check(const process_settings *settings, char *const *files,
                        size_t count, uint32_t *width, uint32_t *height,
                        image_error *error);

/* Computes the frames.  0, or -1 with `error` filled. */
int truth_process(const process_settings *settings, char *const *files,
                  size_t count, image_error *error);

/* Reads the layer "indirect" of the result of `file`.  0, or -1 with `error`
 * filled; compare_side_free() frees it in both cases. */
int truth_process_read(const process_settings *settings, const char *file,
                       compare_side *out, image_error *error);

#endif
