/*
 * copy: the fastest that bytes can be moved.  Each work-item moves one vector
 * of WIDTH floats.
 *
 * Builds: WIDTH (16 on CPUs, 4 on GPUs).
 * Launch: x = vectors.
 */

#define PASTE_(a, b) a##b
#define PASTE(a, b) PASTE_(a, b)
typedef PASTE(float, WIDTH) vector;

kernel void copy(global const vector *from, global vector *to) {
  const size_t i = get_global_id(0);
  to[i] = from[i];
}
