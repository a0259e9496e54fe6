/* The options behind -- for one scene. */
#define _POSIX_C_SOURCE 200809L
#include "bench/truth_words.h"

#include <glob.h>
#include <stdlib.h>
#include <string.h>

static const char scene[] = "{scene}", view[] = "--view";

/* Takes over the malloc'd word; NULL means that memory ran out. */
static int take(truth_words *w, char *word, image_error *error) {
  char **grown =
      word ? realloc(w->words, (w->count + 1) * sizeof *grown) : NULL;
  if (!grown) {
    free(word);
    return image_no_memory(error, "truth: behind --");
  }
  w->words = grown;
  w->words[w->count++] = word;
  return 0;
}

int truth_words_add(truth_words *w, const char *word, image_error *error) {
  return take(w, strdup(word), error);
}

/* The word with the folder in place of each {scene}.  escaped: as a pattern
 * that matches the folder's name alone.  malloc'd; NULL if memory runs out. */
static char *replace(const char *word, const char *folder, int escaped) {
  const size_t most = strlen(word) / strlen(scene) + 1;
  char *out = malloc(strlen(word) + most * 2 * strlen(folder) + 1);
  char *to = out;
  while (out && *word) {
    if (strncmp(word, scene, strlen(scene)) != 0) {
      *to++ = *word++;
      continue;
    }
    for (const char *c = folder; *c; *to++ = *c++)
      if (escaped && strchr("*?[\\", *c))
        *to++ = '\\';
    word += strlen(scene);
  }
  if (out)
    *to = '\0';
  return out;
}

/* Adds --view and its file for each match. */
static int add_matches(truth_words *w, const char *pattern,
                       image_error *error) {
  glob_t found;
  const int status = glob(pattern, 0, NULL, &found);
  if (status == GLOB_NOMATCH)
    return image_fail(
        error, "truth: behind --: --view %s: there is no such file", pattern);
  if (status != 0)
    return image_fail(error, "truth: behind --: --view %s: cannot be read",
                      pattern);
  int failed = 0;
  for (size_t i = 0; i < found.gl_pathc && !failed; i++)
    failed = truth_words_add(w, view, error) != 0 ||
             truth_words_add(w, found.gl_pathv[i], error) != 0;
  globfree(&found);
  return failed ? -1 : 0;
}

/* Adds --view for its value. */
static int add_view(truth_words *w, const char *value, const char *folder,
                    image_error *error) {
  const int many = strpbrk(value, "*?[") != NULL;
  char *text = replace(value, folder, many);
  if (!text)
    return image_no_memory(error, value);
  const int failed = many ? add_matches(w, text, error)
                          : truth_words_add(w, view, error) != 0 ||
                                truth_words_add(w, text, error) != 0;
  free(text);
  return failed ? -1 : 0;
}

int truth_words_make(char *const *words, size_t count, const char *folder,
                     truth_words *out, image_error *error) {
  const size_t length = strlen(view);
  int failed = 0;
  memset(out, 0, sizeof *out);
  for (size_t i = 0; i < count && !failed; i++)
    if (strcmp(words[i], view) == 0 && i + 1 < count)
      failed = add_view(out, words[++i], folder, error);
    else if (strncmp(words[i], view, length) == 0 && words[i][length] == '=')
      failed = add_view(out, words[i] + length + 1, folder, error);
    else
      failed = take(out, replace(words[i], folder, 0), error);
  return failed;
}

void truth_words_free(truth_words *w) {
  for (size_t i = 0; i < w->count; i++)
    free(w->words[i]);
  free(w->words);
  memset(w, 0, sizeof *w);
}
