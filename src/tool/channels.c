/* Which channel is what: Blender's pass names and hbil's own. */
#include "tool/tool.h"

#include <stdio.h>
#include <string.h>

typedef struct pass_name {
  role role;
  const char *pass;
  const char *components;
} pass_name;

/* Behind any or no view layer: "ViewLayer.Depth.Z".  Names up to Blender 4
 * first, then those of Blender 5. */
static const pass_name cycles_passes[] = {
    {ROLE_DEPTH, "Depth", "Z"},      {ROLE_NORMAL, "Normal", "XYZ"},
    {ROLE_ALBEDO, "DiffCol", "RGB"}, {ROLE_ALBEDO, "Diffuse Color", "RGB"},
    {ROLE_DIRECT, "DiffDir", "RGB"}, {ROLE_DIRECT, "Diffuse Direct", "RGB"},
    {ROLE_EMISSION, "Emit", "RGB"},  {ROLE_EMISSION, "Emission", "RGB"},
    {ROLE_BACKGROUND, "Env", "RGB"}, {ROLE_BACKGROUND, "Environment", "RGB"},
    {ROLE_MOTION, "Vector", "XY"},   {ROLE_POSITION, "Position", "XYZ"},
    {ROLE_COUNT, NULL, NULL},
};

static const pass_name plain_passes[] = {
    {ROLE_DEPTH, "depth", "Z"},         {ROLE_NORMAL, "normal", "XYZ"},
    {ROLE_ALBEDO, "albedo", "RGB"},     {ROLE_DIRECT, "direct", "RGB"},
    {ROLE_EMISSION, "emission", "RGB"}, {ROLE_MOTION, "motion", "XY"},
    {ROLE_POSITION, "position", "XYZ"}, {ROLE_COUNT, NULL, NULL},
};

const char *role_name(role r) {
  static const char *const names[ROLE_COUNT] = {
      "depth",    "normal",     "albedo", "direct",
      "emission", "background", "motion", "position"};
  return names[r];
}

const char *dump_kind_name(dump_kind kind) {
  return kind == DUMP_CYCLES ? "Blender Cycles passes" : "hbil's own channels";
}

/* Fills the role if the file has all of the pass's channels. */
static int take_pass(const image *header, const char *prefix,
                     const pass_name *pass, channel_map *out) {
  const size_t count = strlen(pass->components);
  char names[ROLE_CHANNELS][256];
  for (size_t i = 0; i < count; i++) {
    const int length = snprintf(names[i], sizeof names[i], "%s%s.%c", prefix,
                                pass->pass, pass->components[i]);
    if (length >= (int)sizeof names[i] || !image_find(header, names[i]))
      return 0;
  }
  memcpy(out->names[pass->role], names, sizeof names);
  out->count[pass->role] = count;
  return 1;
}

static void take_passes(const image *header, const char *prefix,
                        const pass_name *passes, channel_map *out) {
  for (; passes->pass; passes++)
    if (!out->count[passes->role])
      take_pass(header, prefix, passes, out);
}

/* The view layer ("ViewLayer." or "") of a channel that belongs to the pass. */
static int view_layer(const char *channel, const pass_name *pass, char *prefix,
                      size_t size) {
  char tail[64];
  const int length =
      snprintf(tail, sizeof tail, "%s.%c", pass->pass, pass->components[0]);
  const size_t whole = strlen(channel);
  if (whole < (size_t)length)
    return 0;
  const size_t start = whole - (size_t)length;
  if (strcmp(channel + start, tail) != 0 ||
      (start > 0 && channel[start - 1] != '.') || start >= size)
    return 0;
  memcpy(prefix, channel, start);
  prefix[start] = '\0';
  return 1;
}

/* The first view layer with depth, or with whatever comes next in the list:
 * passes of different view layers are never mixed. */
static void find_view_layer(const image *header, char *prefix, size_t size) {
  for (const pass_name *pass = cycles_passes; pass->pass; pass++)
    for (size_t i = 0; i < header->count; i++)
      if (view_layer(header->planes[i].name, pass, prefix, size))
        return;
  prefix[0] = '\0';
}

/* A background without emission takes its place: both are light that the eye
 * sees as it is. */
static void background_as_emission(channel_map *map) {
  if (map->count[ROLE_EMISSION] || !map->count[ROLE_BACKGROUND])
    return;
  memcpy(map->names[ROLE_EMISSION], map->names[ROLE_BACKGROUND],
         sizeof map->names[ROLE_EMISSION]);
  map->count[ROLE_EMISSION] = map->count[ROLE_BACKGROUND];
  map->count[ROLE_BACKGROUND] = 0;
}

void channels_map(const image *header, channel_map *out) {
  memset(out, 0, sizeof *out);
  out->kind = DUMP_PLAIN;
  take_passes(header, "", plain_passes, out);
  for (int r = 0; r < ROLE_COUNT; r++)
    if (out->count[r])
      return;
  char prefix[256];
  out->kind = DUMP_CYCLES;
  find_view_layer(header, prefix, sizeof prefix);
  take_passes(header, prefix, cycles_passes, out);
  background_as_emission(out);
}

int channels_check(const channel_map *map, const char *path,
                   image_error *error) {
  if (!map->count[ROLE_DEPTH])
    return image_fail(error,
                      "%s: no depth channel; Depth.Z (Blender's Z pass) "
                      "or depth.Z is needed",
                      path);
  if (!map->count[ROLE_NORMAL])
    return image_fail(error,
                      "%s: no normals; Normal.{X,Y,Z} (Blender's Normal "
                      "pass) or normal.{X,Y,Z} are needed",
                      path);
  return 0;
}

void channels_conventions(const channel_map *map, hbil_config *config) {
  const int cycles = map->kind == DUMP_CYCLES;
  config->depth_kind = HBIL_DEPTH_PLANAR;
  config->normal_space = HBIL_SPACE_WORLD;
  if (cycles)
    config->background = 1e9f; /* Cycles writes 1e10 where there is nothing */
  /* DiffDir is irradiance divided by pi. */
  config->direct_scale = cycles ? 3.14159265358979f : 1.0f;
  /* Vector's y runs up. */
  config->motion_scale[0] = 1.0f;
  config->motion_scale[1] = cycles ? -1.0f : 1.0f;
}
