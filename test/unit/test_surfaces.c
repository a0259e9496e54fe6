/*
 * Depths that aren't those of surfaces are told in one line: means over edges,
 * samples that are beside the middle of their pixels, as motion blur and depth
 * of field leave them, and positions that are elsewhere.  Sound frames say
 * nothing, whatever is thin or curved in them.
 */
#include "dump/check_surfaces.h"

#include "test/support/dump_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Twice the size of other dumps: more edges. */
enum { ACROSS = 2 * WIDTH, DOWN = 2 * HEIGHT };

static const char mean_text[] = "depth is a mean over edges: at ";
static const char scatter_text[] = "depths scatter about their surfaces, half ";
static const char blur_text[] = "positions are up to ";

static dump begin_sized(scene_kind kind, uint32_t width, uint32_t height) {
  dump d = dump_begin_sized(kind, width, height, 0);
  dump_add_depth(&d, "depth", "Z", 1, 0);
  dump_add_vectors(&d, "normal", letters_xyz, d.s.normal, AXES_WORLD, 0);
  return d;
}

static dump begin(scene_kind kind) {
  return begin_sized(kind, ACROSS, DOWN);
}

/* Reads the dump and measures it. */
static surface_check measure(dump *d, reading *r) {
  surface_check c;
  dump_write(d);
  *r = dump_read(d);
  const surface_points s = surface_points_of(&r->g, &r->map.camera);
  assert_int_equal(surface_check_measure(&s, &c), 0);
  if (getenv("HBIL_TEST_VERBOSE"))
    print_message("%zu edges, mixed %.3f, scatter %.2g, blur %.2g\n", c.edges,
                  c.mixed, c.scatter, c.blur);
  return c;
}

/* The frame has this finding alone. */
static void assert_finding(const reading *r, const char *text) {
  const findings *found = &r->check.found;
  if (found->count != 1 || strncmp(found->text[0], text, strlen(text)) != 0)
    fail_msg("%d findings, %s", found->count,
             found->count ? found->text[0] : "");
}

/* Each value becomes the mean of 2 x 2, which a filter of a renderer, or half
 * the resolution, makes of it. */
static void filter(dump *d) {
  const size_t width = d->s.width;
  for (size_t y = 0; y + 1 < d->s.height; y++)
    for (size_t x = 0; x + 1 < width; x++) {
      float *p = dump_plane(d, "depth.Z") + y * width + x;
      if (p[0] > 0 && p[1] > 0 && p[width] > 0 && p[width + 1] > 0)
        p[0] = (p[0] + p[1] + p[width] + p[width + 1]) / 4;
    }
}

/* Each value is that of a pixel at most `far` away, or at its own place if the
 * picture ends. */
static void scatter(float *plane, size_t far) {
  float *from = malloc(sizeof *from * ACROSS * DOWN);
  unsigned seed = 1;
  assert_non_null(from);
  memcpy(from, plane, sizeof *from * ACROSS * DOWN);
  for (size_t y = far; y + far < DOWN; y++)
    for (size_t x = far; x + far < ACROSS; x++) {
      seed = seed * 1664525u + 1013904223u;
      const size_t to_x = (seed >> 8) % (2 * far + 1);
      const size_t to_y = (seed >> 20) % (2 * far + 1);
      plane[y * ACROSS + x] = from[(y + to_y - far) * ACROSS + x + to_x - far];
    }
  free(from);
}

TEST_WITH_BOTH_CAMERAS(sound_frames) {
  for (int scene = 0; scene < SCENE_KINDS; scene++) {
    dump d = begin((scene_kind)scene);
    dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
    reading r;
    const surface_check c = measure(&d, &r);
    /* measured: at most .012, 1.7e-5 and 7.6e-6 */
    assert_true(c.mixed < 0.05);
    assert_true(c.scatter < 1e-4);
    assert_true(c.blur < 1e-4);
    assert_no_findings(&r);
    dump_done(&d, &r);
  }
}

TEST_WITH_BOTH_CAMERAS(means_over_edges) {
  for (int scene = 0; scene < SCENE_KINDS; scene++) {
    dump d = begin((scene_kind)scene);
    filter(&d);
    reading r;
    const surface_check c = measure(&d, &r);
    assert_true(c.edges > 100);
    assert_true(c.mixed > 0.7);
    assert_finding(&r, mean_text);
    dump_done(&d, &r);
  }
}

