/* The user's choice of passes, in the frame's own file and in files beside it.
 */
#define _POSIX_C_SOURCE 200809L
#include "dump/chosen_passes.h"

#include "dump/layer_channels.h"
#include "image/error.h"
#include "image/image.h"
#include "image/image_read.h"
#include "image/window.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The last number in the frame's file name; length 0 if it has none. */
static const char *frame_number(const char *frame, int *length) {
  const char *slash = strrchr(frame, '/');
  const char *base = slash ? slash + 1 : frame;
  const char *end = base + strlen(base);
  while (end > base && !isdigit((unsigned char)end[-1]))
    end--;
  const char *begin = end;
  while (begin > base && isdigit((unsigned char)begin[-1]))
    begin--;
  *length = (int)(end - begin);
  return begin;
}

/* The path of a pass's file: FILE in the frame's folder, each run of # replaced
 * by the frame's number.  malloc'd; NULL if memory runs out. */
static char *beside(const char *frame, const char *pattern) {
  int digits;
  const char *number = frame_number(frame, &digits);
  const char *slash = strrchr(frame, '/');
  const size_t folder =
      slash && pattern[0] != '/' ? (size_t)(slash - frame) + 1 : 0;
  size_t size = folder + 1;
  for (const char *at = pattern; *at; at++)
    size += *at == '#' ? (size_t)digits : 1;
  char *path = malloc(size);
  if (!path)
    return NULL;
  char *to = path;
  memcpy(to, frame, folder);
  to += folder;
  for (const char *at = pattern; *at; at++)
    if (*at != '#')
      *to++ = *at;
    else if (at == pattern || at[-1] != '#') {
      memcpy(to, number, (size_t)digits);
      to += digits;
    }
  *to = '\0';
  return path;
}

/* Whether a value of --map names a file and no layer. */
static int is_file(const char *value) {
  static const char *const endings[] = {".exr",  ".png", ".tif",
                                        ".tiff", ".hdr", NULL};
  for (const char *const *e = endings; *e; e++)
    if (strlen(value) > strlen(*e) &&
        strcmp(value + strlen(value) - strlen(*e), *e) == 0)
      return 1;
  return 0;
}

static int take_from(const image *header, const char *path, const char *group,
                     role r, channel_map *out, image_error *error) {
  char layers[512];
  if (layer_channels_take(header, group, r, out) ||
      layer_channels_take_one(header, group, r, out))
    return 0;
  /* the last word of a layer's name stands for it if no other ends so */
  const size_t alike =
      *group ? layer_channels_list(header, group, r, layers, sizeof layers) : 0;
  if (alike == 1 && layer_channels_take(header, layers, r, out))
    return 0;
  /* in a file of its own the first channel may have any name */
  if (!*group && header->count > 0 &&
      layer_channels_take_one(header, header->planes[0].name, r, out))
    return 0;
  if (alike > 1)
    return image_fail(error,
                      "--map %s=%s: %s has several such layers; one of %s is "
                      "needed",
                      role_name(r), group, path, layers);
  layer_channels_list(header, NULL, r, layers, sizeof layers);
  return image_fail(error,
                    "--map %s=%s: %s has no such layer of %zu channel%s%s%s",
                    role_name(r), group, path, role_channels(r),
                    role_channels(r) == 1 ? "" : "s",
                    *layers ? "; it has " : " (see hbil info)", layers);
}

int chosen_passes_take_file(const char *frame, const image *own, char *path,
                            const char *group, role r, channel_map *out,
                            image_error *error) {
  image header;
  free(out->files[r]);
  out->files[r] = path;
  if (image_read_header(path, &header, error) != 0)
    return -1;
  const image_window shown = image_display_window(own);
  const image_window here = image_display_window(&header);
  int failed = take_from(&header, path, group, r, out, error);
  if (!failed && (shown.width != here.width || shown.height != here.height))
    failed = image_fail(error,
                        "%s: %u x %u pixels, but %s has %u x %u; passes of "
                        "one size are needed",
                        path, here.width, here.height, frame, shown.width,
                        shown.height);
  channel_map_encode(out, r, &header);
  image_free(&header);
  return failed;
}

