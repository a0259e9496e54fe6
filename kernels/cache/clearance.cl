/*
 * clearance: a byte for each voxel that lets rays skip empty space.  It holds
 * the voxel's state and how far around it all voxels have that state
 * (lib/cache_args.h), so a ray reads one byte a step and crosses what is all
 * alike in one step.
 *
 * resolve_states: the states.  What a level has not seen gets the state of the
 * next coarser level there.  Levels are done one after the other, the coarsest
 * one first.
 * clearance_along_x, clearance_along: the clearances.  The first finds how far
 * a voxel's row has its state, to both sides.  The second does the same along
 * y, then along z: r is allowed if all voxels up to r away along the axis have
 * the same state, and r or more as their own result so far.  This gives
 * squares, then cubes.  Neighbours are those in memory, which wraps around, so
 * at the border of a level a cube may be too small because of the opposite
 * side.  It is never too large, because rays stop at the border.
 *
 * Launch: resolve_states: x = words of a row of voxels, y = rows, z = slices,
 * of one level; clearance_along_x, clearance_along: x = rows, y = slices of all
 * levels.
 */
#include "lib/cache_voxels.clh"

/* The states of a word's voxels, a byte each. */
INLINE uchar16 states_of_word(uint word) {
  const uint16 shift =
      (uint16)(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  return convert_uchar16(((uint16)(word) >> shift) & 3u);
}

kernel void resolve_states(const hbil_cache_args cache, const int level,
                           global const uint *states, global uchar *clearance) {
  const uint x = (uint)get_global_id(0), y = (uint)get_global_id(1);
  const uint z = (uint)get_global_id(2), n = (uint)cache.voxels;
  if (x >= n / WORD_VOXELS || y >= n || z >= n)
    return;
  const uint word =
      ((((((uint)level << cache.log2_voxels | z) << cache.log2_voxels) | y)
        << cache.log2_voxels) >>
       4) |
      x;
  const uint own = states[word];
  const uint unknown = ~(own | (own >> 1)) & 0x55555555u;
  global uchar *codes = clearance + WORD_VOXELS * word;
  vstore16(states_of_word(own), 0, codes);
  if (!unknown || level + 1 == cache.levels)
    return;
  const int up_y = cell_at(cache, level, 1, (int)y) >> 1;
  const int up_z = cell_at(cache, level, 2, (int)z) >> 1;
  /* neighbours share the coarser voxel, as levels move by whole ones */
  for (uint i = 0; i < WORD_VOXELS; i += 2) {
    const uint pair = unknown >> (2u * i);
    if (!(pair & 5u))
      continue;
    const int up_x = cell_at(cache, level, 0, (int)(x * WORD_VOXELS + i)) >> 1;
    uint code =
        clearance[(uint)voxel_number(cache, level + 1, up_x, up_y, up_z)];
    if (CODE_STATE(code) == HBIL_VOXEL_SURFACE)
      code += 1u << 2; /* a level more above */
    if (pair & 1u)
      codes[i] = (uchar)code;
    if (pair & 4u)
      codes[i + 1] = (uchar)code;
  }
}

/* --- clearance --- */

INLINE char16 is_same_state(uchar16 a, uchar16 b) {
  return ((a ^ b) & (uchar)3) == (uchar)0;
}

INLINE char16 is_no_surface(uchar16 codes) {
  return (codes & (uchar)3) != (uchar)HBIL_VOXEL_SURFACE;
}

/* The first voxel of a work-item's row of a level.  false: there is none. */
INLINE bool row_of_item(const hbil_cache_args c, uint *first) {
  const uint y = (uint)get_global_id(0), z = (uint)get_global_id(1);
  *first = ((z << c.log2_voxels) | y) << c.log2_voxels;
  return y < (uint)c.voxels && z < (uint)(c.voxels * c.levels);
}

kernel void clearance_along_x(const hbil_cache_args cache,
                              global const uchar *in, global uchar *out) {
  uint row;
  if (!row_of_item(cache, &row))
    return;
  const int words = cache.voxels / WORD_VOXELS;
  /* the row, and a word more at both ends */
  uchar around[HBIL_CACHE_MOST_VOXELS + 2 * WORD_VOXELS];
  for (int i = 0; i < words + 2; ++i)
    vstore16(vload16((i + words - 1) & (words - 1), in + row), i, around);
  for (int i = 1; i <= words; ++i) {
    const uchar *at = around + WORD_VOXELS * i;
    const uchar16 own = vload16(0, at);
    uchar16 clearances = 0;
    char16 alike = is_no_surface(own);
    for (int r = 1; r <= HBIL_MOST_CLEARANCE && any(alike); ++r) {
      alike &= is_same_state(own, vload16(0, at - r)) &
               is_same_state(own, vload16(0, at + r));
      clearances += as_uchar16(alike) & (uchar)1;
    }
    vstore16(own | (clearances << (uchar)2), i - 1, out + row);
  }
}

/* Along y (shift = log2_voxels) or z (twice that). */
kernel void clearance_along(const hbil_cache_args cache, const int shift,
                            global const uchar *in, global uchar *out) {
  uint row;
  if (!row_of_item(cache, &row))
    return;
  const uint mask = (uint)cache.voxels - 1u, place = (row >> shift) & mask;
  for (uint i = row; i < row + (uint)cache.voxels; i += WORD_VOXELS) {
    global const uchar *axis = in + (i - (place << shift));
    const uchar16 own = vload16(0, in + i);
    uchar16 least = own >> (uchar)2, clearances = 0;
    char16 alike = is_no_surface(own);
    for (uint r = 1; r <= HBIL_MOST_CLEARANCE && any(alike); ++r) {
      const uchar16 before = vload16(0, axis + (((place - r) & mask) << shift));
      const uchar16 after = vload16(0, axis + (((place + r) & mask) << shift));
      least = min(least, min(before >> (uchar)2, after >> (uchar)2));
      alike &= is_same_state(own, before) & is_same_state(own, after) &
               (least >= (uchar)r);
      clearances += as_uchar16(alike) & (uchar)1;
    }
    const uchar16 codes = (own & (uchar)3) | (clearances << (uchar)2);
    vstore16(select(codes, own, !is_no_surface(own)), 0, out + i);
  }
}
