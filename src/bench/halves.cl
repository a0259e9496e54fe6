/*
 * halves: the same numbers as half floats, to measure images of them.
 *
 * Launch: x = rows of `count` numbers.
 */

kernel void halves(global const float *from, global half *to,
                   const uint count) {
  const size_t begin = get_global_id(0) * count;
  for (size_t i = begin; i < begin + count; ++i)
    vstore_half_rte(from[i], i, to);
}
