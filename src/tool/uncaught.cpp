#include "tool/uncaught.h"

#include <cstdlib>
#include <exception>
#include <new>

namespace {

void (*end_process)(const char *why);

[[noreturn]] void terminate() {
  const char *why = "the process met an error that nothing handles";
  try {
    if (std::current_exception())
      std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc &) {
    why = "the process ran out of memory";
  } catch (...) {
  }
  end_process(why);
  std::abort();
}

} // namespace

extern "C" void uncaught_prepare(void (*end)(const char *why)) {
  end_process = end;
  std::set_terminate(terminate);
}
