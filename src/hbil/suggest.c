/* Settings that the pixels of a first frame decide: what direct light already
 * contains of the light of the sky and of the lamps in the picture. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "context.h"

/* The sky counts as visible above this share of the pixels. */
#define SKY_SEEN 1e-3
/* Direct light contains the sky's if it reaches this share of the sky's
 * radiance.  Even a small window lets more in. */
#define LEAST_SKY 0.02
/* Direct light contains the lamps' if it reaches this share of what the lamps
 * would send without obstacles.  Half of the surfaces may be in shadow. */
#define LEAST_CONTAINED 0.5

/* Direct light below this share of its typical value is a shadow into which no
 * sky shines. */
#define SHADOW 0.1
/* Where so few of the surfaces are in such shadows, the place is open to a sky
 * that `direct` contains; with more of them, less so, up to a closed room. */
#define SHADOWS_OPEN 0.05
#define SHADOWS_CLOSED 0.09
/* In the open, this share of the directions that the screen leaves open ends in
 * the sky.  These four constants were chosen on path-traced
 * scenes. */
#define SKY_IN_THE_OPEN 0.9f

static const double pi = 3.14159265358979323846;

/* A frame that is looked at. */
typedef struct look {
  hbil_host_planes planes; /* with the defaults of the pitches */
  const hbil_config *config;
  const hbil_frame *frame;
  size_t pixels;
} look;

static bool exists(const hbil_host_plane *plane) {
  return plane->channel[0] != NULL;
}

/* Channel c at pixel i, or the first channel if there is no such one. */
static double value(const look *l, const hbil_host_plane *plane, size_t c,
                    size_t i) {
  const size_t x = i % l->config->width, y = i / l->config->width;
  const float *first = plane->channel[c] ? plane->channel[c] : *plane->channel;
  return (double)first[y * (plane->row_pitch / sizeof *first) +
                       x * (plane->pixel_pitch / sizeof *first)];
}

