/*
 * Finite thickness in intervals: the exact counterpart of sectors.c.
 *
 * The covered angles of a half-slice are a union of disjoint intervals, sorted
 * from wo outwards.  A new occluder [front, back] touches a run of them.  Its
 * newly covered measure is A(back) - A(front), less what it shares with each
 * interval of the run; the run and the occluder then become one interval.
 *
 * The bent normal is the integral over the whole half-slice less that over
 * every interval: B(start) + sum (B(front) - B(back)).
 */
#include "exact/intervals.h"

#include <string.h>

/* The measure that an occluder shares with an interval that it touches. */
static double overlap(const half_slice *h, const interval *occluder,
                      const interval *covered) {
  const bool in_front = occluder->high > covered->high;
  const bool behind = occluder->low < covered->low;
  return exact_measure(h, behind ? covered->back : occluder->back) -
         exact_measure(h, in_front ? covered->front : occluder->front);
}

/* Replaces the intervals [first, last), which the occluder touches, and the
 * occluder by one. */
static void merge(intervals *covered, interval occluder, int first, int last) {
  interval *list = covered->list;
  if (last > first && list[first].high > occluder.high) {
    occluder.high = list[first].high;
    occluder.front = list[first].front;
  }
  if (last > first && list[last - 1].low < occluder.low) {
    occluder.low = list[last - 1].low;
    occluder.back = list[last - 1].back;
  }
  memmove(list + first + 1, list + last,
          (size_t)(covered->count - last) * sizeof(*list));
  list[first] = occluder;
  covered->count += 1 - (last - first);
}

double exact_intervals_cover(intervals *covered, const half_slice *h,
                             double distance, double high, double low) {
  const interval *list = covered->list;
  interval occluder = {.high = high, .low = low};
  int first = 0, last;
  while (first < covered->count && list[first].low > high)
    ++first;
  if (first < covered->count && list[first].high >= high &&
      list[first].low <= low)
    return 0.0; /* inside an interval: nothing new, and no angles needed */
  occluder.front = exact_horizon(h, distance, high);
  occluder.back = exact_horizon(h, distance, low);
  double fresh =
      exact_measure(h, occluder.back) - exact_measure(h, occluder.front);
  for (last = first; last < covered->count && list[last].high >= low; ++last)
    fresh -= overlap(h, &occluder, list + last);
  merge(covered, occluder, first, last);
  return fmax(fresh, 0.0);
}

vec3 exact_intervals_bent(const intervals *covered, const half_slice *h) {
  vec3 sum = exact_bent_integral(h, h->start);
  for (int i = 0; i < covered->count; ++i) {
    sum = vec_add(sum, 1.0, exact_bent_integral(h, covered->list[i].front));
    sum = vec_add(sum, -1.0, exact_bent_integral(h, covered->list[i].back));
  }
  return sum;
}
