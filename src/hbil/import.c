/* import, export: between the caller's images and staged planes; normals from
 * depth. */
#include <math.h>

#include "camera.h"
#include "lib/import_args.h"
#include "passes.h"

/* Directions are stored as (v+1)/2 where a format has no negative numbers. */
static bool is_direction(int plane) {
  return plane == PLANE_NORMAL || plane == PLANE_BENT;
}

/* Copies between an image and the plan's planes. */
static hbil_status copy_image(hbil_plan *plan, commands *chain, cl_mem image,
                              int plane, const texel_type *type) {
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
static hbil_status copy_given(hbil_plan *plan, commands *chain,
                              const hbil_frame *given, int plane) {
  const cl_mem image = frame_plane(given, plane)->buffer;
  cl_image_format format;
  const cl_int error =
      clGetImageInfo(image, CL_IMAGE_FORMAT, sizeof format, &format, NULL);
  if (error != CL_SUCCESS)
    return fail_cl(plan->context, error, "clGetImageInfo");
  const texel_type *type = texel_type_of(&format);
  if (plane == PLANE_DEPTH)
    plan->depth_rounding = type->rounding;
  if (plane == PLANE_NORMAL)
    plan->normal_rounding = normal_rounding(&plan->config, type->rounding);
  return copy_image(plan, chain, image, plane, type);
}

static hbil_status rebuild_normals(hbil_plan *plan, commands *chain,
                                   const hbil_frame *frame) {
  hbil_normals_args args = {.view = camera_view(&frame->camera, &plan->config),
                            .planes = plan->layout.planes,
                            .decode = depth_args(&plan->config, frame)};
  /* Of a gradient: that of the difference of two inverse depths, times the
   * focal length.  Rays at the borders of a picture are up to twice as long as
   * the one in the middle.  Without a scale of depths there is no such limit.
   */
  plan->normal_rounding =
      plan->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC
          ? 0.0f
          : 2.0f * 0x1p-22f * fmaxf(args.view.fx, args.view.fy);
  const cl_mem depth = bind_plane(plan, frame, PLANE_DEPTH, &args.depth);
  const argument list[] = {ARG(args), ARG(depth),
                           BUFFER_ARG(plan, BUFFER_STAGED + PLANE_NORMAL)};
  return LAUNCH(chain, KERNEL_NORMALS_FROM_DEPTH, list, vectors_across(plan),
                plan->config.height, 1);
}

hbil_status enqueue_import(hbil_plan *plan, commands *chain,
                           const hbil_frame *frame) {
  const unsigned images = plan->layout.staged.images;
  unsigned planes =
      plan->planes_in_use & plan->layout.staged.planes & INPUT_PLANES;
  hbil_status status = HBIL_SUCCESS;
  if (planes && is_static(plan, frame)) {
    /* The other planes hold the same values already.  Motion is 0 now. */
    planes &= PLANE_BIT(PLANE_MOTION);
    plan->left_out[HBIL_PASS_IMPORT] = !planes;
  }
  for (int i = 0; i < PLANE_FIRST_OUTPUT && status == HBIL_SUCCESS; ++i)
    if (planes & images & PLANE_BIT(i))
      status = copy_given(plan, chain, frame, i);
  return planes & ~images && status == HBIL_SUCCESS
             ? rebuild_normals(plan, chain, frame)
             : status;
}

hbil_status enqueue_export(hbil_plan *plan, commands *chain,
                           const hbil_frame *frame) {
  const unsigned planes = plan->planes_in_use & plan->layout.staged.planes;
  hbil_status status = HBIL_SUCCESS;
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT && status == HBIL_SUCCESS;
       ++i)
    if (planes & PLANE_BIT(i))
      status = copy_given(plan, chain, frame, i);
  return status;
}
