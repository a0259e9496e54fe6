/*
 * How the functions of src/image report a failure.
 *
 * A function that can fail returns 0 on success.  On failure it returns -1 and
 * fills `error`, which may be NULL, with one sentence: "PATH: what is wrong;
 * what is needed".  It leaves nothing behind: no allocated memory and no partly
 * written file.
 */
#ifndef HBIL_IMAGE_ERROR_H
#define HBIL_IMAGE_ERROR_H

#ifdef __cplusplus
extern "C" {
#endif

/* Room for two paths of maximum length and the words around them. */
enum { IMAGE_ERROR_SIZE = 2 * 4096 + 1024 };
typedef struct image_error {
  char text[IMAGE_ERROR_SIZE];
} image_error;

/* Formats the sentence like printf.  Always returns -1. */
int image_fail(image_error *error, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* Reports that memory ran out while working on `path`.  Always returns -1. */
int image_no_memory(image_error *error, const char *path);

#ifdef __cplusplus
}
#endif

#endif
