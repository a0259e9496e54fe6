/*
 * What a cache knows: views that are odd but valid do no harm, nothing is shown
 * before an update, and saved bytes bring all of it back.
 */
#include "test/support/cache.h"
#include "test/support/room.h"
#include "test/support/shim.h"

#include "lib/cache_args.h"

/* ------------------------------------------------------------------------ */
/* Odd views                                                                 */

static void assert_finite(setup *s, const char *what) {
  exact_planes out = room_outputs(s);
  const size_t pixels = setup_pixels(s);
  for (size_t i = 0; i < pixels * EXACT_AO; ++i)
    if (!isfinite(out.values[i]) || out.values[i] < 0.0 ||
        out.values[i] > 100.0)
      fail_msg("%s: E is %g", what, out.values[i]);
  exact_planes_free(&out);
}

static void inject_odd(room_scene *t, const hbil_view *view, const char *what) {
  room_inject(&shared_device, t->s.frame.cache, view, 1, 1);
  const hbil_cache_counts n = room_statistics(&shared_device, t->s.frame.cache);
  assert_int_equal(n.unseen + n.empty + n.surfaces, (size_t)32 * 32 * 32 * 2);
  assert_finite(&t->s, what);
}

TEST(odd_views_do_no_harm) {
  static const int sizes[][2] = {{1, 1}, {16384, 1}, {1, 16384}, {5, 3}};
  const double in_wall[3] = {1.6, 0.0, 0.0}, outside[3] = {0.0, 0.0, -60.0};
  const room r = room_lit();
  room_scene t;
  room_start(&t);
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
    for (int light = 0; light < 2; ++light) {
      const int width = sizes[i][0], height = sizes[i][1];
      const hbil_camera camera =
          room_camera(room_middle, (wall)i, width, height, 90.0);
      hbil_view view =
          room_view(&shared_device, &r, &camera, HBIL_PROJECTION_PERSPECTIVE,
                    width, height, (hbil_view_light)light);
      inject_odd(&t, &view, "an odd size");
      view.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
      inject_odd(&t, &view, "an odd size, orthographic");
      room_view_free(&view);
    }
  for (int towards = 0; towards < WALLS; ++towards) {
    const hbil_camera camera =
        room_camera(in_wall, (wall)towards, 32, 32, 90.0);
    hbil_view view =
        room_view(&shared_device, &r, &camera, HBIL_PROJECTION_PERSPECTIVE, 32,
                  32, HBIL_VIEW_DIRECT);
    inject_odd(&t, &view, "a camera in a wall");
    room_view_free(&view);
  }
  const hbil_camera camera = room_camera(outside, AHEAD, 32, 32, 5.0);
  hbil_view view =
      room_view(&shared_device, &r, &camera, HBIL_PROJECTION_PERSPECTIVE, 32,
                32, HBIL_VIEW_DIRECT);
  inject_odd(&t, &view, "a camera outside");
  room_view_free(&view);
  room_stop(&t);
}

/* A view that shows nothing of the extent changes nothing, wherever it is. */
TEST(views_of_other_places_change_nothing) {
  static const double far_away[] = {1e3, 1e6, 1e9, 1e15};
  room_scene t;
  room_start(&t);
  for (size_t i = 0; i < sizeof far_away / sizeof *far_away; ++i) {
    hbil_view view = t.views[AHEAD];
    view.camera.world_from_view[11] += far_away[i];
    assert_success(&t.s, room_try(&t, &view, 1, NULL));
    hbil_cache_update u = cache_bounces(0);
    assert_success(&t.s, hbil_enqueue_cache_update(t.s.frame.cache,
                                                   shared_device.queue, &u, 0,
                                                   NULL, NULL));
    room_same_bits(&t.s, &t.want, "a view of another place");
  }
  room_stop(&t);
}

/* What was injected is not lit before an update.  Buffers are full of
 * not-a-numbers at first, and of old light after a reset or a move. */
