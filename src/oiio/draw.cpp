#include "image/catch_exceptions.hpp"
#include "oiio/module.hpp"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>

namespace {

namespace algo = OIIO::ImageBufAlgo;

// OpenImageIO can choose a font itself, but looks for names that Debian does
// not have; and versions from 2.5 on don't find names in folders of
// /usr/share/fonts, where Debian, Fedora and Arch have them.
const char *const fonts[] = {
    "DejaVuSans",
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
    "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
    "/usr/share/fonts/TTF/DejaVuSans.ttf",
    "LiberationSans-Regular",
    "FreeSans",
    "NotoSans-Regular",
    "Arial"};

OIIO::ImageBuf wrap(unsigned char *rgb, uint32_t width, uint32_t height) {
  return OIIO::ImageBuf(
      OIIO::ImageSpec(int(width), int(height), 3, OIIO::TypeDesc::UINT8), rgb);
}

int draw_text(picture &to, int x, int y, int size, picture_align align,
              const char *text) {
  static const algo::TextAlignX sides[] = {algo::TextAlignX::Left,
                                           algo::TextAlignX::Center,
                                           algo::TextAlignX::Right};
  OIIO::ImageBuf buffer = wrap(to.rgb, to.width, to.height);
  for (const char *font : fonts) {
    const bool drawn =
        algo::render_text(buffer, x, y, text, size, font, 1.0f, sides[align],
                          algo::TextAlignY::Baseline, 0, {}, 1);
    buffer.geterror(); // which it would print at its end
    if (drawn)
      return 0;
  }
  return -1;
}

int draw_tile(picture &to, const picture_window &at, const picture &tile) {
  OIIO::ImageBuf whole = wrap(to.rgb, to.width, to.height);
  const OIIO::ImageBuf from = wrap(tile.rgb, tile.width, tile.height);
  OIIO::ImageBuf sized(
      OIIO::ImageSpec(int(at.width), int(at.height), 3, OIIO::TypeDesc::UINT8));
  // A box filter of this width averages when it shrinks the tile, and repeats
  // pixels when it enlarges it.
  const float ratio = float(at.width) / float(tile.width);
  return algo::resize(sized, from, "box", std::max(ratio, 1.0f), {}, 1) &&
                 algo::paste(whole, int(at.x), int(at.y), 0, 0, sized, {}, 1)
             ? 0
             : -1;
}

} // namespace

extern "C" int oiio_draw_text(picture *to, int x, int y, int size,
                              picture_align align, const char *text) {
  return catch_exceptions("", "drawn", nullptr, [&] {
    return draw_text(*to, x, y, size, align, text);
  });
}

extern "C" int oiio_draw_tile(picture *to, const picture_window *at,
                              const picture *tile) {
  return catch_exceptions("", "drawn", nullptr,
                          [&] { return draw_tile(*to, *at, *tile); });
}
