/*
 * Results on disk: they take over the attributes of a frame but for those of
 * its own storage, and preserve windows and types of pixels, in every
 * compression.
 *
 * The frame is made with OpenEXRCore, which writes none of our files.
 */
#define _POSIX_C_SOURCE 200809L
#include "test/support/compare.h"

#include <math.h>
#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "image/exr_checksum.h"
#include "image/exr_key.h"
#include "image/exr_read.h"
#include "image/exr_write.h"
#include "image/image.h"

enum { WIDTH = 37, HEIGHT = 21, PIXELS = WIDTH * HEIGHT, CHANNELS = 3 };

/* A data window within the display window, off its corner. */
static const exr_attr_box2i_t data = {.min = {.x = -5, .y = 3},
                                      .max = {.x = WIDTH - 6, .y = HEIGHT + 2}};
static const exr_attr_box2i_t display = {.min = {.x = -8, .y = 0},
                                         .max = {.x = 63, .y = 47}};
static const exr_attr_chromaticities_t primaries = {.red_x = 0.713f,
                                                    .red_y = 0.293f,
                                                    .green_x = 0.165f,
                                                    .green_y = 0.83f,
                                                    .blue_x = 0.128f,
                                                    .blue_y = 0.044f,
                                                    .white_x = 0.32168f,
                                                    .white_y = 0.33767f};

static char frame_path[64], result_path[64];

/* In the order of the file, which is that of the alphabet. */
static const char *const names[CHANNELS] = {"Depth.Z", "crypto.id", "half.V"};
static float depth[PIXELS], halves[PIXELS];
static uint32_t ids[PIXELS];

static void fill_planes(void) {
  for (unsigned i = 0; i < PIXELS; i++) {
    depth[i] = 1.0f / (float)(i + 3);
    ids[i] = 0x80000000u + i * 2654435761u; /* more than a float can hold */
    halves[i] = 4.0f + (float)(i % WIDTH + i / WIDTH) / 16.0f; /* exact */
  }
}

/* ------------------------------------------------------------------------ */
/* The frame                                                                 */

static void works(exr_result_t result) {
  if (result != EXR_ERR_SUCCESS)
    fail_msg("%s", exr_get_default_error_message(result));
}

