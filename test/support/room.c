#include "test/support/room.h"
#include "test/support/cache.h"

room room_dark(void) {
  return (room){.half = {1.6, 1.2, 1.8}, .albedo = 0.5f};
}

/* ------------------------------------------------------------------------ */
/* Cameras                                                                   */

/* Axes x, y and z of view space in the world. */
static void view_axes(wall towards, double axes[3][3]) {
  const int along = towards / 2, sign = towards % 2 ? 1 : -1;
  double(*x)[3] = &axes[0], (*y)[3] = &axes[1], (*z)[3] = &axes[2];
  memset(axes, 0, 9 * sizeof(double));
  (*z)[along] = sign;
  (*y)[along == 1 ? 2 : 1] = 1.0;
  /* x = y cross z */
  for (int i = 0; i < 3; ++i)
    (*x)[i] = (*y)[(i + 1) % 3] * (*z)[(i + 2) % 3] -
              (*y)[(i + 2) % 3] * (*z)[(i + 1) % 3];
}

hbil_camera room_camera(const double eye[3], wall towards, int width,
                        int height, double fov) {
  hbil_camera camera;
  double axes[3][3];
  memset(&camera, 0, sizeof camera);
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  camera.fx = camera.fy = camera.cx / tan(fov * PI / 360.0);
  view_axes(towards, axes);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k)
      camera.world_from_view[4 * i + k] = axes[k][i];
    camera.world_from_view[4 * i + 3] = eye[i];
  }
  camera.world_from_view[15] = 1.0;
  return camera;
}

hbil_camera room_flat_camera(const double eye[3], wall towards, int width,
                             int height, double across) {
  hbil_camera camera = room_camera(eye, towards, width, height, 90.0);
  camera.fx = camera.fy = width / across;
  return camera;
}

/* ------------------------------------------------------------------------ */
/* Pictures                                                                  */

/* What one ray sees. */
typedef struct sight {
  double depth;
  wall hit;
} sight;

/* The wall that a ray leaves the room through; 0: it never was in there. */
static sight look(const room *r, const double from[3], const double d[3]) {
  sight s = {INFINITY, LEFT};
  double entry = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double side = d[i] > 0.0 ? r->half[i] : -r->half[i];
    if (d[i] == 0.0)
      continue;
    const double leaves = (side - from[i]) / d[i];
    entry = fmax(entry, (-side - from[i]) / d[i]);
    if (leaves < s.depth)
      s = (sight){leaves, (wall)(2 * i + (d[i] > 0.0))};
  }
  if (!(s.depth > entry) || (r->roofless && s.hit == CEILING))
    s.depth = 0.0;
  return s;
}

/* Planes in the order of the fixture's inputs. */
static void fill_planes(const room *r, const hbil_camera *camera,
                        hbil_projection projection, int width, int height,
                        float *const planes[EXACT_INPUT_PLANES]) {
  const double *m = camera->world_from_view;
  const bool flat = projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  for (int i = 0; i < width * height; ++i) {
    const double px = (i % width + 0.5 - camera->cx) / camera->fx;
    const double py = ((double)(i / width) + 0.5 - camera->cy) / camera->fy;
    double from[3], d[3];
    for (int k = 0; k < 3; ++k) {
      const double across = m[4 * k] * px + m[4 * k + 1] * py;
      from[k] = m[4 * k + 3] + (flat ? across : 0.0);
      d[k] = m[4 * k + 2] + (flat ? 0.0 : across);
    }
    const sight s = look(r, from, d);
    planes[EXACT_DEPTH][i] = (float)s.depth;
    for (int c = 0; c < 3; ++c) {
      const bool is_normal = (int)s.hit / 2 == c;
      planes[EXACT_NORMAL + c][i] =
          is_normal ? (s.hit % 2 ? -1.0f : 1.0f) : 0.0f;
      planes[EXACT_ALBEDO + c][i] = r->albedo;
      planes[EXACT_DIRECT + c][i] = s.depth > 0.0 ? r->direct[s.hit] : 0.0f;
      planes[EXACT_EMISSION + c][i] = s.depth > 0.0 ? r->emission[s.hit] : 0.0f;
    }
  }
}

