/*
 * ray_hits: what rays from surfaces of the cache end at.
 *
 * list_parts, list_surfaces: the surfaces that an update handles, in rising
 * order; and a copy of the last update's list.
 * trace_rays: follows rays from each of them and stores what each ray ends at.
 * All bounces of an update read these hits, so rays are traced once for all of
 * them.  What is in a ray's way changes seldom, so most surfaces take the hits
 * of the last update, and are traced in turn.
 *
 * Launch: list_parts, list_surfaces: x = HBIL_CACHE_PARTS.  trace_rays: any x.
 */
#include "lib/ray_hits.clh"

/* --- the surfaces of an update -------------------------------------------- */

/* The surfaces of a word that the update handles, as surfaces_of_word(). */
INLINE uint listed_of_word(const hbil_cache_list_args args,
                           global const uint *states, uint word) {
  uint listed = surfaces_of_word(states[word]);
  if (args.phases > 1)
    for (uint left = listed; left; left &= left - 1u)
      if (first_surface(word, left) % (uint)args.phases != (uint)args.phase)
        listed &= ~(left & -left);
  return listed;
}

/* The words of states that a part has, from *word on, before the one returned;
 * none for work-items that are no part. */
INLINE uint words_of_part(const hbil_cache_args cache, uint *word) {
  const uint part = (uint)get_global_id(0);
  const uint words = ((uint)cache.levels << (3 * cache.log2_voxels)) /
                     WORD_VOXELS / HBIL_CACHE_PARTS;
  const bool is_part = part < HBIL_CACHE_PARTS && get_global_id(1) == 0;
  *word = is_part ? part * words : 0u;
  return is_part ? *word + words : 0u;
}

/* A part of the last list, if it isn't too long. */
INLINE void remember_list(const hbil_cache_args cache, uint part,
                          global const uint *list, global uint *last) {
  const uint room =
      ((uint)cache.levels << (3 * cache.log2_voxels)) / HBIL_LAST_LIST;
  const uint count = list[0] <= room ? list[0] : 0u;
  const uint each = (count + HBIL_CACHE_PARTS - 1u) / HBIL_CACHE_PARTS;
  const uint end = min((part + 1u) * each, count);
  for (uint i = part * each; i < end; ++i)
    last[HBIL_LIST_HEAD + i] = list[HBIL_LIST_HEAD + i];
  if (part == 0)
    last[0] = count;
}

kernel void list_parts(const hbil_cache_list_args args,
                       global const uint *states, global uint *list,
                       global uint *last_list) {
  uint word, count = 0;
  const uint end = words_of_part(args.cache, &word);
  if (word == end)
    return;
  remember_list(args.cache, (uint)get_global_id(0), list, last_list);
  for (; word < end; ++word)
    count += popcount(listed_of_word(args, states, word));
  list[1 + get_global_id(0)] = count;
}

kernel void list_surfaces(const hbil_cache_list_args args,
                          global const uint *states, global uint *list) {
  uint word;
  const uint end = words_of_part(args.cache, &word);
  const uint part = (uint)get_global_id(0);
  if (word == end)
    return;
  global uint *next = list + HBIL_LIST_HEAD;
  for (uint i = 0; i < part; ++i)
    next += list[1 + i];
  for (; word < end; ++word)
    for (uint left = listed_of_word(args, states, word); left;
         left &= left - 1u)
      *next++ = first_surface(word, left);
  if (part == HBIL_CACHE_PARTS - 1)
    list[0] = (uint)(next - (list + HBIL_LIST_HEAD));
}

/* --- rays ----------------------------------------------------------------- */

/* The rays of a work-item, numbered as their hits are.  Each lane follows one.
 * As soon as half of the rays have ended, their lanes begin the next ones.  If
 * all lanes waited for the slowest ray, fewer than half would be at work on
 * average. */
typedef struct queue {
  global const uint *surfaces;
  global uint *hits;
  int log2_rays; /* of a surface */
  int next, end;
  int unknown; /* a ray that is known to have no hit yet; -1: none is */
  /* the list of the last update, and its hits */
  global const uint *last_list, *last_hits, *states;
  uint turns, turn;
} queue;