TEST(nothing_is_shown_before_an_update) {
  const double elsewhere[3] = {1e6, 0.0, 0.0};
  room_scene t;
  room_start(&t);
  hbil_cache *const first = t.s.frame.cache;
  shim_guard_buffers(true);
  t.s.frame.cache = room_cache(&shared_device);
  shim_guard_buffers(false);
  assert_success(&t.s, room_try(&t, t.views, WALLS, NULL));
  exact_planes want = room_outputs(&t.s);
  assert_finite(&t.s, "a new cache without an update");
  assert_true(largest_value(&want, EXACT_FAR_IRRADIANCE, 3) == 0.0);
  hbil_cache_destroy(t.s.frame.cache);
  t.s.frame.cache = first;
  assert_success(&t.s, hbil_enqueue_cache_reset(first, shared_device.queue, 0,
                                                NULL, NULL));
  assert_success(&t.s, room_try(&t, t.views, WALLS, NULL));
  room_same_bits(&t.s, &want, "a reset cache without an update");
  room_inject(&shared_device, first, NULL, 0, 2);
  for (int i = 0; i < 2; ++i)
    assert_success(&t.s, hbil_enqueue_cache_move(first, shared_device.queue,
                                                 i ? room_middle : elsewhere, 0,
                                                 NULL, NULL));
  assert_success(&t.s, room_try(&t, t.views, WALLS, NULL));
  room_same_bits(&t.s, &want, "a moved cache without an update");
  exact_planes_free(&want);
  room_stop(&t);
}

/* Every plane in turn holds NaN, infinities and values that are far too large,
 * at every third pixel and at all. */
TEST(views_of_nonsense_leave_frames_finite) {
  static const float nonsense[] = {NAN,    INFINITY, -INFINITY, 3e38f,
                                   -3e38f, 1e-42f,   0.0f,      -1.0f};
  room_scene t;
  room_start(&t);
  for (int p = 0; p < 5; ++p)
    for (size_t k = 0; k < sizeof nonsense / sizeof *nonsense; ++k)
      for (int every = 1; every <= 3; every += 2) {
        const room r = room_lit();
        const hbil_camera camera =
            room_camera(room_middle, (wall)(k % WALLS), 32, 32, 90.0);
        hbil_view view =
            room_view(&shared_device, &r, &camera, HBIL_PROJECTION_PERSPECTIVE,
                      32, 32, k % 2 ? HBIL_VIEW_DIRECT : HBIL_VIEW_FINISHED);
        hbil_plane *const planes[] = {&view.depth, &view.normal, &view.albedo,
                                      &view.direct, &view.emission};
        size_t size;
        unsigned char *bytes =
            buffer_bytes(&shared_device, planes[p]->buffer, &size);
        for (size_t i = 0; i < size / sizeof(float); i += (size_t)every)
          memcpy(bytes + i * sizeof(float), &nonsense[k], sizeof(float));
        buffer_write(&shared_device, planes[p]->buffer, 0, size, bytes);
        free(bytes);
        room_inject(&shared_device, t.s.frame.cache, &view, 1, 3);
        exact_planes out = room_outputs(&t.s);
        for (size_t i = 0; i < setup_pixels(&t.s) * EXACT_AO; ++i)
          if (!isfinite(out.values[i]) || out.values[i] < 0.0)
            fail_msg("plane %d, %g: E is %g", p, (double)nonsense[k],
                     out.values[i]);
        exact_planes_free(&out);
        room_view_free(&view);
      }
  room_stop(&t);
}

/* ------------------------------------------------------------------------ */
/* Saved bytes                                                               */

typedef struct saved {
  unsigned char *bytes;
  size_t size;
} saved;

static saved save(const setup *s) {
  saved v = {NULL, hbil_cache_size(s->frame.cache)};
  v.bytes = malloc(v.size);
  assert_non_null(v.bytes);
  assert_success(
      s, hbil_cache_save(s->frame.cache, s->device->queue, v.bytes, v.size));
  return v;
}

