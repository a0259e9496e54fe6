/* OpenCL programs: one per pass, from the embedded sources or, while working on
 * them, from the folder that HBIL_KERNEL_DIR names. */
#include "internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *embedded(const char *name) {
  for (const kernel_source *s = kernel_sources; s->name; ++s)
    if (!strcmp(s->name, name))
      return s->text;
  return NULL;
}

/* The whole of a file as a malloc'd string; NULL if it cannot be read. */
static char *read_text(const char *path) {
  FILE *file = fopen(path, "rb");
  char *text = NULL;
  long size = -1;
  if (!file)
    return NULL;
  if (!fseek(file, 0, SEEK_END) && (size = ftell(file)) >= 0 &&
      !fseek(file, 0, SEEK_SET) && (text = malloc((size_t)size + 1))) {
    text[fread(text, 1, (size_t)size, file)] = '\0';
  }
  fclose(file);
  return text;
}

/* The text of a kernel file, malloc'd if *owned. */
static const char *source_text(hbil_context *context, const char *name,
                               bool *owned) {
  const char *folder = getenv("HBIL_KERNEL_DIR");
  *owned = folder && *folder;
  if (!*owned)
    return embedded(name);
  const size_t size = strlen(folder) + strlen(name) + 2;
  char *path = malloc(size), *text = NULL;
  if (path) {
    snprintf(path, size, "%s/%s", folder, name);
    text = read_text(path);
    if (!text)
      fail(context, HBIL_BUILD_FAILED, "HBIL_KERNEL_DIR: cannot read %s", path);
  }
  free(path);
  return text;
}

static hbil_status build_failure(hbil_context *context, cl_program program,
                                 const char *pass, cl_int error) {
  size_t size = 0;
  char *log = NULL;
  if (clGetProgramBuildInfo(program, context->device, CL_PROGRAM_BUILD_LOG, 0,
                            NULL, &size) == CL_SUCCESS &&
      (log = calloc(1, size + 1)))
    clGetProgramBuildInfo(program, context->device, CL_PROGRAM_BUILD_LOG, size,
                          log, NULL);
  fail(context, HBIL_BUILD_FAILED, "clBuildProgram(%s.cl): %s (%d)\n%s", pass,
       cl_error_name(error), (int)error, log ? log : "");
  free(log);
  return HBIL_BUILD_FAILED;
}

/* --- the texts of a program --- */

/* Each file behind a #line of its own, so that logs name it. */
enum { MOST_FILES = 5 };
typedef struct sources {
  cl_uint count; /* of text: two to a file */
  const char *text[2 * MOST_FILES];
  bool owned[2 * MOST_FILES];
  char line[MOST_FILES][96];
} sources;

static hbil_status add_file(hbil_context *context, sources *s,
                            const char *name) {
  const cl_uint at = s->count;
  char *line = s->line[at / 2];
  snprintf(line, sizeof s->line[0], "\n%s#line 1 \"%s\"\n",
           at ? "" : "#pragma OPENCL FP_CONTRACT OFF\n", name);
  s->text[at] = line;
  s->text[at + 1] = source_text(context, name, &s->owned[at + 1]);
  s->count += 2;
  if (s->text[at + 1])
    return HBIL_SUCCESS;
  return s->owned[at + 1] ? HBIL_BUILD_FAILED
                          : fail(context, HBIL_BUILD_FAILED,
                                 "%s is not in the library", name);
}

static hbil_status add_files(hbil_context *context, const program_kind *kind,
                             sources *s) {
  char pass_file[64];
  snprintf(pass_file, sizeof pass_file, "%s.cl", kind->name);
  hbil_status status = add_file(context, s, "hbil_shared.h");
  if (status == HBIL_SUCCESS)
    status = add_file(context, s, "common.clh");
  if (status == HBIL_SUCCESS && kind->images)
    status = add_file(context, s, "images.clh");
  if (status == HBIL_SUCCESS && kind->places)
    status = add_file(context, s, "places.clh");
  if (status == HBIL_SUCCESS && kind->guide)
    status = add_file(context, s, "guide.clh");
  if (status == HBIL_SUCCESS && kind->factors)
    status = add_file(context, s, "horizon_cache.clh");
  return status == HBIL_SUCCESS ? add_file(context, s, pass_file) : status;
}

static void free_files(sources *s) {
  for (cl_uint i = 0; i < s->count; ++i)
    if (s->owned[i])
      free((void *)(size_t)s->text[i]);
}

static bool in_name(char c) {
  return c == '_' || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') ||
         (c >= 'a' && c <= 'z');
}

/* Whether a text has the word `name` of `length` characters. */
static bool has_word(const char *text, const char *name, size_t length) {
  for (const char *at = strchr(text, *name); at; at = strchr(at + 1, *name))
    if (!strncmp(at, name, length) && !in_name(at[length]) &&
        (at == text || !in_name(at[-1])))
      return true;
  return false;
}

/* Copies those of `defines`, "-DNAME=VALUE" with spaces between, whose names
 * the texts have.  What differs in nothing that a program asks for is then the
 * same program to a driver that keeps what it has compiled. */
static void add_defines(const sources *s, const char *defines, char *options,
                        size_t size) {
  size_t length = strlen(options);
  while (*defines) {
    const size_t define = strcspn(defines, " ");
    const char *name = defines + strlen("-D");
    const size_t name_length = strcspn(name, "=");
    bool used = false;
    for (cl_uint i = 1; i < s->count && !used; i += 2)
      used = has_word(s->text[i], name, name_length);
    if (used && length + define + 2 < size) {
      options[length++] = ' ';
      memcpy(options + length, defines, define);
      length += define;
    }
    defines += define;
    defines += *defines == ' ';
  }
  options[length] = '\0';
}

/* --- building --- */

static hbil_status build(hbil_context *context, cl_program program,
                         const program_kind *kind, const char *options) {
  const cl_int error =
      clBuildProgram(program, 1, &context->device, options, NULL, NULL);
  if (error == CL_SUCCESS)
    return HBIL_SUCCESS;
  /* whatever is not for want of memory is the kernel's or the compiler's */
  return status_of(error) == HBIL_OPENCL_ERROR
             ? build_failure(context, program, kind->name, error)
             : fail_cl(context, error, "clBuildProgram");
}

static hbil_status build_files(hbil_context *context, const program_kind *kind,
                               const sources *s, const char *defines,
                               cl_program *out) {
  char options[MOST_DEFINES + 128];
  cl_int error = CL_SUCCESS;
  snprintf(options, sizeof options, "-cl-std=CL1.2%s%s",
           kind->defines ? kind->defines : "",
           kind->fast              ? " -cl-fast-relaxed-math"
           : context->exact_divide ? " -cl-fp32-correctly-rounded-divide-sqrt"
                                   : "");
  add_defines(s, defines, options, sizeof options);
  *out = clCreateProgramWithSource(
      context->context, s->count, (const char **)(size_t)s->text, NULL, &error);
  if (!*out)
    return fail_cl(context, error, "clCreateProgramWithSource");
  const hbil_status status = build(context, *out, kind, options);
  if (status != HBIL_SUCCESS) {
    clReleaseProgram(*out);
    *out = NULL;
  }
  return status;
}

hbil_status program_build(hbil_context *context, const program_kind *kind,
                          const char *defines, cl_program *out) {
  sources s = {.count = 0};
  *out = NULL;
  hbil_status status = add_files(context, kind, &s);
  if (status == HBIL_SUCCESS)
    status = build_files(context, kind, &s, defines, out);
  free_files(&s);
  return status;
}
