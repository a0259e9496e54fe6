/*
 * What a cache rejects: each wrong setting, view, update and argument has a
 * message that names it, and changes nothing.
 */
#include "test/support/room.h"
#include "test/support/shim.h"

/* ------------------------------------------------------------------------ */
/* Configurations                                                            */

typedef struct bad_config {
  const char *field;
  void (*spoil)(hbil_cache_config *);
} bad_config;

#define SPOIL(name, statement)                                                 \
  static void name(hbil_cache_config *c) {                                     \
    statement;                                                                 \
  }
SPOIL(voxels_0, c->voxels = 0)
SPOIL(voxels_8, c->voxels = 8)
SPOIL(voxels_17, c->voxels = 17)
SPOIL(voxels_512, c->voxels = 512)
SPOIL(levels_0, c->levels = 0)
SPOIL(levels_5, c->levels = 5)
SPOIL(size_0, c->voxel_size = 0.0)
SPOIL(size_negative, c->voxel_size = -1.0)
SPOIL(size_nan, c->voxel_size = NAN)
SPOIL(size_infinite, c->voxel_size = INFINITY)
SPOIL(size_small, c->voxel_size = 1e-9)
SPOIL(size_huge, c->voxel_size = 1e9)
SPOIL(centre_nan, c->centre[0] = NAN)
SPOIL(centre_infinite, c->centre[1] = -INFINITY)
SPOIL(centre_huge, c->centre[2] = 1e300)
SPOIL(depth_image, c->inputs.depth.component = HBIL_IMAGE)
SPOIL(normal_image, c->inputs.normal.component = HBIL_IMAGE)
SPOIL(direct_image, c->inputs.direct.component = HBIL_IMAGE)
SPOIL(depth_missing, c->inputs.depth.component = HBIL_NONE)
SPOIL(normal_missing, c->inputs.normal.component = HBIL_NONE)
SPOIL(albedo_stride, c->inputs.albedo.stride = 2)
SPOIL(emission_unknown, c->inputs.emission.component = (hbil_component)99)
SPOIL(depth_scale_0, c->inputs.depth_scale = 0.0f)
SPOIL(normal_scale_nan, c->inputs.normal_scale[1] = NAN)
SPOIL(space_unknown, c->inputs.normal_space = (hbil_space)7)
SPOIL(emission_2, c->gather_emission = 2)
SPOIL(unseen_negative, c->unseen_light = -0.25f)
SPOIL(unseen_large, c->unseen_light = 1.5f)
SPOIL(unseen_nan, c->unseen_light = NAN)
SPOIL(struct_0, c->struct_size = 0)
SPOIL(struct_small, c->struct_size -= 8)
SPOIL(struct_large, c->struct_size += 8)

static const bad_config bad_configs[] = {{"voxels", voxels_0},
                                         {"voxels", voxels_8},
                                         {"voxels", voxels_17},
                                         {"voxels", voxels_512},
                                         {"levels", levels_0},
                                         {"levels", levels_5},
                                         {"voxel_size", size_0},
                                         {"voxel_size", size_negative},
                                         {"voxel_size", size_nan},
                                         {"voxel_size", size_infinite},
                                         {"voxel_size", size_small},
                                         {"voxel_size", size_huge},
                                         {"centre[0]", centre_nan},
                                         {"centre[1]", centre_infinite},
                                         {"centre[2]", centre_huge},
                                         {"inputs.depth", depth_image},
                                         {"inputs.normal", normal_image},
                                         {"inputs.direct", direct_image},
                                         {"inputs.depth", depth_missing},
                                         {"inputs.normal", normal_missing},
                                         {"albedo", albedo_stride},
                                         {"emission", emission_unknown},
                                         {"depth_scale", depth_scale_0},
                                         {"normal_scale[1]", normal_scale_nan},
                                         {"normal_space", space_unknown},
                                         {"gather_emission", emission_2},
                                         {"unseen_light", unseen_negative},
                                         {"unseen_light", unseen_large},
                                         {"unseen_light", unseen_nan},
                                         {"struct_size", struct_0},
                                         {"struct_size", struct_small},
                                         {"struct_size", struct_large}};

