/*
 * The same frames give the same bits: on every run, with any number of threads,
 * with work-groups of any size.
 */
#define _POSIX_C_SOURCE 200809L /* popen, setenv */
#include "test/support/fixture.h"
#include "test/support/shim.h"

#include <inttypes.h>
#include <stdio.h>

/* Enough work-groups to occupy two threads in every pass; more than two spans
 * across. */
#define WIDTH 141
#define HEIGHT 67
#define FRAMES 3

/* Every pass in every form that vector widths select. */
typedef struct kind {
  const char *name;
  hbil_reprojection reprojection;
  cl_uint vector_width; /* 0: the device's own */
} kind;

static const kind kinds[] = {
    {"camera", HBIL_REPROJECTION_CAMERA, 0},
    {"camera, a pixel a work-item", HBIL_REPROJECTION_CAMERA, 1},
    {"motion", HBIL_REPROJECTION_MOTION, 0},
    {"motion, a pixel a work-item", HBIL_REPROJECTION_MOTION, 1},
    /* for work-groups alone */
    {"no history, a pixel a work-item", HBIL_REPROJECTION_NONE, 1},
    {"camera, 4 pixels a work-item", HBIL_REPROJECTION_CAMERA, 4},
    {"camera, 16 pixels a work-item", HBIL_REPROJECTION_CAMERA, 16},
};
enum {
  CAMERA,
  CAMERA_1,
  MOTION,
  MOTION_1,
  KINDS,
  NONE_1 = KINDS,
  CAMERA_4,
  CAMERA_16
};

static void start(setup *s, const kind *k) {
  setup_every_pass(s, k->reprojection, k->vector_width, WIDTH, HEIGHT);
  /* the filter takes longest to compile; the others cover it */
  s->config.sampling.unfiltered =
      k->reprojection == HBIL_REPROJECTION_MOTION || k->vector_width > 1;
  /* all but the plans that cache horizons */
  if (k->vector_width > 1)
    s->config.outputs.glossy = three_floats;
  setup_start(s);
}

/* FNV-1a of all bytes of all outputs. */
static uint64_t add_outputs(setup *s, uint64_t hash) {
  for (plane_id id = PLANE_FIRST_OUTPUT; id < PLANE_COUNT; ++id) {
    size_t size;
    if (!plane_slot(&s->frame, id)->buffer)
      continue;
    unsigned char *bytes =
        buffer_bytes(s->device, plane_slot(&s->frame, id)->buffer, &size);
    for (size_t i = 0; i < size; ++i)
      hash = (hash ^ bytes[i]) * 0x100000001b3u;
    free(bytes);
  }
  return hash;
}

/* A sequence from its first frame on, with a moving camera. */
static uint64_t hash_of_sequence(setup *s) {
  uint64_t hash = 0xcbf29ce484222325u;
  hbil_plan_reset(s->plan);
  for (uint32_t i = 0; i < FRAMES; ++i) {
    setup_load_scene(s, SCENE_ROOM, 2 * i);
    s->frame.frame_index = i;
    setup_upload(s);
    setup_run(s, hbil_enqueue_frame);
    hash = add_outputs(s, hash);
  }
  return hash;
}

/* ------------------------------------------------------------------------ */
/* Runs                                                                      */

#define RUNS 8

static void check_hash(uint64_t got, uint64_t want, const char *name,
                       const char *how) {
  if (got != want)
    fail_msg("%s: other bits %s", name, how);
}

TEST(every_run_gives_the_same_bits) {
  for (int k = 0; k < KINDS; ++k) {
    setup s;
    start(&s, &kinds[k]);
    const uint64_t want = hash_of_sequence(&s);
    for (int run = 1; run < RUNS; ++run)
      check_hash(hash_of_sequence(&s), want, kinds[k].name, "on another run");
    setup_free(&s);
  }
}

/* ------------------------------------------------------------------------ */
/* Threads: a process for each number, since PoCL asks but once              */

static const char *program;

/* What the other process does. */
static int print_hashes(void) {
  shared_device = device_open();
  for (int k = 0; k < KINDS; ++k) {
    setup s;
    start(&s, &kinds[k]);
    printf("%" PRIx64 "\n", hash_of_sequence(&s));
    setup_free(&s);
  }
  return device_finish(0);
}

static void hashes_with_threads(const char *threads, uint64_t hash[KINDS]) {
  char command[512];
  setenv("POCL_MAX_PTHREAD_COUNT", threads, 1);
  snprintf(command, sizeof command, "'%s' hashes", program);
  FILE *other = popen(command, "r");
  assert_non_null(other);
  for (int k = 0; k < KINDS; ++k)
    assert_int_equal(fscanf(other, "%" SCNx64, &hash[k]), 1);
  assert_int_equal(pclose(other), 0);
}

TEST(one_thread_and_two_give_the_same_bits) {
  uint64_t one[KINDS], two[KINDS];
  hashes_with_threads("1", one);
  hashes_with_threads("2", two);
  for (int k = 0; k < KINDS; ++k)
    check_hash(two[k], one[k], kinds[k].name, "with two threads");
}

/* ------------------------------------------------------------------------ */
/* Work-groups                                                               */

/* The library uses groups of 16 x 1 on CPUs and 32 x 4 elsewhere, and their
 * rows run in order; here they run from the last to the first. PoCL compiles
 * kernels again for each size. Kernels of single pixels compile fastest, so
 * vectors are left to the long form (`make stress`). */
static const struct {
  int kind;
  size_t group[2];
} groupings[] = {{CAMERA_1, {16, 1}}, {CAMERA_1, {32, 4}}, {CAMERA_1, {7, 3}},
                 {MOTION_1, {32, 4}}, {NONE_1, {7, 3}},    {CAMERA, {7, 3}},
                 {CAMERA_4, {5, 2}},  {CAMERA_16, {3, 4}}, {MOTION, {7, 3}}};
enum { SHORT = 5, GROUPINGS = sizeof groupings / sizeof *groupings };

TEST(every_work_group_gives_the_same_bits) {
  const int count = getenv("HBIL_STRESS_SECONDS") ? GROUPINGS : SHORT;
  for (int i = 0; i < count; ++i) {
    const kind *k = &kinds[groupings[i].kind];
    setup s;
    start(&s, k);
    const uint64_t want = hash_of_sequence(&s);
    shim_use_groups(groupings[i].group);
    check_hash(hash_of_sequence(&s), want, k->name, "with other work-groups");
    shim_use_groups(NULL);
    setup_free(&s);
  }
}

int main(int argc, char **argv) {
  program = argv[0];
  return argc > 1 ? print_hashes() : run_with_device();
}
