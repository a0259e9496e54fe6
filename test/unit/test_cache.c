/*
 * The radiance cache as its header describes it: an empty one changes nothing,
 * and views, moves and saved bytes give the same bits whatever the order, the
 * number of threads and the work-groups.
 */
#define _POSIX_C_SOURCE 200809L /* popen, setenv */
#include "test/support/room.h"
#include "test/support/shim.h"

#include <inttypes.h>
#include <stdio.h>

#define WIDTH 72
#define HEIGHT 44

static const double middle[3] = {0.0, 0.0, 0.0};

/* One wall is behind the camera, and lit; so is a part of what it sees. */
static room lit_room(void) {
  room r = room_dark();
  r.direct[BEHIND] = 5.0f;
  r.direct[CEILING] = 1.0f;
  r.emission[LEFT] = 0.25f;
  return r;
}

static hbil_camera frame_camera(void) {
  const double eye[3] = {0.1, 0.2, -1.0};
  return room_camera(eye, AHEAD, WIDTH, HEIGHT, 75.0);
}

/* The frame of these tests, with few samples: none is about the light. */
static void start(setup *s) {
  const room r = lit_room();
  const hbil_camera camera = frame_camera();
  room_setup(s, &r, &camera, WIDTH, HEIGHT);
  s->config.sampling.slices = 1;
  s->config.sampling.steps_per_side = 4;
  s->config.sampling.unfiltered = CL_TRUE;
  setup_start(s);
}

/* ------------------------------------------------------------------------ */
/* An empty cache                                                            */

static void prepare_empty(setup *s, hbil_far_field far_field, cl_uint width,
                          bool flat) {
  const room r = lit_room();
  const hbil_camera camera = frame_camera();
  room_setup(s, &r, &camera, WIDTH, HEIGHT);
  setup_all_outputs(s);
  s->config.inputs.projection =
      flat ? HBIL_PROJECTION_ORTHOGRAPHIC : HBIL_PROJECTION_PERSPECTIVE;
  setup_load_scene(s, SCENE_ROOM, 0);
  s->config.model.far_field = far_field;
  s->config.model.cache_method = HBIL_CACHE_METHOD_NONE;
  s->config.model.radius = INFINITY;
  s->config.model.relative_thickness = 1.0f;
  s->config.history.reprojection = HBIL_REPROJECTION_CAMERA;
  s->config.execution.vector_width = width;
  s->config.sampling.slices = 1;
  s->config.sampling.steps_per_side = 4;
  s->config.sampling.unfiltered = CL_TRUE;
  for (int i = 0; i < (far_field == HBIL_FAR_SH ? 9 : 1); ++i)
    for (int c = 0; c < 3; ++c)
      s->frame.environment[i][c] =
          far_field == HBIL_FAR_NONE ? 0.0f : 0.5f + 0.125f * (float)(i + c);
}

/* Two frames of a sequence; the second one has carried light. */
static exact_planes two_frames(setup *s) {
  hbil_plan_reset(s->plan);
  setup_run(s, hbil_enqueue_frame);
  return room_outputs(s);
}

static void check_two_frames(setup *s, const exact_planes *want,
                             const char *what) {
  exact_planes got = two_frames(s);
  const size_t different = count_different(&got, want);
  exact_planes_free(&got);
  if (different)
    fail_msg("%s, far field %d, width %u, projection %d: %zu values differ",
             what, (int)s->config.model.far_field,
             (unsigned)s->config.execution.vector_width,
             (int)s->config.inputs.projection, different);
}

