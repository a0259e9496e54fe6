/*
 * Normals that are rebuilt from depth, against closed forms: planes, edges
 * between planes, a sphere, and pixels without neighbours.
 */
#include "test/support/stages.h"

enum { WIDTH = 61, HEIGHT = 37 };

/* In each projection and with the device's own vectors and none. */
static const struct {
  bool is_flat;
  cl_uint vector_width;
} variants[] = {{false, 0}, {false, 1}, {true, 0}, {true, 1}, {false, 4}};
enum { VARIANTS = sizeof variants / sizeof *variants };

static void prepare(setup *s, int variant, int width, int height) {
  setup_init(s, width, height);
  if (variants[variant].is_flat)
    setup_flatten(s, 8.0);
  s->config.execution.vector_width = variants[variant].vector_width;
  s->config.inputs.normal.component = HBIL_NONE;
}

/* Runs the split.  The caller frees the planes. */
static exact_planes split_of(setup *s) {
  setup_start(s);
  setup_run(s, enqueue_split);
  return stage_read(s, HBIL_STAGE_SPLIT);
}

static double angle_between(const double a[3], const double b[3]) {
  double cross2 = 0.0, dot = 0.0;
  for (int c = 0; c < 3; ++c) {
    const int d = (c + 1) % 3, e = (c + 2) % 3;
    const double v = a[d] * b[e] - a[e] * b[d];
    cross2 += v * v;
    dot += a[c] * b[c];
  }
  return atan2(sqrt(cross2), dot);
}

/* Radians between a pixel's normal and another one. */
static double off(const exact_planes *split, int x, int y,
                  const double want[3]) {
  double n[3];
  for (int c = 0; c < 3; ++c)
    n[c] = *exact_at(split, HBIL_SPLIT_NORMAL + c, x, y);
  return angle_between(n, want);
}

/* The largest one of the picture, whose every pixel shows the same plane. */
static double largest_off(const exact_planes *split, const double want[3]) {
  double most = 0.0;
  for (int y = 0; y < split->height; ++y)
    for (int x = 0; x < split->width; ++x)
      most = fmax(most, off(split, x, y, want));
  return most;
}

static void towards_the_eye(const setup *s, int x, int y, double out[3]) {
  double ray[3] = {0.0, 0.0, 1.0};
  if (s->config.inputs.projection == HBIL_PROJECTION_PERSPECTIVE)
    setup_ray(s, x, y, ray);
  for (int c = 0; c < 3; ++c)
    out[c] = -ray[c];
}

/* Depth of the plane with that unit normal whose point on the axis has depth
 * z0; 0 where there is none. */
static float depth_of_plane(const setup *s, const double n[3], double z0, int x,
                            int y) {
  double ray[3];
  setup_ray(s, x, y, ray);
  const double slope = n[0] * ray[0] + n[1] * ray[1];
  const double z = s->config.inputs.projection == HBIL_PROJECTION_PERSPECTIVE
                       ? z0 * n[2] / (slope + n[2])
                       : z0 - slope / n[2];
  return z > 0.0 && z < 6e4 ? (float)z : 0.0f;
}

/* What rounding does to a plane's normal.  Depth and w have an error of 2^-24
 * each, relative to w, so the difference of two has 2^-22.  Times f it is the
 * error of a gradient, of which there are two; the length of (a, b, c) is that
 * of w or more; a ray's slope adds to c what it has of a and b.  In the
 * orthographic pictures depths are up to 8, and lengths are 1 or more. */
static double rounding(const setup *s) {
  const bool flat = s->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC;
  return s->frame.camera.fx * ldexp(1.0, -22) * 2.0 * (flat ? 8.0 : 1.5);
}

