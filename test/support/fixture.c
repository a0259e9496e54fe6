#include "test/support/fixture.h"
#include "hbil/hbil_stages.h"
#include "shared.h"
#include "test/support/shim.h"

const hbil_plane_format one_float = {HBIL_FLOAT32, 4};
const hbil_plane_format three_floats = {HBIL_FLOAT32, 12};

/* ------------------------------------------------------------------------ */
/* Preparing                                                                 */

static hbil_plane_format float_format(plane_id id) {
  return plane_channels(id) == 3 ? three_floats : one_float;
}

static bool has_plane(const setup *s, plane_id id) {
  hbil_config config = s->config;
  return plane_format(&config, id)->component != HBIL_NONE;
}

size_t setup_pixels(const setup *s) {
  return (size_t)s->config.width * s->config.height;
}

/* The model and the sampling that tests begin with: the paper's, which has the
 * fewest parts.  They are stated here so that better defaults of the library
 * change no test.  Floats, because the rounding of packed planes would hide
 * what most tests look for. */
static void use_plain_model(hbil_config *c) {
  c->sampling.storage = HBIL_STORAGE_FLOAT32;
  c->sampling.slices = 2;
  c->sampling.steps_per_side = 8;
  c->sampling.step_growth = 2.0f;
  c->sampling.sample_grid = HBIL_GRID_FULL_RESOLUTION;
  c->model.extrapolate = CL_TRUE;
  c->sampling.unfiltered = CL_FALSE;
  c->model.radius = c->model.thickness = c->model.relative_thickness = INFINITY;
  c->model.facing_fade[0] = -0.1f;
  c->model.facing_fade[1] = 0.0f;
  c->model.back_facing_fallback = HBIL_FALLBACK_LAST_ACCEPTED;
  c->model.gather_emission = CL_TRUE;
  c->history.reprojection = HBIL_REPROJECTION_CAMERA;
  c->model.feedback = HBIL_FEEDBACK_IRRADIANCE;
  c->history.disocclusion_threshold = 0.05f;
  c->model.far_field = HBIL_FAR_NONE;
  c->sampling.slice_frames = 1;
  c->execution.skip = HBIL_SKIP_ALL;
}

void setup_init(setup *s, int width, int height) {
  memset(s, 0, sizeof(*s));
  s->device = &shared_device;
  hbil_config_init(&s->config);
  use_plain_model(&s->config);
  hbil_frame_init(&s->frame);
  s->config.width = (cl_uint)width;
  s->config.height = (cl_uint)height;
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id)
    *plane_format(&s->config, id) = float_format(id);
  s->config.inputs.f0.component = HBIL_NONE;
  s->config.outputs.near_irradiance = s->config.outputs.bent_normal =
      three_floats;
  s->config.outputs.ao = one_float;
  setup_camera(s, 60.0);
  for (int p = 0; p < EXACT_INPUT_PLANES; ++p) {
    s->input[p] = calloc(setup_pixels(s), sizeof(float));
    assert_non_null(s->input[p]);
  }
}

void setup_scene(setup *s, scene_kind kind, int width, int height,
                 uint32_t index) {
  setup_init(s, width, height);
  s->config.inputs.normal_space = HBIL_SPACE_WORLD;
  setup_load_scene(s, kind, index);
}

void setup_every_pass(setup *s, hbil_reprojection reprojection,
                      cl_uint vector_width, int width, int height) {
  setup_scene(s, SCENE_ROOM, width, height, 0);
  setup_all_outputs(s);
  s->config.sampling.storage = HBIL_STORAGE_PACKED;
  s->config.sampling.slices = 1;
  s->config.sampling.steps_per_side = 6;
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.model.far_field = HBIL_FAR_FRAME;
  s->config.history.reprojection = reprojection;
  s->config.execution.vector_width = vector_width;
}

void setup_all_outputs(setup *s) {
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    *plane_format(&s->config, id) = float_format(id);
  s->config.outputs.glossy.component = HBIL_NONE;
}

void setup_no_outputs(setup *s) {
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    plane_format(&s->config, id)->component = HBIL_NONE;
}

