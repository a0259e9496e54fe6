/* gather: the table of steps and the horizon search. */
#include "passes.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "camera.h"
#include "checks.h"
#include "fall.h"
#include "glossy.h"
#include "lib/sampling_pattern.h"
#include "planes.h"
#include "searches.h"

/* The rotation and the shift of frame `frame_index`, in slices and in steps:
 * multiples of the fractional parts of sqrt(7) (the paper's demo) and of the
 * inverse plastic number.  Neither repeats soon. */
static hbil_pattern_args pattern_of(const layout *l, const hbil_frame *frame,
                                    const hbil_view_args *view) {
  hbil_pattern_args pattern = l->pattern;
  const float to_x = (float)view->width / view->fx;
  const float to_y = (float)view->height / view->fy;
  pattern.reach = to_x > to_y ? to_x : to_y;
  pattern.turn = (float)fmod(frame->frame_index * 0.6457513, 1.0);
  pattern.shift = (float)fmod(frame->frame_index * 0.7548777, 1.0);
  return pattern;
}

/* Makes a table of steps in a buffer, unless it is there already. */
static hbil_status make_pattern(hbil_plan *plan, commands *chain, int buffer,
                                step_table *table, const hbil_view_args *view,
                                const hbil_pattern_args *pattern) {
  if (table->is_made && !memcmp(view, &table->view, sizeof *view) &&
      !memcmp(pattern, &table->pattern, sizeof *pattern))
    return HBIL_SUCCESS;
  const hbil_make_pattern_args args = {*view, *pattern, plan->layout.split};
  const argument list[] = {ARG(args), BUFFER_ARG(plan, buffer)};
  const hbil_status status =
      LAUNCH(chain, KERNEL_PATTERN, list,
             (size_t)(pattern->levels * hbil_sites(pattern->gathered)),
             (size_t)pattern->slices * 2, (size_t)pattern->steps + 1);
  *table = (step_table){status == HBIL_SUCCESS, *view, *pattern};
  return status;
}

/* Makes the tables of both searches, as the other one has no kernel for it. */
static hbil_status make_patterns(hbil_plan *plan, commands *chain,
                                 const hbil_frame *frame,
                                 const hbil_view_args *view) {
  const hbil_pattern_args own = pattern_of(&plan->layout, frame, view);
  const hbil_status status =
      make_pattern(plan, chain, BUFFER_STEPS, &plan->steps, view, &own);
  if (status != HBIL_SUCCESS || !plan->layout.ao_search)
    return status;
  const hbil_pattern_args ao = pattern_of(&plan->ao.layout, frame, view);
  return make_pattern(plan, chain, BUFFER_AO_STEPS, &plan->ao_steps, view, &ao);
}

/* W of HBAO falls by this much per world unit. */
static float falloff_slope(const hbil_config *config) {
  if (isinf(config->model.radius) || config->model.falloff == HBIL_FALLOFF_NONE)
    return 0.0f;
  return (config->model.falloff == HBIL_FALLOFF_SOFT ? 1.0f / 3.0f : 1.0f) /
         config->model.radius;
}

/* Length of the ray to the corner that is farthest from the axis; in
 * orthographic views, its distance from the axis in the plane of the picture.
 */
static float longest_ray(const hbil_view_args *v, bool orthographic) {
  const double x = fmax(fabs((double)v->cx), fabs(v->width - (double)v->cx));
  const double y = fmax(fabs((double)v->cy), fabs(v->height - (double)v->cy));
  const double rx = x / (double)v->fx, ry = y / (double)v->fy;
  return (float)sqrt((orthographic ? 0.0 : 1.0) + rx * rx + ry * ry);
}

/* How exact the w of a depth input are, for two of them. */
typedef struct depth_error {
  float relative;  /* the roundings of both, as a share of w */
  float half_step; /* of hardware depth: of one, in w */
} depth_error;

/* Four roundings lie between two depths and the difference of their inverses:
 * those of z0, of z1 and of both inverses.  In a float depth all four are
 * 2^-24; what the first two are in another format is in the table of
 * components, or of image types where the plan has a copy. Codes of depth
 * buffers have steps of one size.  So have floats towards d = 1, where those up
 * to 1 have half steps of 2^-25, and halves of 2^-12.  Where the far end is 0,
 * floats are as exact there as w is. */
static depth_error depth_error_of(const hbil_plan *plan,
                                  const hbil_frame *frame) {
  const hbil_inputs *in = &plan->config.inputs;
  const float rounding = fmaxf(component_kinds[in->depth.component].rounding,
                               plan->depth_rounding);
  const bool is_float = rounding == 0.0f || rounding == ROUNDING_OF_HALF;
  const float own = fmaxf(rounding, 0x1p-22f);
  const float b = (float)frame->hardware_depth[1];
  depth_error error = {own, 0.0f};
  if (in->depth_kind != HBIL_DEPTH_HARDWARE ||
      (is_float && b > 0.0f && in->projection == HBIL_PROJECTION_PERSPECTIVE))
    return error;
  /* of n bits, 1/(2^n - 1) is a step, which is 2^-n (1 + 2^-n) */
  error.half_step =
      0.25f * fmaxf(rounding, 0x1p-23f) * (1.0f + 0.5f * rounding) / fabsf(b);
  error.relative = 0x1p-22f;
  return error;
}

