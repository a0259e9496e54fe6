/*
 * What a cache rejects: each wrong setting, view, update and argument has a
 * message that names it, and changes nothing.
 */
#include "test/support/room.h"
#include "test/support/shim.h"

/* ------------------------------------------------------------------------ */
/* Configurations                                                            */

static const char *spoil_config(hbil_cache_config *c, int which) {
  SPOIL("voxels", c->voxels = 0);
  SPOIL("voxels", c->voxels = 8);
  SPOIL("voxels", c->voxels = 17);
  SPOIL("voxels", c->voxels = 512);
  SPOIL("levels", c->levels = 0);
  SPOIL("levels", c->levels = 5);
  SPOIL("voxel_size", c->voxel_size = 0.0);
  SPOIL("voxel_size", c->voxel_size = -1.0);
  SPOIL("voxel_size", c->voxel_size = NAN);
  SPOIL("voxel_size", c->voxel_size = INFINITY);
  SPOIL("voxel_size", c->voxel_size = 1e-9);
  SPOIL("voxel_size", c->voxel_size = 1e9);
  SPOIL("centre[0]", c->centre[0] = NAN);
  SPOIL("centre[1]", c->centre[1] = -INFINITY);
  SPOIL("centre[2]", c->centre[2] = 1e300);
  SPOIL("inputs.depth", c->inputs.depth.component = HBIL_IMAGE);
  SPOIL("inputs.normal", c->inputs.normal.component = HBIL_IMAGE);
  SPOIL("inputs.direct", c->inputs.direct.component = HBIL_IMAGE);
  SPOIL("inputs.depth", c->inputs.depth.component = HBIL_NONE);
  SPOIL("inputs.normal", c->inputs.normal.component = HBIL_NONE);
  SPOIL("albedo", c->inputs.albedo.pixel_pitch = 8);
  SPOIL("emission", c->inputs.emission.component = (hbil_component)99);
  SPOIL("depth_scale", c->inputs.depth_scale = 0.0f);
  SPOIL("normal_scale[1]", c->inputs.normal_scale[1] = NAN);
  SPOIL("normal_space", c->inputs.normal_space = (hbil_space)7);
  SPOIL("gather_emission", c->gather_emission = 2);
  SPOIL("unseen_light", c->unseen_light = -0.25f);
  SPOIL("unseen_light", c->unseen_light = 1.5f);
  SPOIL("unseen_light", c->unseen_light = NAN);
  SPOIL("struct_size", c->struct_size = 0);
  SPOIL("struct_size", c->struct_size -= 8);
  SPOIL("struct_size", c->struct_size += 8);
  return NULL;
}

TEST(bad_configurations_are_rejected_by_name) {
  for (int i = 0;; ++i) {
    hbil_cache_config c = room_cache_config();
    hbil_cache *cache = (hbil_cache *)&c;
    size_t bytes = 77;
    const char *field = spoil_config(&c, i);
    if (!field)
      break;
    const long held = shim_references();
    room_rejected(hbil_cache_memory(shared_device.hbil, &c, &bytes),
                  HBIL_INVALID_CONFIG, field);
    assert_int_equal(bytes, 77);
    room_rejected(hbil_cache_create(shared_device.hbil, &c, &cache),
                  HBIL_INVALID_CONFIG, field);
    assert_null(cache);
    assert_int_equal(shim_references(), held);
  }
}

TEST(defaults_are_those_of_the_header) {
  hbil_cache_config c;
  hbil_config plan;
  hbil_cache_update u;
  hbil_view v;
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
  assert_int_equal(u.bounces, 4);
  assert_int_equal(u.phases, 1);
  assert_int_equal(u.far_field, HBIL_FAR_AUTO);
  hbil_view_init(&v);
  assert_int_equal(v.struct_size, sizeof v);
  assert_int_equal(v.light, HBIL_VIEW_DIRECT);
  assert_null(v.depth.buffer);
}

/* What a plan and a cache take from each other; a thickness that isn't the
 * default one is the caller's. */
