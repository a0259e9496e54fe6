/* How open a place is to a sky that no picture of it shows.
 *
 * Unseen directions end on surfaces in a room and in the sky, or in nothing, in
 * the open.  Three things tell: what lies behind the surfaces, where a picture
 * shows that; what surrounds the eye; and whether light reaches the shadows. */
#include "look.h"

#include <math.h>

/* Of the open directions, so many times the share of the pictures that shows
 * nothing end in nothing.  cornell, with .26, would be best at .3, veach_bidir,
 * with .16, at .6, and four frames of `still` with .48 to .67 at .75 to .9. */
#define NOTHING_FACTOR 1.5
/* In the open, this share of the directions that the screen leaves open ends in
 * the sky.  It was chosen on path-traced scenes, as were the limits below. */
#define SKY_IN_THE_OPEN 0.9

/* Direct light below this share of its typical value is a shadow into which no
 * sky shines. */
#define SHADOW 0.1
/* Where so few of the surfaces are in such shadows, light comes from all sides;
 * with more of them, less so. */
#define SHADOWS_OPEN 0.05
#define SHADOWS_CLOSED 0.09
/* Shares of a picture's surfaces that face up: less ground than this tells
 * nothing of a place, and more is the ground of an open one. */
#define GROUND_NONE 0.2
#define GROUND_OPEN 0.35
/* Shares that face down, which is a ceiling, or a table or a branch. */
#define CEILING_NONE 0.01
#define CEILING_SEEN 0.03
/* Shares of the pairs of surfaces that are upright and face each other: one
 * wall and things in front of it, or the walls of a room.  Things on a ground
 * in the open come to .053. */
#define WALLS_NONE 0.06
#define WALLS_SEEN 0.1

/* Cosines with the vertical: surfaces that face up or down, and upright ones.
 */
#define LEVEL 0.7
#define UPRIGHT 0.5
/* Cosine from which surfaces face each other: planes don't face themselves,
 * whatever the errors of their normals are. */
#define FACING 0.1

/* Surfaces that are taken, on a grid: their pairs take as long as reading the
 * picture once. */
enum { COLUMNS = 24, ROWS = 16, MOST_TAKEN = COLUMNS * ROWS };

/* 0 up to `low`, 1 from `high` on. */
static double ramp(double v, double low, double high) {
  return fmax(0, fmin((v - low) / (high - low), 1));
}

/* --- light in the shadows --- */

/* The mean of direct light over the surfaces of a square of 2 x 2 pixels, which
 * is less noisy than that of a pixel; its three channels added up.  Returns
 * false if the square shows less than two surfaces. */
static bool light_of_square(const look *l, size_t x, size_t y, double *out) {
  size_t count = 0;
  *out = 0;
  for (size_t i = 0; i < 4; ++i) {
    const size_t at = (y + i / 2) * l->config->width + x + i % 2;
    if (look_is_sky(l, at))
      continue;
    ++count;
    for (size_t c = 0; c < 3; ++c)
      *out += look_irradiance(l, c, at);
  }
  if (count)
    *out /= (double)count;
  return count >= 2;
}

/* In the open, the sky shines into nearly every shadow; in rooms, most shadows
 * are black. */
static void add_shadows(const look *l, hbil_sources *found) {
  const size_t width = l->config->width, height = l->config->height;
  double roots = 0, here;
  size_t squares = 0, shadows = 0;
  for (size_t y = 0; y + 1 < height; y += 2)
    for (size_t x = 0; x + 1 < width; x += 2)
      if (light_of_square(l, x, y, &here)) {
        roots += sqrt(here);
        ++squares;
      }
  /* the mean of square roots, squared: lamps nearby must not make shadows */
  const double root = squares ? roots / (double)squares : 0;
  for (size_t y = 0; y + 1 < height; y += 2)
    for (size_t x = 0; x + 1 < width; x += 2)
      shadows +=
          light_of_square(l, x, y, &here) && !(here >= SHADOW * root * root);
  found->known.squares += (double)squares;
  found->known.shadows += roots > 0 ? (double)shadows : (double)squares;
}

/* --- what surrounds the eye --- */

