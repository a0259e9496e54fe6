/* See shim.h.  The dynamic linker prefers a program's own definitions of the
 * OpenCL functions to those of libOpenCL, also for the calls of libhbil. */
#define _GNU_SOURCE /* RTLD_NEXT, setenv */
#include "test/support/shim.h"

#include "test/support/shim_programs.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* Failing                                                                   */

static struct {
  int countdown; /* 1: the next one; 0: none */
  cl_int error;
  const char *failed;
} fault;

void shim_fail(int nth, cl_int error) {
  fault.countdown = nth;
  fault.error = error;
  fault.failed = NULL;
}

const char *shim_failed(void) {
  return fault.failed;
}

int shim_remaining(void) {
  return fault.countdown;
}

/* CL_SUCCESS, or the error that a call of that name is to return without being
 * executed. */
static cl_int planned_failure(const char *name) {
  if (!fault.countdown || --fault.countdown)
    return CL_SUCCESS;
  fault.failed = name;
  return fault.error;
}

/* ------------------------------------------------------------------------ */
/* References                                                                */

enum { MOST_OBJECTS = 1024 };

static struct {
  const void *object;
  long references;
} objects[MOST_OBJECTS];
static pthread_mutex_t objects_lock = PTHREAD_MUTEX_INITIALIZER;

void shim_give_up(const char *why) {
  fprintf(stderr, "shim: %s\n", why);
  abort();
}

static void add_reference(const void *object) {
  int free_entry = -1, entry = -1;
  pthread_mutex_lock(&objects_lock);
  for (int i = 0; i < MOST_OBJECTS && entry < 0; ++i) {
    if (objects[i].references && objects[i].object == object)
      entry = i;
    if (!objects[i].references && free_entry < 0)
      free_entry = i;
  }
  if (entry < 0 && free_entry < 0)
    shim_give_up("more objects than the shim has room for");
  entry = entry < 0 ? free_entry : entry;
  objects[entry].object = object;
  objects[entry].references++;
  pthread_mutex_unlock(&objects_lock);
}

/* Under oclgrind, whose own functions call one another through this file and
 * release objects that were never seen here. */
static bool under_oclgrind;

/* Returns the number of references that are left; below 0 for an object of
 * oclgrind's own. */
static long drop_reference(const void *object) {
  long left = -1;
  pthread_mutex_lock(&objects_lock);
  for (int i = 0; i < MOST_OBJECTS && left < 0; ++i)
    if (objects[i].references && objects[i].object == object)
      left = --objects[i].references;
  pthread_mutex_unlock(&objects_lock);
  if (left < 0 && !under_oclgrind)
    shim_give_up("an object was released that is not held");
  return left;
}

long shim_references(void) {
  long count = 0;
  for (int i = 0; i < MOST_OBJECTS; ++i)
    count += objects[i].references;
  return count;
}

static long events_made;

long shim_events_made(void) {
  return events_made;
}

static shim_buffers created_buffers;

void shim_start_counting(void) {
  created_buffers = (shim_buffers){0, 0, 0};
}

shim_buffers shim_created(void) {
  return created_buffers;
}

static struct {
  cl_device_info what;
  const void *value; /* NULL: no answer is replaced */
  size_t size;
} answer;

void shim_answer(cl_device_info what, const void *value, size_t size) {
  answer.what = what;
  answer.value = value;
  answer.size = size;
}

static cl_int device_info(cl_device_id device, cl_device_info what, size_t room,
                          void *value, size_t *size) {
  if (!answer.value || what != answer.what)
    return NEXT(clGetDeviceInfo)(device, what, room, value, size);
  if (size)
    *size = answer.size;
  if (value)
    memcpy(value, answer.value, answer.size);
  return CL_SUCCESS;
}

/* ------------------------------------------------------------------------ */
/* Work-groups                                                               */

static const size_t *group_size;
static const char *launched_only;

/* PoCL would compile each kernel for each size of groups, and twice for that:
 * for rows of groups that begin at 0, and for others.  So it is told to compile
 * kernels that take any size, once. */
void shim_use_groups(const size_t *group) {
  setenv("POCL_WORK_GROUP_SPECIALIZATION", group ? "0" : "1", 1);
  group_size = group;
}

void shim_launch_only(const char *kernel) {
  launched_only = kernel;
}