void setup_mode(setup *s, hbil_mode mode) {
  s->config.model.mode = mode;
  if (mode != HBIL_MODE_HBIL)
    s->config.outputs.near_irradiance.component =
        s->config.outputs.unknown.component =
            s->config.outputs.glossy.component = HBIL_NONE;
  if (mode == HBIL_MODE_HBAO)
    s->config.outputs.bent_normal.component =
        s->config.outputs.cone_cosine.component =
            s->config.outputs.error_estimate.component = HBIL_NONE;
}

size_t setup_memory(const setup *s) {
  hbil_memory memory;
  assert_success(s, hbil_plan_memory(s->device->hbil, &s->config, &memory));
  return memory.persistent + memory.scratch;
}

/* ------------------------------------------------------------------------ */
/* Inputs and camera                                                         */

void setup_camera(setup *s, double fov_y_degrees) {
  hbil_camera *camera = &s->frame.camera;
  memset(camera, 0, sizeof(*camera));
  camera->cx = 0.5 * s->config.width;
  camera->cy = 0.5 * s->config.height;
  camera->fx = camera->cy / tan(fov_y_degrees * PI / 360.0);
  camera->fy = camera->fx;
  for (int i = 0; i < 4; ++i)
    camera->world_from_view[5 * i] = 1.0;
}

void setup_flatten(setup *s, double width) {
  s->config.inputs.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  s->frame.camera.fx = s->frame.camera.fy = s->config.width / width;
}

void setup_ray(const setup *s, int x, int y, double ray[3]) {
  const hbil_camera *camera = &s->frame.camera;
  ray[0] = (x + 0.5 - camera->cx) / camera->fx;
  ray[1] = (y + 0.5 - camera->cy) / camera->fy;
  ray[2] = 1.0;
}

void setup_load_scene(setup *s, scene_kind kind, uint32_t index) {
  setup_load_view(s, kind, 0.0, index); /* the scene's own field of view */
}

void setup_load_view(setup *s, scene_kind kind, double fov_y_degrees,
                     uint32_t index) {
  scene_frame f;
  size_t size = setup_pixels(s) * sizeof(float);
  const bool orthographic =
      s->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  if (orthographic ? scene_render_orthographic(kind, s->config.width,
                                               s->config.height, 0.0, index, &f)
                   : scene_render(kind, s->config.width, s->config.height,
                                  fov_y_degrees * PI / 180.0, index, &f))
    hard_error("scene_render: out of memory");
  s->frame.camera = f.camera;
  memcpy(s->input[EXACT_DEPTH], f.depth, size);
  for (int c = 0; c < 3; ++c) {
    memcpy(s->input[EXACT_NORMAL + c], f.normal[c], size);
    memcpy(s->input[EXACT_ALBEDO + c], f.albedo[c], size);
    memcpy(s->input[EXACT_DIRECT + c], f.direct[c], size);
    memcpy(s->input[EXACT_EMISSION + c], f.emission[c], size);
  }
  for (int c = 0; c < 2; ++c)
    memcpy(s->input[EXACT_MOTION + c], f.motion[c], size);
  scene_free(&f);
}

void setup_fill(setup *s, int plane, float value) {
  for (size_t i = 0; i < setup_pixels(s); ++i)
    s->input[plane][i] = value;
}

void tilted_normal(double tilt, double azimuth, double normal[3]) {
  normal[0] = sin(tilt) * cos(azimuth);
  normal[1] = sin(tilt) * sin(azimuth);
  normal[2] = -cos(tilt);
}

void setup_plane(setup *s, const double normal[3]) {
  const int width = (int)s->config.width;
  for (int i = 0; i < (int)setup_pixels(s); ++i) {
    double ray[3], slope = 0.0;
    setup_ray(s, i % width, i / width, ray);
    for (int c = 0; c < 3; ++c)
      slope += normal[c] * ray[c];
    const double z = slope < 0.0 ? 3.0 * normal[2] / slope : 0.0;
    s->input[EXACT_DEPTH][i] = z < 6e4 ? (float)z : 0.0f;
    for (int c = 0; c < 3; ++c)
      s->input[EXACT_NORMAL + c][i] = (float)normal[c];
  }
}

/* ------------------------------------------------------------------------ */
/* Running                                                                   */

