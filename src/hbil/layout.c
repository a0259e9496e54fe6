/* Sizes and layouts: what a configuration decides before any memory is touched.
 */
#include "layout.h"

#include "config.h"
#include "error_factors.h"
#include "lib/estimate_args.h"
#include "lib/sampling_pattern.h"
#include "planes.h"
#include "searches.h"

#include <math.h>
#include <string.h>

static cl_uint rounded_up(cl_uint n, cl_uint to) {
  return (n + to - 1) / to * to;
}

static bool has(const hbil_config *config, int plane) {
  return plane_format(config, plane)->component != HBIL_NONE;
}

/* Whether the light of what back-facing samples block is estimated. */
static bool estimates_back_faces(const hbil_config *config) {
  return config->model.back_facing_fallback == HBIL_FALLBACK_FRAME_MEAN &&
         config_rejects_back_faces(config);
}

static void decide_work(const hbil_config *config, layout *out) {
  const bool sums = has(config, PLANE_INDIRECT) || has(config, PLANE_BEAUTY);
  const bool from_frame = config->model.far_field == HBIL_FAR_FRAME;
  /* where nothing is guessed, that output is 0 and needs no light */
  const bool guesses = has(config, PLANE_UNKNOWN) &&
                       (from_frame || estimates_back_faces(config));
  out->glossy = has(config, PLANE_GLOSSY);
  out->radiance = config->model.mode == HBIL_MODE_HBIL &&
                  (sums || guesses || out->glossy || has(config, PLANE_NEAR) ||
                   (has(config, PLANE_FAR) && from_frame));
  out->far_field = sums || out->radiance || has(config, PLANE_FAR)
                       ? config->model.far_field
                       : HBIL_FAR_NONE;
  out->probes = config->model.cache_method != HBIL_CACHE_METHOD_NONE &&
                (sums || out->radiance || has(config, PLANE_FAR));
  out->ao_bounces = out->far_field || out->probes ? config->model.ao_bounces
                                                  : HBIL_AO_BOUNCES_NONE;
  out->bent = (has(config, PLANE_BENT) && !out->ao_search) || out->glossy ||
              out->far_field == HBIL_FAR_SH ||
              out->far_field == HBIL_FAR_FRAME || out->probes;
  out->unknown = out->radiance && estimates_back_faces(config);
  out->estimate = out->unknown || out->far_field == HBIL_FAR_FRAME;
  out->history =
      out->radiance && config->history.reprojection != HBIL_REPROJECTION_NONE;
  out->slice_frames = hbil_config_slice_frames(config);
  out->late_counts =
      (sums && !(out->radiance && config->model.gather_emission)) ||
      out->ao_bounces == HBIL_AO_BOUNCES_ALBEDO;
}

/* Whether all outputs are 0 times the irradiance where a surface reflects
 * nothing diffusely.  Irradiance that is carried over would reach other
 * surfaces. */
static bool irradiance_is_hidden(const hbil_config *config, const layout *l) {
  static const int shown[] = {PLANE_NEAR,    PLANE_FAR,   PLANE_AO,
                              PLANE_BENT,    PLANE_CONE,  PLANE_ERROR,
                              PLANE_UNKNOWN, PLANE_GLOSSY};
  for (size_t i = 0; i < sizeof shown / sizeof *shown; ++i)
    if (has(config, shown[i]))
      return false;
  /* `indirect` knows nothing of albedo */
  return !has(config, PLANE_INDIRECT) &&
         (has(config, PLANE_ALBEDO) || has(config, PLANE_F0)) &&
         (!l->history || config->model.feedback == HBIL_FEEDBACK_RADIANCE);
}

static void decide_skips(const hbil_config *config, layout *out) {
  out->skip = config->execution.skip;
  /* samples that face away stand for unknown light, whatever they send */
  if (!out->radiance || out->unknown)
    out->skip &= ~(cl_uint)HBIL_SKIP_DARK;
  if (isinf(config->model.radius))
    out->skip &= ~(cl_uint)HBIL_SKIP_RADIUS;
  /* a frame that leaves pixels out hands nothing of them on */
  if (!irradiance_is_hidden(config, out) || out->slice_frames > 1)
    out->skip &= ~(cl_uint)HBIL_SKIP_UNUSED;
  /* with a radius, spans test this themselves (gather.cl, light_in_reach) */
  out->quadrants = out->skip & HBIL_SKIP_DARK && isinf(config->model.radius) &&
                   !config_has_thickness(config);
}