TEST(planes_are_exact) {
  double most = 0.0;
  for (int v = 0; v < VARIANTS; ++v)
    for (int i = 0; i < 9; ++i) {
      setup s;
      double n[3];
      prepare(&s, v, WIDTH, HEIGHT);
      tilted_normal(0.17 * i, 2.4 * i, n);
      for (int p = 0; p < WIDTH * HEIGHT; ++p)
        s.input[EXACT_DEPTH][p] =
            depth_of_plane(&s, n, 40.0, p % WIDTH, p / WIDTH);
      exact_planes split = split_of(&s);
      const double scale = rounding(&s) * (variants[v].is_flat ? 40.0 / 8 : 1);
      size_t surfaces = 0;
      for (int p = 0; p < WIDTH * HEIGHT; ++p)
        if (s.input[EXACT_DEPTH][p] > 0.0f) {
          most = fmax(most, off(&split, p % WIDTH, p / WIDTH, n) / scale);
          ++surfaces;
        }
      assert_true(surfaces > WIDTH * HEIGHT / 4);
      exact_planes_free(&split);
      setup_free(&s);
    }
  check_at_most("share of the roundings", most, 1.0);
}

/* Four planes, with edges between them along rows and columns. */
TEST(edges_bend_no_normals) {
  double most = 0.0;
  for (int v = 0; v < VARIANTS; ++v) {
    setup s;
    double n[4][3];
    prepare(&s, v, WIDTH, HEIGHT);
    for (int q = 0; q < 4; ++q)
      tilted_normal(0.2 + 0.15 * q, 1.9 * q, n[q]);
    for (int p = 0; p < WIDTH * HEIGHT; ++p) {
      const int x = p % WIDTH, y = p / WIDTH, q = (x > 25) + 2 * (y > 14);
      s.input[EXACT_DEPTH][p] = depth_of_plane(&s, n[q], 5.0 + 0.7 * q, x, y);
    }
    exact_planes split = split_of(&s);
    for (int p = 0; p < WIDTH * HEIGHT; ++p) {
      const int x = p % WIDTH, y = p / WIDTH, q = (x > 25) + 2 * (y > 14);
      most = fmax(most, off(&split, x, y, n[q]) / rounding(&s));
    }
    exact_planes_free(&split);
    setup_free(&s);
  }
  check_at_most("share of the roundings", most, 1.0);
}

/* Depth of a sphere of radius 1 about (0, 0, 3), and its normal. */
static float sphere(const setup *s, int x, int y, double n[3]) {
  double ray[3], from[3] = {0.0, 0.0, -3.0};
  setup_ray(s, x, y, ray);
  if (s->config.inputs.projection == HBIL_PROJECTION_ORTHOGRAPHIC) {
    from[0] = ray[0];
    from[1] = ray[1];
    ray[0] = ray[1] = 0.0;
  }
  double a = 0.0, b = 0.0, c = -1.0;
  for (int i = 0; i < 3; ++i) {
    a += ray[i] * ray[i];
    b += ray[i] * from[i];
    c += from[i] * from[i];
  }
  if (b * b < a * c)
    return 0.0f;
  const double z = (-b - sqrt(b * b - a * c)) / a;
  for (int i = 0; i < 3; ++i)
    n[i] = from[i] + z * ray[i];
  return (float)z;
}

/* A difference to a neighbour is the gradient half a pixel away.  There the
 * normal is turned by half of what a pixel covers of the sphere, along each
 * axis; to first order, hence half as much more. */
TEST(spheres_are_off_by_half_a_pixel) {
  double most = 0.0;
  for (int v = 0; v < VARIANTS; ++v) {
    setup s;
    double n[3];
    size_t seen = 0;
    prepare(&s, v, WIDTH, HEIGHT);
    for (int p = 0; p < WIDTH * HEIGHT; ++p)
      s.input[EXACT_DEPTH][p] = sphere(&s, p % WIDTH, p / WIDTH, n);
    exact_planes split = split_of(&s);
    for (int p = 0; p < WIDTH * HEIGHT; ++p) {
      const int x = p % WIDTH, y = p / WIDTH;
      double eye[3];
      const double z = (double)sphere(&s, x, y, n);
      towards_the_eye(&s, x, y, eye);
      const double cosine = cos(angle_between(n, eye));
      if (!(z > 0.0) || cosine < 0.5)
        continue;
      const double covered =
          (variants[v].is_flat ? 1.0 : z) / (s.frame.camera.fx * cosine);
      most = fmax(most, off(&split, x, y, n) / (0.5 * sqrt(2.0) * covered));
      ++seen;
    }
    assert_true(seen > 50);
    exact_planes_free(&split);
    setup_free(&s);
  }
  check_at_most("in halves of a pixel", most, 1.5);
}

