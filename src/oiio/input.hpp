// What the two readers of OpenImageIO's formats share.
#ifndef HBIL_OIIO_INPUT_HPP
#define HBIL_OIIO_INPUT_HPP

#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <mutex>

// While an object of this class exists, nothing reaches standard error.
// libpng, libjpeg and libtiff report a damaged file there, and the caller's own
// message reports it again.  Standard error belongs to the whole process, so
// only one object can exist at a time; the constructor waits for that.
class SilencedStderr {
public:
  SilencedStderr();
  ~SilencedStderr();
  SilencedStderr(const SilencedStderr &) = delete;
  SilencedStderr &operator=(const SilencedStderr &) = delete;

private:
  const std::lock_guard<std::mutex> lock;
  const int saved; // a duplicate of the descriptor of standard error
};

// Reads the channels from `begin` to before `end` as floats; `stride` is the
// distance from pixel to pixel in floats.
bool read_channels(OIIO::ImageInput &in, int begin, int end, float *out,
                   size_t stride);

#endif
