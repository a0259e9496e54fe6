/* Stores built programs between runs where the driver doesn't. */
#ifndef HBIL_TOOL_PROGRAM_CACHE_H
#define HBIL_TOOL_PROGRAM_CACHE_H

#include "hbil/hbil.h"
#include "tool/program_folder.h"

/* The folder for the programs of a platform: HBIL_PROGRAM_DIR, which may be
 * empty for none.  If it isn't set: none if the driver stores its programs
 * itself, else $XDG_CACHE_HOME/hbil or $HOME/.cache/hbil, whose parents are
 * made.  malloc'd; NULL: none. */
char *program_cache_path(const char *platform);

/* Gives a context the folder of its device's platform.  It must stay open until
 * the context is destroyed.  Returns NULL if there is none. */
program_folder *program_cache_open(hbil_context *context, cl_device_id device);

#endif
