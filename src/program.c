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

static hbil_status build(hbil_context *context, cl_program program,
                         const char *pass, const char *defines, bool fast) {
  char options[4096];
  const int length = snprintf(options, sizeof options, "-cl-std=CL1.2 %s%s",
                              fast ? "-cl-fast-relaxed-math "
                              : context->exact_divide
                                  ? "-cl-fp32-correctly-rounded-divide-sqrt "
                                  : "",
                              defines);
  if (length < 0 || (size_t)length >= sizeof options)
    return fail(context, HBIL_BUILD_FAILED, "%s.cl: build options too long",
                pass);
  const cl_int error =
      clBuildProgram(program, 1, &context->device, options, NULL, NULL);
  if (error == CL_SUCCESS)
    return HBIL_SUCCESS;
  /* whatever is not for want of memory is the kernel's or the compiler's */
  return status_of(error) == HBIL_OPENCL_ERROR
             ? build_failure(context, program, pass, error)
             : fail_cl(context, error, "clBuildProgram");
}

hbil_status program_build(hbil_context *context, const char *pass,
                          const char *defines, bool fast, cl_program *out) {
  /* Each file behind a #line of its own, so that logs name it. */
  enum { FILES = 3 };
  char pass_file[64], lines[FILES][96];
  snprintf(pass_file, sizeof pass_file, "%s.cl", pass);
  const char *names[FILES] = {"hbil_shared.h", "common.clh", pass_file};
  const char *texts[2 * FILES] = {NULL};
  bool owned[FILES] = {false};
  hbil_status status = HBIL_SUCCESS;
  cl_int error = CL_SUCCESS;
  *out = NULL;
  for (int i = 0; i < FILES && status == HBIL_SUCCESS; ++i) {
    snprintf(lines[i], sizeof lines[i], "\n%s#line 1 \"%s\"\n",
             i ? "" : "#pragma OPENCL FP_CONTRACT OFF\n", names[i]);
    texts[2 * i] = lines[i];
    texts[2 * i + 1] = source_text(context, names[i], &owned[i]);
    if (!texts[2 * i + 1])
      status = owned[i] ? HBIL_BUILD_FAILED
                        : fail(context, HBIL_BUILD_FAILED,
                               "%s is not in the library", names[i]);
  }
  if (status == HBIL_SUCCESS) {
    *out = clCreateProgramWithSource(context->context, 2 * FILES, texts, NULL,
                                     &error);
    status = *out ? build(context, *out, pass, defines, fast)
                  : fail_cl(context, error, "clCreateProgramWithSource");
  }
  for (int i = 0; i < FILES; ++i)
    if (owned[i])
      free((void *)(size_t)texts[2 * i + 1]);
  if (status != HBIL_SUCCESS && *out) {
    clReleaseProgram(*out);
    *out = NULL;
  }
  return status;
}