static void make_plane(setup *s, plane_id id) {
  const plane_layout *layout = s->layout + id;
  hbil_plane *plane = plane_slot(&s->frame, id);
  placement p = place_plane(&s->config, id, layout);
  unsigned char *bytes;
  s->bytes[id] = p.end + CANARY_BYTES;
  bytes = malloc(s->bytes[id]);
  assert_non_null(bytes);
  memset(bytes, CANARY, s->bytes[id]);
  plane->buffer = buffer_new(s->device, s->bytes[id], bytes);
  plane->offset = p.offset;
  plane->row_pitch = layout->row_extra ? p.row : 0;
  plane->plane_pitch = layout->plane_extra ? p.plane : 0;
  free(bytes);
}

void assert_success(const setup *s, hbil_status status) {
  if (status != HBIL_SUCCESS)
    fail_msg("%s: %s", hbil_status_string(status),
             hbil_context_message(s->device->hbil));
}

void setup_start(setup *s) {
  shim_launch_only("clear_padding"); /* it writes what no frame does */
  setup_start_compiled(s);
  shim_launch_only(NULL);
}

void setup_start_compiled(setup *s) {
  assert_success(s, hbil_plan_create(s->device->hbil, &s->config, &s->plan));
  for (plane_id id = 0; id < PLANE_COUNT; ++id)
    if (has_plane(s, id))
      make_plane(s, id);
  setup_upload(s);
}

/* What store_pixel() does of floats, without its questions for every pixel:
 * these would take most of the time of tests with many frames. */
static void store_floats(const setup *s, plane_id id, const placement *p,
                         unsigned char *bytes) {
  for (int c = 0; c < plane_channels(id); ++c) {
    const float *value = s->input[plane_first(id) + c];
    for (size_t y = 0; y < s->config.height; ++y) {
      unsigned char *at = bytes + placement_of(p, c, 0, y);
      for (size_t x = 0; x < s->config.width; ++x, at += p->pixel)
        memcpy(at, value++, sizeof *value);
    }
  }
}

static void store_pixels(setup *s, plane_id id, const placement *p,
                         unsigned char *bytes) {
  const size_t width = s->config.width;
  for (size_t i = 0; i < setup_pixels(s); ++i) {
    float values[3] = {0};
    for (int c = 0; c < plane_channels(id); ++c)
      values[c] = s->input[plane_first(id) + c][i];
    store_pixel(&s->config, &s->frame, id, p, bytes, i % width, i / width,
                values);
    for (int c = 0; c < plane_channels(id); ++c)
      s->input[plane_first(id) + c][i] = values[c];
  }
}

static void upload_plane(setup *s, plane_id id) {
  size_t size;
  cl_mem buffer = plane_slot(&s->frame, id)->buffer;
  unsigned char *bytes = buffer_bytes(s->device, buffer, &size);
  placement p = place_plane(&s->config, id, s->layout + id);
  if (stores_its_values(&s->config, id, &p))
    store_floats(s, id, &p, bytes);
  else
    store_pixels(s, id, &p, bytes);
  buffer_write(s->device, buffer, 0, size, bytes);
  free(bytes);
}

void setup_upload(setup *s) {
  s->job.config = &s->config;
  s->job.camera = s->frame.camera;
  s->job.frame_index = s->frame.frame_index;
  memcpy(s->job.environment, s->frame.environment, sizeof(s->job.environment));
  s->job.sky_share = s->frame.sky_share;
  s->job.exposure = s->frame.exposure;
  for (plane_id id = 0; id < PLANE_FIRST_OUTPUT; ++id) {
    bool has = has_plane(s, id);
    if (has)
      upload_plane(s, id);
    for (int c = 0; c < plane_channels(id); ++c)
      s->job.input[plane_first(id) + c] =
          has ? s->input[plane_first(id) + c] : NULL;
  }
}

void setup_free(setup *s) {
  hbil_plan_destroy(s->plan);
  for (plane_id id = 0; id < PLANE_COUNT; ++id)
    if (plane_slot(&s->frame, id)->buffer)
      clReleaseMemObject(plane_slot(&s->frame, id)->buffer);
  for (int p = 0; p < EXACT_INPUT_PLANES; ++p)
    free(s->input[p]);
}