TEST(a_plan_uses_a_cache) {
  for (int i = 0; i < 2; ++i) {
    hbil_cache_config c = room_cache_config();
    hbil_config plan;
    hbil_config_init(&plan);
    c.voxel_size = 0.25;
    c.method = HBIL_CACHE_METHOD_CONES;
    plan.inputs.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
    plan.inputs.depth_kind = HBIL_DEPTH_RAY;
    plan.model.gather_emission = CL_FALSE;
    if (i)
      plan.model.relative_thickness = 0.1f;
    assert_int_equal(hbil_config_use_cache(&plan, &c), HBIL_SUCCESS);
    assert_memory_equal(&c.inputs, &plan.inputs, sizeof c.inputs);
    assert_int_equal(c.gather_emission, CL_FALSE);
    assert_int_equal(plan.model.cache_method, HBIL_CACHE_METHOD_CONES);
    assert_true(plan.model.radius == 1.0f); /* four voxels */
    assert_true(plan.model.relative_thickness == (i ? 0.1f : 0.06f));
    assert_true(plan.model.near_relative_thickness == (i ? INFINITY : 0.02f));
    assert_true(isinf(plan.model.thickness));
  }
}

TEST(a_plan_needs_the_size_of_voxels) {
  static const double wrong[] = {0.0, -0.1, NAN};
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    hbil_cache_config c = room_cache_config();
    hbil_config plan;
    hbil_config_init(&plan);
    c.voxel_size = wrong[i];
    assert_int_equal(hbil_config_use_cache(&plan, &c), HBIL_INVALID_ARGUMENT);
    assert_non_null(strstr(hbil_context_message(NULL), "voxel_size: "));
    assert_true(plan.model.cache_method == HBIL_CACHE_METHOD_NONE &&
                isinf(plan.model.radius));
  }
}

/* ------------------------------------------------------------------------ */
/* Views                                                                     */

/* All that a frame and its plan say of a view. */
TEST(a_frame_is_a_view) {
  hbil_config plan;
  hbil_frame frame;
  hbil_view view;
  hbil_config_init(&plan);
  hbil_frame_init(&frame);
  plan.width = 320;
  plan.height = 200;
  plan.inputs.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  frame.camera = room_camera(room_middle, BEHIND, 320, 200, 70.0);
  frame.hardware_depth[0] = 3.0;
  frame.hardware_depth[1] = 4.0;
  hbil_plane *const from[] = {&frame.depth, &frame.normal, &frame.albedo,
                              &frame.f0,    &frame.direct, &frame.emission};
  const hbil_plane *const to[] = {&view.depth, &view.normal, &view.albedo,
                                  &view.f0,    &view.direct, &view.emission};
  for (size_t i = 0; i < sizeof to / sizeof *to; ++i)
    from[i]->offset = 64 * (i + 1);
  memset(&view, 0xff, sizeof view);
  assert_int_equal(hbil_view_from_frame(&view, &plan, &frame), HBIL_SUCCESS);
  assert_int_equal(view.struct_size, sizeof view);
  assert_true(view.width == 320 && view.height == 200);
  assert_int_equal(view.projection, HBIL_PROJECTION_ORTHOGRAPHIC);
  assert_memory_equal(&view.camera, &frame.camera, sizeof view.camera);
  for (size_t i = 0; i < sizeof to / sizeof *to; ++i)
    assert_memory_equal(to[i], from[i], sizeof *to[i]);
  assert_int_equal(view.light, HBIL_VIEW_DIRECT);
  assert_memory_equal(view.hardware_depth, frame.hardware_depth,
                      sizeof view.hardware_depth);
}

