/*
 * Planes that are held from one reading of a frame to the next are those of its
 * file, which is read once.
 */
#include "test/support/dump_file.h"

#include "dump/held_planes.h"
#include "image/image_memory.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { ALL = (1 << ROLE_COUNT) - 1 };

/* Reads with the map's held planes. */
static gbuffer read_roles(const dump *d, const channel_map *map,
                          unsigned roles) {
  gbuffer g;
  image_error error;
  if (gbuffer_read(d->path, map, roles, &g, &error) != 0)
    fail_msg("%s", error.text);
  return g;
}

/* Frees b. */
static void assert_same(const gbuffer *a, gbuffer b) {
  assert_int_equal(a->planes.count, b.planes.count);
  assert_true(a->planes.count > 0);
  for (size_t i = 0; i < b.planes.count; i++) {
    assert_string_equal(a->planes.planes[i].name, b.planes.planes[i].name);
    assert_memory_equal(a->planes.planes[i].pixels, b.planes.planes[i].pixels,
                        sizeof(float) * PIXELS);
  }
  gbuffer_free(&b);
}

static dump write_frame(void) {
  dump d = dump_begin_plain(SCENE_ROOM);
  dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
  dump_add_colour(&d, "direct", letters_rgb, d.s.direct, NULL, 1);
  dump_write(&d);
  return d;
}

/* The file is gone after the first reading. */
TEST(the_file_is_read_once) {
  const unsigned few = 1u << ROLE_POSITION | 1u << ROLE_DEPTH;
  dump d = write_frame();
  reading r = dump_read(&d);
  gbuffer plain = read_roles(&d, &r.map, ALL);
  gbuffer points = read_roles(&d, &r.map, few);
  held_planes held = {.is_read = 0};
  image_error error;
  r.map.held = &held;
  assert_same(&points, read_roles(&d, &r.map, few));
  assert_int_equal(unlink(d.path), 0);
  assert_same(&points, read_roles(&d, &r.map, few));
  assert_same(&plain, read_roles(&d, &r.map, ALL));
  held.is_last = 1;
  assert_same(&plain, read_roles(&d, &r.map, ALL));
  assert_int_equal(held.planes.count, 0);
  assert_int_not_equal(gbuffer_read(d.path, &r.map, ALL, &plain, &error), 0);
  held_planes_free(&held);
  gbuffer_free(&points);
  dump_done(&d, &r);
}

/* A channel that can't be read fails those who want it, and nobody else. */
TEST(who_wants_no_missing_channel_reads_on) {
  dump d = write_frame();
  reading r = dump_read(&d);
  gbuffer plain = read_roles(&d, &r.map, 1u << ROLE_DEPTH), none;
  held_planes held = {.is_read = 0};
  image_error error;
  r.map.held = &held;
  snprintf(r.map.names[ROLE_DIRECT][1], sizeof r.map.names[ROLE_DIRECT][1],
           "missing");
  assert_same(&plain, read_roles(&d, &r.map, 1u << ROLE_DEPTH));
  assert_int_not_equal(
      gbuffer_read(d.path, &r.map, 1u << ROLE_DIRECT, &none, &error), 0);
  assert_non_null(strstr(error.text, "missing"));
  held_planes_free(&held);
  gbuffer_free(&plain);
  dump_done(&d, &r);
}

static void assert_lies_at(const image *img, size_t plane,
                           const image_memory *m, size_t place) {
  const size_t bytes = image_memory_plane(sizeof(float) * PIXELS);
  assert_true(img->planes[plane].is_lent);
  assert_ptr_equal(img->planes[plane].pixels, m->bytes + place * bytes);
}

/* Frame after frame, planes are in the same memory, one behind the other, and
 * those that find no room are elsewhere. */
TEST(planes_lie_in_lent_memory) {
  const unsigned few = 1u << ROLE_NORMAL | 1u << ROLE_DEPTH;
  dump d = write_frame();
  reading r = dump_read(&d);
  gbuffer plain = read_roles(&d, &r.map, few);
  image_memory m = {.bytes = NULL};
  assert_int_equal(gbuffer_read_bytes(&r.map, few),
                   4 * image_memory_plane(sizeof(float) * PIXELS));
  for (size_t room = 4; room > 1; room--) {
    image_memory_free(&m);
    image_memory_empty(&m, room * image_memory_plane(sizeof(float) * PIXELS));
    m.size = room *
             image_memory_plane(sizeof(float) * PIXELS); /* it was rounded up */
    image_memory_select(&m);
    gbuffer lent = read_roles(&d, &r.map, few);
    image_memory_select(NULL);
    for (size_t i = 0; i < room; i++)
      assert_lies_at(&lent.planes, i, &m, i);
    for (size_t i = room; i < 4; i++)
      assert_false(lent.planes.planes[i].is_lent);
    assert_same(&plain, lent);
  }
  image_memory_free(&m);
  gbuffer_free(&plain);
  dump_done(&d, &r);
}

/* What was read before moves to where the others are. */
TEST(planes_move_into_lent_memory) {
  dump d = write_frame();
  reading r = dump_read(&d);
  gbuffer plain = read_roles(&d, &r.map, ALL);
  gbuffer moved = read_roles(&d, &r.map, ALL);
  image_memory m = {.bytes = NULL};
  image_memory_empty(&m, moved.planes.count *
                             image_memory_plane(sizeof(float) * PIXELS));
  image_memory_select(&m);
  image_memory_move(&moved.planes);
  image_memory_select(NULL);
  for (size_t i = 0; i < moved.planes.count; i++)
    assert_lies_at(&moved.planes, i, &m, i);
  assert_same(&plain, moved);
  image_memory_free(&m);
  gbuffer_free(&plain);
  dump_done(&d, &r);
}
