#define _POSIX_C_SOURCE 200809L
#include "image/exr_stream.h"
#include "image/regular_file.h"
#include "image/signature.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int check_format(const exr_stream *s, image_error *error) {
  char start[SIGNATURE_SIZE];
  const ssize_t size = pread(s->fd, start, sizeof start, 0);
  if (size < 0 || signature_format(start, (size_t)size) != FILE_FORMAT_EXR)
    return image_fail(error,
                      "%s: not an OpenEXR file; an .exr is needed, or a "
                      "PNG, TIFF or HDR file where it serves",
                      s->path);
  return 0;
}

int exr_stream_open(exr_stream *s, const char *path, image_error *error) {
  const char *why;
  s->path = path;
  s->message[0] = '\0';
  s->is_mute = 0;
  s->fd = regular_file_open(path, &why);
  if (s->fd < 0)
    return image_fail(
        error, "%s: cannot be read: %s; an OpenEXR file is needed", path, why);
  return check_format(s, error);
}

void exr_stream_close(exr_stream *s) {
  if (s->fd >= 0)
    close(s->fd);
  s->fd = -1;
}

static int64_t stream_size(exr_const_context_t context, void *user) {
  struct stat status;
  (void)context;
  return fstat(((exr_stream *)user)->fd, &status) == 0 ? (int64_t)status.st_size
                                                       : -1;
}

/* Reads up to the end of the file.  Returns the number of bytes, -1 on failure.
 * The library decides whether fewer bytes than it asked for are enough. */
static int64_t stream_read(exr_const_context_t context, void *user, void *data,
                           uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t report) {
  uint64_t done = 0;
  while (done < size) {
    ssize_t n = pread(((exr_stream *)user)->fd, (char *)data + done,
                      (size_t)(size - done), (off_t)(offset + done));
    if (n < 0 && errno == EINTR)
      continue;
    if (n < 0) {
      report(context, EXR_ERR_READ_IO, "%s", strerror(errno));
      return -1;
    }
    if (n == 0)
      break;
    done += (uint64_t)n;
  }
  return (int64_t)done;
}

static void store_message(exr_const_context_t context, exr_result_t code,
                          const char *message) {
  void *user = NULL;
  (void)code;
  if (context && exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user) {
    exr_stream *s = user;
    if (!s->message[0] && !s->is_mute)
      snprintf(s->message, sizeof s->message, "%s", message);
  }
}

void exr_stream_attach(exr_stream *s, exr_context_initializer_t *initializer) {
  initializer->user_data = s;
  initializer->read_fn = stream_read;
  initializer->size_fn = stream_size;
  initializer->error_handler_fn = store_message;
}
