/*
 * Images on the host: named planes of floats.  Knows files, no light.
 *
 * Every function that can fail returns 0 on success and fills `error` with one
 * sentence otherwise ("PATH: what is wrong; what would be right").  Nothing is
 * left behind on failure: no memory, no half-written file.
 */
#ifndef HBIL_IMAGE_H
#define HBIL_IMAGE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Two paths of the greatest length, and what is wrong with them. */
enum { IMAGE_ERROR_SIZE = 2 * 4096 + 1024 };
typedef struct image_error {
  char text[IMAGE_ERROR_SIZE];
} image_error;

/* What a file has for each pixel.  Memory has floats for both of the first. */
typedef enum image_type { IMAGE_FLOAT = 0, IMAGE_HALF, IMAGE_UINT } image_type;

/* One channel: width*height floats, row-major, top row first. */
typedef struct image_plane {
  char name[256];  /* full channel name, e.g. "ViewLayer.Depth.Z" */
  float *pixels;   /* owned by the image; NULL in a header-only image */
  image_type type; /* IMAGE_UINT: the pixels are the bits of integers */
} image_plane;

typedef struct image_window {
  int32_t x, y; /* of the top left pixel */
  uint32_t width, height;
} image_window;

/* What a renderer says of its camera in the header, as the file has it. */
typedef struct image_matrices {
  int has_camera, has_ndc;
  double world_to_camera[16], world_to_ndc[16];
} image_matrices;

typedef struct image {
  uint32_t width, height; /* of the data window */
  int32_t x, y;           /* its top left corner */
  image_window display;   /* what is to be seen; width 0: the data window */
  size_t count;
  image_plane *planes;
  image_matrices matrices;
  char origin[128]; /* what the header tells of the program that wrote it */
  int gamma;        /* colours are stored as sRGB, not linear */
  char key[32]; /* what it was made from, attribute hbilKey; "" where none */
} image;

