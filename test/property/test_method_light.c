/*
 * Light of the methods against closed forms: a disc that a light shines on,
 * flux that stays, an even environment, and furnaces.
 */
#include "test/support/lit_frame.h"
#include "test/support/room.h"
#include "test/support/shim.h"

#include "exact/cache_methods.h"

static hbil_cache *cache_with(hbil_cache_method method, cl_uint levels) {
  hbil_cache_config config = room_cache_config();
  hbil_cache *cache = NULL;
  config.levels = levels;
  config.method = method;
  const hbil_status status =
      hbil_cache_create(shared_device.hbil, &config, &cache);
  if (status != HBIL_SUCCESS)
    fail_msg("%s", hbil_context_message(shared_device.hbil));
  return cache;
}

/* Irradiance of all that a probe knows, if nothing is in the way. */
static double irradiance_of(const exact_probe *p, int c) {
  return 2.0 * PI / 3.0 *
         (p->light[c][1] * p->normal.x + p->light[c][2] * p->normal.y +
          p->light[c][3] * p->normal.z);
}

/* ------------------------------------------------------------------------ */
/* A disc in a light                                                         */

/* The disc is about the origin and faces +z. */
#define DISC_RADIUS 1.0
#define DISC_RADIANCE 3.0

/* A camera at `eye` that looks at the origin; focal: pixels per unit of its
 * image plane. */
static hbil_camera aimed(const double eye[3], int size, double focal) {
  const vec3 z = vec_normalize(vec(-eye[0], -eye[1], -eye[2]));
  const vec3 x = vec_normalize(vec(-z.z, 0.0, z.x));
  const vec3 y =
      vec(z.y * x.z - z.z * x.y, z.z * x.x - z.x * x.z, z.x * x.y - z.y * x.x);
  const hbil_camera camera = {
      .fx = focal,
      .fy = focal,
      .cx = 0.5 * size,
      .cy = 0.5 * size,
      .world_from_view = {x.x, y.x, z.x, eye[0], x.y, y.y, z.y, eye[1], x.z,
                          y.z, z.z, eye[2], 0.0, 0.0, 0.0, 1.0}};
  return camera;
}

/* Planar depth of the disc in a pixel, or 0. */
static double depth_of_disc(const hbil_camera *c, bool flat, int x, int y) {
  const double *m = c->world_from_view;
  const double px = (x + 0.5 - c->cx) / c->fx, py = (y + 0.5 - c->cy) / c->fy;
  double from[3], d[3];
  for (int k = 0; k < 3; ++k) {
    const double across = m[4 * k] * px + m[4 * k + 1] * py;
    from[k] = m[4 * k + 3] + (flat ? across : 0.0);
    d[k] = m[4 * k + 2] + (flat ? 0.0 : across);
  }
  const double t = -from[2] / d[2];
  return hypot(from[0] + t * d[0], from[1] + t * d[1]) < DISC_RADIUS ? t : 0.0;
}

typedef struct disc_view {
  hbil_view view;
  exact_cache_view exact;
  exact_texel *texels;
} disc_view;

