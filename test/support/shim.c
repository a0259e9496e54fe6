/* See shim.h.  The dynamic linker prefers a program's own definitions of the
 * OpenCL functions to those of libOpenCL, also for the calls of libhbil. */
#define _GNU_SOURCE /* RTLD_NEXT */
#include "test/support/shim.h"

#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* libOpenCL's function of that name.  C doesn't let an object pointer become a
 * function pointer; POSIX does. */
#define NEXT(name)                                                             \
  (((union {                                                                   \
     void *object;                                                             \
     __typeof__(&name) function;                                               \
   }){.object = dlsym(RTLD_NEXT, #name)})                                      \
       .function)

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

static void give_up(const char *why) {
  fprintf(stderr, "shim: %s\n", why);
  abort();
}

static void add_reference(const void *object) {
  int free_entry = -1;
  for (int i = 0; i < MOST_OBJECTS; ++i) {
    if (objects[i].references && objects[i].object == object) {
      objects[i].references++;
      return;
    }
    if (!objects[i].references && free_entry < 0)
      free_entry = i;
  }
  if (free_entry < 0)
    give_up("more objects than the shim has room for");
  objects[free_entry].object = object;
  objects[free_entry].references = 1;
}

/* Returns the number of references that are left. */
static long drop_reference(const void *object) {
  for (int i = 0; i < MOST_OBJECTS; ++i)
    if (objects[i].references && objects[i].object == object)
      return --objects[i].references;
  give_up("an object was released that is not held");
  return 0;
}

long shim_references(void) {
  long count = 0;
  for (int i = 0; i < MOST_OBJECTS; ++i)
    count += objects[i].references;
  return count;
}

static shim_buffers created_buffers;

void shim_start_counting(void) {
  created_buffers = (shim_buffers){0, 0};
}

shim_buffers shim_created(void) {
  return created_buffers;
}

/* ------------------------------------------------------------------------ */
/* Programs that are reused                                                  */

enum { MOST_PROGRAMS = 16 };

static bool reusing, skipping;
static struct {
  uint64_t source; /* a hash */
  cl_program program;
  bool built;
} programs[MOST_PROGRAMS];

void shim_reuse_programs(bool reuse) {
  reusing = reuse;
  for (int i = 0; i < MOST_PROGRAMS && !reuse; ++i)
    if (programs[i].program) {
      NEXT(clReleaseProgram)(programs[i].program);
      programs[i].program = NULL;
    }
}

/* FNV-1a */
static uint64_t hash_of(cl_uint count, const char **strings) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (cl_uint i = 0; i < count; ++i)
    for (const char *c = strings[i]; *c; ++c)
      hash = (hash ^ (unsigned char)*c) * 0x100000001b3u;
  return hash;
}

/* The entry of a source, or else a free one. */
static int entry_of_source(uint64_t source) {
  int i = 0;
  while (i < MOST_PROGRAMS && programs[i].program &&
         programs[i].source != source)
    ++i;
  if (i == MOST_PROGRAMS)
    give_up("more programs than the shim has room for");
  return i;
}

/* `lengths` are NULL: the strings end with a zero. */
static cl_program make_program(cl_context context, cl_uint count,
                               const char **strings, const size_t *lengths,
                               cl_int *error) {
  const int i = reusing ? entry_of_source(hash_of(count, strings)) : 0;
  if (reusing && programs[i].program) {
    *error = NEXT(clRetainProgram)(programs[i].program);
    return programs[i].program;
  }
  const cl_program program =
      NEXT(clCreateProgramWithSource)(context, count, strings, lengths, error);
  if (reusing && program && NEXT(clRetainProgram)(program) == CL_SUCCESS) {
    programs[i].source = hash_of(count, strings);
    programs[i].program = program;
    programs[i].built = false;
  }
  return program;
}

static cl_int build(cl_program program, cl_uint count,
                    const cl_device_id *devices, const char *options,
                    void(CL_CALLBACK *notify)(cl_program, void *), void *data) {
  int i = 0;
  if (skipping)
    return CL_SUCCESS;
  while (i < MOST_PROGRAMS && !(reusing && programs[i].program == program))
    ++i;
  if (i < MOST_PROGRAMS && programs[i].built)
    return CL_SUCCESS;
  const cl_int error =
      NEXT(clBuildProgram)(program, count, devices, options, notify, data);
  if (i < MOST_PROGRAMS)
    programs[i].built = error == CL_SUCCESS;
  return error;
}

/* ------------------------------------------------------------------------ */
/* Builds that are skipped                                                   */

static cl_program idle_program; /* built, with the kernel "idle" */

void shim_skip_builds(bool skip) {
  skipping = skip;
  if (!skip && idle_program) {
    NEXT(clReleaseProgram)(idle_program);
    idle_program = NULL;
  }
}

static cl_kernel make_kernel(cl_program program, const char *name,
                             cl_int *error) {
  const char *source = "__kernel void idle(void) {}";
  if (!skipping)
    return NEXT(clCreateKernel)(program, name, error);
  if (!idle_program) {
    cl_context context = NULL;
    clGetProgramInfo(program, CL_PROGRAM_CONTEXT, sizeof context, &context,
                     NULL);
    idle_program =
        NEXT(clCreateProgramWithSource)(context, 1, &source, NULL, error);
    if (!idle_program ||
        NEXT(clBuildProgram)(idle_program, 0, NULL, "", NULL, NULL))
      give_up("the idle kernel cannot be built");
  }
  return NEXT(clCreateKernel)(idle_program, "idle", error);
}

/* ------------------------------------------------------------------------ */
/* Work-groups                                                               */

static const size_t *group_size;

void shim_use_groups(const size_t *group) {
  group_size = group;
}

static cl_int run_kernel(cl_command_queue queue, cl_kernel kernel,
                         cl_uint dimensions, const size_t *offset,
                         const size_t *global, const size_t *local,
                         cl_uint wait_count, const cl_event *wait_list,
                         cl_event *event) {
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
enum { MOST_GUARDED = 64 };

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
    give_up("no room for guards");
  memset(bytes, GUARD, all);
  const cl_mem outer = NEXT(clCreateBuffer)(
      context, flags | CL_MEM_COPY_HOST_PTR, all, bytes, error);
  free(bytes);
  if (!outer)
    return NULL;
  const cl_mem inner = clCreateSubBuffer(
      outer, flags, CL_BUFFER_CREATE_TYPE_REGION, &inside, error);
  if (!inner)
    give_up("no sub-buffer");
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
    give_up("guards cannot be read");
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
    if (status == CL_SUCCESS && event)                                         \
      add_reference(*event);                                                   \
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

#define RELEASE(name, type)                                                    \
  CL_API_ENTRY cl_int CL_API_CALL name(type object) {                          \
    const cl_int failure = planned_failure(#name);                             \
    drop_reference(object);                                                    \
    const cl_int status = NEXT(name)(object);                                  \
    return failure != CL_SUCCESS ? failure : status;                           \
  }

PLAIN(clGetDeviceInfo,
      (cl_device_id device, cl_device_info what, size_t room, void *value,
       size_t *size),
      NEXT(clGetDeviceInfo)(device, what, room, value, size))
PLAIN(clGetMemObjectInfo,
      (cl_mem object, cl_mem_info what, size_t room, void *value, size_t *size),
      NEXT(clGetMemObjectInfo)(object, what, room, value, size))
PLAIN(clGetCommandQueueInfo,
      (cl_command_queue queue, cl_command_queue_info what, size_t room,
       void *value, size_t *size),
      NEXT(clGetCommandQueueInfo)(queue, what, room, value, size))
PLAIN(clGetEventProfilingInfo,
      (cl_event event, cl_profiling_info what, size_t room, void *value,
       size_t *size),
      NEXT(clGetEventProfilingInfo)(event, what, room, value, size))
PLAIN(clGetProgramBuildInfo,
      (cl_program program, cl_device_id device, cl_program_build_info what,
       size_t room, void *value, size_t *size),
      NEXT(clGetProgramBuildInfo)(program, device, what, room, value, size))
PLAIN(clBuildProgram,
      (cl_program program, cl_uint count, const cl_device_id *devices,
       const char *options, void(CL_CALLBACK *notify)(cl_program, void *),
       void *data),
      build(program, count, devices, options, notify, data))
PLAIN(clSetKernelArg,
      (cl_kernel kernel, cl_uint index, size_t size, const void *value),
      skipping ? CL_SUCCESS : NEXT(clSetKernelArg)(kernel, index, size, value))
PLAIN(clFinish, (cl_command_queue queue), NEXT(clFinish)(queue))
PLAIN(clWaitForEvents, (cl_uint count, const cl_event *events),
      NEXT(clWaitForEvents)(count, events))

ENQUEUE(clEnqueueFillBuffer,
        (cl_command_queue queue, cl_mem buffer, const void *pattern,
         size_t pattern_size, size_t offset, size_t size, cl_uint wait_count,
         const cl_event *wait_list, cl_event *event),
        NEXT(clEnqueueFillBuffer)(queue, buffer, pattern, pattern_size, offset,
                                  size, wait_count, wait_list, event))
ENQUEUE(clEnqueueReadBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset,
         size_t size, void *to, cl_uint wait_count, const cl_event *wait_list,
         cl_event *event),
        NEXT(clEnqueueReadBuffer)(queue, buffer, blocking, offset, size, to,
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
       make_program(context, count, strings, lengths, error))
CREATE(cl_kernel, clCreateKernel,
       (cl_program program, const char *name, cl_int *error),
       make_kernel(program, name, error))

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
  }
  return buffer;
}

RETAIN(clRetainContext, cl_context)
RETAIN(clRetainDevice, cl_device_id)
RETAIN(clRetainEvent, cl_event)

RELEASE(clReleaseContext, cl_context)
RELEASE(clReleaseDevice, cl_device_id)
RELEASE(clReleaseCommandQueue, cl_command_queue)
RELEASE(clReleaseProgram, cl_program)
RELEASE(clReleaseKernel, cl_kernel)
RELEASE(clReleaseEvent, cl_event)

CL_API_ENTRY cl_int CL_API_CALL clReleaseMemObject(cl_mem object) {
  const cl_int failure = planned_failure("clReleaseMemObject");
  const bool last = drop_reference(object) == 0;
  const cl_int status = NEXT(clReleaseMemObject)(object);
  if (last)
    drop_guards(object);
  return failure != CL_SUCCESS ? failure : status;
}
