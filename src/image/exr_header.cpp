#include "image/exr_header.hpp"
#include "image/exr_checksum.h"
#include "image/exr_key.h"
#include "image/signature.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfStringVectorAttribute.h>

#include <algorithm>
#include <iterator>
#include <string>

namespace {

// Attributes that describe how a file is stored, or that are true only of the
// file that they are in.
bool is_storage(const std::string &name) {
  static const char *const names[] = {"channels",
                                      "compression",
                                      "dataWindow",
                                      "lineOrder",
                                      "tiles",
                                      "type",
                                      "name",
                                      "version",
                                      "chunkCount",
                                      "deepImageState",
                                      "maxSamplesPerPixel",
                                      "view",
                                      "multiView",
                                      "preview",
                                      "acesImageContainerFlag",
                                      EXR_KEY,
                                      EXR_NEAR_RADIUS,
                                      EXR_AO_RADIUS,
                                      EXR_CHECKSUM};
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

// Reads the header of a file's first part.  Returns false if the file is not
// OpenEXR.  The header is not checked for absurd sizes, because the pixels of
// this file were read before.  Imf::MultiPartInputFile would read the header
// too, but also the tables of all chunks.
bool read_header(const char *path, Imf::Header &out) {
  char start[8]; // the signature and the version
  Imf::StdIFStream in(path);
  try {
    in.read(start, sizeof start);
  } catch (const std::exception &) {
    return false; // shorter than any OpenEXR file
  }
  if (signature_format(start, sizeof start) != FILE_FORMAT_EXR)
    return false;
  int version = 0;
  for (int i = 0; i < 4; i++)
    version |= int((unsigned char)(start[4 + i])) << 8 * i;
  out.readFrom(in, version);
  return true;
}

void copy_attributes(const exr_style &style, Imf::Header &header) {
  Imf::Header like;
  if (!style.like || !read_header(style.like, like))
    return;
  for (auto i = like.begin(); i != like.end(); ++i)
    if (!is_storage(i.name()))
      header.insert(i.name(), i.attribute());
  if (style.compression == EXR_COMPRESSION_OF_INPUT)
    header.compression() = like.compression();
}

Imath::Box2i box(const image_window &w) {
  return {{w.x, w.y}, {w.x + int(w.width) - 1, w.y + int(w.height) - 1}};
}

Imath::M44f matrix(const double m[16]) {
  Imath::M44f out;
  for (int i = 0; i < 16; i++)
    out[i / 4][i % 4] = float(m[i]);
  return out;
}

Imf::PixelType stored_type(const image_plane &plane, bool half) {
  if (half || plane.type == IMAGE_HALF)
    return Imf::HALF;
  return plane.type == IMAGE_UINT ? Imf::UINT : Imf::FLOAT;
}

} // namespace

Imf::Header exr_header(const image &img, const unsigned char *half,
                       const exr_style &style) {
  const Imath::Box2i window = box(image_data_window(&img));
  const image_matrices &m = img.matrices;
  Imf::Header header(window, window);
  header.compression() = style.compression == EXR_COMPRESSION_OF_INPUT
                             ? Imf::ZIP_COMPRESSION
                             : Imf::Compression(style.compression);
  copy_attributes(style, header);
  header.displayWindow() = box(image_display_window(&img));
  if (m.has_camera)
    Imf::addWorldToCamera(header, matrix(m.world_to_camera));
  if (m.has_ndc)
    Imf::addWorldToNDC(header, matrix(m.world_to_ndc));
  if (img.view_count)
    header.insert("multiView", Imf::StringVectorAttribute(Imf::StringVector(
                                   img.views, img.views + img.view_count)));
  if (img.key[0]) {
    header.insert(EXR_KEY, Imf::StringAttribute(img.key));
    header.insert(EXR_CHECKSUM, Imf::StringAttribute(EXR_CHECKSUM_ROOM));
  }
  if (img.near_radius > 0.0f)
    header.insert(EXR_NEAR_RADIUS, Imf::FloatAttribute(img.near_radius));
  if (img.ao_radius > 0.0f)
    header.insert(EXR_AO_RADIUS, Imf::FloatAttribute(img.ao_radius));
  for (size_t i = 0; i < img.count; i++)
    header.channels().insert(img.planes[i].name,
                             stored_type(img.planes[i], half && half[i]));
  return header;
}