void room_load(setup *s, const room *r, const hbil_camera *camera) {
  s->frame.camera = *camera;
  fill_planes(r, camera, s->config.inputs.projection, (int)s->config.width,
              (int)s->config.height, s->input);
}

void room_setup(setup *s, const room *r, const hbil_camera *camera, int width,
                int height) {
  setup_init(s, width, height);
  setup_no_outputs(s);
  s->config.outputs.near_irradiance = s->config.outputs.far_irradiance =
      three_floats;
  s->config.outputs.ao = one_float;
  s->config.inputs.motion.component = HBIL_NONE;
  s->config.inputs.normal_space = HBIL_SPACE_WORLD;
  hbil_cache_config cache = room_cache_config();
  assert_int_equal(hbil_config_use_cache(&s->config, &cache), HBIL_SUCCESS);
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
  s->config.execution.vector_width = 1;
  room_load(s, r, camera);
}

/* ------------------------------------------------------------------------ */
/* Caches and views                                                          */

static void view_formats(hbil_inputs *inputs) {
  inputs->depth = one_float;
  inputs->normal = inputs->albedo = inputs->direct = inputs->emission =
      three_floats;
  inputs->f0.component = inputs->motion.component = HBIL_NONE;
  inputs->normal_space = HBIL_SPACE_WORLD;
}

hbil_cache_config room_cache_config(void) {
  hbil_cache_config config;
  hbil_cache_config_init(&config);
  config.voxels = 32;
  config.levels = 2;
  config.voxel_size = ROOM_VOXEL;
  view_formats(&config.inputs);
  return config;
}

static void must(const device_fixture *d, hbil_status status) {
  if (status != HBIL_SUCCESS)
    fail_msg("%s: %s", hbil_status_string(status),
             hbil_context_message(d->hbil));
}

hbil_cache *room_cache(const device_fixture *d) {
  const hbil_cache_config config = room_cache_config();
  hbil_cache *cache = NULL;
  must(d, hbil_cache_create(d->hbil, &config, &cache));
  assert_non_null(cache);
  return cache;
}

hbil_view room_view(const device_fixture *d, const room *r,
                    const hbil_camera *camera, hbil_projection projection,
                    int width, int height, hbil_view_light light) {
  const size_t plane = (size_t)width * (size_t)height;
  float *values = calloc(EXACT_INPUT_PLANES * plane, sizeof(float));
  float *planes[EXACT_INPUT_PLANES];
  hbil_view view;
  assert_non_null(values);
  for (int i = 0; i < EXACT_INPUT_PLANES; ++i)
    planes[i] = values + plane * (size_t)i;
  fill_planes(r, camera, projection, width, height, planes);
  hbil_view_init(&view);
  view.width = (cl_uint)width;
  view.height = (cl_uint)height;
  view.projection = projection;
  view.camera = *camera;
  view.light = light;
  const struct {
    hbil_plane *at;
    int first, channels;
  } parts[] = {{&view.depth, EXACT_DEPTH, 1},
               {&view.normal, EXACT_NORMAL, 3},
               {&view.albedo, EXACT_ALBEDO, 3},
               {&view.direct, EXACT_DIRECT, 3},
               {&view.emission, EXACT_EMISSION, 3}};
  float *pixels = malloc(3 * plane * sizeof(float));
  assert_non_null(pixels);
  for (size_t p = 0; p < sizeof parts / sizeof *parts; ++p) {
    const size_t count = (size_t)parts[p].channels;
    for (size_t i = 0; i < plane * count; ++i)
      pixels[i] = planes[parts[p].first + (int)(i % count)][i / count];
    parts[p].at->buffer = buffer_new(d, plane * count * sizeof(float), pixels);
  }
  free(pixels);
  free(values);
  return view;
}

void room_view_free(hbil_view *view) {
  hbil_plane *const planes[] = {&view->depth, &view->normal, &view->albedo,
                                &view->direct, &view->emission};
  for (size_t i = 0; i < sizeof planes / sizeof *planes; ++i) {
    if (planes[i]->buffer)
      clReleaseMemObject(planes[i]->buffer);
    planes[i]->buffer = NULL;
  }
}

