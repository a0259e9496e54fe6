/*
 * One meaning a layer: ao, bent_normal, cone_cosine and the error of AO are
 * those of occluders within model.ao_radius, whatever the near field is and
 * whether or not there is a radiance cache.  Light doesn't depend on them.
 */
#include "test/support/lit_frame.h"
#include "test/support/stages.h"

#define WIDTH 96
#define HEIGHT 60
#define NEAR 0.4f

/* The outputs that show occlusion, and those that show light. */
static const plane_id shown[] = {PLANE_AO, PLANE_BENT, PLANE_CONE};
static const plane_id lit[] = {PLANE_NEAR,   PLANE_FAR,     PLANE_INDIRECT,
                               PLANE_BEAUTY, PLANE_UNKNOWN, PLANE_GLOSSY};
#define COUNT(list) (sizeof(list) / sizeof *(list))

/* The largest difference of an output. */
static double difference(const exact_planes *a, const exact_planes *b,
                         plane_id id) {
  const size_t plane = (size_t)a->width * (size_t)a->height;
  const size_t channels = (size_t)plane_channels(id);
  const size_t start = plane * (size_t)plane_first(id);
  double most = 0.0;
  for (size_t i = start; i < start + plane * channels; ++i)
    most = fmax(most, fabs(a->values[i] - b->values[i]));
  return most;
}

/* How far a layer may be off.  Variants of the gather for vectors divide by
 * estimates, and the compiler makes others where light is gathered beside
 * occlusion.  Bent normals have few digits where what is open cancels, and
 * errors are roots of differences of squares, times up to 2.6.  Measured in
 * floats: 1.5e-6, 6.5e-5, 3e-6.  Packed, a rounding may become a step of 16
 * bits, or of 10 in a bent normal; measured: 0, with one cache 6.2e-6. */
typedef struct limits {
  double ao, bent, squared_error;
} limits;
/* In packed storage a step of AO is 2^-16, which is twice as much in its
 * square.
 */
static const limits packed = {0x1p-16, 1e-3, 0x1p-15},
                    floats = {3e-6, 1e-4, 1e-5};

static void check_occlusion(const exact_planes *got, const exact_planes *want,
                            const limits *most) {
  double off = 0.0;
  for (size_t i = 0; i < COUNT(shown); ++i)
    check_at_most(plane_name(shown[i]), difference(got, want, shown[i]),
                  shown[i] == PLANE_BENT ? most->bent : most->ao);
  for (int i = 0; i < got->width * got->height; ++i) {
    const int x = i % got->width, y = i / got->width;
    off =
        fmax(off, fabs(pow(*exact_at(got, EXACT_ERROR_ESTIMATE, x, y), 2.0) -
                       pow(*exact_at(want, EXACT_ERROR_ESTIMATE, x, y), 2.0)));
  }
  check_at_most("squared error of AO", off, most->squared_error);
}

static void check_light(const exact_planes *got, const exact_planes *want) {
  for (size_t i = 0; i < COUNT(lit); ++i)
    check_at_most(plane_name(lit[i]), difference(got, want, lit[i]), 0.0);
}

/* A frame of a furnished room with everything in it. */
typedef struct kind {
  const char *what;
  bool packed, thick, orthographic;
  cl_uint slices, width;
  hbil_resolution resolution;
} kind;

static const kind kinds[] = {
    {"default", true, false, false, 3, 0, HBIL_RESOLUTION_FULL},
    {"half resolution, a slice", true, false, false, 1, 4,
     HBIL_RESOLUTION_HALF},
    {"single pixels, floats", false, false, true, 2, 1, HBIL_RESOLUTION_FULL},
    {"infinite thickness", false, true, false, 2, 8, HBIL_RESOLUTION_HALF},
};

static void prepare(setup *s, const kind *k) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  if (k->orthographic) {
    s->config.inputs.projection = HBIL_PROJECTION_ORTHOGRAPHIC;
    setup_load_scene(s, SCENE_ROOM, 0);
  }
  setup_all_outputs(s);
  s->config.outputs.glossy = three_floats;
  s->config.sampling.storage =
      k->packed ? HBIL_STORAGE_PACKED : HBIL_STORAGE_FLOAT32;
  s->config.sampling.slices = k->slices;
  s->config.sampling.resolution = k->resolution;
  s->config.execution.vector_width = k->width;
  s->config.model.relative_thickness = k->thick ? INFINITY : 0.06f;
  s->config.model.back_facing_fallback = HBIL_FALLBACK_FRAME_MEAN;
  s->config.model.far_field = HBIL_FAR_FRAME;
}

static void without_occlusion(hbil_config *config) {
  for (size_t k = 0; k < COUNT(shown); ++k)
    plane_format(config, shown[k])->component = HBIL_NONE;
  config->outputs.error_estimate.component = HBIL_NONE;
}

static exact_planes run(setup *s) {
  setup_start(s);
  setup_run(s, hbil_enqueue_frame);
  return outputs_read(s);
}

/* Occlusion is that of a frame whose near field reaches as far.  The default
 * with both radii, other kinds with one of them in turn: kernels take long to
 * compile. */
