/* Names and sizes of the roles. */
#include "dump/roles.h"

const char *role_name(role r) {
  static const char *const names[ROLE_COUNT] = {
      "depth",  "normal",   "albedo",   "direct",   "emission", "background",
      "motion", "position", "indirect", "coverage", "picture",  "alpha"};
  return names[r];
}

size_t role_channels(role r) {
  return r == ROLE_DEPTH || r == ROLE_COVERAGE || r == ROLE_ALPHA ? 1
         : r == ROLE_MOTION                                       ? 2
                                                                  : 3;
}

int role_is_colour(role r) {
  return r == ROLE_ALBEDO || r == ROLE_DIRECT || r == ROLE_EMISSION ||
         r == ROLE_BACKGROUND || r == ROLE_INDIRECT || r == ROLE_PICTURE;
}
