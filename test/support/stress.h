/*
 * What the tests with extreme inputs share: how much to do, a few plans that
 * they all run on, and checks that hold for every frame.
 *
 * In the environment: HBIL_STRESS_SEED, a number, is where drawing begins (1);
 * HBIL_STRESS_SECONDS selects the long form (`make stress`) and says how long
 * random settings are drawn; HBIL_STRESS_TEST selects tests by name.  Every
 * failure prints the case that was tried.
 */
#ifndef HBIL_TEST_STRESS_H
#define HBIL_TEST_STRESS_H

#include <stdio.h>

#include "test/support/random.h"
#include "test/support/stages.h"

#define WIDTH 64
#define HEIGHT 48
#define PIXELS (WIDTH * HEIGHT)

typedef struct stress_settings {
  uint64_t seed;
  double seconds; /* 0: the short form of `make check` */
} stress_settings;

/* Read from the environment before main() runs. */
extern stress_settings stress_effort;

/* The case that is being tried, for the message of a failure. */
extern char stress_case[2048];
#define STRESS_CASE(...) snprintf(stress_case, sizeof stress_case, __VA_ARGS__)
/* check_at_most(), and prints the case on failure. */
void check_case(const char *what, double value, double limit);

/* --- plans: few, since each takes seconds to compile --- */

typedef enum plan_kind {
  PLAIN_SH,       /* float32, far field from SH, one pixel a work-item */
  PLAIN_ESTIMATE, /* float32, unseen light estimated, motion vectors */
  PACKED_SH,      /* the same two, packed */
  PACKED_ESTIMATE,
  PLANS,
  ONE_SAMPLE = PLANS, /* AO of one sample a side; only composite reads albedo,
                         F0, direct light and emission */
  ALL_PLANS
} plan_kind;

extern const char *const stress_plan_names[PLANS];
bool stress_is_packed(plan_kind kind);
/* Whether this form of the tests runs that plan: the short form runs two. */
bool stress_tries(plan_kind kind);
void stress_one_sample(setup *s);
/* A plan before its first frame, with the room as input; owned by this module.
 */
setup *stress_begin(plan_kind kind);
void stress_load_room(setup *s, uint32_t index);
/* Turns the input's normals from world space into view space. */
void stress_normals_to_view(setup *s);
/* Uploads and runs a frame. */
void stress_run(setup *s);

/* --- checks --- */

/* Everything that holds for any frame: outputs are finite and in range, and so
 * are the stages. */
void check_sane(setup *s);

#endif