/* Fills `error` (NULL is allowed) as printf does; returns -1. */
int image_fail(image_error *error, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* The same for memory that ran out while working on `path`. */
int image_no_memory(image_error *error, const char *path);

void image_free(image *img); /* allowed on a zeroed image and twice */

/* The plane of that name, or NULL. */
image_plane *image_find(const image *img, const char *name);

/* Adds a zeroed plane; returns it or NULL (out of memory). The pointers of
 * other image_plane structs may move, their pixels do not. */
image_plane *image_add(image *img, const char *name);

/* The same without pixels: for header-only images. */
image_plane *image_declare(image *img, const char *name);

/* Where the pixels are, and what of them is to be seen. */
image_window image_data_window(const image *img);
image_window image_display_window(const image *img);
/* The smallest window that holds both, and the largest in both (0 x 0 where
 * there is none). */
image_window image_window_union(image_window a, image_window b);
image_window image_window_common(image_window a, image_window b);

/* A plane of `from` as a plane of `to`, zero where it has no pixels; both
 * planes are their windows' size. */
void image_place(const float *pixels, image_window from, float *out,
                 image_window to);

/* Any file of planes: EXR, and what formats_recognise() knows. */
int image_read_header(const char *path, image *out, image_error *error);
int image_read(const char *path, const char *const *names, size_t count,
               image *out, image_error *error);

/* --- EXR, through OpenEXRCore (exr.c) and OpenEXR (exr_write.cpp) --- */

/* Attribute of image.key. */
#define EXR_KEY "hbilKey"

/*
 * Flat scanline and tiled files, single and multi-part.  The first flat part
 * gives the size; channels are those of all flat parts of the same data window.
 * A name that an earlier part has used already is listed as PART.NAME; so is
 * one without a layer in a part behind the first, which is a layer by itself.
 *
 * Whatever a file claims, memory stays below EXR_SPARE_MEMORY and, once the
 * header is known, 4 times its image more: pixels x channels x 4 bytes.  The
 * spare part is for the header, and for small images in DWA, whose chunks have
 * 256 rows in any case.
 */
enum { EXR_SPARE_MEMORY = 64 << 20 };

/* Header only: size and channel names. */
int exr_read_header(const char *path, image *out, image_error *error);

/* The named channels only (all converted to float). Names that the file lacks
 * are an error. */
int exr_read(const char *path, const char *const *names, size_t count,
             image *out, image_error *error);

/* The same in the files' own types: integers stay what they are. */
int exr_read_as_is(const char *path, const char *const *names, size_t count,
                   image *out, image_error *error);

/* none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab; and, where a file is
 * written like another, that one's ("input").  Ends with NULL. */
extern const char *const exr_compressions[];
enum { EXR_COMPRESSION_OF_ZIP = 3, EXR_COMPRESSION_OF_INPUT = 10 };

typedef struct exr_style {
  int compression;  /* one of the above */
  const char *like; /* a file of whose first part the attributes are taken
                     * over, but for those of its own storage; or NULL.  One of
                     * another format has none. */
} exr_style;

/* Writes all planes as a scanline file to a temporary name beside `path`, then
 * renames.  half: store as half (1) or in the plane's type (0), per plane;
 * finite values stay finite.  style: NULL is ZIP and no further attributes. */
int exr_write(const char *path, const image *img, const unsigned char *half,
              image_error *error);
int exr_write_as(const char *path, const image *img, const unsigned char *half,
                 const exr_style *style, image_error *error);

/* --- other formats, through OpenImageIO (formats.cpp) --- */

/* 8-bit PNG of rgb (width*height*3 bytes, top row first), via a temporary name.
 */
int png_write(const char *path, const unsigned char *rgb, uint32_t width,
              uint32_t height, image_error *error);

/* --- pictures that are put together, through OpenImageIO (picture.cpp) --- */

typedef struct picture {
  uint32_t width, height;
  unsigned char *rgb; /* width*height*3 bytes, top row first; malloc'd */
} picture;

typedef struct picture_window {
  uint32_t x, y, width, height;
} picture_window;

typedef enum picture_align {
  PICTURE_LEFT = 0, /* x is where the text begins, */
  PICTURE_CENTRE,   /* its middle, */
  PICTURE_RIGHT     /* where it ends */
} picture_align;

/* What a new picture is filled with. */
enum { PICTURE_GREY = 32 };

/* These give 0 or -1: out of memory. */
int picture_new(uint32_t width, uint32_t height, picture *out);
void picture_free(picture *p); /* allowed on a zeroed picture and twice */
/* Puts a tile, made as large as the window, into a picture. */
int picture_tile(picture *to, const picture_window *at, const picture *tile);
/* White text, size pixels high, on the base line y; -1 also where there is no
 * font (Debian: fonts-dejavu-core). */
int picture_text(picture *to, int x, int y, int size, picture_align align,
                 const char *text);

/* Any image OpenImageIO reads, as interleaved RGB floats (malloc'd, grey is
 * tripled, alpha dropped); 16384 x 8192 pixels at most. */
enum { IMAGE_MAP_PIXELS = 1 << 27 };
int formats_read_rgb(const char *path, float **rgb, uint32_t *width,
                     uint32_t *height, image_error *error);

/* Whether it begins as a PNG, TIFF or Radiance HDR file does. */
int formats_recognise(const char *path);
/* Such a file as planes, with the names and to the rules of exr_read_header()
 * and exr_read(); integers become 0..1.  IMAGE_MAP_PIXELS at most. */
int formats_read_header(const char *path, image *out, image_error *error);
int formats_read(const char *path, const char *const *names, size_t count,
                 image *out, image_error *error);

/* --- camera side-car (camera_json.c) --- */

/* The JSON beside a dump: camera_to_world (OpenGL convention, row-major), fx,
 * fy, cx, cy; resolution, projection, near and far may be there.  Pixels are
 * counted from the display window's corner. */
typedef struct camera_file {
  double camera_to_world[16];
  int orthographic; /* all rays are parallel */
  double fx, fy;    /* pixels; orthographic: pixels to a world unit */
  double cx, cy;
  uint32_t width, height;
  double near, far; /* clipping planes; 0: not told */
} camera_file;

/* A file that is larger is refused before the rest of it is read. */
enum { CAMERA_FILE_MOST = 1 << 20 };

int camera_read(const char *path, camera_file *out, image_error *error);
int camera_write(const char *path, const camera_file *camera,
                 image_error *error);

#ifdef __cplusplus
}
#endif

#endif
