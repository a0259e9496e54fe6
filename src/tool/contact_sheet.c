/* Pictures side by side: layers of frames, and what a radiance cache knows. */
#include "tool/contact_sheet.h"

#include "dump/pixel_ray.h"
#include "tool/preview.h"

/* ------------------------------------------------------------------------ */
/* What a radiance cache knows                                               */

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

/* ------------------------------------------------------------------------ */
/* The sheet                                                                 */

/* Pixels. */
enum { LEAST_TILE = 160, MOST_TILE = 320, GAP = 8, LINE = 22, TEXT = 15 };

/* Longer sequences are shown by equally spaced frames.  More tiles than columns
 * go on below: four of the widest fill a screen of 1280 pixels. */
enum { MOST_ROWS = 8, MOST_COLUMNS = 4 };

static size_t rows_of(size_t frames) {
  return frames < MOST_ROWS ? frames : MOST_ROWS;
}

/* The frame that a row shows.  The first and the last one are among them. */
static size_t frame_of(const contact_sheet *s, size_t row) {
  const size_t rows = rows_of(s->frames);
  return rows < 2 ? 0 : row * (s->frames - 1) / (rows - 1);
}

/* Tiles of a frame: its layers in their order, then the cache's. */
static uint32_t tiles_of(const contact_sheet *s) {
  uint32_t tiles = s->cache ? 1 : 0;
  for (int l = 0; l < LAYER_COUNT; l++)
    tiles += s->layers >> l & 1;
  return tiles;
}

/* Every tile has a line of text above it. */
static uint32_t line_height(const contact_sheet *s) {
  return LINE + s->tile_height + GAP;
}

/* A row has a line with the frame's name, then its tiles. */
static uint32_t row_height(const contact_sheet *s) {
  const uint32_t lines = (tiles_of(s) + MOST_COLUMNS - 1) / MOST_COLUMNS;
  return LINE + lines * line_height(s);
}

static picture_window tile_place(const contact_sheet *s, size_t row,
                                 uint32_t tile) {
  return (picture_window){GAP + tile % MOST_COLUMNS * (s->tile_width + GAP),
                          (uint32_t)row * row_height(s) + 2 * LINE +
                              tile / MOST_COLUMNS * line_height(s),
                          s->tile_width, s->tile_height};
}

static void write_text(contact_sheet *s, uint32_t x, uint32_t y,
                       const char *text) {
  if (picture_text(&s->picture, (int)x, (int)y + TEXT, TEXT, PICTURE_LEFT,
                   text) != 0)
    s->unlabelled = 1;
}

int contact_sheet_open(contact_sheet *s, unsigned layers, int cache,
                       size_t frames, uint32_t width, uint32_t height) {
  *s = (contact_sheet){.layers = layers, .cache = cache, .frames = frames};
  s->tile_width = width < LEAST_TILE  ? LEAST_TILE
                  : width > MOST_TILE ? MOST_TILE
                                      : width;
  s->tile_height =
      (uint32_t)(((uint64_t)height * s->tile_width + width / 2) / width);
  if (s->tile_height < 1)
    s->tile_height = 1;
  const uint32_t tiles = tiles_of(s);
  const uint32_t columns = tiles < MOST_COLUMNS ? tiles : MOST_COLUMNS;
  return picture_new(GAP + columns * (s->tile_width + GAP),
                     (uint32_t)rows_of(frames) * row_height(s), &s->picture);
}

void contact_sheet_close(contact_sheet *s) {
  picture_free(&s->picture);
}

int contact_sheet_shows(const contact_sheet *s, size_t frame) {
  return s->picture.rgb && s->row < rows_of(s->frames) &&
         frame_of(s, s->row) == frame;
}

/* Writes a tile and its name above it. */
static int add_tile(contact_sheet *s, size_t row, uint32_t number,
                    const char *name, const picture *tile) {
  const picture_window place = tile_place(s, row, number);
  write_text(s, place.x, place.y - LINE, name);
  return picture_tile(&s->picture, &place, tile);
}

int contact_sheet_add(contact_sheet *s, const char *name, const image *result,
                      float exposure) {
  const size_t row = s->row++;
  uint32_t tiles = 0;
  int failed = 0;
  write_text(s, GAP, (uint32_t)row * row_height(s), name);
  for (int l = 0; l < LAYER_COUNT && !failed; l++) {
    picture tile = {0};
    if (!(s->layers >> l & 1))
      continue;
    failed = preview_picture(result, (layer)l, exposure, &tile) != 0 ||
             add_tile(s, row, tiles++, layer_table[l].name, &tile) != 0;
    picture_free(&tile);
  }
  return failed ? -1 : 0;
}

size_t contact_sheet_rows(const contact_sheet *s) {
  return s->row;
}

size_t contact_sheet_frame(const contact_sheet *s, size_t row) {
  return frame_of(s, row);
}

int contact_sheet_add_cache(contact_sheet *s, size_t row, const picture *tile) {
  return add_tile(s, row, tiles_of(s) - 1, "radiance cache", tile);
}
