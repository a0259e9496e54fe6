/* Which results of an interrupted job stay. */
#define _POSIX_C_SOURCE 200809L
#include "tool/resume.h"

#include "image/png_mark.h"
#include "image/regular_file.h"
#include "image/temporary.h"
#include "tool/job_key.h"
#include "tool/report.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

/* ------------------------------------------------------------------------ */
/* The history of the last frame, in a file                                  */

/* The file begins with this; the history follows. */
typedef struct preface {
  char magic[8];
  uint64_t key, size;
  double exposure;
  uint64_t hash; /* of everything in the file */
} preface;
_Static_assert(sizeof(preface) == 40, "no padding");

static const char file_magic[8] = {'h', 'b', 'i', 'l', 'l', 'i', 'g', '3'};

/* The hash of a file; that in its preface counts as 0. */
static uint64_t hash_of(preface head, const void *bytes) {
  head.hash = 0;
  return XXH3_64bits_withSeed(bytes, head.size,
                              XXH3_64bits(&head, sizeof head));
}

static void write_history(const void *history, FILE *out) {
  const saved_history *h = history;
  preface head = {.key = h->key, .size = h->size, .exposure = h->exposure};
  memcpy(head.magic, file_magic, sizeof head.magic);
  head.hash = hash_of(head, h->bytes);
  fwrite(&head, sizeof head, 1, out);
  fwrite(h->bytes, h->size, 1, out);
}

int saved_history_write(const char *path, const saved_history *h,
                        image_error *error) {
  return temporary_write(path, EXISTING_REPLACED, write_history, h, error);
}

typedef enum saved_state {
  SAVED_NOTHING = 0, /* no such file, or a whole one of another size */
  SAVED_DAMAGED,     /* its bytes are not those that this version wrote */
  SAVED_WHOLE
} saved_state;

static saved_state read_file(FILE *file, saved_history *h) {
  preface head;
  struct stat info;
  if (fread(&head, sizeof head, 1, file) != 1 ||
      memcmp(head.magic, file_magic, sizeof head.magic) != 0 ||
      fstat(fileno(file), &info) != 0 ||
      (uint64_t)info.st_size - sizeof head != head.size)
    return SAVED_DAMAGED;
  if (head.size != h->size)
    return SAVED_NOTHING;
  if (fread(h->bytes, h->size, 1, file) != 1 ||
      head.hash != hash_of(head, h->bytes))
    return SAVED_DAMAGED;
  h->key = head.key;
  h->exposure = (float)head.exposure;
  return SAVED_WHOLE;
}

/* Reads the file if its size is h->size, and compares it with its checksum:
 * fills in key, exposure and bytes if it is whole. */
static saved_state saved_history_read(const char *path, saved_history *h) {
  const char *why;
  FILE *file = regular_file_stream(path, &why);
  if (!file)
    return SAVED_NOTHING;
  const saved_state state = read_file(file, h);
  fclose(file);
  return state;
}

void saved_history_remove(const char *path) {
  unlink(path);
}

/* ------------------------------------------------------------------------ */
/* Results                                                                   */

int resume_find_key(resume *r, size_t item, image_error *error) {
  if (r->keys[item])
    return 0;
  r->keys[item] = item == 0 ? r->begin : r->keys[item - 1];
  return job_key_next(&r->job->frames[item], &r->keys[item], error);
}

/* Stores the name of the first file, malloc'd, and counts all. */
static void add_file(resume_files *files, const char *path) {
  if (!files->count++)
    files->first = strdup(path);
}

/* Whether all previews of a frame are there. */
static int has_previews(resume *r, const job_frame *f) {
  const job *j = r->job;
  int all = 1;
  for (int l = 0; l < LAYER_COUNT && all; l++) {
    char *path = j->layers >> l & 1 ? job_preview_path(f, (layer)l) : NULL;
    all = !(j->layers >> l & 1) || (path && png_look(path).whole);
    if (path && !all && access(path, F_OK) == 0)
      add_file(&r->damaged, path);
    free(path);
  }
  return all;
}

static int look_for_result(resume *r, int item, image_error *error) {
  const job_frame *f = &r->job->frames[item];
  if (resume_find_key(r, (size_t)item, error) != 0)
    return -1;
  if (job_is_pre_roll(r->job, item))
    return 0; /* finished already, since nothing of it is written */
  char *path = job_result_path(f);
  if (!path)
    return image_no_memory(error, f->path);
  const result_state state = job_key_look(path, r->keys[item]);
  if (state == RESULT_DAMAGED)
    add_file(&r->damaged, path);
  else if (state == RESULT_OTHER)
    add_file(&r->others, path);
  r->finished[item] = state == RESULT_FINISHED &&
                      (!r->job->settings->preview || has_previews(r, f));
  free(path);
  return 0;
}