static void update_once(const setup *s, hbil_cache *cache) {
  assert_success(s, hbil_enqueue_cache_update(cache, s->device->queue, NULL, 0,
                                              NULL, NULL));
}

/* The next frames of a cache that took the bytes are those of the cache that
 * gave them, bounces included, and its room_middle is that one's, too. */
TEST(saved_bytes_give_the_same_frames) {
  const double centre[3] = {0.25, 0.0, -0.25}, elsewhere[3] = {50.0, 0.0, 0.0};
  room_scene t;
  room_start(&t);
  hbil_cache *const first = t.s.frame.cache, *second;
  assert_success(&t.s, hbil_enqueue_cache_move(first, shared_device.queue,
                                               centre, 0, NULL, NULL));
  saved v = save(&t.s);
  saved again = save(&t.s);
  assert_memory_equal(again.bytes, v.bytes, v.size);
  update_once(&t.s, first);
  exact_planes want = room_outputs(&t.s);
  assert_true(count_different(&want, &t.want) > 0); /* one bounce more */
  t.s.frame.cache = second = room_cache(&shared_device);
  assert_int_equal(hbil_cache_size(second), v.size);
  assert_success(&t.s, hbil_enqueue_cache_move(second, shared_device.queue,
                                               elsewhere, 0, NULL, NULL));
  for (int i = 0; i < 2; ++i) {
    assert_success(
        &t.s, hbil_cache_load(second, shared_device.queue, v.bytes, v.size));
    update_once(&t.s, second);
    room_same_bits(&t.s, &want, "a cache that took the bytes");
    room_inject(&shared_device, second, t.views, WALLS, 2); /* load it anew */
  }
  hbil_cache_destroy(second);
  t.s.frame.cache = first;
  exact_planes_free(&want);
  free(v.bytes);
  free(again.bytes);
  room_stop(&t);
}

/* A frame right after it was loaded, without an update. */
TEST(a_loaded_cache_shows_what_the_saved_one_did) {
  room_scene t;
  room_start(&t);
  hbil_cache *const first = t.s.frame.cache;
  saved v = save(&t.s);
  t.s.frame.cache = room_cache(&shared_device);
  assert_success(&t.s, hbil_cache_load(t.s.frame.cache, shared_device.queue,
                                       v.bytes, v.size));
  room_same_bits(&t.s, &t.want, "right after loading");
  hbil_cache_destroy(t.s.frame.cache);
  t.s.frame.cache = first;
  free(v.bytes);
  room_stop(&t);
}

/* Bounces under a sky, with places that no view has seen: what these get
 * depends on what surfaces have told of the sky. */
TEST(saved_bytes_have_what_bounces_need) {
  hbil_cache_update u;
  room_scene t;
  room_start(&t);
  hbil_cache *const first = t.s.frame.cache;
  hbil_cache_update_init(&u);
  u.far_field = HBIL_FAR_FRAME;
  u.environment[0][0] = u.environment[0][1] = u.environment[0][2] = 0.5f;
  u.bounces = 3;
  assert_success(&t.s, hbil_enqueue_cache_reset(first, shared_device.queue, 0,
                                                NULL, NULL));
  room_inject(&shared_device, first, t.views, 2, 0);
  room_inject(&shared_device, first, &t.views[BEHIND], 1, 0);
  assert_success(&t.s, hbil_enqueue_cache_update(first, shared_device.queue, &u,
                                                 0, NULL, NULL));
  saved v = save(&t.s);
  assert_success(&t.s, hbil_enqueue_cache_update(first, shared_device.queue, &u,
                                                 0, NULL, NULL));
  exact_planes want = room_outputs(&t.s);
  assert_true(largest_value(&want, EXACT_FAR_IRRADIANCE, 3) > 0.01);
  t.s.frame.cache = room_cache(&shared_device);
  assert_success(&t.s, hbil_cache_load(t.s.frame.cache, shared_device.queue,
                                       v.bytes, v.size));
  assert_success(&t.s,
                 hbil_enqueue_cache_update(t.s.frame.cache, shared_device.queue,
                                           &u, 0, NULL, NULL));
  room_same_bits(&t.s, &want, "bounces after loading");
  hbil_cache_destroy(t.s.frame.cache);
  t.s.frame.cache = first;
  exact_planes_free(&want);
  free(v.bytes);
  room_stop(&t);
}