static hbil_grid_args grid(size_t *end, cl_int width, cl_int height) {
  const hbil_grid_args g = {(cl_uint)*end, width, height};
  *end += 2 * (size_t)width * (size_t)height;
  return g;
}

static cl_int divided_up(cl_int n, cl_int by) {
  return (n + by - 1) / by;
}

/* Returns the words of all grids. */
static size_t lay_out_bounds(const hbil_config *config,
                             const hbil_layer_args *layers,
                             hbil_bounds_args *out, hbil_grid_args *row_block) {
  size_t end = 0;
  const cl_uint group = HBIL_SIDE * config->execution.vector_width;
  const cl_int across = divided_up(layers->width, HBIL_CELL);
  const cl_int down = divided_up(layers->height, HBIL_CELL);
  out->group = grid(&end, divided_up((cl_int)config->width, (cl_int)group),
                    (cl_int)config->height);
  out->cell = grid(&end, across, down);
  if (config->execution.vector_width == 1)
    *row_block =
        grid(&end, across, divided_up((cl_int)config->height, HBIL_ROW_BLOCK));
  out->block =
      grid(&end, divided_up(across, HBIL_BLOCK), divided_up(down, HBIL_BLOCK));
  out->whole = grid(&end, 1, 1);
  out->quadrants = (cl_uint)end;
  return end + (size_t)out->block.width * (size_t)out->block.height;
}

/* Rows of full-resolution planes are padded to whole groups of 4 vectors, so
 * that kernels may work past the right edge.  Rows longer than a group of the
 * widest vectors begin at multiples of it, which is a whole number of cache
 * lines. */
static cl_uint row_of_plane(const hbil_config *config, cl_uint width) {
  const cl_uint widest = 4 * HBIL_WIDEST;
  return rounded_up(width, width > widest ? widest
                                          : 4 * config->execution.vector_width);
}

/* Numbers of planes of the stages, which hold words of 32 bits.  split: without
 * radiance (guides) and with it.  gathered: with AO, with E_near too, with the
 * bent normal too. */
static const struct {
  cl_uint history, carried, guides, split, ao, near_irradiance, bent;
} stored[] = {
    [HBIL_STORAGE_PACKED] = {HBIL_PACKED_HISTORY_PLANES,
                             HBIL_PACKED_CARRIED_PLANES, HBIL_PACKED_RADIANCE,
                             HBIL_PACKED_SPLIT_PLANES, HBIL_PACKED_NEAR,
                             HBIL_PACKED_BENT, HBIL_PACKED_LIGHT_PLANES},
    [HBIL_STORAGE_FLOAT32] = {HBIL_HISTORY_PLANES, HBIL_CARRIED_PLANES,
                              HBIL_SPLIT_RED, HBIL_SPLIT_PLANES, HBIL_LIGHT_RED,
                              HBIL_LIGHT_BENT, HBIL_LIGHT_PLANES}};

static void lay_out_planes(const hbil_config *config, layout *out) {
  out->planes.row = row_of_plane(config, config->width);
  out->planes.plane = out->planes.row * config->height;
}

static cl_uint layer_width(const hbil_config *config) {
  return rounded_up(config->width, HBIL_SIDE) / HBIL_SIDE;
}

/* Layers of at most 4 columns have spans of one vector, because the padding
 * around their rows would take most of the memory.  A span still holds the
 * whole row, so nothing else changes. */
static void lay_out_spans(const hbil_config *config, layout *out) {
  const cl_uint vector = config->execution.vector_width;
  const cl_uint narrow = vector > HBIL_SIDE ? vector : HBIL_SIDE;
  const cl_uint width = layer_width(config);
  out->span = width <= HBIL_SIDE ? narrow : HBIL_SPAN;
  out->taken = vector == 1 ? 1 : out->span;
  out->spans = (width + out->taken - 1) / out->taken;
}

static void lay_out_staged(const hbil_config *config, layout *out) {
  for (int i = 0; i < PLANE_COUNT; ++i)
    if (out->staged.planes & PLANE_BIT(i))
      out->bytes[BUFFER_STAGED + i] = sizeof(cl_float) *
                                      plane_components(config, i) *
                                      (size_t)out->planes.plane;
}

/* Composite is the last command of a frame, unless outputs are copied to images
 * after it.  The history must survive if such a copy can't be enqueued, so
 * composite then writes to a second buffer. */
