/*
 * inject: what a view tells of each voxel.
 *
 * Every voxel looks at itself in the view (a pull: no atomics, and the same
 * bits in any order of work-items).  If the view shows surfaces in the voxel,
 * their means join the voxel's; light that has changed replaces its light.  If
 * the view shows only what is behind it, the voxel is empty.  A voxel that
 * holds a surface is empty only if the view looks through that surface and all
 * around it.  If something is in front of it, nothing is learnt.  Where a
 * view shows a plane beside the voxel alone, because it is hidden in the voxel,
 * other light is no change: a floor that goes on behind a wall may have other
 * light there.
 *
 * Launch: x = words of a row of voxels, y = rows, z = slices, of all levels.
 * In: texels (cache/view.cl).  In and out: states, voxels.  Out: what new
 * surfaces send, before any bounce.
 */
#include "lib/cache_voxels.clh"
#include "lib/camera.clh"

/* --- a voxel in the view -------------------------------------------------- */

/* The texels around a voxel's place in the view, and what they have shown. */
typedef struct shown {
  float surfaces;
  bool in_sight; /* any of them */
  int taps, behind, sky;
  float3 normal, reflectance, sent;
  float3 last; /* normal */
  float offset;
} shown;

INLINE float3 reflectance_of(uint word) {
  return (float3)((float)(word & 1023u), (float)((word >> 10) & 1023u),
                  (float)((word >> 20) & 1023u)) *
         (1.0f / 1023.0f);
}

/* The point that a texel of depth z shows. */
INLINE float3 shown_point(const hbil_cache_inject_args args, int x, int y,
                          float z) {
  const float spread = ORTHOGRAPHIC ? 1.0f : z;
  return transformed(
      args.to_cache,
      (float3)(((float)x + 0.5f - args.view.cx) * args.view.inv_fx * spread,
               ((float)y + 0.5f - args.view.cy) * args.view.inv_fy * spread,
               z));
}

/* Whether the plane of normal n through a point crosses a voxel; to: the point,
 * from the voxel's centre. */
INLINE bool crosses(float3 n, float3 to, float size) {
  const float3 lean = fabs(n);
  return fabs(dot(n, to)) <= 0.5f * size * (lean.x + lean.y + lean.z);
}

/* The texel of a point, and its depth.  false: it has no place in the view. */
INLINE bool texel_of(const hbil_cache_inject_args args, float3 p, float size,
                     int *x, int *y, float *depth) {
  const hbil_view_args view = args.view;
  const float3 q = transformed(args.to_view, p);
  const float shrink = ORTHOGRAPHIC ? 1.0f : 1.0f / q.z;
  const float px = fma(view.fx * q.x, shrink, view.cx);
  const float py = fma(view.fy * q.y, shrink, view.cy);
  *x = (int)px;
  *y = (int)py;
  *depth = q.z;
  return (ORTHOGRAPHIC || q.z > 0.3f * size) && px >= 0.0f && py >= 0.0f &&
         px < (float)view.width && py < (float)view.height;
}

/* Whether the view has nothing in front of a place of a surface in a voxel but
 * planes that cross the voxel, too. */
INLINE bool is_in_sight(const hbil_cache_inject_args args,
                        global const uint *texels, float3 p, float3 centre,
                        float size) {
  int x, y;
  float depth;
  if (!texel_of(args, p, size, &x, &y, &depth))
    return true;
  const uint4 texel =
      vload4((size_t)y * (size_t)args.view.width + (size_t)x, texels);
  const float z = as_float(texel.x);
  return !(z > 0.0f) || z >= depth ||
         crosses(normal_of_word(texel.y), shown_point(args, x, y, z) - centre,
                 size);
}

/* A surface is in the voxel if its point is less than a voxel from the centre
 * along each axis, and its plane crosses the voxel. */
INLINE void look(const hbil_cache_inject_args args, global const uint *texels,
                 int x, int y, float3 centre, float depth, float size,
                 shown *s) {
  const uint4 texel =
      vload4((size_t)y * (size_t)args.view.width + (size_t)x, texels);
  const float z = as_float(texel.x);
  ++s->taps;
  if (!(z > 0.0f)) {
    ++s->behind;
    ++s->sky;
    return;
  }
  const float3 to = shown_point(args, x, y, z) - centre, off = fabs(to);
  if (max(off.x, max(off.y, off.z)) <= size) {
    const float3 n = normal_of_word(texel.y);
    const float along = dot(n, to);
    if (crosses(n, to, size)) {
      s->in_sight = s->in_sight ||
                    max(off.x, max(off.y, off.z)) <= HBIL_CACHE_INSIDE * size ||
                    is_in_sight(args, texels, centre + n * along, centre, size);
      s->surfaces += 1.0f;
      s->normal += n;
      s->last = n;
      s->offset += along;
      s->reflectance += reflectance_of(texel.z);
      s->sent += light_of_word(texel.w);
      return;
    }
  }
  s->behind += z > depth;
}

