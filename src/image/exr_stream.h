/*
 * An open file as the stream that OpenEXRCore reads from.
 *
 * The library can open files itself, but then the reason why one cannot be
 * opened (errno) is lost, and its messages go to standard error.
 */
#ifndef HBIL_IMAGE_EXR_STREAM_H
#define HBIL_IMAGE_EXR_STREAM_H

#include "image/error.h"

#include <openexr.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct exr_stream {
  const char *path;
  int fd;
  char message[512]; /* the library's first message, or "": later messages are
                      * only consequences of the first */
  int is_mute;       /* whether messages are not stored, because several threads
                      * read */
} exr_stream;

/* Opens a file and checks that it is a regular file and begins as OpenEXR does.
 * `path` must remain valid.  exr_stream_close() is allowed even if this fails.
 */
int exr_stream_open(exr_stream *s, const char *path, image_error *error);
void exr_stream_close(exr_stream *s);

/* Makes the library read from the stream and leave its messages there. */
void exr_stream_attach(exr_stream *s, exr_context_initializer_t *initializer);

#ifdef __cplusplus
}
#endif

#endif
