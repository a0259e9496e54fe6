/* The module as a part of the program, where there are no shared libraries. */
#include "image/formats_module.h"

const formats_table *formats_module(image_error *error) {
  (void)error;
  return &hbil_formats;
}
