#include "image/exr_output.hpp"

#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

ExrOutput::ExrOutput(const char *path, int file)
    : Imf::OStream(path), fd(file) {
}

void ExrOutput::hash_into(exr_checksum *to) {
  checksum = to;
  hashed = at;
}

// The library writes chunks one behind the other, and goes back only to the
// table in front of them.
void ExrOutput::write(const char bytes[], int count) {
  if (checksum && at == hashed) {
    exr_checksum_add(checksum, bytes, size_t(count));
    hashed += uint64_t(count);
  }
  for (int done = 0; done < count;) {
    const ssize_t n = pwrite(fd, bytes + done, size_t(count - done), off_t(at));
    if (n < 0 && errno == EINTR)
      continue;
    if (n <= 0)
      fail(n < 0 ? errno : ENOSPC);
    done += int(n);
    at += uint64_t(n);
  }
}

uint64_t ExrOutput::tellp() {
  return at;
}

void ExrOutput::seekp(uint64_t position) {
  at = position;
}

const std::string &ExrOutput::failure() const {
  return message;
}

void ExrOutput::fail(int code) {
  if (message.empty())
    message = std::strerror(code);
  throw std::runtime_error(message);
}
