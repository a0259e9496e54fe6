/*
 * A limit on the memory that OpenEXRCore allocates for one file.
 *
 * The header of a damaged file may ask for any amount of memory.  The library
 * limits the size of an image, but not the memory that it takes to read one, so
 * it allocates through the two functions below.
 */
#ifndef HBIL_IMAGE_EXR_BUDGET_H
#define HBIL_IMAGE_EXR_BUDGET_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Whatever a file claims, reading it takes at most this much memory in bytes,
 * and once the header is known 4 times the size of its image in addition:
 * pixels x channels x 4 bytes.  This constant part serves the header, and small
 * images in DWA compression, whose chunks always have 256 rows.
 */
enum { EXR_SPARE_MEMORY = 64 << 20 };

typedef struct exr_budget {
  size_t held, limit; /* bytes */
  int exceeded;       /* whether an allocation was denied */
} exr_budget;

/* Selects the budget that the calling thread's allocations are charged to;
 * NULL: no limit.  A thread reads one file at a time. */
void budget_select(exr_budget *budget);

/* malloc() and free() within the selected budget. */
void *budget_take(size_t size);
void budget_give(void *memory);

#ifdef __cplusplus
}
#endif

#endif
