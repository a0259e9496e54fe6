// An open file as the stream that OpenEXR's C++ library writes to.
//
// The library's own stream, Imf::StdOFStream, does not serve: the library
// finishes a file in a destructor, which ignores write errors (a full disk).
#ifndef HBIL_IMAGE_EXR_OUTPUT_HPP
#define HBIL_IMAGE_EXR_OUTPUT_HPP

#include "image/exr_checksum.h"

#include <OpenEXR/ImfIO.h>

#include <cstdint>
#include <string>

class ExrOutput : public Imf::OStream {
public:
  // The caller opens the file and closes it.
  ExrOutput(const char *path, int file);

  void write(const char bytes[], int count) override;
  uint64_t tellp() override;
  void seekp(uint64_t position) override;

  // From here on, all that is written is added to a checksum, which must live
  // as long as the stream; but what is written in front of this place isn't.
  void hash_into(exr_checksum *checksum);

  // Why the first write that failed did so; empty if none failed.
  const std::string &failure() const;

private:
  [[noreturn]] void fail(int code);

  const int fd;
  uint64_t at = 0;
  exr_checksum *checksum = nullptr;
  uint64_t hashed = 0; // the end of what is hashed
  std::string message;
};

#endif
