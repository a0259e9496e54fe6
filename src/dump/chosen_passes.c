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
  if (layer_channels_take(header, group, r, out) ||
      layer_channels_take_one(header, group, r, out))
    return 0;
  /* in a file of its own the first channel may have any name */
  if (!*group && header->count > 0 &&
      layer_channels_take_one(header, header->planes[0].name, r, out))
    return 0;
  return image_fail(error,
                    "--map %s=%s: %s has no such layer of %zu channel%s (see "
                    "hbil info)",
                    role_name(r), group, path, role_channels(r),
                    role_channels(r) == 1 ? "" : "s");
}

/* Takes a pass from a file of its own. */
static int take_file(const char *frame, const image *own, const char *pattern,
                     const char *group, role r, channel_map *out,
                     image_error *error) {
  image header;
  char *path = beside(frame, pattern);
  if (!path)
    return image_no_memory(error, frame);
  if (image_read_header(path, &header, error) != 0) {
    free(path);
    return -1;
  }
  const image_window shown = image_display_window(own);
  const image_window here = image_display_window(&header);
  int failed = take_from(&header, path, group, r, out, error);
  if (!failed && (shown.width != here.width || shown.height != here.height))
    failed = image_fail(error,
                        "%s: %u x %u pixels, but %s has %u x %u; passes of "
                        "one size are needed",
                        path, here.width, here.height, frame, shown.width,
                        shown.height);
  out->gamma[r] = header.gamma;
  image_free(&header);
  free(out->files[r]);
  out->files[r] = path;
  return failed;
}

/* Takes one ROLE=[FILE:]LAYER, which is overwritten. */
static int take_word(const char *frame, const image *header, char *word,
                     channel_map *out, image_error *error) {
  char *equals = strchr(word, '=');
  int r = 0;
  if (equals)
    *equals = '\0';
  while (r < ROLE_COUNT && strcmp(word, role_name((role)r)) != 0)
    r++;
  if (!equals || r == ROLE_COUNT)
    return image_fail(error,
                      "--map %s: ROLE=LAYER is needed, ROLE one of depth, "
                      "normal, albedo, direct, emission, background, motion, "
                      "position, indirect",
                      word);
  char *value = equals + 1;
  char *colon = strrchr(value, ':');
  out->count[r] = 0;
  free(out->files[r]);
  out->files[r] = NULL;
  out->gamma[r] = header->gamma;
  if (!*value)
    return 0;
  if (colon)
    *colon = '\0';
  if (colon || is_file(value))
    return take_file(frame, header, value, colon ? colon + 1 : "", (role)r, out,
                     error);
  return take_from(header, frame, value, (role)r, out, error);
}

int chosen_passes_take(const char *frame, const image *header, const char *text,
                       channel_map *out, image_error *error) {
  char *words = strdup(text), *rest = NULL;
  int failed = words ? 0 : image_no_memory(error, frame);
  for (char *word = words ? strtok_r(words, ",", &rest) : NULL; word && !failed;
       word = strtok_r(NULL, ",", &rest))
    failed = take_word(frame, header, word, out, error);
  free(words);
  return failed;
}
