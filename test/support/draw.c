/* See draw.h. */
#include "test/support/draw.h"

#include "scene/store.h"
#include "test/support/stress.h"

cl_uint random_below(random_state *r, int count) {
  return (cl_uint)(random_unit(r) * count);
}

static bool maybe(random_state *r, double probability) {
  return random_unit(r) < probability;
}

/* ------------------------------------------------------------------------ */
/* Formats                                                                   */

static hbil_component any_component(plane_id id, random_state *r) {
  static const hbil_component floats[] = {HBIL_FLOAT32, HBIL_FLOAT16};
  static const hbil_component normals[] = {
      HBIL_FLOAT32, HBIL_FLOAT16, HBIL_SNORM16, HBIL_UNORM8, HBIL_UNORM16};
  static const hbil_component colours[] = {
      HBIL_FLOAT32,         HBIL_FLOAT16,     HBIL_FLOAT32,
      HBIL_UNORM8,          HBIL_UNORM16,     HBIL_RGB10A2_UNORM,
      HBIL_R11G11B10_FLOAT, HBIL_RGB9E5_FLOAT};
  if (id == PLANE_NORMAL)
    return ANY_OF(r, normals);
  return id >= PLANE_ALBEDO && id <= PLANE_EMISSION ? ANY_OF(r, colours)
                                                    : ANY_OF(r, floats);
}

static hbil_plane_format any_format(plane_id id, random_state *r) {
  const hbil_component component = any_component(id, r);
  const cl_uint channels =
      scene_is_word(component) ? 1 : (cl_uint)plane_channels(id);
  const cl_uint strides[] = {0, 1, channels, 4};
  return pitched_format(component, ANY_OF(r, strides));
}

/* Room around planes, and between their rows and channels. */
static plane_layout any_layout(plane_id id, const hbil_plane_format *f,
                               random_state *r) {
  plane_layout layout = {random_below(r, 9), random_below(r, 5), 0};
  if (plane_channels(id) > 1 && !scene_is_word(f->component) &&
      f->pixel_pitch == scene_component_size(f->component))
    layout.plane_extra = random_below(r, 13);
  return layout;
}

static void any_formats(setup *s, random_state *r) {
  hbil_config *c = &s->config;
  for (plane_id id = 0; id < PLANE_COUNT; ++id) {
    const bool optional = (id >= PLANE_ALBEDO && id <= PLANE_EMISSION) ||
                          id >= PLANE_FIRST_OUTPUT;
    hbil_plane_format *format = plane_format(c, id);
    *format = any_format(id, r);
    if (maybe(r, 0.5))
      s->layout[id] = any_layout(id, format, r);
    if (optional && maybe(r, 0.25))
      format->component = HBIL_NONE;
  }
  if (maybe(r, 0.1)) { /* one output alone */
    const plane_id id =
        PLANE_FIRST_OUTPUT + random_below(r, PLANE_COUNT - PLANE_FIRST_OUTPUT);
    setup_no_outputs(s);
    *plane_format(c, id) = any_format(id, r);
  }
  c->inputs.normal_encoding = (hbil_normal_encoding)maybe(r, 0.2);
  c->inputs.normal_space = (hbil_space)random_below(r, 2);
  c->outputs.bent_normal_space = (hbil_space)random_below(r, 2);
}

/* Units and axes of the inputs; their values are divided by these. */
static void any_units(hbil_inputs *c, hardness kind, random_state *r) {
  static const float axes[][3] = {
      {1, 1, 1}, {1, 1, 1}, {1, -1, -1}, {1, -1, 1}, {-3, 0.5f, 2}};
  static const float depths[] = {1.0f, 1.0f, 0.01f, -1.0f};
  static const float motions[] = {1.0f, -0.75f, 20.0f};
  const float *axis = axes[random_below(r, 5)];
  c->depth_kind = (hbil_depth_kind)random_below(r, 2);
  if (kind == SCENES && c->projection == HBIL_PROJECTION_PERSPECTIVE &&
      maybe(r, 0.2))
    c->depth_kind = HBIL_DEPTH_HARDWARE;
  c->depth_scale = ANY_OF(r, depths);
  for (int i = 0; i < 3; ++i)
    c->normal_scale[i] = axis[i];
  c->motion_scale[0] = ANY_OF(r, motions);
  c->direct_scale = maybe(r, 0.2) ? (kind == WILD ? 1e10f : 2.5f) : 1.0f;
  c->sky_depth = maybe(r, 0.2) ? (kind == WILD ? 1e6f : 20.0f) : INFINITY;
}

