// C functions implemented with C++ libraries.  No exception may reach a C
// caller, so each such function does its work inside catch_exceptions().
#ifndef HBIL_IMAGE_CATCH_EXCEPTIONS_HPP
#define HBIL_IMAGE_CATCH_EXCEPTIONS_HPP

#include "image/error.h"

#include <exception>

// Returns what `function` returns.  If it throws, returns -1 and reports that
// `path` "cannot be VERB", with the exception's message.
template <typename Function>
int catch_exceptions(const char *path, const char *verb, image_error *error,
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
