/* Finds the channels of a layer in a file's header. */
#include "dump/layer_channels.h"

#include "image/image.h"

#include <stdio.h>
#include <string.h>

/* The names of the components in layers of one, two and three channels. */
static const char *const letters[][ROLE_CHANNELS + 1] = {
    {"Z"},
    {"V"},
    {"R"},
    {"Y"},
    {"z"},
    {"v"},
    {"r"},
    {"y"},
    {"T"},
    {"X"},
    {"red"},
    {"X", "Y"},
    {"R", "G"},
    {"x", "y"},
    {"U", "V"},
    {"u", "v"},
    {"r", "g"},
    {"red", "green"},
    {"X", "Y", "Z"},
    {"R", "G", "B"},
    {"x", "y", "z"},
    {"r", "g", "b"},
    {"red", "green", "blue"},
};

static size_t letter_count(const char *const *set) {
  size_t count = 0;
  while (set[count])
    count++;
  return count;
}

/* The names of LAYER.LETTER for the whole set.  Returns how many of them the
 * header has before the first that it lacks. */
static size_t name_set(const image *header, const char *group,
                       const char *const *set, char names[ROLE_CHANNELS][256]) {
  for (size_t i = 0; set[i]; i++) {
    const int length = snprintf(names[i], sizeof names[i], "%s%s%s", group,
                                *group ? "." : "", set[i]);
    if (length >= (int)sizeof names[i] || !image_find(header, names[i]))
      return i;
  }
  return letter_count(set);
}

/* Fills the role's names if the header has the whole set. */
static int take_set(const image *header, const char *group,
                    const char *const *set, role r, channel_map *out) {
  const size_t count = letter_count(set);
  char names[ROLE_CHANNELS][256];
  if (name_set(header, group, set, names) < count)
    return 0;
  memcpy(out->names[r], names, count * sizeof *names);
  out->count[r] = count;
  return 1;
}

int layer_channels_take_one(const image *header, const char *name, role r,
                            channel_map *out) {
  const size_t count = role_channels(r);
  if ((count > 1 && !role_is_colour(r)) || !image_find(header, name))
    return 0;
  for (size_t i = 0; i < count; i++)
    snprintf(out->names[r][i], sizeof *out->names[r], "%s", name);
  out->count[r] = count;
  return 1;
}

int layer_channels_take(const image *header, const char *group, role r,
                        channel_map *out) {
  if (role_channels(r) == 1 && layer_channels_take_one(header, group, r, out))
    return 1;
  for (size_t i = 0; i < sizeof letters / sizeof *letters; i++)
    if (letter_count(letters[i]) == role_channels(r) &&
        take_set(header, group, letters[i], r, out))
      return 1;
  return 0;
}

/* Whether the last word of a layer's name is `word`. */
static int ends_in_word(const char *layer, const char *word) {
  const size_t whole = strlen(layer), own = strlen(word);
  return whole > own && layer[whole - own - 1] == '.' &&
         strcmp(layer + whole - own, word) == 0;
}

/* Whether the channel is the first one of a layer that could have the role. */
static int begins_layer(const image *header, const char *channel,
                        const char *layer, role r) {
  char names[ROLE_CHANNELS][256];
  for (size_t i = sizeof letters / sizeof *letters; i-- > 0;) {
    const size_t count = letter_count(letters[i]);
    if (name_set(header, layer, letters[i], names) < count)
      continue;
    if (count == role_channels(r))
      return strcmp(names[0], channel) == 0;
    if (role_channels(r) == 1)
      return 0; /* its Z or R is a part of a vector or colour */
  }
  return 0;
}

size_t layer_channels_list(const image *header, const char *word, role r,
                           char *text, size_t size) {
  size_t count = 0, used = 0;
  *text = '\0';
  for (size_t i = 0; i < header->count; i++) {
    const char *name = header->planes[i].name, *dot = strrchr(name, '.');
    char layer[256];
    snprintf(layer, sizeof layer, "%.*s", dot ? (int)(dot - name) : 0, name);
    if (!*layer || (word && !ends_in_word(layer, word)) ||
        !begins_layer(header, name, layer, r))
      continue;
    if (used < size)
      used += (size_t)snprintf(text + used, size - used, "%s%s",
                               count ? ", " : "", layer);
    count++;
  }
  return count;
}

int layer_channels_lack(const image *header, const char *layer, char *missing) {
  *missing = '\0';
  for (size_t i = 0; i < sizeof letters / sizeof *letters && *layer; i++) {
    const char *const *set = letters[i];
    char name[256];
    int has = 0;
    if (letter_count(set) < 3 || (**set != 'R' && **set != 'r'))
      continue;
    *missing = '\0';
    for (size_t c = 0; c < 3; c++) {
      const int length = snprintf(name, sizeof name, "%s.%s", layer, set[c]);
      if (length < (int)sizeof name && image_find(header, name))
        has = 1;
      else if (!*missing)
        memcpy(missing, name, sizeof name);
    }
    if (has && *missing)
      return 1;
  }
  *missing = '\0';
  return 0;
}

int layer_channels_take_ending(const image *header, const char *ending, role r,
                               channel_map *out) {
  const size_t length = strlen(ending);
  for (size_t i = 0; i < header->count; i++) {
    const char *name = header->planes[i].name;
    const size_t whole = strlen(name);
    if (whole > length && strcmp(name + whole - length, ending) == 0)
      return layer_channels_take_one(header, name, r, out);
  }
  return 0;
}

int layer_channels_take_alpha(const image *header, const char *group,
                              channel_map *out) {
  char name[256];
  const int length =
      snprintf(name, sizeof name, "%s%sA", group, *group ? "." : "");
  return length < (int)sizeof name &&
         layer_channels_take_one(header, name, ROLE_ALPHA, out);
}

int layer_channels_take_with_alpha(const image *header, role r,
                                   channel_map *out) {
  for (size_t i = 0; i < header->count; i++) {
    const char *name = header->planes[i].name;
    const size_t length = strlen(name);
    char group[256];
    if (length < 3 || strcmp(name + length - 2, ".A") != 0)
      continue;
    snprintf(group, sizeof group, "%.*s", (int)length - 2, name);
    if (layer_channels_take(header, group, r, out))
      return 1;
  }
  return 0;
}
