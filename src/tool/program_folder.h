/*
 * Stores built programs between runs where the driver doesn't, in a folder that
 * belongs to the user.  Whatever goes wrong, a program is built from its text,
 * and nothing is reported.
 */
#ifndef HBIL_TOOL_PROGRAM_FOLDER_H
#define HBIL_TOOL_PROGRAM_FOLDER_H

#include "hbil/hbil.h"

typedef struct program_folder program_folder;

/*
 * Gives a context the folder of its device's platform: HBIL_PROGRAM_DIR, which
 * may be empty for none.  If it isn't set: none if the driver stores its
 * programs itself, else $XDG_CACHE_HOME/hbil or $HOME/.cache/hbil, whose
 * parents are made.  It must stay open until the context is destroyed.  Returns
 * NULL if there is none, or if others may write there.
 */
program_folder *program_folder_of_device(hbil_context *context,
                                         cl_device_id id);

/* If any program was stored, deletes those that were not used for longest while
 * all together have more than 256 MiB.  NULL is allowed. */
void program_folder_close(program_folder *folder);

#endif
