/*
 * How long an exact gather will take: a pilot run over a few hundred pixels,
 * one at a random position in each block of the picture.  Regular positions
 * could all lie in one thread's rows.
 */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <time.h>

#include "exact/passes.h"
#include "exact/settings.h"

/* Pixels of the pilot run, about: seconds where a frame takes hours. */
enum { PILOT_PIXELS = 400 };

static double seconds_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Marks a pixel in each block of side x side; returns how many. */
static size_t mark_pixels(unsigned char *mask, int width, int height,
                          int side) {
  unsigned random = 1;
  size_t count = 0;
  for (int y = 0; y < height; y += side)
    for (int x = 0; x < width; x += side) {
      random = random * 1664525u + 1013904223u; /* Numerical Recipes */
      const int i = x + (int)((random >> 8) % (unsigned)side);
      const int j = y + (int)((random >> 20) % (unsigned)side);
      if (i >= width || j >= height)
        continue;
      mask[(size_t)j * (size_t)width + (size_t)i] = 1;
      count++;
    }
  return count;
}

/* Seconds that the gather of the marked pixels takes; 0: it failed. */
static double time_gather(const exact_frame *frame, const exact_dense *how) {
  hbil_config ao;
  exact_frame second = *frame;
  const int width = (int)frame->config->width;
  const int height = (int)frame->config->height;
  exact_planes split = {0}, gathered = {0};
  double seconds = 0.0;
  if (exact_planes_create(&split, width, height, HBIL_SPLIT_PLANES) ==
          EXACT_SUCCESS &&
      exact_planes_create(&gathered, width, height, HBIL_GATHERED_PLANES) ==
          EXACT_SUCCESS) {
    exact_split(frame, NULL, &split);
    const double before = seconds_now();
    exact_status status = exact_gather_dense(frame, &split, how, &gathered);
    if (status == EXACT_SUCCESS && exact_searches_ao(frame->config, &ao)) {
      second.config = &ao;
      status = exact_gather_dense(&second, &split, how, &gathered);
    }
    if (status == EXACT_SUCCESS)
      seconds = seconds_now() - before;
  }
  exact_planes_free(&split);
  exact_planes_free(&gathered);
  return seconds;
}

double exact_predict_seconds(const exact_frame *frame, int slices,
                             size_t pixels) {
  const size_t width = frame->config->width, height = frame->config->height;
  unsigned char *mask = calloc(width * height, 1);
  int side = 1;
  if (!mask)
    return 0.0;
  while ((size_t)(side + 1) * (size_t)(side + 1) * PILOT_PIXELS <=
         width * height)
    side++;
  const size_t count = mark_pixels(mask, (int)width, (int)height, side);
  const exact_dense how = {.slices = slices, .mask = mask};
  const double seconds = count ? time_gather(frame, &how) : 0.0;
  free(mask);
  return count ? seconds * (double)pixels / (double)count : 0.0;
}