TEST(it_counts_within_ao_radius) {
  static const float radii[] = {INFINITY, 1.0f};
  for (size_t i = 0; i < COUNT(kinds); ++i)
    for (size_t k = 0; k < COUNT(radii); ++k) {
      if (i && i % 2 != k)
        continue;
      setup same, nearer;
      print_message("%s, ao_radius %g\n", kinds[i].what, (double)radii[k]);
      prepare(&same, kinds + i);
      same.config.model.radius = same.config.model.ao_radius = radii[k];
      exact_planes want = run(&same);
      prepare(&nearer, kinds + i);
      nearer.config.model.radius = k ? INFINITY : NEAR;
      nearer.config.model.ao_radius = radii[k];
      nearer.config.model.near_relative_thickness = 0.02f;
      exact_planes got = run(&nearer);
      check_occlusion(&got, &want, kinds[i].packed ? &packed : &floats);
      assert_true(difference(&got, &want, PLANE_NEAR) > 1e-3);
      planes_free(&got, &want);
      setup_free(&same);
      setup_free(&nearer);
    }
}

/* Light has the bits that it has where nobody asks for occlusion, or for that
 * of the near field. */
TEST(light_does_not_depend_on_it) {
  for (size_t i = 0; i < 2; ++i) {
    setup alone, both;
    prepare(&alone, kinds + i);
    alone.config.model.radius = NEAR;
    if (i % 2)
      without_occlusion(&alone.config);
    else
      alone.config.model.ao_radius = NEAR;
    exact_planes want = run(&alone);
    prepare(&both, kinds + i);
    both.config.model.radius = NEAR;
    exact_planes got = run(&both);
    check_light(&got, &want);
    for (int p = 0; p < WIDTH * HEIGHT && i % 2 == 0; ++p)
      assert_true(
          *exact_at(&got, EXACT_ERROR_ESTIMATE + 1, p % WIDTH, p / WIDTH) ==
          *exact_at(&want, EXACT_ERROR_ESTIMATE + 1, p % WIDTH, p / WIDTH));
    planes_free(&got, &want);
    setup_free(&alone);
    setup_free(&both);
  }
}

/* Where no light is shown there is one search, that of the outputs: with the
 * memory and the bits of a plan whose radius it is. */
TEST(occlusion_alone_has_one_search) {
  for (int mode = HBIL_MODE_HBIL; mode <= HBIL_MODE_GTAO; ++mode) {
    setup s[2];
    exact_planes out[2];
    for (int i = 0; i < 2; ++i) {
      prepare(s + i, kinds);
      setup_no_outputs(s + i);
      s[i].config.model.mode = (hbil_mode)mode;
      s[i].config.model.far_field =
          mode == HBIL_MODE_HBIL ? HBIL_FAR_FRAME : HBIL_FAR_NONE;
      s[i].config.outputs.ao = one_float;
      s[i].config.outputs.bent_normal = three_floats;
      s[i].config.model.ao_radius = 1.0f;
      s[i].config.model.radius = i ? 1.0f : NEAR;
      out[i] = run(s + i);
    }
    assert_int_equal(setup_memory(s), setup_memory(s + 1));
    assert_memory_equal(out[0].values, out[1].values,
                        count_values(out) * sizeof *out->values);
    for (int i = 0; i < 2; ++i) {
      exact_planes_free(out + i);
      setup_free(s + i);
    }
  }
}

/* A second search takes memory only where it is made. */
TEST(memory_is_taken_where_needed) {
  setup s;
  prepare(&s, kinds);
  const size_t one = setup_memory(&s);
  s.config.model.radius = s.config.model.ao_radius = NEAR;
  const size_t limited = setup_memory(&s);
  assert_true(limited > one); /* the table of steps */
  s.config.model.ao_radius = INFINITY;
  assert_true(setup_memory(&s) > limited);
  without_occlusion(&s.config);
  assert_true(setup_memory(&s) < limited);
  setup_free(&s);
}

/* GTAO: far light goes through the near field's cone. */
TEST(gtao_has_both) {
  setup s[3];
  exact_planes out[3];
  for (int i = 0; i < 3; ++i) {
    prepare(s + i, kinds);
    setup_mode(s + i, HBIL_MODE_GTAO);
    s[i].config.model.far_field = HBIL_FAR_SH;
    s[i].config.model.radius = i ? NEAR : INFINITY;
    s[i].config.model.ao_radius = i == 1 ? NEAR : INFINITY;
    lit_environment(s + i);
    out[i] = run(s + i);
  }
  check_occlusion(out + 2, out, &packed);
  check_light(out + 2, out + 1);
  assert_true(difference(out + 2, out, PLANE_FAR) > 1e-3);
  for (int i = 0; i < 3; ++i) {
    exact_planes_free(out + i);
    setup_free(s + i);
  }
}