static const char *spoil_view(hbil_view *v, int which) {
  SPOIL("width", v->width = 0);
  SPOIL("width", v->width = 16385);
  SPOIL("height", v->height = 0);
  SPOIL("height", v->height = 16385);
  SPOIL("projection", v->projection = (hbil_projection)7);
  SPOIL("light", v->light = (hbil_view_light)7);
  SPOIL("cx", v->camera.cx = NAN);
  SPOIL("fx", v->camera.fx = 0.0);
  SPOIL("world_from_view", v->camera.world_from_view[3] = NAN);
  SPOIL("world_from_view", v->camera.world_from_view[0] = 1.5);
  SPOIL("camera", memset(&v->camera, 0, sizeof v->camera));
  SPOIL("depth.buffer: missing, the cache has", v->depth.buffer = NULL);
  SPOIL("f0.buffer: given, but the cache has", v->f0.buffer = v->depth.buffer);
  SPOIL("static_view: 2", v->static_view = 2);
  SPOIL("normal", v->normal.buffer = NULL);
  SPOIL("direct", v->direct.buffer = NULL);
  SPOIL("normal", v->normal.buffer = v->depth.buffer);
  SPOIL("depth", v->height += 1);
  SPOIL("depth", v->depth.offset = 2);
  SPOIL("depth", v->depth.offset = SIZE_MAX - 3);
  SPOIL("struct_size", v->struct_size -= 8);
  SPOIL("struct_size", v->struct_size += 8);
  SPOIL("struct_size", v->struct_size = 0);
  return NULL;
}

/* Wrong as the only view, and behind a right one, which isn't injected then.
 * The right one has other light, so that it would be seen. */