void room_views(const device_fixture *d, const room *r, const double eye[3],
                int size, hbil_view_light light, hbil_view views[WALLS]) {
  for (int i = 0; i < WALLS; ++i) {
    const hbil_camera camera = room_camera(eye, (wall)i, size, size, 90.0);
    views[i] = room_view(d, r, &camera, HBIL_PROJECTION_PERSPECTIVE, size, size,
                         light);
  }
}

void room_views_free(hbil_view *views, int count) {
  for (int i = 0; i < count; ++i)
    room_view_free(&views[i]);
}

void room_inject(const device_fixture *d, hbil_cache *cache,
                 const hbil_view *views, cl_uint count, cl_uint bounces) {
  hbil_cache_update update = cache_bounces(bounces);
  must(d,
       hbil_enqueue_cache_inject(cache, d->queue, views, count, 0, NULL, NULL));
  must(d, hbil_enqueue_cache_update(cache, d->queue, &update, 0, NULL, NULL));
}

void room_show(hbil_cache *cache, const room *r, int size,
               hbil_view_light light, cl_uint bounces) {
  hbil_view views[WALLS];
  room_views(&shared_device, r, room_middle, size, light, views);
  room_inject(&shared_device, cache, views, WALLS, bounces);
  room_views_free(views, WALLS);
}

hbil_cache_counts room_statistics(const device_fixture *d, hbil_cache *cache) {
  hbil_cache_counts out = {0, 0, 0};
  must(d, hbil_cache_statistics(cache, d->queue, &out));
  return out;
}

exact_planes room_outputs(setup *s) {
  setup_run(s, hbil_enqueue_frame);
  return outputs_read(s);
}

void room_same_bits(setup *s, const exact_planes *want, const char *what) {
  exact_planes got = room_outputs(s);
  const size_t different = count_different(&got, want);
  exact_planes_free(&got);
  if (different)
    fail_msg("%s: %zu values have other bits", what, different);
}

/* ------------------------------------------------------------------------ */
/* A frame, a cache and its views                                            */

const double room_middle[3] = {0.0, 0.0, 0.0};

room room_lit(void) {
  room r = room_dark();
  r.direct[BEHIND] = 5.0f;
  r.direct[LEFT] = r.direct[RIGHT] = 0.6f;
  r.emission[LEFT] = 0.25f;
  return r;
}

void room_start(room_scene *t) {
  const double eye[3] = {0.1, 0.2, -1.0};
  const room r = room_lit();
  const hbil_camera camera =
      room_camera(eye, AHEAD, ROOM_WIDTH, ROOM_HEIGHT, 75.0);
  room_setup(&t->s, &r, &camera, ROOM_WIDTH, ROOM_HEIGHT);
  t->s.config.sampling.slices = 1;
  t->s.config.sampling.steps_per_side = 4;
  t->s.config.sampling.unfiltered = CL_TRUE;
  setup_start(&t->s);
  t->s.frame.cache = room_cache(t->s.device);
  room_views(t->s.device, &r, room_middle, 32, HBIL_VIEW_DIRECT, t->views);
  room_inject(t->s.device, t->s.frame.cache, t->views, WALLS, 1);
  t->want = room_outputs(&t->s);
  assert_true(largest_value(&t->want, EXACT_FAR_IRRADIANCE, 3) > 0.01);
}

void room_stop(room_scene *t) {
  exact_planes_free(&t->want);
  room_views_free(t->views, WALLS);
  hbil_cache_destroy(t->s.frame.cache);
  setup_free(&t->s);
}

hbil_status room_try(const room_scene *t, const hbil_view *views, cl_uint count,
                     cl_event *event) {
  return hbil_enqueue_cache_inject(t->s.frame.cache, t->s.device->queue, views,
                                   count, 0, NULL, event);
}

void room_rejected(hbil_status got, hbil_status want, const char *field) {
  const char *message = hbil_context_message(shared_device.hbil);
  if (got != want)
    fail_msg("%s: status %d, expected %d", field, (int)got, (int)want);
  if (!strstr(message, field))
    fail_msg("%s is not named in the message \"%s\"", field, message);
  if (strchr(message, '\n'))
    fail_msg("%s: more than one line: \"%s\"", field, message);
}
