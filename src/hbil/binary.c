/* Built programs that a caller's store has from an earlier run. */
#include "binary.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shared_programs.h"

/* --- hashes --- */

/* FNV-1a.  Each step is a bijection of the hash, so a single byte that differs
 * always shows.  The second start is any other number. */
static const cl_ulong start = 0xcbf29ce484222325u,
                      other_start = 0x9ae16a3b2f90u;

static cl_ulong hash_bytes(cl_ulong hash, const void *data, size_t size) {
  const unsigned char *bytes = data;
  for (size_t i = 0; i < size; ++i)
    hash = (hash ^ bytes[i]) * 0x100000001b3u;
  return hash;
}

/* The zero at the end separates texts. */
static cl_ulong hash_text(cl_ulong hash, const char *text) {
  return hash_bytes(hash, text, strlen(text) + 1);
}

/* --- identity --- */

enum { MOST_INFO = 1024 };

/* Adds what the device says; whatever is longer than usual is an error. */
static cl_int hash_device_info(const hbil_context *context, cl_device_info what,
                               cl_ulong *hash) {
  char info[MOST_INFO];
  size_t size = 0;
  const cl_int error =
      clGetDeviceInfo(context->device, what, sizeof info, info, &size);
  if (error == CL_SUCCESS)
    *hash = hash_bytes(*hash, info, size);
  return error;
}

static cl_int hash_platform_info(cl_platform_id platform, cl_platform_info what,
                                 cl_ulong *hash) {
  char info[MOST_INFO];
  size_t size = 0;
  const cl_int error =
      clGetPlatformInfo(platform, what, sizeof info, info, &size);
  if (error == CL_SUCCESS)
    *hash = hash_bytes(*hash, info, size);
  return error;
}

/* Everything about the device and its compiler that a binary may depend on. */
static cl_int hash_device(const hbil_context *context, cl_ulong *hash) {
  static const cl_device_info device[] = {CL_DEVICE_NAME,
                                          CL_DEVICE_VENDOR,
                                          CL_DEVICE_VENDOR_ID,
                                          CL_DEVICE_VERSION,
                                          CL_DRIVER_VERSION,
                                          CL_DEVICE_PROFILE,
                                          CL_DEVICE_OPENCL_C_VERSION,
                                          CL_DEVICE_ADDRESS_BITS,
                                          CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT};
  static const cl_platform_info of_platform[] = {
      CL_PLATFORM_NAME, CL_PLATFORM_VENDOR, CL_PLATFORM_VERSION};
  cl_platform_id platform = NULL;
  cl_int error = clGetDeviceInfo(context->device, CL_DEVICE_PLATFORM,
                                 sizeof platform, &platform, NULL);
  *hash = hash_text(start, hbil_version());
  for (size_t i = 0; i < sizeof device / sizeof *device; ++i)
    if (error == CL_SUCCESS)
      error = hash_device_info(context, device[i], hash);
  for (size_t i = 0; i < sizeof of_platform / sizeof *of_platform; ++i)
    if (error == CL_SUCCESS)
      error = hash_platform_info(platform, of_platform[i], hash);
  return error;
}

static cl_ulong hash_program(const hbil_context *context, cl_ulong from,
                             const char *text, const char *options) {
  cl_ulong hash = hash_bytes(from, &context->programs.device,
                             sizeof context->programs.device);
  hash = hash_text(hash, options);
  return hash_text(hash, text);
}

void binary_identify(const hbil_context *context, const char *name,
                     const char *text, const char *options,
                     binary_identity *out) {
  memset(out, 0, sizeof *out);
  out->is_new = true;
  snprintf(out->key, sizeof out->key, "%s-%016llx", name,
           (unsigned long long)hash_program(context, start, text, options));
  /* a key is no path, unlike the names of the radiance cache's programs */
  for (char *at = strchr(out->key, '/'); at; at = strchr(at, '/'))
    *at = '-';
  out->identity = hash_program(context, other_start, text, options);
}

/* --- what is stored --- */

/* Before the driver's binary.  Another byte order makes other numbers. */
typedef struct header {
  char magic[8];
  cl_ulong identity;
  cl_ulong size;     /* bytes of the binary */
  cl_ulong checksum; /* of the above and the binary */
} header;
static const char magic[8] = {'h', 'b', 'i', 'l', 'p', 'r', 'o', 'g'};

/* More bytes than any driver's binary of one of these programs has.  What is
 * larger is not even read. */
#define MOST_STORED ((size_t)64 << 20)

/* The header that belongs in front of `size` bytes of a binary. */
static header make_header(const binary_identity *identity,
                          const unsigned char *binary, size_t size) {
  header h = {.identity = identity->identity, .size = size};
  memcpy(h.magic, magic, sizeof magic);
  h.checksum = hash_bytes(hash_bytes(start, &h, offsetof(header, checksum)),
                          binary, size);
  return h;
}

