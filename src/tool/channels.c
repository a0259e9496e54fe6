/* Which channel is what, in the frame's own file and in others beside it. */
#define _POSIX_C_SOURCE 200809L
#include "tool/tool.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

const char *role_name(role r) {
  static const char *const names[ROLE_COUNT] = {
      "depth",    "normal",     "albedo", "direct",
      "emission", "background", "motion", "position"};
  return names[r];
}

const char *dump_kind_name(dump_kind kind) {
  return source_table[kind].about;
}

static size_t role_channels(role r) {
  return r == ROLE_DEPTH ? 1 : r == ROLE_MOTION ? 2 : 3;
}

static int is_colour(role r) {
  return r == ROLE_ALBEDO || r == ROLE_DIRECT || r == ROLE_EMISSION ||
         r == ROLE_BACKGROUND;
}

/* ------------------------------------------------------------------------ */
/* A layer's channels                                                        */

/* What the components of a layer are called, for one, two and three. */
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

/* Fills the role's names if the file has LAYER.LETTER for all of the set; "" is
 * no layer. */
static int take_set(const image *header, const char *group,
                    const char *const *set, role r, channel_map *out) {
  const size_t count = letter_count(set);
  char names[ROLE_CHANNELS][256];
  for (size_t i = 0; i < count; i++) {
    const int length = snprintf(names[i], sizeof names[i], "%s%s%s", group,
                                *group ? "." : "", set[i]);
    if (length >= (int)sizeof names[i] || !image_find(header, names[i]))
      return 0;
  }
  memcpy(out->names[r], names, count * sizeof *names);
  out->count[r] = count;
  return 1;
}

/* One channel by its whole name; a grey one is three of a colour. */
static int take_channel(const image *header, const char *name, role r,
                        channel_map *out) {
  const size_t count = role_channels(r);
  if ((count > 1 && !is_colour(r)) || !image_find(header, name))
    return 0;
  for (size_t i = 0; i < count; i++)
    snprintf(out->names[r][i], sizeof *out->names[r], "%s", name);
  out->count[r] = count;
  return 1;
}

static int take_layer(const image *header, const char *group, role r,
                      channel_map *out) {
  if (role_channels(r) == 1 && take_channel(header, group, r, out))
    return 1;
  for (size_t i = 0; i < sizeof letters / sizeof *letters; i++)
    if (letter_count(letters[i]) == role_channels(r) &&
        take_set(header, group, letters[i], r, out))
      return 1;
  return 0;
}

/* The first channel that ends so. */
static int take_ending(const image *header, const char *ending, role r,
                       channel_map *out) {
  const size_t length = strlen(ending);
  for (size_t i = 0; i < header->count; i++) {
    const char *name = header->planes[i].name;
    const size_t whole = strlen(name);
    if (whole > length && strcmp(name + whole - length, ending) == 0)
      return take_channel(header, name, r, out);
  }
  return 0;
}

static void take_passes(const image *header, const char *prefix,
                        const pass_name *passes, channel_map *out) {
  for (; passes->pass; passes++) {
    char group[256];
    const int length =
        snprintf(group, sizeof group, "%s%s", prefix, passes->pass);
    if (out->count[passes->role] || length >= (int)sizeof group)
      continue;
    if (passes->pass[0] == '*')
      take_ending(header, passes->pass + 1, passes->role, out);
    else
      take_layer(header, group, passes->role, out);
  }
}

/* ------------------------------------------------------------------------ */
/* Whose dump it is                                                          */

/* The view layer ("ViewLayer." or "") of a channel that belongs to the pass. */
static int view_layer(const char *channel, const char *pass, char *prefix,
                      size_t size) {
  const char *dot = strrchr(channel, '.');
  const size_t length = strlen(pass);
  const size_t group = dot ? (size_t)(dot - channel) : 0;
  if (group < length)
    return 0;
  const size_t start = group - length;
  if (strncmp(channel + start, pass, length) != 0 ||
      (start > 0 && channel[start - 1] != '.') || start >= size)
    return 0;
  memcpy(prefix, channel, start);
  prefix[start] = '\0';
  return 1;
}

/* The first view layer with depth, or with whatever comes next in the list:
 * passes of different view layers are never mixed. */
static int find_view_layer(const image *header, char *prefix, size_t size) {
  for (const pass_name *pass = source_table[DUMP_CYCLES].passes; pass->pass;
       pass++)
    for (size_t i = 0; i < header->count; i++)
      if (view_layer(header->planes[i].name, pass->pass, prefix, size))
        return 1;
  prefix[0] = '\0';
  return 0;
}

