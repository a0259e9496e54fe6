/* Makes the channel map of a frame from its header and the user's options. */
#define _POSIX_C_SOURCE 200809L
#include "dump/read_channel_map.h"

#include "dump/chosen_passes.h"
#include "dump/layer_channels.h"
#include "dump/output_files.h"
#include "dump/recognise.h"
#include "dump/view_layer.h"
#include "image/error.h"
#include "image/image.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

/* Takes the channels of a pass in a view layer, with the eye's name behind it
 * or without.  Alpha is the channel A beside a pass's colours. */
static int take_pass(const image *header, const view_layer *from,
                     const char *eye, const pass_name *pass, channel_map *out) {
  char group[256];
  const int length =
      snprintf(group, sizeof group, "%s%s%s", from->before, pass->pass, eye);
  if (length >= (int)sizeof group)
    return 0;
  const int taken = pass->role == ROLE_ALPHA
                        ? layer_channels_take_alpha(header, group, out)
                        : layer_channels_take(header, group, pass->role, out);
  if (!taken && role_is_colour(pass->role) && !*out->lacks[pass->role])
    layer_channels_lack(header, group, out->lacks[pass->role]);
  return taken;
}

/* Takes the first pass of the list that the file has, for each role. */
static void take_passes(const image *header, const view_layer *from,
                        const pass_name *passes, channel_map *out) {
  for (; passes->pass; passes++) {
    if (out->count[passes->role])
      continue;
    if (strcmp(passes->pass, "*RGBA") == 0)
      layer_channels_take_with_alpha(header, passes->role, out);
    else if (passes->pass[0] == '*')
      layer_channels_take_ending(header, passes->pass + 1, passes->role, out);
    else if (!take_pass(header, from, from->behind, passes, out) && from->plain)
      take_pass(header, from, "", passes, out);
  }
}

/* Both are radiance that the eye sees directly, so a background pass can stand
 * in for a missing emission pass. */
static void background_as_emission(channel_map *map) {
  if (map->count[ROLE_EMISSION] || !map->count[ROLE_BACKGROUND])
    return;
  memcpy(map->names[ROLE_EMISSION], map->names[ROLE_BACKGROUND],
         sizeof map->names[ROLE_EMISSION]);
  map->count[ROLE_EMISSION] = map->count[ROLE_BACKGROUND];
  map->gamma[ROLE_EMISSION] = map->gamma[ROLE_BACKGROUND];
  map->floats[ROLE_EMISSION] = map->floats[ROLE_BACKGROUND];
  map->files[ROLE_EMISSION] = map->files[ROLE_BACKGROUND];
  map->files[ROLE_BACKGROUND] = NULL;
  map->count[ROLE_BACKGROUND] = 0;
  map->emission_is_sky = 1;
}

static int is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/* Whether one of the words of a text, up to `end`, is a usual name of finished
 * images. */
static int names_beauty(const char *text, const char *end) {
  static const char *const words[] = {
      "combined", "beauty", "finalimage", "finalimagemovierenderqueue",
      "rgba",     NULL};
  while (text < end) {
    const char *from = text;
    while (text < end && is_letter(*text))
      text++;
    const size_t length = (size_t)(text - from);
    for (const char *const *word = words; *word; word++)
      if (strlen(*word) == length && strncasecmp(from, *word, length) == 0)
        return 1;
    text++;
  }
  return 0;
}

/* Whether a channel's layer is a finished image by its name.  Blender puts the
 * name of the view layer in front, which says nothing. */
static int layer_is_beauty(const char *channel) {
  const char *first = strchr(channel, '.'), *last = strrchr(channel, '.');
  return last && names_beauty(first < last ? first + 1 : channel, last);
}

/* Whether the pass of direct light is a finished image, by its name or because
 * it is the file's RGB without a layer. */
static int is_beauty(const channel_map *map) {
  const char *file = map->files[ROLE_DIRECT];
  const char *name = map->names[ROLE_DIRECT][0];
  const char *slash = file ? strrchr(file, '/') : NULL;
  if (!map->count[ROLE_DIRECT])
    return 0;
  if (map->how.shows_sources)
    return 0; /* its source writes direct light there (light_sources.h) */
  if (file && names_beauty(slash ? slash + 1 : file, file + strlen(file)))
    return 1;
  return layer_is_beauty(name) || (!file && !strchr(name, '.'));
}