static void check_empty(hbil_far_field far_field, cl_uint width, bool flat) {
  setup without, with;
  prepare_empty(&without, far_field, width, flat);
  prepare_empty(&with, far_field, width, flat);
  with.config.model.cache_method = HBIL_CACHE_METHOD_RAYS;
  setup_start(&without);
  setup_start(&with);
  exact_planes want = two_frames(&without);
  assert_true(largest_value(&want, EXACT_NEAR_IRRADIANCE, 3) > 0.01);
  check_two_frames(&with, &want, "no cache");
  hbil_cache *cache = room_cache(&shared_device);
  with.frame.cache = cache;
  check_two_frames(&with, &want, "a new cache");
  room_inject(&shared_device, cache, NULL, 0, 3);
  check_two_frames(&with, &want, "a cache without views");
  const room r = lit_room();
  hbil_view views[WALLS];
  room_views(&shared_device, &r, middle, 24, HBIL_VIEW_FINISHED, views);
  room_inject(&shared_device, cache, views, WALLS, 0);
  exact_planes filled = two_frames(&with);
  assert_true(count_different(&filled, &want) > 0);
  assert_success(&with, hbil_enqueue_cache_reset(cache, shared_device.queue, 0,
                                                 NULL, NULL));
  check_two_frames(&with, &want, "a cache that was reset");
  room_views_free(views, WALLS);
  planes_free(&filled, &want);
  hbil_cache_destroy(cache);
  setup_free(&without);
  setup_free(&with);
}

TEST(an_empty_cache_changes_no_far_field) {
  for (int far_field = HBIL_FAR_NONE; far_field <= HBIL_FAR_FRAME; ++far_field)
    for (int flat = 0; flat < 2; ++flat)
      check_empty((hbil_far_field)far_field, 1, flat);
}

/* The far field of the frame has the longest kernels, and each width takes one
 * projection, of which the kernels know by a few branches.  All combinations
 * follow in the long form (make stress). */
TEST(an_empty_cache_changes_no_vector_width) {
  static const cl_uint widths[] = {4, 8, 16};
  const bool all = getenv("HBIL_STRESS_SECONDS") != NULL;
  const int first = all ? HBIL_FAR_NONE : HBIL_FAR_FRAME;
  for (int far_field = first; far_field <= HBIL_FAR_FRAME; ++far_field)
    for (int i = 0; i < 3; ++i)
      for (int flat = 0; flat < 2; ++flat)
        if (all || flat == (i & 1))
          check_empty((hbil_far_field)far_field, widths[i], flat);
}

/* ------------------------------------------------------------------------ */
/* The order of views                                                        */

/* Views of different cameras, sizes, projections and kinds of light, of which
 * several show the same voxels with other values. */
enum { MIXED = 7 };

static void mixed_views(hbil_view views[MIXED]) {
  for (int i = 0; i < MIXED; ++i) {
    const double eye[3] = {0.2 * i - 0.6, 0.1 * i - 0.3, 0.3 - 0.15 * i};
    const wall towards = i % 2 ? BEHIND : LEFT;
    const bool flat = i == 3;
    const hbil_camera camera =
        flat ? room_flat_camera(eye, towards, 60, 50, 3.0)
             : room_camera(eye, towards, 60 + i / 4, 50, 80.0 + i);
    room r = lit_room();
    for (int k = 0; k < WALLS; ++k)
      r.direct[k] = 0.3f * (float)(i + 1) + 0.17f * (float)k;
    views[i] = room_view(
        &shared_device, &r, &camera,
        flat ? HBIL_PROJECTION_ORTHOGRAPHIC : HBIL_PROJECTION_PERSPECTIVE,
        60 + i / 4, 50,
        i == 1 || i == 4 ? HBIL_VIEW_FINISHED : HBIL_VIEW_DIRECT);
  }
}

/* All that a cache knows; the caller frees. */
static unsigned char *saved_bytes(const setup *s) {
  const size_t size = hbil_cache_size(s->frame.cache);
  unsigned char *bytes = malloc(size);
  assert_non_null(bytes);
  assert_success(
      s, hbil_cache_save(s->frame.cache, s->device->queue, bytes, size));
  return bytes;
}

