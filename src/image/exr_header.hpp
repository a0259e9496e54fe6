// The header of an OpenEXR file that is about to be written.
#ifndef HBIL_IMAGE_EXR_HEADER_HPP
#define HBIL_IMAGE_EXR_HEADER_HPP

#include "image/exr_style.h"
#include "image/image.h"

#include <OpenEXR/ImfHeader.h>

// The header of `img`.  half[i] says whether plane i is stored as half instead
// of its own type; `half` may be NULL.
Imf::Header exr_header(const image &img, const unsigned char *half,
                       const exr_style &style);

#endif