/* The role of a ROLE=..., of which `equals` is the =. */
static int role_of(const char *word, const char *equals) {
  const size_t length = (size_t)(equals - word);
  int r = 0;
  while (r < ROLE_COUNT && (strlen(role_name((role)r)) != length ||
                            strncmp(word, role_name((role)r), length) != 0))
    r++;
  return r;
}

static int take_value(const char *frame, const image *header, char *value,
                      role r, channel_map *out, image_error *error) {
  char *colon = strrchr(value, ':');
  if (colon)
    *colon = '\0';
  if (!colon && !is_file(value))
    return take_from(header, frame, value, r, out, error);
  char *path = beside(frame, value);
  return path ? chosen_passes_take_file(frame, header, path,
                                        colon ? colon + 1 : "", r, out, error)
              : image_no_memory(error, frame);
}

/* Takes single channels, one for each component. */
static int take_channels(const char *frame, const image *header,
                         char *const *values, size_t count, role r,
                         channel_map *out, image_error *error) {
  if (count != role_channels(r))
    return image_fail(error, "--map %s=%s,...: %zu channels; %zu are needed",
                      role_name(r), values[0], count, role_channels(r));
  for (size_t i = 0; i < count; i++) {
    if (!image_find(header, values[i]))
      return image_fail(error,
                        "--map %s=...,%s: %s has no such channel (see hbil "
                        "info)",
                        role_name(r), values[i], frame);
    snprintf(out->names[r][i], sizeof out->names[r][i], "%s", values[i]);
  }
  out->count[r] = count;
  return 0;
}

static int report_role(const char *word, image_error *error) {
  char roles[256] = "";
  for (int r = 0; r < ROLE_COUNT; r++) {
    const size_t used = strlen(roles);
    snprintf(roles + used, sizeof roles - used, "%s%s", r ? ", " : "",
             role_name((role)r));
  }
  return image_fail(error, "--map %.*s: ROLE=LAYER is needed, ROLE one of %s",
                    (int)strcspn(word, "="), word, roles);
}

/* Takes one ROLE= with its values, which are overwritten. */
static int take_role(const char *frame, const image *header, char *const *words,
                     size_t count, channel_map *out, image_error *error) {
  char *equals = strchr(words[0], '=');
  const int r = equals ? role_of(words[0], equals) : ROLE_COUNT;
  char *values[ROLE_CHANNELS + 1] = {equals ? equals + 1 : NULL};
  if (r == ROLE_COUNT)
    return report_role(words[0], error);
  out->chosen |= 1u << r;
  out->count[r] = 0;
  free(out->files[r]);
  out->files[r] = NULL;
  channel_map_encode(out, (role)r, header);
  if (count > 1) {
    for (size_t i = 1; i < count && i <= ROLE_CHANNELS; i++)
      values[i] = words[i];
    return take_channels(frame, header, values, count, (role)r, out, error);
  }
  return *values[0] ? take_value(frame, header, values[0], (role)r, out, error)
                    : 0;
}

/* Splits a text at its commas, and returns how many words there are. */
static size_t split(char *text, char **words, size_t most) {
  size_t count = 0;
  char *rest = NULL;
  for (char *word = strtok_r(text, ",", &rest); word && count < most;
       word = strtok_r(NULL, ",", &rest))
    words[count++] = word;
  return count;
}

int chosen_passes_take(const char *frame, const image *header, const char *text,
                       channel_map *out, image_error *error) {
  const size_t most = strlen(text) / 2 + 1;
  char *copy = strdup(text), **words = calloc(most, sizeof *words);
  int failed = copy && words ? 0 : image_no_memory(error, frame);
  const size_t count = failed ? 0 : split(copy, words, most);
  /* a word without = is one more channel of the role before it */
  for (size_t i = 0, next; i < count && !failed; i = next) {
    for (next = i + 1; next < count && !strchr(words[next], '=');)
      next++;
    failed = take_role(frame, header, words + i, next - i, out, error);
  }
  free(words);
  free(copy);
  return failed;
}
