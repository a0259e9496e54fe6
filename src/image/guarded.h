// For what calls C++ libraries behind a C interface: no exception leaves.
#ifndef HBIL_GUARDED_H
#define HBIL_GUARDED_H

#include "image/image.h"

#include <exception>

// Runs a function; whatever it throws becomes the message.
template <typename Function>
int guarded(const char *path, const char *verb, image_error *error,
            Function function) {
  try {
    return function();
  } catch (const std::exception &e) {
    return image_fail(error, "%s: cannot be %s: %s", path, verb, e.what());
  } catch (...) {
    return image_fail(error, "%s: cannot be %s", path, verb);
  }
}

#endif
