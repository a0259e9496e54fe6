#include "image/exr_channels.h"
#include "image/error.h"

#include <stdio.h>
#include <string.h>

enum { NAME_SIZE = sizeof((image_plane *)0)->name };

static void qualified_name(const exr_file *f, int part, const char *channel,
                           char name[NAME_SIZE]) {
  const char *part_name = NULL;
  if (exr_get_name(f->context, part, &part_name) != EXR_ERR_SUCCESS ||
      !part_name)
    part_name = "";
  snprintf(name, NAME_SIZE, "%s.%s", part_name, channel);
}

static image_type type_of(const exr_attr_chlist_entry_t *entry) {
  return entry->pixel_type == EXR_PIXEL_UINT   ? IMAGE_UINT
         : entry->pixel_type == EXR_PIXEL_HALF ? IMAGE_HALF
                                               : IMAGE_FLOAT;
}

static int list_part(const exr_file *f, int part, image *out) {
  const exr_attr_chlist_t *channels = exr_file_channels(f, part);
  for (int i = 0; channels && i < channels->num_channels; i++) {
    char name[NAME_SIZE];
    const char *plain = channels->entries[i].name.str;
    snprintf(name, sizeof name, "%s", plain);
    if (image_find(out, name) || (part > 0 && !strchr(plain, '.')))
      qualified_name(f, part, plain, name);
    if (image_find(out, name))
      continue;
    image_plane *plane = image_declare(out, name);
    if (!plane)
      return image_no_memory(f->error, f->stream.path);
    plane->type = type_of(&channels->entries[i]);
  }
  return 0;
}

int exr_channels_list(const exr_file *f, image *out) {
  int failed = 0;
  for (int part = 0; part < f->parts && !failed; part++)
    failed = list_part(f, part, out);
  return failed;
}

/* Returns the index of the channel in the part's list, or -1. */
static int find_in_part(const exr_file *f, int part, const char *wanted,
                        int qualified) {
  const exr_attr_chlist_t *channels = exr_file_channels(f, part);
  for (int i = 0; channels && i < channels->num_channels; i++) {
    char name[NAME_SIZE];
    const char *plain = channels->entries[i].name.str;
    snprintf(name, sizeof name, "%s", plain);
    if (qualified)
      qualified_name(f, part, plain, name);
    if (strcmp(name, wanted) == 0)
      return i;
  }
  return -1;
}

int exr_channels_find(const exr_file *f, const char *name, exr_source *out) {
  /* A channel's own name takes precedence in all parts. */
  for (int qualified = 0; qualified < 2; qualified++)
    for (int part = 0; part < f->parts; part++) {
      const int i = find_in_part(f, part, name, qualified);
      if (i < 0)
        continue;
      const exr_attr_chlist_entry_t *entry =
          &exr_file_channels(f, part)->entries[i];
      if (entry->x_sampling != 1 || entry->y_sampling != 1)
        return image_fail(f->error,
                          "%s: channel %s is subsampled; a value "
                          "for every pixel is needed",
                          f->stream.path, name);
      *out = (exr_source){part, i, type_of(entry)};
      return 0;
    }
  return image_fail(f->error, "%s: has no channel %s (see hbil info)",
                    f->stream.path, name);
}