static int has_mark(const image *header, dump_kind kind) {
  const char *const *mark = source_table[kind].marks;
  for (; mark && *mark; mark++) {
    if (strstr(header->origin, *mark))
      return 1;
    for (size_t i = 0; i < header->count; i++)
      if (strstr(header->planes[i].name, *mark))
        return 1;
  }
  return 0;
}

/* Channels that hbil writes itself, by which its own dumps are known. */
static int is_own(const image *header) {
  static const char *const names[] = {"depth.Z",    "normal.X",   "albedo.R",
                                      "direct.R",   "emission.R", "motion.X",
                                      "position.X", NULL};
  for (const char *const *name = names; *name; name++)
    if (image_find(header, *name))
      return 1;
  return 0;
}

/* Marks first: other programs' names may be some of ours, too. */
static dump_kind guess(const image *header) {
  char prefix[256];
  for (int k = DUMP_CYCLES; k < DUMP_KINDS; k++)
    if (has_mark(header, (dump_kind)k))
      return (dump_kind)k;
  if (is_own(header))
    return DUMP_PLAIN;
  return find_view_layer(header, prefix, sizeof prefix) ? DUMP_CYCLES
                                                        : DUMP_PLAIN;
}

/* A background without emission takes its place: both are light that the eye
 * sees as it is. */
static void background_as_emission(channel_map *map) {
  if (map->count[ROLE_EMISSION] || !map->count[ROLE_BACKGROUND])
    return;
  memcpy(map->names[ROLE_EMISSION], map->names[ROLE_BACKGROUND],
         sizeof map->names[ROLE_EMISSION]);
  map->count[ROLE_EMISSION] = map->count[ROLE_BACKGROUND];
  map->gamma[ROLE_EMISSION] = map->gamma[ROLE_BACKGROUND];
  map->files[ROLE_EMISSION] = map->files[ROLE_BACKGROUND];
  map->files[ROLE_BACKGROUND] = NULL;
  map->count[ROLE_BACKGROUND] = 0;
}

/* Whether a text has one of the words that finished pictures are called by. */
static int names_beauty(const char *text) {
  static const char *const words[] = {"combined", "beauty", "finalimage",
                                      "rgba", NULL};
  for (; *text; text++)
    for (const char *const *word = words; *word; word++)
      if (strncasecmp(text, *word, strlen(*word)) == 0)
        return 1;
  return 0;
}

/* Whether direct light is by its name a finished picture: that is also what
 * channels without a layer are, in a file of many. */
static int is_beauty(const channel_map *map) {
  const char *file = map->files[ROLE_DIRECT];
  const char *name = map->names[ROLE_DIRECT][0];
  const char *slash = file ? strrchr(file, '/') : NULL;
  if (!map->count[ROLE_DIRECT])
    return 0;
  if (file && names_beauty(slash ? slash + 1 : file))
    return 1;
  return names_beauty(name) || (!file && !strchr(name, '.'));
}

/* ------------------------------------------------------------------------ */
/* --map                                                                     */

/* The last number in a frame's name, for # in the names of other files. */
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

/* The file of a pass beside a frame: # (or a run of them) is its number. */
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

/* Whether a value of --map is a file as a whole. */
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
  if (take_layer(header, group, r, out) || take_channel(header, group, r, out))
    return 0;
  /* a file of its own may have but one channel, whatever its name */
  if (!*group && header->count > 0 &&
      take_channel(header, header->planes[0].name, r, out))
    return 0;
  return image_fail(error,
                    "--map %s=%s: %s has no such layer of %zu channel%s (see "
                    "hbil info)",
                    role_name(r), group, path, role_channels(r),
                    role_channels(r) == 1 ? "" : "s");
}

/* A pass in a file of its own. */
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

/* ROLE=[FILE:]LAYER */
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
                      "position",
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

static int take_words(const char *frame, const image *header, const char *map,
                      channel_map *out, image_error *error) {
  char *words = strdup(map), *rest = NULL;
  int failed = words ? 0 : image_no_memory(error, frame);
  for (char *word = words ? strtok_r(words, ",", &rest) : NULL; word && !failed;
       word = strtok_r(NULL, ",", &rest))
    failed = take_word(frame, header, word, out, error);
  free(words);
  return failed;
}

/* ------------------------------------------------------------------------ */
/* Both together                                                             */

void channels_init(channel_map *out, dump_kind kind) {
  memset(out, 0, sizeof *out);
  out->kind = kind;
  out->how = source_table[kind].how;
}

