// The module's table.
#include "oiio/module.hpp"

extern "C" const formats_table hbil_formats = {
    HBIL_PACKAGE_VERSION, oiio_read_header, oiio_read,     oiio_read_rgb,
    oiio_write_png,       oiio_draw_tile,   oiio_draw_text};
