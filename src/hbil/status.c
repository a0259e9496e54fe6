/* Status and version strings. */
#include "hbil/hbil.h"

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

const char *hbil_status_string(hbil_status status) {
  switch (status) {
  case HBIL_SUCCESS:
    return "success";
  case HBIL_INVALID_ARGUMENT:
    return "an argument is null or malformed";
  case HBIL_INVALID_CONFIG:
    return "a member of hbil_config or hbil_cache_config is wrong or lacks "
           "what the call needs";
  case HBIL_INVALID_FRAME:
    return "a member of hbil_frame or hbil_view is missing or wrong";
  case HBIL_OUT_OF_HOST_MEMORY:
    return "out of host memory";
  case HBIL_OUT_OF_DEVICE_MEMORY:
    return "out of device memory";
  case HBIL_UNSUPPORTED_DEVICE:
    return "the device lacks OpenCL 1.2 or a compiler";
  case HBIL_BUILD_FAILED:
    return "a kernel did not compile";
  case HBIL_OPENCL_ERROR:
    return "an OpenCL call failed";
  }
  return "unknown status";
}

const char *hbil_version(void) {
  return TEXT(HBIL_VERSION_MAJOR) "." TEXT(HBIL_VERSION_MINOR) "." TEXT(
      HBIL_VERSION_PATCH);
}
