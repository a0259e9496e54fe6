/*
 * The sampling pattern: directions spread evenly, no pixel looked at twice.
 */
#include "lib/sampling_pattern.h"

#include "test/support/compare.h"
#include "test/support/random.h"

static hbil_pattern_args make_pattern(int slices, int steps, int grid,
                                      float growth) {
  hbil_pattern_args p = {
      slices, steps, HBIL_MAX_LEVELS, grid, 1.6f, growth, 0.0f, 0.0f, 16};
  return p;
}

static hbil_view_args make_view(int width, int height) {
  hbil_view_args v = {width,
                      height,
                      (float)width / 1.6f,
                      (float)width / 1.6f,
                      0.5f * (float)width,
                      0.5f * (float)height,
                      1.6f / (float)width,
                      1.6f / (float)width};
  return v;
}

TEST(cos_and_sin_are_accurate) {
  double worst = 0.0;
  const int steps = 100000;
  for (int i = 0; i < steps; ++i) {
    float v = (float)i / (float)steps, c, s;
    hbil_cos_sin_pi(v, &c, &s);
    worst = fmax(worst, fabs((double)c - cos(PI * (double)v)));
    worst = fmax(worst, fabs((double)s - sin(PI * (double)v)));
  }
  check_at_most("cos, sin of pi v", worst, 2e-7); /* header: 1e-7 + rounding */
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* The i-th site that is gathered. */
static int site_of(int i, int gathered) {
  return hbil_site(hbil_gathered_layer(i % gathered, gathered), i / gathered,
                   gathered);
}

/* Largest deviation of the sorted directions from equal steps. */
static double unevenness(int slices, int gathered, float turn) {
  double angle[16 * 32], worst = 0.0;
  hbil_pattern_args p = make_pattern(slices, 8, 1, 3.0f);
  const int places = hbil_gathered_sites(gathered), count = places * slices;
  p.turn = turn;
  p.gathered = gathered;
  for (int i = 0; i < count; ++i) {
    float x, y;
    hbil_slice_direction(site_of(i % places, gathered), i / places, p, &x, &y);
    worst = fmax(worst, fabs(hypot((double)x, (double)y) - 1.0));
    angle[i] = atan2((double)y, (double)x);
  }
  qsort(angle, (size_t)count, sizeof(*angle), ascending);
  for (int i = 1; i < count; ++i)
    worst = fmax(worst, fabs(angle[i] - angle[i - 1] - PI / count));
  return worst;
}

TEST(directions_of_a_block_are_equally_spaced) {
  const int slices[] = {1, 2, 3, 4, 32};
  for (size_t i = 0; i < sizeof(slices) / sizeof(*slices); ++i)
    for (int gathered = 4; gathered <= 16; gathered *= 4) {
      /* derived: a few roundings of numbers up to pi */
      check_at_most("spacing", unevenness(slices[i], gathered, 0.0f), 1e-6);
      check_at_most("turned spacing",
                    unevenness(slices[i], gathered, 0.6457513f), 1e-6);
    }
}

TEST(places_are_permutations) {
  for (int gathered = 4; gathered <= 16; gathered *= 4) {
    const int places = hbil_gathered_sites(gathered);
    unsigned directions = 0, shifts = 0;
    for (int i = 0; i < places; ++i) {
      directions |= 1u << hbil_direction_order(site_of(i, gathered), gathered);
      shifts |= 1u << hbil_shift_order(site_of(i, gathered), gathered);
    }
    assert_int_equal(directions, (1u << places) - 1u);
    assert_int_equal(shifts, (1u << places) - 1u);
  }
}

/* The layers of a list are those that are gathered, and each is in it once. */
TEST(gathered_layers_are_listed) {
  for (int gathered = 4; gathered <= 16; gathered *= 4) {
    unsigned listed = 0, asked = 0;
    for (int i = 0; i < gathered; ++i)
      listed |= 1u << hbil_gathered_layer(i, gathered);
    for (int layer = 0; layer < HBIL_LAYERS; ++layer)
      asked |= hbil_is_gathered(layer, gathered) ? 1u << layer : 0u;
    assert_int_equal(listed, asked);
    assert_int_equal(__builtin_popcount(listed), gathered);
  }
}

/* Offsets of one half-slice: distinct points of the grid, ever farther out. */
static void check_half_slice(int layer, int level, float ux, float uy,
                             hbil_view_args v, hbil_pattern_args p) {
  int before = 0;
  for (int k = 0; k < p.steps; ++k) {
    int x, y, major;
    hbil_sample_offset(layer, k, level, ux, uy, v, p, &x, &y);
    major = abs(x) > abs(y) ? abs(x) : abs(y);
    if (major <= before)
      fail_msg("%dx%d, layer %d, level %d, growth %g: sample %d is %d away, "
               "the one before %d",
               v.width, v.height, layer, level, (double)p.growth, k, major,
               before);
    assert_true(major >= (k + 1) * p.grid);
    assert_true(x % p.grid == 0 && y % p.grid == 0);
    before = major;
  }
}

static void check_samples(int width, int height, hbil_pattern_args p) {
  hbil_view_args v = make_view(width, height);
  for (int i = 0; i < HBIL_LAYERS * p.slices; ++i)
    for (int level = 0; level < 6; ++level) {
      float ux, uy;
      hbil_slice_direction(i % 16, i / 16, p, &ux, &uy);
      check_half_slice(i % 16, level, ux, uy, v, p);
      check_half_slice(i % 16, level, -ux, -uy, v, p);
    }
}

TEST(samples_are_distinct_and_ever_farther) {
  const int sizes[][2] = {{1, 1}, {17, 31}, {640, 360}};
  const int samples[] = {1, 8, 64};
  const float growths[] = {0.0f, 3.0f, 64.0f};
  for (int i = 0; i < 54; ++i) {
    hbil_pattern_args p =
        make_pattern(2, samples[i / 3 % 3], i / 9 % 2 ? 4 : 1, growths[i % 3]);
    check_samples(sizes[i / 18][0], sizes[i / 18][1], p);
    p.turn = 0.3f;
    p.shift = 0.77f;
    check_samples(sizes[i / 18][0], sizes[i / 18][1], p);
  }
}

TEST(the_last_sample_gets_to_the_edge) {
  hbil_view_args v = make_view(640, 360);
  hbil_pattern_args p = make_pattern(1, 8, 1, 3.0f);
  for (int layer = 0; layer < HBIL_LAYERS; ++layer) {
    float ux, uy, size;
    int x, y;
    hbil_slice_direction(layer, 0, p, &ux, &uy);
    hbil_sample_offset(layer, 7, 0, ux, uy, v, p, &x, &y);
    size = fmaxf((float)abs(x) / 640.0f, (float)abs(y) / 360.0f);
    /* derived: t >= 7/8, growth 3: 0.875 / 1.375 of the way, which ends
     * 1.6 away from the pixel or, at worst, at 0.826 of that in x */
    assert_true(size > 0.52f && size <= 1.01f);
  }
}

/* The steps of neighbouring samples meet in the middle of the pixels between
 * them, and overlap by a tenth of these.  What tells a sample's slope lies a
 * quarter of its step away, on the line to the receiver but for rounding, and
 * never beyond the receiver. */
static void check_extents(float ux, float uy, const hbil_view_args v,
                          const hbil_pattern_args p) {
  int x, y, before = 0;
  double end = 0.5; /* of the receiver's own pixel */
  hbil_sample_offset(3, 0, 0, ux, uy, v, p, &x, &y);
  for (int k = 0; k < p.steps; ++k) {
    int next_x = x, next_y = y;
    if (k + 1 < p.steps)
      hbil_sample_offset(3, k + 1, 0, ux, uy, v, p, &next_x, &next_y);
    const int length = hbil_offset_length(x, y);
    const int after = hbil_offset_length(next_x, next_y);
    const hbil_extent e =
        hbil_sample_extent(x, y, k, p.steps, before, length, after);
    const double from = length * (1.0 - (double)e.near) - 0.5;
    const int quarter = hbil_offset_length(e.slope_x, e.slope_y);
    const double wide =
        k + 1 < p.steps ? (after - before) / 2.0 : (double)(length - before);
    /* the receiver isn't a step's middle, so the first one begins behind it */
    if (k > 0)
      assert_true(fabs(end - from - 0.2 * (length - before - 1)) < 1e-3);
    assert_true(from > 0.0 && (double)e.far >= 0.0);
    assert_true(quarter >= 1 && quarter <= length);
    assert_true(quarter == 1 || fabs(quarter - wide / 4.0) <= 0.5);
    assert_true(fabs((double)e.slope_x * y - (double)e.slope_y * x) <=
                0.5 * length + 1e-9);
    assert_true(e.slope_x * x >= 0 && e.slope_y * y >= 0);
    end = length * (1.0 + (double)e.far) + 0.5;
    before = length;
    x = next_x;
    y = next_y;
  }
}

TEST(steps_overlap_and_slopes_are_told_beside_them) {
  const hbil_view_args v = make_view(16384, 9000);
  const float growth[] = {0.0f, 2.0f};
  for (int steps = 1; steps <= 256; steps *= 2)
    for (int i = 0; i < 32; ++i) {
      const hbil_pattern_args p = make_pattern(1, steps, 1, growth[i & 1]);
      const double angle = 2.0 * PI * i / 32.0 + 0.1;
      check_extents((float)cos(angle), (float)sin(angle), v, p);
    }
}

TEST(the_level_is_the_smallest_that_covers) {
  random_state r = {7};
  for (int i = 0; i < 10000; ++i) {
    float reach = (float)(0.1 + 3.0 * random_unit(&r));
    float need = (float)pow(2.0, 8.0 - 24.0 * random_unit(&r));
    int level = hbil_level(reach, need, HBIL_MAX_LEVELS);
    float covered = ldexpf(reach, -level);
    assert_true(level >= 0 && level < HBIL_MAX_LEVELS);
    assert_true(level == 0 || covered >= need);
    assert_true(level == HBIL_MAX_LEVELS - 1 || 0.5f * covered < need);
    assert_int_equal(hbil_level(reach, need, 1), 0);
  }
}

int main(void) {
  return tests_run();
}