#define PASS_FUNCTION(name, pass)                                              \
  hbil_status enqueue_##name(hbil_plan *plan, cl_command_queue queue,          \
                             const hbil_frame *frame, cl_uint wait_count,      \
                             const cl_event *wait_list, cl_event *event) {     \
    return hbil_enqueue_passes(plan, queue, frame, pass, pass, wait_count,     \
                               wait_list, event);                              \
  }

PASS_FUNCTION(reproject, HBIL_PASS_REPROJECT)
PASS_FUNCTION(push_pull, HBIL_PASS_PUSH_PULL)
PASS_FUNCTION(split, HBIL_PASS_SPLIT)
PASS_FUNCTION(gather, HBIL_PASS_GATHER)
PASS_FUNCTION(recompose, HBIL_PASS_RECOMPOSE)
PASS_FUNCTION(composite, HBIL_PASS_COMPOSITE)

/* The library measured these, so the exact passes take them over. */
static void take_error_factors(setup *s) {
  hbil_recompose_args args;
  if (!has_plane(s, PLANE_ERROR) || !shim_has_argument("recompose", 0))
    return;
  shim_argument("recompose", 0, sizeof args, &args);
  s->job.error_factors[0] = (double)args.errors.ao;
  s->job.error_factors[1] = (double)args.errors.near_irradiance;
}

enqueue_function *const passes[PASSES] = {enqueue_reproject, enqueue_push_pull,
                                          enqueue_split,     enqueue_gather,
                                          enqueue_recompose, enqueue_composite};

void setup_run(setup *s, enqueue_function *pass) {
  assert_success(s, pass(s->plan, s->device->queue, &s->frame, 0, NULL, NULL));
  assert_int_equal(clFinish(s->device->queue), CL_SUCCESS);
  take_error_factors(s);
}

cl_uint setup_bounces(const setup *s) {
  hbil_last_frame last;
  assert_success(s, hbil_plan_last_frame(s->plan, &last));
  return last.bounces;
}

/* ------------------------------------------------------------------------ */
/* Outputs                                                                   */

/* Takes an output's values and overwrites them with the canary. */
static void take_output(setup *s, plane_id id, unsigned char *bytes,
                        exact_planes *out) {
  placement p = place_plane(&s->config, id, s->layout + id);
  for (int c = 0; c < plane_channels(id); ++c)
    for (int y = 0; y < out->height; ++y) {
      unsigned char *at = bytes + placement_of(&p, c, 0, (size_t)y);
      double *value = exact_at(out, plane_first(id) + c, 0, y);
      for (int x = 0; x < out->width; ++x, at += p.pixel) {
        *value++ = component_value(p.component, at, c);
        memset(at, CANARY, p.size);
      }
    }
}

exact_planes outputs_read(setup *s) {
  exact_planes out = checked_planes((int)s->config.width, (int)s->config.height,
                                    EXACT_OUTPUT_PLANES);
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id) {
    size_t size;
    unsigned char *bytes;
    if (!has_plane(s, id))
      continue;
    bytes = buffer_bytes(s->device, plane_slot(&s->frame, id)->buffer, &size);
    take_output(s, id, bytes, &out);
    for (size_t i = 0; i < size; ++i)
      if (bytes[i] != CANARY)
        fail_msg("%s: byte %zu outside the plane was written", plane_name(id),
                 i);
    free(bytes);
  }
  return out;
}

exact_planes frame_outputs(setup *s) {
  setup_run(s, hbil_enqueue_frame);
  return outputs_read(s);
}

exact_planes last_outputs(setup *s) {
  exact_planes out = outputs_read(s);
  setup_free(s);
  return out;
}

exact_planes first_outputs(setup *s) {
  setup_start(s);
  return frame_outputs(s);
}

#define OUTPUT_LIMIT 1e-4
#define CONE_LIMIT 1e-3

void check_frame_outputs(setup *s, const exact_planes *want) {
  exact_planes got = outputs_read(s);
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    if (has_plane(s, id))
      check_at_most(
          plane_name(id),
          relative_rmse(&got, want, plane_first(id), plane_channels(id)),
          id == PLANE_CONE ? CONE_LIMIT : OUTPUT_LIMIT);
  exact_planes_free(&got);
}