static hbil_gather_args gather_args(const hbil_plan *plan,
                                    const hbil_frame *frame,
                                    const hbil_view_args *view,
                                    const hbil_pattern_args *pattern) {
  const hbil_config *c = &plan->config;
  /* flatness: the roundings of the three components of a normal and of what is
   * made of them.  A packed normal is off by at most sqrt(18)/4 steps of 2^-14,
   * which is 6.5e-5. */
  const depth_error depth = depth_error_of(plan, frame);
  const float normal =
      normal_rounding(c, component_kinds[c->inputs.normal.component].rounding);
  const bool packed = c->sampling.storage != HBIL_STORAGE_FLOAT32;
  const bool orthographic =
      c->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  hbil_gather_args args = {
      .view = *view,
      .split = plan->layout.split,
      .light = plan->layout.light,
      .radius = c->model.radius,
      .reach = pattern->reach,
      /* moves samples away from the eye; orthographic w is -z, below 0 */
      .nearness = orthographic ? 1.0f + depth.relative : 1.0f - depth.relative,
      .half_step = depth.half_step,
      .flatness = fmaxf(fmaxf(packed ? 0x1p-13f : 0x1p-21f, normal),
                        plan->normal_rounding),
      .facing = {c->model.facing_fade[0],
                 1.0f / fmaxf(c->model.facing_fade[1] - c->model.facing_fade[0],
                              FLT_MIN)},
      /* finite, since the gather is built without infinities */
      .thickness = fminf(c->model.thickness, 1e30f),
      .relative_thickness = fminf(near_thickness_share(c), 1e30f),
      .falloff = falloff_slope(c),
      .longest = longest_ray(view, orthographic),
      .bounds = plan->layout.bounds,
      .spans = (cl_uint)plan->layout.spans,
      .slices = pattern->slices,
      .steps = pattern->steps,
      .lobe = glossy_lobe(c),
      .past = plan->layout.past,
      .motion_scale = {c->inputs.motion_scale[0], c->inputs.motion_scale[1]},
      .disocclusion_threshold = c->history.disocclusion_threshold,
      .exposure = light_exposure(frame->exposure),
      .per_exposure = 1.0f / light_exposure(frame->exposure),
      .has_past = plan->slices.has && shares_slices(plan, frame)};
  const hbil_camera *last =
      plan->slices.has ? &plan->slices.camera : &frame->camera;
  args.before = camera_view(last, c);
  args.back = camera_between(&frame->camera, last);
  args.forth = camera_between(last, &frame->camera);
  if (orthographic)
    args.thickness =
        fminf(args.thickness,
              args.relative_thickness * (float)view->width * view->inv_fx);
  return args;
}

/* Launches the search.  Where frames share slices, what this one finds goes to
 * the other of two buffers.  composite makes it the plan's, so that a frame
 * which fails leaves none. */
static hbil_status search(hbil_plan *plan, commands *chain,
                          const hbil_frame *frame, hbil_gather_args *args) {
  const cl_mem motion = bind_plane(plan, frame, PLANE_MOTION, &args->motion);
  const cl_mem ratios = fall_ratios(frame);
  const hbil_fall_args fall = fall_args(plan, frame);
  const argument list[] = {ARG(*args),
                           BUFFER_ARG(plan, BUFFER_SPLIT),
                           BUFFER_ARG(plan, BUFFER_STEPS),
                           BUFFER_ARG(plan, BUFFER_LIGHT),
                           BUFFER_ARG(plan, BUFFER_BOUNDS),
                           BUFFER_ARG(plan, BUFFER_USED_GROUPS),
                           BUFFER_ARG(plan, BUFFER_SPAN_STATES),
                           BUFFER_ARG(plan, BUFFER_FLAGS),
                           BUFFER_ARG(plan, BUFFER_SLICES + plan->slices.last),
                           BUFFER_ARG(plan, BUFFER_SLICES + !plan->slices.last),
                           ARG(motion),
                           ARG(fall),
                           ARG(ratios)};
  return LAUNCH(chain, KERNEL_GATHER, list, plan->layout.spans,
                (size_t)plan->layout.split.height,
                (size_t)plan->layout.pattern.gathered);
}

hbil_status enqueue_gather(hbil_plan *plan, commands *chain,
                           const hbil_frame *frame) {
  const hbil_view_args view = camera_view(&frame->camera, &plan->config);
  const hbil_pattern_args pattern = pattern_of(&plan->layout, frame, &view);
  const bool rest = may_rest(plan, frame);
  if (rest && !plan->layout.history)
    return leave_out(plan, HBIL_PASS_GATHER);
  hbil_gather_args args = gather_args(plan, frame, &view, &pattern);
  const bool shares = shares_slices(plan, frame);
  args.is_static = rest;
  hbil_status status = make_patterns(plan, chain, frame, &view);
  if (status == HBIL_SUCCESS)
    status = search(plan, chain, frame, &args);
  plan->slices.written = shares && status == HBIL_SUCCESS;
  plan->searched_all = !shares;
  plan->may_leave_out[HBIL_PASS_GATHER] = rest;
  return status == HBIL_SUCCESS ? enqueue_estimate(plan, chain, frame) : status;
}