/* ------------------------------------------------------------------------ */
/* Settings                                                                  */

static void any_lengths(hbil_model *m, hardness kind, random_state *r) {
  static const float near[] = {0.25f, 1.0f, 2.0f};
  static const float wild[] = {1e-6f, 0.3f, 2.0f, 1e4f, 1e12f};
  m->radius = maybe(r, 0.5)  ? INFINITY
              : kind == WILD ? ANY_OF(r, wild)
                             : ANY_OF(r, near);
  m->thickness = m->relative_thickness = INFINITY;
  if (kind == HARD || maybe(r, 0.4))
    return;
  if (maybe(r, 0.5))
    m->thickness = kind == WILD ? ANY_OF(r, wild) : 0.1f;
  if (isinf(m->thickness) || maybe(r, 0.3))
    m->relative_thickness = kind == WILD && maybe(r, 0.3) ? 1e-6f : 0.08f;
}

/* Limits of the search for the outputs: half of the cases have one search. */
static void any_search(hbil_model *m, uint64_t seed) {
  static const float radii[] = {INFINITY, 0.5f, 2.0f};
  m->ao_radius = seed / 3 % 2 ? m->radius : radii[seed / 6 % 3];
  if (seed / 3 % 2 == 0 && seed / 18 % 2 && !isinf(m->relative_thickness))
    m->near_relative_thickness = 0.02f;
}

static void any_facing(hbil_model *m, random_state *r) {
  static const float fades[][2] = {{-1.0f, -1.0f}, {-0.1f, 0.0f}, {-0.5f, 0.5f},
                                   {0.2f, 0.2f},   {0.0f, 1.0f},  {1.0f, 1.0f}};
  const float *fade = fades[random_below(r, 6)];
  m->facing_fade[0] = fade[0];
  m->facing_fade[1] = fade[1];
  m->back_facing_fallback = (hbil_back_facing_fallback)random_below(r, 3);
}

/* Leaves out what a mode doesn't have. */
static void any_mode(setup *s, random_state *r) {
  hbil_config *c = &s->config;
  setup_mode(s, (hbil_mode)(maybe(r, 0.6) ? 0 : random_below(r, 3)));
  c->model.falloff = (hbil_falloff)random_below(r, 3);
  c->model.far_field =
      (hbil_far_field)random_below(r, c->model.mode == HBIL_MODE_HBIL   ? 4
                                      : c->model.mode == HBIL_MODE_GTAO ? 3
                                                                        : 2);
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id)
    if (plane_format(c, id)->component)
      return;
  c->outputs.ao = one_float;
}

static void any_model(setup *s, hardness kind, random_state *r) {
  static const float roughness[] = {0.3f, 0.6f, 1.0f};
  hbil_config *c = &s->config;
  c->inputs.projection = (hbil_projection)maybe(r, 0.25);
  any_mode(s, r);
  any_lengths(&c->model, kind, r);
  any_facing(&c->model, r);
  c->model.extrapolate = (cl_bool)random_below(r, 2);
  c->model.gather_emission = (cl_bool)random_below(r, 2);
  c->model.feedback = (hbil_feedback)random_below(r, 2);
  c->model.offscreen_light = (float)random_unit(r);
  c->model.roughness = ANY_OF(r, roughness);
  c->history.reprojection = (hbil_reprojection)random_below(r, 3);
  c->history.disocclusion_threshold = maybe(r, 0.2) ? INFINITY : 0.05f;
}