/* The same of light: 0 if the plane is missing, negative or not finite. */
static double light(const look *l, const hbil_host_plane *plane, size_t c,
                    size_t i) {
  const double v = exists(plane) ? value(l, plane, c, i) : 0;
  return isfinite(v) && v > 0 ? v : 0;
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool is_parallel(const look *l) {
  return l->config->inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
}

/* Planar depth of a value of a depth buffer; 0 at the far end and beyond. */
static double hardware_depth(const look *l, double d) {
  /* d = a + b w, where w is 1/z, or -z in an orthographic view */
  const double a = l->frame->hardware_depth[0];
  const double b = (is_parallel(l) ? -1 : 1) * l->frame->hardware_depth[1];
  const double far = b < 0 ? 1 : 0; /* d of the far end */
  const double w = (d - a) / b;
  return !((d - far) / b > 0) ? 0 : is_parallel(l) ? -w : 1 / w;
}

/* The depth of a surface, along the axis or the ray, or 0 for the sky: as the
 * kernels tell them apart, without their limit of 1e15. */
static double depth_at(const look *l, size_t i) {
  const hbil_inputs *inputs = &l->config->inputs;
  const double stored = value(l, &l->planes.depth, 0, i);
  const double depth = inputs->depth_kind == HBIL_DEPTH_HARDWARE
                           ? hardware_depth(l, stored)
                           : stored * (double)inputs->depth_scale;
  return isfinite(depth) && depth > 0 && depth < (double)inputs->sky_depth
             ? depth
             : 0;
}

static bool is_sky(const look *l, size_t i) {
  return !(depth_at(l, i) > 0);
}

/* --- the sky --- */

/* The radiance of the visible sky: the mean of the square roots, squared, so
 * that the sun's disc counts for little.  0 if too little sky is visible. */
static void sky_radiance(const look *l, float out[3]) {
  double sum[3] = {0};
  size_t sky = 0;
  for (size_t i = 0; i < l->pixels; ++i) {
    double sum_here = 0;
    for (size_t c = 0; c < 3 && is_sky(l, i); ++c) {
      const double v = light(l, &l->planes.emission, c, i);
      sum[c] += sqrt(v);
      sum_here += v;
    }
    sky += sum_here > 0;
  }
  for (size_t c = 0; c < 3; ++c) {
    const double root = sky ? sum[c] / (double)sky : 0;
    out[c] =
        (double)sky > SKY_SEEN * (double)l->pixels ? (float)(root * root) : 0;
  }
}

/* The radiance that direct light gives a white surface. */
static double white_radiance(const look *l, size_t c, size_t i) {
  return light(l, &l->planes.direct, c, i) *
         (double)l->config->inputs.direct_scale / pi;
}

/* Whether direct light reaches LEAST_SKY of the sky's radiance at more than a
 * few pixels. */
static bool contains_sky(const look *l, const float sky[3]) {
  size_t bright = 0;
  for (size_t i = 0; i < l->pixels; ++i)
    for (size_t c = 0; c < 3; ++c)
      if (sky[c] > 0 && white_radiance(l, c, i) > LEAST_SKY * (double)sky[c]) {
        ++bright;
        break;
      }
  return (double)bright > SKY_SEEN * (double)l->pixels;
}

static hbil_source find_sky(const look *l, float radiance[3]) {
  sky_radiance(l, radiance);
  if (!(radiance[0] + radiance[1] + radiance[2] > 0))
    return HBIL_SOURCE_NOT_SEEN;
  return contains_sky(l, radiance) ? HBIL_SOURCE_IN_DIRECT
                                   : HBIL_SOURCE_NOT_IN_DIRECT;
}

/* --- a sky that the picture does not show --- */

/* The mean of direct light over the surfaces of a square of 2 x 2 pixels, which
 * is less noisy than that of a pixel; its three channels added up.  Returns
 * false if the square shows less than two surfaces. */
static bool light_of_square(const look *l, size_t x, size_t y, double *out) {
  size_t count = 0;
  *out = 0;
  for (size_t i = 0; i < 4; ++i) {
    const size_t at = (y + i / 2) * l->config->width + x + i % 2;
    if (is_sky(l, at))
      continue;
    ++count;
    for (size_t c = 0; c < 3; ++c)
      *out += light(l, &l->planes.direct, c, at);
  }
  if (count)
    *out /= (double)count;
  return count >= 2;
}

/* The share of the open directions that end in a sky which lights the surfaces
 * though the picture does not show it.  In the open, the sky shines into nearly
 * every shadow; in rooms, most shadows are black. */
static float hidden_sky_share(const look *l) {
  const size_t width = l->config->width, height = l->config->height;
  double roots = 0, here;
  size_t squares = 0, shadows = 0;
  for (size_t y = 0; y + 1 < height; y += 2)
    for (size_t x = 0; x + 1 < width; x += 2)
      if (light_of_square(l, x, y, &here)) {
        roots += sqrt(here);
        ++squares;
      }
  if (!(roots > 0))
    return 0;
  /* the mean of square roots, squared: lamps nearby must not make shadows */
  const double root = roots / (double)squares;
  for (size_t y = 0; y + 1 < height; y += 2)
    for (size_t x = 0; x + 1 < width; x += 2)
      shadows += light_of_square(l, x, y, &here) && here < SHADOW * root * root;
  const double share = (double)shadows / (double)squares;
  const double open =
      (SHADOWS_CLOSED - share) / (SHADOWS_CLOSED - SHADOWS_OPEN);
  return SKY_IN_THE_OPEN * (float)fmax(0, fmin(open, 1));
}

/* --- lamps --- */

/* A pixel's piece of surface, in view space. */
typedef struct patch {
  double at[3], normal[3], area;
} patch;

/* The point where a pixel looks from, and its ray, whose z is 1. */
static void ray_at(const look *l, size_t i, double from[3], double ray[3]) {
  const hbil_camera *camera = &l->frame->camera;
  const double right =
      ((double)(i % l->config->width) + 0.5 - camera->cx) / camera->fx;
  const double down =
      ((double)(i / l->config->width) + 0.5 - camera->cy) / camera->fy;
  const double at[3] = {right, down, 0}, ahead[3] = {0, 0, 1}, eye[3] = {0};
  const double through[3] = {right, down, 1};
  memcpy(from, is_parallel(l) ? at : eye, sizeof at);
  memcpy(ray, is_parallel(l) ? ahead : through, sizeof at);
}

/* Planar depth; 0 for the sky. */
static double z_at(const look *l, size_t i) {
  double from[3], ray[3];
  const double depth = depth_at(l, i);
  ray_at(l, i, from, ray);
  return l->config->inputs.depth_kind == HBIL_DEPTH_RAY
             ? depth / sqrt(dot(ray, ray))
             : depth;
}

/* 1/z, or -z in an orthographic view: affine in pixel coordinates on planes. */
static double w_at(const look *l, size_t i) {
  const double z = z_at(l, i);
  return is_parallel(l) ? -z : 1 / z;
}

/* The smaller difference of w to the neighbours before and behind; 0 if there
 * is none.  The kernels choose with more care (normals_from_depth.cl). */
static double gradient(const look *l, size_t i, size_t step, bool before,
                       bool behind) {
  double least = INFINITY;
  if (before && z_at(l, i - step) > 0)
    least = w_at(l, i) - w_at(l, i - step);
  if (behind && z_at(l, i + step) > 0) {
    const double other = w_at(l, i + step) - w_at(l, i);
    least = fabs(other) < fabs(least) ? other : least;
  }
  return isfinite(least) ? least : 0;
}

/* The normal of a pixel's surface by its depth, of any length. */
static void rebuild_normal(const look *l, size_t i, const double ray[3],
                           double out[3]) {
  const size_t width = l->config->width, x = i % width, y = i / width;
  const hbil_camera *camera = &l->frame->camera;
  out[0] = -camera->fx * gradient(l, i, 1, x > 0, x + 1 < width);
  out[1] =
      -camera->fy * gradient(l, i, width, y > 0, y + 1 < l->config->height);
  out[2] =
      is_parallel(l) ? -1 : -w_at(l, i) - out[0] * ray[0] - out[1] * ray[1];
}

/* The pixel's unit normal in view space, facing the eye.  Returns false if it
 * has none. */
static bool read_normal(const look *l, size_t i, const double ray[3],
                        double out[3]) {
  double n[3];
  for (size_t c = 0; c < 3 && exists(&l->planes.normal); ++c)
    n[c] = value(l, &l->planes.normal, c, i) *
           (double)l->config->inputs.normal_scale[c];
  for (size_t c = 0; c < 3 && exists(&l->planes.normal); ++c) {
    const double *m = l->frame->camera.world_from_view + c;
    out[c] = l->config->inputs.normal_space == HBIL_SPACE_VIEW
                 ? n[c]
                 : m[0] * n[0] + m[4] * n[1] + m[8] * n[2];
  }
  if (!exists(&l->planes.normal))
    rebuild_normal(l, i, ray, out);
  const double length = sqrt(dot(out, out));
  const double sign = dot(out, ray) > 0 ? -1 : 1;
  for (size_t c = 0; c < 3; ++c)
    out[c] *= sign / length;
  return length > 0 && isfinite(length);
}

/* Returns false if the pixel shows no surface. */
static bool read_patch(const look *l, size_t i, patch *out) {
  const hbil_camera *camera = &l->frame->camera;
  const bool parallel = is_parallel(l);
  const double z = z_at(l, i);
  double from[3], ray[3];
  ray_at(l, i, from, ray);
  if (!(z > 0) || !read_normal(l, i, ray, out->normal))
    return false;
  /* A pixel has the solid angle 1 / (fx fy |r|^3); with parallel rays, all
   * pixels have the same area.  A grazing surface may be of any size; it counts
   * as if it were tilted by a tenth of a radian. */
  const double grazing = 0.1 * sqrt(dot(ray, ray));
  out->area = (parallel ? 1 : z * z) /
              (camera->fx * camera->fy * fmax(-dot(out->normal, ray), grazing));
  for (size_t c = 0; c < 3; ++c)
    out->at[c] = from[c] + z * ray[c];
  return true;
}

/* Whether a surface emits light, as the sum of its channels tells. */
static bool emits(const look *l, size_t i) {
  const hbil_host_plane *emission = &l->planes.emission;
  double sum = 0;
  for (size_t c = 0; c < 3 && exists(emission); ++c)
    sum += value(l, emission, c, i);
  return isfinite(sum) && sum > 0 && !is_sky(l, i);
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
    if (!emits(l, i) || seen++ % every || !read_patch(l, i, &here.patch))
      continue;
    here.patch.area *= (double)every;
    for (size_t c = 0; c < 3; ++c)
      here.light += light(l, &l->planes.emission, c, i);
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
    const double here = dot(to, receiver->normal);
    const double there = -dot(to, from->normal);
    const double r2 = dot(to, to);
    /* the formula is for points; closer than a lamp's size it is limited */
    if (here > 0 && there > 0)
      sum += lamps[i].light * here * there * from->area /
             (pi * r2 * fmax(r2, from->area));
  }
  return sum;
}