/* Frames read rounded light, so what the cache knows is compared as well. */
TEST(the_order_of_views_changes_no_bit) {
  static const int orders[][MIXED] = {
      {6, 5, 4, 3, 2, 1, 0}, {4, 0, 6, 1, 5, 2, 3}, {1, 4, 3, 6, 0, 5, 2}};
  hbil_view views[MIXED], shuffled[MIXED];
  setup s;
  start(&s);
  hbil_cache *cache = room_cache(&shared_device);
  s.frame.cache = cache;
  mixed_views(views);
  room_inject(&shared_device, cache, views, MIXED, 2);
  exact_planes want = room_outputs(&s);
  unsigned char *known = saved_bytes(&s);
  assert_true(largest_value(&want, EXACT_FAR_IRRADIANCE, 3) > 0.01);
  for (size_t i = 0; i < sizeof orders / sizeof *orders; ++i) {
    assert_success(&s, hbil_enqueue_cache_reset(cache, shared_device.queue, 0,
                                                NULL, NULL));
    for (int k = 0; k < MIXED; ++k)
      shuffled[k] = views[orders[i][k]];
    room_inject(&shared_device, cache, shuffled, MIXED, 2);
    room_same_bits(&s, &want, "another order");
    unsigned char *bytes = saved_bytes(&s);
    assert_memory_equal(bytes, known, hbil_cache_size(cache));
    free(bytes);
  }
  free(known);
  exact_planes_free(&want);
  room_views_free(views, MIXED);
  hbil_cache_destroy(cache);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* The same bits: runs, threads, work-groups                                 */

static uint64_t add_bytes(uint64_t hash, const void *bytes, size_t size) {
  for (size_t i = 0; i < size; ++i)
    hash = (hash ^ ((const unsigned char *)bytes)[i]) * 0x100000001b3u;
  return hash;
}

/* Everything that a cache does, from a reset on. */
static uint64_t hash_of_sequence(setup *s, const hbil_view views[MIXED]) {
  static const double places[2][3] = {{0.0, 0.0, 0.6}, {0.3, -0.3, 0.0}};
  uint64_t hash = 0xcbf29ce484222325u;
  hbil_cache_update update;
  hbil_cache_update_init(&update);
  update.phases = 3;
  assert_success(s, hbil_enqueue_cache_move(s->frame.cache, s->device->queue,
                                            middle, 0, NULL, NULL));
  assert_success(s, hbil_enqueue_cache_reset(s->frame.cache, s->device->queue,
                                             0, NULL, NULL));
  for (int i = 0; i < 2; ++i) {
    room_inject(s->device, s->frame.cache, views + 3 * i, 3 + (cl_uint)i, 2);
    assert_success(s,
                   hbil_enqueue_cache_update(s->frame.cache, s->device->queue,
                                             &update, 0, NULL, NULL));
    assert_success(s, hbil_enqueue_cache_move(s->frame.cache, s->device->queue,
                                              places[i], 0, NULL, NULL));
    exact_planes out = room_outputs(s);
    assert_true(largest_value(&out, EXACT_FAR_IRRADIANCE, 3) > 0.01);
    hash = add_bytes(hash, out.values, count_values(&out) * sizeof *out.values);
    exact_planes_free(&out);
  }
  unsigned char *saved = saved_bytes(s);
  hash = add_bytes(hash, saved, hbil_cache_size(s->frame.cache));
  free(saved);
  return hash;
}

typedef struct sequence {
  setup s;
  hbil_view views[MIXED];
} sequence;

static void start_sequence(sequence *q) {
  start(&q->s);
  q->s.frame.cache = room_cache(&shared_device);
  mixed_views(q->views);
}

static void end_sequence(sequence *q) {
  hbil_cache_destroy(q->s.frame.cache);
  room_views_free(q->views, MIXED);
  setup_free(&q->s);
}

TEST(every_run_gives_the_same_bits) {
  sequence q;
  start_sequence(&q);
  const uint64_t want = hash_of_sequence(&q.s, q.views);
  for (int i = 0; i < 4; ++i)
    assert_true(hash_of_sequence(&q.s, q.views) == want);
  end_sequence(&q);
  start_sequence(&q); /* in other memory */
  assert_true(hash_of_sequence(&q.s, q.views) == want);
  end_sequence(&q);
}

/* A process for each number of threads, since PoCL asks but once. */
static const char *program;

static int print_hash(void) {
  sequence q;
  shared_device = device_open();
  start_sequence(&q);
  printf("%" PRIx64 "\n", hash_of_sequence(&q.s, q.views));
  end_sequence(&q);
  return device_finish(0);
}

static uint64_t hash_with_threads(const char *threads) {
  char command[512];
  uint64_t hash = 0;
  setenv("POCL_MAX_PTHREAD_COUNT", threads, 1);
  snprintf(command, sizeof command, "'%s' hash", program);
  FILE *other = popen(command, "r");
  assert_non_null(other);
  assert_int_equal(fscanf(other, "%" SCNx64, &hash), 1);
  assert_int_equal(pclose(other), 0);
  return hash;
}

TEST(one_thread_and_two_give_the_same_bits) {
  assert_true(hash_with_threads("1") == hash_with_threads("2"));
}

TEST(every_work_group_gives_the_same_bits) {
  static const size_t groups[][2] = {{32, 4}, {7, 3}};
  sequence q;
  start_sequence(&q);
  const uint64_t want = hash_of_sequence(&q.s, q.views);
  for (size_t i = 0; i < sizeof groups / sizeof *groups; ++i) {
    shim_use_groups(groups[i]);
    const uint64_t got = hash_of_sequence(&q.s, q.views);
    shim_use_groups(NULL);
    assert_true(got == want);
  }
  end_sequence(&q);
}

/* ------------------------------------------------------------------------ */
/* Statistics                                                                */

static size_t voxels_of(const hbil_cache_counts *n) {
  return n->unseen + n->empty + n->surfaces;
}

#define ALL_VOXELS ((size_t)32 * 32 * 32 * 2)

/* What a view of 90 degrees from the middle to a wall sees is a sixth of the
 * room or a little more; the wall's voxels are two-dimensional. */
TEST(a_view_of_a_wall_shows_surfaces_and_empty_space) {
  const room r = lit_room();
  const hbil_camera camera = room_camera(middle, AHEAD, 64, 64, 90.0);
  hbil_cache *cache = room_cache(&shared_device);
  hbil_cache_counts n = room_statistics(&shared_device, cache);
  assert_int_equal(n.unseen, ALL_VOXELS);
  assert_int_equal(n.empty + n.surfaces, 0);
  hbil_view view =
      room_view(&shared_device, &r, &camera, HBIL_PROJECTION_PERSPECTIVE, 64,
                64, HBIL_VIEW_DIRECT);
  room_inject(&shared_device, cache, &view, 1, 0);
  n = room_statistics(&shared_device, cache);
  assert_int_equal(voxels_of(&n), ALL_VOXELS);
  /* of the finer level, the wall has 26 x 20 voxels, and the pyramid before it
   * some 3500; the coarser level adds a quarter and an eighth */
  assert_in_range(n.surfaces, 400, 4000);
  assert_in_range(n.empty, 1500, 6000);
  assert_true(n.unseen > ALL_VOXELS * 3 / 4);
  room_inject(&shared_device, cache, &view, 1, 0);
  const hbil_cache_counts again = room_statistics(&shared_device, cache);
  assert_memory_equal(&again, &n, sizeof n);
  room_view_free(&view);
  hbil_cache_destroy(cache);
}

/* ------------------------------------------------------------------------ */
/* Moves                                                                     */

/* The rays are the same, but for roundings (measured: 0). */
#define MOVED_LIMIT 1e-3

static void move_to(const setup *s, double x, double y, double z) {
  const double to[3] = {x, y, z};
  assert_success(s, hbil_enqueue_cache_move(s->frame.cache, s->device->queue,
                                            to, 0, NULL, NULL));
}

static exact_planes start_with_views(setup *s) {
  const room r = lit_room();
  start(s);
  s->frame.cache = room_cache(&shared_device);
  room_show(s->frame.cache, &r, 48, HBIL_VIEW_DIRECT, 2);
  exact_planes out = room_outputs(s);
  assert_true(largest_value(&out, EXACT_FAR_IRRADIANCE, 3) > 0.01);
  return out;
}

static void end_with_views(setup *s, exact_planes *out) {
  exact_planes_free(out);
  hbil_cache_destroy(s->frame.cache);
  setup_free(s);
}

TEST(an_equal_move_changes_nothing) {
  setup s;
  exact_planes want = start_with_views(&s);
  const double coarsest = 2.0 * ROOM_VOXEL;
  move_to(&s, 0.0, 0.0, 0.0);
  room_same_bits(&s, &want, "a move to where it is");
  move_to(&s, 0.4 * coarsest, -0.4 * coarsest, 0.4 * coarsest);
  room_same_bits(&s, &want, "a move by less than half a voxel");
  end_with_views(&s, &want);
}

/* Of 32 voxels, what moves out of a level by m coarse voxels each way is
 * forgotten there, and unseen when the cache is back; the room lies within the
 * middle 16 of the coarser level. */
TEST(a_move_and_back_keeps_what_stayed_inside) {
  setup s;
  exact_planes want = start_with_views(&s);
  const double coarsest = 2.0 * ROOM_VOXEL;
  const hbil_cache_counts before =
      room_statistics(&shared_device, s.frame.cache);
  /* all of the room stays in the finer level: 1.6 of 2, less 0.25 */
  move_to(&s, coarsest, 0.0, 0.0);
  exact_planes moved = room_outputs(&s);
  check_at_most("a move that leaves all inside",
                relative_rmse(&moved, &want, EXACT_FAR_IRRADIANCE, 3),
                MOVED_LIMIT);
  exact_planes_free(&moved);
  move_to(&s, 0.0, 0.0, 0.0);
  const hbil_cache_counts after =
      room_statistics(&shared_device, s.frame.cache);
  assert_int_equal(voxels_of(&after), ALL_VOXELS);
  assert_int_equal(after.surfaces, before.surfaces);
  room_same_bits(&s, &want, "a move that leaves all inside, and back");
  /* half of the finer level is forgotten, and nothing of the room in the
   * coarser one */
  move_to(&s, 8 * coarsest, 0.0, 0.0);
  const hbil_cache_counts away = room_statistics(&shared_device, s.frame.cache);
  assert_int_equal(voxels_of(&away), ALL_VOXELS);
  assert_true(away.surfaces < before.surfaces * 3 / 4);
  assert_true(away.surfaces > before.surfaces / 4);
  move_to(&s, 0.0, 0.0, 0.0);
  const hbil_cache_counts back = room_statistics(&shared_device, s.frame.cache);
  assert_memory_equal(&back, &away, sizeof back);
  end_with_views(&s, &want);
}

TEST(a_move_by_more_than_the_width_forgets_all) {
  static const double places[][3] = {
      {8.0, 0.0, 0.0}, {0.0, -8.0, 0.0}, {0.0, 0.0, 1e9}, {-1e12, 1e3, 0.0}};
  for (size_t i = 0; i < sizeof places / sizeof *places; ++i) {
    setup s;
    exact_planes want = start_with_views(&s);
    move_to(&s, places[i][0], places[i][1], places[i][2]);
    const hbil_cache_counts n = room_statistics(&shared_device, s.frame.cache);
    assert_int_equal(n.unseen, ALL_VOXELS);
    end_with_views(&s, &want);
  }
}

/* A cache whose middle is far from the origin works as one at the origin: the
 * room, its views and the cache move together. */
TEST(a_cache_far_away_is_as_good) {
  const double away[3] = {4096.0, -8192.0, 1024.0};
  const room r = lit_room();
  hbil_view views[WALLS];
  setup s;
  exact_planes want = start_with_views(&s);
  room_views(&shared_device, &r, middle, 48, HBIL_VIEW_DIRECT, views);
  for (int i = 0; i < 3; ++i) {
    s.frame.camera.world_from_view[4 * i + 3] += away[i];
    for (int k = 0; k < WALLS; ++k)
      views[k].camera.world_from_view[4 * i + 3] += away[i];
  }
  move_to(&s, away[0], away[1], away[2]);
  assert_success(&s, hbil_enqueue_cache_reset(
                         s.frame.cache, shared_device.queue, 0, NULL, NULL));
  room_inject(&shared_device, s.frame.cache, views, WALLS, 2);
  exact_planes got = room_outputs(&s);
  check_at_most("far from the origin",
                relative_rmse(&got, &want, EXACT_FAR_IRRADIANCE, 3),
                MOVED_LIMIT);
  exact_planes_free(&got);
  room_views_free(views, WALLS);
  end_with_views(&s, &want);
}

int main(int argc, char **argv) {
  program = argv[0];
  return argc > 1 ? print_hash() : run_with_device();
}
