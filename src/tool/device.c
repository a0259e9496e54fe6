/* Lists the machine's OpenCL devices and opens one of them. */
#include "tool/device.h"

#include "image/error.h"
#include "tool/drivers.h"
#include "tool/last_words.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct device_entry {
  cl_platform_id platform;
  cl_device_id id;
} device_entry;

typedef struct device_entries {
  size_t count;
  device_entry *list;
  char *note; /* see driver_cache_prepare() */
} device_entries;

static void free_entries(device_entries *entries) {
  free(entries->list);
  free(entries->note);
  last_words_driver(NULL);
}

/* What the loader and the platforms answered that have no device; or which
 * drivers can't be loaded, and why. */
typedef struct answers {
  char text[2048];
  size_t length;
} answers;

static void add_text(void *user, const char *who, const char *what) {
  answers *all = user;
  const size_t room = sizeof all->text - all->length;
  const int length = snprintf(all->text + all->length, room, "%s%s: %s",
                              all->length ? ", " : "", who, what);
  if (length > 0)
    all->length += (size_t)length < room ? (size_t)length : room - 1;
}

static void add_answer(answers *all, const char *who, cl_int status) {
  char what[32] = "no device";
  /* the loader's CL_PLATFORM_NOT_FOUND_KHR, and CL_SUCCESS with a count of 0 */
  if (status == -1001)
    snprintf(what, sizeof what, "no platform");
  else if (status != CL_SUCCESS && status != CL_DEVICE_NOT_FOUND)
    snprintf(what, sizeof what, "OpenCL error %d", (int)status);
  add_text(all, who, what);
}

static int no_device(const answers *none, image_error *error) {
  answers failures = {"", 0};
  drivers_check(add_text, &failures);
  return failures.length
             ? image_fail(error,
                          "no OpenCL device (%s); a driver can't be loaded: %s",
                          none->text, failures.text)
             : image_fail(error,
                          "no OpenCL device (%s); a driver is needed, for "
                          "example Debian's pocl-opencl-icd",
                          none->text);
}

static void platform_name(cl_platform_id platform, char name[256]) {
  if (clGetPlatformInfo(platform, CL_PLATFORM_NAME, 256, name, NULL) !=
      CL_SUCCESS)
    snprintf(name, 256, "a platform without a name");
  name[255] = '\0';
}

static int is_pocl(const char *platform) {
  return strcmp(platform, "Portable Computing Language") == 0;
}

static int add_platform(device_entries *entries, cl_platform_id platform,
                        const image_error *no_cache, answers *none) {
  cl_uint count = 0;
  char name[256];
  platform_name(platform, name);
  const cl_int status =
      clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, NULL, &count);
  if (status != CL_SUCCESS || count == 0) {
    if (no_cache->text[0] && is_pocl(name))
      add_text(none, name, no_cache->text);
    else
      add_answer(none, name, status);
    return 0;
  }
  cl_device_id *ids = calloc(count, sizeof *ids);
  device_entry *list =
      realloc(entries->list, (entries->count + count) * sizeof *list);
  if (list)
    entries->list = list;
  if (!ids || !list) {
    free(ids);
    return -1;
  }
  if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, ids, NULL) ==
      CL_SUCCESS)
    for (cl_uint i = 0; i < count; i++)
      list[entries->count++] = (device_entry){platform, ids[i]};
  free(ids);
  return 0;
}

/* All devices, platform by platform, in OpenCL's order. */
static int find_devices(device_entries *out, image_error *error) {
  cl_uint count = 0;
  int failed = 0;
  answers none = {"", 0};
  image_error no_cache = {""};
  memset(out, 0, sizeof *out);
  last_words_driver("listed its devices");
  /* PoCL looks at it already when the loader finds it */
  driver_cache_prepare(&out->note, &no_cache);
  cl_int status = clGetPlatformIDs(0, NULL, &count);
  if (status != CL_SUCCESS)
    count = 0;
  cl_platform_id *platforms = calloc(count + 1, sizeof *platforms);
  if (!platforms)
    return image_no_memory(error, "devices");
  if (count > 0)
    status = clGetPlatformIDs(count, platforms, NULL);
  if (status != CL_SUCCESS || count == 0)
    add_answer(&none, "OpenCL's loader", status);
  else
    for (cl_uint i = 0; i < count && !failed; i++)
      failed = add_platform(out, platforms[i], &no_cache, &none);
  free(platforms);
  if (failed)
    image_no_memory(error, "devices");
  else if (out->count == 0)
    failed = no_device(&none, error);
  if (failed)
    free_entries(out);
  return failed;
}

static void device_text(cl_device_id id, cl_device_info what, char *text,
                        size_t size) {
  text[0] = '\0';
  if (clGetDeviceInfo(id, what, size, text, NULL) != CL_SUCCESS)
    snprintf(text, size, "?");
  text[size - 1] = '\0';
}

