/* Pictures of what a radiance cache knows. */
#include "tool/cache_picture.h"

#include "dump/pixel_ray.h"
#include "tool/preview.h"

/* Grey levels: seen without a surface; the two of the stripes of what no view
 * has seen, and the width of a stripe, pixels. */
enum { OPEN = 128, DARK = 16, LESS_DARK = 48, STRIPE = 4 };

/* No view sees the voxel that its own eye is in: so many voxels of the first
 * level. */
static const double eye_reach = 2.0;

/* The ray of a pixel in cache space. */
static void ray_of(const exact_cache *where, const job_frame *f, size_t x,
                   size_t y, vec3 *origin, vec3 *direction) {
  const hbil_camera *camera = &f->map.camera;
  const double *m = camera->world_from_view;
  const pixel_ray ray = pixel_ray_at(f->map.projection, camera, x, y);
  double from[3], along[3];
  for (int i = 0; i < 3; ++i) {
    from[i] = m[4 * i + 3];
    along[i] = 0.0;
    for (int k = 0; k < 3; ++k) {
      from[i] += m[4 * i + k] * ray.from[k];
      along[i] += m[4 * i + k] * ray.along[k];
    }
  }
  *origin = exact_cache_from_world(where, vec(from[0], from[1], from[2]));
  *direction = vec_normalize(vec(along[0], along[1], along[2]));
}

int cache_picture(const exact_saved_cache *cache, const job_frame *f,
                  const image_window *shown, uint32_t width, uint32_t height,
                  float exposure, picture *out) {
  if (picture_new(width, height, out) != 0)
    return -1;
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++) {
      unsigned char *rgb = out->rgb + 3 * ((size_t)y * width + x);
      const size_t px = (size_t)((int64_t)shown->x - f->map.window.x) +
                        (size_t)x * shown->width / width;
      const size_t py = (size_t)((int64_t)shown->y - f->map.window.y) +
                        (size_t)y * shown->height / height;
      vec3 origin, direction;
      double radiance[3];
      ray_of(&cache->where, f, px, py, &origin, &direction);
      const exact_ray_kind met =
          exact_saved_follow(cache, origin, direction, eye_reach, radiance);
      const int grey = met == EXACT_RAY_SKY        ? OPEN
                       : (x + y) / STRIPE % 2 == 0 ? DARK
                                                   : LESS_DARK;
      for (int c = 0; c < 3; c++)
        rgb[c] = met == EXACT_RAY_HIT
                     ? preview_light(exposure * (float)radiance[c])
                     : (unsigned char)grey;
    }
  return 0;
}
