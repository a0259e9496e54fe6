/*
 * A folder of built programs that belongs to the user.  It is a store for
 * hbil_context_set_program_store(), with a limit to its size.  Whatever goes
 * wrong, a program is built from its text, and nothing is reported.
 */
#ifndef HBIL_TOOL_PROGRAM_FOLDER_H
#define HBIL_TOOL_PROGRAM_FOLDER_H

#include <stddef.h>

typedef struct program_folder program_folder;

/* Opens the folder and makes it if its parent exists.  Returns NULL if it can't
 * be used: programs are executed, so it must belong to the user, and nobody
 * else may have the right to write there. */
program_folder *program_folder_open(const char *path);

/* Deletes those programs that were not used for longest while all together have
 * more than 256 MiB, if any was stored.  NULL is allowed. */
void program_folder_close(program_folder *folder);

/* The functions of the store; `user` is the program_folder.  Stored programs
 * are regular files, of which other processes see all or nothing. */
size_t program_folder_load(void *user, const char *key, void *data,
                           size_t size);
void program_folder_store(void *user, const char *key, const void *data,
                          size_t size);

#endif
