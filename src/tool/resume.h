/*
 * Going on where a job was broken off: what the results that are there were
 * made from, and the light that is handed on to the next frame.
 */
#ifndef HBIL_TOOL_RESUME_H
#define HBIL_TOOL_RESUME_H

#include "tool/tool.h"

/* Where a hash begins. */
#define RESUME_HASH 0xcbf29ce484222325u

/* Takes more bytes into a hash, which must not be chosen by an enemy. */
uint64_t resume_hash(uint64_t hash, const void *data, size_t bytes);

/* The key of a job before its first frame: the tool's version, the device (its
 * name and driver) and whatever changes a bit of a result. */
uint64_t resume_settings(const process_options *o, const hbil_config *config,
                         unsigned layers, float environment[9][3],
                         const char *which);
/* Takes a frame into the key: its files as they are, how they are read, its
 * camera. */
int resume_frame(const char *path, const channel_map *map,
                 const camera_file *camera, uint64_t *key, image_error *error);

/* Notes the key in a result that is going to be written. */
void resume_sign(image *result, uint64_t key);
/* Whether that file is there, whole, and has this key. */
int resume_is_finished(const char *result, uint64_t key);

/* What a frame hands on to the next, as the sequence keeps it. */
typedef struct resume_light {
  uint64_t key;   /* of that frame */
  float exposure; /* of all previews */
  size_t size;    /* of bytes; 0: nothing is handed on */
  void *bytes;
} resume_light;

int resume_save(const char *folder, const resume_light *light,
                image_error *error);
/* Fills in what was saved; 0 if there is none of that size. */
int resume_load(const char *folder, resume_light *light);

/* Takes away what processes that are gone have left half-written. */
void resume_sweep(const char *folder);
/* After the last frame: nothing is to be resumed. */
void resume_done(const char *folder);

#endif
