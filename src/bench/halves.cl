/*
 * halves: the same numbers as half floats, to measure images of them.
 *
 * Launch: x = numbers.
 */

kernel void halves(global const float *from, global half *to) {
  const size_t i = get_global_id(0);
  vstore_half_rte(from[i], i, to);
}