/* HBAO counts within `radius`. */
TEST(hbao_has_none) {
  setup s[2];
  exact_planes out[2];
  for (int i = 0; i < 2; ++i) {
    prepare(s + i, kinds);
    setup_mode(s + i, HBIL_MODE_HBAO);
    s[i].config.model.far_field = HBIL_FAR_NONE;
    s[i].config.model.radius = 1.0f;
    s[i].config.model.ao_radius = i ? 0.1f : INFINITY;
    s[i].config.model.near_relative_thickness = i ? 0.01f : INFINITY;
    out[i] = run(s + i);
  }
  assert_memory_equal(out[0].values, out[1].values,
                      count_values(out) * sizeof *out->values);
  for (int i = 0; i < 2; ++i) {
    exact_planes_free(out + i);
    setup_free(s + i);
  }
}

static void run_frame(setup *s, cl_uint i, bool pass_by_pass) {
  s->frame.static_frame = i > 1;
  if (!pass_by_pass)
    setup_run(s, hbil_enqueue_frame);
  for (hbil_pass p = HBIL_PASS_REPROJECT;
       pass_by_pass && p <= HBIL_PASS_COMPOSITE; ++p)
    assert_success(s, hbil_enqueue_passes(s->plan, s->device->queue, &s->frame,
                                          p, p, 0, NULL, NULL));
}

/* Frames in a row: with slices that they share, static, and pass by
 * pass.  The second plan has two searches, the
 * others one, whose occlusion and whose light it has. */
TEST(sequences_agree) {
  for (cl_uint frames = 1; frames <= 3; frames += 2) {
    setup s[3];
    exact_planes out[3];
    for (int i = 0; i < 3; ++i) {
      prepare(s + i, kinds);
      s[i].config.sampling.slice_frames = frames;
      s[i].config.outputs.glossy.component = HBIL_NONE;
      s[i].config.model.radius = i ? NEAR : INFINITY;
      s[i].config.model.ao_radius = i == 2 ? NEAR : INFINITY;
      setup_start(s + i);
    }
    for (cl_uint k = 0; k < 5; ++k) {
      for (int i = 0; i < 3; ++i) {
        run_frame(s + i, k, i == 1 && k % 2 == 0);
        out[i] = outputs_read(s + i);
      }
      check_occlusion(out + 1, out, &packed);
      check_light(out + 1, out + 2);
      for (int i = 0; i < 3; ++i)
        exact_planes_free(out + i);
    }
    for (int i = 0; i < 3; ++i)
      setup_free(s + i);
  }
}

/* The same frame with a radiance cache and without one. */
static void prepare_pair(lit_frame *with, setup *without) {
  lit_prepare(with, HBIL_CACHE_METHOD_RAYS, 0, SCENE_ROOM,
              HBIL_PROJECTION_PERSPECTIVE, HBIL_FAR_FRAME);
  view_prepare(without, SCENE_ROOM, LIT_WIDTH, LIT_HEIGHT, 3,
               HBIL_PROJECTION_PERSPECTIVE);
  setup_all_outputs(without);
}

/* A radiance cache, with the settings that hbil_config_use_cache() gives; the
 * default model. */
TEST(a_cache_changes_nothing) {
  for (int storage = HBIL_STORAGE_PACKED; storage <= HBIL_STORAGE_FLOAT32;
       ++storage) {
    lit_frame l;
    setup without;
    prepare_pair(&l, &without);
    l.s.config.model.ao_radius = INFINITY;
    hbil_cache_config cache = l.f.config;
    hbil_config *const configs[] = {&l.s.config, &without.config};
    for (int i = 0; i < 2; ++i) {
      configs[i]->sampling.storage = (hbil_storage)storage;
      assert_success(&l.s,
                     hbil_model_set(&configs[i]->model, HBIL_MODEL_DEFAULT));
    }
    assert_success(&l.s, hbil_config_use_cache(&l.s.config, &cache));
    assert_true(l.s.config.model.radius < INFINITY &&
                l.s.config.model.relative_thickness == 0.06f &&
                l.s.config.model.near_relative_thickness == 0.02f);
    exact_planes got = run(&l.s), want = run(&without);
    check_occlusion(&got, &want,
                    storage == HBIL_STORAGE_PACKED ? &packed : &floats);
    planes_free(&got, &want);
    setup_free(&without);
    lit_free(&l);
  }
}

/* Near light beside a cache has three fifths of the steps, unless ao has the
 * same search. */
TEST(near_light_has_fewer_steps) {
  for (int shared = 0; shared < 2; ++shared) {
    lit_frame l;
    setup without;
    prepare_pair(&l, &without);
    hbil_config *const configs[] = {&l.s.config, &without.config};
    for (int i = 0; i < 2; ++i) {
      configs[i]->model.radius = NEAR;
      configs[i]->model.ao_radius = shared ? NEAR : INFINITY;
      configs[i]->model.near_relative_thickness = INFINITY;
      configs[i]->sampling.steps_per_side = i && !shared ? 12 : 20;
    }
    exact_planes got = run(&l.s), want = run(&without);
    /* measured: 4.6e-7, as kernels without a cache are other ones; .033 with a
     * fifth more steps */
    check_at_most("near light", difference(&got, &want, PLANE_NEAR), 2e-6);
    planes_free(&got, &want);
    setup_free(&without);
    lit_free(&l);
  }
}
