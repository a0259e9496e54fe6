/*
 * hbil: a frame: its camera, its planes and its environment.  Programs include
 * hbil/hbil.h.
 */
#ifndef HBIL_HBIL_FRAME_H
#define HBIL_HBIL_FRAME_H

#include <hbil/hbil_base.h>
#include <hbil/hbil_config.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------ */
/* Planes: the caller's buffers as images                                    */

/* A plane in a buffer, which remains the caller's.  The frame's commands use it
 * until the frame's event completes.
 * offset, row_pitch and plane_pitch are in bytes and must be multiples of the
 * component's size.  A row_pitch of 0 means width * pixel_pitch.
 * plane_pitch is the distance between the channels of planar formats; 0 means
 * row_pitch * height.
 *
 * The library checks before it enqueues anything; what fails is
 * HBIL_INVALID_FRAME:
 *   kind     a buffer or sub-buffer; for HBIL_IMAGE an image2d_t, and offset
 *            and pitches are 0
 *   context  the OpenCL context of the plan
 *   access   inputs must not be CL_MEM_WRITE_ONLY, nor outputs
 *            CL_MEM_READ_ONLY; the CL_MEM_HOST_ flags do not matter
 *   size     all pixels are in the buffer, and no row of pixels is longer than
 *            row_pitch; an image has the frame's width and height
 *   overlap  no byte of an output belongs to another plane, nor to two of its
 *            own channels.  Inputs may overlap each other.
 * Planes may share a buffer, or the parent of their sub-buffers, if their bytes
 * are apart.  Two planes of which one begins behind the other's last byte are
 * apart whatever their formats.  With the same row_pitch, each may also use its
 * own part of common rows, or rows between those of the other.  If pixels are
 * the same number of bytes apart as well, each may use its own bytes of common
 * pixels, such as ao the fourth component of pixels whose first three are
 * bent_normal.  Other mixtures are rejected where an output is involved.
 * The single passes check the planes that they use. */
typedef struct hbil_plane {
  cl_mem buffer;
  size_t offset;
  size_t row_pitch;
  size_t plane_pitch;
} hbil_plane;

/* ------------------------------------------------------------------------ */
/* Frame: camera, planes and environment                                     */

typedef struct hbil_camera {
  /* Focal lengths, 1e-18..1e18: pixels; orthographic: pixels per unit. */
  double fx, fy;
  /* Principal point, pixels from the top left corner, -1e18..1e18. */
  double cx, cy;
  /* The camera's position and axes in the world: x towards the next column, y
   * towards the next row, z forward.  The axes must have length 1 and be at
   * right angles, to 1e-3.  The determinant is 1 in a right-handed world.  It
   * may be -1, for a left-handed world or for rows that go upwards.  Normals,
   * bent normals and the environment are in the caller's world either way.
   * Coordinates of the position are -1e18..1e18. */
  double world_from_view[16];
} hbil_camera;

/* Fills a camera from the convention of OpenGL and Blender, where x is right, y
 * is up and the camera looks along -z.  camera_to_world is row-major. */
HBIL_API void hbil_camera_from_opengl(hbil_camera *camera,
                                      const double camera_to_world[16],
                                      double fx, double fy, double cx,
                                      double cy);

/* What a renderer's matrices don't tell of themselves; a sum of these.  0 is
 * Direct3D's clip space, and matrices that are row-major for column vectors.
 * Direct3D with DirectXMath: COLUMN_MAJOR.  Vulkan with glm: COLUMN_MAJOR and
 * Y_DOWN.  OpenGL with glm: COLUMN_MAJOR and SIGNED_DEPTH (without it after
 * glClipControl() with GL_ZERO_TO_ONE), and Y_DOWN if the planes lie in memory
 * as OpenGL's textures do, the lowest row first. */
