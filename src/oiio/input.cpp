#include "oiio/input.hpp"

#include <fcntl.h>
#include <unistd.h>

namespace {
std::mutex standard_error;
}

SilencedStderr::SilencedStderr()
    : lock(standard_error), saved(dup(STDERR_FILENO)) {
  const int null = open("/dev/null", O_WRONLY);
  if (saved >= 0 && null >= 0)
    dup2(null, STDERR_FILENO);
  if (null >= 0)
    close(null);
}

SilencedStderr::~SilencedStderr() {
  if (saved >= 0) {
    dup2(saved, STDERR_FILENO);
    close(saved);
  }
}

bool read_channels(OIIO::ImageInput &in, int begin, int end, float *out,
                   size_t stride) {
  // read_image() returns true for a truncated TIFF; only the error tells.
  return in.read_image(0, 0, begin, end, OIIO::TypeDesc::FLOAT, out,
                       OIIO::stride_t(stride * sizeof(float))) &&
         !in.has_error();
}
