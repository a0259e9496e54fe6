/*
 * Which PNG files are this program's own: a text in the file says so.
 */
#ifndef HBIL_IMAGE_PNG_MARK_H
#define HBIL_IMAGE_PNG_MARK_H

#ifdef __cplusplus
extern "C" {
#endif

/* PNG's keyword for the program that wrote a file, and our text. */
#define PNG_MARK_NAME "Software"
#define PNG_MARK "hbil"

/* Whether the file is a PNG that png_write() wrote and is there to its last
 * chunk.  Pixels are not read. */
int png_is_marked(const char *path);

#ifdef __cplusplus
}
#endif

#endif
