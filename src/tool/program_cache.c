/* Stores built programs between runs where the driver doesn't. */
#define _POSIX_C_SOURCE 200809L
#include "tool/program_cache.h"

#include "tool/paths.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Platforms for which nothing is stored.  All others have programs stored: if
 * such a driver has a cache of its own, that costs disk space only. */
static const char *const excluded[] = {
    "Portable Computing Language", /* ~/.cache/pocl, POCL_CACHE_DIR */
    "NVIDIA CUDA",                 /* ~/.nv/ComputeCache, CUDA_CACHE_PATH */
    "rusticl", /* Mesa: ~/.cache/mesa_shader_cache, MESA_SHADER_CACHE_DIR */
    /* A simulator: its own command line has build options, which the key of a
     * program doesn't have. */
    "Oclgrind",
};

static int is_excluded(const char *platform) {
  for (size_t i = 0; i < sizeof excluded / sizeof *excluded; i++)
    if (strcmp(platform, excluded[i]) == 0)
      return 1;
  return 0;
}

/* An absolute path, as the XDG base directory specification demands. */
static const char *folder_of(const char *variable) {
  const char *folder = getenv(variable);
  return folder && folder[0] == '/' ? folder : NULL;
}

/* The user's folder of caches, made if its parent exists. */
static char *user_caches(void) {
  const char *own = folder_of("XDG_CACHE_HOME"), *home = folder_of("HOME");
  char *folder = own    ? path_join(own, "", "")
                 : home ? path_join(home, "/", ".cache")
                        : NULL;
  if (folder)
    mkdir(folder, 0700);
  return folder;
}

char *program_cache_path(const char *platform) {
  const char *chosen = getenv("HBIL_PROGRAM_DIR");
  if (chosen)
    return *chosen ? path_join(chosen, "", "") : NULL;
  char *caches = is_excluded(platform) ? NULL : user_caches();
  char *path = caches ? path_join(caches, "/", "hbil") : NULL;
  free(caches);
  return path;
}

program_folder *program_cache_open(hbil_context *context, cl_device_id device) {
  cl_platform_id platform = NULL;
  char name[256] = "";
  if (clGetDeviceInfo(device, CL_DEVICE_PLATFORM, sizeof platform, &platform,
                      NULL) != CL_SUCCESS ||
      clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof name - 1, name,
                        NULL) != CL_SUCCESS)
    return NULL;
  char *path = program_cache_path(name);
  program_folder *folder = path ? program_folder_open(path) : NULL;
  free(path);
  if (folder && hbil_context_set_program_store(context, program_folder_load,
                                               program_folder_store,
                                               folder) != HBIL_SUCCESS) {
    program_folder_close(folder);
    folder = NULL;
  }
  return folder;
}