/* The program from a binary, built; NULL if the driver rejects it. */
static cl_program create(const hbil_context *context, const char *options,
                         const unsigned char *binary, size_t size) {
  cl_int error = CL_SUCCESS, status = CL_SUCCESS;
  const cl_program program = clCreateProgramWithBinary(
      context->context, 1, &context->device, &size, &binary, &status, &error);
  if (!program)
    return NULL;
  if (status == CL_SUCCESS && clBuildProgram(program, 1, &context->device,
                                             options, NULL, NULL) == CL_SUCCESS)
    return program;
  clReleaseProgram(program);
  return NULL;
}

cl_program binary_load(hbil_context *context, const char *options,
                       const binary_identity *identity) {
  if (!context->programs.load)
    return NULL;
  void *const user = context->programs.user;
  const size_t size = context->programs.load(user, identity->key, NULL, 0);
  const bool is_possible = size > sizeof(header) && size <= MOST_STORED;
  unsigned char *data = is_possible ? malloc(size) : NULL;
  cl_program program = NULL;
  if (!size || (is_possible && !data))
    return NULL;
  if (data && context->programs.load(user, identity->key, data, size) == size) {
    const unsigned char *binary = data + sizeof(header);
    const header want = make_header(identity, binary, size - sizeof(header));
    if (!memcmp(data, &want, sizeof want))
      program = create(context, options, binary, size - sizeof(header));
  }
  free(data);
  if (!program)
    warn(context,
         "%s: what is stored is damaged, or not of this device and version; "
         "the program is built again",
         identity->key);
  return program;
}

/* --- storing --- */

/* A program may be of many devices; those of a plan are built for one. */
enum { MOST_DEVICES = 64 };

/* The binary of the context's device, with room for a header in front,
 * malloc'd; NULL if there is none. */
static unsigned char *read_binary(const hbil_context *context,
                                  cl_program program, size_t *size) {
  cl_device_id devices[MOST_DEVICES];
  size_t sizes[MOST_DEVICES] = {0};
  unsigned char *binaries[MOST_DEVICES] = {NULL}, *data = NULL;
  cl_uint count = 0, i = 0;
  if (clGetProgramInfo(program, CL_PROGRAM_NUM_DEVICES, sizeof count, &count,
                       NULL) != CL_SUCCESS ||
      count > MOST_DEVICES ||
      clGetProgramInfo(program, CL_PROGRAM_DEVICES, sizeof devices, devices,
                       NULL) != CL_SUCCESS ||
      clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof sizes, sizes,
                       NULL) != CL_SUCCESS)
    return NULL;
  while (i < count && devices[i] != context->device)
    ++i;
  if (i == count || !sizes[i] || !(data = malloc(sizeof(header) + sizes[i])))
    return NULL;
  binaries[i] = data + sizeof(header);
  *size = sizes[i];
  /* rusticl 22.3 ends the process if there is room for more than there are */
  if (clGetProgramInfo(program, CL_PROGRAM_BINARIES, count * sizeof *binaries,
                       binaries, NULL) == CL_SUCCESS)
    return data;
  free(data);
  return NULL;
}

void binary_store(hbil_context *context, cl_program program,
                  const binary_identity *identity) {
  size_t size = 0;
  if (!context->programs.store || !identity->is_new)
    return;
  unsigned char *data = read_binary(context, program, &size);
  if (!data) {
    warn(context, "%s: the driver does not give the binary away",
         identity->key);
    return;
  }
  const header h = make_header(identity, data + sizeof h, size);
  memcpy(data, &h, sizeof h);
  context->programs.store(context->programs.user, identity->key, data,
                          sizeof h + size);
  free(data);
}

/* --- public --- */

hbil_status hbil_context_set_program_store(hbil_context *context,
                                           hbil_program_load load,
                                           hbil_program_store store,
                                           void *user) {
  cl_ulong device = 0;
  if (!context)
    return fail_null(NULL, __func__, "context");
  if (!load != !store)
    return fail_null(context, __func__, load ? "store" : "load");
  const cl_int error = load ? hash_device(context, &device) : CL_SUCCESS;
  if (error != CL_SUCCESS)
    return fail_cl(context, error,
                   "hbil_context_set_program_store: "
                   "clGetDeviceInfo");
  free(context->programs.folder);
  context->programs.folder = NULL;
  /* the new store must get them, too */
  forget_shared_programs(context);
  context->programs.device = device;
  context->programs.load = load;
  context->programs.store = store;
  context->programs.user = user;
  return HBIL_SUCCESS;
}