TEST(bad_views_are_rejected_by_name) {
  room_scene t;
  room r = room_lit();
  room_start(&t);
  r.direct[BEHIND] = 50.0f;
  const hbil_camera camera = room_camera(room_middle, BEHIND, 32, 32, 90.0);
  hbil_view good =
      room_view(&shared_device, &r, &camera, HBIL_PROJECTION_PERSPECTIVE, 32,
                32, HBIL_VIEW_FINISHED);
  const long made = shim_events_made();
  for (int i = 0;; ++i) {
    hbil_view views[2] = {good, t.views[0]};
    cl_event event = NULL;
    const char *field = spoil_view(&views[1], i);
    if (!field)
      break;
    room_rejected(room_try(&t, &views[1], 1, &event), HBIL_INVALID_FRAME,
                  field);
    room_rejected(room_try(&t, views, 2, &event), HBIL_INVALID_FRAME, field);
    assert_memory_equal(hbil_context_message(shared_device.hbil),
                        "views[1]: ", 10);
    assert_null(event);
  }
  assert_int_equal(shim_events_made(), made);
  assert_success(
      &t.s, hbil_enqueue_cache_update(
                t.s.frame.cache, shared_device.queue,
                &(hbil_cache_update){.struct_size = sizeof(hbil_cache_update),
                                     .phases = 1},
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

TEST(planes_of_other_contexts_are_rejected) {
  room_scene t;
  cl_int error;
  room_start(&t);
  const cl_context context = other_context();
  hbil_view view = t.views[0];
  view.albedo.buffer = clCreateBuffer(context, CL_MEM_READ_WRITE,
                                      (size_t)32 * 32 * 12, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  room_rejected(room_try(&t, &view, 1, NULL), HBIL_INVALID_FRAME,
                "albedo.buffer: not of the cache's");
  clReleaseMemObject(view.albedo.buffer);
  clReleaseContext(context);
  room_same_bits(&t.s, &t.want, "after a plane of another context");
  room_stop(&t);
}

/* ------------------------------------------------------------------------ */
/* Updates, moves and frames                                                 */

static const char *spoil_update(hbil_cache_update *u, int which) {
  SPOIL("bounces", u->bounces = 1025);
  SPOIL("phases", u->phases = 0);
  SPOIL("phases", u->phases = 4097);
  SPOIL("far_field: 7; must be one of hbil_far_field",
        u->far_field = (hbil_far_field)7);
  SPOIL("environment[0][1]",
        (u->far_field = HBIL_FAR_CONSTANT, u->environment[0][1] = -1.0f));
  SPOIL("environment[8][2]",
        (u->far_field = HBIL_FAR_SH, u->environment[8][2] = NAN));
  SPOIL("environment[0][0]",
        (u->far_field = HBIL_FAR_FRAME, u->environment[0][0] = INFINITY));
  SPOIL("environment[0][2]",
        (u->far_field = HBIL_FAR_CONSTANT, u->environment[0][2] = 1e31f));
  SPOIL("struct_size", u->struct_size -= 8);
  SPOIL("struct_size", u->struct_size += 8);
  return NULL;
}

TEST(bad_updates_and_moves_are_rejected) {
  static const double bad[] = {NAN, INFINITY, -INFINITY, 1e300};
  room_scene t;
  room_start(&t);
  cl_event event = NULL;
  for (int i = 0;; ++i) {
    hbil_cache_update u;
    hbil_cache_update_init(&u);
    const char *field = spoil_update(&u, i);
    if (!field)
      break;
    room_rejected(hbil_enqueue_cache_update(t.s.frame.cache,
                                            shared_device.queue, &u, 0, NULL,
                                            &event),
                  HBIL_INVALID_ARGUMENT, field);
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

TEST(bad_changes_are_rejected) {
  static const float bad[] = {-0.1f, 1.1f, NAN};
  room_scene t;
  hbil_cache_change change;
  cl_event event = NULL;
  room_start(&t);
  hbil_cache *cache = t.s.frame.cache;
  for (int i = 0; i < 9; ++i) {
    hbil_cache_change_init(&change);
    assert_true(isinf(change.low[i % 3]) && change.low[i % 3] < 0.0 &&
                isinf(change.high[i % 3]) && change.high[i % 3] > 0.0 &&
                change.surfaces == 0.0f && change.light == 0.0f);
    if (i < 3)
      change.surfaces = bad[i];
    else if (i < 6)
      change.light = bad[i - 3];
    else
      change.low[i - 6] = i == 7 ? NAN : change.high[i - 6];
    room_rejected(hbil_enqueue_cache_forget(cache, shared_device.queue, &change,
                                            0, NULL, &event),
                  HBIL_INVALID_ARGUMENT,
                  i < 3   ? "surfaces"
                  : i < 6 ? "light"
                          : "high[");
  }
  change.struct_size = 7;
  room_rejected(hbil_enqueue_cache_forget(cache, shared_device.queue, &change,
                                          0, NULL, &event),
                HBIL_INVALID_ARGUMENT, "struct_size");
  assert_null(event);
  room_same_bits(&t.s, &t.want, "after rejected changes");
  room_stop(&t);
}

static void reject_frame(const setup *s, const char *what) {
  cl_event event = NULL;
  room_rejected(hbil_enqueue_frame(s->plan, shared_device.queue, &s->frame, 0,
                                   NULL, &event),
                HBIL_INVALID_FRAME, what);
  assert_null(event);
}

TEST(frames_reject_caches_that_are_not_theirs) {
  room_scene t;
  setup plain;
  device_fixture other = shared_device;
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
TEST(other_modes_have_no_cache) {
  static const hbil_mode modes[] = {HBIL_MODE_GTAO, HBIL_MODE_HBAO};
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

TEST(null_arguments_are_rejected) {
  const hbil_cache_config config = room_cache_config();
  hbil_context *const context = shared_device.hbil;
  const cl_command_queue queue = shared_device.queue;
  hbil_cache_counts n;
  hbil_cache *none = NULL;
  size_t bytes;
  room_scene t;
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
  INVALID(hbil_enqueue_cache_forget(NULL, queue, NULL, 0, NULL, NULL));
  INVALID(hbil_enqueue_cache_forget(cache, queue, NULL, 0, NULL, NULL));
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

TEST(queues_and_events_of_other_contexts_are_rejected) {
  room_scene t;
  cl_int error;
  room_start(&t);
  const cl_context context = other_context();
  const cl_command_queue queue =
      clCreateCommandQueue(context, shared_device.id, 0, &error);
  assert_int_equal(error, CL_SUCCESS);
  INVALID(hbil_enqueue_cache_inject(t.s.frame.cache, queue, t.views, 1, 0, NULL,
                                    NULL));
  INVALID(hbil_enqueue_cache_reset(t.s.frame.cache, queue, 0, NULL, NULL));
  const cl_event foreign = clCreateUserEvent(context, &error);
  assert_int_equal(error, CL_SUCCESS);
  room_rejected(hbil_enqueue_cache_reset(t.s.frame.cache, shared_device.queue,
                                         1, &foreign, NULL),
                HBIL_INVALID_ARGUMENT,
                "hbil_enqueue_cache_reset: wait_list[0]: an event of another");
  clReleaseEvent(foreign);
  clReleaseCommandQueue(queue);
  clReleaseContext(context);
  room_same_bits(&t.s, &t.want, "after a queue of another context");
  room_stop(&t);
}