static void bad_configurations_are_rejected_by_name(void **state) {
  (void)state;
  for (size_t i = 0; i < sizeof bad_configs / sizeof *bad_configs; ++i) {
    hbil_cache_config c = room_cache_config();
    hbil_cache *cache = (hbil_cache *)&c;
    size_t bytes = 77;
    bad_configs[i].spoil(&c);
    const long held = shim_references();
    room_rejected(hbil_cache_memory(shared_device.hbil, &c, &bytes),
                  HBIL_INVALID_CONFIG, bad_configs[i].field);
    assert_int_equal(bytes, 77);
    room_rejected(hbil_cache_create(shared_device.hbil, &c, &cache),
                  HBIL_INVALID_CONFIG, bad_configs[i].field);
    assert_null(cache);
    assert_int_equal(shim_references(), held);
  }
}

static void defaults_are_those_of_the_header(void **state) {
  hbil_cache_config c;
  hbil_config plan;
  hbil_cache_update u;
  hbil_view v;
  (void)state;
  hbil_cache_config_init(&c);
  hbil_config_init(&plan);
  assert_int_equal(c.struct_size, sizeof c);
  assert_int_equal(c.voxels, 64);
  assert_int_equal(c.levels, 2);
  assert_true(c.voxel_size == 0.0);
  assert_memory_equal(c.centre, room_middle, sizeof room_middle);
  assert_memory_equal(&c.inputs, &plan.inputs, sizeof c.inputs);
  assert_int_equal(c.gather_emission, CL_TRUE);
  assert_true(c.unseen_light == 0.8f);
  hbil_cache_update_init(&u);
  assert_int_equal(u.rounds, 4);
  assert_int_equal(u.share, 1);
  assert_int_equal(u.far_field, HBIL_FAR_NONE);
  hbil_view_init(&v);
  assert_int_equal(v.struct_size, sizeof v);
  assert_int_equal(v.light, HBIL_VIEW_DIRECT);
  assert_null(v.depth.buffer);
}

/* ------------------------------------------------------------------------ */
/* Views                                                                     */

typedef struct bad_view {
  const char *field;
  void (*spoil)(hbil_view *);
} bad_view;

#define SPOIL_VIEW(name, statement)                                            \
  static void name(hbil_view *v) {                                             \
    statement;                                                                 \
  }
SPOIL_VIEW(width_0, v->width = 0)
SPOIL_VIEW(width_16385, v->width = 16385)
SPOIL_VIEW(height_0, v->height = 0)
SPOIL_VIEW(height_16385, v->height = 16385)
SPOIL_VIEW(projection_7, v->projection = (hbil_projection)7)
SPOIL_VIEW(light_7, v->light = (hbil_view_light)7)
SPOIL_VIEW(camera_nan, v->camera.cx = NAN)
SPOIL_VIEW(camera_fx, v->camera.fx = 0.0)
SPOIL_VIEW(camera_moved, v->camera.world_from_view[3] = NAN)
SPOIL_VIEW(camera_scaled, v->camera.world_from_view[0] = 1.5)
SPOIL_VIEW(camera_zero, memset(&v->camera, 0, sizeof v->camera))
SPOIL_VIEW(no_depth, v->depth.buffer = NULL)
SPOIL_VIEW(no_normal, v->normal.buffer = NULL)
SPOIL_VIEW(no_direct, v->direct.buffer = NULL)
SPOIL_VIEW(normal_small, v->normal.buffer = v->depth.buffer)
SPOIL_VIEW(too_high, v->height += 1)
SPOIL_VIEW(depth_misaligned, v->depth.offset = 2)
SPOIL_VIEW(offset_huge, v->depth.offset = SIZE_MAX - 3)
SPOIL_VIEW(view_size_small, v->struct_size -= 8)
SPOIL_VIEW(view_size_large, v->struct_size += 8)
SPOIL_VIEW(view_size_0, v->struct_size = 0)

