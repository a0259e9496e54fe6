/* What a file is that lies where another one is to be written. */
#ifndef HBIL_TOOL_FILE_KIND_H
#define HBIL_TOOL_FILE_KIND_H

typedef enum file_kind {
  FILE_ABSENT = 0,
  FILE_BLANK,     /* nothing but zeros, or empty: it has nothing to lose */
  FILE_IRREGULAR, /* a folder, a device, a pipe, ... */
  FILE_RESULT,    /* of hbil process: an EXR with a job's key */
  FILE_DEMO,      /* a G-buffer of hbil demo: an EXR with FILE_DEMO_KEY */
  FILE_PICTURE,   /* a PNG that hbil wrote */
  FILE_CACHE,     /* a radiance cache */
  FILE_OTHER      /* anything else, also a file that cannot be read */
} file_kind;

/* image.key of what hbil demo traces. */
#define FILE_DEMO_KEY "demo"

/* Looks at a file's beginning, not at its pixels.  Links are followed. */
file_kind file_kind_of(const char *path);

/* "a radiance cache"; for the kinds that hbil writes. */
const char *file_kind_name(file_kind kind);

#endif