typedef enum hbil_matrix_convention {
  /* The matrices are stored column by column, or are made for row vectors. */
  HBIL_MATRIX_COLUMN_MAJOR = 1,
  /* z/w of clip space is -1..1, which the depth buffer holds as 0..1; without
   * this flag, it is 0..1.  Most matrices fit both.  A wrong flag then halves
   * or doubles B, and all distances. */
  HBIL_MATRIX_SIGNED_DEPTH = 2,
  /* What is nearer has the greater depth, as in 1..0. */
  HBIL_MATRIX_REVERSED_DEPTH = 4,
  /* The first row of the planes is at y/w = -1 of clip space; without this
   * flag, it is at y/w = 1. */
  HBIL_MATRIX_Y_DOWN = 8,
  HBIL_MATRIX_ALL = 15
} hbil_matrix_convention;

/* Fills a camera from a renderer's matrices: `view` from world to view space,
 * and `projection` from view to clip space.  Of the plan's configuration,
 * width, height and inputs.projection are read.  Exact to double precision for
 * views that look along z or -z, with x and y in either direction, right- or
 * left-handed, and for projections that are off-centre or jittered (with their
 * jitter, because the planes have it, too), with any far plane.
 *   view        a rotation, mirrored or not, and a shift
 *   projection  rows  a 0 b 0   0 c d 0   . . . .   0 0 w 0, or orthographic
 *                     a 0 0 b   0 c 0 d   . . . .   0 0 0 1   with w = 1 or -1
 * The third row is needed for hardware_depth, and in orthographic views for the
 * direction of view; it is 0 0 e f.  hardware_depth receives A and B of the
 * depth buffer's value d = A + B/z, orthographic d = A + B z; NULL is allowed.
 * With a viewport whose depths are not 0..1 but low..high, use
 * low + (high - low) A and (high - low) B.  An orthographic near plane must be
 * in front of the eye, since depths below 0 are sky.
 * Returns HBIL_INVALID_ARGUMENT for anything else, which leaves camera and
 * hardware_depth as they are; hbil_context_message(NULL) says what is wrong. */
HBIL_API hbil_status hbil_camera_from_matrices(
    hbil_camera *camera, double hardware_depth[2], const hbil_config *config,
    const double projection[16], const double view[16], cl_uint conventions);

/* So many static frames in a row have the same bits as other frames.  By then
 * light has changed by most of what it will; what goes on for ever is roundings
 * (hbil_frame.static_frame). */
#define HBIL_EXACT_STATIC_FRAMES 32