/* Where no neighbour shows a surface, normals point to the eye; along a line,
 * they do as seen along the other axis. */
TEST(pixels_alone_face_the_eye) {
  for (int v = 0; v < VARIANTS; ++v) {
    setup s;
    double want[3];
    prepare(&s, v, WIDTH, HEIGHT);
    for (int i = 0; i < 9; ++i)
      s.input[EXACT_DEPTH][(4 * i) * WIDTH + 7 * i] = 2.0f;
    for (int x = 0; x < WIDTH; ++x)
      s.input[EXACT_DEPTH][HEIGHT / 2 * WIDTH + x] = 2.0f;
    exact_planes split = split_of(&s);
    for (int i = 0; i < 9; ++i)
      if (abs(4 * i - HEIGHT / 2) > 1) {
        towards_the_eye(&s, 7 * i, 4 * i, want);
        check_at_most("a pixel", off(&split, 7 * i, 4 * i, want), 5e-7);
      }
    /* the line has constant depth and lies in the middle: ry is 0 */
    double line = 0.0;
    for (int x = 0; x < WIDTH; ++x) {
      const double front[3] = {0.0, 0.0, -1.0};
      line = fmax(line, off(&split, x, HEIGHT / 2, front));
    }
    check_at_most("a line", line, 1e-6);
    exact_planes_free(&split);
    setup_free(&s);
  }
}

/* Pictures of one pixel, row or column, and with sides of two. */
TEST(small_pictures_have_normals) {
  static const int sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {2, 2}, {2, 7}};
  for (int v = 0; v < VARIANTS; ++v)
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
      setup s;
      prepare(&s, v, sizes[i][0], sizes[i][1]);
      const double front[3] = {0.0, 0.0, -1.0};
      setup_fill(&s, EXACT_DEPTH, 3.0f);
      exact_planes split = split_of(&s);
      check_at_most("the plane", largest_off(&split, front), 1e-6);
      exact_planes_free(&split);
      setup_free(&s);
    }
}

/* Any scale of a scene, from the nearest depth to the farthest. */
TEST(scale_does_not_matter) {
  const double n[3] = {0.6, 0.0, -0.8};
  for (int e = -14; e <= 14; e += 7) {
    setup s;
    hbil_sanitized counts;
    prepare(&s, 0, WIDTH, HEIGHT);
    for (int p = 0; p < WIDTH * HEIGHT; ++p)
      s.input[EXACT_DEPTH][p] =
          depth_of_plane(&s, n, 3.0, p % WIDTH, p / WIDTH) *
          (float)pow(10.0, e);
    exact_planes split = split_of(&s);
    check_at_most("normal", largest_off(&split, n),
                  2.0 * rounding(&s)); /* a third rounding: the scale */
    exact_planes_free(&split);
    setup_run(&s, hbil_enqueue_frame);
    assert_success(&s, hbil_plan_sanitized(s.plan, s.device->queue, &counts));
    assert_int_equal(counts.normal, 0);
    setup_free(&s);
  }
}

/* Depth along the ray, hardware depth 1/z, and floats with pitches. */
TEST(every_form_of_depth_is_read) {
  const double n[3] = {0.36, 0.48, -0.8};
  for (int form = 0; form < 3; ++form) {
    setup s;
    /* rays differ from lane to lane; single pixels compile fastest */
    prepare(&s, form == 0 ? 0 : 1, WIDTH, HEIGHT);
    if (form == 0)
      s.config.inputs.depth_kind = HBIL_DEPTH_RAY;
    if (form == 1) {
      s.config.inputs.depth_kind = HBIL_DEPTH_HARDWARE;
      s.frame.hardware_depth[0] = 0.0;
      s.frame.hardware_depth[1] = 1.0;
    }
    if (form == 2) {
      s.config.inputs.depth = pitched_format(HBIL_FLOAT32, 3);
      s.layout[PLANE_DEPTH] = (plane_layout){5, 7, 0};
    }
    for (int p = 0; p < WIDTH * HEIGHT; ++p) {
      const float z = depth_of_plane(&s, n, 3.0, p % WIDTH, p / WIDTH);
      double ray[3];
      setup_ray(&s, p % WIDTH, p / WIDTH, ray);
      const double length = sqrt(1.0 + ray[0] * ray[0] + ray[1] * ray[1]);
      s.input[EXACT_DEPTH][p] = form == 0 ? z * (float)length : z;
    }
    exact_planes split = split_of(&s);
    /* the ray's length and the fixture's hardware depth add roundings */
    check_at_most("normal", largest_off(&split, n), 2.0 * rounding(&s));
    exact_planes_free(&split);
    setup_free(&s);
  }
}

