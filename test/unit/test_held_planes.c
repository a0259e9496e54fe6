/*
 * Planes that are held from one reading of a frame to the next are those of its
 * file, which is read once.
 */
#include "test/support/dump_file.h"

#include "dump/held_planes.h"

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
static void the_file_is_read_once(void **state) {
  const unsigned few = 1u << ROLE_POSITION | 1u << ROLE_DEPTH;
  dump d = write_frame();
  reading r = dump_read(&d);
  gbuffer plain = read_roles(&d, &r.map, ALL);
  gbuffer points = read_roles(&d, &r.map, few);
  held_planes held = {.is_read = 0};
  image_error error;
  (void)state;
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
  reading_free(&r);
  dump_end(&d);
}

/* A channel that can't be read fails those who want it, and nobody else. */
static void who_wants_no_missing_channel_reads_on(void **state) {
  dump d = write_frame();
  reading r = dump_read(&d);
  gbuffer plain = read_roles(&d, &r.map, 1u << ROLE_DEPTH), none;
  held_planes held = {.is_read = 0};
  image_error error;
  (void)state;
  r.map.held = &held;
  snprintf(r.map.names[ROLE_DIRECT][1], sizeof r.map.names[ROLE_DIRECT][1],
           "missing");
  assert_same(&plain, read_roles(&d, &r.map, 1u << ROLE_DEPTH));
  assert_int_not_equal(
      gbuffer_read(d.path, &r.map, 1u << ROLE_DIRECT, &none, &error), 0);
  assert_non_null(strstr(error.text, "missing"));
  held_planes_free(&held);
  gbuffer_free(&plain);
  reading_free(&r);
  dump_end(&d);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_file_is_read_once),
      cmocka_unit_test(who_wants_no_missing_channel_reads_on),
  };
  return RUN_WITH_DUMPS(tests);
}