static void any_sampling(hbil_config *c, random_state *r) {
  static const cl_uint samples[] = {1, 3, 8, 16, 33}, widths[] = {1, 4, 8, 16};
  static const float growth[] = {0.0f, 2.0f, 64.0f};
  c->sampling.slices = 1 + random_below(r, 4);
  if (maybe(r, 0.25)) /* its slice is weighed */
    c->sampling.slices = 1;
  c->sampling.steps_per_side = ANY_OF(r, samples);
  c->sampling.step_growth = ANY_OF(r, growth);
  c->sampling.sample_grid = (hbil_sample_grid)random_below(r, 2);
  c->sampling.unfiltered = maybe(r, 0.2);
  c->sampling.resolution =
      c->sampling.unfiltered
          ? HBIL_RESOLUTION_FULL
          : (hbil_resolution)random_below(r, HBIL_RESOLUTION_HALF + 1);
  c->sampling.storage =
      maybe(r, 0.5) ? HBIL_STORAGE_PACKED : HBIL_STORAGE_FLOAT32;
  c->execution.vector_width = ANY_OF(r, widths);
  c->execution.skip =
      maybe(r, 0.5) ? HBIL_SKIP_ALL : random_below(r, HBIL_SKIP_ALL + 1);
}

/* ------------------------------------------------------------------------ */
/* Cases                                                                     */

static void any_size(int size[2], random_state *r) {
  /* the least ones, and more than two spans of the widest vectors */
  static const int sizes[][2] = {{1, 1},  {3, 5},   {17, 31},
                                 {1, 37}, {64, 36}, {301, 20}};
  const cl_uint i = random_below(r, 12);
  size[0] = i < 6 ? sizes[i][0] : 1 + (int)random_below(r, 97);
  size[1] = i < 6 ? sizes[i][1] : 1 + (int)random_below(r, 67);
}

/* d.z = 0.1 for a reversed depth buffer without a far plane. */
#define HARDWARE_NEAR 0.1

void draw_case(setup *s, drawn *d, uint64_t seed) {
  random_state *r = &d->r;
  int size[2];
  d->seed = r->state = seed;
  d->kind = maybe(r, 0.6) ? SCENES : maybe(r, 0.5) ? HARD : WILD;
  d->what = d->kind == SCENES ? ROOM : (content)random_below(r, CONTENTS);
  d->scale = d->kind == WILD ? pow(10.0, 16.0 * random_unit(r) - 6.0) : 1.0;
  d->spoiled = d->kind == WILD && maybe(r, 0.5) ? 0.1 * random_unit(r) : 0.0;
  d->view = views[random_below(r, VIEWS)];
  any_size(size, r);
  setup_init(s, size[0], size[1]);
  any_formats(s, r);
  any_model(s, d->kind, r);
  any_sampling(&s->config, r);
  /* not by `r`: the other settings of a seed stay as they were */
  if (s->config.model.mode != HBIL_MODE_HBIL)
    s->config.model.ao_bounces = (hbil_ao_bounces)(seed % 3);
  any_search(&s->config.model, seed);
  any_units(&s->config.inputs, d->kind, r);
  /* nor by `r`, as above */
  s->config.inputs.direct_kind = (hbil_direct_kind)(seed / 5 % 3 == 0);
  s->frame.hardware_depth[0] = 0.0;
  s->frame.hardware_depth[1] = HARDWARE_NEAR;
}

/* What decides about build defines and about paths of the kernels. */
enum { FEATURES = 32, VALUES = 16, CANDIDATES = 64 };

