/*
 * Going on where a job was broken off.
 *
 * Every result says, as an attribute of its file, what it was made from: a
 * key of the settings, of its frame and of all frames before it.  So a result
 * that is there is known to be the right one.  The light that the last frame
 * hands on stands in a file of its own beside the results while the job runs.
 */
#define _POSIX_C_SOURCE 200809L
#include "tool/resume.h"

#include "image/temporary.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define LIGHT_NAME ".hbil-light"

/* ------------------------------------------------------------------------ */
/* Keys                                                                      */

/* FNV-1a's steps, a word at a time. */
uint64_t resume_hash(uint64_t hash, const void *data, size_t bytes) {
  const uint64_t prime = 0x100000001b3u;
  const unsigned char *at = data;
  for (; bytes >= sizeof hash; bytes -= sizeof hash, at += sizeof hash) {
    uint64_t word;
    memcpy(&word, at, sizeof word);
    hash = (hash ^ word) * prime;
    hash ^= hash >> 29;
  }
  for (; bytes > 0; bytes--)
    hash = (hash ^ *at++) * prime;
  return hash;
}

static uint64_t hash_text(uint64_t hash, const char *text) {
  return resume_hash(hash, text, strlen(text) + 1);
}

/* All settings but profiling, which changes nothing; the members in between
 * have four bytes each, so there is no padding to be hashed. */
static uint64_t hash_config(uint64_t hash, const hbil_config *config) {
  const size_t from = offsetof(hbil_config, width);
  const size_t to = offsetof(hbil_config, profiling);
  return resume_hash(hash, (const char *)config + from, to - from);
}

uint64_t resume_settings(const process_options *o, const hbil_config *config,
                         unsigned layers, float environment[9][3],
                         const char *which) {
  const unsigned more[] = {layers,
                           o->repeat,
                           o->warm_up,
                           o->choose_every,
                           (unsigned)o->exact,
                           (unsigned)o->preview,
                           (unsigned)o->keep,
                           (unsigned)o->half,
                           (unsigned)o->compression};
  uint64_t hash = hash_text(RESUME_HASH, hbil_version());
  hash = hash_text(hash, which);
  hash = hash_config(hash, config);
  hash = resume_hash(hash, more, sizeof more);
  return resume_hash(hash, environment, 9 * sizeof *environment);
}

/* How planes are read: the members before `unit` have four bytes each, those
 * from there on eight. */
static uint64_t hash_map(uint64_t hash, const channel_map *map) {
  const conventions *how = &map->how;
  hash = resume_hash(
      hash, how, offsetof(conventions, motion_zero) + sizeof how->motion_zero);
  hash =
      resume_hash(hash, &how->unit, sizeof *how - offsetof(conventions, unit));
  for (int r = 0; r < ROLE_COUNT; r++)
    for (size_t c = 0; c < map->count[r]; c++)
      hash = hash_text(hash, map->names[r][c]);
  return resume_hash(hash, map->gamma, sizeof map->gamma);
}

static int hash_file(const char *path, uint64_t *hash, image_error *error) {
  enum { BLOCK = 1 << 16 }; /* a multiple of the hash's word */
  size_t read = BLOCK;
  FILE *file = fopen(path, "rb");
  char *block = file ? malloc(BLOCK) : NULL;
  while (block && read == BLOCK) {
    read = fread(block, 1, BLOCK, file);
    *hash = resume_hash(*hash, block, read);
  }
  const int failed = !block || ferror(file);
  if (failed)
    image_fail(error, "%s: cannot be read: %s", path, strerror(errno));
  if (file)
    fclose(file);
  free(block);
  return failed ? -1 : 0;
}

int resume_frame(const char *path, const channel_map *map,
                 const camera_file *camera, uint64_t *key, image_error *error) {
  uint64_t hash = hash_map(*key, map);
  int failed = hash_file(path, &hash, error);
  for (int r = 0; r < ROLE_COUNT && !failed; r++)
    if (map->files[r])
      failed = hash_file(map->files[r], &hash, error);
  hash = resume_hash(hash, camera->camera_to_world,
                     sizeof camera->camera_to_world);
  const double lens[] = {camera->fx, camera->fy, camera->cx, camera->cy};
  *key = resume_hash(hash, lens, sizeof lens);
  return failed;
}