INLINE float3 joined(float3 mean, float3 value, float share) {
  return fma(value - mean, (float3)(share), mean);
}

INLINE float largest(float3 v) {
  return max(max(v.x, v.y), v.z);
}

/* HBIL_VOXEL_BEFORE with one more view.  held: the voxel's light. */
INLINE float with_view(float before, bool is_like, float3 held) {
  const float light = held.x + held.y + held.z;
  const uint views = as_uint(before) & HBIL_VOXEL_MOMENT_VIEWS;
  if (!is_like || before < 0.0f)
    return -1.0f;
  if (before > 0.0f) /* the first view knew what was before */
    return views < HBIL_VOXEL_MOMENT_VIEWS ? as_float(as_uint(before) + 1u)
                                           : before;
  return light >= HBIL_VOXEL_LEAST_LIGHT
             ? as_float((as_uint(light) & ~HBIL_VOXEL_MOMENT_VIEWS) | 1u)
             : -1.0f;
}

INLINE bool is_other_light(float3 held, float3 seen) {
  return largest(fabs(held - seen)) >
         HBIL_CACHE_LIGHT_CHANGED * max(largest(held), largest(seen));
}

/* Joins the means of a view to those of the voxel. */
INLINE void add_surface(global float *voxel, bool is_new, int finished,
                        const shown *s) {
  float4 plane = 0.0f, surface = 0.0f, light = 0.0f;
  float before = 0.0f;
  if (!is_new) {
    before = voxel[HBIL_VOXEL_BEFORE];
    plane = vload4(0, voxel + HBIL_VOXEL_NORMAL);
    surface = vload4(0, voxel + HBIL_VOXEL_REFLECTANCE);
    light = vload4(0, voxel + HBIL_VOXEL_SENT);
  } else
    vstore4((float4)(0.0f), 0, voxel + HBIL_VOXEL_INDIRECT);
  const float inv = 1.0f / s->surfaces;
  const float3 sent = s->sent * inv;
  const float views = min(surface.w + 1.0f, HBIL_CACHE_MOST_VIEWS);
  const float share = 1.0f / views;
  plane.xyz = joined(plane.xyz, s->normal * inv, share);
  plane.w = fma(fma(s->offset, inv, -plane.w), share, plane.w);
  /* opposite sides of a sheet leave no normal: the newest counts */
  if (dot(plane.xyz, plane.xyz) < 1e-4f)
    plane = (float4)(s->last, s->offset * inv);
  vstore4(plane, 0, voxel + HBIL_VOXEL_NORMAL);
  vstore4((float4)(joined(surface.xyz, s->reflectance * inv, share), views), 0,
          voxel + HBIL_VOXEL_REFLECTANCE);
  const bool like =
      s->in_sight && (finished ? light.w <= -1.0f : light.w >= 1.0f);
  voxel[HBIL_VOXEL_BEFORE] = with_view(before, like, light.xyz);
  /* finished radiance replaces light of the first bounce, never the other way
   * round */
  if (light.w < 0.0f && !finished)
    return;
  const bool anew =
      (finished && light.w > 0.0f) || is_other_light(light.xyz, sent);
  const float count =
      anew ? 1.0f : min(fabs(light.w) + 1.0f, HBIL_CACHE_MOST_VIEWS);
  const float weight =
      !s->in_sight && fabs(light.w) < 1.0f ? HBIL_CACHE_NOT_IN_SIGHT : count;
  vstore4((float4)(joined(light.xyz, sent, 1.0f / count),
                   finished ? -weight : weight),
          0, voxel + HBIL_VOXEL_SENT);
}

/* Whether the view looks through the surface that a voxel holds: the texels
 * around its point, `around` each way, all show what is more than a voxel
 * behind it, and off its plane by as much (which a floor seen at a grazing
 * angle is not).  All of them: a thing that is thinner than the voxel must not
 * be overlooked.  *sky: they show the sky. */
INLINE bool looks_through(const hbil_cache_inject_args args,
                          global const uint *texels, global const float *voxel,
                          float3 centre, float size, int around, bool *sky) {
  const hbil_view_args view = args.view;
  const float4 plane = vload4(0, voxel + HBIL_VOXEL_NORMAL);
  const float3 n = plane.xyz * (1.0f / sqrt(dot(plane.xyz, plane.xyz)));
  const float3 p = centre + n * plane.w;
  int column, row;
  float depth;
  if (!texel_of(args, p, size, &column, &row, &depth))
    return false;
  *sky = true;
  for (int y = max(row - around, 0); y <= min(row + around, view.height - 1);
       ++y)
    for (int x = max(column - around, 0);
         x <= min(column + around, view.width - 1); ++x) {
      const float z =
          as_float(texels[HBIL_TEXEL_WORDS *
                          ((size_t)y * (size_t)view.width + (size_t)x)]);
      if (!(z > 0.0f))
        continue;
      *sky = false;
      if (!(z > depth + size) ||
          fabs(dot(n, shown_point(args, x, y, z) - p)) < size)
        return false;
    }
  return true;
}

