/* OpenCL programs: one per pass, from the embedded sources or, while working on
 * them, from the folder that HBIL_KERNEL_DIR names. */
#define _GNU_SOURCE /* secure_getenv() */
#include "program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "regular_file.h"
#include "shared_programs.h"

/* --- the text of a file --- */

static const char *embedded(const char *name) {
  for (const kernel_source *s = kernel_sources; s->name; ++s)
    if (!strcmp(s->name, name))
      return s->text;
  return NULL;
}

/* The whole of a file as a malloc'd string; NULL if it cannot be read. */
static char *read_text(const char *path) {
  size_t size;
  FILE *file = open_regular_file(path, &size);
  if (!file)
    return NULL;
  char *text = malloc(size + 1);
  if (text)
    text[fread(text, 1, size, file)] = '\0';
  fclose(file);
  return text;
}

/* The folder of kernels that replace the embedded ones; NULL: none.  Whoever
 * runs a program that has more rights than they have (setuid) must not choose
 * its code. */
static const char *kernel_folder(void) {
  static const char name[] = "HBIL_KERNEL_DIR";
#ifdef HBIL_HAS_SECURE_GETENV
  const char *folder = secure_getenv(name);
#else
  const char *folder =
      getuid() == geteuid() && getgid() == getegid() ? getenv(name) : NULL;
#endif
  return folder && *folder ? folder : NULL;
}

void program_report_folder(hbil_context *context) {
  if (kernel_folder())
    warn(context,
         "HBIL_KERNEL_DIR: kernels are read from %s, not from the library",
         kernel_folder());
}

