/* The two images of `hbil compare`, and which of their channels are compared.
 */
#define _POSIX_C_SOURCE 200809L
#include "tool/compare_sides.h"

#include "image/image_read.h"
#include "image/signature.h"
#include "image/srgb.h"
#include "image/window.h"
#include "tool/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ------------------------------------------------------------------------ */
/* Which channels the name of a layer stands for                             */

/* How well a name fits, the best last. */
typedef enum fit { FIT_NONE = 0, FIT_PART, FIT_END, FIT_WHOLE } fit;

/* A layer or a channel: the first `length` characters of a channel's name. */
typedef struct unit {
  const char *name;
  size_t length;
} unit;

const char *channel_letter(const char *channel) {
  const char *dot = strrchr(channel, '.');
  return dot ? dot + 1 : channel;
}

/* The layer of a channel; length 0: it has none. */
static unit layer_of(const char *channel) {
  const char *dot = strrchr(channel, '.');
  return (unit){channel, dot ? (size_t)(dot - channel) : 0};
}

static int is_same(unit a, unit b) {
  return a.length == b.length && memcmp(a.name, b.name, a.length) == 0;
}

/* Parts end at dots. */
static fit fit_of(unit u, const char *wanted) {
  const size_t own = strlen(wanted);
  fit best = FIT_NONE;
  for (size_t begin = 0; own && begin + own <= u.length; begin++) {
    const size_t end = begin + own;
    if ((begin > 0 && u.name[begin - 1] != '.') ||
        (end < u.length && u.name[end] != '.') ||
        memcmp(u.name + begin, wanted, own) != 0)
      continue;
    const fit found = end < u.length ? FIT_PART
                      : begin > 0    ? FIT_END
                                     : FIT_WHOLE;
    best = found > best ? found : best;
  }
  return best;
}

/* What of a channel the name fits: its layer, or else the channel itself, of
 * which the end must fit. */
static fit fit_of_channel(const char *channel, const char *wanted, unit *out) {
  const unit whole = {channel, strlen(channel)};
  const fit layer = fit_of(layer_of(channel), wanted);
  const fit own = fit_of(whole, wanted);
  const int alone = own >= FIT_END && own > layer;
  *out = alone ? whole : layer_of(channel);
  return alone ? own : layer;
}

static fit best_fit(const image *header, const char *wanted) {
  fit best = FIT_NONE;
  for (size_t i = 0; i < header->count; i++) {
    unit u;
    const fit found = fit_of_channel(header->planes[i].name, wanted, &u);
    best = found > best ? found : best;
  }
  return best;
}

/* Adds a name to a list with commas; it ends in "..." where there is no more
 * room. */
static void add_name(char *list, size_t size, unit u) {
  const size_t used = strlen(list);
  if (used + u.length + sizeof ", ..., " < size)
    snprintf(list + used, size - used, "%s%.*s", used ? ", " : "",
             (int)u.length, u.name);
  else if (used >= 3 && strcmp(list + used - 3, "...") != 0)
    snprintf(list + used, size - used, ", ...");
}

/* What of the i-th channel belongs to a list of names: its layer, or the whole
 * channel if it has none, unless a channel before had the same. */
static int is_new(const image *header, size_t i, unit *out) {
  const char *name = header->planes[i].name;
  *out = layer_of(name);
  for (size_t k = 0; k < i && out->length; k++)
    if (is_same(layer_of(header->planes[k].name), *out))
      return 0;
  if (!out->length)
    out->length = strlen(name);
  return 1;
}

static int report_missing(const char *path, const image *header,
                          const char *wanted, image_error *error) {
  char there[1024] = "";
  unit u;
  for (size_t i = 0; i < header->count; i++)
    if (is_new(header, i, &u))
      add_name(there, sizeof there, u);
  return *wanted ? image_fail(error, "%s: has no layer %s; one of %s is needed",
                              path, wanted, there)
                 : image_fail(error,
                              "%s: has no channels without a layer; one of %s "
                              "is needed",
                              path, there);
}

/* Takes the channels of one unit.  Returns -1 if there are several, and lists
 * them. */
