/* Chooses one of several pictures in a file. */
#include "dump/view_layer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A view layer of a file: the text in front of its passes' names, with its dot,
 * and the roles for which it has passes. */
typedef struct candidate {
  char before[256];
  unsigned roles;
} candidate;

typedef struct candidates {
  candidate *list; /* owned */
  size_t count;
} candidates;

/* The length of a channel's name without its last part, and without the eye in
 * front of that. */
static size_t group_length(const image *header, const char *channel) {
  const char *dot = strrchr(channel, '.');
  const size_t group = dot ? (size_t)(dot - channel) : 0;
  for (size_t i = 0; i < header->view_count; i++) {
    const size_t eye = strlen(header->views[i]);
    if (group > eye + 1 && channel[group - eye - 1] == '.' &&
        memcmp(channel + group - eye, header->views[i], eye) == 0)
      return group - eye - 1;
  }
  return group;
}

/* If the first `length` characters of a channel's name are a view layer and
 * the pass, returns 1 and the length of the view layer's part. */
static int ends_in_pass(const char *channel, size_t length, const char *pass,
                        size_t *before) {
  const size_t own = strlen(pass);
  if (!own || length < own || memcmp(channel + length - own, pass, own) != 0)
    return 0;
  *before = length - own;
  return *before == 0 || channel[*before - 1] == '.';
}

/* Adds the roles to the candidate of that name, which is made if it is new.
 * Returns -1 if memory runs out. */
static int add(candidates *c, const char *channel, size_t before, role r) {
  size_t i = 0;
  if (before >= sizeof c->list->before)
    return 0;
  while (i < c->count && (strlen(c->list[i].before) != before ||
                          memcmp(c->list[i].before, channel, before) != 0))
    i++;
  if (i == c->count) {
    candidate *grown = realloc(c->list, (c->count + 1) * sizeof *grown);
    if (!grown)
      return -1;
    c->list = grown;
    memset(&c->list[c->count], 0, sizeof *c->list);
    memcpy(c->list[c->count++].before, channel, before);
  }
  c->list[i].roles |= 1u << r;
  return 0;
}

/* Blender's "Composite" is a finished picture and no view layer. */
static void drop_pictures(candidates *c) {
  const unsigned picture = 1u << ROLE_PICTURE | 1u << ROLE_ALPHA;
  size_t count = 0;
  for (size_t i = 0; i < c->count; i++)
    if (c->list[i].roles & ~picture)
      c->list[count++] = c->list[i];
  c->count = count;
}

/* All view layers of the file.  Returns -1 if memory runs out. */
static int find(const image *header, const pass_name *passes, candidates *out) {
  size_t before = 0;
  memset(out, 0, sizeof *out);
  for (size_t i = 0; i < header->count; i++) {
    const char *channel = header->planes[i].name;
    const size_t length = group_length(header, channel);
    for (const pass_name *p = passes; p->pass; p++)
      if (ends_in_pass(channel, length, p->pass, &before) &&
          add(out, channel, before, p->role) != 0)
        return -1;
  }
  drop_pictures(out);
  return 0;
}

int view_layer_exists(const image *header, dump_kind kind) {
  candidates all;
  const int there =
      find(header, source_table[kind].passes, &all) == 0 && all.count > 0;
  free(all.list);
  return there;
}

/* The names of view layers, with commas. */
static void list_layers(const candidates *all, char *text, size_t size) {
  size_t used = 0;
  text[0] = '\0';
  for (size_t i = 0; i < all->count && used < size; i++) {
    const size_t length = strlen(all->list[i].before);
    used += (size_t)snprintf(text + used, size - used, "%s%.*s", i ? ", " : "",
                             length ? (int)length - 1 : 0, all->list[i].before);
  }
}

static unsigned count_bits(unsigned set) {
  unsigned count = 0;
  for (; set; set &= set - 1)
    count++;
  return count;
}

/* The view layer with the most roles; depth counts more than all others. */
static size_t richest(const candidates *all) {
  size_t best = 0;
  unsigned most = 0;
  for (size_t i = 0; i < all->count; i++) {
    const unsigned roles = all->list[i].roles;
    const unsigned worth =
        count_bits(roles) + (roles >> ROLE_DEPTH & 1 ? ROLE_COUNT : 0);
    if (worth > most) {
      most = worth;
      best = i;
    }
  }
  return best;
}

/* The view layer of that name, or all->count. */
static size_t named(const candidates *all, const char *name) {
  const size_t length = strlen(name);
  size_t i = 0;
  while (i < all->count && !(strlen(all->list[i].before) == length + 1 &&
                             !memcmp(all->list[i].before, name, length)))
    i++;
  return i;
}

static int choose_layer(const char *path, const candidates *all,
                        const char *wanted, channel_map *map, view_layer *out,
                        image_error *error) {
  char names[200];
  list_layers(all, names, sizeof names);
  const size_t taken = wanted ? named(all, wanted) : richest(all);
  if (wanted && taken == all->count)
    return image_fail(error, "%s: has no view layer %s; %s%s is needed", path,
                      wanted, names[0] ? "one of " : "a file with view layers",
                      names);
  /* only Blender's files have view layers without being asked */
  if (taken == all->count || (!wanted && map->kind != DUMP_CYCLES))
    return 0;
  snprintf(out->before, sizeof out->before, "%s", all->list[taken].before);
  if (!wanted && all->count > 1)
    snprintf(map->picked[0], sizeof map->picked[0],
             "view layer %.*s is read, of %s (--view-layer)",
             (int)strlen(out->before) - 1, out->before, names);
  return 0;
}

static void list_eyes(const image *header, char *text, size_t size) {
  size_t used = 0;
  text[0] = '\0';
  for (size_t i = 0; i < header->view_count && used < size; i++)
    used += (size_t)snprintf(text + used, size - used, "%s%s", i ? ", " : "",
                             header->views[i]);
}

static int choose_eye(const char *path, const image *header, const char *wanted,
                      channel_map *map, view_layer *out, image_error *error) {
  char names[160];
  size_t i = 0;
  list_eyes(header, names, sizeof names);
  while (wanted && i < header->view_count &&
         strcmp(wanted, header->views[i]) != 0)
    i++;
  if (wanted && i == header->view_count)
    return image_fail(error, "%s: has no eye %s; %s%s is needed", path, wanted,
                      names[0] ? "one of " : "a multi-view file", names);
  if (!header->view_count)
    return 0;
  snprintf(out->behind, sizeof out->behind, ".%s", header->views[i]);
  out->plain = i == 0;
  if (!wanted && header->view_count > 1)
    snprintf(map->picked[1], sizeof map->picked[1],
             "eye %s is read, of %s (--eye)", header->views[0], names);
  return 0;
}

int view_layer_choose(const char *path, const image *header,
                      const source_options *options, channel_map *map,
                      view_layer *out, image_error *error) {
  candidates all;
  memset(out, 0, sizeof *out);
  int failed = find(header, source_table[map->kind].passes, &all) != 0
                   ? image_no_memory(error, path)
                   : 0;
  if (!failed)
    failed =
        choose_layer(path, &all, options->view_layer, map, out, error) != 0 ||
        choose_eye(path, header, options->eye, map, out, error) != 0;
  free(all.list);
  return failed ? -1 : 0;
}
