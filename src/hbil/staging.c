/* Which planes are staged, and which images can be planes. */
#include "staging.h"

#include <math.h>
#include <string.h>

/* --- which planes are staged --- */

static hbil_status check_device(hbil_context *context, int plane) {
  cl_bool images = CL_FALSE;
  const cl_int error = clGetDeviceInfo(context->device, CL_DEVICE_IMAGE_SUPPORT,
                                       sizeof images, &images, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clGetDeviceInfo");
  if (images)
    return HBIL_SUCCESS;
  return fail(context, HBIL_UNSUPPORTED_DEVICE,
              "%s.%s.component: HBIL_IMAGE; the device has no images "
              "(CL_DEVICE_IMAGE_SUPPORT), buffers are possible",
              plane < PLANE_FIRST_OUTPUT ? "inputs" : "outputs",
              plane_kinds[plane].name);
}

hbil_status stage_planes(hbil_context *context, hbil_config *config,
                         staging *out) {
  static const hbil_plane_format planar = {HBIL_FLOAT32, 4};
  out->images = out->planes = 0;
  for (int i = 0; i < PLANE_COUNT; ++i)
    if (plane_format(config, i)->component == HBIL_IMAGE) {
      const hbil_status status = check_device(context, i);
      if (status != HBIL_SUCCESS)
        return status;
      out->images |= PLANE_BIT(i);
    }
  out->planes = out->images;
  if (config->inputs.normal.component == HBIL_NONE) {
    out->planes |= PLANE_BIT(PLANE_NORMAL);
    config->inputs.normal_space = HBIL_SPACE_VIEW;
    config->inputs.normal_encoding = HBIL_NORMAL_XYZ;
    for (int c = 0; c < 3; ++c)
      config->inputs.normal_scale[c] = 1.0f;
  }
  for (int i = 0; i < PLANE_COUNT; ++i)
    if (out->planes & PLANE_BIT(i))
      memcpy((char *)config + plane_kinds[i].format_at, &planar, sizeof planar);
  return HBIL_SUCCESS;
}

/* --- checks of images --- */

/* Light in halves does not become infinite, as in half planes. */
static const texel_type texel_types[] = {
    {CL_FLOAT, false, INFINITY, 0.0f},
    {CL_HALF_FLOAT, false, 65504.0f, ROUNDING_OF_HALF},
    {CL_SNORM_INT8, false, 1.0f, ROUNDING_OF_BITS(8)},
    {CL_SNORM_INT16, false, 1.0f, ROUNDING_OF_BITS(16)},
    {CL_UNORM_INT8, true, 1.0f, ROUNDING_OF_BITS(8)},
    {CL_UNORM_INT16, true, 1.0f, ROUNDING_OF_BITS(16)},
    {CL_UNORM_INT_101010, true, 1.0f, ROUNDING_OF_BITS(10)},
    {CL_UNORM_SHORT_565, true, 1.0f, ROUNDING_OF_BITS(5)},
    {CL_UNORM_SHORT_555, true, 1.0f, ROUNDING_OF_BITS(5)}};

const texel_type *texel_type_of(const cl_image_format *format) {
  for (size_t i = 0; i < sizeof texel_types / sizeof *texel_types; ++i)
    if (texel_types[i].type == format->image_channel_data_type)
      return &texel_types[i];
  return NULL;
}

/* Channels of an image, from red on; 0: there is no red, or the order is one of
 * depth or sRGB, which are not of OpenCL 1.2. */
static int channels_of(cl_channel_order order) {
  switch (order) {
  case CL_R:
  case CL_Rx:
  case CL_INTENSITY:
  case CL_LUMINANCE:
    return 1;
  case CL_RG:
  case CL_RGx:
    return 2;
  case CL_RGB:
  case CL_RGBx:
  case CL_RGBA:
  case CL_BGRA:
  case CL_ARGB:
    return 3;
  }
  return 0;
}

/* Whether the depth of such an image is exact enough for its kind. */
static bool suits_depth(const hbil_config *config, const staging *staged,
                        const texel_type *type) {
  return type->type == CL_FLOAT ||
         (type->type == CL_HALF_FLOAT && staged->planes == staged->images) ||
         (type->type == CL_UNORM_INT16 &&
          config->inputs.depth_kind == HBIL_DEPTH_HARDWARE);
}

static hbil_status check_format(hbil_context *context,
                                const hbil_config *config,
                                const staging *staged, int plane,
                                const cl_image_format *format) {
  const char *name = plane_kinds[plane].name;
  const int needed = (int)plane_components(config, plane);
  const texel_type *type = texel_type_of(format);
  const int channels = channels_of(format->image_channel_order);
  if (!channels || !type)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.buffer: image channel order 0x%x of type 0x%x; must be "
                "CL_R, CL_RG, CL_RGBA or an order like these, of type UNORM, "
                "SNORM, HALF_FLOAT or FLOAT",
                name, (unsigned)format->image_channel_order,
                (unsigned)format->image_channel_data_type);
  if (channels < needed)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.buffer: an image of %d channels; must have %d or more",
                name, channels, needed);
  if (plane == PLANE_DEPTH && !suits_depth(config, staged, type))
    return fail(context, HBIL_INVALID_FRAME,
                "depth.buffer: image channel type 0x%x; must be CL_FLOAT, with "
                "normals CL_HALF_FLOAT, or with HBIL_DEPTH_HARDWARE "
                "CL_UNORM_INT16",
                (unsigned)type->type);
  return HBIL_SUCCESS;
}

hbil_status check_image(hbil_context *context, const hbil_config *config,
                        const staging *staged, int plane, cl_mem image) {
  const char *name = plane_kinds[plane].name;
  const unsigned width = config->width, height = config->height;
  size_t across = 0, down = 0;
  cl_image_format format;
  cl_int error =
      clGetImageInfo(image, CL_IMAGE_WIDTH, sizeof across, &across, NULL);
  if (error == CL_SUCCESS)
    error = clGetImageInfo(image, CL_IMAGE_HEIGHT, sizeof down, &down, NULL);
  if (error == CL_SUCCESS)
    error =
        clGetImageInfo(image, CL_IMAGE_FORMAT, sizeof format, &format, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(context, error, "clGetImageInfo");
  if (across != width || down != height)
    return fail(context, HBIL_INVALID_FRAME,
                "%s.buffer: an image of %zu x %zu pixels; must be %u x %u",
                name, across, down, width, height);
  return check_format(context, config, staged, plane, &format);
}
