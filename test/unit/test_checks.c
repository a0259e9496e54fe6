/*
 * The memory of a frame's planes is checked before anything is enqueued: its
 * kind, context and access, and that outputs have bytes of their own.
 */
#include "test/support/fixture.h"
#include "test/support/random.h"
#include "test/support/shim.h"

#include <stdio.h>

enum { WIDTH = 5, HEIGHT = 3 };

/* Aligns sub-buffers on every device that the tests run on. */
enum { ALIGNMENT = 4096, SHARED_BYTES = 3 * ALIGNMENT };

static const plane_id shown[] = {PLANE_NEAR, PLANE_AO, PLANE_BENT};
#define SHOWN 3

/* A plan of few kernels.  All outputs take pixels of 16 bytes: four floats, or
 * eight halves for ao. */
static void start(setup *s) {
  setup_scene(s, SCENE_ROOM, WIDTH, HEIGHT, 0);
  s->config.history.reprojection = HBIL_REPROJECTION_NONE;
  s->config.inputs.motion.component = HBIL_NONE;
  s->config.outputs.near_irradiance = s->config.outputs.bent_normal =
      (hbil_plane_format){HBIL_FLOAT32, 16};
  s->config.outputs.ao = (hbil_plane_format){HBIL_FLOAT16, 16};
  setup_start(s);
}