static void reject_bytes(room_scene *t, const saved *v, const char *what) {
  room_rejected(
      hbil_cache_load(t->s.frame.cache, shared_device.queue, v->bytes, v->size),
      HBIL_INVALID_ARGUMENT, what);
}

/* Nothing of what was in the device's memory before is saved. */
TEST(saved_bytes_hold_nothing_else) {
  room_scene t;
  room_start(&t);
  hbil_cache *const first = t.s.frame.cache;
  assert_success(&t.s, hbil_enqueue_cache_reset(first, shared_device.queue, 0,
                                                NULL, NULL));
  room_inject(&shared_device, first, t.views, 1, 1);
  saved want = save(&t.s);
  for (int guarded = 0; guarded < 2; ++guarded) {
    shim_guard_buffers(guarded); /* full of not-a-numbers */
    t.s.frame.cache = room_cache(&shared_device);
    shim_guard_buffers(false);
    room_inject(&shared_device, t.s.frame.cache, t.views, 1, 1);
    saved got = save(&t.s);
    assert_memory_equal(got.bytes, want.bytes, want.size);
    free(got.bytes);
    hbil_cache_destroy(t.s.frame.cache);
  }
  t.s.frame.cache = first;
  free(want.bytes);
  room_stop(&t);
}

/* Any damaged byte is found: one of the head, one of each part, the last. */
TEST(damaged_bytes_change_nothing) {
  room_scene t;
  room_start(&t);
  saved v = save(&t.s);
  for (int bit = 0; bit < 8; bit += 7)
    for (size_t i = 0; i <= 97; ++i) {
      const size_t at = i <= 64 ? 2 * i : (v.size - 1) / 97 * i;
      v.bytes[at] ^= (unsigned char)(1 << bit);
      reject_bytes(&t, &v, "bytes");
      v.bytes[at] ^= (unsigned char)(1 << bit);
    }
  v.bytes[v.size - 1] ^= 1;
  reject_bytes(&t, &v, "bytes: damaged");
  v.bytes[v.size - 1] ^= 1;
  memset(v.bytes, 0, 8); /* of another version, or another file */
  reject_bytes(&t, &v, "not a cache");
  --v.size;
  reject_bytes(&t, &v, "size");
  v.size += 2;
  reject_bytes(&t, &v, "size");
  v.size = 0;
  reject_bytes(&t, &v, "size");
  room_same_bits(&t.s, &t.want, "after damaged bytes");
  free(v.bytes);
  room_stop(&t);
}

/* As hash_of_saved() of the library: anyone can make a file with a right hash.
 */
static void sign(saved *v) {
  cl_ulong hash = 0xcbf29ce484222325u, word;
  hbil_cache_saved_head head;
  memcpy(&head, v->bytes, sizeof head);
  head.hash = 0;
  memcpy(v->bytes, &head, sizeof head);
  for (size_t at = 0; at < v->size; at += sizeof word) {
    memcpy(&word, v->bytes + at, sizeof word);
    hash = (hash ^ word) * 0x100000001b3u;
    hash ^= hash >> 29;
  }
  head.hash = hash;
  memcpy(v->bytes, &head, sizeof head);
}