static void lay_out_history(const hbil_config *config, layout *out) {
  const size_t bytes =
      sizeof(cl_float) *
      (stored[config->sampling.storage].history * (size_t)out->planes.plane +
       2 * (size_t)hbil_history_origin(out->planes));
  out->bytes[BUFFER_HISTORY] = bytes;
  if (out->staged.planes & ~INPUT_PLANES)
    out->bytes[BUFFER_HISTORY_NEXT] = bytes;
}

/* Layers have a span of padding left and right, and a row above and below. */
static void lay_out_layers(const hbil_config *config, cl_uint span,
                           cl_uint planes, hbil_layer_args *l) {
  const cl_uint width = layer_width(config);
  const cl_uint height = rounded_up(config->height, HBIL_SIDE) / HBIL_SIDE;
  l->width = (cl_int)width;
  l->height = (cl_int)height;
  l->row_extent = rounded_up(width, span) + 2 * span;
  l->plane = l->row_extent;
  l->layer = l->plane * planes;
  l->row = l->layer * HBIL_LAYERS;
  l->origin = l->row + span;
}

/* Layers that are gathered. */
static cl_uint gathered_layers(const hbil_config *config) {
  return hbil_config_resolution(config) == HBIL_RESOLUTION_HALF ? 4
                                                                : HBIL_LAYERS;
}

static size_t layers_size(const hbil_layer_args *l) {
  return sizeof(cl_float) * l->row * ((size_t)l->height + 2);
}

/* Levels are halved down to one texel.  Returns the floats of all levels. */
static size_t lay_out_chain(const hbil_config *config, layout *out) {
  cl_uint width = config->width, height = config->height;
  size_t end = 0;
  out->carried_planes = stored[config->sampling.storage].carried;
  for (out->chain_count = 0; out->chain_count < MAX_CHAIN;) {
    hbil_chain_args *level = &out->chain[out->chain_count++];
    level->width = (cl_int)width;
    level->height = (cl_int)height;
    level->row = row_of_plane(config, width);
    level->plane = level->row * height;
    level->offset = (cl_uint)end;
    end += (size_t)out->carried_planes * level->plane;
    if (width == 1 && height == 1)
      break;
    width = (width + 1) / 2;
    height = (height + 1) / 2;
  }
  return end;
}

static cl_uint light_planes(const layout *l) {
  return l->bent       ? HBIL_LIGHT_PLANES
         : l->radiance ? HBIL_LIGHT_BENT
                       : HBIL_LIGHT_RED;
}

static cl_uint split_planes(const hbil_config *config, const layout *l) {
  return l->radiance ? stored[config->sampling.storage].split
                     : stored[config->sampling.storage].guides;
}

static cl_uint gathered_planes(const hbil_config *config, const layout *l) {
  if (l->unknown && config->sampling.storage == HBIL_STORAGE_FLOAT32)
    return HBIL_LIGHT_UNKNOWN + 1;
  return l->bent       ? stored[config->sampling.storage].bent
         : l->radiance ? stored[config->sampling.storage].near_irradiance
                       : stored[config->sampling.storage].ao;
}

/* Probes stand at least so many pixels apart, and the farther the larger the
 * picture is, as long as there are enough of them: their number decides the
 * time, and light from afar changes slowly over the picture, whatever its
 * resolution. */
enum { PROBE_SPACING = 8, LEAST_PROBES_ACROSS = 40 };

static void lay_out_probes(const hbil_config *config, layout *out) {
  hbil_probe_grid_args *g = &out->probe_grid;
  if (!out->probes)
    return;
  g->spacing = PROBE_SPACING;
  const cl_uint longer =
      config->width > config->height ? config->width : config->height;
  while (2 * (cl_uint)g->spacing * LEAST_PROBES_ACROSS <= longer)
    g->spacing *= 2;
  g->columns = divided_up((cl_int)config->width - 1, g->spacing) + 1;
  /* lines of corners and of insides alternate; no cells lie below the last
   * corners */
  g->lines = 2 * divided_up((cl_int)config->height - 1, g->spacing) + 1;
  out->bytes[BUFFER_PROBES] = out->bytes[BUFFER_FILTERED_PROBES] =
      out->bytes[BUFFER_PROBE_HISTORY] = out->bytes[BUFFER_PROBE_HISTORY_NEXT] =
          sizeof(cl_float) * HBIL_PROBE_FLOATS * (size_t)g->columns *
          (size_t)g->lines;
  if (out->glossy)
    out->bytes[BUFFER_GLOSSY_PROBES] = sizeof(cl_float) *
                                       HBIL_GLOSSY_PROBE_FLOATS *
                                       (size_t)g->columns * (size_t)g->lines;
}