/* Mitsuba's ending of distances along the ray, whatever else is known. */
static int is_ray_by_name(const channel_map *map) {
  const char *name = map->names[ROLE_DEPTH][0];
  const size_t length = strlen(name);
  return map->count[ROLE_DEPTH] && length > 2 &&
         strcmp(name + length - 2, ".T") == 0;
}

/* Positions replace a missing depth.  They also replace a depth that begins at
 * the near plane, because its distance is often unknown, unless the user asks
 * for that depth. */
static void choose_depth(const source_options *o, channel_map *map) {
  const int asked = map->chosen >> ROLE_DEPTH & 1;
  if (o->depth < 0 && is_ray_by_name(map)) {
    map->how.depth = DEPTH_RAY;
    map->how.unsure &= ~(unsigned)UNSURE_DEPTH;
  }
  if (o->depth < 0 && map->count[ROLE_POSITION] &&
      (!map->count[ROLE_DEPTH] || (map->how.from_near && !asked)))
    map->how.depth = DEPTH_POSITION;
  if (map->how.depth != DEPTH_POSITION || !map->count[ROLE_POSITION])
    return;
  map->count[ROLE_DEPTH] = 1;
  snprintf(map->names[ROLE_DEPTH][0], sizeof *map->names[ROLE_DEPTH], "from %s",
           role_name(ROLE_POSITION));
}

/* If direct light also shows lamps and the sky, these are the emission, unless
 * the user says what else is. */
static void take_sources(channel_map *map) {
  conventions *how = &map->how;
  how->shows_sources &= how->direct == DIRECT_RADIANCE &&
                        map->count[ROLE_DIRECT] &&
                        !(map->chosen >> ROLE_EMISSION & 1);
  for (size_t c = 0; how->shows_sources && c < 3; c++)
    snprintf(map->names[ROLE_EMISSION][c], sizeof *map->names[ROLE_EMISSION],
             "in %s", role_name(ROLE_DIRECT));
  if (how->shows_sources)
    map->count[ROLE_EMISSION] = 3;
  else
    how->unsure &= ~(unsigned)UNSURE_LAMPS;
}

/* Guesses the passes by their names. */
static int find_passes(const char *path, const image *header,
                       const source_options *options, channel_map *out,
                       image_error *error) {
  const source_info *source = &source_table[out->kind];
  view_layer from;
  if (options->source < 0 && !options->map && out->kind == DUMP_PLAIN &&
      recognise_karma(header))
    return image_fail(error,
                      "%s: is of Houdini's Karma, whose names and units hbil "
                      "doesn't know; --map depth=LAYER,normal=LAYER,"
                      "albedo=LAYER,direct=directdiffuse and --direct radiance "
                      "are needed",
                      path);
  if (source->in_files)
    return output_files_take(path, header, source->passes, out, error);
  if (options->source < 0 && out->kind == DUMP_PLAIN &&
      output_files_check(path, error) != 0)
    return -1;
  if (view_layer_choose(path, header, options, out, &from, error) != 0)
    return -1;
  take_passes(header, &from, source->passes, out);
  return 0;
}

int channel_map_read(const char *path, const image *header,
                     const source_options *options, channel_map *out,
                     image_error *error) {
  channel_map_init(out, options->source >= 0 ? (dump_kind)options->source
                                             : recognise_source(path, header));
  for (int r = 0; r < ROLE_COUNT; r++)
    channel_map_encode(out, (role)r, header);
  out->how = source_conventions(out->kind, options);
  if (out->kind == DUMP_PLAIN && recognise_own_channels(header))
    out->how.unsure = 0;
  if (find_passes(path, header, options, out, error) != 0 ||
      (options->map &&
       chosen_passes_take(path, header, options->map, out, error) != 0)) {
    channel_map_free(out);
    return -1;
  }
  if (out->how.from_depth)
    out->count[ROLE_NORMAL] = 0;
  background_as_emission(out);
  choose_depth(options, out);
  take_sources(out);
  out->unnamed = image_find(header, "ch00") != NULL;
  out->is_beauty = is_beauty(out);
  for (int r = 0; r < ROLE_COUNT; r++) {
    if (options->gamma >= 0) /* light that is floats is never sRGB */
      out->gamma[r] = options->gamma && (r == ROLE_ALBEDO || !out->floats[r]);
    if (out->count[r] || out->chosen >> r & 1)
      *out->lacks[r] = '\0';
  }
  out->data = out->window = image_data_window(header);
  out->display = image_display_window(header);
  return 0;
}
