/* Settings that the pixels of frames decide: what direct light already contains
 * of the light of the sky and of the lamps in the pictures. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "context.h"
#include "look.h"

/* The sky counts as visible above this share of the pixels. */
#define SKY_SEEN 1e-3
/* Direct light contains the sky's if it reaches this share of the sky's
 * radiance.  Even a small window lets more in. */
#define LEAST_SKY 0.02
/* Direct light contains the lamps' if it reaches this share of what the lamps
 * would send without obstacles.  Half of the surfaces may be in shadow. */
#define LEAST_CONTAINED 0.5

static const double pi = 3.14159265358979323846;

/* --- the sky --- */

/* Adds the picture's sky, if it shows more than a few pixels of it. Returns
 * whether it does. */
static bool add_sky(const look *l, hbil_sources *found) {
  double sum[3] = {0};
  size_t sky = 0;
  for (size_t i = 0; i < l->pixels; ++i) {
    double sum_here = 0;
    for (size_t c = 0; c < 3 && look_is_sky(l, i); ++c) {
      const double v = look_light(l, &l->planes.emission, c, i);
      sum[c] += sqrt(v);
      sum_here += v;
    }
    sky += sum_here > 0;
  }
  if (!((double)sky > SKY_SEEN * (double)l->pixels))
    return false;
  for (size_t c = 0; c < 3; ++c)
    found->known.sky_roots[c] += sum[c];
  found->known.sky_pixels += (double)sky;
  return true;
}

/* The radiance of the sky that was seen: the mean of the square roots, squared,
 * so that the sun's disc counts for little. */
static void sky_radiance(const hbil_sources *found, float out[3]) {
  for (size_t c = 0; c < 3; ++c) {
    const double root =
        found->known.sky_roots[c] / fmax(found->known.sky_pixels, 1);
    out[c] = (float)(root * root);
  }
}

/* Whether direct light reaches LEAST_SKY of the sky's radiance at more than a
 * few pixels. */
static bool contains_sky(const look *l, const float sky[3]) {
  size_t bright = 0;
  for (size_t i = 0; i < l->pixels; ++i)
    for (size_t c = 0; c < 3; ++c)
      if (sky[c] > 0 &&
          look_irradiance(l, c, i) / pi > LEAST_SKY * (double)sky[c]) {
        ++bright;
        break;
      }
  return (double)bright > SKY_SEEN * (double)l->pixels;
}

/* Whether direct light contains the sky is told by pictures that show it. */
static void look_at_sky(const look *l, hbil_sources *found, float radiance[3]) {
  const bool shows = add_sky(l, found);
  sky_radiance(found, radiance);
  if (shows && contains_sky(l, radiance))
    found->sky = HBIL_SOURCE_IN_DIRECT;
  else if (shows && found->sky == HBIL_SOURCE_NOT_SEEN)
    found->sky = HBIL_SOURCE_NOT_IN_DIRECT;
}

/* --- lamps --- */

/* Whether a surface emits light, as the sum of its channels tells. */
static bool emits(const look *l, size_t i) {
  const hbil_host_plane *emission = &l->planes.emission;
  double sum = 0;
  for (size_t c = 0; c < 3 && look_has(emission); ++c)
    sum += look_value(l, emission, c, i);
  return isfinite(sum) && sum > 0 && !look_is_sky(l, i);
}

/* A lamp: some neighbouring pixels that emit light, taken as one. */
typedef struct lamp {
  patch patch;
  double light; /* the sum of the channels */
} lamp;

enum { MOST_LAMPS = 512, MOST_RECEIVERS = 2048 };

/* Takes every n-th of the emitting pixels, so that at most MOST_LAMPS stand for
 * all of them. */
static size_t find_lamps(const look *l, lamp out[MOST_LAMPS]) {
  size_t emitting = 0, count = 0, seen = 0;
  for (size_t i = 0; i < l->pixels; ++i)
    emitting += emits(l, i);
  const size_t every = emitting / MOST_LAMPS + 1;
  for (size_t i = 0; i < l->pixels; ++i) {
    lamp here = {.light = 0};
    if (!emits(l, i) || seen++ % every || !look_patch(l, i, &here.patch))
      continue;
    here.patch.area *= (double)every;
    for (size_t c = 0; c < 3; ++c)
      here.light += look_light(l, &l->planes.emission, c, i);
    out[count++] = here;
  }
  return count;
}