static int take(const image *header, const char *wanted, fit best,
                const char **out, size_t *count, char *several, size_t size) {
  unit first = {NULL, 0}, last = {NULL, 0};
  int failed = 0;
  for (size_t i = 0; i < header->count; i++) {
    const char *name = header->planes[i].name;
    unit u;
    if (fit_of_channel(name, wanted, &u) != best)
      continue;
    if (!first.name)
      first = u;
    if (!last.name || !is_same(last, u))
      add_name(several, size, u);
    last = u;
    failed |= !is_same(first, u);
    /* a channel that is named itself may be an alpha */
    if (u.length == strlen(name) || strcmp(channel_letter(name), "A") != 0)
      out[(*count)++] = name;
  }
  return failed ? -1 : 0;
}

/* Writes the names of the channels that `wanted` stands for
 * (compare_side.layer) to out, which has room for header->count, and their
 * number to *count.  The alpha of a layer is coverage, and left out.  Returns
 * 0, or -1 with `error` filled if the name stands for nothing or for several
 * layers. */
static int select_layer(const char *path, const image *header,
                        const char *wanted, const char **out, size_t *count,
                        image_error *error) {
  char several[512] = "";
  *count = 0;
  for (size_t i = 0; i < header->count && (!wanted || !*wanted); i++) {
    const char *name = header->planes[i].name;
    if (!wanted || (!strchr(name, '.') && strcmp(name, "A") != 0))
      out[(*count)++] = name;
  }
  if (!wanted && *count == 0)
    return image_fail(error, "%s: has no channels", path);
  if (wanted && *wanted) {
    const fit best = best_fit(header, wanted);
    if (best != FIT_NONE &&
        take(header, wanted, best, out, count, several, sizeof several) != 0)
      return image_fail(error,
                        "%s: %s is the name of several layers; one of %s is "
                        "needed",
                        path, wanted, several);
  }
  return *count ? 0 : report_missing(path, header, wanted, error);
}

/* ------------------------------------------------------------------------ */
/* The two images                                                            */

/* An existing file is taken as it is, even if its name has a colon. */
static int name_side(const char *argument, compare_side *out,
                     image_error *error) {
  const char *colon = strrchr(argument, ':');
  out->path = strdup(argument);
  if (!out->path)
    return image_no_memory(error, argument);
  if (colon && colon > argument && access(argument, F_OK) != 0) {
    out->path[colon - argument] = '\0';
    out->layer = colon + 1;
  }
  return 0;
}

int compare_sides_name(const char *first, const char *second, compare_side *a,
                       compare_side *b, image_error *error) {
  memset(a, 0, sizeof *a);
  memset(b, 0, sizeof *b);
  return name_side(first, a, error) != 0 || name_side(second, b, error) != 0
             ? -1
             : 0;
}

void compare_side_free(compare_side *s) {
  image_free(&s->header);
  image_free(&s->planes);
  free(s->path);
}

/* Colours in sRGB encoding become linear, as all others are. */
static void make_linear(image *planes) {
  const size_t pixels = (size_t)planes->width * planes->height;
  for (size_t i = 0; i < planes->count; i++)
    if (strcmp(channel_letter(planes->planes[i].name), "A") != 0)
      for (size_t k = 0; k < pixels; k++)
        planes->planes[i].pixels[k] =
            linear_of_srgb(planes->planes[i].pixels[k]);
}

static int read_side(compare_side *s, const char **selected,
                     image_error *error) {
  size_t count;
  if (select_layer(s->path, &s->header, s->layer, selected, &count, error) !=
          0 ||
      image_read(s->path, selected, count, &s->planes, error) != 0)
    return -1;
  if (s->header.gamma)
    make_linear(&s->planes);
  return 0;
}

const image_plane *compare_partner(const compare_side *a, const compare_side *b,
                                   const char *name) {
  if (a->planes.count == 1 && b->planes.count == 1)
    return &b->planes.planes[0];
  if (!a->layer && !b->layer)
    return image_find(&b->planes, name);
  for (size_t i = 0; i < b->planes.count; i++)
    if (strcmp(channel_letter(b->planes.planes[i].name),
               channel_letter(name)) == 0)
      return &b->planes.planes[i];
  return NULL;
}

static int is_same_window(image_window a, image_window b) {
  return memcmp(&a, &b, sizeof a) == 0;
}

/* Whether both have the coordinates of one picture: its whole, parts of it, or
 * pixels around it.  Of pictures that begin at one corner but show different
 * windows, one may as well have larger pixels than the other. */
static int have_one_picture(const image *a, const image *b) {
  const image_window common =
      image_window_common(image_data_window(a), image_data_window(b));
  return is_same_window(image_display_window(a), image_display_window(b)) ||
         ((a->x != b->x || a->y != b->y) &&
          (is_same_window(common, image_data_window(a)) ||
           is_same_window(common, image_data_window(b))));
}

