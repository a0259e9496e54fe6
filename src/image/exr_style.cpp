#include "image/exr_style.h"

#include <OpenEXR/ImfCompression.h>

// OpenEXR 3.1 has no names for its compressions.  The order is that of
// Imf::Compression.
extern "C" const char *const exr_compressions[] = {
    "none", "rle",  "zips", "zip",  "piz",   "pxr24",
    "b44",  "b44a", "dwaa", "dwab", "input", nullptr};

static_assert(EXR_COMPRESSION_OF_NONE == int(Imf::NO_COMPRESSION) &&
                  EXR_COMPRESSION_OF_ZIP == int(Imf::ZIP_COMPRESSION),
              "the names are in the library's order");
static_assert(EXR_COMPRESSION_OF_INPUT == int(Imf::DWAB_COMPRESSION) + 1,
              "\"input\" follows the library's compressions");
