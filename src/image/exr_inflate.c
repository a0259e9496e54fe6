#include "image/exr_inflate.h"

#include <libdeflate.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "image/exr_budget.h"

/* OpenEXR stores first the bytes at even places, then those at odd places, and
 * of each byte but the first the difference from the one before it, plus 128.
 * So the even ones are restored in place, and the odd ones as both are joined.
 * Sixteen bytes at a time where the compiler can: a sixth of the time.
 */
#ifdef __has_builtin
#if __has_builtin(__builtin_shufflevector)
#define HAS_VECTORS 1
#endif
#endif

#ifdef HAS_VECTORS
typedef uint8_t bytes __attribute__((vector_size(16)));

/* Moves all bytes n places up, and zeros in behind them. */
#define MOVE_UP(v, n)                                                          \
  __builtin_shufflevector((bytes){0}, v, 16 - (n), 17 - (n), 18 - (n),         \
                          19 - (n), 20 - (n), 21 - (n), 22 - (n), 23 - (n),    \
                          24 - (n), 25 - (n), 26 - (n), 27 - (n), 28 - (n),    \
                          29 - (n), 30 - (n), 31 - (n))

/* The next sixteen bytes.  last: the byte before them, in all places. */
static bytes restore(const uint8_t *from, bytes *last) {
  bytes sum;
  memcpy(&sum, from, sizeof sum);
  sum -= 128;
  sum += MOVE_UP(sum, 1);
  sum += MOVE_UP(sum, 2);
  sum += MOVE_UP(sum, 4);
  sum += MOVE_UP(sum, 8);
  const bytes restored = *last + sum;
  *last += __builtin_shufflevector(sum, sum, 15, 15, 15, 15, 15, 15, 15, 15, 15,
                                   15, 15, 15, 15, 15, 15, 15);
  return restored;
}

static void interleave(bytes even, bytes odd, uint8_t *to) {
  const bytes low = __builtin_shufflevector(even, odd, 0, 16, 1, 17, 2, 18, 3,
                                            19, 4, 20, 5, 21, 6, 22, 7, 23);
  even = __builtin_shufflevector(even, odd, 8, 24, 9, 25, 10, 26, 11, 27, 12,
                                 28, 13, 29, 14, 30, 15, 31);
  memcpy(to, &low, sizeof low);
  memcpy(to + sizeof low, &even, sizeof even);
}

/* Restores as many bytes as fill vectors.  to: NULL, or where they go behind
 * those at `even`, in turns.  Returns their number. */
static size_t restore_vectors(uint8_t *from, size_t size, uint8_t *last,
                              const uint8_t *even, uint8_t *to) {
  bytes before = (bytes){0} + *last;
  size_t i = 0;
  for (; i + sizeof before <= size; i += sizeof before) {
    const bytes restored = restore(from + i, &before);
    bytes other;
    if (to) {
      memcpy(&other, even + i, sizeof other);
      interleave(other, restored, to + 2 * i);
    } else {
      memcpy(from + i, &restored, sizeof restored);
    }
  }
  *last = before[0];
  return i;
}
#else
static size_t restore_vectors(uint8_t *from, size_t size, uint8_t *last,
                              const uint8_t *even, uint8_t *to) {
  (void)from, (void)size, (void)last, (void)even, (void)to;
  return 0;
}
#endif

static void restore_bytes(uint8_t *from, size_t size, uint8_t *to) {
  const size_t pairs = size / 2, even = size - pairs;
  const uint8_t *odd = from + even;
  uint8_t last = 128;
  for (size_t i = restore_vectors(from, even, &last, NULL, NULL); i < even; i++)
    from[i] = last = (uint8_t)(last + from[i] - 128u);
  size_t i = restore_vectors(from + even, pairs, &last, from, to);
  for (; i < pairs; i++) {
    to[2 * i] = from[i];
    to[2 * i + 1] = last = (uint8_t)(last + odd[i] - 128u);
  }
  if (size % 2)
    to[size - 1] = from[pairs];
}

/* Memory for the bytes before they are restored; the pipeline releases it. */
static exr_result_t take_scratch(exr_decode_pipeline_t *p, size_t size) {
  if (p->scratch_alloc_size_1 >= size)
    return EXR_ERR_SUCCESS;
  budget_give(p->scratch_buffer_1);
  p->scratch_buffer_1 = budget_take(size);
  p->scratch_alloc_size_1 = p->scratch_buffer_1 ? size : 0;
  return p->scratch_buffer_1 ? EXR_ERR_SUCCESS : EXR_ERR_OUT_OF_MEMORY;
}

static exr_result_t decompress(exr_decode_pipeline_t *p) {
  const exr_inflate *with = p->decoding_user_data;
  const size_t packed = (size_t)p->chunk.packed_size;
  const size_t size = (size_t)p->chunk.unpacked_size;
  if (packed == 0 || packed == size) /* compression would have gained nothing */
    return with->stored(p);
  const exr_result_t result = take_scratch(p, size);
  if (result != EXR_ERR_SUCCESS)
    return result;
  if (libdeflate_zlib_decompress(with->state, p->packed_buffer, packed,
                                 p->scratch_buffer_1, size,
                                 NULL) != LIBDEFLATE_SUCCESS)
    return EXR_ERR_CORRUPT_CHUNK;
  restore_bytes(p->scratch_buffer_1, size, p->unpacked_buffer);
  return EXR_ERR_SUCCESS;
}

exr_result_t exr_inflate_start(exr_inflate *with,
                               exr_decode_pipeline_t *pipeline) {
  exr_compression_t compression;
  const exr_result_t result = exr_get_compression(
      pipeline->context, pipeline->part_index, &compression);
  if (result != EXR_ERR_SUCCESS || (compression != EXR_COMPRESSION_ZIP &&
                                    compression != EXR_COMPRESSION_ZIPS))
    return result;
  with->state = libdeflate_alloc_decompressor();
  if (!with->state)
    return EXR_ERR_OUT_OF_MEMORY;
  with->stored = pipeline->decompress_fn;
  pipeline->decompress_fn = decompress;
  pipeline->decoding_user_data = with;
  return EXR_ERR_SUCCESS;
}

void exr_inflate_end(exr_inflate *with) {
  libdeflate_free_decompressor(with->state);
  with->state = NULL;
}