static void check_forged(room_scene *t, const saved *v, float value,
                         int member) {
  assert_success(&t->s, hbil_cache_load(t->s.frame.cache, shared_device.queue,
                                        v->bytes, v->size));
  for (int k = 0; k < 3; ++k) {
    exact_planes out = room_outputs(&t->s);
    for (size_t i = 0; i < count_values(&out); ++i)
      if (!isfinite(out.values[i]))
        fail_msg("float %d is %g: value %zu of the outputs is %g", member,
                 (double)value, i, out.values[i]);
    exact_planes_free(&out);
    update_once(&t->s, t->s.frame.cache); /* and its bounces */
  }
}

/* Another plan for the same cache, which has every output that asks it. */
static void ask_for_all_outputs(room_scene *t) {
  const double eye[3] = {0.1, 0.2, -1.0};
  hbil_cache *const cache = t->s.frame.cache;
  const room r = room_lit();
  const hbil_camera camera =
      room_camera(eye, AHEAD, ROOM_WIDTH, ROOM_HEIGHT, 75.0);
  setup_free(&t->s);
  room_setup(&t->s, &r, &camera, ROOM_WIDTH, ROOM_HEIGHT);
  setup_all_outputs(&t->s);
  t->s.config.outputs.glossy = three_floats;
  t->s.config.sampling.slices = 1;
  t->s.config.sampling.steps_per_side = 4;
  setup_start(&t->s);
  t->s.frame.cache = cache;
}

/* Every float of every voxel in turn is nonsense, and one time all voxels are
 * said to be surfaces. */
TEST(forged_bytes_leave_frames_finite) {
  static const float nonsense[] = {NAN,   INFINITY, -INFINITY,
                                   3e38f, -3e38f,   1.0f};
  const size_t voxels = (size_t)32 * 32 * 32 * 2;
  room_scene t;
  room_start(&t);
  ask_for_all_outputs(&t);
  saved v = save(&t.s);
  unsigned char *floats = v.bytes + v.size - 64 * voxels;
  unsigned char *plain = malloc(v.size);
  assert_non_null(plain);
  memcpy(plain, v.bytes, v.size);
  for (int member = 0; member < HBIL_VOXEL_FLOATS; ++member)
    for (size_t k = 0; k < sizeof nonsense / sizeof *nonsense; ++k) {
      memcpy(v.bytes, plain, v.size);
      for (size_t i = 0; i < voxels; ++i)
        memcpy(floats + 64 * i + 4 * (size_t)member, &nonsense[k], 4);
      if (member % 2)
        memset(v.bytes + sizeof(hbil_cache_saved_head), 0xaa, voxels / 4);
      sign(&v);
      check_forged(&t, &v, nonsense[k], member);
    }
  free(plain);
  free(v.bytes);
  room_stop(&t);
}

/* A middle near the end of 64 bits would overflow in the next move. */
TEST(bytes_from_beyond_are_rejected) {
  room_scene t;
  room_start(&t);
  saved v = save(&t.s);
  hbil_cache_saved_head head;
  memcpy(&head, v.bytes, sizeof head);
  head.middle[1] = INT64_MIN;
  memcpy(v.bytes, &head, sizeof head);
  sign(&v);
  reject_bytes(&t, &v, "2^52 voxels away");
  room_same_bits(&t.s, &t.want, "after bytes from beyond");
  free(v.bytes);
  room_stop(&t);
}

TEST(bytes_of_other_caches_change_nothing) {
  room_scene t;
  room_start(&t);
  for (int i = 0; i < 3; ++i) {
    hbil_cache_config config = room_cache_config();
    hbil_cache *other;
    config.voxels = i == 0 ? 16 : 32;
    config.levels = i == 1 ? 1 : 2;
    config.voxel_size = i == 2 ? 0.25 : ROOM_VOXEL;
    assert_success(&t.s,
                   hbil_cache_create(shared_device.hbil, &config, &other));
    setup s = t.s;
    s.frame.cache = other;
    saved v = save(&s);
    reject_bytes(&t, &v, i < 2 ? "size" : "voxel_size");
    free(v.bytes);
    hbil_cache_destroy(other);
  }
  room_same_bits(&t.s, &t.want, "after other caches' bytes");
  room_stop(&t);
}