/* Two neighbours in a half have the same depth, or a whole step between. */
TEST(depths_of_16_bits_are_rejected) {
  setup s;
  hbil_memory memory;
  prepare(&s, 0, WIDTH, HEIGHT);
  s.config.inputs.depth.component = HBIL_FLOAT16;
  assert_int_equal(hbil_plan_memory(s.device->hbil, &s.config, &memory),
                   HBIL_INVALID_CONFIG);
  assert_non_null(
      strstr(hbil_context_message(s.device->hbil), "inputs.normal.component"));
  setup_free(&s);
}

/* The plan has three planes more, of rows that are multiples of 64 floats. */
/* Parts of the scratch memory begin where the device lets sub-buffers begin. */
TEST(memory_is_counted) {
  setup s;
  size_t with, without;
  cl_uint bits;
  assert_int_equal(clGetDeviceInfo(shared_device.id,
                                   CL_DEVICE_MEM_BASE_ADDR_ALIGN, sizeof bits,
                                   &bits, NULL),
                   CL_SUCCESS);
  const size_t alignment = bits / 8;
  const size_t normals = 3 * 64 * HEIGHT * sizeof(float);
  prepare(&s, 0, WIDTH, HEIGHT);
  with = setup_memory(&s);
  s.config.inputs.normal = three_floats;
  without = setup_memory(&s);
  assert_int_equal(with - without,
                   (normals + alignment - 1) / alignment * alignment);
  setup_free(&s);
}

TEST(given_normals_are_rejected) {
  setup s;
  prepare(&s, 0, WIDTH, HEIGHT);
  setup_start(&s);
  s.frame.normal.buffer = s.frame.depth.buffer;
  assert_int_equal(
      hbil_enqueue_frame(s.plan, s.device->queue, &s.frame, 0, NULL, NULL),
      HBIL_INVALID_FRAME);
  assert_non_null(
      strstr(hbil_context_message(s.device->hbil), "normal.buffer"));
  s.frame.normal.buffer = NULL;
  setup_free(&s);
}

/* Whole frames: the same as with those normals given.  With packed storage,
 * whose normals are less exact than either, so that the gather takes both for
 * equally flat. */
TEST(frames_are_those_of_the_rebuilt_normals) {
  setup rebuilt, given;
  setup_scene(&rebuilt, SCENE_ROOM, WIDTH, HEIGHT, 0);
  setup_all_outputs(&rebuilt);
  rebuilt.config.sampling.storage = HBIL_STORAGE_PACKED;
  rebuilt.config.inputs.normal.component = HBIL_NONE;
  exact_planes split = split_of(&rebuilt);
  setup_scene(&given, SCENE_ROOM, WIDTH, HEIGHT, 0);
  setup_all_outputs(&given);
  given.config.sampling.storage = HBIL_STORAGE_PACKED;
  given.config.inputs.normal_space = HBIL_SPACE_VIEW;
  for (int c = 0; c < 3; ++c)
    for (int p = 0; p < WIDTH * HEIGHT; ++p)
      given.input[EXACT_NORMAL + c][p] =
          (float)*exact_at(&split, HBIL_SPLIT_NORMAL + c, p % WIDTH, p / WIDTH);
  setup_start(&given);
  for (int frame = 0; frame < 3; ++frame) {
    rebuilt.frame.static_frame = given.frame.static_frame = frame == 2;
    setup_run(&rebuilt, hbil_enqueue_frame);
    setup_run(&given, hbil_enqueue_frame);
  }
  exact_planes got = outputs_read(&rebuilt), want = outputs_read(&given);
  assert_int_equal(count_different(&got, &want), 0);
  planes_free(&got, &want, &split);
  setup_free(&rebuilt);
  setup_free(&given);
}
