#include "image/exr_inflate.h"

#include <libdeflate.h>
#include <stddef.h>
#include <stdint.h>

#include "image/exr_budget.h"

/* OpenEXR stores first the bytes at even places, then those at odd places, and
 * of each byte but the first the difference from the one before it, plus 128.
 */
static void restore_bytes(const uint8_t *from, size_t size, uint8_t *to) {
  const size_t even = (size + 1) / 2;
  unsigned value = 128;
  for (size_t i = 0; i < even; i++)
    to[2 * i] = (uint8_t)(value += from[i] - 128u);
  for (size_t i = even; i < size; i++)
    to[2 * (i - even) + 1] = (uint8_t)(value += from[i] - 128u);
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