/* Looks at a voxel whose centre is at (px, py) in the view.  Returns its new
 * state. */
INLINE uint inject_voxel(const hbil_cache_inject_args args,
                         global const uint *texels, global float *voxel,
                         uint state, float3 centre, float size, float px,
                         float py, float depth) {
  const hbil_view_args view = args.view;
  const int x = (int)px, y = (int)py;
  const int reach =
      (int)min(0.5f * view.fx * size * (ORTHOGRAPHIC ? 1.0f : 1.0f / depth),
               (float)HBIL_CACHE_FOOTPRINT);
  const int step = max(reach, 1), most = reach > 0;
  shown s = {
      0.0f,           false,          0,   0, 0, (float3)(0.0f), (float3)(0.0f),
      (float3)(0.0f), (float3)(0.0f), 0.0f};
  for (int j = -most; j <= most; ++j)
    for (int i = -most; i <= most; ++i) {
      const int tx = x + i * step, ty = y + j * step;
      if (tx >= 0 && ty >= 0 && tx < view.width && ty < view.height)
        look(args, texels, tx, ty, centre, depth, size, &s);
    }
  if (s.surfaces > 0.0f) {
    add_surface(voxel, state != HBIL_VOXEL_SURFACE, args.finished, &s);
    return HBIL_VOXEL_SURFACE;
  }
  if (state == HBIL_VOXEL_SURFACE) {
    bool sky;
    return !looks_through(args, texels, voxel, centre, size, step, &sky) ? state
           : sky ? HBIL_VOXEL_SKY
                 : HBIL_VOXEL_EMPTY;
  }
  if (s.behind < s.taps)
    return state;
  return s.sky == s.taps               ? HBIL_VOXEL_SKY
         : state == HBIL_VOXEL_UNKNOWN ? HBIL_VOXEL_EMPTY
                                       : state;
}

/* --- sixteen voxels ------------------------------------------------------- */

kernel void inject(const hbil_cache_inject_args args, global const uint *texels,
                   global uint *states, global float *voxels,
                   global uint *radiance) {
  const hbil_cache_args cache = args.cache;
  const hbil_view_args view = args.view;
  uint number;
  if (!word_of_item(cache, &number))
    return;
  const word_place at = place_of_word(cache, number);
  const uint first = at.first;
  const float size = (float)(1 << at.level);
  /* the same for all voxels of the word */
  const realv cy =
      (TO_REALV(cell_at(cache, at.level, 1, (intv)at.row)) + 0.5f) * size;
  const realv cz =
      (TO_REALV(cell_at(cache, at.level, 2, (intv)at.slice)) + 0.5f) * size;
  const uint before = states[number];
  uint after = before;
  for (int part = 0; part < WORD_VOXELS; part += HBIL_WIDTH) {
    const intv place = at.column + part + EACH_LANE;
    const points centre = {
        (TO_REALV(cell_at(cache, at.level, 0, place)) + 0.5f) * size, cy, cz};
    const points q = transformed_points(args.to_view, centre);
    const realv shrink = ORTHOGRAPHIC ? (realv)1.0f : 1.0f / q.z;
    const realv px = fma(view.fx * q.x, shrink, (realv)view.cx);
    const realv py = fma(view.fy * q.y, shrink, (realv)view.cy);
    /* a voxel around the eye has no place in the view */
    const intv inside = (ORTHOGRAPHIC ? TRUE_LANES : (q.z > 0.3f * size)) &
                        (px >= 0.0f) & (py >= 0.0f) & (px < (float)view.width) &
                        (py < (float)view.height);
    if (!ANY(inside))
      continue;
    float x[HBIL_WIDTH], y[HBIL_WIDTH], z[HBIL_WIDTH], c[3][HBIL_WIDTH];
    float is_inside[HBIL_WIDTH];
    STOREV(px, x);
    STOREV(py, y);
    STOREV(q.z, z);
    STOREV(centre.x, c[0]);
    STOREV(centre.y, c[1]);
    STOREV(centre.z, c[2]);
    STOREV(select((realv)0.0f, (realv)1.0f, inside), is_inside);
    for (int i = 0; i < HBIL_WIDTH; ++i) {
      const uint voxel = (uint)(part + i);
      if (is_inside[i] == 0.0f)
        continue;
      const uint state = state_in_word(before, voxel);
      const uint now = inject_voxel(
          args, texels, voxels + HBIL_VOXEL_FLOATS * (size_t)(first + voxel),
          state, (float3)(c[0][i], c[1][i], c[2][i]), size, x[i], y[i], z[i]);
      if (now == HBIL_VOXEL_SURFACE && state != now)
        radiance[first + voxel] = word_of_light(
            vload3(0, voxels + HBIL_VOXEL_FLOATS * (size_t)(first + voxel) +
                          HBIL_VOXEL_SENT));
      after ^= (state ^ now) << (2u * voxel);
    }
  }
  if (after != before)
    states[number] = after;
}