/* The radiance per albedo, summed over the channels, that a receiver would have
 * if nothing stood between it and the lamps. */
static double radiance_from_lamps(const lamp *lamps, size_t count,
                                  const patch *receiver) {
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    const patch *from = &lamps[i].patch;
    double to[3];
    for (size_t c = 0; c < 3; ++c)
      to[c] = from->at[c] - receiver->at[c];
    const double here = look_dot(to, receiver->normal);
    const double there = -look_dot(to, from->normal);
    const double r2 = look_dot(to, to);
    /* the formula is for points; closer than a lamp's size it is limited */
    if (here > 0 && there > 0)
      sum += lamps[i].light * here * there * from->area /
             (pi * r2 * fmax(r2, from->area));
  }
  return sum;
}

/* Adds what the lamps would send without obstacles to surfaces that emit or to
 * those that don't, and how much of it direct light contains. */
static void add_receivers(const look *l, const lamp *lamps, size_t count,
                          bool emitting, hbil_sources *found) {
  for (size_t i = 0; i < l->pixels; i += l->pixels / MOST_RECEIVERS + 1) {
    patch receiver;
    if (emits(l, i) != emitting || !look_patch(l, i, &receiver))
      continue;
    const double expected = radiance_from_lamps(lamps, count, &receiver);
    double direct = 0;
    for (size_t c = 0; c < 3; ++c)
      direct += look_irradiance(l, c, i) / pi;
    found->known.from_lamps[emitting] += expected;
    found->known.contained[emitting] += fmin(direct, expected);
  }
}

static void look_at_lamps(const look *l, hbil_sources *found) {
  lamp lamps[MOST_LAMPS];
  const size_t count = find_lamps(l, lamps);
  if (count > 0) {
    add_receivers(l, lamps, count, false, found);
    add_receivers(l, lamps, count, true, found);
    found->known.lamps += (double)count;
  }
  /* those that emit count where nothing else faces a lamp */
  const bool others = found->known.from_lamps[0] > 0;
  const double all = found->known.from_lamps[others ? 0 : 1];
  const double contained = found->known.contained[others ? 0 : 1];
  found->lamps = !(found->known.lamps > 0) ? HBIL_SOURCE_NOT_SEEN
                 : all > 0 && contained >= LEAST_CONTAINED * all
                     ? HBIL_SOURCE_IN_DIRECT
                     : HBIL_SOURCE_NOT_IN_DIRECT;
}

/* --- what the caller hands in --- */

/* Fills in the defaults of a plane, and checks that it can be read. */
static hbil_status complete(hbil_host_plane *plane, const char *name,
                            size_t width, size_t channels, bool needed) {
  const bool exists =
      needed || look_has(plane) || plane->channel[1] || plane->channel[2];
  for (size_t c = 0; exists && c < channels; ++c)
    if (!plane->channel[c])
      return fail(NULL, HBIL_INVALID_ARGUMENT,
                  "hbil_config_suggest: planes.%s.channel[%zu]: null; %s", name,
                  c, needed ? "this plane is needed" : "the others are there");
  if (plane->pixel_pitch == 0)
    plane->pixel_pitch = sizeof(float);
  /* of a row, up to its last float */
  const size_t least = (width - 1) * plane->pixel_pitch + sizeof(float);
  if (plane->row_pitch == 0)
    plane->row_pitch = width * plane->pixel_pitch;
  if (exists &&
      (plane->row_pitch < least || plane->row_pitch % sizeof(float) != 0 ||
       plane->pixel_pitch % sizeof(float) != 0))
    return fail(NULL, HBIL_INVALID_ARGUMENT,
                "hbil_config_suggest: planes.%s: pixel_pitch %zu, row_pitch "
                "%zu; must be multiples of %zu bytes, and a row has %zu",
                name, plane->pixel_pitch, plane->row_pitch, sizeof(float),
                least);
  return HBIL_SUCCESS;
}