/* The text of a kernel file, malloc'd if *owned; NULL after fail(). */
static const char *source_text(hbil_context *context, const char *name,
                               bool *owned) {
  const char *folder = kernel_folder();
  *owned = folder != NULL;
  if (!*owned) {
    const char *text = embedded(name);
    if (!text)
      fail(context, HBIL_BUILD_FAILED, "%s is not in the library", name);
    return text;
  }
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

/* --- expanding #include lines --- */

/* A program's text so far, and the files that are in it. */
enum { MOST_FILES = 48, MOST_NAME = 64 };
typedef struct source {
  char *text;
  size_t length, room;
  int files;
  char file[MOST_FILES][MOST_NAME];
} source;

static hbil_status append(hbil_context *context, source *s, const char *text,
                          size_t length) {
  if (s->length + length + 1 > s->room) {
    const size_t room = 2 * (s->length + length + 1);
    char *grown = realloc(s->text, room);
    if (!grown)
      return fail(context, HBIL_OUT_OF_HOST_MEMORY, "no memory for a program");
    s->text = grown;
    s->room = room;
  }
  memcpy(s->text + s->length, text, length);
  s->length += length;
  s->text[s->length] = '\0';
  return HBIL_SUCCESS;
}

/* Tells the compiler where the next line is from, so that build logs name
 * files. */
static hbil_status append_position(hbil_context *context, source *s,
                                   const char *name, int line) {
  char text[MOST_NAME + 32];
  const int length =
      snprintf(text, sizeof text, "#line %d \"%s\"\n", line, name);
  return append(context, s, text, (size_t)length);
}

/* The name in a line `#include "name"`; false for any other line. */
static bool read_include(const char *line, char name[MOST_NAME]) {
  static const char keyword[] = "#include \"";
  const size_t length = sizeof keyword - 1;
  if (strncmp(line, keyword, length))
    return false;
  const size_t named = strcspn(line + length, "\"\n");
  if (line[length + named] != '"' || named >= MOST_NAME)
    return false;
  memcpy(name, line + length, named);
  name[named] = '\0';
  return true;
}

static hbil_status append_file(hbil_context *context, source *s,
                               const char *name);

static hbil_status append_lines(hbil_context *context, source *s,
                                const char *name, const char *text) {
  hbil_status status = append_position(context, s, name, 1);
  for (int line = 1; *text && status == HBIL_SUCCESS; ++line) {
    char included[MOST_NAME];
    const size_t length = strcspn(text, "\n") + 1;
    if (read_include(text, included)) {
      status = append_file(context, s, included);
      if (status == HBIL_SUCCESS)
        status = append_position(context, s, name, line + 1);
    } else {
      status = append(context, s, text, length);
    }
    text += length;
  }
  return status;
}

static hbil_status append_file(hbil_context *context, source *s,
                               const char *name) {
  for (int i = 0; i < s->files; ++i)
    if (!strcmp(s->file[i], name))
      return HBIL_SUCCESS;
  if (s->files == MOST_FILES)
    return fail(context, HBIL_BUILD_FAILED, "%s: more than %d kernel files",
                name, MOST_FILES);
  snprintf(s->file[s->files++], MOST_NAME, "%s", name);
  bool owned;
  const char *text = source_text(context, name, &owned);
  if (!text)
    return HBIL_BUILD_FAILED;
  const hbil_status status = append_lines(context, s, name, text);
  if (owned)
    free((void *)(size_t)text);
  return status;
}

/* Replaces comments by spaces, since a program gets the defines that its text
 * names, and a comment may name one that the code doesn't use.  Line numbers
 * stay as they are.  Kernels have no comment of several lines in a #define, no
 * comments that begin with two slashes, and no strings. */
static void blank_comments(char *text) {
  bool inside = false;
  for (; *text; ++text)
    if (!strncmp(text, inside ? "*/" : "/*", 2)) {
      text[0] = text[1] = ' ';
      ++text;
      inside = !inside;
    } else if (inside && *text != '\n') {
      *text = ' ';
    }
}

/* --- defines --- */

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

/* Appends those of `defines` to the options whose names the text has, and `own`
 * has not. */
static hbil_status add_defines(hbil_context *context, const char *text,
                               const char *defines, const char *own,
                               char *options, size_t size) {
  size_t length = strlen(options);
  while (*defines) {
    const size_t define = strcspn(defines, " ");
    const char *name = defines + strlen("-D");
    /* in `own` the name follows a D, too */
    const size_t length_of_name = strcspn(name, "=");
    if (define > 0 && has_word(text, name, length_of_name) &&
        !(*own && has_word(own, name - 1, length_of_name + 1))) {
      if (length + define + 2 > size)
        return fail(context, HBIL_BUILD_FAILED,
                    "the build options don't fit into %zu characters", size);
      options[length++] = ' ';
      memcpy(options + length, defines, define);
      length += define;
    }
    defines += define;
    defines += *defines == ' ';
  }
  options[length] = '\0';
  return HBIL_SUCCESS;
}

/* --- building --- */

/* The compiler's log as a malloc'd string; NULL if there is none. */
static char *build_log(const hbil_context *context, cl_program program) {
  size_t size = 0;
  char *log = NULL;
  if (clGetProgramBuildInfo(program, context->device, CL_PROGRAM_BUILD_LOG, 0,
                            NULL, &size) == CL_SUCCESS &&
      (log = calloc(1, size + 1)))
    clGetProgramBuildInfo(program, context->device, CL_PROGRAM_BUILD_LOG, size,
                          log, NULL);
  return log;
}

static hbil_status build_failure(hbil_context *context, cl_program program,
                                 const char *pass, cl_int error) {
  char *log = build_log(context, program);
  fail(context, HBIL_BUILD_FAILED, "clBuildProgram(%s.cl): %s (%d)\n%s", pass,
       cl_error_name(error), (int)error, log ? log : "");
  free(log);
  return HBIL_BUILD_FAILED;
}

/* Hands on what the compiler said of a program that it built. */
static void report_remarks(hbil_context *context, cl_program program,
                           const char *pass) {
  if (!context->callback)
    return;
  char *log = build_log(context, program);
  if (log && log[strspn(log, " \t\r\n")])
    warn(context, "%s.cl: the compiler says: %s", pass, log);
  free(log);
}

static hbil_status build(hbil_context *context, cl_program program,
                         const program_kind *kind, const char *options) {
  const cl_int error =
      clBuildProgram(program, 1, &context->device, options, NULL, NULL);
  if (error == CL_SUCCESS) {
    report_remarks(context, program, kind->name);
    return HBIL_SUCCESS;
  }
  /* every failure but a lack of memory comes from the kernel or the compiler */
  return status_of(error) == HBIL_OPENCL_ERROR
             ? build_failure(context, program, kind->name, error)
             : fail_cl(context, error, "clBuildProgram(%s.cl)", kind->name);
}

static hbil_status build_text(hbil_context *context, const program_kind *kind,
                              const char *text, const char *defines,
                              cl_program *out, binary_identity *identity) {
  const char *own = kind->defines ? kind->defines : "";
  char options[MOST_DEFINES + 128], registers[48] = "";
  cl_int error = CL_SUCCESS;
  if (kind->registers && context->takes_registers)
    snprintf(registers, sizeof registers, " -cl-nv-maxrregcount=%d",
             kind->registers);
  snprintf(options, sizeof options, "-cl-std=CL1.2%s%s",
           kind->relaxed           ? " -cl-fast-relaxed-math"
           : context->exact_divide ? " -cl-fp32-correctly-rounded-divide-sqrt"
                                   : "",
           registers);
  hbil_status status =
      add_defines(context, text, own, "", options, sizeof options);
  if (status == HBIL_SUCCESS)
    status = add_defines(context, text, defines, own, options, sizeof options);
  if (status != HBIL_SUCCESS)
    return status;
  binary_identify(context, kind->name, text, options, identity);
  *out = shared_program(context, identity);
  if (!*out)
    *out = binary_load(context, options, identity);
  identity->is_new = !*out;
  if (*out)
    return HBIL_SUCCESS;
  *out = clCreateProgramWithSource(context->context, 1, &text, NULL, &error);
  if (!*out)
    return fail_cl(context, error, "clCreateProgramWithSource(%s.cl)",
                   kind->name);
  status = build(context, *out, kind, options);
  if (status != HBIL_SUCCESS) {
    clReleaseProgram(*out);
    *out = NULL;
  }
  return status;
}

hbil_status program_build(hbil_context *context, const program_kind *kind,
                          const char *defines, cl_program *out,
                          binary_identity *identity) {
  /* Kernels spell out their fused operations; no compiler may add others. */
  static const char first[] = "#pragma OPENCL FP_CONTRACT OFF\n";
  source s = {.text = NULL};
  char file[MOST_NAME];
  *out = NULL;
  snprintf(file, sizeof file, "%s.cl", kind->name);
  hbil_status status = append(context, &s, first, sizeof first - 1);
  if (status == HBIL_SUCCESS)
    status = append_file(context, &s, file);
  if (status == HBIL_SUCCESS) {
    blank_comments(s.text);
    status = build_text(context, kind, s.text, defines, out, identity);
  }
  free(s.text);
  return status;
}
