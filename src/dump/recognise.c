/* Recognises by a file's header which program wrote the dump. */
#include "dump/recognise.h"

#include "dump/output_files.h"
#include "image/image.h"

#include <string.h>

/* If the channel belongs to the pass, writes the view layer in front of it
 * ("ViewLayer." or "") to prefix and returns 1. */
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

int recognise_view_layer(const image *header, char *prefix, size_t size) {
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

int recognise_own_channels(const image *header) {
  static const char *const names[] = {"depth.Z",    "normal.X",   "albedo.R",
                                      "direct.R",   "emission.R", "motion.X",
                                      "position.X", NULL};
  for (const char *const *name = names; *name; name++)
    if (image_find(header, *name))
      return 1;
  return 0;
}

/* Marks come first: the pass names of other programs may also be hbil's. */
dump_kind recognise_source(const char *path, const image *header) {
  char prefix[256];
  for (int k = DUMP_CYCLES; k < DUMP_KINDS; k++)
    if (has_mark(header, (dump_kind)k))
      return (dump_kind)k;
  if (recognise_own_channels(header))
    return DUMP_PLAIN;
  if (recognise_view_layer(header, prefix, sizeof prefix))
    return DUMP_CYCLES;
  return output_files_recognise(path);
}
