/* OpenEXRCore reads attributes, but does not tell where they are. */
#define _POSIX_C_SOURCE 200809L
#include "image/exr_checksum.h"

#include "image/regular_file.h"
#include "image/signature.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>
#include <xxhash.h>

/* Bytes of the checksum, of the signature and version in front of the header,
 * of an attribute's two names and its size at most, and of a block that is
 * hashed at a time. */
enum { DIGITS = 16, START = 8, HEAD_MOST = 2 * 256 + 4, BLOCK = 1 << 18 };
_Static_assert(sizeof EXR_CHECKSUM_ROOM == DIGITS + 1, "room for 64 bits");

/* Reads up to `size` bytes; fewer at the end of the file.  -1: errno is set. */
static ssize_t read_at(int fd, void *out, size_t size, off_t at) {
  size_t done = 0;
  while (done < size) {
    const ssize_t n =
        pread(fd, (char *)out + done, size - done, at + (off_t)done);
    if (n < 0 && errno == EINTR)
      continue;
    if (n < 0)
      return -1;
    if (n == 0)
      break;
    done += (size_t)n;
  }
  return (ssize_t)done;
}

/* ------------------------------------------------------------------------ */
/* Where it is                                                               */

/* An attribute is its name and its type, which end with '\0', the size of its
 * value, and the value. */
typedef struct attribute {
  char head[HEAD_MOST]; /* begins with the name */
  const char *type;
  off_t value; /* in the file */
  uint32_t size;
} attribute;

/* Reads the attribute that begins here; 0 if there is none. */
static int read_attribute(int fd, off_t at, attribute *out) {
  const ssize_t count = read_at(fd, out->head, sizeof out->head, at);
  if (count <= 0)
    return 0;
  const size_t room = (size_t)count;
  const size_t name = strnlen(out->head, room) + 1;
  if (name == 1 || name >= room)
    return 0;
  const size_t type = strnlen(out->head + name, room - name) + 1;
  if (name + type + 4 > room)
    return 0;
  const unsigned char *size = (const unsigned char *)out->head + name + type;
  out->type = out->head + name;
  out->size = (uint32_t)size[0] | (uint32_t)size[1] << 8 |
              (uint32_t)size[2] << 16 | (uint32_t)size[3] << 24;
  out->value = at + (off_t)(name + type + 4);
  return 1;
}

/* Places in a file; 0: unknown. */
typedef struct layout {
  off_t digits; /* of the checksum */
  off_t table;  /* of chunks, behind the header */
} layout;

static layout find_layout(int fd) {
  char start[START];
  attribute a;
  layout out = {0, 0};
  off_t at = START;
  if (read_at(fd, start, sizeof start, 0) != START ||
      signature_format(start, sizeof start) != FILE_FORMAT_EXR)
    return out;
  for (; read_attribute(fd, at, &a); at = a.value + (off_t)a.size)
    if (strcmp(a.head, EXR_CHECKSUM) == 0 && strcmp(a.type, "string") == 0 &&
        a.size == DIGITS)
      out.digits = a.value;
  out.table = at + 1; /* an empty name ends the header */
  return out;
}

/* Where the first chunk begins, which is the first entry of the table; 0:
 * unknown. */
static off_t find_chunks(int fd, off_t table) {
  unsigned char bytes[8];
  uint64_t at = 0;
  if (read_at(fd, bytes, sizeof bytes, table) != (ssize_t)sizeof bytes)
    return 0;
  for (int i = 7; i >= 0; i--)
    at = at << 8 | bytes[i];
  return at > (uint64_t)table && at < (uint64_t)1 << 62 ? (off_t)at : 0;
}

/* ------------------------------------------------------------------------ */
/* The checksum                                                              */

struct exr_checksum {
  XXH3_state_t *state;
  unsigned char *block;
};

exr_checksum *exr_checksum_new(void) {
  exr_checksum *c = calloc(1, sizeof *c);
  if (!c)
    return NULL;
  c->state = XXH3_createState();
  c->block = malloc(BLOCK);
  if (!c->state || !c->block || XXH3_64bits_reset(c->state) != XXH_OK) {
    exr_checksum_free(c);
    return NULL;
  }
  return c;
}

void exr_checksum_free(exr_checksum *c) {
  if (!c)
    return;
  XXH3_freeState(c->state);
  free(c->block);
  free(c);
}

void exr_checksum_add(exr_checksum *c, const void *bytes, size_t size) {
  XXH3_64bits_update(c->state, bytes, size);
}

/* Zeros in place of those bytes of a block that are the checksum's digits. */
static void blank_digits(unsigned char *block, size_t size, off_t at,
                         off_t digits) {
  for (off_t i = digits; i < digits + DIGITS; i++)
    if (i >= at && i < at + (off_t)size)
      block[i - at] = 0;
}

/* Takes in the bytes of a file from one place to another, or to its end. */
static int add_part(exr_checksum *c, int fd, off_t from, off_t to,
                    off_t digits) {
  while (from < to) {
    const size_t wanted = to - from < BLOCK ? (size_t)(to - from) : BLOCK;
    const ssize_t count = read_at(fd, c->block, wanted, from);
    if (count <= 0)
      return (int)count;
    blank_digits(c->block, (size_t)count, from, digits);
    exr_checksum_add(c, c->block, (size_t)count);
    from += count;
  }
  return 0;
}

static void print_digits(const exr_checksum *c, char out[DIGITS + 1]) {
  snprintf(out, DIGITS + 1, "%016" PRIx64, XXH3_64bits_digest(c->state));
}

int exr_checksum_store(exr_checksum *c, int fd, uint64_t chunks,
                       const char *path, image_error *error) {
  char digits[DIGITS + 1];
  const layout l = find_layout(fd);
  if (!l.digits || find_chunks(fd, l.table) != (off_t)chunks)
    return image_fail(error, "%s: cannot be written: no room for a checksum",
                      path);
  if (add_part(c, fd, 0, (off_t)chunks, l.digits) == 0) {
    print_digits(c, digits);
    errno = ENOSPC; /* if fewer bytes are written */
    if (pwrite(fd, digits, DIGITS, l.digits) == DIGITS)
      return 0;
  }
  return image_fail(error, "%s: cannot be written: %s", path, strerror(errno));
}

static exr_checksum_state compare(exr_checksum *c, int fd, off_t size) {
  char expected[DIGITS + 1], found[DIGITS];
  const layout l = find_layout(fd);
  const off_t chunks = l.digits ? find_chunks(fd, l.table) : 0;
  if (!l.digits)
    return EXR_CHECKSUM_MISSING;
  if (!chunks || read_at(fd, found, DIGITS, l.digits) != DIGITS ||
      add_part(c, fd, chunks, size, l.digits) != 0 ||
      add_part(c, fd, 0, chunks, l.digits) != 0)
    return EXR_CHECKSUM_WRONG;
  print_digits(c, expected);
  return memcmp(found, expected, DIGITS) == 0 ? EXR_CHECKSUM_RIGHT
                                              : EXR_CHECKSUM_WRONG;
}

exr_checksum_state exr_checksum_look(const char *path) {
  struct stat info;
  exr_checksum_state out = EXR_CHECKSUM_MISSING;
  exr_checksum *c = exr_checksum_new();
  const char *why;
  const int fd = regular_file_open(path, &why);
  if (c && fd >= 0 && fstat(fd, &info) == 0)
    out = compare(c, fd, info.st_size);
  if (fd >= 0)
    close(fd);
  exr_checksum_free(c);
  return out;
}
