#define _GNU_SOURCE /* RTLD_NEXT */
#include "test/support/shim_programs.h"

#include "test/support/shim.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdint.h>
#include <string.h>

enum { MOST_PROGRAMS = 2048 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

/* Programs that the library holds, and the built ones that stand in for them.
 */
static struct open_program {
  cl_program program; /* NULL: a free entry */
  cl_context context;
  uint64_t source; /* a hash */
  cl_program built;
} opened[MOST_PROGRAMS];

/* Programs that were built; the shim holds a reference to each. */
static struct built_program {
  cl_program program; /* NULL: a free entry */
  cl_context context;
  uint64_t key; /* a hash of source and options */
} built[MOST_PROGRAMS];

static bool skipping;
static cl_program idle_program; /* built, with the kernel "idle" */

/* FNV-1a */
static uint64_t hash_text(uint64_t hash, const char *text) {
  for (; *text; ++text)
    hash = (hash ^ (unsigned char)*text) * 0x100000001b3u;
  return hash;
}

/* The entry of a program; NULL asks for a free one. */
static struct open_program *find_opened(cl_program program) {
  for (int i = 0; i < MOST_PROGRAMS; ++i)
    if (opened[i].program == program)
      return &opened[i];
  if (!program)
    shim_give_up("more programs than the shim has room for");
  return NULL;
}

static cl_program find_built(cl_context context, uint64_t key) {
  for (int i = 0; i < MOST_PROGRAMS; ++i)
    if (built[i].program && built[i].context == context && built[i].key == key)
      return built[i].program;
  return NULL;
}

static void add_built(cl_program program, cl_context context, uint64_t key) {
  int i = 0;
  while (i < MOST_PROGRAMS && built[i].program)
    ++i;
  if (i == MOST_PROGRAMS || NEXT(clRetainProgram)(program) != CL_SUCCESS)
    return; /* it will be built again */
  built[i].program = program;
  built[i].context = context;
  built[i].key = key;
}

/* `lengths` are NULL: the strings end with a zero. */
cl_program programs_create(cl_context context, cl_uint count,
                           const char **strings, const size_t *lengths,
                           cl_int *error) {
  uint64_t source = 0xcbf29ce484222325u;
  const cl_program program =
      NEXT(clCreateProgramWithSource)(context, count, strings, lengths, error);
  if (!program)
    return NULL;
  for (cl_uint i = 0; i < count; ++i)
    source = hash_text(source, strings[i]);
  pthread_mutex_lock(&lock);
  *find_opened(NULL) = (struct open_program){program, context, source, NULL};
  pthread_mutex_unlock(&lock);
  return program;
}

cl_int programs_build(cl_program program, cl_uint count,
                      const cl_device_id *devices, const char *options,
                      void(CL_CALLBACK *notify)(cl_program, void *),
                      void *data) {
  if (skipping)
    return CL_SUCCESS;
  pthread_mutex_lock(&lock);
  struct open_program *entry = find_opened(program);
  const uint64_t key = entry ? hash_text(entry->source, options) : 0;
  if (entry)
    entry->built = find_built(entry->context, key);
  const bool found = entry && entry->built;
  pthread_mutex_unlock(&lock);
  if (found)
    return CL_SUCCESS;
  const cl_int error =
      NEXT(clBuildProgram)(program, count, devices, options, notify, data);
  pthread_mutex_lock(&lock);
  entry = find_opened(program);
  if (error == CL_SUCCESS && entry)
    add_built(program, entry->context, key);
  pthread_mutex_unlock(&lock);
  return error;
}

void shim_skip_builds(bool skip) {
  skipping = skip;
  if (!skip && idle_program) {
    NEXT(clReleaseProgram)(idle_program);
    idle_program = NULL;
  }
}

int shim_begin_skipping(void **state) {
  (void)state;
  shim_skip_builds(true);
  return 0;
}

int shim_end_skipping(void **state) {
  (void)state;
  shim_skip_builds(false);
  return 0;
}

static cl_kernel idle_kernel(cl_program program, cl_int *error) {
  const char *source = "__kernel void idle(void) {}";
  if (!idle_program) {
    cl_context context = NULL;
    NEXT(clGetProgramInfo)
    (program, CL_PROGRAM_CONTEXT, sizeof context, &context, NULL);
    idle_program =
        NEXT(clCreateProgramWithSource)(context, 1, &source, NULL, error);
    if (!idle_program ||
        NEXT(clBuildProgram)(idle_program, 0, NULL, "", NULL, NULL))
      shim_give_up("the idle kernel cannot be built");
  }
  return NEXT(clCreateKernel)(idle_program, "idle", error);
}

/* The program that was built in place of this one. */
static cl_program built_for(cl_program program) {
  pthread_mutex_lock(&lock);
  const struct open_program *entry = find_opened(program);
  const cl_program from = entry && entry->built ? entry->built : program;
  pthread_mutex_unlock(&lock);
  return from;
}

cl_kernel programs_kernel(cl_program program, const char *name, cl_int *error) {
  return skipping ? idle_kernel(program, error)
                  : NEXT(clCreateKernel)(built_for(program), name, error);
}

cl_int programs_info(cl_program program, cl_program_info what, size_t room,
                     void *value, size_t *size) {
  return NEXT(clGetProgramInfo)(built_for(program), what, room, value, size);
}

/* Arguments that were set, by kernel and index. */
enum { MOST_ARGUMENTS = 1024, LARGEST_ARGUMENT = 1024, LONGEST_NAME = 32 };
static struct argument {
  char kernel[LONGEST_NAME]; /* empty: a free entry */
  cl_uint index;
  size_t size;
  unsigned char value[LARGEST_ARGUMENT];
} arguments[MOST_ARGUMENTS];

static struct argument *find_argument(const char *kernel, cl_uint index) {
  int i = 0;
  while (i < MOST_ARGUMENTS && arguments[i].kernel[0] &&
         (arguments[i].index != index || strcmp(arguments[i].kernel, kernel)))
    ++i;
  if (i == MOST_ARGUMENTS)
    shim_give_up("more arguments than the shim has room for");
  return &arguments[i];
}

static void keep_argument(cl_kernel kernel, cl_uint index, size_t size,
                          const void *value) {
  char name[LONGEST_NAME];
  if (!value || size > LARGEST_ARGUMENT ||
      NEXT(clGetKernelInfo)(kernel, CL_KERNEL_FUNCTION_NAME, sizeof name, name,
                            NULL) != CL_SUCCESS)
    return;
  pthread_mutex_lock(&lock);
  struct argument *entry = find_argument(name, index);
  strcpy(entry->kernel, name);
  entry->index = index;
  entry->size = size;
  memcpy(entry->value, value, size);
  pthread_mutex_unlock(&lock);
}

bool shim_has_argument(const char *kernel, cl_uint index) {
  pthread_mutex_lock(&lock);
  const bool has = find_argument(kernel, index)->size > 0;
  pthread_mutex_unlock(&lock);
  return has;
}

void shim_argument(const char *kernel, cl_uint index, size_t size,
                   void *value) {
  pthread_mutex_lock(&lock);
  const struct argument *entry = find_argument(kernel, index);
  if (!entry->kernel[0] || entry->size != size)
    shim_give_up("an argument was asked for that no kernel has had");
  memcpy(value, entry->value, size);
  pthread_mutex_unlock(&lock);
}

cl_int programs_set_argument(cl_kernel kernel, cl_uint index, size_t size,
                             const void *value) {
  if (skipping)
    return CL_SUCCESS;
  keep_argument(kernel, index, size, value);
  return NEXT(clSetKernelArg)(kernel, index, size, value);
}

void programs_forget(cl_program program) {
  pthread_mutex_lock(&lock);
  struct open_program *entry = find_opened(program);
  if (entry)
    entry->program = NULL;
  pthread_mutex_unlock(&lock);
}

void programs_forget_context(cl_context context) {
  pthread_mutex_lock(&lock);
  for (int i = 0; i < MOST_PROGRAMS; ++i)
    if (built[i].program && built[i].context == context) {
      NEXT(clReleaseProgram)(built[i].program);
      built[i].program = NULL;
    }
  pthread_mutex_unlock(&lock);
}
