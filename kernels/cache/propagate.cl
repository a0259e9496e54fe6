/*
 * propagate: one step of light from cell to cell (lib/volumes.clh).
 *
 * A cell gets light from its six neighbours, through its five other faces each:
 * the intensity towards the face's middle, times the solid angle of the face as
 * the neighbour's middle sees it, is the flux, which goes on from the cell's
 * own middle as if it came from a point there that faces that face.  Surfaces
 * stop light that leaves their own cell: they may be anywhere in it, and light
 * that has come as far as the cell is at them.  They also hide what comes from
 * behind them: what a surface sends (volumes.cl) takes the place of as much of
 * the light of the neighbour there, so the two are never brighter than the
 * brighter one.
 *
 * A step adds what surfaces send, so the volumes come to rest at all light that
 * has spread since, and follow changes from any earlier state.
 *
 * propagate: Launch: x = vectors of cells, y = cells, z = cells of all levels.
 * volume_border: the cells around a volume: those of the next coarser level
 * there, or the environment's light.  Launch: x, y = cells of a face, with
 * those around; z = faces of all levels.
 */
#include "lib/sky_radiance.clh"
#include "lib/volumes.clh"

/* The direction to the middle of a side face: (1, 1/2), to unit length. */
#define FORWARD 0.894427191f
#define ASIDE 0.447213595f

/* The intensity of one colour: mean and slope. */
typedef struct intensity {
  realv mean, slope[3];
} intensity;

/* The flux that goes through the far face, and through the side face towards
 * +-j, of the neighbour in the direction of sign on axis i. */
INLINE realv front_flux(const intensity *v, int i, float sign) {
  return FRONT_FACE * max(fma((realv)sign, v->slope[i], v->mean), (realv)0.0f);
}
INLINE realv side_flux(const intensity *v, int i, float sign, int j,
                       float side) {
  const realv f = fma((realv)(FORWARD * sign), v->slope[i],
                      fma((realv)(ASIDE * side), v->slope[j], v->mean));
  return SIDE_FACE * max(f, (realv)0.0f);
}

/* Of the order-1 intensity only what is positive goes on.  This factor makes it
 * the flux of the cell again, 4 pi times the mean. */
INLINE realv flux_factor(const intensity *v) {
  realv sum = 0.0f;
#pragma unroll
  for (int i = 0; i < 3; ++i)
#pragma unroll
    for (int s = 0; s < 2; ++s) {
      const float sign = s ? -1.0f : 1.0f;
      sum += front_flux(v, i, sign);
#pragma unroll
      for (int j = 1; j < 3; ++j)
        sum += side_flux(v, i, sign, (i + j) % 3, 1.0f) +
               side_flux(v, i, sign, (i + j) % 3, -1.0f);
    }
  return select((realv)0.0f, 12.5663706f * v->mean / sum, sum > 0.0f);
}

/* Adds what comes from the neighbour against the direction of sign on axis i;
 * `open`: the share that gets in. */
INLINE void add_neighbour(global const float *from, uint plane, int i,
                          float sign, realv open, intensity *to) {
  const intensity v = {
      LOADV(from),
      {LOADV(from + plane), LOADV(from + 2 * plane), LOADV(from + 3 * plane)}};
  const realv scale = open * LOADV(from + VOLUME_FACTOR * plane);
  const realv front = scale * front_flux(&v, i, sign);
  realv total = front;
  to->slope[i] += sign * front;
#pragma unroll
  for (int k = 1; k < 3; ++k) {
    const int j = (i + k) % 3;
    const realv up = scale * side_flux(&v, i, sign, j, 1.0f);
    const realv down = scale * side_flux(&v, i, sign, j, -1.0f);
    total += up + down;
    to->slope[j] += up - down;
  }
  to->mean += total;
}

INLINE void store_lanes(realv v, global float *to, int count) {
  if (count >= HBIL_WIDTH) {
    STOREV(v, to);
    return;
  }
  float lane[HBIL_WIDTH];
  STOREV(v, lane);
  for (int i = 0; i < count; ++i)
    to[i] = lane[i];
}

INLINE void store_intensity(const intensity *v, uint plane, global float *to,
                            int count) {
  store_lanes(v->mean, to, count);
#pragma unroll
  for (int i = 0; i < 3; ++i)
    store_lanes(v->slope[i], to + (1 + i) * plane, count);
  store_lanes(flux_factor(v), to + VOLUME_FACTOR * plane, count);
}

