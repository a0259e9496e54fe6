/* Which results of an interrupted job stay, and the light that the next frame
 * needs. */
#ifndef HBIL_TOOL_RESUME_H
#define HBIL_TOOL_RESUME_H

#include "image/error.h"
#include "tool/job.h"
#include "tool/lighting.h"

#include <stddef.h>
#include <stdint.h>

/* ------------------------------------------------------------------------ */
/* The history of the last frame, in a file                                  */

typedef struct saved_history {
  uint64_t key;   /* of the frame whose history it is (job_key.h) */
  float exposure; /* of all previews */
  size_t size;    /* of bytes; 0: there is no history */
  void *bytes;    /* see lighting_history_save(); owned by the caller */
} saved_history;

/* Writes the file (job_history_path()).  0, or -1 with `error` filled. */
int saved_history_write(const char *path, const saved_history *h,
                        image_error *error);

/* Removes the file. */
void saved_history_remove(const char *path);

/* ------------------------------------------------------------------------ */
/* Results                                                                   */

typedef struct resume_files {
  int count;
  char *first; /* the name of the first one; NULL: none */
} resume_files;

typedef struct resume {
  const job *job;
  uint64_t begin;          /* the key before the first frame */
  uint64_t *keys;          /* of each frame; 0: not known yet */
  unsigned char *finished; /* 1: the frame's result exists, or is not written */
  int first, end;          /* computed are frames from `first`, before `end` */
  char *history_path;      /* of the saved history */
  size_t history_size;     /* bytes; 0: frames hand on nothing */
  float exposure;          /* of all previews; 0: not known yet */
  resume_files damaged;    /* that are computed again therefore */
  resume_files others;     /* likewise, since they have other keys */
} resume;

/* Without --resume, nothing is finished.  With it, looks at the results that
 * exist and restores the saved history into l.  0, or -1 with `error` filled;
 * resume_close() frees it in both cases. */
int resume_open(resume *r, const job *j, lighting *l, image_error *error);
void resume_close(resume *r);

/* Makes sure that the key of this frame is known.  0, or -1. */
int resume_find_key(resume *r, size_t item, image_error *error);

/* Whether a frame must be computed.  A frame with a finished result must be if
 * later frames need its history, or previews its exposure. */
int resume_is_needed(const resume *r, size_t item);

/* Whether the radiance cache must see a frame: what it knows, and so the light
 * of later frames, the contact sheet and a saved cache, depends on all frames
 * before, computed or not. */
int resume_is_seen(const resume *r, size_t item);

/* Whether the radiance cache is used at all. */
int resume_uses_cache(const resume *r);

/* Whether the frame's history is saved, for the frames that are left. */
int resume_hands_on(const resume *r, size_t item);

#endif