static void features_of(const setup *s, const drawn *d, int f[FEATURES]) {
  const hbil_config *c = &s->config;
  const hbil_model *m = &c->model;
  const int all[FEATURES] = {
      c->sampling.storage,
      (int)(c->execution.vector_width % 13), /* 1, 4, 8, 3 */
      m->mode,
      d->kind,
      c->inputs.projection,
      isinf(m->radius),
      m->ao_radius == m->radius ? 0 : 1 + isinf(m->ao_radius),
      isinf(m->near_relative_thickness),
      !isinf(m->thickness) + 2 * !isinf(m->relative_thickness),
      m->facing_fade[1] <= -1.0f ? 0
                                 : 1 + (m->facing_fade[0] < m->facing_fade[1]),
      m->back_facing_fallback,
      (int)m->extrapolate,
      (int)m->gather_emission,
      m->feedback,
      m->far_field,
      m->mode == HBIL_MODE_HBAO ? m->falloff : 0,
      c->history.reprojection,
      c->sampling.slices == 1,
      c->sampling.sample_grid,
      (int)hbil_config_resolution(c) + 2 * (int)c->sampling.unfiltered,
      (int)c->inputs.depth.component +
          8 * (c->inputs.depth_kind == HBIL_DEPTH_RAY),
      c->inputs.depth_kind == HBIL_DEPTH_HARDWARE,
      c->inputs.normal.component,
      c->inputs.normal_encoding,
      c->inputs.albedo.component,
      c->inputs.direct.component,
      c->inputs.emission.component,
      c->outputs.beauty.component,
      c->outputs.glossy.component != HBIL_NONE,
      c->outputs.error_estimate.component,
      c->outputs.unknown.component,
      c->outputs.bent_normal.component};
  memcpy(f, all, sizeof all);
}

/* Counts the pairs of a case's values that `seen` lacks. */
static int count_new(const setup *s, const drawn *d,
                     unsigned char seen[FEATURES * VALUES][FEATURES * VALUES],
                     bool add) {
  int f[FEATURES], count = 0;
  features_of(s, d, f);
  for (int i = 0; i < FEATURES; ++i)
    for (int j = 0; j < i; ++j) {
      unsigned char *pair = &seen[VALUES * i + f[i]][VALUES * j + f[j]];
      count += !*pair;
      *pair |= add;
    }
  return count;
}

void draw_covering_case(setup *s, drawn *d, uint64_t seed, uint64_t index) {
  static unsigned char seen[FEATURES * VALUES][FEATURES * VALUES];
  int most = -1;
  uint64_t best = seed;
  for (uint64_t i = 0; i < CANDIDATES; ++i) {
    draw_case(s, d, seed + CANDIDATES * index + i);
    const int count = count_new(s, d, seen, false);
    setup_free(s);
    if (count > most) {
      most = count;
      best = d->seed;
    }
  }
  draw_case(s, d, best);
  count_new(s, d, seen, true);
}

