/* The planes of what is measured on. */
#include "bench/content.h"

#include <stdlib.h>
#include <string.h>

int bench_content_copy(bench_content *content, bench_frame *frame,
                       bench_input input, const float *const *channels,
                       image_error *error) {
  const size_t pixels = bench_pixels(content);
  const size_t count = bench_input_channels(input);
  float *plane = malloc(count * pixels * sizeof *plane);
  frame->plane[input] = plane;
  if (!plane)
    return image_no_memory(error, content->name);
  for (size_t c = 0; c < count; c++)
    memcpy(plane + c * pixels, channels[c], pixels * sizeof *plane);
  return 0;
}

void bench_content_drop_planes(bench_content *content) {
  for (unsigned f = 0; f < content->frames; f++)
    for (int i = 0; i < BENCH_INPUTS; i++) {
      free(content->frame[f].plane[i]);
      content->frame[f].plane[i] = NULL;
    }
}

void bench_content_free(bench_content *content) {
  bench_content_drop_planes(content);
  free(content->frame);
  free(content->compared);
  memset(content, 0, sizeof *content);
}
