/*
 * hbil: what all its headers share.  Programs include hbil/hbil.h.
 */
#ifndef HBIL_HBIL_BASE_H
#define HBIL_HBIL_BASE_H

#include <stddef.h>

/* The library needs OpenCL 1.2.  CL_TARGET_OPENCL_VERSION is the program's: the
 * headers compile with 120 and above, before or after <CL/opencl.hpp>. */
#ifdef __APPLE__
#include <OpenCL/opencl.h>
#else
#include <CL/cl.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define HBIL_VERSION_MAJOR 0
#define HBIL_VERSION_MINOR 1
#define HBIL_VERSION_PATCH 0

/* The largest width and height of a frame, in pixels. */
#define HBIL_MAX_SIZE 16384

#if defined(_WIN32)
#define HBIL_API
#else
#define HBIL_API __attribute__((visibility("default")))
#endif

/* The library on one device (hbil.h). */
typedef struct hbil_context hbil_context;

/* ------------------------------------------------------------------------ */
/* Status: result codes and version                                          */

typedef enum hbil_status {
  HBIL_SUCCESS = 0,
  HBIL_INVALID_ARGUMENT = 1, /* an argument is null or malformed */
  /* a member of hbil_config or hbil_cache_config is out of range */
  HBIL_INVALID_CONFIG = 2,
  /* a member of hbil_frame or hbil_view is missing or wrong */
  HBIL_INVALID_FRAME = 3,
  HBIL_OUT_OF_HOST_MEMORY = 4,
  HBIL_OUT_OF_DEVICE_MEMORY = 5, /* the device cannot hold the buffers */
  HBIL_UNSUPPORTED_DEVICE = 6,   /* below OpenCL 1.2 or without a compiler */
  HBIL_BUILD_FAILED = 7,         /* a kernel did not compile; see the message */
  HBIL_OPENCL_ERROR = 8          /* any other OpenCL failure; see the message */
} hbil_status;

/* Returns a short sentence for a status; a static string, never NULL. */
HBIL_API const char *hbil_status_string(hbil_status status);

/* Returns the running library's "major.minor.patch"; a static string. */
HBIL_API const char *hbil_version(void);
#ifdef __cplusplus
}
#endif

#endif
