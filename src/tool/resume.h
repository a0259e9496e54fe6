/* Bookkeeping of a job: which results exist already, which frames are still to
 * be computed, and with which history the computation begins. */
#ifndef HBIL_TOOL_RESUME_H
#define HBIL_TOOL_RESUME_H

#include "tool/job.h"
#include "tool/lighting.h"
#include "tool/saved_history.h"
#include "image/error.h"

#include <stdint.h>

typedef struct resume {
  const job *job;
  uint64_t begin;          /* the key before the first frame */
  uint64_t *keys;          /* of each frame; 0: not known yet */
  unsigned char *finished; /* 1: the frame's result exists, or is not written */
  int first, end;          /* computed are frames from `first`, before `end` */
  char *history_path;      /* of the saved history */
  size_t history_size;     /* bytes; 0: frames hand on nothing */
  float exposure;          /* of all previews; 0: not known yet */
  int damaged;             /* files that are computed again therefore */
  char *first_damaged;     /* the name of the first one; NULL: none */
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