/* Stores what the rays `ray` end at, where it isn't negative. */
INLINE void store_hits(const queue *q, intv ray, const ray_ends *ends) {
  int number[HBIL_WIDTH];
  uint hit[HBIL_WIDTH];
  const uintv open =
      select((uintv)HIT_UNKNOWN, (uintv)HIT_SKY, AS_UINTV(ends->sky));
  STORE_INTV(AS_INTV(select(open, AS_UINTV(ends->voxel), AS_UINTV(ends->hit))),
             hit);
  STORE_INTV(ray, number);
  for (int i = 0; i < HBIL_WIDTH; ++i)
    if (number[i] >= 0)
      q->hits[number[i]] = hit[i];
}

/* The place of a surface in the last update's list, which is in rising order;
 * as many as there are: it isn't in it. */
INLINE uint last_place(global const uint *list, uint number) {
  const uint count = list[0];
  uint first = 0, end = count;
  while (first < end) {
    const uint middle = (first + end) / 2u;
    if (list[HBIL_LIST_HEAD + middle] < number)
      first = middle + 1u;
    else
      end = middle;
  }
  return first < count && list[HBIL_LIST_HEAD + first] == number ? first
                                                                 : count;
}

/* Whether a surface has the hits of the last update, and their place there: it
 * isn't its turn, it was listed, and everything that they hit is still there.
 */
INLINE bool has_last_hits(const queue *q, uint place, uint *last) {
  const uint number = q->surfaces[place], rays = 1u << q->log2_rays;
  if (q->turns < 2u || number % q->turns == q->turn)
    return false;
  *last = last_place(q->last_list, number);
  if (*last == q->last_list[0])
    return false;
  for (uint i = 0; i < rays; ++i) {
    const uint hit = q->last_hits[*last * rays + i];
    if (hit < HIT_SKY &&
        state_in_word(q->states[hit / WORD_VOXELS], hit) != HBIL_VOXEL_SURFACE)
      return false;
  }
  return true;
}

/* Takes known hits, and goes on to the next ray without any.  With a lane to a
 * work-item, each takes a single one, so that many work at once. */
INLINE void take_known_hits(queue *q) {
  const uint rays = 1u << q->log2_rays, taken = HBIL_WIDTH > 1 ? rays : 1u;
  uint last;
  while (q->next < q->end && q->next != q->unknown &&
         ((uint)q->next & (taken - 1u)) == 0u &&
         has_last_hits(q, (uint)q->next >> q->log2_rays, &last)) {
    const uint from = last * rays + ((uint)q->next & (rays - 1u));
    for (uint i = 0; i < taken; ++i)
      q->hits[(uint)q->next + i] = q->last_hits[from + i];
    q->next += (int)taken;
  }
  q->unknown = q->next;
}

/* The next rays, for these lanes; -1 where there is none. */
INLINE intv next_rays(queue *q, intv wanted) {
  int ray[HBIL_WIDTH];
  STORE_INTV(wanted, ray);
  for (int i = 0; i < HBIL_WIDTH; ++i) {
    take_known_hits(q);
    ray[i] = ray[i] && q->next < q->end ? q->next++ : -1;
  }
  return LOADV(ray);
}

/* Lanes whose voxels have direct light: finished radiance has all bounces. */
INLINE intv direct_light(global const float *voxels, intv number) {
  int voxel[HBIL_WIDTH];
  float weight[HBIL_WIDTH];
  STORE_INTV(number, voxel);
#pragma unroll
  for (int i = 0; i < HBIL_WIDTH; ++i)
    weight[i] =
        voxels[HBIL_VOXEL_FLOATS * (size_t)voxel[i] + HBIL_VOXEL_LIGHT_WEIGHT];
  return LOADV(weight) >= 0.0f;
}

