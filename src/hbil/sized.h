/* Structs that grow: the caller may have compiled with an older header. */
#ifndef HBIL_SIZED_H
#define HBIL_SIZED_H

#include "context.h"

/* Bytes of a struct whose last field is `last`. */
#define SIZE_UP_TO(type, last)                                                 \
  ((offsetof(type, last) + sizeof(((const type *)0)->last) + _Alignof(type) -  \
    1) /                                                                       \
   _Alignof(type) * _Alignof(type))

/* Fills a caller's struct of `size` bytes, which begins with its struct_size,
 * with the `known` bytes of this library's defaults, and the rest with 0. */
void init_sized(void *out, size_t size, const void *defaults, size_t known);

/* Copies a caller's struct over `own`, which holds the defaults and its own
 * size.  Reads struct_size bytes and no more.  least: bytes of the struct in
 * the first version that had it.  Fails with `rejection`. */
hbil_status take_sized(hbil_context *context, hbil_status rejection,
                       const char *name, const void *given, size_t least,
                       void *own);

#endif
