/* The options behind -- for one scene: `{scene}` stands for its folder. */
#ifndef HBIL_BENCH_TRUTH_WORDS_H
#define HBIL_BENCH_TRUTH_WORDS_H

#include <stddef.h>

#include "image/error.h"

typedef struct truth_words {
  char **words; /* owned, and so is each word */
  size_t count;
} truth_words;

/*
 * Replaces {scene} in the words by the folder.  Behind --view, a word with *, ?
 * or [ becomes one --view for each file that it matches (glob(3)), sorted by
 * name.  0, or -1 with `error` filled; truth_words_free() frees it in both
 * cases.
 */
int truth_words_make(char *const *words, size_t count, const char *folder,
                     truth_words *out, image_error *error);

/* Adds a copy of a word.  0, or -1 with `error` filled. */
int truth_words_add(truth_words *w, const char *word, image_error *error);

void truth_words_free(truth_words *w);

#endif
