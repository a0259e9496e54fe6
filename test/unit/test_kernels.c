/*
 * Each pass of a frame matches the exact pass on what the device's passes
 * before it wrote, with random settings, formats, sizes, cameras and contents
 * from extremes.  Every output is finite and in range, and nothing is written
 * outside of it.
 *
 * `make check` draws CASES whose settings cover as many pairs of values as they
 * can, after those that were wrong once; `make stress` draws for
 * HBIL_STRESS_SECONDS.  HBIL_STRESS_CASE in the
 * environment is one case's seed, as failures print it.
 */
#include "test/support/pass_rows.h"
#include "test/support/stress.h"

#include <stdio.h>
#include <time.h>

/* Frames of each case: without a history, with it, and with planted stages. */
enum { FRAMES = 3, CASES = 12 };

static void check(setup *s, drawn *d) {
  draw_tell(s, d);
  if (getenv("HBIL_TEST_VERBOSE"))
    print_message("%s\n", stress_case);
  setup_start(s);
  for (uint32_t i = 0; i < FRAMES; ++i) {
    draw_frame(s, d, i);
    check_passes(s, d, i, i == FRAMES - 1);
    if (i < FRAMES - 1)
      check_sane(s);
  }
  setup_free(s);
}

static double now(void) {
  struct timespec t;
  timespec_get(&t, TIME_UTC);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seeds of cases that found what no other test had: guesses that hang on depths
 * beside a sky, and a lobe that is a whole sphere. */
static const uint64_t found[] = {732, 1150};

TEST(passes_match_with_any_settings) {
  const char *one = getenv("HBIL_STRESS_CASE");
  const double end = now() + stress_effort.seconds;
  setup s;
  drawn d;
  if (one) {
    draw_case(&s, &d, strtoull(one, NULL, 10));
    check(&s, &d);
    return;
  }
  for (size_t i = 0; i < sizeof found / sizeof *found; ++i) {
    draw_case(&s, &d, found[i]);
    check(&s, &d);
  }
  for (uint64_t i = 0; i < CASES || now() < end; ++i) {
    draw_covering_case(&s, &d, stress_effort.seed, i);
    check(&s, &d);
  }
}