/* Behind the light come planes that outputs ask for. */
static void lay_out_resolved(const hbil_config *config, layout *out) {
  const cl_uint errors = !has(config, PLANE_ERROR) ? 0 : out->radiance ? 2 : 1;
  const bool unknown = out->unknown && has(config, PLANE_UNKNOWN);
  out->glossy_resolved = light_planes(out);
  out->error_plane = light_planes(out) + (out->glossy ? HBIL_GLOSSY_PLANES : 0);
  out->resolved_planes = out->error_plane + errors + unknown;
  out->unknown_plane = unknown ? out->resolved_planes - 1 : 0;
  out->bytes[BUFFER_RESOLVED] =
      sizeof(cl_float) * out->resolved_planes * (size_t)out->planes.plane;
}

/* Lanes of each part of the estimate: as many as the layers have rows for,
 * since the sums of the others are zero. */
static cl_uint estimate_lanes(const hbil_layer_args *layers) {
  const cl_uint rows = ((cl_uint)layers->height + 3) / 4;
  const cl_uint lanes = HBIL_ESTIMATE_BLOCK * rows;
  return lanes < HBIL_ESTIMATE_LANES ? lanes : HBIL_ESTIMATE_LANES;
}

/* The pixels of a cache line of the outputs, of half floats if there are any,
 * because storing less than a line past the caches is slow. */
static cl_uint composed_line(const hbil_config *config) {
  cl_uint line = HBIL_WIDEST;
  if (config->execution.vector_width == 1)
    return 1;
  for (int i = PLANE_FIRST_OUTPUT; i < PLANE_COUNT; ++i)
    if (plane_format(config, i)->component == HBIL_FLOAT16)
      line = 2 * HBIL_WIDEST;
  return line;
}

bool layout_is_scratch(int buffer) {
  switch (buffer) {
  case BUFFER_CARRIED:
  case BUFFER_SPLIT:
  case BUFFER_LIGHT:
  case BUFFER_RESOLVED:
  case BUFFER_AO_LIGHT:
  case BUFFER_AO_RESOLVED:
  case BUFFER_PROBES:
  case BUFFER_FILTERED_PROBES:
  case BUFFER_GLOSSY_PROBES:
  case BUFFER_BOUNDS:
  case BUFFER_USED_GROUPS:
    return true;
  }
  return buffer >= BUFFER_STAGED;
}

/* Adds up the buffers, and puts scratch buffers one behind the other. */
static void lay_out_memory(size_t alignment, layout *out) {
  for (int i = 0; i < BUFFER_COUNT; ++i) {
    if (!layout_is_scratch(i)) {
      out->memory.persistent += out->bytes[i];
      continue;
    }
    out->bytes[i] = (out->bytes[i] + alignment - 1) / alignment * alignment;
    out->at[i] = out->memory.scratch;
    out->memory.scratch += out->bytes[i];
  }
}

static void lay_out_steps(const hbil_config *config, layout *out) {
  const cl_uint steps = near_steps(config);
  out->pattern.slices = (cl_int)config->sampling.slices;
  out->pattern.steps = (cl_int)steps;
  out->pattern.levels = isinf(config->model.radius) ? 1 : HBIL_MAX_LEVELS;
  out->pattern.grid =
      config->sampling.sample_grid == HBIL_GRID_SAME_LAYER ? HBIL_SIDE : 1;
  out->pattern.growth = config->sampling.step_growth;
  out->pattern.gathered = (cl_int)gathered_layers(config);
  out->bytes[BUFFER_STEPS] = sizeof(hbil_step) * (size_t)out->pattern.levels *
                             (size_t)hbil_sites(out->pattern.gathered) * 2 *
                             config->sampling.slices * (steps + 1);
}

/* Its buffers are as large as the plan's own, but for the table of steps; it
 * reads the plan's layers. */
void layout_of_ao_search(const hbil_config *ao, const layout *whole,
                         layout *out) {
  layout_compute(ao, &whole->staged, 1, out);
  out->split = whole->split;
  out->bounds = whole->bounds;
}