static disc_view view_disc(const double eye[3], bool flat, int size) {
  const double far_off =
      sqrt(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
  const double focal = 0.45 * size * (flat ? 1.0 : far_off - 0.8);
  const size_t count = (size_t)size * (size_t)size;
  float *depth = calloc(count, sizeof(float));
  float *three = calloc(3 * count, sizeof(float));
  disc_view d;
  hbil_view_init(&d.view);
  d.view.width = d.view.height = (cl_uint)size;
  d.view.camera = aimed(eye, size, focal);
  d.view.projection =
      flat ? HBIL_PROJECTION_ORTHOGRAPHIC : HBIL_PROJECTION_PERSPECTIVE;
  d.texels = calloc(count, sizeof *d.texels);
  d.exact = (exact_cache_view){.camera = d.view.camera,
                               .orthographic = flat,
                               .stride = 1,
                               .width = size,
                               .height = size,
                               .texel = d.texels};
  assert_true(depth && three && d.texels);
  for (size_t i = 0; i < count; ++i) {
    const double z =
        depth_of_disc(&d.view.camera, flat, (int)i % size, (int)i / size);
    depth[i] = (float)z;
    d.texels[i].depth = z / ROOM_VOXEL;
    d.texels[i].normal = vec(0.0, 0.0, 1.0);
    for (int c = 0; c < 3; ++c)
      d.texels[i].sent[c] = DISC_RADIANCE;
  }
  const float parts[4][3] = {{0.0f, 0.0f, 1.0f},
                             {0.5f, 0.5f, 0.5f},
                             {(float)(2.0 * PI * DISC_RADIANCE),
                              (float)(2.0 * PI * DISC_RADIANCE),
                              (float)(2.0 * PI * DISC_RADIANCE)},
                             {0.0f, 0.0f, 0.0f}};
  hbil_plane *const to[4] = {&d.view.normal, &d.view.albedo, &d.view.direct,
                             &d.view.emission};
  d.view.depth.buffer =
      buffer_new(&shared_device, count * sizeof(float), depth);
  for (int p = 0; p < 4; ++p) {
    for (size_t i = 0; i < 3 * count; ++i)
      three[i] = parts[p][i % 3];
    to[p]->buffer =
        buffer_new(&shared_device, 3 * count * sizeof(float), three);
  }
  free(depth);
  free(three);
  return d;
}

static void free_disc(disc_view *d) {
  room_view_free(&d->view);
  free(d->texels);
}

/* A frame that shows a small piece of a plane which faces the disc, at a
 * distance from its middle: all its probes are at the same place, but for the
 * texels that they choose. */
static void facing_frame(setup *s, double distance) {
  enum { WIDTH = 320, HEIGHT = 180 };
  const double eye[3] = {0.0, 0.0, -5.0};
  const room r = {.half = {1.0, 1.0, distance}, .albedo = 0.5f};
  const hbil_camera camera = room_flat_camera(eye, AHEAD, WIDTH, HEIGHT, 1e-3);
  room_setup(s, &r, &camera, WIDTH, HEIGHT);
  s->config.inputs.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
  s->config.model.cache_method = HBIL_CACHE_METHOD_RSM;
  room_load(s, &r, &camera);
  setup_start(s);
}

/* Counts the valid probes.  All corners must be valid; insides may be. */
static int count_valid(const exact_probes *probes) {
  int valid = 0;
  for (int i = 0; i < probes->count; ++i) {
    const bool is_inside = i / probes->columns % 2;
    assert_true(probes->probe[i].valid || is_inside);
    valid += probes->probe[i].valid;
  }
  return valid;
}

static void check_disc(const double eye[3], bool flat, cl_uint count,
                       double distance) {
  const double want = count * PI * DISC_RADIANCE * DISC_RADIUS * DISC_RADIUS /
                      (DISC_RADIUS * DISC_RADIUS + distance * distance);
  const hbil_cache_config config = room_cache_config();
  disc_view d = view_disc(eye, flat, 256);
  hbil_view views[2] = {d.view, d.view};
  exact_cache exact;
  setup s;
  double sum[3][4] = {{0.0}}, mean = 0.0;
  facing_frame(&s, distance);
  s.frame.cache = cache_with(HBIL_CACHE_METHOD_RSM, 2);
  assert_success(&s, hbil_enqueue_cache_light_views(s.frame.cache,
                                                    shared_device.queue, views,
                                                    count, 0, NULL, NULL));
  setup_run(&s, hbil_enqueue_frame);
  exact_probes probes = lit_probes(&s, "filter_probes", 1);
  const int number = count_valid(&probes);
  for (int i = 0; i < probes.count; ++i) {
    const exact_probe *p = probes.probe + i;
    if (!p->valid)
      continue;
    mean += (irradiance_of(p, 0) + irradiance_of(p, 1) + irradiance_of(p, 2)) /
            (3.0 * number);
  }
  assert_int_equal(exact_cache_create(&exact, &config), EXACT_SUCCESS);
  for (cl_uint i = 0; i < count; ++i)
    exact_light_sum(&exact, &d.exact, vec(0.0, 0.0, distance / ROOM_VOXEL),
                    vec(0.0, 0.0, -1.0), sum);
  check_at_most("disc: all texels", fabs(-sum[1][3] / want - 1.0), 0.01);
  check_at_most("disc: the probes' mean", fabs(mean / want - 1.0), 0.01);
  exact_probes_free(&probes);
  exact_cache_free(&exact);
  hbil_cache_destroy(s.frame.cache);
  setup_free(&s);
  free_disc(&d);
}

TEST(a_lit_disc_lights_what_faces_it) {
  static const double eyes[][3] = {{0.0, 0.0, 2.5}, {1.7, 0.9, 2.0}};
  static const double distances[] = {0.5, 1.0, 2.0};
  for (int e = 0; e < 2; ++e)
    for (int i = 0; i < 3; ++i) {
      check_disc(eyes[e], false, 1, distances[i]);
      check_disc(eyes[e], true, 1, distances[i]);
    }
  check_disc(eyes[0], false, 2, 1.0);
}

/* ------------------------------------------------------------------------ */
/* Flux                                                                      */

static void update(hbil_cache *cache, hbil_far_field far_field, float radiance,
                   cl_uint steps) {
  hbil_cache_update u = cache_bounces(0);
  u.steps = steps;
  u.far_field = far_field;
  for (int c = 0; c < 3; ++c)
    u.environment[0][c] = (float)(1 << c) * radiance;
  if (hbil_enqueue_cache_update(cache, shared_device.queue, &u, 0, NULL,
                                NULL) != HBIL_SUCCESS)
    fail_msg("%s", hbil_context_message(shared_device.hbil));
  assert_int_equal(clFinish(shared_device.queue), CL_SUCCESS);
}

/* Cells across a volume of room_cache_config(), with those around. */
enum { ACROSS = 18, PLANE = ACROSS * ACROSS * ACROSS };

/* Puts light into one cell of the volume that the next step begins with. */
static void plant(const exact_intensity light[3], int x, int y, int z) {
  float *planes = calloc(15 * PLANE, sizeof *planes);
  cl_mem buffer;
  const int cell = ((z + 1) * ACROSS + y + 1) * ACROSS + x + 1;
  assert_non_null(planes);
  for (int c = 0; c < 3; ++c) {
    float *to = planes + 5 * c * PLANE + cell;
    const exact_intensity *v = &light[c];
    const double values[5] = {v->mean, v->slope.x, v->slope.y, v->slope.z,
                              exact_flux_factor(v)};
    for (int k = 0; k < 5; ++k)
      to[k * PLANE] = (float)values[k];
  }
  shim_argument("propagate", 4, sizeof buffer, &buffer);
  buffer_write(&shared_device, buffer, 0, 15 * PLANE * sizeof *planes, planes);
  free(planes);
}

/* The flux of all cells inside, and how many have light. */
static int flux_of(double flux[3]) {
  cl_mem buffer;
  int lit = 0;
  shim_argument("propagate", 4, sizeof buffer, &buffer);
  float *planes = (float *)buffer_bytes(&shared_device, buffer, NULL);
  flux[0] = flux[1] = flux[2] = 0.0;
  for (int i = 0; i < PLANE; ++i) {
    const int at[3] = {i % ACROSS, i / ACROSS % ACROSS, i / ACROSS / ACROSS};
    bool inside = true;
    for (int k = 0; k < 3; ++k)
      inside = inside && at[k] > 0 && at[k] < ACROSS - 1;
    lit += inside && planes[i] > 0.0f;
    for (int c = 0; c < 3 && inside; ++c)
      flux[c] += 4.0 * PI * (double)planes[5 * c * PLANE + i];
  }
  free(planes);
  return lit;
}

/* Nothing stops it, so it is all there until it leaves; lobes whose order-1
 * form is negative on one side, too. */
TEST(flux_stays_in_an_empty_volume) {
  const exact_intensity light[3] = {
      {0.25, {0.5, 0.0, 0.0}}, {1.0, {0.0, 0.0, 0.0}}, {0.5, {-0.6, 0.7, 0.4}}};
  hbil_cache *cache = cache_with(HBIL_CACHE_METHOD_LPV, 1);
  double flux[3];
  update(cache, HBIL_FAR_NONE, 0.0f, 1);
  plant(light, 8, 7, 8);
  for (int step = 1; step <= 24; ++step) {
    update(cache, HBIL_FAR_NONE, 0.0f, 1);
    const int lit = flux_of(flux);
    for (int c = 0; c < 3; ++c) {
      const double share = flux[c] / (4.0 * PI * light[c].mean);
      /* seven cells to either side */
      if (step <= 7)
        check_at_most("flux that is lost or won", fabs(share - 1.0), 1e-5);
      else
        assert_true(share < 1.0 - 1e-6 && share > 0.0);
    }
    assert_true(step < 7 || lit > 200);
  }
  hbil_cache_destroy(cache);
}

/* ------------------------------------------------------------------------ */
/* Even environments                                                         */

/* A frame of the room with a method, and radiance from everywhere. */
static void room_frame(setup *s, hbil_cache_method method, const room *r,
                       const double eye[3], float radiance) {
  const hbil_camera camera = room_camera(eye, AHEAD, 160, 96, 90.0);
  room_setup(s, r, &camera, 160, 96);
  s->config.sampling.slices = 4;
  s->config.sampling.steps_per_side = 16;
  s->config.model.cache_method = method;
  s->config.model.far_field = HBIL_FAR_CONSTANT;
  for (int c = 0; c < 3; ++c)
    s->frame.environment[0][c] = (float)(1 << c) * radiance;
  setup_start(s);
}

static const double inner_eye[3] = {0.1, 0.2, -1.0};

TEST(volumes_read_out_an_even_environment) {
  const room r = room_dark();
  for (cl_uint levels = 1; levels <= 3; ++levels) {
    setup s;
    double worst[2] = {0.0, 0.0};
    room_frame(&s, HBIL_CACHE_METHOD_LPV, &r, inner_eye, 0.5f);
    s.frame.cache = cache_with(HBIL_CACHE_METHOD_LPV, levels);
    update(s.frame.cache, HBIL_FAR_CONSTANT, 0.5f, 1000);
    setup_run(&s, hbil_enqueue_frame);
    exact_probes probes = lit_probes(&s, "filter_probes", 1);
    assert_true(count_valid(&probes) > 0);
    for (int i = 0; i < probes.count; ++i)
      for (int c = 0; c < 3; ++c) {
        const exact_probe *p = probes.probe + i;
        const double want = 0.5 * (1 << c);
        if (!p->valid)
          continue;
        worst[0] = fmax(worst[0], fabs(p->light[c][0] / want - 1.0));
        worst[1] =
            fmax(worst[1], fabs(irradiance_of(p, c) / (PI * want) - 1.0));
      }
    check_at_most("LPV: radiance of an even environment", worst[0], 0.01);
    check_at_most("LPV: irradiance of an even environment", worst[1], 0.01);
    exact_probes_free(&probes);
    hbil_cache_destroy(s.frame.cache);
    setup_free(&s);
  }
}

/* A cache whose views have seen the sky everywhere: nothing but a grain of dust
 * is in them. */
static void see_sky(hbil_cache *cache) {
  const double eye[3] = {0.03, 0.02, 0.01};
  const room dust = {.half = {1e-9, 1e-9, 1e-9}};
  hbil_view views[WALLS];
  for (int i = 0; i < WALLS; ++i) {
    const hbil_camera camera = room_camera(eye, (wall)i, 64, 64, 100.0);
    views[i] = room_view(&shared_device, &dust, &camera,
                         HBIL_PROJECTION_PERSPECTIVE, 64, 64, HBIL_VIEW_DIRECT);
  }
  room_inject(&shared_device, cache, views, WALLS, 0);
  room_views_free(views, WALLS);
}

/* Cones fill the hemisphere: their solid angles sum to 2 pi, so a probe knows
 * all, and their cosines, times these, to pi. */
TEST(cones_fill_the_hemisphere) {
  const room r = room_dark();
  setup s;
  double mean = 0.0, solid = 0.0, cosine = 0.0, light = 0.0;
  room_frame(&s, HBIL_CACHE_METHOD_CONES, &r, inner_eye, 1.0f);
  s.frame.cache = cache_with(HBIL_CACHE_METHOD_CONES, 2);
  see_sky(s.frame.cache);
  setup_run(&s, hbil_enqueue_frame);
  exact_probes probes = lit_probes(&s, "filter_probes", 1);
  const int count = count_valid(&probes);
  for (int i = 0; i < probes.count; ++i) {
    const exact_probe *p = probes.probe + i;
    const double sum = 2.0 / 3.0 *
                       (p->known[1] * p->normal.x + p->known[2] * p->normal.y +
                        p->known[3] * p->normal.z);
    if (!p->valid)
      continue;
    solid = fmax(solid, fabs(p->known[0] - 1.0));
    cosine = fmax(cosine, fabs(sum - 1.0));
    mean += sum / count;
    for (int c = 0; c < 3; ++c)
      light = fmax(light, fabs(p->light[c][0] / (1 << c) - 1.0));
  }
  check_at_most("cones: solid angles over 2 pi", solid, 1e-5);
  /* the strata of a probe's cones are turned by up to half of one */
  check_at_most("cones: cosines over pi", cosine, 1.0 / 16.0 + 1e-5);
  check_at_most("cones: mean cosines over pi", fabs(mean - 1.0), 0.005);
  check_at_most("cones: light of an even environment", light, 0.05);
  exact_probes_free(&probes);
  hbil_cache_destroy(s.frame.cache);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Furnaces                                                                  */

/* E over pi. */
typedef struct furnace_light {
  double least, greatest, mean;
} furnace_light;

/* Half the sizes of closed rooms: their walls are at other places of voxels and
 * texels. */
static const double furnaces[][3] = {
    {1.6, 1.2, 1.8}, {1.37, 1.03, 1.71}, {1.9, 0.7, 1.25}};
enum { FURNACES = sizeof furnaces / sizeof *furnaces };

/* A closed room whose walls all send 1. */
static furnace_light light_of_furnace(hbil_cache_method method,
                                      const double half[3], float sky) {
  room r = {.half = {half[0], half[1], half[2]}};
  hbil_view views[WALLS];
  setup s;
  furnace_light got = {INFINITY, 0.0, 0.0};
  for (int i = 0; i < WALLS; ++i)
    r.direct[i] = r.emission[i] = 1.0f;
  room_frame(&s, method, &r, inner_eye, sky);
  s.frame.cache = cache_with(method, 2);
  room_views(&shared_device, &r, room_middle, 64, HBIL_VIEW_FINISHED, views);
  room_inject(&shared_device, s.frame.cache, views, WALLS, 0);
  update(s.frame.cache, HBIL_FAR_NONE, 0.0f, 200);
  if (method == HBIL_CACHE_METHOD_RSM)
    assert_success(&s, hbil_enqueue_cache_light_views(
                           s.frame.cache, shared_device.queue, views,
                           HBIL_MAX_LIGHT_VIEWS, 0, NULL, NULL));
  exact_planes out = room_outputs(&s);
  for (int i = 0; i < out.width * out.height; ++i) {
    const int x = i % out.width, y = i / out.width;
    const double e = (*exact_at(&out, EXACT_NEAR_IRRADIANCE, x, y) +
                      *exact_at(&out, EXACT_FAR_IRRADIANCE, x, y)) /
                     PI;
    got.least = fmin(got.least, e);
    got.greatest = fmax(got.greatest, e);
    got.mean += e / (out.width * out.height);
  }
  exact_planes_free(&out);
  room_views_free(views, WALLS);
  hbil_cache_destroy(s.frame.cache);
  setup_free(&s);
  return got;
}

/* What no view has seen is dark, or as bright as the walls.  Reflective shadow
 * maps have four of the six walls, by a few texels a probe. */
TEST(no_method_is_brighter_than_the_furnace) {
  static const struct {
    const char *name;
    hbil_cache_method method;
    double brighter;
  } rows[] = {{"rays, brighter", HBIL_CACHE_METHOD_RAYS, 1e-5},
              {"cones, brighter", HBIL_CACHE_METHOD_CONES, 1e-5},
              {"RSM, brighter", HBIL_CACHE_METHOD_RSM, 0.0},
              /* (measured: -0.025) */
              {"LPV, brighter", HBIL_CACHE_METHOD_LPV, 0.0}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows * 2 * FURNACES; ++i) {
    const size_t row = i / (2 * FURNACES);
    const bool sky = i % 2;
    const furnace_light got = light_of_furnace(
        rows[row].method, furnaces[i / 2 % FURNACES], (float)sky);
    check_at_most(rows[row].name, got.greatest - 1.0, rows[row].brighter);
    if (rows[row].method == HBIL_CACHE_METHOD_CONES && sky)
      check_at_most("cones, darker", 1.0 - got.least, 0.05);
    /* ways along the room's edges end at what no view has seen (measured:
     * 0.032 to 0.039; rays: 0.041 to 0.052) */
    if (rows[row].method == HBIL_CACHE_METHOD_CONES && !sky)
      check_at_most("cones, leak", 1.0 - got.mean, 0.05);
    assert_true(got.mean > 0.5);
  }
}