typedef struct hbil_frame {
  size_t struct_size; /* set by hbil_frame_init(); see hbil_config */
  hbil_camera camera;
  /* Inputs and outputs.  Exactly those planes that have a format in the plan
   * must have a buffer. */
  hbil_plane depth, normal, albedo, f0, direct, emission, motion;
  hbil_plane near_irradiance, far_irradiance, ao, bent_normal, cone_cosine,
      indirect, beauty, error_estimate, unknown, glossy;
  /* The far field, RGB radiance in world space, at most 1e30.
   * HBIL_FAR_CONSTANT reads environment[0].  HBIL_FAR_FRAME reads
   * environment[0] as the radiance of a sky that `direct` already contains, 0
   * if it contains none.  HBIL_FAR_SH reads nine coefficients of the real
   * orthonormal basis in the order
   *   (0,0) (1,-1) (1,0) (1,1) (2,-2) (2,-1) (2,0) (2,1) (2,2) */
  float environment[9][3];
  /* HBIL_FAR_FRAME: if `direct` contains a sky that the picture doesn't show,
   * the share of the open directions that ends in it.  0..1: 0 in rooms, near 1
   * in the open. hbil_config_suggest() sets it. */
  float sky_share;
  /* Rotates the sampling pattern.  One constant avoids flicker. */
  cl_uint frame_index;
  /* CL_TRUE: nothing has moved since the plan's last frame.  Camera,
   * environment, exposure, frame_index and the contents of all inputs are the
   * same, and motion is 0.  Only the carried light is updated.  If it stops
   * changing, bit for bit, nothing is gathered or filtered any more.  After
   * HBIL_EXACT_STATIC_FRAMES of them in a row, light that is lower than before
   * by no more than a rounding counts as unchanged, so that roundings don't
   * prevent this.  Where frames share slices, static ones search all of them.
   * Camera, exposure and frame_index are checked, bit by bit.  This only saves
   * work: in a frame whose camera differs by a rounding, leave it CL_FALSE, and
   * light differs by a rounding.
   * Ignored where a plan has no last frame of its own: in its first one, and
   * after hbil_plan_reset(), hbil_plan_follow() and hbil_plan_adopt_history().
   * Callers who write to a plan's stages, or to scratch memory that they lent
   * it, must not set it. */
  cl_bool static_frame;
  /* With HBIL_DEPTH_HARDWARE: A and B of this frame's projection;
   * hbil_camera_from_matrices() computes both.  The value of
   * the depth buffer is d = A + B/z, in orthographic views d = A + B z, where z
   * is planar depth.  A is finite, B is not 0; as floats, too, and B is not
   * subnormal.  A far end at A = 1.00001 is 1e-5 in front of the far plane's
   * 1, so these are doubles: depths are then as exact as a float whatever f / n
   * is (test_formats).  With the near plane at n and the far one at f (n > 0;
   * n < f):
   *                                  A                B
   *   perspective, 0..1              f / (f-n)        -f n / (f-n)
   *     far plane at infinity        1                -n
   *   perspective, reversed, 1..0    -n / (f-n)       f n / (f-n)
   *     far plane at infinity        0                n
   *   perspective, -1..1             (f+n) / (f-n)    -2 f n / (f-n)
   *     far plane at infinity        1                -2 n
   *   orthographic, 0..1             -n / (f-n)       1 / (f-n)
   *   orthographic, reversed, 1..0   f / (f-n)        -1 / (f-n)
   *   orthographic, -1..1            -(f+n) / (f-n)   2 / (f-n)
   * 0..1 is what depth buffers hold, OpenGL's too, whose clip space is -1..1
   * (with glDepthRange(0, 1), the default).  -1..1 is for float planes with
   * clip space's z/w; it can't be reversed.
   * The far end, d = 1, or d = 0 where depth is reversed, is what a cleared
   * depth buffer holds.  It is sky, and so is everything beyond. */
  double hardware_depth[2];
  /* With hbil_model.cache_method: the radiance cache that this frame uses, of
   * the plan's context, or NULL for none (hbil_cache.h). */
  struct hbil_cache *cache;
  /* What this frame's light is multiplied by before it is written to planes, as
   * engines do: `direct`, `emission` and `environment` have this factor, and so
   * have the outputs.  The history and the radiance cache hold light without
   * it, so that it may differ from frame to frame: light is then as it would be
   * had it always been so.  1e-12..1e12, or 0 (default), which stands for 1. */
  float exposure;
} hbil_frame;

/* Sets struct_size, and all other members to 0.  The camera must be set by the
 * caller, since 0 is not valid.  Use the macro. */
HBIL_API void hbil_frame_init_sized(hbil_frame *frame, size_t struct_size);
#define hbil_frame_init(frame)                                                 \
  hbil_frame_init_sized((frame), sizeof(hbil_frame))

/* Projects a latitude-longitude map to order-2 spherical harmonics, on the
 * host.  rgb has `height` rows of `width` pixels of 3 floats.  Any width and
 * height will do; a width of twice the height is usual.  Rows are row_pitch
 * bytes apart; 0 means without gaps.  The top row is the map's +z pole, and a
 * direction d has, as in Blender,
 *   column = width (0.5 - atan2(d.y, d.x) / (2 pi))
 *   row    = height acos(d.z) / pi
 * world_from_map is a row-major 3x3 rotation, checked to 1e-3.  In a
 * left-handed world it is a mirrored rotation, because the map is right-handed.
 * NULL means the identity.  Anything else is HBIL_INVALID_ARGUMENT, which
 * leaves `environment` as it is.  NaN, negative and infinite values of the map
 * count as 0. */
HBIL_API hbil_status hbil_environment_from_latlong(
    const float *rgb, size_t width, size_t height, size_t row_pitch,
    const float world_from_map[9], float environment[9][3]);
#ifdef __cplusplus
}
#endif

#endif