/* The user's words overrule the table. */
static void apply(const source_options *o, conventions *how) {
  if (o->depth >= 0) {
    how->depth = (depth_kind)o->depth;
    how->unsure &= ~(unsigned)UNSURE_DEPTH;
  }
  if (o->normals >= 0) {
    if (how->normals != (dump_space)o->normals)
      how->flips = 0; /* those of the source are for its own space */
    how->normals = (dump_space)o->normals;
  }
  if (o->positions >= 0)
    how->positions = (dump_space)o->positions;
  if (o->encoded >= 0) {
    how->encoded = o->encoded;
    how->unsure &= ~(unsigned)UNSURE_NORMALS;
  }
  if (o->direct >= 0)
    how->direct = (direct_kind)o->direct;
  how->flips ^= o->flips;
  if (o->unit > 0.0f)
    how->unit = (double)o->unit;
  if (!isnan(o->background)) {
    how->background = o->background != 0.0f ? fabsf(o->background) : INFINITY;
    how->unsure &= ~(unsigned)UNSURE_SKY;
  }
  how->near = (double)o->clip[0];
  how->far = (double)o->clip[1];
  if (o->motion_scale[0] != 0.0f)
    memcpy(how->motion_scale, o->motion_scale, sizeof how->motion_scale);
}

/* Positions stand in for depth that isn't there, and are preferred to one that
 * depends on a near plane. */
static void choose_depth(const source_options *o, channel_map *map) {
  if (o->depth < 0 && map->count[ROLE_POSITION] &&
      (!map->count[ROLE_DEPTH] || map->how.from_near))
    map->how.depth = DEPTH_POSITION;
  if (map->how.depth != DEPTH_POSITION || !map->count[ROLE_POSITION])
    return;
  map->count[ROLE_DEPTH] = 1;
  snprintf(map->names[ROLE_DEPTH][0], sizeof *map->names[ROLE_DEPTH], "from %s",
           role_name(ROLE_POSITION));
}

int channels_map(const char *path, const image *header,
                 const source_options *options, channel_map *out,
                 image_error *error) {
  char prefix[256] = "";
  channels_init(out, options->source >= 0 ? (dump_kind)options->source
                                          : guess(header));
  if (out->kind == DUMP_CYCLES)
    find_view_layer(header, prefix, sizeof prefix);
  if (out->kind == DUMP_PLAIN && is_own(header))
    out->how.unsure = 0;
  for (int r = 0; r < ROLE_COUNT; r++)
    out->gamma[r] = header->gamma;
  take_passes(header, prefix, source_table[out->kind].passes, out);
  apply(options, &out->how);
  if (options->map && take_words(path, header, options->map, out, error) != 0) {
    channels_free(out);
    return -1;
  }
  background_as_emission(out);
  choose_depth(options, out);
  out->is_beauty = is_beauty(out);
  for (int r = 0; r < ROLE_COUNT && options->gamma >= 0; r++)
    out->gamma[r] = options->gamma;
  out->data = out->window = image_data_window(header);
  out->display = image_display_window(header);
  return 0;
}

void channels_free(channel_map *map) {
  for (int r = 0; r < ROLE_COUNT; r++) {
    free(map->files[r]);
    map->files[r] = NULL;
  }
}

static int check_depth(const channel_map *map, const char *path,
                       image_error *error) {
  const int wanted = map->how.depth == DEPTH_POSITION;
  if (map->count[wanted ? ROLE_POSITION : ROLE_DEPTH])
    return 0;
  return image_fail(error,
                    wanted
                        ? "%s: no positions to take depth from; Position, P "
                          "or --map position=LAYER is needed"
                        : "%s: no depth channel; Depth.Z (Blender's Z pass), "
                          "depth.Z or --map depth=CHANNEL is needed",
                    path);
}

int channels_check(const channel_map *map, const char *path,
                   image_error *error) {
  if (check_depth(map, path, error) != 0)
    return -1;
  if (!map->count[ROLE_NORMAL])
    return image_fail(error,
                      "%s: no normals; Normal.{X,Y,Z} (Blender's Normal "
                      "pass), normal.{X,Y,Z} or --map normal=LAYER are needed",
                      path);
  return 0;
}

void channels_conventions(const channel_map *map, hbil_config *config) {
  const conventions *how = &map->how;
  config->projection = map->projection;
  config->depth_kind = HBIL_DEPTH_PLANAR;
  config->normal_space =
      how->normals == SPACE_WORLD ? HBIL_SPACE_WORLD : HBIL_SPACE_VIEW;
  if (convert_is_straight(how) && isfinite(how->background))
    config->sky_depth = how->background;
  config->direct_scale =
      how->direct == DIRECT_IRRADIANCE ? 1.0f : 3.14159265358979f;
  memcpy(config->motion_scale, how->motion_scale, sizeof how->motion_scale);
}
