/* Structs that grow: the caller may have compiled with an older header. */
#include "sized.h"

#include <string.h>

void init_sized(void *out, size_t size, const void *defaults, size_t known) {
  if (!out || size < sizeof size)
    return;
  memset(out, 0, size);
  memcpy(out, defaults, size < known ? size : known);
  memcpy(out, &size, sizeof size);
}

hbil_status take_sized(hbil_context *context, hbil_status rejection,
                       const char *name, const void *given, size_t least,
                       void *own) {
  size_t size, known;
  memcpy(&size, given, sizeof size);
  memcpy(&known, own, sizeof known);
  if (size < least)
    return fail(context, rejection,
                "struct_size: %zu, %s has had at least %zu bytes; call "
                "%s_init() first",
                size, name, least, name);
  if (size > known)
    return fail(context, rejection,
                "struct_size: %zu, %s of library %s has %zu bytes; the "
                "program's hbil.h is newer, or %s_init() was not called",
                size, name, hbil_version(), known, name);
  memcpy(own, given, size);
  memcpy(own, &known, sizeof known);
  return HBIL_SUCCESS;
}