/* Of a larger picture every second row and column is measured. */
TEST(large_pictures) {
  size_t edges[2];
  for (unsigned size = 1; size <= 2; size++) {
    dump d = begin_sized(SCENE_ROOM, 256 * size, 144 * size + 1);
    filter(&d);
    reading r;
    const surface_check c = measure(&d, &r);
    edges[size - 1] = c.edges;
    assert_true(c.mixed > 0.7);
    assert_finding(&r, mean_text);
    dump_done(&d, &r);
  }
  /* about as many edges, not twice: measured 706 and 797 */
  assert_true(3 * edges[1] < 4 * edges[0] && 4 * edges[1] > 3 * edges[0]);
}

/* Checks look at every other row of such a picture, but a surface in another
 * row is one. */
TEST(a_single_row_is_seen) {
  for (size_t row = 0; row <= 2; row++) {
    dump d = begin_sized(SCENE_ROOM, 512, 289);
    float *depth = dump_plane(&d, "depth.Z");
    for (size_t i = 0; i < 512 * 289; i++)
      depth[i] = row < 2 && i / 512 == row ? 2.0f : 0.0f;
    reading r = dump_reading(&d);
    const surface_points s = surface_points_of(&r.g, &r.map.camera);
    assert_int_equal(surface_looks(&s), 145 * 512);
    const findings *found = &r.check.found;
    int none = 0;
    for (int i = 0; i < found->count; i++)
      none += strncmp(found->text[i], "no pixel has a depth", 20) == 0;
    assert_int_equal(none, row == 2);
    assert_true((r.check.surface > 0.0) == (row < 2));
    dump_done(&d, &r);
  }
}

/* Without normals, depth alone tells it. */
TEST_WITH_BOTH_CAMERAS(means_without_normals) {
  for (int spoilt = 0; spoilt < 2; spoilt++) {
    dump d = dump_begin_sized(SCENE_ROOM, ACROSS, DOWN, 0);
    dump_add_depth(&d, "depth", "Z", 1, 0);
    d.options.from_depth = 1;
    if (spoilt)
      filter(&d);
    reading r;
    measure(&d, &r);
    if (spoilt)
      assert_finding(&r, mean_text);
    else
      assert_no_findings(&r);
    dump_done(&d, &r);
  }
}

TEST_WITH_BOTH_CAMERAS(scattered_depths) {
  for (int scene = 0; scene < SCENE_KINDS; scene++) {
    dump d = begin((scene_kind)scene);
    scatter(dump_plane(&d, "depth.Z"), 2);
    reading r;
    const surface_check c = measure(&d, &r);
    assert_true(c.scatter > 0.15);
    assert_finding(&r, scatter_text);
    dump_done(&d, &r);
  }
}

/* Rounding to half floats is no scatter. */
TEST(halves) {
  dump d = begin(SCENE_ROOM);
  float *depth = dump_plane(&d, "depth.Z");
  for (size_t i = 0; i < (size_t)ACROSS * DOWN; i++) {
    unsigned bits;
    memcpy(&bits, &depth[i], sizeof bits);
    bits = (bits + 0x1000u) & ~0x1fffu;
    memcpy(&depth[i], &bits, sizeof bits);
  }
  reading r;
  measure(&d, &r);
  assert_no_findings(&r);
  dump_done(&d, &r);
}

/* Positions are those of pixels to the left, as if the camera had turned while
 * they were sampled. */
TEST(blurred_positions) {
  static const size_t shifts[] = {1, 2};
  for (size_t k = 0; k < 2; k++) {
    dump d = begin(SCENE_ROOM);
    dump_add_vectors(&d, "position", letters_xyz, d.s.position, AXES_WORLD, 1);
    for (size_t c = 0; c < 3; c++) {
      char name[16] = "position.X";
      name[9] = letters_xyz[c][0];
      float *p = dump_plane(&d, name);
      for (size_t i = (size_t)ACROSS * DOWN - 1; i > 0; i--)
        if (i % 3 && i % ACROSS >= shifts[k])
          p[i] = p[i - shifts[k]];
    }
    reading r;
    const surface_check c = measure(&d, &r);
    assert_true(fabs(c.blur - (double)shifts[k]) < 0.1);
    if (k)
      assert_finding(&r, blur_text);
    else
      assert_no_findings(&r);
    dump_done(&d, &r);
  }
}