static cl_mem new_memory(cl_mem_flags flags, size_t bytes) {
  cl_int error;
  cl_mem created =
      clCreateBuffer(shared_device.context, flags, bytes, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  return created;
}

static cl_mem new_part(cl_mem parent, cl_mem_flags flags, size_t at,
                       size_t bytes) {
  const cl_buffer_region region = {at, bytes};
  cl_int error;
  cl_mem part = clCreateSubBuffer(parent, flags, CL_BUFFER_CREATE_TYPE_REGION,
                                  &region, &error);
  assert_int_equal(error, CL_SUCCESS);
  return part;
}

/* ------------------------------------------------------------------------ */
/* Rejected and accepted                                                     */

/* A message is one line, which names the plane. */
static void assert_message(const char *name, const char *part) {
  const char *message = hbil_context_message(shared_device.hbil);
  if (getenv("HBIL_TEST_VERBOSE"))
    printf("# %s\n", message);
  if (strncmp(message, name, strlen(name)) != 0 || !strstr(message, part) ||
      strchr(message, '\n'))
    fail_msg("\"%s\", expected \"%s...%s...\"", message, name, part);
}

/* The frame is rejected for that plane, and nothing is enqueued. */
static void assert_rejected(setup *s, enqueue_function *enqueue, plane_id plane,
                            const char *part) {
  cl_event event = NULL;
  const long held = shim_references();
  assert_int_equal(
      enqueue(s->plan, s->device->queue, &s->frame, 0, NULL, &event),
      HBIL_INVALID_FRAME);
  assert_null(event);
  assert_int_equal(shim_references(), held);
  assert_message(plane_name(plane), part);
}

/* By all functions that use the plane. */
static void assert_plane_rejected(setup *s, plane_id plane, const char *part) {
  assert_rejected(s, hbil_enqueue_frame, plane, part);
  if (plane < PLANE_FIRST_OUTPUT)
    assert_rejected(s, enqueue_split, plane, part);
  if (plane != PLANE_NORMAL)
    assert_rejected(s, enqueue_composite, plane, part);
}

/* With `memory` for the plane's buffer, the frame is rejected. */
static void assert_memory_rejected(setup *s, plane_id plane, cl_mem memory,
                                   const char *part) {
  hbil_plane *slot = plane_slot(&s->frame, plane);
  const hbil_plane good = *slot;
  slot->buffer = memory;
  assert_plane_rejected(s, plane, part);
  *slot = good;
}

/* ------------------------------------------------------------------------ */
/* Kind, context, access                                                     */

static cl_mem new_image(cl_mem_object_type type, cl_mem buffer) {
  const cl_image_format format = {CL_RGBA, CL_FLOAT};
  cl_image_desc desc = {.image_type = type,
                        .image_width = 4 * WIDTH,
                        .image_height = 4 * HEIGHT,
                        .buffer = buffer};
  cl_int error;
  if (type == CL_MEM_OBJECT_IMAGE1D_BUFFER)
    desc.image_height = 0;
  cl_mem image = clCreateImage(shared_device.context, CL_MEM_READ_WRITE,
                               &format, &desc, NULL, &error);
  return error == CL_SUCCESS ? image : NULL;
}

TEST(images_are_rejected) {
  const plane_id planes[] = {PLANE_DEPTH, PLANE_NORMAL, PLANE_NEAR, PLANE_AO};
  setup s;
  cl_bool has_images = CL_FALSE;
  clGetDeviceInfo(shared_device.id, CL_DEVICE_IMAGE_SUPPORT, sizeof has_images,
                  &has_images, NULL);
  if (!has_images)
    skip();
  start(&s);
  cl_mem texels = new_memory(CL_MEM_READ_WRITE, SHARED_BYTES);
  cl_mem image = new_image(CL_MEM_OBJECT_IMAGE2D, NULL);
  cl_mem of_buffer = new_image(CL_MEM_OBJECT_IMAGE1D_BUFFER, texels);
  assert_non_null(image);
  for (size_t i = 0; i < sizeof planes / sizeof *planes; ++i) {
    assert_memory_rejected(&s, planes[i], image, ".buffer: an image");
    if (of_buffer) /* not every device has this kind */
      assert_memory_rejected(&s, planes[i], of_buffer, ".buffer: an image");
  }
  setup_run(&s, hbil_enqueue_frame);
  clReleaseMemObject(image);
  if (of_buffer)
    clReleaseMemObject(of_buffer);
  clReleaseMemObject(texels);
  setup_free(&s);
}

TEST(other_contexts_are_rejected) {
  setup s;
  cl_int error;
  start(&s);
  cl_context other =
      clCreateContext(NULL, 1, &shared_device.id, NULL, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  cl_mem memory =
      clCreateBuffer(other, CL_MEM_READ_WRITE, SHARED_BYTES, NULL, &error);
  assert_int_equal(error, CL_SUCCESS);
  assert_memory_rejected(&s, PLANE_DEPTH, memory, ".buffer: not of the plan's");
  assert_memory_rejected(&s, PLANE_BENT, memory, ".buffer: not of the plan's");
  clReleaseMemObject(memory);
  const cl_event events[2] = {clCreateUserEvent(shared_device.context, &error),
                              clCreateUserEvent(other, &error)};
  assert_int_equal(error, CL_SUCCESS);
  assert_int_equal(hbil_enqueue_frame(s.plan, shared_device.queue, &s.frame, 2,
                                      events, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(
      hbil_context_message(shared_device.hbil),
      "hbil_enqueue_frame: wait_list[1]: an event of another OpenCL context"));
  for (int i = 0; i < 2; ++i)
    clReleaseEvent(events[i]);
  clReleaseContext(other);
  setup_free(&s);
}

/* Inputs that are read-only and outputs that are write-only are accepted;
 * rejected is the other way. `memory` is released. */
static void check_access(setup *s, cl_mem memory, bool readable,
                         bool writable) {
  const plane_id planes[] = {PLANE_NORMAL, PLANE_BENT};
  for (int i = 0; i < 2; ++i) {
    hbil_plane *slot = plane_slot(&s->frame, planes[i]);
    const hbil_plane good = *slot;
    if (i ? writable : readable) {
      slot->buffer = memory;
      setup_run(s, hbil_enqueue_frame);
    } else
      assert_memory_rejected(s, planes[i], memory,
                             i ? ".buffer: CL_MEM_READ_ONLY"
                               : ".buffer: CL_MEM_WRITE_ONLY");
    *slot = good;
  }
  clReleaseMemObject(memory);
}

TEST(access_must_fit_the_use) {
  setup s;
  start(&s);
  check_access(&s, new_memory(CL_MEM_READ_WRITE, SHARED_BYTES), true, true);
  check_access(&s, new_memory(0, SHARED_BYTES), true, true);
  check_access(&s, new_memory(CL_MEM_READ_ONLY, SHARED_BYTES), true, false);
  check_access(&s, new_memory(CL_MEM_WRITE_ONLY, SHARED_BYTES), false, true);
  check_access(
      &s, new_memory(CL_MEM_READ_WRITE | CL_MEM_HOST_NO_ACCESS, SHARED_BYTES),
      true, true);
  check_access(
      &s, new_memory(CL_MEM_READ_ONLY | CL_MEM_HOST_WRITE_ONLY, SHARED_BYTES),
      true, false);
  check_access(
      &s, new_memory(CL_MEM_WRITE_ONLY | CL_MEM_HOST_READ_ONLY, SHARED_BYTES),
      false, true);
  setup_free(&s);
}

TEST(parts_have_their_own_access_or_the_parents) {
  setup s;
  start(&s);
  cl_mem any = new_memory(CL_MEM_READ_WRITE, SHARED_BYTES);
  cl_mem read = new_memory(CL_MEM_READ_ONLY, SHARED_BYTES);
  cl_mem write = new_memory(CL_MEM_WRITE_ONLY, SHARED_BYTES);
  check_access(&s, new_part(any, CL_MEM_READ_ONLY, ALIGNMENT, ALIGNMENT), true,
               false);
  check_access(&s, new_part(any, CL_MEM_WRITE_ONLY, ALIGNMENT, ALIGNMENT),
               false, true);
  check_access(&s, new_part(any, 0, ALIGNMENT, ALIGNMENT), true, true);
  check_access(&s, new_part(read, 0, ALIGNMENT, ALIGNMENT), true, false);
  check_access(&s, new_part(write, 0, ALIGNMENT, ALIGNMENT), false, true);
  clReleaseMemObject(any);
  clReleaseMemObject(read);
  clReleaseMemObject(write);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Size                                                                      */

/* Pitches whose products wrap around are no way past the check. */
TEST(huge_pitches_are_rejected) {
  setup s;
  start(&s);
  cl_mem tiny = new_memory(CL_MEM_READ_WRITE, 8); /* less than a row */
  assert_memory_rejected(&s, PLANE_AO, tiny, " bytes do not fit in its buffer");
  clReleaseMemObject(tiny);
  s.frame.ao.row_pitch = (size_t)1 << 63;
  assert_plane_rejected(&s, PLANE_AO, ".row_pitch");
  s.frame.ao.row_pitch = 0;
  s.frame.emission.plane_pitch = (size_t)1 << 63;
  setup_run(&s, hbil_enqueue_frame); /* not planar: of no meaning */
  s.frame.bent_normal.row_pitch = WIDTH * 16 - 8;
  assert_plane_rejected(&s, PLANE_BENT, ".row_pitch");
  s.frame.bent_normal.row_pitch = WIDTH * 16 - 4;
  setup_run(&s, hbil_enqueue_frame);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Shared memory: chosen cases                                               */

enum { ROW = 16 * WIDTH, IMAGE = ROW * HEIGHT };

/* Where near_irradiance, ao and bent_normal lie in one buffer. */
typedef struct sharing {
  const char *what;
  struct {
    size_t offset, row_pitch;
  } at[SHOWN];
  const char *blamed; /* NULL: accepted */
} sharing;

static const sharing sharings[] = {
    {"one after the other", {{0, 0}, {IMAGE, 0}, {2 * IMAGE, 0}}, NULL},
    {"another row_pitch behind the last byte",
     {{0, 0}, {IMAGE - 4, 2 * ROW}, {4 * IMAGE, 0}},
     NULL},
    {"ao is the fourth component of bent_normal",
     {{IMAGE, 0}, {12, 0}, {0, 0}},
     NULL},
    {"ao is the last half of near_irradiance",
     {{0, 0}, {14, 0}, {IMAGE, 0}},
     NULL},
    {"ao begins in the row before, as the fourth component",
     {{IMAGE + ROW, 0}, {12, 0}, {ROW, 0}},
     NULL},
    {"side by side", {{0, 3 * ROW}, {ROW, 3 * ROW}, {2 * ROW, 3 * ROW}}, NULL},
    {"side by side, one of them a row further down",
     {{0, 3 * ROW}, {4 * ROW, 3 * ROW}, {2 * ROW, 3 * ROW}},
     NULL},
    {"side by side, ao in the pixels of bent_normal",
     {{0, 2 * ROW}, {ROW + 12, 2 * ROW}, {ROW, 2 * ROW}},
     NULL},
    {"common pixels of rows that are no multiple of a pixel",
     {{IMAGE + 3 * 4, 0}, {12, ROW + 4}, {0, ROW + 4}},
     NULL},
    {"all the same bytes", {{0, 0}, {0, 0}, {0, 0}}, "ao"},
    {"ao is the third component of bent_normal",
     {{IMAGE, 0}, {8, 0}, {0, 0}},
     "bent_normal"},
    {"ao is half of the third component of bent_normal",
     {{IMAGE, 0}, {10, 0}, {0, 0}},
     "bent_normal"},
    {"bent_normal begins at the last half of ao",
     {{0, 0}, {IMAGE, 0}, {2 * IMAGE - 16, 0}},
     "bent_normal"},
    {"side by side, too close by a pixel",
     {{0, 3 * ROW}, {ROW, 3 * ROW}, {2 * ROW - 16, 3 * ROW}},
     "bent_normal"},
    {"one inside of a wider row_pitch's rows",
     {{0, 2 * ROW}, {ROW, 4 * ROW}, {8 * IMAGE, 0}},
     "ao"},
};

static void place(setup *s, const sharing *how, cl_mem memory) {
  for (int i = 0; i < SHOWN; ++i)
    *plane_slot(&s->frame, shown[i]) =
        (hbil_plane){memory, how->at[i].offset, how->at[i].row_pitch, 0};
}

static placement placement_at(setup *s, plane_id id) {
  const plane_layout none = {0, 0, 0};
  const hbil_plane *slot = plane_slot(&s->frame, id);
  placement p = place_plane(&s->config, id, &none);
  p.offset = slot->offset;
  if (slot->row_pitch)
    p.row = slot->row_pitch;
  if (p.plane > p.size) /* planar */
    p.plane = slot->plane_pitch ? slot->plane_pitch : p.row * s->config.height;
  return p;
}

/* Reads an output's values, wherever it lies. */
static void read_output(setup *s, plane_id id, float *values) {
  const placement p = placement_at(s, id);
  unsigned char *bytes =
      buffer_bytes(s->device, plane_slot(&s->frame, id)->buffer, NULL);
  for (int c = 0; c < plane_channels(id); ++c)
    for (size_t y = 0; y < HEIGHT; ++y)
      for (size_t x = 0; x < WIDTH; ++x)
        *values++ = (float)component_value(
            p.component, bytes + placement_of(&p, c, x, y), c);
  free(bytes);
}

/* What is accepted gives the same bits as planes in buffers of their own. */
TEST(outputs_share_memory_as_the_header_says) {
  setup s;
  float want[SHOWN][3 * WIDTH * HEIGHT] = {{0}},
                                got[SHOWN][3 * WIDTH * HEIGHT] = {{0}};
  start(&s);
  setup_run(&s, hbil_enqueue_frame);
  for (int i = 0; i < SHOWN; ++i)
    read_output(&s, shown[i], want[i]);
  const hbil_frame own = s.frame;
  cl_mem memory = new_memory(CL_MEM_READ_WRITE, SHARED_BYTES);
  for (size_t k = 0; k < sizeof sharings / sizeof *sharings; ++k) {
    const sharing *how = &sharings[k];
    place(&s, how, memory);
    const hbil_status status =
        hbil_enqueue_frame(s.plan, s.device->queue, &s.frame, 0, NULL, NULL);
    if ((status == HBIL_SUCCESS) != !how->blamed)
      fail_msg("%s: %s", how->what, hbil_context_message(s.device->hbil));
    if (how->blamed) {
      assert_int_equal(status, HBIL_INVALID_FRAME);
      assert_message(how->blamed, ": overlaps ");
      continue;
    }
    for (int i = 0; i < SHOWN; ++i)
      read_output(&s, shown[i], got[i]);
    if (memcmp(got, want, sizeof got))
      fail_msg("%s: other bits than in buffers of their own", how->what);
  }
  s.frame = own;
  clReleaseMemObject(memory);
  setup_free(&s);
}

/* Sub-buffers that begin at `begins[0]` for ao and at `begins[1]` for
 * bent_normal, whose offsets are `offsets`. */
static void check_parts(setup *s, cl_mem parent, const size_t begins[2],
                        const size_t offsets[2], bool accepted) {
  const hbil_frame own = s->frame;
  for (int i = 0; i < 2; ++i)
    *plane_slot(&s->frame, shown[1 + i]) = (hbil_plane){
        new_part(parent, 0, begins[i], 2 * ALIGNMENT), offsets[i], 0, 0};
  if (accepted)
    setup_run(s, hbil_enqueue_frame);
  else
    assert_plane_rejected(s, PLANE_BENT, ": overlaps ao");
  for (int i = 0; i < 2; ++i)
    clReleaseMemObject(plane_slot(&s->frame, shown[1 + i])->buffer);
  s->frame = own;
}

TEST(overlap_is_seen_through_sub_buffers) {
  const size_t both[] = {0, ALIGNMENT}, same[] = {ALIGNMENT, ALIGNMENT};
  setup s;
  start(&s);
  cl_mem parent = new_memory(CL_MEM_READ_WRITE, SHARED_BYTES);
  check_parts(&s, parent, both, (const size_t[]){0, 0}, true);
  check_parts(&s, parent, both, (const size_t[]){ALIGNMENT, 0}, false);
  check_parts(&s, parent, both, (const size_t[]){ALIGNMENT, IMAGE}, true);
  check_parts(&s, parent, both, (const size_t[]){ALIGNMENT + 12, 0}, true);
  check_parts(&s, parent, same, (const size_t[]){0, 0}, false);
  check_parts(&s, parent, same, (const size_t[]){12, 0}, true);
  /* a part and the parent itself */
  const hbil_plane ao = s.frame.ao, bent_normal = s.frame.bent_normal;
  s.frame.ao = (hbil_plane){parent, ALIGNMENT, 0, 0};
  s.frame.bent_normal =
      (hbil_plane){new_part(parent, 0, ALIGNMENT, ALIGNMENT), 0, 0, 0};
  assert_plane_rejected(&s, PLANE_BENT, ": overlaps ao");
  s.frame.ao.offset += 12;
  setup_run(&s, hbil_enqueue_frame);
  clReleaseMemObject(s.frame.bent_normal.buffer);
  s.frame.ao = ao;
  s.frame.bent_normal = bent_normal;
  clReleaseMemObject(parent);
  setup_free(&s);
}

TEST(inputs_may_share_outputs_must_not) {
  setup s;
  start(&s);
  const hbil_frame own = s.frame;
  s.frame.albedo = s.frame.emission = s.frame.direct;
  setup_run(&s, hbil_enqueue_frame);
  s.frame.near_irradiance.buffer = s.frame.direct.buffer;
  assert_plane_rejected(&s, PLANE_NEAR, ": overlaps albedo");
  s.frame = own;
  s.frame.depth.buffer = s.frame.near_irradiance.buffer;
  assert_plane_rejected(&s, PLANE_NEAR, ": overlaps depth");
  s.frame = own;
  setup_free(&s);
}

/* The split doesn't write near_irradiance, and the composite doesn't read
 * normal. */
TEST(passes_check_their_own_planes) {
  setup s;
  start(&s);
  const hbil_frame own = s.frame;
  s.frame.normal.buffer = s.frame.near_irradiance.buffer;
  assert_rejected(&s, hbil_enqueue_frame, PLANE_NEAR, ": overlaps normal");
  setup_run(&s, enqueue_split);
  setup_run(&s, enqueue_composite);
  s.frame = own;
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* Shared memory: any layout                                                 */

/* Whether an output's byte is also another's or its own, byte by byte. */
static bool bytes_overlap(setup *s) {
  static bool taken[SHARED_BYTES];
  memset(taken, 0, sizeof taken);
  for (int i = 0; i < SHOWN; ++i) {
    const placement p = placement_at(s, shown[i]);
    for (int c = 0; c < plane_channels(shown[i]); ++c)
      for (size_t y = 0; y < s->config.height; ++y)
        for (size_t x = 0; x < s->config.width; ++x)
          for (size_t b = 0; b < p.size; ++b) {
            const size_t at = placement_of(&p, c, x, y) + b;
            assert_true(at < SHARED_BYTES);
            if (taken[at])
              return true;
            taken[at] = true;
          }
  }
  return false;
}

static size_t draw(random_state *r, size_t below) {
  return (size_t)(random_unit(r) * (double)below);
}

/* Places all outputs at random within `rows` rows, more or less; true if all
 * have the same row_pitch. */
static bool draw_places(setup *s, random_state *r, size_t row, size_t rows) {
  const size_t wider[] = {row, row, row + 4, row + row / 4 * 4, 3 * row};
  const size_t pitch = wider[draw(r, 5)], reach = pitch * (1 + draw(r, rows));
  bool same = true;
  for (int i = 0; i < SHOWN; ++i) {
    hbil_plane *slot = plane_slot(&s->frame, shown[i]);
    slot->offset = 4 * draw(r, reach / 4);
    slot->row_pitch = draw(r, 8) ? pitch : wider[draw(r, 5)];
    /* channels within rows, row by row, or one after the other */
    slot->plane_pitch = draw(r, 2) ? row : 4 * draw(r, reach / 4);
    same = same && slot->row_pitch == pitch;
  }
  return same;
}

/* The distance of all outputs' pixels in bytes; 0 if they differ. */
static size_t common_pixel(setup *s) {
  const size_t pixel = placement_at(s, shown[0]).pixel;
  for (int i = 1; i < SHOWN; ++i)
    if (placement_at(s, shown[i]).pixel != pixel)
      return 0;
  return pixel;
}

/* The library rejects all that overlap.  It accepts all others if both rows and
 * pixels are equally far apart in all planes.  Rows have at least `pixel` bytes
 * a pixel. */
static void check_random_places(const hbil_plane_format formats[SHOWN],
                                size_t pixel, size_t rows, int width,
                                int height) {
  random_state r = {17};
  setup s;
  int accepted = 0, rejected = 0, too_careful = 0;
  setup_init(&s, width, height);
  s.config.history.reprojection = HBIL_REPROJECTION_NONE;
  for (int i = 0; i < SHOWN; ++i)
    *plane_format(&s.config, shown[i]) = formats[i];
  setup_start(&s);
  const hbil_frame own = s.frame;
  cl_mem memory = new_memory(CL_MEM_READ_WRITE, SHARED_BYTES);
  for (int i = 0; i < SHOWN; ++i)
    plane_slot(&s.frame, shown[i])->buffer = memory;
  for (int i = 0; i < 1000; ++i) {
    const bool same_rows = draw_places(&s, &r, pixel * (size_t)width, rows);
    const bool overlap = bytes_overlap(&s);
    const hbil_status status =
        enqueue_composite(s.plan, s.device->queue, &s.frame, 0, NULL, NULL);
    if (overlap)
      assert_int_equal(status, HBIL_INVALID_FRAME);
    else if (same_rows && common_pixel(&s))
      assert_success(&s, status);
    accepted += status == HBIL_SUCCESS;
    rejected += overlap;
    too_careful += !overlap && status != HBIL_SUCCESS;
  }
  if (getenv("HBIL_TEST_VERBOSE"))
    printf("# %d x %d: %d accepted, %d overlap, %d apart but rejected\n", width,
           height, accepted, rejected, too_careful);
  assert_in_range(accepted, 50, 950);
  assert_in_range(rejected, 50, 950);
  assert_int_equal(clFinish(s.device->queue), CL_SUCCESS);
  s.frame = own;
  clReleaseMemObject(memory);
  setup_free(&s);
}

TEST(interleaved_planes_are_told_apart) {
  const hbil_plane_format formats[SHOWN] = {
      {HBIL_FLOAT16, 28}, {HBIL_FLOAT32, 28}, {HBIL_FLOAT32, 28}};
  check_random_places(formats, 28, 3, WIDTH, HEIGHT);
  check_random_places(formats, 28, 3, WIDTH, 1);
  check_random_places(formats, 28, 3, 1, HEIGHT);
}

TEST(planar_planes_are_told_apart) {
  const hbil_plane_format formats[SHOWN] = {
      {HBIL_FLOAT32, 4}, {HBIL_FLOAT32, 4}, {HBIL_FLOAT32, 4}};
  check_random_places(formats, 4, 60, WIDTH, HEIGHT);
  check_random_places(formats, 4, 60, WIDTH, 1);
}

TEST(planes_of_several_kinds_are_told_apart) {
  const hbil_plane_format formats[SHOWN] = {
      {HBIL_FLOAT16, 28}, {HBIL_FLOAT32, 4}, {HBIL_FLOAT32, 20}};
  check_random_places(formats, 28, 8, WIDTH, HEIGHT);
}