static bool is_named(cl_kernel kernel, const char *name) {
  char own[64] = "";
  return NEXT(clGetKernelInfo)(kernel, CL_KERNEL_FUNCTION_NAME, sizeof own, own,
                               NULL) == CL_SUCCESS &&
         !strcmp(own, name);
}

static cl_int run_kernel(cl_command_queue queue, cl_kernel kernel,
                         cl_uint dimensions, const size_t *offset,
                         const size_t *global, const size_t *local,
                         cl_uint wait_count, const cl_event *wait_list,
                         cl_event *event) {
  if (launched_only && !is_named(kernel, launched_only))
    return NEXT(clEnqueueMarkerWithWaitList)(queue, wait_count, wait_list,
                                             event);
  if (!group_size || dimensions < 2)
    return NEXT(clEnqueueNDRangeKernel)(queue, kernel, dimensions, offset,
                                        global, local, wait_count, wait_list,
                                        event);
  const size_t group[3] = {group_size[0], group_size[1], 1};
  const size_t rows = (global[1] + group[1] - 1) / group[1];
  const size_t row[3] = {(global[0] + group[0] - 1) / group[0] * group[0],
                         group[1], dimensions > 2 ? global[2] : 1};
  cl_int error = CL_SUCCESS;
  for (size_t i = rows; i-- > 0 && error == CL_SUCCESS;) {
    const size_t from[3] = {0, i * group[1], 0};
    error = NEXT(clEnqueueNDRangeKernel)(queue, kernel, dimensions, from, row,
                                         group, wait_count, wait_list,
                                         i ? NULL : event);
  }
  return error;
}

/* ------------------------------------------------------------------------ */
/* Guards                                                                    */

/* A page suits every device's alignment of sub-buffers, and is a few rows of
 * the pictures in the tests. */
#define GUARD_BYTES 4096
#define GUARD 0xff
enum { MOST_GUARDED = 128 };

static bool guarding;
static struct {
  cl_mem outer, inner; /* with and without the guards */
  size_t size;
} guarded[MOST_GUARDED];

void shim_guard_buffers(bool guard) {
  guarding = guard;
}

static int entry_of_buffer(cl_mem inner) {
  int i = 0;
  while (i < MOST_GUARDED && guarded[i].inner != inner)
    ++i;
  return i;
}

static cl_mem make_guarded(cl_context context, cl_mem_flags flags, size_t size,
                           cl_int *error) {
  const size_t all = size + 2 * GUARD_BYTES;
  const cl_buffer_region inside = {GUARD_BYTES, size};
  const int i = entry_of_buffer(NULL);
  unsigned char *bytes = malloc(all);
  if (i == MOST_GUARDED || !bytes)
    shim_give_up("no room for guards");
  memset(bytes, GUARD, all);
  const cl_mem outer = NEXT(clCreateBuffer)(
      context, flags | CL_MEM_COPY_HOST_PTR, all, bytes, error);
  free(bytes);
  if (!outer)
    return NULL;
  const cl_mem inner = NEXT(clCreateSubBuffer)(
      outer, flags, CL_BUFFER_CREATE_TYPE_REGION, &inside, error);
  if (!inner)
    shim_give_up("no sub-buffer");
  guarded[i].outer = outer;
  guarded[i].inner = inner;
  guarded[i].size = size;
  return inner;
}

/* `inner` has lost its last reference. */
static void drop_guards(cl_mem inner) {
  const int i = entry_of_buffer(inner);
  if (i == MOST_GUARDED)
    return;
  NEXT(clReleaseMemObject)(guarded[i].outer);
  guarded[i].inner = NULL;
}

static size_t overwritten_at(cl_command_queue queue, cl_mem outer, size_t at) {
  unsigned char bytes[GUARD_BYTES];
  size_t count = 0;
  if (NEXT(clEnqueueReadBuffer)(queue, outer, CL_TRUE, at, sizeof bytes, bytes,
                                0, NULL, NULL) != CL_SUCCESS)
    shim_give_up("guards cannot be read");
  for (size_t i = 0; i < sizeof bytes; ++i)
    count += bytes[i] != GUARD;
  return count;
}

size_t shim_overwritten(cl_command_queue queue) {
  size_t count = 0;
  for (int i = 0; i < MOST_GUARDED; ++i)
    if (guarded[i].inner)
      count += overwritten_at(queue, guarded[i].outer, 0) +
               overwritten_at(queue, guarded[i].outer,
                              GUARD_BYTES + guarded[i].size);
  return count;
}