static const bad_view bad_views[] = {{"width", width_0},
                                     {"width", width_16385},
                                     {"height", height_0},
                                     {"height", height_16385},
                                     {"projection", projection_7},
                                     {"light", light_7},
                                     {"cx", camera_nan},
                                     {"fx", camera_fx},
                                     {"world_from_view", camera_moved},
                                     {"world_from_view", camera_scaled},
                                     {"camera", camera_zero},
                                     {"depth", no_depth},
                                     {"normal", no_normal},
                                     {"direct", no_direct},
                                     {"normal", normal_small},
                                     {"depth", too_high},
                                     {"depth", depth_misaligned},
                                     {"depth", offset_huge},
                                     {"struct_size", view_size_small},
                                     {"struct_size", view_size_large},
                                     {"struct_size", view_size_0}};

/* Wrong as the only view, and behind a right one, which isn't injected then.
 * The right one has other light, so that it would be seen. */
static void bad_views_are_rejected_by_name(void **state) {
  room_scene t;
  room r = room_lit();
  (void)state;
  room_start(&t);
  r.direct[BEHIND] = 50.0f;
  const hbil_camera camera = room_camera(room_middle, BEHIND, 32, 32, 90.0);
  hbil_view good =
      room_view(&shared_device, &r, &camera, HBIL_PROJECTION_PERSPECTIVE, 32,
                32, HBIL_VIEW_FINISHED);
  const long made = shim_events_made();
  for (size_t i = 0; i < sizeof bad_views / sizeof *bad_views; ++i) {
    hbil_view views[2] = {good, t.views[0]};
    cl_event event = NULL;
    bad_views[i].spoil(&views[1]);
    room_rejected(room_try(&t, &views[1], 1, &event), HBIL_INVALID_FRAME,
                  bad_views[i].field);
    room_rejected(room_try(&t, views, 2, &event), HBIL_INVALID_FRAME,
                  bad_views[i].field);
    assert_null(event);
  }
  assert_int_equal(shim_events_made(), made);
  assert_success(
      &t.s, hbil_enqueue_cache_update(
                t.s.frame.cache, shared_device.queue,
                &(hbil_cache_update){
                    sizeof(hbil_cache_update), 0, 1, HBIL_FAR_NONE, {{0}}, 0},
                0, NULL, NULL));
  room_same_bits(&t.s, &t.want, "after rejected views");
  /* the good one is one that would have been seen */
  room_inject(&shared_device, t.s.frame.cache, &good, 1, 0);
  exact_planes other = room_outputs(&t.s);
  assert_true(count_different(&other, &t.want) > 0);
  exact_planes_free(&other);
  room_view_free(&good);
  room_stop(&t);
}