/* The share of the lamps' light that direct light contains, at surfaces that
 * emit or at those that don't; negative if no such surface faces a lamp. */
static double explained(const look *l, const lamp *lamps, size_t count,
                        bool emitting) {
  double all = 0, contained = 0;
  for (size_t i = 0; i < l->pixels; i += l->pixels / MOST_RECEIVERS + 1) {
    patch receiver;
    if (emits(l, i) != emitting || !read_patch(l, i, &receiver))
      continue;
    const double expected = radiance_from_lamps(lamps, count, &receiver);
    double direct = 0;
    for (size_t c = 0; c < 3; ++c)
      direct += white_radiance(l, c, i);
    all += expected;
    contained += fmin(direct, expected);
  }
  return all > 0 ? contained / all : -1;
}

static hbil_source look_at_lamps(const look *l) {
  lamp lamps[MOST_LAMPS];
  const size_t count = find_lamps(l, lamps);
  if (count == 0)
    return HBIL_SOURCE_NOT_SEEN;
  double share = explained(l, lamps, count, false);
  if (share < 0)
    share = explained(l, lamps, count, true);
  return share >= LEAST_CONTAINED ? HBIL_SOURCE_IN_DIRECT
                                  : HBIL_SOURCE_NOT_IN_DIRECT;
}