static hbil_status complete_planes(hbil_host_planes *planes, size_t width) {
  hbil_status status = complete(&planes->depth, "depth", width, 1, true);
  if (status == HBIL_SUCCESS)
    status = complete(&planes->normal, "normal", width, 3, false);
  if (status == HBIL_SUCCESS)
    status = complete(&planes->direct, "direct", width, 1, false);
  if (status == HBIL_SUCCESS)
    status = complete(&planes->emission, "emission", width, 1, false);
  return status == HBIL_SUCCESS
             ? complete(&planes->albedo, "albedo", width, 1, false)
             : status;
}

static bool positive(double v) {
  return isfinite(v) && v > 0;
}

static bool has_depth_scale(const hbil_config *config,
                            const hbil_frame *frame) {
  const double *depth = frame->hardware_depth;
  return config->inputs.depth_kind != HBIL_DEPTH_HARDWARE ||
         (isfinite(depth[0]) && positive(fabs(depth[1])));
}

static bool is_size(cl_uint size) {
  return size >= 1 && size <= HBIL_MAX_SIZE;
}

/* Whether the picture can be looked at.  Fills in the defaults of its planes.
 */
static hbil_status check_look(look *l) {
  const hbil_config *config = l->config;
  const hbil_frame *frame = l->frame;
  if (!is_size(config->width) || !is_size(config->height) ||
      (unsigned)config->inputs.depth_kind > HBIL_DEPTH_HARDWARE)
    return fail(NULL, HBIL_INVALID_CONFIG,
                "hbil_config_suggest: width, height, inputs.depth_kind: %u, "
                "%u, %d; must be 1 .. %d pixels and a hbil_depth_kind",
                (unsigned)config->width, (unsigned)config->height,
                (int)config->inputs.depth_kind, HBIL_MAX_SIZE);
  const hbil_status status = complete_planes(&l->planes, config->width);
  if (status != HBIL_SUCCESS)
    return status;
  if (!positive(frame->camera.fx) || !positive(frame->camera.fy))
    return fail(NULL, HBIL_INVALID_FRAME,
                "hbil_config_suggest: camera.fx, camera.fy: %g, %g; must be "
                "above 0",
                frame->camera.fx, frame->camera.fy);
  if (!has_depth_scale(config, frame))
    return fail(NULL, HBIL_INVALID_FRAME,
                "hbil_config_suggest: hardware_depth: A = %g, B = %g; must "
                "be finite, and B not 0",
                frame->hardware_depth[0], frame->hardware_depth[1]);
  return HBIL_SUCCESS;
}

hbil_status hbil_config_suggest(const hbil_host_planes *planes,
                                hbil_config *config, hbil_frame *frame,
                                hbil_sources *sources) {
  hbil_sources alone = {.sky = HBIL_SOURCE_NOT_SEEN};
  hbil_sources *found = sources ? sources : &alone;
  if (!planes || !config || !frame)
    return fail_null(NULL, __func__,
                     !planes   ? "planes"
                     : !config ? "config"
                               : "frame");
  const bool looks = config->model.mode == HBIL_MODE_HBIL;
  if (looks) {
    look l = {*planes, config, frame, (size_t)config->width * config->height};
    const hbil_status status = check_look(&l);
    if (status != HBIL_SUCCESS)
      return status;
    look_at_sky(&l, found, frame->environment[0]);
    look_at_lamps(&l, found);
    surroundings_add(&l, found);
    const float hidden = surroundings_hidden_sky(found);
    if (found->sky != HBIL_SOURCE_NOT_SEEN)
      found->place = HBIL_PLACE_SKY_SEEN;
    frame->sky_share = found->sky == HBIL_SOURCE_NOT_SEEN ? hidden : 0;
  }
  config->model.far_field = !looks ? HBIL_FAR_NONE
                            : found->sky == HBIL_SOURCE_NOT_IN_DIRECT
                                ? HBIL_FAR_CONSTANT
                                : HBIL_FAR_FRAME;
  config->model.gather_emission = found->lamps == HBIL_SOURCE_NOT_IN_DIRECT;
  return HBIL_SUCCESS;
}