/* Begins rays that aren't negative. */
INLINE ray_states begin(const queue *q, const cache_map *map, intv ray) {
  const hbil_cache_args cache = map->cache;
  const int mask = cache.voxels - 1, k = cache.log2_voxels;
  const int rays = 1 << q->log2_rays;
  const intv is_ray = ray >= 0;
  const intv place = max(ray, 0) >> q->log2_rays;
  const intv number = AS_INTV(gather_words(q->surfaces, place));
  points n;
  realv offset;
  gather_planes(map->voxels, number, TRUE_LANES, &n, &offset);
  const realv shorter = 1.0f / sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  n.x *= shorter;
  n.y *= shorter;
  n.z *= shorter;
  const intv level = number >> (3 * k);
  const realv size = AS_REALV((level + 127) << 23);
  const realv lift = fma((realv)HBIL_CACHE_LIFT, size, offset);
  const points origin = {
      fma(TO_REALV(cell_at(cache, level, 0, number & mask)) + 0.5f, size,
          n.x * lift),
      fma(TO_REALV(cell_at(cache, level, 1, (number >> k) & mask)) + 0.5f, size,
          n.y * lift),
      fma(TO_REALV(cell_at(cache, level, 2, (number >> 2 * k) & mask)) + 0.5f,
          size, n.z * lift)};
  return begin_rays(
      cache, origin,
      surface_ray_directions(ray & (rays - 1), rays, AS_UINTV(number), n),
      HBIL_CACHE_START * size, is_ray & direct_light(map->voxels, number));
}

/* Replaces the rays of some lanes. */
INLINE void replace_rays(const hbil_cache_args c, ray_states *r, intv lanes,
                         const ray_states *fresh) {
#define REPLACE(member) r->member = select(r->member, fresh->member, lanes)
  REPLACE(origin.x);
  REPLACE(origin.y);
  REPLACE(origin.z);
  REPLACE(d.x);
  REPLACE(d.y);
  REPLACE(d.z);
  REPLACE(inverse.x);
  REPLACE(inverse.y);
  REPLACE(inverse.z);
  REPLACE(t);
  for (int l = 0; l + 1 < c.levels; ++l)
    REPLACE(entries[l]);
  REPLACE(unseen);
  REPLACE(last);
  REPLACE(active);
#undef REPLACE
}

INLINE void follow_all(queue *q, const cache_map *map) {
  const hbil_cache_args cache = map->cache;
  const points nowhere = {0.0f, 0.0f, 0.0f};
  ray_states r = begin_rays(cache, nowhere, nowhere, 0.0f, 0);
  ray_ends ends = {0, 0, 0, 0.0f, 0.0f, 0.0f};
  intv ray = -1;
  for (ulong steps = (ulong)(q->end - q->next) * (ulong)most_steps(cache);
       steps > 0; --steps) {
    if (q->next < q->end && lanes_true(r.active) <= HBIL_WIDTH / 2) {
      const intv done = !r.active;
      store_hits(q, select((intv)-1, ray, done), &ends);
      const intv more = next_rays(q, done);
      const ray_states fresh = begin(q, map, more);
      replace_rays(cache, &r, done, &fresh);
      ray = select(ray, more, done);
      ends.hit &= !done;
      ends.sky &= !done;
    } else if (!ANY(r.active))
      break;
    if (ANY(r.active))
      step_rays(map, &r, &ends);
  }
  store_hits(q, ray, &ends);
}

kernel void trace_rays(const hbil_cache_trace_args args,
                       global const uchar *clearance,
                       global const float *voxels, global const uint *list,
                       global uint *hits, global const uint *last_list,
                       global const uint *last_hits,
                       global const uint *states) {
  const hbil_cache_args cache = args.cache;
  const cache_map map = {cache, clearance, voxels};
  uint first;
  if (get_global_id(1) > 0 || cache.voxels < 1)
    return;
  const uint rays = (uint)rays_of_each(cache, list[0]);
  /* lanes share what they find out about a surface */
  const uint least = HBIL_WIDTH > 1 ? HBIL_CACHE_RAYS : 1u;
  const uint end = part_of_item(list[0] * rays, least, &first);
  if (first == end)
    return;
  /* a list that is remembered has all rays */
  const bool takes = rays == HBIL_CACHE_RAYS;
  queue q = {list + HBIL_LIST_HEAD,
             hits,
             31 - (int)clz(rays),
             (int)first,
             (int)end,
             -1,
             last_list,
             last_hits,
             states,
             takes ? (uint)args.turns : 1u,
             (uint)args.turn};
  follow_all(&q, &map);
}
