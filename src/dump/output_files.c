/* Renderers that write each pass to a file of its own. */
#define _POSIX_C_SOURCE 200809L
#include "dump/output_files.h"

#include "dump/chosen_passes.h"
#include "dump/layer_channels.h"
#include "image/error.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Where a file's name has the word of a pass. */
typedef struct place {
  size_t at, length; /* in the path; length 0: it has none */
  int small;         /* 1: in small letters */
} place;

static int same_word(const char *text, const char *word, size_t length,
                     int small) {
  for (size_t i = 0; i < length; i++) {
    const int letter = small ? tolower((unsigned char)word[i]) : word[i];
    if ((unsigned char)text[i] != letter)
      return 0;
  }
  return 1;
}

/* The word is a name's part if no letter is beside it.  `_` is part of longer
 * names of passes, which the caller looks for first. */
static place find_word(const char *path, const char *word) {
  const char *slash = strrchr(path, '/');
  const size_t from = slash ? (size_t)(slash - path) + 1 : 0;
  const size_t length = strlen(word), whole = strlen(path);
  for (int small = 0; small < 2; small++)
    for (size_t at = whole; at-- > from;)
      if (at + length <= whole && same_word(path + at, word, length, small) &&
          (at == from || !isalnum((unsigned char)path[at - 1])) &&
          !isalpha((unsigned char)path[at + length]))
        return (place){at, length, small};
  return (place){0, 0, 0};
}

/* The path with another word in that place; malloc'd, NULL if memory runs out.
 */
static char *with_word(const char *path, place where, const char *word) {
  const size_t length = strlen(word), tail = where.at + where.length;
  char *out = malloc(strlen(path) + length + 1);
  if (!out)
    return NULL;
  memcpy(out, path, where.at);
  for (size_t i = 0; i < length; i++)
    out[where.at + i] =
        (char)(where.small ? tolower((unsigned char)word[i]) : word[i]);
  strcpy(out + where.at + length, path + tail);
  return out;
}

/* The file of a pass beside that of another one; NULL if there is none. */
static char *file_of(const char *path, place where, const char *word) {
  char *file = with_word(path, where, word);
  if (file && access(file, F_OK) == 0)
    return file;
  free(file);
  return NULL;
}

/* The word for the depth of a source. */
static const char *depth_word(dump_kind kind) {
  const pass_name *pass = source_table[kind].passes;
  while (pass->role != ROLE_DEPTH)
    pass++;
  return pass->pass;
}

/* Whether there are normals or direct light beside it; the word for depth alone
 * may be anyone's. */
static int has_others(const char *path, place where, dump_kind kind) {
  int others = 0;
  for (const pass_name *pass = source_table[kind].passes; pass->pass; pass++)
    if (pass->role == ROLE_NORMAL || pass->role == ROLE_DIRECT) {
      char *file = file_of(path, where, pass->pass);
      others |= file != NULL;
      free(file);
    }
  return others;
}

dump_kind output_files_recognise(const char *path) {
  for (int k = 0; k < DUMP_KINDS; k++) {
    if (!source_table[k].in_files)
      continue;
    const place where = find_word(path, depth_word((dump_kind)k));
    if (where.length && has_others(path, where, (dump_kind)k))
      return (dump_kind)k;
  }
  return DUMP_PLAIN;
}

/* The longest word that the name has, as one may be a part of another. */
static place find_pass(const char *path, dump_kind kind) {
  /* pictures that have no role */
  static const char *const pictures[] = {"RGB", "RGB_IMAGEPIPELINE", "RGBA",
                                         "IRRADIANCE", NULL};
  place best = {0, 0, 0};
  for (const char *const *picture = pictures; *picture; picture++) {
    const place here = find_word(path, *picture);
    if (here.length > best.length)
      best = here;
  }
  for (const pass_name *pass = source_table[kind].passes; pass->pass; pass++) {
    const place here = find_word(path, pass->pass);
    if (here.length > best.length)
      best = here;
  }
  return best;
}

int output_files_check(const char *path, image_error *error) {
  for (int k = 0; k < DUMP_KINDS; k++) {
    if (!source_table[k].in_files)
      continue;
    const char *word = depth_word((dump_kind)k);
    const place here = find_pass(path, (dump_kind)k);
    char *depth = here.length ? file_of(path, here, word) : NULL;
    const int failed =
        depth && strcmp(depth, path) != 0 &&
                has_others(path, here, (dump_kind)k)
            ? image_fail(error,
                         "%s: is the output %.*s of %s; the frame to name is "
                         "%s, whose other outputs are found beside it",
                         path, (int)here.length, path + here.at,
                         source_table[k].about, depth)
            : 0;
    free(depth);
    if (failed)
      return -1;
  }
  return 0;
}

int output_files_take(const char *path, const image *header,
                      const pass_name *passes, channel_map *out,
                      image_error *error) {
  const place where = find_word(path, depth_word(out->kind));
  int failed = 0;
  for (const pass_name *pass = passes; pass->pass && !failed; pass++) {
    if (out->count[pass->role])
      continue;
    if (pass->role == ROLE_DEPTH) {
      layer_channels_take(header, "", ROLE_DEPTH, out);
      continue;
    }
    char *file = where.length ? file_of(path, where, pass->pass) : NULL;
    if (file)
      failed = chosen_passes_take_file(path, header, file, "", pass->role, out,
                                       error);
  }
  return failed;
}
