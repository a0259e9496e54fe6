/*
 * A folder for one test, and what programs leave in it.
 */
#ifndef HBIL_TEST_FOLDER_H
#define HBIL_TEST_FOLDER_H

#include <stddef.h>

enum { MOST_PATH = 256 };

/* Makes an empty folder and writes its path. */
void folder_make(char path[MOST_PATH]);
/* Removes it with everything in it. */
void folder_remove(const char *path);
/* The number of files in it, and in folders in it, whose names end so. */
int folder_count(const char *path, const char *ending);

#endif