/* ------------------------------------------------------------------------ */
/* Filling                                                                   */

void shim_under_oclgrind(bool is_oclgrind) {
  under_oclgrind = is_oclgrind;
}

static cl_int fill_buffer(cl_command_queue queue, cl_mem buffer,
                          const void *pattern, size_t pattern_size,
                          size_t offset, size_t size, cl_uint wait_count,
                          const cl_event *wait_list, cl_event *event) {
  if (!under_oclgrind)
    return NEXT(clEnqueueFillBuffer)(queue, buffer, pattern, pattern_size,
                                     offset, size, wait_count, wait_list,
                                     event);
  size_t all = 0;
  cl_int error =
      NEXT(clGetMemObjectInfo)(buffer, CL_MEM_SIZE, sizeof all, &all, NULL);
  unsigned char *bytes = malloc(all);
  if (!bytes)
    shim_give_up("no memory to fill a buffer");
  if (error == CL_SUCCESS && size < all)
    error = NEXT(clEnqueueReadBuffer)(queue, buffer, CL_TRUE, 0, all, bytes,
                                      wait_count, wait_list, NULL);
  for (size_t at = 0; at < size; at += pattern_size)
    memcpy(bytes + offset + at, pattern, pattern_size);
  if (error == CL_SUCCESS)
    error = NEXT(clEnqueueWriteBuffer)(queue, buffer, CL_TRUE, 0, all, bytes,
                                       wait_count, wait_list, event);
  free(bytes);
  return error;
}

/* ------------------------------------------------------------------------ */
/* The calls                                                                 */

