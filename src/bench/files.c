/* Files of results. */
#define _POSIX_C_SOURCE 200809L
#include "bench/files.h"

#include "image/temporary_sweep.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int bench_folder_make(const char *path, image_error *error) {
  struct stat info;
  int reason = mkdir(path, 0777) == 0 ? 0 : errno;
  if (reason == EEXIST && stat(path, &info) == 0 && S_ISDIR(info.st_mode))
    reason = access(path, W_OK | X_OK) == 0 ? 0 : errno;
  if (reason == 0)
    temporary_sweep(path);
  return reason == 0
             ? 0
             : image_fail(error, "%s: no results can be written here: %s", path,
                          strerror(reason));
}

static char *join(const char *a, const char *b, const char *c, const char *d,
                  const char *e) {
  const size_t size =
      strlen(a) + strlen(b) + strlen(c) + strlen(d) + strlen(e) + 1;
  char *text = malloc(size);
  if (text)
    snprintf(text, size, "%s%s%s%s%s", a, b, c, d, e);
  return text;
}

char *bench_result_path(const char *folder, const char *name,
                        const char *suffix) {
  return join(folder, "/", name, ".", suffix);
}

/* --- sections --- */

/* A file around one of its sections. */
typedef struct section {
  char *text;        /* the whole file; owned */
  size_t before;     /* bytes up to and with the line of its beginning */
  const char *after; /* from the line of its end on */
  file_writer *write;
  const void *context;
} section;

/* The whole file, malloc'd and with a 0 behind it; NULL on failure. */
static char *read_text(const char *path, image_error *error) {
  FILE *in = fopen(path, "rb");
  char *text = NULL;
  long size = -1;
  if (in && fseek(in, 0, SEEK_END) == 0)
    size = ftell(in);
  if (size >= 0)
    text = malloc((size_t)size + 1);
  if (text) {
    rewind(in);
    text[fread(text, 1, (size_t)size, in)] = '\0';
  } else
    image_fail(error, "--markdown %s: cannot be read: %s", path,
               strerror(errno));
  if (in)
    fclose(in);
  return text;
}

static int find_section(const char *path, const char *name, section *out,
                        image_error *error) {
  char *mark = join("<!-- hbil-bench ", name, " -->\n", "", "");
  if (!mark)
    return image_no_memory(error, path);
  out->text = read_text(path, error);
  const char *begin = out->text ? strstr(out->text, mark) : NULL;
  out->after = begin ? strstr(begin, "<!-- end -->") : NULL;
  if (out->after)
    out->before = (size_t)(begin - out->text) + strlen(mark);
  else if (out->text) {
    image_fail(error,
               "--markdown %s: the lines <!-- hbil-bench %s --> and, behind "
               "it, <!-- end --> are needed",
               path, name);
    free(out->text);
  }
  free(mark);
  return out->after ? 0 : -1;
}

int bench_section_check(const char *path, const char *name,
                        image_error *error) {
  section s;
  if (find_section(path, name, &s, error) != 0)
    return -1;
  free(s.text);
  return 0;
}

static void write_around(const void *context, FILE *out) {
  const section *s = context;
  fwrite(s->text, 1, s->before, out);
  fputc('\n', out);
  s->write(s->context, out);
  fputc('\n', out);
  fputs(s->after, out);
}

int bench_section_replace(const char *path, const char *name,
                          file_writer *write, const void *context,
                          image_error *error) {
  section s;
  if (find_section(path, name, &s, error) != 0)
    return -1;
  s.write = write;
  s.context = context;
  const int failed =
      temporary_write(path, EXISTING_REPLACED, write_around, &s, error);
  free(s.text);
  return failed;
}