/* Leaves these pixels of a picture alone. */
static int take_part(const char *path, image *planes, image_window part,
                     image_error *error) {
  for (size_t i = 0; i < planes->count; i++) {
    float *pixels = malloc((size_t)part.width * part.height * sizeof(float));
    if (!pixels)
      return image_no_memory(error, path);
    image_place(planes->planes[i].pixels, image_data_window(planes), pixels,
                part);
    free(planes->planes[i].pixels);
    planes->planes[i].pixels = pixels;
  }
  planes->display = image_display_window(planes);
  planes->x = part.x;
  planes->y = part.y;
  planes->width = part.width;
  planes->height = part.height;
  return 0;
}

/* Compares the pixels that both have, where files of EXR have different parts
 * of one picture, and tells what differs.  Other formats have no windows. */
static int align(compare_side *a, compare_side *b, image_error *error) {
  const image_window own = image_data_window(&a->planes);
  const image_window other = image_data_window(&b->planes);
  const image_window common = image_window_common(own, other);
  char text[160];
  if (is_same_window(own, other) ||
      signature_of_file(a->path) != FILE_FORMAT_EXR ||
      signature_of_file(b->path) != FILE_FORMAT_EXR)
    return 0;
  if (have_one_picture(&a->planes, &b->planes)) {
    if (!common.width)
      return image_fail(error,
                        "%s: none of its pixels are in the data window of %s; "
                        "images with common pixels are needed",
                        a->path, b->path);
    snprintf(text, sizeof text,
             "only its %u x %u pixels at %d, %d are compared, which are in "
             "both data windows",
             common.width, common.height, common.x, common.y);
    report_note(a->path, "", text);
    return take_part(a->path, &a->planes, common, error) != 0 ||
                   take_part(b->path, &b->planes, common, error) != 0
               ? -1
               : 0;
  }
  if (own.width != other.width || own.height != other.height)
    return 0; /* which check_fit() rejects */
  snprintf(text, sizeof text,
           "its pixels are at %d, %d, and those of the other image at %d, %d; "
           "they are compared as if they were at one place",
           own.x, own.y, other.x, other.y);
  report_note(a->path, "warning: ", text);
  return 0;
}

static int check_fit(const compare_side *a, const compare_side *b,
                     image_error *error) {
  if (a->planes.width != b->planes.width ||
      a->planes.height != b->planes.height)
    return image_fail(error,
                      "%s: %u x %u pixels, but %s has %u x %u; images of one "
                      "size are needed",
                      a->path, a->planes.width, a->planes.height, b->path,
                      b->planes.width, b->planes.height);
  if (a->planes.count != b->planes.count)
    return image_fail(error,
                      "%s: %zu channels, but %s has %zu; FILE:LAYER with the "
                      "same channels on both sides is needed",
                      a->path, a->planes.count, b->path, b->planes.count);
  for (size_t i = 0; i < a->planes.count; i++)
    if (!compare_partner(a, b, a->planes.planes[i].name))
      return image_fail(error,
                        "%s: channel %s has no partner in %s; layers with the "
                        "same channels are needed",
                        a->path, a->planes.planes[i].name, b->path);
  return 0;
}

static int has_root(const image *header) {
  for (size_t i = 0; i < header->count; i++)
    if (!strchr(header->planes[i].name, '.'))
      return 1;
  return 0;
}

/* A single layer is meant for both files, unless the other one has no such
 * layer, but channels without any. */
static void share_layer(compare_side *a, compare_side *b) {
  compare_side *without = a->layer ? b : a;
  const char *layer = a->layer ? a->layer : b->layer;
  if (!a->layer == !b->layer)
    return;
  without->layer = best_fit(&without->header, layer) != FIT_NONE ||
                           !has_root(&without->header)
                       ? layer
                       : "";
}

int compare_sides_read(compare_side *a, compare_side *b, image_error *error) {
  if (image_read_header(a->path, &a->header, error) != 0 ||
      image_read_header(b->path, &b->header, error) != 0)
    return -1;
  const char **selected =
      calloc(a->header.count + b->header.count + 1, sizeof *selected);
  if (!selected)
    return image_no_memory(error, a->path);
  share_layer(a, b);
  const int failed =
      read_side(a, selected, error) != 0 || read_side(b, selected, error) != 0;
  free(selected);
  return failed || align(a, b, error) != 0 ? -1 : check_fit(a, b, error);
}
