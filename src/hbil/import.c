/* Staged planes: images, and normals from depth. */
#include "import.h"

#include <math.h>
#include <string.h>

#include "camera.h"
#include "lib/import_args.h"
#include "passes.h"
#include "planes.h"

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
  static const hbil_plane_format planar = {HBIL_FLOAT32, 1};
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
  }
  for (int i = 0; i < PLANE_COUNT; ++i)
    if (out->planes & PLANE_BIT(i))
      memcpy((char *)config + plane_kinds[i].format_at, &planar, sizeof planar);
  return HBIL_SUCCESS;
}

hbil_frame staged_frame(const hbil_plan *plan, const hbil_frame *given) {
  const hbil_plane_args *l = &plan->layout.planes;
  hbil_frame frame = *given;
  for (int i = 0; i < PLANE_COUNT; ++i)
    if (plan->layout.staged.planes & PLANE_BIT(i)) {
      const hbil_plane own = {.buffer = plan->buffers[BUFFER_STAGED + i],
                              .row_pitch = sizeof(cl_float) * l->row,
                              .plane_pitch = sizeof(cl_float) * l->plane};
      memcpy((char *)&frame + plane_kinds[i].plane_at, &own, sizeof own);
    }
  return frame;
}

/* --- checks of images --- */

/* How kernels read and write components of a type.  rounding: as in
 * component_kind. */
typedef struct texel_type {
  cl_channel_type type;
  bool is_unorm;
  float largest; /* the largest value that can be written */
  float rounding;
} texel_type;

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

