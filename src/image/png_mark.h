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

typedef struct png_state {
  int marked; /* 1: png_write() wrote the file */
  int whole;  /* 1: the file is there to its last chunk */
} png_state;

/* Looks at a file without reading its pixels.  Both members are 0 if it is no
 * PNG. */
png_state png_look(const char *path);

#ifdef __cplusplus
}
#endif

#endif
