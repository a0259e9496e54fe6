/* Frames and their layers side by side in one picture. */
#include "tool/contact_sheet.h"

#include "image/image.h"
#include "image/picture.h"
#include "tool/preview.h"

/* Pixels. */
enum { LEAST_TILE = 160, MOST_TILE = 320, GAP = 8, LINE = 22, TEXT = 15 };

/* Longer sequences are shown by equally spaced frames. */
enum { MOST_ROWS = 8 };

static size_t rows_of(size_t frames) {
  return frames < MOST_ROWS ? frames : MOST_ROWS;
}

/* The frame that a row shows.  The first and the last one are among them. */
static size_t frame_of(const contact_sheet *s, size_t row) {
  const size_t rows = rows_of(s->frames);
  return rows < 2 ? 0 : row * (s->frames - 1) / (rows - 1);
}

static uint32_t column_x(const contact_sheet *s, uint32_t column) {
  return GAP + column * (s->tile_width + GAP);
}

/* The top of a row's label; its tiles lie below that. */
static uint32_t row_y(const contact_sheet *s, size_t row) {
  return LINE + (uint32_t)row * (LINE + s->tile_height + GAP);
}

static void write_text(contact_sheet *s, uint32_t x, uint32_t y,
                       const char *text) {
  if (picture_text(&s->picture, (int)x, (int)y + TEXT, TEXT, PICTURE_LEFT,
                   text) != 0)
    s->unlabelled = 1;
}

int contact_sheet_open(contact_sheet *s, unsigned layers, int cache,
                       size_t frames, uint32_t width, uint32_t height) {
  uint32_t columns = 0;
  *s = (contact_sheet){.layers = layers, .cache = cache, .frames = frames};
  s->tile_width = width < LEAST_TILE  ? LEAST_TILE
                  : width > MOST_TILE ? MOST_TILE
                                      : width;
  s->tile_height =
      (uint32_t)(((uint64_t)height * s->tile_width + width / 2) / width);
  if (s->tile_height < 1)
    s->tile_height = 1;
  for (int l = 0; l < LAYER_COUNT; l++)
    columns += layers >> l & 1;
  if (picture_new(column_x(s, columns + (cache ? 1 : 0)),
                  row_y(s, rows_of(frames)), &s->picture) != 0)
    return -1;
  columns = 0;
  for (int l = 0; l < LAYER_COUNT; l++)
    if (layers >> l & 1)
      write_text(s, column_x(s, columns++), 2, layer_table[l].name);
  if (cache)
    write_text(s, column_x(s, columns), 2, "radiance cache");
  return 0;
}

void contact_sheet_close(contact_sheet *s) {
  picture_free(&s->picture);
}

int contact_sheet_shows(const contact_sheet *s, size_t frame) {
  return s->picture.rgb && s->row < rows_of(s->frames) &&
         frame_of(s, s->row) == frame;
}

int contact_sheet_add(contact_sheet *s, const char *name, const image *result,
                      float exposure) {
  const uint32_t y = row_y(s, s->row++);
  uint32_t column = 0;
  int failed = 0;
  write_text(s, GAP, y, name);
  for (int l = 0; l < LAYER_COUNT && !failed; l++) {
    picture tile = {0};
    if (!(s->layers >> l & 1))
      continue;
    const picture_window at = {column_x(s, column++), y + LINE, s->tile_width,
                               s->tile_height};
    failed = preview_picture(result, (layer)l, exposure, &tile) != 0 ||
             picture_tile(&s->picture, &at, &tile) != 0;
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
  const picture_window at = {s->picture.width - GAP - s->tile_width,
                             row_y(s, row) + LINE, s->tile_width,
                             s->tile_height};
  return picture_tile(&s->picture, &at, tile);
}