/* NULL: kernels can't read it as floats. */
static const texel_type *type_of(const cl_image_format *format) {
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
static bool suits_depth(const hbil_plan *plan, const texel_type *type) {
  return type->type == CL_FLOAT ||
         (type->type == CL_HALF_FLOAT &&
          plan->layout.staged.planes == plan->layout.staged.images) ||
         (type->type == CL_UNORM_INT16 &&
          plan->config.inputs.depth_kind == HBIL_DEPTH_HARDWARE);
}

static hbil_status check_format(hbil_plan *plan, int plane,
                                const cl_image_format *format) {
  hbil_context *context = plan->context;
  const char *name = plane_kinds[plane].name;
  const int needed = (int)plane_components(&plan->config, plane);
  const texel_type *type = type_of(format);
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
  if (plane == PLANE_DEPTH && !suits_depth(plan, type))
    return fail(context, HBIL_INVALID_FRAME,
                "depth.buffer: image channel type 0x%x; must be CL_FLOAT, with "
                "normals CL_HALF_FLOAT, or with HBIL_DEPTH_HARDWARE "
                "CL_UNORM_INT16",
                (unsigned)type->type);
  return HBIL_SUCCESS;
}

hbil_status check_image(hbil_plan *plan, int plane, cl_mem image) {
  hbil_context *context = plan->context;
  const char *name = plane_kinds[plane].name;
  const unsigned width = plan->config.width, height = plan->config.height;
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
  return check_format(plan, plane, &format);
}

/* --- the commands --- */

/* Directions are stored as (v+1)/2 where a format has no negative numbers. */
static bool is_direction(int plane) {
  return plane == PLANE_NORMAL || plane == PLANE_BENT;
}

/* Copies between an image and the plan's planes. */
static hbil_status copy_image(commands *chain, cl_mem image, int plane,
                              const texel_type *type) {
  hbil_plan *plan = chain->plan;
  const hbil_config *c = &plan->config;
  const hbil_image_args args = {.planes = plan->layout.planes,
                                .width = (cl_int)c->width,
                                .height = (cl_int)c->height,
                                .channels = (cl_int)plane_components(c, plane),
                                .is_direction =
                                    type->is_unorm && is_direction(plane),
                                .largest = type->largest};
  const argument in[] = {ARG(args), ARG(image),
                         BUFFER_ARG(plan, BUFFER_STAGED + plane)};
  const argument out[] = {ARG(args), BUFFER_ARG(plan, BUFFER_STAGED + plane),
                          ARG(image)};
  return plane < PLANE_FIRST_OUTPUT
             ? LAUNCH(chain, KERNEL_IMPORT_IMAGE, in, c->width, c->height, 1)
             : LAUNCH(chain, KERNEL_EXPORT_IMAGE, out, c->width, c->height, 1);
}

/* The same with the caller's image, whose format has been checked. */
static hbil_status copy_given(commands *chain, const hbil_frame *given,
                              int plane) {
  hbil_plan *plan = chain->plan;
  const cl_mem image = frame_plane(given, plane)->buffer;
  cl_image_format format;
  const cl_int error =
      clGetImageInfo(image, CL_IMAGE_FORMAT, sizeof format, &format, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clGetImageInfo");
  const texel_type *type = type_of(&format);
  if (plane == PLANE_DEPTH)
    plan->depth_rounding = type->rounding;
  if (plane == PLANE_NORMAL)
    plan->normal_rounding = normal_rounding(&plan->config, type->rounding);
  return copy_image(chain, image, plane, type);
}

static hbil_status rebuild_normals(commands *chain, const hbil_frame *staged) {
  hbil_plan *plan = chain->plan;
  hbil_normals_args args = {.view = camera_view(&staged->camera, &plan->config),
                            .planes = plan->layout.planes,
                            .decode = depth_args(&plan->config, staged)};
  /* Of a gradient: that of the difference of two inverse depths, times the
   * focal length.  Rays at the borders of a picture are up to twice as long as
   * the one in the middle.  Without a scale of depths there is no such limit.
   */
  plan->normal_rounding =
      plan->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC
          ? 0.0f
          : 2.0f * 0x1p-22f * fmaxf(args.view.fx, args.view.fy);
  const cl_mem depth =
      plane_bind(&plan->config, staged, PLANE_DEPTH, &args.depth);
  const argument list[] = {ARG(args), ARG(depth),
                           BUFFER_ARG(plan, BUFFER_STAGED + PLANE_NORMAL)};
  return LAUNCH(chain, KERNEL_NORMALS_FROM_DEPTH, list, vectors_across(plan),
                plan->config.height, 1);
}

hbil_status enqueue_import(commands *chain, const hbil_frame *given,
                           const hbil_frame *staged, unsigned planes) {
  hbil_plan *plan = chain->plan;
  const unsigned inputs = PLANE_BIT(PLANE_FIRST_OUTPUT) - 1;
  hbil_status status = HBIL_SUCCESS;
  chain->pass = HBIL_PASS_IMPORT;
  plan->left_out[chain->pass] = false;
  planes &= plan->layout.staged.planes & inputs;
  if (planes && is_static(plan, given)) {
    /* The other planes hold the same values already.  Motion is 0 now. */
    planes &= PLANE_BIT(PLANE_MOTION);
    plan->left_out[chain->pass] = !planes;
  }
  for (int i = 0; i < PLANE_FIRST_OUTPUT && status == HBIL_SUCCESS; ++i)
    if (planes & plan->layout.staged.images & PLANE_BIT(i))
      status = copy_given(chain, given, i);
  planes &= ~plan->layout.staged.images;
  return planes && status == HBIL_SUCCESS ? rebuild_normals(chain, staged)
                                          : status;
}

hbil_status enqueue_export(commands *chain, const hbil_frame *given,
                           unsigned planes) {
  hbil_plan *plan = chain->plan;
  hbil_status status = HBIL_SUCCESS;
  chain->pass = HBIL_PASS_EXPORT;
  planes &= plan->layout.staged.planes;
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT && status == HBIL_SUCCESS;
       ++i)
    if (planes & PLANE_BIT(i))
      status = copy_given(chain, given, i);
  return status;
}

hbil_status try_import(commands *chain, const hbil_frame *frame) {
  const staging *staged = &chain->plan->layout.staged;
  /* the mandatory format of OpenCL 1.2 with floats */
  const cl_image_format format = {CL_RGBA, CL_FLOAT};
  const cl_image_desc pixel = {
      .image_type = CL_MEM_OBJECT_IMAGE2D, .image_width = 1, .image_height = 1};
  cl_int error = CL_SUCCESS;
  cl_mem image = NULL;
  hbil_status status = HBIL_SUCCESS;
  if (staged->images) {
    image = clCreateImage(chain->plan->context->context, CL_MEM_READ_WRITE,
                          &format, &pixel, NULL, &error);
    if (!image)
      return fail_cl(chain->plan->context, error, "clCreateImage");
  }
  for (int i = 0; i < PLANE_COUNT && status == HBIL_SUCCESS; ++i)
    if (staged->images & PLANE_BIT(i))
      status = copy_image(chain, image, i, &texel_types[0]);
  if (image)
    clReleaseMemObject(image); /* the commands retain it */
  return status == HBIL_SUCCESS && staged->planes != staged->images
             ? rebuild_normals(chain, frame)
             : status;
}
