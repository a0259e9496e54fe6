/*
 * For libFuzzer: any bytes as a dump or as a camera.  Besides what the
 * sanitizers see, a reader must give either an image or one sentence, and must
 * hold no more memory than exr_budget.h states.  Built and run by `make fuzz`.
 */
#define _GNU_SOURCE
#include "image/camera_json.h"
#include "image/exr_budget.h"
#include "image/exr_read.h"
#include "image/image.h"

#include <sanitizer/allocator_interface.h>

#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* Larger claims are let go after the header: their pixels are the same code as
 * those of small ones and would only take time. */
enum { MOST_VALUES = 1 << 20 };

/*
 * Beside the reader's own budget: zlib's state, stdio, and what OpenImageIO
 * allocates once for the process.  Measured: 1 MiB.
 */
enum { BESIDE = 4 << 20 };

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* ------------------------------------------------------------------------ */
/* Memory                                                                    */

static atomic_size_t held, peak;

static void taken(const volatile void *memory, size_t size) {
  (void)memory;
  const size_t now = atomic_fetch_add(&held, size) + size;
  if (now > peak)
    peak = now;
}

static void given(const volatile void *memory) {
  if (memory)
    atomic_fetch_sub(
        &held, __sanitizer_get_allocated_size((const void *)(uintptr_t)memory));
}

static void forget(void) {
  peak = atomic_load(&held);
}

static void check_memory(size_t before, size_t image_bytes, const char *what) {
  const size_t most = 4 * image_bytes + EXR_SPARE_MEMORY + BESIDE;
  if (peak <= before + most)
    return;
  fprintf(stderr, "%s: %zu bytes held, at most %zu allowed for %zu\n", what,
          peak - before, most, image_bytes);
  abort();
}

static void check_error(const image_error *error) {
  if (error->text[0])
    return;
  fprintf(stderr, "failed without a word\n");
  abort();
}

/* ------------------------------------------------------------------------ */
/* Readers                                                                   */

/* Every step-th channel. */
static void read_some(const char *path, const image *header, size_t step) {
  const size_t bytes =
      sizeof(float) * header->count * header->width * header->height;
  const char **names = calloc(header->count + 1, sizeof *names);
  size_t count = 0;
  image_error error = {""};
  image out;
  if (!names)
    return;
  for (size_t i = 0; i < header->count; i += step)
    names[count++] = header->planes[i].name;
  const size_t before = held;
  forget();
  if (exr_read(path, names, count, &out, &error) != 0)
    check_error(&error);
  check_memory(before, bytes, "pixels");
  image_free(&out);
  free(names);
}

static void read_dump(const char *path) {
  image_error error = {""};
  image header;
  const size_t before = held;
  forget();
  const int failed = exr_read_header(path, &header, &error);
  check_memory(before, 0, "header");
  if (failed)
    check_error(&error);
  else if (header.count * header.width * header.height <= MOST_VALUES) {
    read_some(path, &header, 1);
    read_some(path, &header, 2);
  }
  image_free(&header);
}

static void read_camera(const char *path) {
  image_error error = {""};
  camera_file camera;
  if (camera_read(path, &camera, &error) != 0)
    check_error(&error);
}

int LLVMFuzzerInitialize(int *argc, char ***argv) {
  (void)argc;
  (void)argv;
  __sanitizer_install_malloc_and_free_hooks(taken, given);
  return 0;
}

/* What doesn't begin like an EXR file is taken for a camera. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  char path[64];
  const int file = memfd_create("dump", 0);
  if (file < 0 || write(file, data, size) != (ssize_t)size)
    abort();
  snprintf(path, sizeof path, "/proc/self/fd/%d", file);
  if (size && data[0] == 0x76)
    read_dump(path);
  else
    read_camera(path);
  close(file);
  return 0;
}