/* Calls that neither take nor release a reference. */
#define PLAIN(name, parameters, call)                                          \
  CL_API_ENTRY cl_int CL_API_CALL name parameters {                            \
    const cl_int failure = planned_failure(#name);                             \
    return failure == CL_SUCCESS ? call : failure;                             \
  }

/* Calls that return an event to callers who ask for one. */
#define ENQUEUE(name, parameters, call)                                        \
  CL_API_ENTRY cl_int CL_API_CALL name parameters {                            \
    cl_int status = planned_failure(#name);                                    \
    if (status == CL_SUCCESS)                                                  \
      status = call;                                                           \
    if (status == CL_SUCCESS && event) {                                       \
      add_reference(*event);                                                   \
      events_made++;                                                           \
    }                                                                          \
    return status;                                                             \
  }

#define CREATE(type, name, parameters, call)                                   \
  CL_API_ENTRY type CL_API_CALL name parameters {                              \
    const cl_int failure = planned_failure(#name);                             \
    if (failure != CL_SUCCESS) {                                               \
      if (error)                                                               \
        *error = failure;                                                      \
      return NULL;                                                             \
    }                                                                          \
    const type created = call;                                                 \
    if (created)                                                               \
      add_reference(created);                                                  \
    return created;                                                            \
  }

#define RETAIN(name, type)                                                     \
  CL_API_ENTRY cl_int CL_API_CALL name(type object) {                          \
    cl_int status = planned_failure(#name);                                    \
    if (status == CL_SUCCESS)                                                  \
      status = NEXT(name)(object);                                             \
    if (status == CL_SUCCESS)                                                  \
      add_reference(object);                                                   \
    return status;                                                             \
  }

/* forget: called with the object before its last reference goes. */
#define RELEASE(name, type, forget)                                            \
  CL_API_ENTRY cl_int CL_API_CALL name(type object) {                          \
    const cl_int failure = planned_failure(#name);                             \
    if (drop_reference(object) == 0)                                           \
      forget(object);                                                          \
    const cl_int status = NEXT(name)(object);                                  \
    return failure != CL_SUCCESS ? failure : status;                           \
  }
#define NOTHING(object) ((void)(object))

PLAIN(clGetDeviceInfo,
      (cl_device_id device, cl_device_info what, size_t room, void *value,
       size_t *size),
      device_info(device, what, room, value, size))
PLAIN(clGetMemObjectInfo,
      (cl_mem object, cl_mem_info what, size_t room, void *value, size_t *size),
      NEXT(clGetMemObjectInfo)(object, what, room, value, size))
PLAIN(clGetImageInfo,
      (cl_mem image, cl_image_info what, size_t room, void *value,
       size_t *size),
      NEXT(clGetImageInfo)(image, what, room, value, size))
PLAIN(clGetCommandQueueInfo,
      (cl_command_queue queue, cl_command_queue_info what, size_t room,
       void *value, size_t *size),
      NEXT(clGetCommandQueueInfo)(queue, what, room, value, size))
PLAIN(clGetEventInfo,
      (cl_event event, cl_event_info what, size_t room, void *value,
       size_t *size),
      NEXT(clGetEventInfo)(event, what, room, value, size))
PLAIN(clGetEventProfilingInfo,
      (cl_event event, cl_profiling_info what, size_t room, void *value,
       size_t *size),
      NEXT(clGetEventProfilingInfo)(event, what, room, value, size))
PLAIN(clGetPlatformInfo,
      (cl_platform_id platform, cl_platform_info what, size_t room, void *value,
       size_t *size),
      NEXT(clGetPlatformInfo)(platform, what, room, value, size))
PLAIN(clGetProgramInfo,
      (cl_program program, cl_program_info what, size_t room, void *value,
       size_t *size),
      programs_info(program, what, room, value, size))
PLAIN(clGetProgramBuildInfo,
      (cl_program program, cl_device_id device, cl_program_build_info what,
       size_t room, void *value, size_t *size),
      NEXT(clGetProgramBuildInfo)(program, device, what, room, value, size))
PLAIN(clBuildProgram,
      (cl_program program, cl_uint count, const cl_device_id *devices,
       const char *options, void(CL_CALLBACK *notify)(cl_program, void *),
       void *data),
      programs_build(program, count, devices, options, notify, data))
PLAIN(clSetKernelArg,
      (cl_kernel kernel, cl_uint index, size_t size, const void *value),
      programs_set_argument(kernel, index, size, value))
PLAIN(clGetKernelInfo,
      (cl_kernel kernel, cl_kernel_info what, size_t room, void *value,
       size_t *size),
      NEXT(clGetKernelInfo)(kernel, what, room, value, size))
PLAIN(clFlush, (cl_command_queue queue), NEXT(clFlush)(queue))
PLAIN(clFinish, (cl_command_queue queue), NEXT(clFinish)(queue))
PLAIN(clWaitForEvents, (cl_uint count, const cl_event *events),
      NEXT(clWaitForEvents)(count, events))

ENQUEUE(clEnqueueFillBuffer,
        (cl_command_queue queue, cl_mem buffer, const void *pattern,
         size_t pattern_size, size_t offset, size_t size, cl_uint wait_count,
         const cl_event *wait_list, cl_event *event),
        fill_buffer(queue, buffer, pattern, pattern_size, offset, size,
                    wait_count, wait_list, event))
ENQUEUE(clEnqueueReadBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset,
         size_t size, void *to, cl_uint wait_count, const cl_event *wait_list,
         cl_event *event),
        NEXT(clEnqueueReadBuffer)(queue, buffer, blocking, offset, size, to,
                                  wait_count, wait_list, event))
ENQUEUE(clEnqueueWriteBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset,
         size_t size, const void *from, cl_uint wait_count,
         const cl_event *wait_list, cl_event *event),
        NEXT(clEnqueueWriteBuffer)(queue, buffer, blocking, offset, size, from,
                                   wait_count, wait_list, event))
ENQUEUE(clEnqueueNDRangeKernel,
        (cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
         const size_t *offset, const size_t *global, const size_t *local,
         cl_uint wait_count, const cl_event *wait_list, cl_event *event),
        run_kernel(queue, kernel, dimensions, offset, global, local, wait_count,
                   wait_list, event))
ENQUEUE(clEnqueueMarkerWithWaitList,
        (cl_command_queue queue, cl_uint wait_count, const cl_event *wait_list,
         cl_event *event),
        NEXT(clEnqueueMarkerWithWaitList)(queue, wait_count, wait_list, event))

CREATE(cl_context, clCreateContext,
       (const cl_context_properties *properties, cl_uint count,
        const cl_device_id *devices,
        void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *),
        void *data, cl_int *error),
       NEXT(clCreateContext)(properties, count, devices, notify, data, error))
CREATE(cl_command_queue, clCreateCommandQueue,
       (cl_context context, cl_device_id device,
        cl_command_queue_properties properties, cl_int *error),
       NEXT(clCreateCommandQueue)(context, device, properties, error))
CREATE(cl_program, clCreateProgramWithSource,
       (cl_context context, cl_uint count, const char **strings,
        const size_t *lengths, cl_int *error),
       programs_create(context, count, strings, lengths, error))
CREATE(cl_program, clCreateProgramWithBinary,
       (cl_context context, cl_uint count, const cl_device_id *devices,
        const size_t *lengths, const unsigned char **binaries, cl_int *status,
        cl_int *error),
       NEXT(clCreateProgramWithBinary)(context, count, devices, lengths,
                                       binaries, status, error))
CREATE(cl_kernel, clCreateKernel,
       (cl_program program, const char *name, cl_int *error),
       programs_kernel(program, name, error))

CREATE(cl_mem, clCreateSubBuffer,
       (cl_mem buffer, cl_mem_flags flags, cl_buffer_create_type type,
        const void *region, cl_int *error),
       NEXT(clCreateSubBuffer)(buffer, flags, type, region, error))
CREATE(cl_mem, clCreateImage,
       (cl_context context, cl_mem_flags flags, const cl_image_format *format,
        const cl_image_desc *desc, void *host, cl_int *error),
       NEXT(clCreateImage)(context, flags, format, desc, host, error))
CREATE(cl_event, clCreateUserEvent, (cl_context context, cl_int *error),
       NEXT(clCreateUserEvent)(context, error))

CL_API_ENTRY cl_mem CL_API_CALL clCreateBuffer(cl_context context,
                                               cl_mem_flags flags, size_t size,
                                               void *host, cl_int *error) {
  const cl_int failure = planned_failure("clCreateBuffer");
  if (failure != CL_SUCCESS) {
    if (error)
      *error = failure;
    return NULL;
  }
  const cl_mem buffer =
      guarding && !host
          ? make_guarded(context, flags, size, error)
          : NEXT(clCreateBuffer)(context, flags, size, host, error);
  if (buffer) {
    add_reference(buffer);
    created_buffers.bytes += size;
    created_buffers.count++;
    created_buffers.hosted += host != NULL;
  }
  return buffer;
}

/* A callback that is yet to come. */
typedef struct destructor {
  void(CL_CALLBACK *call)(cl_mem, void *);
  void *user;
} destructor;

static atomic_long destructors;

long shim_destructors(void) {
  return destructors;
}

static void CL_CALLBACK destroyed(cl_mem object, void *user) {
  const destructor d = *(destructor *)user;
  free(user);
  d.call(object, d.user);
  --destructors;
}

CL_API_ENTRY cl_int CL_API_CALL clSetMemObjectDestructorCallback(
    cl_mem object, void(CL_CALLBACK *call)(cl_mem, void *), void *user) {
  const cl_int failure = planned_failure("clSetMemObjectDestructorCallback");
  destructor *d = malloc(sizeof *d);
  if (!d)
    shim_give_up("no memory");
  *d = (destructor){call, user};
  const cl_int status =
      failure != CL_SUCCESS
          ? failure
          : NEXT(clSetMemObjectDestructorCallback)(object, destroyed, d);
  if (status == CL_SUCCESS)
    ++destructors;
  else
    free(d);
  return status;
}

static bool shares_programs;

void shim_share_programs(bool share) {
  shares_programs = share;
}

/* The library retains programs for sharing alone. */
CL_API_ENTRY cl_int CL_API_CALL clRetainProgram(cl_program program) {
  const cl_int failure = shares_programs ? planned_failure("clRetainProgram")
                                         : CL_OUT_OF_RESOURCES;
  if (failure != CL_SUCCESS)
    return failure;
  add_reference(program);
  return NEXT(clRetainProgram)(program);
}

RETAIN(clRetainContext, cl_context)
RETAIN(clRetainDevice, cl_device_id)
RETAIN(clRetainEvent, cl_event)
RETAIN(clRetainCommandQueue, cl_command_queue)

RELEASE(clReleaseContext, cl_context, programs_forget_context)
RELEASE(clReleaseDevice, cl_device_id, NOTHING)
RELEASE(clReleaseCommandQueue, cl_command_queue, NOTHING)
RELEASE(clReleaseProgram, cl_program, programs_forget)
RELEASE(clReleaseKernel, cl_kernel, NOTHING)
RELEASE(clReleaseEvent, cl_event, NOTHING)

CL_API_ENTRY cl_int CL_API_CALL clReleaseMemObject(cl_mem object) {
  const cl_int failure = planned_failure("clReleaseMemObject");
  const bool last = drop_reference(object) == 0;
  const cl_int status = NEXT(clReleaseMemObject)(object);
  if (last)
    drop_guards(object);
  return failure != CL_SUCCESS ? failure : status;
}