static void declare_frame(exr_context_t file, exr_compression_t compression) {
  const exr_attr_v2f_t centre = {.x = 0.25f, .y = -0.5f};
  exr_attr_m44f_t matrix = {{0.0f}};
  int part;
  matrix.m[0] = matrix.m[5] = matrix.m[10] = matrix.m[15] = 2.0f;
  works(exr_set_longname_support(file, 1));
  works(exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part));
  works(exr_initialize_required_attr(file, part, &display, &data, 2.0f, &centre,
                                     1.5f, EXR_LINEORDER_INCREASING_Y,
                                     compression));
  works(exr_attr_set_chromaticities(file, part, "chromaticities", &primaries));
  works(exr_attr_set_m44f(file, part, "worldToCamera", &matrix));
  works(exr_attr_set_string(file, part, "owner", "somebody"));
  works(exr_attr_set_string(file, part, "hbilKey", "another frame's"));
  works(exr_attr_set_int(file, part, "acesImageContainerFlag", 1));
  works(exr_attr_set_user(file, part, "oddThing", "studioType", 5, "12345"));
  works(exr_add_channel(file, part, names[0], EXR_PIXEL_FLOAT,
                        EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
  works(exr_add_channel(file, part, names[1], EXR_PIXEL_UINT,
                        EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
  works(exr_add_channel(file, part, names[2], EXR_PIXEL_HALF,
                        EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
  works(exr_write_header(file));
}

static void encode_frame(exr_context_t file) {
  const void *planes[CHANNELS] = {depth, ids, halves};
  exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
  int32_t lines;
  works(exr_get_scanlines_per_chunk(file, 0, &lines));
  for (int y = 0; y < HEIGHT; y += lines) {
    exr_chunk_info_t chunk;
    works(exr_write_scanline_chunk_info(file, 0, data.min.y + y, &chunk));
    works(y ? exr_encoding_update(file, 0, &chunk, &encoder)
            : exr_encoding_initialize(file, 0, &chunk, &encoder));
    for (int c = 0; c < CHANNELS; c++) {
      exr_coding_channel_info_t *channel = &encoder.channels[c];
      channel->encode_from_ptr =
          (const uint8_t *)planes[c] + 4 * (size_t)(y * WIDTH);
      channel->user_data_type = c == 1 ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
      channel->user_bytes_per_element = channel->user_pixel_stride = 4;
      channel->user_line_stride = 4 * WIDTH;
    }
    if (!y)
      works(exr_encoding_choose_default_routines(file, 0, &encoder));
    works(exr_encoding_run(file, 0, &encoder));
  }
  works(exr_encoding_destroy(file, &encoder));
}

static void write_frame(exr_compression_t compression) {
  const exr_context_initializer_t plain = EXR_DEFAULT_CONTEXT_INITIALIZER;
  exr_context_t file;
  works(exr_start_write(&file, frame_path, EXR_WRITE_FILE_DIRECTLY, &plain));
  declare_frame(file, compression);
  encode_frame(file);
  works(exr_finish(&file));
}

/* ------------------------------------------------------------------------ */
/* The result                                                                */

static image read_frame(void) {
  image source;
  image_error error;
  if (exr_read_as_is(frame_path, names, CHANNELS, &source, &error) != 0)
    fail_msg("%s", error.text);
  return source;
}

static void write_result(const image *img, int compression, const char *like) {
  const exr_style style = {compression, like, EXISTING_REPLACED};
  image_error error;
  if (exr_write_as(result_path, img, NULL, &style, &error) != 0)
    fail_msg("%s", error.text);
}

static exr_context_t open_result(void) {
  const exr_context_initializer_t plain = EXR_DEFAULT_CONTEXT_INITIALIZER;
  exr_context_t file;
  works(exr_start_read(&file, result_path, &plain));
  return file;
}

TEST(types_are_kept_bit_by_bit) {
  write_frame(EXR_COMPRESSION_ZIP);
  image source = read_frame();
  assert_int_equal(image_find(&source, names[0])->type, IMAGE_FLOAT);
  assert_int_equal(image_find(&source, names[1])->type, IMAGE_UINT);
  assert_int_equal(image_find(&source, names[2])->type, IMAGE_HALF);
  assert_memory_equal(image_find(&source, names[0])->pixels, depth,
                      sizeof depth);
  assert_memory_equal(image_find(&source, names[1])->pixels, ids, sizeof ids);
  assert_memory_equal(image_find(&source, names[2])->pixels, halves,
                      sizeof halves);
  image_free(&source);
}

/* pxr24 rounds floats to 15 bits of mantissa. Of the others, B44 rounds
 * halves, but not this ramp, and DWA rounds channels whose names are those of
 * colours. */
TEST(every_compression_holds_what_it_promises) {
  const float rounding = 0x1p-16f;
  write_frame(EXR_COMPRESSION_ZIP);
  image source = read_frame();
  for (int c = 0; exr_compressions[c]; c++) {
    image again;
    image_error error;
    write_result(&source, c, frame_path);
    if (exr_read_as_is(result_path, names, CHANNELS, &again, &error) != 0)
      fail_msg("%s: %s", exr_compressions[c], error.text);
    assert_int_equal(again.x, data.min.x);
    assert_int_equal(again.y, data.min.y);
    if (c != EXR_COMPRESSION_PXR24)
      assert_memory_equal(again.planes[0].pixels, depth, sizeof depth);
    for (int i = 0; i < PIXELS; i++)
      assert_true(fabsf(again.planes[0].pixels[i] - depth[i]) <=
                  rounding * depth[i]);
    assert_memory_equal(again.planes[1].pixels, ids, sizeof ids);
    assert_memory_equal(again.planes[2].pixels, halves, sizeof halves);
    image_free(&again);
  }
  image_free(&source);
}

TEST(the_compression_can_be_that_of_the_frame) {
  static const exr_compression_t frames[] = {EXR_COMPRESSION_PIZ,
                                             EXR_COMPRESSION_RLE};
  for (size_t i = 0; i < 2; i++) {
    exr_compression_t found;
    write_frame(frames[i]);
    image source = read_frame();
    write_result(&source, EXR_COMPRESSION_OF_INPUT, frame_path);
    image_free(&source);
    exr_context_t file = open_result();
    works(exr_get_compression(file, 0, &found));
    assert_int_equal(found, frames[i]);
    works(exr_finish(&file));
  }
}

static void check_required(exr_const_context_t file) {
  exr_attr_box2i_t window;
  exr_attr_v2f_t centre;
  float number;
  works(exr_get_display_window(file, 0, &window));
  assert_memory_equal(&window, &display, sizeof window);
  works(exr_get_data_window(file, 0, &window));
  assert_memory_equal(&window, &data, sizeof window);
  works(exr_get_pixel_aspect_ratio(file, 0, &number));
  assert_true(number == 2.0f);
  works(exr_get_screen_window_center(file, 0, &centre));
  assert_true(centre.x == 0.25f && centre.y == -0.5f);
  works(exr_get_screen_window_width(file, 0, &number));
  assert_true(number == 1.5f);
}

TEST(attributes_are_taken_over) {
  exr_attr_chromaticities_t colours;
  exr_attr_m44f_t matrix;
  const char *text = NULL, *type = NULL;
  const void *bytes = NULL;
  int32_t length;
  write_frame(EXR_COMPRESSION_ZIP);
  image source = read_frame();
  snprintf(source.key, sizeof source.key, "ours");
  write_result(&source, EXR_COMPRESSION_OF_ZIP, frame_path);
  image_free(&source);
  exr_context_t file = open_result();
  check_required(file);
  works(exr_attr_get_chromaticities(file, 0, "chromaticities", &colours));
  assert_memory_equal(&colours, &primaries, sizeof colours);
  works(exr_attr_get_m44f(file, 0, "worldToCamera", &matrix));
  assert_true(matrix.m[5] == 2.0f && matrix.m[1] == 0.0f);
  works(exr_attr_get_string(file, 0, "owner", &length, &text));
  assert_string_equal(text, "somebody");
  works(exr_attr_get_user(file, 0, "oddThing", &type, &length, &bytes));
  assert_string_equal(type, "studioType");
  assert_int_equal(length, 5);
  assert_memory_equal(bytes, "12345", 5);
  works(exr_finish(&file));
}

/* What the result says about its layers. */
static void check_radii(float near, float ao) {
  image result;
  image_error error;
  assert_int_equal(exr_read_header(result_path, &result, &error), 0);
  assert_true(result.near_radius == near && result.ao_radius == ao);
  image_free(&result);
}

TEST(what_would_be_untrue_is_not) {
  const char *text = NULL;
  int32_t length, flag;
  write_frame(EXR_COMPRESSION_ZIP);
  image source = read_frame();
  snprintf(source.key, sizeof source.key, "ours");
  source.near_radius = 0.25f;
  source.ao_radius = INFINITY;
  write_result(&source, EXR_COMPRESSION_OF_ZIP, frame_path);
  check_radii(0.25f, INFINITY);
  source.key[0] = '\0';
  source.near_radius = source.ao_radius = 0.0f;
  exr_context_t file = open_result();
  works(exr_attr_get_string(file, 0, EXR_KEY, &length, &text));
  assert_string_equal(text, "ours");
  assert_int_not_equal(
      exr_attr_get_int(file, 0, "acesImageContainerFlag", &flag),
      EXR_ERR_SUCCESS);
  works(exr_finish(&file));
  write_result(&source, EXR_COMPRESSION_OF_ZIP, frame_path);
  check_radii(0.0f, 0.0f);
  file = open_result();
  assert_int_not_equal(exr_attr_get_string(file, 0, EXR_KEY, &length, &text),
                       EXR_ERR_SUCCESS);
  works(exr_finish(&file));
  image_free(&source);
}

/* The bytes of the result; malloc'd. */
static unsigned char *bytes_of(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fseek(file, 0, SEEK_END), 0);
  *size = (size_t)ftell(file);
  rewind(file);
  unsigned char *bytes = malloc(*size);
  assert_non_null(bytes);
  assert_int_equal(fread(bytes, 1, *size, file), *size);
  fclose(file);
  return bytes;
}

static void write_bytes(const unsigned char *bytes, size_t size) {
  FILE *file = fopen(result_path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  fclose(file);
}

static exr_checksum_state state_of(const unsigned char *bytes, size_t size) {
  write_bytes(bytes, size);
  return exr_checksum_look(result_path);
}

/* Every byte of the header and many of the others: a file with one changed, or
 * that ends early or late, isn't taken for what was written. */
TEST(a_checksum_covers_every_byte) {
  size_t size;
  write_frame(EXR_COMPRESSION_ZIP);
  image source = read_frame();
  for (int c = 0; c < EXR_COMPRESSION_OF_INPUT; c += 3) {
    snprintf(source.key, sizeof source.key, "ours");
    write_result(&source, c, frame_path);
    assert_int_equal(exr_checksum_look(result_path), EXR_CHECKSUM_RIGHT);
    unsigned char *bytes = bytes_of(result_path, &size);
    for (size_t i = 0; i < size; i += i < 1500 ? 1 : 197) {
      bytes[i] ^= 0x10;
      assert_int_not_equal(state_of(bytes, size), EXR_CHECKSUM_RIGHT);
      bytes[i] ^= 0x10;
    }
    for (size_t end = 0; end < size; end += end < 1500 ? 97 : 977)
      assert_int_not_equal(state_of(bytes, end), EXR_CHECKSUM_RIGHT);
    bytes = realloc(bytes, size + 1);
    assert_non_null(bytes);
    bytes[size] = 0;
    assert_int_equal(state_of(bytes, size + 1), EXR_CHECKSUM_WRONG);
    assert_int_equal(state_of(bytes, size), EXR_CHECKSUM_RIGHT);
    free(bytes);
  }
  source.key[0] = '\0';
  write_result(&source, EXR_COMPRESSION_OF_ZIP, frame_path);
  assert_int_equal(exr_checksum_look(result_path), EXR_CHECKSUM_MISSING);
  assert_int_equal(exr_checksum_look("/"), EXR_CHECKSUM_MISSING);
  image_free(&source);
}

/* No changed byte of a compressed chunk changes a pixel, and all but those with
 * bits that deflate leaves open are told. */
TEST(damage_in_zip_is_told) {
  enum { BYTES = 200 };
  int told = 0;
  size_t size;
  write_frame(EXR_COMPRESSION_ZIP);
  image source = read_frame();
  unsigned char *bytes = bytes_of(frame_path, &size);
  for (size_t i = size - BYTES; i < size; i++) {
    image again;
    image_error error;
    bytes[i] ^= 0x10;
    write_bytes(bytes, size);
    if (exr_read_as_is(result_path, names, CHANNELS, &again, &error) != 0) {
      told++;
    } else {
      for (int c = 0; c < CHANNELS; c++)
        assert_memory_equal(again.planes[c].pixels, source.planes[c].pixels,
                            sizeof depth);
      image_free(&again);
    }
    bytes[i] ^= 0x10;
  }
  assert_in_range(told, BYTES - 2, BYTES);
  free(bytes);
  image_free(&source);
}

TEST(a_file_of_another_kind_has_no_attributes) {
  char other[sizeof result_path + 4];
  write_frame(EXR_COMPRESSION_ZIP);
  image source = read_frame();
  snprintf(other, sizeof other, "%s.txt", result_path);
  for (int length = 0; length < 9;
       length += 8) { /* shorter than any EXR, too */
    exr_attr_box2i_t window;
    FILE *file = fopen(other, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite("no image", 1, (size_t)length, file), length);
    fclose(file);
    write_result(&source, EXR_COMPRESSION_OF_INPUT, other);
    exr_context_t result = open_result();
    works(exr_get_display_window(result, 0, &window));
    assert_memory_equal(&window, &display, sizeof window);
    works(exr_finish(&result));
  }
  unlink(other);
  image_free(&source);
}

TEST(finite_values_stay_finite_as_halves) {
  static const float values[] = {1e9f,      -1e9f, 65519.0f, INFINITY,
                                 -INFINITY, NAN,   1.5f};
  static const float stored[] = {65504.0f,  -65504.0f, 65504.0f, INFINITY,
                                 -INFINITY, NAN,       1.5f};
  enum { COUNT = sizeof values / sizeof *values };
  const unsigned char half[] = {1};
  image img = {.width = COUNT, .height = 1}, again;
  const char *const name[] = {"light.R"};
  image_error error;
  memcpy(image_add(&img, name[0])->pixels, values, sizeof values);
  assert_int_equal(exr_write(result_path, &img, half, &error), 0);
  assert_int_equal(exr_read_as_is(result_path, name, 1, &again, &error), 0);
  assert_int_equal(again.planes[0].type, IMAGE_HALF);
  for (int i = 0; i < COUNT; i++)
    assert_true(isnan(stored[i]) ? isnan(again.planes[0].pixels[i])
                                 : again.planes[0].pixels[i] == stored[i]);
  image_free(&img);
  image_free(&again);
}

static int make_paths(void **state) {
  (void)state;
  fill_planes();
  snprintf(frame_path, sizeof frame_path, "/tmp/hbil-frame%ld.exr",
           (long)getpid());
  snprintf(result_path, sizeof result_path, "/tmp/hbil-result%ld.exr",
           (long)getpid());
  return 0;
}

static int remove_files(void **state) {
  (void)state;
  unlink(frame_path);
  unlink(result_path);
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Threads                                                                   */

/* More than a thread reads alone. */
enum { WIDE = 640, HIGH = 500, WIDE_PIXELS = WIDE * HIGH };

static void write_wide(image *img) {
  image_error error;
  const exr_style style = {EXR_COMPRESSION_OF_ZIP, NULL, EXISTING_REPLACED};
  img->width = WIDE;
  img->height = HIGH;
  for (int c = 0; c < 2; c++) {
    float *pixels = image_add(img, c ? "b" : "a")->pixels;
    for (size_t i = 0; i < WIDE_PIXELS; i++)
      pixels[i] = (float)((i + (size_t)c) * 2654435761u % 1000003u);
  }
  if (exr_write_as(result_path, img, NULL, &style, &error) != 0)
    fail_msg("%s", error.text);
}

TEST(large_images_are_read_completely) {
  static const char *const wide_names[] = {"a", "b"};
  image img = {0}, again;
  image_error error;
  write_wide(&img);
  if (exr_read(result_path, wide_names, 2, &again, &error) != 0)
    fail_msg("%s", error.text);
  for (size_t c = 0; c < 2; c++)
    assert_memory_equal(again.planes[c].pixels, img.planes[c].pixels,
                        sizeof(float) * WIDE_PIXELS);
  image_free(&again);
  image_free(&img);
}

/* Two chunks are damaged in different ways, and the message is always that on
 * the first one. */
TEST(damage_is_reported_alike) {
  static const char *const wide_names[] = {"a", "b"};
  image img = {0}, again;
  image_error first, error;
  write_wide(&img);
  FILE *file = fopen(result_path, "r+b");
  assert_non_null(file);
  assert_int_equal(fseek(file, 0, SEEK_END), 0);
  const long size = ftell(file);
  static const char nonsense[64] = "nonsense";
  assert_int_equal(fseek(file, size / 2, SEEK_SET), 0);
  assert_int_equal(fwrite(nonsense, 1, sizeof nonsense, file), 64);
  assert_int_equal(fclose(file), 0);
  assert_int_equal(truncate(result_path, size - size / 8), 0);
  assert_int_not_equal(exr_read(result_path, wide_names, 2, &again, &first), 0);
  for (int i = 0; i < 20; i++) {
    assert_int_not_equal(exr_read(result_path, wide_names, 2, &again, &error),
                         0);
    assert_string_equal(error.text, first.text);
  }
  image_free(&img);
}

int main(void) {
  return tests_run_with(make_paths, remove_files);
}
