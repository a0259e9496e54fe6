/*
 * Chunks in ZIP and ZIPS compression, decompressed by libdeflate.  OpenEXRCore
 * before 3.2 has zlib for it, which takes about twice as long.
 */
#ifndef HBIL_IMAGE_EXR_INFLATE_H
#define HBIL_IMAGE_EXR_INFLATE_H

#include <openexr.h>

/* What one pipeline decompresses with.  All zeros before exr_inflate_start().
 */
typedef struct exr_inflate {
  struct libdeflate_decompressor *state;
  exr_result_t (*stored)(exr_decode_pipeline_t *); /* chunks as they are */
} exr_inflate;

/* Makes a pipeline whose routines are chosen decompress so, if its part is
 * compressed so.  `with` stays with the pipeline. */
exr_result_t exr_inflate_start(exr_inflate *with,
                               exr_decode_pipeline_t *pipeline);
void exr_inflate_end(exr_inflate *with);

#endif
