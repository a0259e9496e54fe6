/* Recognises by a file's header which program wrote the dump. */
#ifndef HBIL_DUMP_RECOGNISE_H
#define HBIL_DUMP_RECOGNISE_H

#include "dump/source.h"
#include "image/image.h"

/* The program that wrote the file, by its header and its name; DUMP_PLAIN if
 * nothing tells. */
dump_kind recognise_source(const char *path, const image *header);

/* Whether the file has channels that hbil itself writes. */
int recognise_own_channels(const image *header);

/* Whether Houdini's Karma wrote the file.  It has no row in the table of
 * sources. */
int recognise_karma(const image *header);

#endif