/* "hbil: lit/frame_0002.exr: is damaged or has no checksum, like 2 others; it
 * is computed again" */
static void tell(const resume *r, const resume_files *files, const char *what,
                 const char *advice) {
  char text[256], others[48] = "";
  if (!files->first || r->job->settings->quiet)
    return;
  if (files->count > 1)
    snprintf(others, sizeof others, ", like %d other%s", files->count - 1,
             files->count > 2 ? "s" : "");
  snprintf(text, sizeof text, "%s%s; it is computed again%s", what, others,
           advice);
  report_note(files->first, "", text);
}

/* Restores the saved history if it is that of a frame before the first missing
 * one; computation then begins behind that frame. */
static int restore_history(resume *r, int missing, lighting *l,
                           saved_history *h, image_error *error) {
  int from = missing - 1;
  const saved_state state = saved_history_read(r->history_path, h);
  if (state == SAVED_DAMAGED && !r->job->settings->quiet)
    report_note(r->history_path, "",
                "is damaged or of another version; earlier frames are lit "
                "again");
  if (state != SAVED_WHOLE)
    return 0;
  while (from >= 0 && r->keys[from] != h->key)
    from--;
  if (from < 0)
    return 0;
  r->first = from + 1;
  r->exposure = h->exposure;
  return lighting_history_restore(l, r->job, from, h->bytes, error);
}

static int find_history(resume *r, int missing, lighting *l,
                        image_error *error) {
  saved_history h = {.size = r->history_size};
  if (!h.size)
    return 0;
  h.bytes = malloc(h.size);
  const int failed = h.bytes ? restore_history(r, missing, l, &h, error)
                             : image_no_memory(error, r->job->settings->output);
  free(h.bytes);
  return failed;
}

static void tell_what_is_left(const resume *r, lighting *l) {
  unsigned frames = 0, runs = 0;
  for (int i = r->first; i < r->end; i++)
    if (resume_is_needed(r, (size_t)i)) {
      frames++;
      runs += job_runs(r->job, i);
    }
  lighting_expect(l, frames, runs);
}

static int look_for_results(resume *r, lighting *l, image_error *error) {
  const job *j = r->job;
  int missing = j->count;
  r->end = 0;
  for (int i = 0; i < j->count; i++) {
    if (look_for_result(r, i, error) != 0)
      return -1;
    if (r->finished[i])
      continue;
    r->end = i + 1;
    missing = i < missing ? i : missing;
  }
  tell(r, &r->damaged, "is damaged or has no checksum", "");
  tell(r, &r->others,
       "was made with other options or frames, on another device or by another "
       "version",
       " (--resume leaves a result alone if all of these are the same)");
  if (find_history(r, missing, l, error) != 0)
    return -1;
  tell_what_is_left(r, l);
  return 0;
}

int resume_open(resume *r, const job *j, lighting *l, image_error *error) {
  char which[sizeof l->device.name + sizeof l->device.driver + 1];
  snprintf(which, sizeof which, "%s %s", l->device.name, l->device.driver);
  memset(r, 0, sizeof *r);
  r->job = j;
  r->end = j->count;
  r->history_size = lighting_history_size(l);
  r->keys = calloc((size_t)j->count, sizeof *r->keys);
  r->finished = calloc((size_t)j->count, sizeof *r->finished);
  r->history_path = job_history_path(j, (int)j->pre_roll);
  for (int i = 0; r->finished && job_is_pre_roll(j, i); i++)
    r->finished[i] = 1;
  if (!r->keys || !r->finished || !r->history_path)
    return image_no_memory(error, j->frames[0].path);
  if (job_key_begin(j, which, &r->begin, error) != 0)
    return -1;
  return j->settings->resume ? look_for_results(r, l, error) : 0;
}

void resume_close(resume *r) {
  free(r->keys);
  free(r->history_path);
  free(r->damaged.first);
  free(r->others.first);
  free(r->finished);
  memset(r, 0, sizeof *r);
}

int resume_is_needed(const resume *r, size_t item) {
  const int i = (int)item;
  return !r->finished[i] || (i >= r->first && i < r->end &&
                             (r->history_size || (r->job->settings->preview &&
                                                  i == (int)r->job->pre_roll)));
}

/* Files that are made of what the cache knows in the end. */
static int needs_whole_cache(const process_settings *s) {
  return s->cache_save || s->contact_sheet;
}

int resume_uses_cache(const resume *r) {
  return r->job->has_cache &&
         (r->end > 0 || needs_whole_cache(r->job->settings));
}

int resume_is_seen(const resume *r, size_t item) {
  const process_settings *s = r->job->settings;
  return r->job->has_cache && !s->cache_fixed &&
         ((int)item < r->end || needs_whole_cache(s));
}

int resume_hands_on(const resume *r, size_t item) {
  return r->history_size && (int)item + 1 < r->end;
}