static cl_device_type device_type(cl_device_id id) {
  cl_device_type type = 0;
  clGetDeviceInfo(id, CL_DEVICE_TYPE, sizeof type, &type, NULL);
  return type;
}

static const char *type_name(cl_device_type type) {
  if (type & CL_DEVICE_TYPE_GPU)
    return "GPU";
  if (type & CL_DEVICE_TYPE_CPU)
    return "CPU";
  return type & CL_DEVICE_TYPE_ACCELERATOR ? "accelerator" : "other";
}

unsigned long long device_memory(cl_device_id id) {
  cl_ulong bytes = 0;
  clGetDeviceInfo(id, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof bytes, &bytes, NULL);
  return bytes;
}

int device_list(image_error *error) {
  device_entries entries;
  if (find_devices(&entries, error) != 0)
    return -1;
  for (size_t i = 0; i < entries.count; i++) {
    char name[256], platform[256], version[256];
    cl_uint units = 0;
    const cl_device_id id = entries.list[i].id;
    device_text(id, CL_DEVICE_NAME, name, sizeof name);
    device_text(id, CL_DEVICE_VERSION, version, sizeof version);
    platform_name(entries.list[i].platform, platform);
    clGetDeviceInfo(id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units,
                    NULL);
    printf("%zu  %s (%s, %s; %s; %u compute units, %llu MiB)\n", i, name,
           type_name(device_type(id)), platform, version, units,
           device_memory(id) >> 20);
  }
  free_entries(&entries);
  return 0;
}

static int contains(const char *text, const char *part) {
  const size_t length = strlen(part);
  for (; *text && length; text++) {
    size_t i = 0;
    while (i < length && text[i] &&
           tolower((unsigned char)text[i]) == tolower((unsigned char)part[i]))
      i++;
    if (i == length)
      return 1;
  }
  return 0;
}

static size_t default_device(const device_entries *entries) {
  for (size_t i = 0; i < entries->count; i++)
    if (device_type(entries->list[i].id) & CL_DEVICE_TYPE_GPU)
      return i;
  return 0;
}

/* The index of the wanted device; the number of devices if there is none. */
static size_t choose(const device_entries *entries, const char *wanted) {
  char *end;
  if (!wanted)
    return default_device(entries);
  const unsigned long index = strtoul(wanted, &end, 10);
  if (isdigit((unsigned char)wanted[0]) && !*end)
    return index < entries->count ? index : entries->count;
  size_t i = 0;
  for (; i < entries->count; i++) {
    char name[256];
    device_text(entries->list[i].id, CL_DEVICE_NAME, name, sizeof name);
    if (contains(name, wanted))
      break;
  }
  return i;
}

static int open_queue(const device_entry *entry, int profiling, device *out,
                      image_error *error) {
  const cl_context_properties properties[] = {
      CL_CONTEXT_PLATFORM, (cl_context_properties)entry->platform, 0};
  cl_int status;
  out->id = entry->id;
  device_text(entry->id, CL_DEVICE_NAME, out->name, sizeof out->name);
  out->uses_host_memory = (device_type(entry->id) & CL_DEVICE_TYPE_CPU) != 0;
  device_text(entry->id, CL_DRIVER_VERSION, out->driver, sizeof out->driver);
  out->context =
      clCreateContext(properties, 1, &entry->id, NULL, NULL, &status);
  if (status == CL_SUCCESS)
    out->queue = clCreateCommandQueue(out->context, entry->id,
                                      profiling ? CL_QUEUE_PROFILING_ENABLE : 0,
                                      &status);
  if (status == CL_SUCCESS)
    return 0;
  image_fail(error,
             "device %s: cannot be used (OpenCL error %d); another one "
             "of hbil devices is needed",
             out->name, (int)status);
  device_close(out);
  return -1;
}

int device_open(const char *wanted, int profiling, device *out,
                image_error *error) {
  device_entries entries;
  memset(out, 0, sizeof *out);
  if (find_devices(&entries, error) != 0)
    return -1;
  const size_t chosen = choose(&entries, wanted);
  const int failed =
      chosen < entries.count
          ? open_queue(&entries.list[chosen], profiling, out, error)
          : image_fail(error,
                       "--device %s: no such device; an index or a part of a "
                       "name that hbil devices lists is needed",
                       wanted);
  if (!failed) {
    char name[256];
    device_platform(out->id, name);
    out->note = is_pocl(name) ? entries.note : NULL;
    if (out->note)
      entries.note = NULL;
  }
  free_entries(&entries);
  last_words_driver(failed ? NULL : "was opened");
  return failed;
}

void device_platform(cl_device_id id, char name[256]) {
  cl_platform_id platform = NULL;
  clGetDeviceInfo(id, CL_DEVICE_PLATFORM, sizeof platform, &platform, NULL);
  platform_name(platform, name);
}

void device_close(device *d) {
  if (d->queue)
    clReleaseCommandQueue(d->queue);
  if (d->context)
    clReleaseContext(d->context);
  free(d->note);
  last_words_driver(NULL);
  memset(d, 0, sizeof *d);
}
