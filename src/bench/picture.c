/* The plot as a PNG, by a program that is there or not. */
#define _POSIX_C_SOURCE 200809L
#include "bench/bench.h"
#include "image/temporary.h"

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

extern char **environ;

/* Whether it ran and succeeded. */
static int convert(char *svg, char *png) {
  char program[] = "rsvg-convert", output[] = "-o";
  char *const arguments[] = {program, output, png, svg, NULL};
  pid_t child;
  int status = 1;
  if (posix_spawnp(&child, program, NULL, NULL, arguments, environ) != 0)
    return 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR)
      return 0;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static char *file_in(const char *folder, const char *name, image_error *error) {
  const size_t size = strlen(folder) + strlen(name) + 2;
  char *path = malloc(size);
  if (path)
    snprintf(path, size, "%s/%s", folder, name);
  else
    image_no_memory(error, folder);
  return path;
}

/* To a temporary name first: no half picture is left. */
static int make_png(char *svg, const char *png, int *made, image_error *error) {
  char *name = temporary_name(png, error);
  if (!name)
    return -1;
  *made = convert(svg, name);
  if (*made)
    return temporary_commit(name, png, error);
  temporary_discard(name);
  return 0;
}

int bench_write_png(const char *folder, int *made, image_error *error) {
  char *svg = file_in(folder, "bench.svg", error);
  char *png = file_in(folder, "bench.png", error);
  *made = 0;
  const int failed = svg && png ? make_png(svg, png, made, error) : -1;
  free(svg);
  free(png);
  return failed;
}
