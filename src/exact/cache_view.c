/* A view's pixels, as the radiance cache takes them. */
#include "exact/cache.h"
#include "exact/camera.h"
#include "exact/input.h"
#include "exact/passes.h"

/* The input's normal in view space; surfaces whose normal has no direction face
 * the eye. */
static vec3 view_normal(const exact_frame *frame, int x, int y) {
  const hbil_inputs *in = &frame->config->inputs;
  vec3 n = vec((double)exact_input(frame, EXACT_NORMAL, x, y),
               (double)exact_input(frame, EXACT_NORMAL + 1, x, y),
               (double)exact_input(frame, EXACT_NORMAL + 2, x, y));
  n = vec(n.x * (double)in->normal_scale[0], n.y * (double)in->normal_scale[1],
          n.z * (double)in->normal_scale[2]);
  if (in->normal_space == HBIL_SPACE_WORLD)
    n = exact_to_view(&frame->camera, n);
  return vec_dot(n, n) >= 1e-20 && vec_dot(n, n) < HUGE_VAL
             ? n
             : vec_scale(-1.0, exact_ray(frame, x, y));
}

exact_texel exact_cache_texel(const exact_frame *frame,
                              const exact_cache *cache, bool finished, int x,
                              int y) {
  exact_texel texel = {.depth = 0.0};
  if (exact_is_sky(frame, x, y))
    return texel;
  texel.depth = exact_planar_depth(frame, x, y) / cache->voxel_size;
  texel.normal =
      vec_normalize(exact_to_world(&frame->camera, view_normal(frame, x, y)));
  for (int c = 0; c < 3; ++c) {
    texel.reflectance[c] =
        exact_albedo(frame, c, x, y) * exact_transmittance(frame, c, x, y);
    const double sent =
        finished ? exact_light(frame, EXACT_DIRECT + c, x, y)
                 : texel.reflectance[c] / PI * exact_direct(frame, c, x, y) +
                       exact_gathered_emission(frame, c, x, y);
    texel.sent[c] = sent / exact_exposure(frame);
  }
  return texel;
}