static cl_context other_context(void) {
  cl_int error;
  const cl_context context =
      clCreateContext(NULL, 1, &shared_device.id, NULL, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  return context;
}

static void planes_of_other_contexts_are_rejected(void **state) {
  room_scene t;
  cl_int error;
  (void)state;
  room_start(&t);
  const cl_context context = other_context();
  hbil_view view = t.views[0];
  view.albedo.buffer = clCreateBuffer(context, CL_MEM_READ_WRITE,
                                      (size_t)32 * 32 * 12, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  room_rejected(room_try(&t, &view, 1, NULL), HBIL_INVALID_FRAME, "albedo");
  clReleaseMemObject(view.albedo.buffer);
  clReleaseContext(context);
  room_same_bits(&t.s, &t.want, "after a plane of another context");
  room_stop(&t);
}

/* ------------------------------------------------------------------------ */
/* Updates, moves and frames                                                 */

typedef struct bad_update {
  const char *field;
  void (*spoil)(hbil_cache_update *);
} bad_update;

#define SPOIL_UPDATE(name, statement)                                          \
  static void name(hbil_cache_update *u) {                                     \
    statement;                                                                 \
  }
SPOIL_UPDATE(rounds_1025, u->rounds = 1025)
SPOIL_UPDATE(share_0, u->share = 0)
SPOIL_UPDATE(share_4097, u->share = 4097)
SPOIL_UPDATE(far_7, u->far_field = (hbil_far_field)7)
SPOIL_UPDATE(far_negative,
             (u->far_field = HBIL_FAR_CONSTANT, u->environment[0][1] = -1.0f))
SPOIL_UPDATE(far_nan, (u->far_field = HBIL_FAR_SH, u->environment[8][2] = NAN))
SPOIL_UPDATE(far_infinite,
             (u->far_field = HBIL_FAR_FRAME, u->environment[0][0] = INFINITY))
SPOIL_UPDATE(update_small, u->struct_size -= 8)
SPOIL_UPDATE(update_large, u->struct_size += 8)

static const bad_update bad_updates[] = {{"rounds", rounds_1025},
                                         {"share", share_0},
                                         {"share", share_4097},
                                         {"far_field", far_7},
                                         {"environment[0][1]", far_negative},
                                         {"environment[8][2]", far_nan},
                                         {"environment[0][0]", far_infinite},
                                         {"struct_size", update_small},
                                         {"struct_size", update_large}};

static void bad_updates_and_moves_are_rejected(void **state) {
  static const double bad[] = {NAN, INFINITY, -INFINITY, 1e300};
  room_scene t;
  (void)state;
  room_start(&t);
  cl_event event = NULL;
  for (size_t i = 0; i < sizeof bad_updates / sizeof *bad_updates; ++i) {
    hbil_cache_update u;
    hbil_cache_update_init(&u);
    bad_updates[i].spoil(&u);
    room_rejected(hbil_enqueue_cache_update(t.s.frame.cache,
                                            shared_device.queue, &u, 0, NULL,
                                            &event),
                  HBIL_INVALID_ARGUMENT, bad_updates[i].field);
  }
  for (size_t i = 0; i < 3 * sizeof bad / sizeof *bad; ++i) {
    double centre[3] = {50.0, 50.0, 50.0};
    centre[i % 3] = bad[i / 3];
    room_rejected(hbil_enqueue_cache_move(t.s.frame.cache, shared_device.queue,
                                          centre, 0, NULL, &event),
                  HBIL_INVALID_ARGUMENT, "centre[");
  }
  assert_null(event);
  room_same_bits(&t.s, &t.want, "after rejected updates and moves");
  room_stop(&t);
}

static void reject_frame(const setup *s, const char *what) {
  cl_event event = NULL;
  room_rejected(hbil_enqueue_frame(s->plan, shared_device.queue, &s->frame, 0,
                                   NULL, &event),
                HBIL_INVALID_FRAME, what);
  assert_null(event);
}

static void frames_reject_caches_that_are_not_theirs(void **state) {
  room_scene t;
  setup plain;
  device_fixture other = shared_device;
  (void)state;
  room_start(&t);
  hbil_cache *const own = t.s.frame.cache;
  assert_int_equal(hbil_context_create(other.context, other.id, &other.hbil),
                   HBIL_SUCCESS);
  t.s.frame.cache = room_cache(&other);
  reject_frame(&t.s, "cache");
  hbil_cache_destroy(t.s.frame.cache);
  hbil_context_destroy(other.hbil);
  t.s.frame.cache = own;
  room_same_bits(&t.s, &t.want, "after a cache of another context");
  const room r = room_lit();
  room_setup(&plain, &r, &t.s.frame.camera, ROOM_WIDTH, ROOM_HEIGHT);
  plain.config.model.cache_method = HBIL_CACHE_METHOD_NONE;
  setup_start(&plain);
  plain.frame.cache = own;
  reject_frame(&plain, "cache_method");
  setup_free(&plain);
  room_stop(&t);
}

/* Modes without light have no use for a cache. */
static void other_modes_have_no_cache(void **state) {
  static const hbil_mode modes[] = {HBIL_MODE_GTAO, HBIL_MODE_HBAO};
  (void)state;
  for (int i = 0; i < 2; ++i) {
    setup s;
    hbil_plan *plan = NULL;
    setup_init(&s, ROOM_WIDTH, ROOM_HEIGHT);
    setup_mode(&s, modes[i]);
    s.config.model.cache_method = HBIL_CACHE_METHOD_RAYS;
    room_rejected(hbil_plan_create(shared_device.hbil, &s.config, &plan),
                  HBIL_INVALID_CONFIG, "cache_method");
    setup_free(&s);
  }
}

/* ------------------------------------------------------------------------ */
/* Null and malformed arguments                                              */

#define INVALID(call) assert_int_equal((call), HBIL_INVALID_ARGUMENT)

static void null_arguments_are_rejected(void **state) {
  const hbil_cache_config config = room_cache_config();
  hbil_context *const context = shared_device.hbil;
  const cl_command_queue queue = shared_device.queue;
  hbil_cache_counts n;
  hbil_cache *none = NULL;
  size_t bytes;
  room_scene t;
  (void)state;
  room_start(&t);
  hbil_cache *const cache = t.s.frame.cache;
  INVALID(hbil_cache_memory(NULL, &config, &bytes));
  INVALID(hbil_cache_memory(context, NULL, &bytes));
  INVALID(hbil_cache_memory(context, &config, NULL));
  INVALID(hbil_cache_create(NULL, &config, &none));
  INVALID(hbil_cache_create(context, NULL, &none));
  INVALID(hbil_cache_create(context, &config, NULL));
  INVALID(hbil_enqueue_cache_inject(NULL, queue, t.views, 1, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_inject(cache, NULL, t.views, 1, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_inject(cache, queue, NULL, 1, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_inject(cache, queue, t.views, 1, 1, NULL, NULL));
  INVALID(hbil_enqueue_cache_update(NULL, queue, NULL, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_update(cache, NULL, NULL, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_update(cache, queue, NULL, 1, NULL, NULL));
  INVALID(hbil_enqueue_cache_move(NULL, queue, room_middle, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_move(cache, NULL, room_middle, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_move(cache, queue, NULL, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_reset(NULL, queue, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_reset(cache, NULL, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_reset(cache, queue, 1, NULL, NULL));
  INVALID(hbil_cache_statistics(NULL, queue, &n));
  INVALID(hbil_cache_statistics(cache, NULL, &n));
  INVALID(hbil_cache_statistics(cache, queue, NULL));
  INVALID(hbil_cache_save(NULL, queue, &n, sizeof n));
  INVALID(hbil_cache_save(cache, queue, NULL, hbil_cache_size(cache)));
  INVALID(hbil_cache_save(cache, queue, &n, sizeof n));
  INVALID(hbil_cache_load(NULL, queue, &n, sizeof n));
  INVALID(hbil_cache_load(cache, queue, NULL, hbil_cache_size(cache)));
  INVALID(hbil_cache_load(cache, queue, &n, sizeof n));
  assert_int_equal(hbil_cache_size(NULL), 0);
  hbil_cache_destroy(NULL);
  hbil_cache_config_init_sized(NULL, sizeof config);
  hbil_view_init_sized(NULL, sizeof(hbil_view));
  hbil_cache_update_init_sized(NULL, sizeof(hbil_cache_update));
  room_same_bits(&t.s, &t.want, "after null arguments");
  /* a null update is the default one */
  assert_success(&t.s,
                 hbil_enqueue_cache_update(cache, queue, NULL, 0, NULL, NULL));
  room_stop(&t);
}

static void queues_of_other_contexts_are_rejected(void **state) {
  room_scene t;
  cl_int error;
  (void)state;
  room_start(&t);
  const cl_context context = other_context();
  const cl_command_queue queue =
      clCreateCommandQueue(context, shared_device.id, 0, &error);
  assert_int_equal(error, CL_SUCCESS);
  INVALID(hbil_enqueue_cache_inject(t.s.frame.cache, queue, t.views, 1, 0, NULL,
                                    NULL));
  INVALID(hbil_enqueue_cache_reset(t.s.frame.cache, queue, 0, NULL, NULL));
  clReleaseCommandQueue(queue);
  clReleaseContext(context);
  room_same_bits(&t.s, &t.want, "after a queue of another context");
  room_stop(&t);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(bad_configurations_are_rejected_by_name),
      cmocka_unit_test(defaults_are_those_of_the_header),
      cmocka_unit_test(bad_views_are_rejected_by_name),
      cmocka_unit_test(planes_of_other_contexts_are_rejected),
      cmocka_unit_test(bad_updates_and_moves_are_rejected),
      cmocka_unit_test(frames_reject_caches_that_are_not_theirs),
      cmocka_unit_test(other_modes_have_no_cache),
      cmocka_unit_test(null_arguments_are_rejected),
      cmocka_unit_test(queues_of_other_contexts_are_rejected)};
  return RUN_WITH_DEVICE(tests);
}
