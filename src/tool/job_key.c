/* Keys: what a result was made from, as one number. */
#include "tool/job_key.h"

#include "image/camera_json.h"
#include "image/error.h"
#include "image/exr_checksum.h"
#include "image/exr_read.h"
#include "image/image.h"
#include "image/regular_file.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

/* The hash of the bytes before and of these. */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t bytes) {
  return XXH3_64bits_withSeed(data, bytes, hash);
}

static uint64_t hash_text(uint64_t hash, const char *text) {
  return hash_bytes(hash, text, strlen(text) + 1);
}

static uint64_t hash_range(uint64_t hash, const hbil_config *config,
                           size_t from, size_t to) {
  return hash_bytes(hash, (const char *)config + from, to - from);
}

/* All settings but profiling and what follows it, which change no result.  The
 * members have four bytes each, so there is padding in front of `execution`
 * alone, whose last member is larger. */
_Static_assert(sizeof(hbil_inputs) % 4 == 0 && _Alignof(hbil_inputs) == 4 &&
                   _Alignof(hbil_outputs) == 4 && _Alignof(hbil_model) == 4 &&
                   _Alignof(hbil_sampling) == 4 && _Alignof(hbil_history) == 4,
               "members of four bytes");
static uint64_t hash_config(uint64_t hash, const hbil_config *config) {
  hash = hash_range(hash, config, offsetof(hbil_config, width),
                    offsetof(hbil_config, history) + sizeof config->history);
  return hash_range(hash, config, offsetof(hbil_config, execution),
                    offsetof(hbil_config, execution.profiling));
}

/* How planes are read.  The members before `unit` have four bytes each, those
 * from there on eight, so neither part has padding. */
static uint64_t hash_map(uint64_t hash, const channel_map *map) {
  const conventions *how = &map->how;
  hash = hash_bytes(
      hash, how, offsetof(conventions, motion_zero) + sizeof how->motion_zero);
  hash =
      hash_bytes(hash, &how->unit, sizeof *how - offsetof(conventions, unit));
  for (int r = 0; r < ROLE_COUNT; r++)
    for (size_t c = 0; c < map->count[r]; c++)
      hash = hash_text(hash, map->names[r][c]);
  hash = hash_bytes(hash, &map->exposure, sizeof map->exposure);
  return hash_bytes(hash, map->gamma, sizeof map->gamma);
}

static int hash_file(const char *path, uint64_t *hash, image_error *error) {
  enum { BLOCK = 1 << 16 };
  size_t read = BLOCK;
  const char *why = NULL;
  FILE *file = regular_file_stream(path, &why);
  char *block = file ? malloc(BLOCK) : NULL;
  while (block && read == BLOCK) {
    read = fread(block, 1, BLOCK, file);
    *hash = hash_bytes(*hash, block, read);
  }
  const int failed = !block || ferror(file);
  if (failed)
    image_fail(error, "%s: cannot be read: %s", path,
               why ? why : strerror(errno));
  if (file)
    fclose(file);
  free(block);
  return failed ? -1 : 0;
}

int job_key_next(const job_frame *f, uint64_t *key, image_error *error) {
  const camera_file *c = &f->camera;
  const double lens[] = {c->fx, c->fy, c->cx, c->cy};
  uint64_t hash = hash_map(*key, &f->map);
  int failed = hash_file(f->path, &hash, error);
  for (int r = 0; r < ROLE_COUNT && !failed; r++)
    if (f->map.files[r])
      failed = hash_file(f->map.files[r], &hash, error);
  hash = hash_bytes(hash, c->camera_to_world, sizeof c->camera_to_world);
  *key = hash_bytes(hash, lens, sizeof lens);
  return failed;
}

/* What the radiance cache is, and what it knows before the first frame. */
static int hash_cache(const job *j, uint64_t *hash, image_error *error) {
  const process_settings *s = j->settings;
  const hbil_cache_config *c = &j->cache;
  const unsigned how[] = {c->voxels,
                          c->levels,
                          (unsigned)s->view_light,
                          (unsigned)s->learn,
                          (unsigned)s->cache_fixed,
                          (unsigned)j->view_count,
                          (unsigned)j->light_count};
  const double where[] = {c->voxel_size, c->centre[0], c->centre[1],
                          c->centre[2], (double)c->unseen_light};
  int failed = 0;
  if (!j->has_cache)
    return 0;
  *hash = hash_bytes(*hash, how, sizeof how);
  *hash = hash_bytes(*hash, where, sizeof where);
  if (s->cache_load)
    *hash = hash_bytes(*hash, &j->loaded.hash, sizeof j->loaded.hash);
  for (int i = 0; i < j->view_count && !failed; i++)
    failed = job_key_next(&j->views[i], hash, error);
  for (int i = 0; i < j->light_count && !failed; i++)
    failed = job_key_next(&j->lights[i], hash, error);
  for (int i = 0; s->learn && i < j->count && !failed; i++)
    failed = job_key_next(&j->frames[i], hash, error);
  return failed;
}

int job_key_begin(const job *j, const char *device, uint64_t *key,
                  image_error *error) {
  const process_settings *s = j->settings;
  const unsigned more[] = {j->layers,
                           s->repeat,
                           s->warm_up,
                           (unsigned)s->exact,
                           (unsigned)s->preview,
                           (unsigned)s->copy_channels,
                           (unsigned)j->half,
                           (unsigned)j->replaces,
                           (unsigned)s->compression};
  uint64_t hash = hash_text(0, hbil_version());
  hash = hash_text(hash, device);
  hash = hash_config(hash, &j->config);
  hash = hash_bytes(hash, more, sizeof more);
  hash = hash_bytes(hash, &j->shown, sizeof j->shown);
  *key = hash_bytes(hash, &j->far, sizeof j->far);
  return hash_cache(j, key, error);
}

int job_key_is_valid(const char *text) {
  return strlen(text) == 16 && strspn(text, "0123456789abcdef") == 16;
}

void job_key_sign(image *result, uint64_t key) {
  snprintf(result->key, sizeof result->key, "%016" PRIx64, key);
}

result_state job_key_look(const char *result, uint64_t key) {
  image header, wanted;
  if (exr_read_header(result, &header, NULL) != 0)
    return RESULT_MISSING;
  job_key_sign(&wanted, key);
  const int same = strcmp(header.key, wanted.key) == 0;
  const int is_result = job_key_is_valid(header.key);
  image_free(&header);
  return !same ? is_result ? RESULT_OTHER : RESULT_MISSING
         : exr_checksum_look(result) == EXR_CHECKSUM_RIGHT ? RESULT_FINISHED
                                                           : RESULT_DAMAGED;
}