/* --- what the caller hands in --- */

/* Fills in the defaults of a plane.  Returns false if it can't be read. */
static bool complete(hbil_host_plane *plane, size_t width, size_t channels,
                     bool needed) {
  if (!exists(plane))
    return !needed && !plane->channel[1] && !plane->channel[2];
  for (size_t c = 1; c < channels; ++c)
    if (!plane->channel[c])
      return false;
  if (plane->pixel_pitch == 0)
    plane->pixel_pitch = sizeof(float);
  /* of a row, up to its last float */
  const size_t least = (width - 1) * plane->pixel_pitch + sizeof(float);
  if (plane->row_pitch == 0)
    plane->row_pitch = width * plane->pixel_pitch;
  return plane->row_pitch >= least && plane->row_pitch % sizeof(float) == 0 &&
         plane->pixel_pitch % sizeof(float) == 0;
}

/* Returns the name of a plane that can't be read, or NULL. */
static const char *complete_planes(hbil_host_planes *planes, size_t width) {
  return !complete(&planes->depth, width, 1, true)       ? "depth"
         : !complete(&planes->normal, width, 3, false)   ? "normal"
         : !complete(&planes->direct, width, 1, false)   ? "direct"
         : !complete(&planes->emission, width, 1, false) ? "emission"
                                                         : NULL;
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

hbil_status hbil_config_suggest(const hbil_host_planes *planes,
                                hbil_config *config, hbil_frame *frame,
                                hbil_sources *sources) {
  hbil_sources found = {HBIL_SOURCE_NOT_SEEN, HBIL_SOURCE_NOT_SEEN};
  float sky[3] = {0};
  if (!planes || !config || !frame)
    return fail_null(NULL, __func__,
                     !planes   ? "planes"
                     : !config ? "config"
                               : "frame");
  const bool looks = config->model.mode == HBIL_MODE_HBIL;
  if (looks) {
    look l = {*planes, config, frame, (size_t)config->width * config->height};
    if (!is_size(config->width) || !is_size(config->height) ||
        (unsigned)config->inputs.depth_kind > HBIL_DEPTH_HARDWARE)
      return fail(NULL, HBIL_INVALID_CONFIG,
                  "hbil_config_suggest: width, height, inputs.depth_kind: %u, "
                  "%u, %d; must be 1 .. %d pixels and a hbil_depth_kind",
                  (unsigned)config->width, (unsigned)config->height,
                  (int)config->inputs.depth_kind, HBIL_MAX_SIZE);
    const char *wrong = complete_planes(&l.planes, config->width);
    if (wrong)
      return fail(NULL, HBIL_INVALID_ARGUMENT,
                  "hbil_config_suggest: planes.%s: a channel is missing, or "
                  "row_pitch is not a multiple of 4 bytes or less than a row",
                  wrong);
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
    found.sky = find_sky(&l, sky);
    found.lamps = look_at_lamps(&l);
    memcpy(frame->environment[0], sky, sizeof sky);
    frame->sky_share =
        found.sky == HBIL_SOURCE_NOT_SEEN ? hidden_sky_share(&l) : 0;
  }
  config->model.far_field = !looks ? HBIL_FAR_NONE
                            : found.sky == HBIL_SOURCE_NOT_IN_DIRECT
                                ? HBIL_FAR_CONSTANT
                                : HBIL_FAR_FRAME;
  config->model.gather_emission = found.lamps == HBIL_SOURCE_NOT_IN_DIRECT;
  if (sources)
    *sources = found;
  return HBIL_SUCCESS;
}
