#define _POSIX_C_SOURCE 200809L
#include "image/png_mark.h"

#include "image/regular_file.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>

/* A file is a signature and then chunks: four bytes of length, four of type,
 * the data, and four of checksum. */
enum { SIGNATURE = 8, HEAD = 8, CHECKSUM = 4 };

static const char signature[SIGNATURE] = {'\x89', 'P',  'N',    'G',
                                          '\r',   '\n', '\x1a', '\n'};
static const char mark[] = PNG_MARK_NAME "\0" PNG_MARK;

static int has_signature(FILE *file) {
  char start[SIGNATURE];
  return fread(start, sizeof start, 1, file) == 1 &&
         memcmp(start, signature, sizeof start) == 0;
}

/* Whether the chunk of so many bytes, whose head has been read, is the mark. */
static int is_mark(FILE *file, const unsigned char *head, uint32_t length) {
  char text[sizeof mark - 1]; /* without the '\0' behind it */
  return memcmp(head + 4, "tEXt", 4) == 0 && length == sizeof text &&
         fread(text, sizeof text, 1, file) == 1 &&
         memcmp(text, mark, sizeof text) == 0;
}

/* Goes through the chunks of a file of `size` bytes. */
static png_state look(FILE *file, off_t size) {
  unsigned char head[HEAD];
  png_state out = {0, 0};
  off_t at = SIGNATURE;
  while (!out.whole && fseeko(file, at, SEEK_SET) == 0 &&
         fread(head, sizeof head, 1, file) == 1) {
    const uint32_t length = (uint32_t)head[0] << 24 | (uint32_t)head[1] << 16 |
                            (uint32_t)head[2] << 8 | head[3];
    out.marked |= is_mark(file, head, length);
    at += HEAD + (off_t)length + CHECKSUM;
    out.whole = memcmp(head + 4, "IEND", 4) == 0 && at == size;
  }
  return out;
}

png_state png_look(const char *path) {
  struct stat info;
  png_state out = {0, 0};
  const char *why;
  FILE *file = regular_file_stream(path, &why);
  if (file && fstat(fileno(file), &info) == 0 && has_signature(file))
    out = look(file, info.st_size);
  if (file)
    fclose(file);
  return out;
}
