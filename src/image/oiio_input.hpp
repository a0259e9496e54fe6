// What the two readers of OpenImageIO's formats share.
#ifndef HBIL_IMAGE_OIIO_INPUT_HPP
#define HBIL_IMAGE_OIIO_INPUT_HPP

#include <OpenImageIO/imageio.h>

#include <cstddef>

// While an object of this class exists, nothing reaches standard error.
// libpng, libjpeg and libtiff report a damaged file there, and the caller's own
// message reports it again.
class SilencedStderr {
public:
  SilencedStderr();
  ~SilencedStderr();
  SilencedStderr(const SilencedStderr &) = delete;
  SilencedStderr &operator=(const SilencedStderr &) = delete;

private:
  const int saved; // a duplicate of the descriptor of standard error
};

// Reads the channels from `begin` to before `end` as floats; `stride` is the
// distance from pixel to pixel in floats.
bool read_channels(OIIO::ImageInput &in, int begin, int end, float *out,
                   size_t stride);

#endif