static void lay_out_ao_search(const hbil_config *ao, layout *out) {
  static const int buffers[][2] = {{BUFFER_AO_STEPS, BUFFER_STEPS},
                                   {BUFFER_AO_LIGHT, BUFFER_LIGHT},
                                   {BUFFER_AO_RESOLVED, BUFFER_RESOLVED},
                                   {BUFFER_AO_SLICES, BUFFER_SLICES},
                                   {BUFFER_AO_SLICES_NEXT, BUFFER_SLICES_NEXT},
                                   {BUFFER_AO_SPAN_STATES, BUFFER_SPAN_STATES}};
  layout search;
  layout_of_ao_search(ao, out, &search);
  out->ao_error_plane = search.error_plane;
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; ++i)
    out->bytes[buffers[i][0]] = search.bytes[buffers[i][1]];
}

void layout_compute(const hbil_config *config, const staging *staged,
                    size_t alignment, layout *out) {
  hbil_config ao_config;
  memset(out, 0, sizeof *out);
  out->staged = *staged;
  out->ao_search = searches_differ(config, &ao_config);
  decide_work(config, out);
  decide_skips(config, out);
  lay_out_planes(config, out);
  lay_out_staged(config, out);
  out->line = composed_line(config);
  const size_t chain = lay_out_chain(config, out);
  const size_t real = sizeof(cl_float);
  if (out->history) {
    lay_out_history(config, out);
    out->bytes[BUFFER_CARRIED] = chain * real;
  }
  lay_out_spans(config, out);
  lay_out_layers(config, out->span, split_planes(config, out), &out->split);
  const cl_uint gathered = gathered_planes(config, out);
  const bool weighted =
      out->slice_frames > 1 ||
      (config->sampling.slices == 1 && !config->sampling.unfiltered);
  out->weight_plane = weighted ? gathered : 0;
  out->glossy_plane = out->glossy ? gathered + weighted : 0;
  lay_out_layers(config, out->span,
                 gathered + weighted +
                     (out->glossy ? HBIL_GATHERED_GLOSSY_PLANES : 0),
                 &out->light);
  if (out->slice_frames > 1) {
    lay_out_layers(config, out->span,
                   HBIL_PAST_SETS + (out->slice_frames - 1) * (gathered + 1),
                   &out->past);
    /* the layers that are gathered, one after the other */
    out->past.row = out->past.layer * gathered_layers(config);
    out->past.origin = out->past.row + out->span;
    out->bytes[BUFFER_SLICES] = out->bytes[BUFFER_SLICES_NEXT] =
        layers_size(&out->past);
  }
  out->bytes[BUFFER_SPLIT] = layers_size(&out->split);
  out->bytes[BUFFER_LIGHT] = layers_size(&out->light);
  lay_out_resolved(config, out);
  lay_out_probes(config, out);
  out->estimate_lanes =
      config->execution.vector_width == 1 ? estimate_lanes(&out->split) : 1;
  if (out->estimate)
    out->bytes[BUFFER_ESTIMATE] =
        real * (HBIL_ESTIMATE_SIZE +
                (out->estimate_lanes > 1 ? HBIL_ESTIMATE_LANES_SIZE : 0));
  out->bytes[BUFFER_SANITIZED] = HBIL_SANITIZED_WORDS * sizeof(cl_uint);
  out->bytes[BUFFER_FLAGS] = HBIL_FLAGS * sizeof(cl_uint);
  if (out->skip & (HBIL_SKIP_OPEN | HBIL_SKIP_DARK))
    out->bytes[BUFFER_BOUNDS] =
        sizeof(cl_uint) *
        lay_out_bounds(config, &out->split, &out->bounds, &out->row_block);
  const size_t width = config->execution.vector_width;
  if (out->skip & HBIL_SKIP_UNUSED)
    out->bytes[BUFFER_USED_GROUPS] =
        sizeof(cl_uint) * config->height *
        ((config->width + 4 * width - 1) / (4 * width));
  out->bytes[BUFFER_SPAN_STATES] =
      2 * out->spans * (size_t)out->split.height * HBIL_LAYERS;
  lay_out_steps(config, out);
  out->errors = error_factors(out->pattern.slices, out->pattern.steps,
                              config_has_thickness(config),
                              out->pattern.gathered < HBIL_LAYERS);
  if (out->ao_search)
    lay_out_ao_search(&ao_config, out);
  lay_out_memory(alignment, out);
}