kernel void propagate(const hbil_cache_args cache, global const float *sources,
                      global const float *opacities, global const float *before,
                      global float *after) {
  const int across = cache.voxels / 2;
  const int x = (int)get_global_id(0) * HBIL_WIDTH, y = (int)get_global_id(1);
  int z;
  const int level = level_of_item(cache, &z);
  if (x >= across || y >= across || level >= cache.levels)
    return;
  const uint plane = volume_plane(cache);
  const int row = volume_across(cache);
  const int apart[3] = {1, row, row * row};
  const int count = min(across - x, HBIL_WIDTH);
  global const float *source =
      sources + cell_address(cache, 12u, level, x, y, z);
  global const float *opacity =
      opacities + cell_address(cache, 6u, level, x, y, z);
  const uint cell = cell_address(cache, VOLUME_PLANES, level, x, y, z);
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    const uint colour = (uint)c * VOLUME_COLOUR * plane;
    global const float *from = before + cell + colour;
    intensity got = {0.0f, {0.0f, 0.0f, 0.0f}};
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      const realv up = 1.0f - LOADV(opacity - apart[i] + (2 * i) * plane);
      const realv down = 1.0f - LOADV(opacity + apart[i] + (2 * i + 1) * plane);
      add_neighbour(from - apart[i], plane, i, 1.0f,
                    up * (1.0f - LOADV(opacity + (2 * i + 1) * plane)), &got);
      add_neighbour(from + apart[i], plane, i, -1.0f,
                    down * (1.0f - LOADV(opacity + (2 * i) * plane)), &got);
    }
    /* Phi/pi (1/4 + 1/2 n.w) of each face */
    const intensity v = {
        fma((realv)0.0795774715f, got.mean, LOADV(source + (4 * c) * plane)),
        {fma((realv)0.159154943f, got.slope[0],
             LOADV(source + (4 * c + 1) * plane)),
         fma((realv)0.159154943f, got.slope[1],
             LOADV(source + (4 * c + 2) * plane)),
         fma((realv)0.159154943f, got.slope[2],
             LOADV(source + (4 * c + 3) * plane))}};
    store_intensity(&v, plane, after + cell + colour, count);
  }
}

/* --- what is around the volumes ------------------------------------------- */

/* The environment's light of one colour, which has the same radiance L(d) from
 * each direction d everywhere: 3/2 s^2 L(-w), s being a cell's width. */
INLINE void store_sky(const hbil_sh_args sky, float size, uint plane,
                      global float *to) {
  const float scale = 1.5f * size * size;
  const float value[4] = {scale * max(sky.sh[0], 0.0f), -scale * sky.sh[3],
                          -scale * sky.sh[1], -scale * sky.sh[2]};
  const intensity v = {value[0], {value[1], value[2], value[3]}};
  float factor[HBIL_WIDTH];
  STOREV(flux_factor(&v), factor);
#pragma unroll
  for (int k = 0; k < 4; ++k)
    to[(uint)k * plane] = value[k];
  to[VOLUME_FACTOR * plane] = factor[0];
}

kernel void volume_border(const hbil_cache_args cache,
                          const hbil_environment_args environment,
                          global float *volumes) {
  const int across = cache.voxels / 2;
  const int u = (int)get_global_id(0) - 1, v = (int)get_global_id(1) - 1;
  const int face = (int)get_global_id(2) % 6;
  const int level = (int)get_global_id(2) / 6;
  if (u > across || v > across || level >= cache.levels)
    return;
  const int end = face & 1 ? across : -1, axis = face / 2;
  const int x = axis == 0 ? end : u;
  const int y = axis == 1 ? end : axis == 0 ? u : v;
  const int z = axis == 2 ? end : v;
  const uint plane = volume_plane(cache);
  global float *cell =
      volumes + cell_address(cache, VOLUME_PLANES, level, x, y, z);
  if (level + 1 == cache.levels) {
    /* not indexed as an argument: see rotate_direction() */
    const hbil_sh_args sky[3] = {environment.channel[0], environment.channel[1],
                                 environment.channel[2]};
#pragma unroll
    for (int c = 0; c < 3; ++c)
      store_sky(sky[c], (float)(2 << level), plane,
                cell + (uint)c * VOLUME_COLOUR * plane);
    return;
  }
  /* a cell of the coarser level is twice as wide, so it passes four times the
   * flux; (i + 1/2 - across/2) / 2 + across/2, rounded down */
  const int shift = across / 2;
  global const float *coarser =
      volumes + cell_address(cache, VOLUME_PLANES, level + 1, (x + shift) >> 1,
                             (y + shift) >> 1, (z + shift) >> 1);
#pragma unroll
  for (int k = 0; k < VOLUME_PLANES; ++k)
    cell[(uint)k * plane] =
        (k % VOLUME_COLOUR == VOLUME_FACTOR ? 1.0f : 0.25f) *
        coarser[(uint)k * plane];
}