/* The direction up in view space: the axis of the world, to either side, that
 * is the most upright one in the picture and not across it.  Cameras pitch, but
 * hardly roll.  The picture's own, if there is none or no pose. */
static void find_up(const hbil_camera *camera, double out[3]) {
  double best = 0;
  out[0] = out[2] = 0;
  out[1] = -1;
  for (int axis = 0; axis < 3; ++axis)
    for (int sign = -1; sign <= 1; sign += 2) {
      const double *row = camera->world_from_view + 4 * axis;
      const double score = -sign * row[1] - 2 * fabs(row[0]);
      if (!(score > best))
        continue;
      best = score;
      for (int c = 0; c < 3; ++c)
        out[c] = sign * row[c];
    }
}

static size_t take(const look *l, patch out[MOST_TAKEN]) {
  const size_t width = l->config->width, height = l->config->height;
  size_t count = 0;
  for (size_t k = 0; k < MOST_TAKEN; ++k) {
    const size_t x = (2 * (k % COLUMNS) + 1) * width / (2 * COLUMNS);
    const size_t y = (2 * (k / COLUMNS) + 1) * height / (2 * ROWS);
    count += look_patch(l, y * width + x, out + count);
  }
  return count;
}

static bool face_each_other(const patch *a, const patch *b) {
  double to[3];
  for (int c = 0; c < 3; ++c)
    to[c] = b->at[c] - a->at[c];
  const double least = FACING * sqrt(look_dot(to, to));
  return look_dot(to, a->normal) > least && -look_dot(to, b->normal) > least;
}

static void add_surfaces(const look *l, hbil_sources *found) {
  patch taken[MOST_TAKEN];
  const size_t count = take(l, taken);
  double up[3];
  size_t ground = 0, ceiling = 0, upright = 0, pairs = 0;
  find_up(&l->frame->camera, up);
  for (size_t i = 0; i < count; ++i) {
    const double rise = look_dot(taken[i].normal, up);
    const patch here = taken[i];
    ground += rise > LEVEL;
    ceiling += rise < -LEVEL;
    if (!(fabs(rise) < UPRIGHT))
      continue;
    for (size_t k = 0; k < upright; ++k)
      pairs += face_each_other(&here, taken + k);
    taken[upright++] = here; /* at i or before it */
  }
  const double each = count ? 1 / (double)count : 0;
  const double roof = ramp(each * (double)ceiling, CEILING_NONE, CEILING_SEEN);
  const double walls =
      ramp(2 * each * each * (double)pairs, WALLS_NONE, WALLS_SEEN);
  found->known.ground += each * (double)ground;
  found->known.enclosed =
      fmax(found->known.enclosed, 1 - (1 - roof) * (1 - walls));
}

void surroundings_add(const look *l, hbil_sources *found) {
  size_t nothing = 0;
  for (size_t i = 0; i < l->pixels; ++i)
    nothing += look_is_sky(l, i);
  found->known.pictures += 1;
  found->known.nothing += (double)nothing / (double)l->pixels;
  add_shadows(l, found);
  add_surfaces(l, found);
}

float surroundings_hidden_sky(hbil_sources *found) {
  const double each = found->known.pictures > 0 ? 1 / found->known.pictures : 0;
  const double squares = fmax(found->known.squares, 1);
  const double lit =
      1 - ramp(found->known.shadows / squares, SHADOWS_OPEN, SHADOWS_CLOSED);
  const double ground =
      ramp(each * found->known.ground, GROUND_NONE, GROUND_OPEN);
  const double around = 1 - found->known.enclosed;
  const double empty =
      fmin(NOTHING_FACTOR * each * found->known.nothing, SKY_IN_THE_OPEN);
  const double open = SKY_IN_THE_OPEN * lit * ground * around;
  found->place = open > 0 && open >= empty ? HBIL_PLACE_OPEN
                 : empty > 0               ? HBIL_PLACE_EMPTY
                 : !(lit > 0)              ? HBIL_PLACE_DARK
                 : !(around > 0)           ? HBIL_PLACE_ENCLOSED
                                           : HBIL_PLACE_NO_GROUND;
  return (float)fmax(open, empty);
}
