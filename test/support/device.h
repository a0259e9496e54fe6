/*
 * The OpenCL device that a test program runs on.
 *
 * A missing device ends the program with status 99, automake's "hard error":
 * the machine is not set up for the tests, which is no reason to skip them.
 */
#ifndef HBIL_TEST_DEVICE_H
#define HBIL_TEST_DEVICE_H

#include "hbil/hbil.h"

/* A device with a context, an in-order queue and hbil's context on it. */
typedef struct device_fixture {
  cl_device_id id;
  cl_context context;
  cl_command_queue queue;
  hbil_context *hbil;
} device_fixture;

/* PoCL's device if there is one, otherwise the first of any platform. */
device_fixture device_open(void);
void device_close(device_fixture *d);

/* What the tests of a group share. */
extern device_fixture shared_device;

/* tests_run() with `shared_device` open. */
int run_with_device(void);
/* Closes `shared_device` and returns `failures`. */
int device_finish(int failures);

/* Begins a test that is about PoCL alone.  cmocka counts a skip in a test's
 * setup function as a failure. */
void skip_unless_pocl(void);

/* Prints the reason and ends the program with status 99. */
_Noreturn void hard_error(const char *why);

/* A buffer of `size` bytes that holds `bytes` (NULL: anything); must succeed.
 * The caller releases it. */
cl_mem buffer_new(const device_fixture *d, size_t size, const void *bytes);
/* Every byte of a buffer and, unless NULL, how many there are; the caller
 * frees. */
unsigned char *buffer_bytes(const device_fixture *d, cl_mem buffer,
                            size_t *size);
/* Replaces `size` bytes from `offset` on. */
void buffer_write(const device_fixture *d, cl_mem buffer, size_t offset,
                  size_t size, const void *bytes);

#endif