void draw_tell(const setup *s, const drawn *d) {
  const hbil_config *c = &s->config;
  const hbil_model *m = &c->model;
  const camera_view *v = &d->view;
  char formats[PLANE_COUNT * 40] = "";
  for (plane_id id = 0; id < PLANE_COUNT; ++id) {
    hbil_config copy = *c;
    const hbil_plane_format *f = plane_format(&copy, id);
    snprintf(formats + strlen(formats), 40, "%s %d/%u, ", plane_name(id),
             (int)f->component, f->pixel_pitch);
  }
  STRESS_CASE(
      "HBIL_STRESS_CASE=%llu: %s in units of %g, %.3g of it spoiled, "
      "field of view %g, off centre %g, %g, pixels 1 : %g\n"
      "%u x %u, projection %d mode %d falloff %d radius %g ao_radius %g "
      "thickness %g %g near %g "
      "facing_fade %g %g fallback %d extrapolate %d gather_emission %d "
      "feedback %d far_field %d roughness %g ao_bounces %d, reprojection %d "
      "disocclusion %g\n"
      "%u x %u growth %g grid %d resolution %d unfiltered %d storage %d "
      "width %u skip %u\n%s"
      "depth_kind %d scale %g, sky_depth %g, normal_encoding %d space %d scale "
      "%g %g %g, direct_kind %d scale %g, motion_scale %g",
      (unsigned long long)d->seed,
      d->kind == SCENES ? "scenes" : content_names[d->what], d->scale,
      d->spoiled, v->fov, v->off_x, v->off_y, v->pixel, c->width, c->height,
      (int)c->inputs.projection, (int)m->mode, (int)m->falloff,
      (double)m->radius, (double)m->ao_radius, (double)m->thickness,
      (double)m->relative_thickness, (double)m->near_relative_thickness,
      (double)m->facing_fade[0], (double)m->facing_fade[1],
      (int)m->back_facing_fallback, (int)m->extrapolate,
      (int)m->gather_emission, (int)m->feedback, (int)m->far_field,
      (double)m->roughness, (int)m->ao_bounces, (int)c->history.reprojection,
      (double)c->history.disocclusion_threshold, c->sampling.slices,
      c->sampling.steps_per_side, (double)c->sampling.step_growth,
      (int)c->sampling.sample_grid, (int)c->sampling.resolution,
      (int)c->sampling.unfiltered, (int)c->sampling.storage,
      c->execution.vector_width, c->execution.skip, formats,
      (int)c->inputs.depth_kind, (double)c->inputs.depth_scale,
      (double)c->inputs.sky_depth, (int)c->inputs.normal_encoding,
      (int)c->inputs.normal_space, (double)c->inputs.normal_scale[0],
      (double)c->inputs.normal_scale[1], (double)c->inputs.normal_scale[2],
      (int)c->inputs.direct_kind, (double)c->inputs.direct_scale,
      (double)c->inputs.motion_scale[0]);
}

/* ------------------------------------------------------------------------ */
/* Frames                                                                    */

/* Depths are in units of `scale`, and all values before depth_scale and
 * normal_scale. */
static void scale_inputs(setup *s, double scale) {
  const hbil_inputs *c = &s->config.inputs;
  if (c->depth_kind != HBIL_DEPTH_HARDWARE)
    scale /= (double)c->depth_scale;
  for (size_t i = 0; i < setup_pixels(s); ++i) {
    s->input[EXACT_DEPTH][i] =
        (float)((double)s->input[EXACT_DEPTH][i] * scale);
    for (int k = 0; k < 3; ++k)
      s->input[EXACT_NORMAL + k][i] /= c->normal_scale[k];
  }
}

static void load(setup *s, drawn *d, uint32_t index) {
  static const double fovs[] = {0.0, 30.0, 90.0, 120.0};
  if (d->kind == SCENES) {
    setup_load_view(s, d->seed & 1 ? SCENE_SKY : SCENE_ROOM,
                    fovs[d->seed / 2 % 4], index);
    if (s->config.inputs.normal_space == HBIL_SPACE_VIEW)
      stress_normals_to_view(s);
    for (int c = 0; c < 3; ++c)
      for (size_t i = 0; i < setup_pixels(s); ++i)
        s->input[EXACT_F0 + c][i] = (float)random_unit(&d->r);
    return;
  }
  if (d->what == ROOM) {
    stress_load_room(s, index);
    return;
  }
  set_view(s, &d->view);
  load_content(s, d->what, index, &d->r);
}

void draw_frame(setup *s, drawn *d, uint32_t index) {
  load(s, d, index);
  s->frame.frame_index = index;
  for (int i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      s->frame.environment[i][c] = (float)(i ? 0.5 * random_unit(&d->r) - 0.25
                                             : 1.5 + random_unit(&d->r));
  s->frame.sky_share = (float)random_unit(&d->r);
  for (int c = 0; c < 3 && d->kind != SCENES; ++c)
    s->frame.camera.world_from_view[4 * c + 3] += 0.1 * index * d->scale;
  scale_inputs(s, d->scale);
  if (index % 2)
    s->frame.exposure = (float)exp2(8.0 * random_unit(&d->r) - 4.0);
  spoil(s, &d->r, d->spoiled);
  setup_upload(s);
}