void resume_sign(image *result, uint64_t key) {
  snprintf(result->key, sizeof result->key, "%016" PRIx64, key);
}

/* ------------------------------------------------------------------------ */
/* Results                                                                   */

/* Reads it, since its folder may have been copied only in part. */
static int is_whole(const char *path, const image *header) {
  const char **names = calloc(header->count + 1, sizeof *names);
  image planes;
  for (size_t i = 0; names && i < header->count; i++)
    names[i] = header->planes[i].name;
  const int whole =
      names && exr_read(path, names, header->count, &planes, NULL) == 0;
  if (whole)
    image_free(&planes);
  free(names);
  return whole;
}

int resume_is_finished(const char *result, uint64_t key) {
  image header, wanted;
  if (exr_read_header(result, &header, NULL) != 0)
    return 0;
  resume_sign(&wanted, key);
  const int finished =
      strcmp(header.key, wanted.key) == 0 && is_whole(result, &header);
  image_free(&header);
  return finished;
}

/* ------------------------------------------------------------------------ */
/* Light                                                                     */

/* In front of the light in its file. */
typedef struct preface {
  char magic[8];
  uint64_t key, size;
  double exposure;
} preface;

static const char light_magic[8] = {'h', 'b', 'i', 'l', 'l', 'i', 'g', '1'};

static char *light_path(const char *folder) {
  char *path = malloc(strlen(folder) + sizeof "/" LIGHT_NAME);
  if (path)
    strcat(strcpy(path, folder), "/" LIGHT_NAME);
  return path;
}

static int write_light(const char *name, const char *path,
                       const resume_light *light, image_error *error) {
  preface head = {
      .key = light->key, .size = light->size, .exposure = light->exposure};
  memcpy(head.magic, light_magic, sizeof head.magic);
  FILE *file = fopen(name, "wb");
  int failed = !file || fwrite(&head, sizeof head, 1, file) != 1 ||
               fwrite(light->bytes, light->size, 1, file) != 1;
  if (file && fclose(file) != 0)
    failed = 1;
  return failed ? image_fail(error, "%s: cannot be written: %s", path,
                             strerror(errno))
                : 0;
}

int resume_save(const char *folder, const resume_light *light,
                image_error *error) {
  char *path = light_path(folder);
  char *name = path ? temporary_name(path, error) : NULL;
  int failed = -1;
  if (!path)
    image_no_memory(error, folder);
  else if (name && write_light(name, path, light, error) == 0)
    failed = temporary_commit(name, path, error);
  else
    temporary_discard(name);
  free(path);
  return failed;
}

int resume_load(const char *folder, resume_light *light) {
  preface head;
  char *path = light_path(folder);
  FILE *file = path ? fopen(path, "rb") : NULL;
  const int found = file && fread(&head, sizeof head, 1, file) == 1 &&
                    !memcmp(head.magic, light_magic, sizeof head.magic) &&
                    head.size == light->size &&
                    fread(light->bytes, light->size, 1, file) == 1 &&
                    fgetc(file) == EOF;
  if (found) {
    light->key = head.key;
    light->exposure = (float)head.exposure;
  }
  if (file)
    fclose(file);
  free(path);
  return found;
}

/* ------------------------------------------------------------------------ */
/* Leftovers                                                                 */

/* NAME.tmpPID of one of our files, whose process is gone. */
static int is_leftover(const char *name) {
  const char *mark = NULL;
  for (const char *at = name; (at = strstr(at, ".tmp")); at++)
    mark = at;
  if (!mark || !isdigit((unsigned char)mark[4]) || mark - name < 4)
    return 0;
  char *end;
  const long id = strtol(mark + 4, &end, 10);
  return !*end && id > 0 &&
         (!strncmp(mark - 4, ".exr", 4) || !strncmp(mark - 4, ".png", 4) ||
          !strncmp(name, LIGHT_NAME, sizeof LIGHT_NAME - 1)) &&
         kill((pid_t)id, 0) != 0 && errno == ESRCH;
}

void resume_sweep(const char *folder) {
  DIR *entries = opendir(folder);
  for (struct dirent *e; entries && (e = readdir(entries));)
    if (is_leftover(e->d_name))
      unlinkat(dirfd(entries), e->d_name, 0);
  if (entries)
    closedir(entries);
}

void resume_done(const char *folder) {
  char *path = light_path(folder);
  if (path)
    unlink(path);
  free(path);
}
