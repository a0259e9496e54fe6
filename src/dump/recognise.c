/* Recognises by a file's header which program wrote the dump. */
#include "dump/recognise.h"

#include "dump/output_files.h"
#include "dump/view_layer.h"
#include "image/image.h"

#include <string.h>

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

/* The pass of its direct diffuse light has this name by default, and those of
 * other programs that have it are written with capitals (RenderMan). */
int recognise_karma(const image *header) {
  if (strstr(header->origin, "Karma") || strstr(header->origin, "karma"))
    return 1;
  for (size_t i = 0; i < header->count; i++)
    if (strncmp(header->planes[i].name, "directdiffuse", 13) == 0)
      return 1;
  return 0;
}

/* Marks come first: the pass names of other programs may also be hbil's. */
dump_kind recognise_source(const char *path, const image *header) {
  for (int k = DUMP_CYCLES; k < DUMP_KINDS; k++)
    if (has_mark(header, (dump_kind)k))
      return (dump_kind)k;
  if (recognise_own_channels(header))
    return DUMP_PLAIN;
  if (view_layer_exists(header, DUMP_CYCLES))
    return DUMP_CYCLES;
  return output_files_recognise(path);
}
