/*
 * hbil: horizon-based indirect lighting from a G-buffer, with OpenCL.
 *
 * hbil computes indirect light in screen space.  Its input is a G-buffer with
 * depth, normals, albedo and direct light.  For every pixel it computes ambient
 * occlusion (AO), the irradiance from surfaces on the screen (E_near), the mean
 * direction and the width of the unblocked part of the hemisphere (bent normal
 * and cone), the irradiance through this part (E_far), and the lit picture.
 * Light from the last frame is added, so light bounces once more every frame.
 * The method is B. Mayaux, "Horizon-Based Indirect Lighting", 2018 ("the paper"
 * below).  doc/method.md derives it, with corrections.
 *
 * HOW A PROGRAM USES IT
 *   1. Call hbil_context_create() with an OpenCL context and device of yours.
 *   2. Fill an hbil_config: hbil_config_init() sets the defaults; you set the
 *      size and the formats of inputs and outputs.  hbil_plan_create() builds
 *      the kernels and allocates the buffers, once.
 *   3. For every frame, fill an hbil_frame with the camera and the planes, and
 *      call hbil_enqueue_frame().
 *
 * CONVENTIONS
 *   View space is right-handed with x right, y down and z forward.  Pixel (i,j)
 *   has its centre at (i+0.5, j+0.5) from the top left corner and looks along
 *   r = ((i+0.5-cx)/fx, (j+0.5-cy)/fy, 1).  Matrices are row-major 4x4 matrices
 *   for column vectors.  Lengths are in world units of the caller's choice.
 *   Light is linear, in any RGB primaries; the channels are never mixed.
 *   Radiance L is in W/(m2 sr), irradiance E in W/m2.  A diffuse surface sends
 *   L = (1-F0) albedo/pi E, plus its emission.
 *
 * THREADS
 *   Only one thread at a time may use a context and its plans.  Different
 *   contexts are independent, even on the same cl_context.
 *
 * BLOCKING
 *   The hbil_enqueue_* functions never wait for commands on the device and
 *   allocate no memory.  hbil_plan_create() builds kernels, which takes long.
 *   hbil_plan_timings(), hbil_plan_statistics() and hbil_plan_sanitized() wait
 *   for the device.  PoCL, OpenCL for CPUs, compiles each kernel at its first
 *   launch.  So run one frame before you measure times, or three with static
 *   frames, which launch further kernels.
 *
 * ERRORS
 *   Every function that can fail returns an hbil_status; HBIL_SUCCESS is 0.
 *   hbil_context_message() describes the last failure in one sentence.  The
 *   library never prints, exits or aborts.  It checks arguments before it
 *   enqueues anything.  If a frame fails later, the plan's history is the same
 *   as before, and you may enqueue the same frame again or another one.  What
 *   was enqueued already still runs; on an out-of-order queue, wait for that
 *   with clFinish() first.
 */
#ifndef HBIL_HBIL_H
#define HBIL_HBIL_H

#include <stddef.h>

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HBIL_VERSION_MAJOR 0
#define HBIL_VERSION_MINOR 1
#define HBIL_VERSION_PATCH 0

/* The largest width and height of a frame, in pixels. */
#define HBIL_MAX_SIZE 16384

#if defined(_WIN32)
#define HBIL_API
#else
#define HBIL_API __attribute__((visibility("default")))
#endif

/* ------------------------------------------------------------------------ */
/* Status: result codes and version                                          */

typedef enum hbil_status {
  HBIL_SUCCESS = 0,
  HBIL_INVALID_ARGUMENT = 1, /* an argument is null or malformed */
  HBIL_INVALID_CONFIG = 2,   /* a member of hbil_config is out of range */
  HBIL_INVALID_FRAME = 3,    /* a member of hbil_frame is missing or wrong */
  HBIL_OUT_OF_HOST_MEMORY = 4,
  HBIL_OUT_OF_DEVICE_MEMORY = 5, /* the device cannot hold the buffers */
  HBIL_UNSUPPORTED_DEVICE = 6,   /* below OpenCL 1.2 or without a compiler */
  HBIL_BUILD_FAILED = 7,         /* a kernel did not compile; see the message */
  HBIL_OPENCL_ERROR = 8          /* any other OpenCL failure; see the message */
} hbil_status;

/* Returns a short sentence for a status; a static string, never NULL. */
HBIL_API const char *hbil_status_string(hbil_status status);

/* Returns the running library's "major.minor.patch"; a static string. */
HBIL_API const char *hbil_version(void);

/* ------------------------------------------------------------------------ */
/* Context: the library on one device                                        */

typedef struct hbil_context hbil_context;

/* Creates a context, which binds the library to a cl_context and one of its
 * devices.  The context retains both until hbil_context_destroy().  The device
 * needs OpenCL 1.2 and a compiler.  Images, sub-groups and 64-bit atomics are
 * not used.  On failure *out is NULL, and there is no message.  If the
 * environment variable HBIL_KERNEL_DIR names a folder, plans read the kernels
 * from there; this is meant for work on the kernels. */
HBIL_API hbil_status hbil_context_create(cl_context context,
                                         cl_device_id device,
                                         hbil_context **out);

/* Destroys a context.  Destroy its plans first.  NULL is allowed. */
HBIL_API void hbil_context_destroy(hbil_context *context);

/* Returns one sentence on the last failure in this context or in one of its
 * plans.  It has the name of the OpenCL error, and the build log if a kernel
 * did not compile.  The string is empty if nothing has failed.  It is valid
 * until the next call on the context or one of its plans. */
HBIL_API const char *hbil_context_message(const hbil_context *context);

/* ------------------------------------------------------------------------ */
/* Planes: the caller's buffers as images                                    */

typedef enum hbil_component {
  HBIL_NONE = 0,    /* the plane does not exist */
  HBIL_FLOAT32 = 1, /* 4 bytes */
  HBIL_FLOAT16 = 2, /* 2 bytes, IEEE half */
  HBIL_UNORM8 = 3   /* 1 byte, 0..255 for 0..1; only albedo, f0, direct and
                       emission can have it */
} hbil_component;

/* How the pixels of a plane lie in its buffer.  The formats are fixed per plan,
 * because the kernels are compiled for them.
 * stride is the distance from a pixel to its right-hand neighbour, in
 * components.  1 means planar: each channel is an image of its own.  The number
 * of channels or more, up to 64, means interleaved: the channels of a pixel are
 * adjacent, and further components are neither read nor changed.  0 means the
 * number of channels. */
typedef struct hbil_plane_format {
  hbil_component component;
  cl_uint stride;
} hbil_plane_format;

/* A plane in a buffer, which remains the caller's.  The frame's commands use it
 * until the frame's event completes.
 * offset, row_pitch and plane_pitch are in bytes and must be multiples of the
 * component's size.  A row_pitch of 0 means width * stride components.
 * plane_pitch is the distance between the channels of planar formats; 0 means
 * row_pitch * height.  The library checks that all pixels are in the buffer. */
typedef struct hbil_plane {
  cl_mem buffer;
  size_t offset;
  size_t row_pitch;
  size_t plane_pitch;
} hbil_plane;

/* ------------------------------------------------------------------------ */
/* Configuration: what a plan computes, and from which formats               */

typedef enum hbil_depth_kind {
  HBIL_DEPTH_PLANAR = 0, /* z, along the camera's axis */
  HBIL_DEPTH_RAY = 1     /* distance from the eye */
} hbil_depth_kind;

typedef enum hbil_projection {
  /* All rays start at the eye; pixel (i,j) looks along
   * ((i+0.5-cx)/fx, (j+0.5-cy)/fy, 1). */
  HBIL_PROJECTION_PERSPECTIVE = 0,
  /* All rays are parallel to z; pixel (i,j) looks from
   * ((i+0.5-cx)/fx, (j+0.5-cy)/fy, 0), and fx and fy are pixels per world unit.
   * Such depths have no scale, so settings that are a share of a depth become
   * a share of the picture's width in world units. */
  HBIL_PROJECTION_ORTHOGRAPHIC = 1
} hbil_projection;

typedef enum hbil_space {
  HBIL_SPACE_VIEW = 0, /* x right, y down, z forward */
  HBIL_SPACE_WORLD = 1
} hbil_space;

/* How light is carried over from the last frame. */
typedef enum hbil_reprojection {
  HBIL_REPROJECTION_NONE = 0,    /* not at all: a single bounce */
  HBIL_REPROJECTION_SCATTER = 1, /* by the cameras; the nearest surface wins */
  HBIL_REPROJECTION_MOTION = 2   /* by motion vectors */
} hbil_reprojection;

/* Which light is carried over to the next frame. */
typedef enum hbil_feedback {
  /* The indirect irradiance.  The next frame applies its own albedo and adds
   * its own direct light and emission, so none of these lags behind. */
  HBIL_FEEDBACK_IRRADIANCE = 0,
  /* The diffuse radiance, direct light included (paper, equation 17).  The next
   * frame uses its own direct light only where nothing was carried over. */
  HBIL_FEEDBACK_RADIANCE = 1
} hbil_feedback;

/* What the horizon search computes. */
typedef enum hbil_mode {
  /* E_near, cosine-weighted AO and the bent cone (the paper). */
  HBIL_MODE_HBIL = 0,
  /* Ground-truth ambient occlusion (Jimenez and others 2016): the same AO and
   * bent cone, without E_near.  near_irradiance and HBIL_FAR_FRAME are
   * rejected, and `indirect` has far light only. */
  HBIL_MODE_GTAO = 1,
  /* Horizon-based ambient occlusion (Bavoil and others 2008): AO that weights
   * all directions alike, and each sample by hbil_falloff (doc/method.md,
   * section 17).  HBAO rejects what GTAO rejects, and also bent_normal,
   * cone_cosine, error_estimate and HBIL_FAR_SH. */
  HBIL_MODE_HBAO = 2
} hbil_mode;

/* The weight of a sample at distance r in HBIL_MODE_HBAO.  R is the radius,
 * beyond which nothing counts.  All weights are 1 if R is infinite. */
typedef enum hbil_falloff {
  HBIL_FALLOFF_LINEAR = 0, /* max(0, 1 - r/R) */
  HBIL_FALLOFF_SOFT = 1,   /* 1 - r/(3R) */
  HBIL_FALLOFF_NONE = 2    /* 1 */
} hbil_falloff;

/* The radiance that arrives from unblocked directions. */
typedef enum hbil_far_field {
  HBIL_FAR_NONE = 0,     /* 0 */
  HBIL_FAR_CONSTANT = 1, /* the same from all directions */
  HBIL_FAR_SH = 2,       /* order-2 spherical harmonics, 9 coefficients */
  /* An estimate for rooms that continue outside the picture: the mean of what
   * the frame's own surfaces send towards the bent normal.  If `direct`
   * contains a sky, environment[0] tells its radiance, and only directions that
   * the sky does not light get the estimate (doc/method.md, section 11). */
  HBIL_FAR_FRAME = 3
} hbil_far_field;

/* The light of directions that are blocked by a surface facing away, whose
 * other side the screen does not show; see hbil_config.facing_fade. */
typedef enum hbil_back_facing_fallback {
  /* the last accepted radiance on the same half-slice, at first the pixel's own
   * (paper, 3.4) */
  HBIL_FALLBACK_LAST_ACCEPTED = 0,
  HBIL_FALLBACK_BLACK = 1, /* none */
  /* the mean of what the frame's surfaces send towards the pixel's normal */
  HBIL_FALLBACK_FRAME_MEAN = 2
} hbil_back_facing_fallback;

/* The pixels that can be samples of a pixel. */
typedef enum hbil_sample_grid {
  HBIL_GRID_SAME_LAYER = 0,     /* every fourth one in x and y (paper, 3.3) */
  HBIL_GRID_FULL_RESOLUTION = 1 /* all */
} hbil_sample_grid;

/* How the planes between the passes split and recompose are stored.  Depth is a
 * 32-bit float in both.  PACKED is faster wherever memory limits the speed, and
 * its error is far below that of sampling (doc/measurements.md, "Storage"). */
typedef enum hbil_storage {
  /* 3 words of 32 bits for the G-buffer and 3 for its light, up to a radiance
   * of 1e30.  The three channels of a colour share an exponent, so a channel
   * below 1/500 of the brightest one is lost.  See hbil_stages.h. */
  HBIL_STORAGE_PACKED = 0,
  HBIL_STORAGE_FLOAT32 = 1 /* 7 floats, and 7 or 8 for the light */
} hbil_storage;

/* Work that the library leaves out because it cannot change the outputs;
 * hbil_config.skip is a sum of these.  The device decides in every frame what
 * to leave out, and the host reads nothing back.  The outputs have the same
 * bits with and without (test_skip). */
typedef enum hbil_skip {
  HBIL_SKIP_SKY = 1,  /* gather: spans of pixels that are all sky */
  HBIL_SKIP_OPEN = 2, /* gather: spans where nothing rises above the surface */
  HBIL_SKIP_DARK = 4, /* gather: the light of samples that send none */
  /* gather: surfaces that reflect no diffuse light (albedo 0 or F0 1), if
   * beauty is the only output and no irradiance is carried over.  The data of
   * HBIL_STAGE_GATHERED and HBIL_STAGE_RESOLVED do differ. */
  HBIL_SKIP_UNUSED = 8,
  HBIL_SKIP_RADIUS = 16, /* gather: samples certainly beyond the radius */
  HBIL_SKIP_HOLES = 32,  /* push_pull: frames without holes */
  HBIL_SKIP_STATIC = 64, /* all passes: what a static frame does not change */
  HBIL_SKIP_ALL = 127
} hbil_skip;

typedef struct hbil_config {
  /* Set by hbil_config_init().  Later versions may add members at the end, and
   * programs that were compiled without them get their defaults.  A struct
   * larger than the library's is rejected. */
  size_t struct_size;

  cl_uint width, height; /* pixels, 1..HBIL_MAX_SIZE */

  /* Formats of the inputs.  depth and normal are needed; the others may be
   * HBIL_NONE.  Without a plane, albedo is 1 and the others are 0.
   * Results are finite whatever the inputs hold.  Unusable values are replaced,
   * and hbil_plan_sanitized() counts the pixels:
   *   depth     NaN, negative, below 1e-15 except 0: sky
   *   normal    NaN, infinite, shorter than 1e-10, longer than 1e19: the
   *             direction to the eye
   *   albedo, f0        NaN, infinite, negative: 0; above 1: 1
   *   direct, emission  NaN, negative, above 1e30 (after direct_scale): 0
   *   motion    NaN, infinite: nothing is carried over to the pixel
   * Depths of 0, and from 1e15 or sky_depth on, are sky and not counted.  Nor
   * are normals that face away; they are turned until nearly edge on. */
  hbil_plane_format depth;    /* 1 channel; see depth_kind, sky_depth */
  hbil_plane_format normal;   /* 3 channels, any length; see normal_space */
  hbil_plane_format albedo;   /* 3 channels, diffuse reflectance, 0..1 */
  hbil_plane_format f0;       /* 3 channels, reflectance at normal incidence */
  hbil_plane_format direct;   /* 3 channels, irradiance; see direct_scale */
  hbil_plane_format emission; /* 3 channels, radiance */
  hbil_plane_format motion;   /* 2 channels; see motion_scale */

  /* Formats of the outputs, HBIL_FLOAT32 or HBIL_FLOAT16, at least one.  What
   * is HBIL_NONE is computed only if another output needs it.  At the sky ao is
   * 1 and the others are 0, except for beauty. */
  hbil_plane_format near_irradiance; /* 3 channels: E_near */
  hbil_plane_format far_irradiance;  /* 3 channels: E_far */
  hbil_plane_format ao;              /* 1 channel: 1 is open, 0 is closed */
  /* 3 channels: unit vector, 0 if nothing is open; see bent_normal_space */
  hbil_plane_format bent_normal;
  hbil_plane_format cone_cosine; /* 1: cosine of the half-angle, sqrt(1-AO) */
  hbil_plane_format indirect;    /* 3 channels: (1-F0) (E_near + E_far) / pi */
  /* 3 channels: albedo ((1-F0) E_direct/pi + indirect) + emission.  At the sky:
   * the emission if there is such a plane, else the radiance of
   * HBIL_FAR_CONSTANT or HBIL_FAR_SH, else 0. */
  hbil_plane_format beauty;
  /* 2 channels: estimates of the sampling errors of ao and of E_near (per
   * channel, irradiance), which 95 % of the pixels don't exceed.  They hold for
   * infinite thickness and are too small for any other (doc/method.md, section
   * 18).  The second is 0 if no E_near is computed. */
  hbil_plane_format error_estimate;

  /* How inputs are read. */
  hbil_projection projection; /* of all cameras; default PERSPECTIVE */
  hbil_depth_kind depth_kind; /* default PLANAR */
  float sky_depth; /* depths from here on are sky; > 0; default infinity */
  hbil_space normal_space;      /* default VIEW */
  hbil_space bent_normal_space; /* default VIEW */
  float direct_scale; /* E_direct is `direct` times this; 0..1e30; default 1 */
  /* `motion` times this is the previous position minus the current one, in
   * pixels, x right, y down.  -1e6..1e6; default 1, 1 */
  float motion_scale[2];

  /* The method.  hbil_config_set_model() sets what says "model" here; the
   * default is HBIL_MODEL_DEFAULT. */
  hbil_mode mode;       /* default HBIL */
  hbil_falloff falloff; /* for HBIL_MODE_HBAO only; default LINEAR */
  float radius;         /* of the search, world units, > 0; default infinity */
  /* Thickness of occluders in world units, and as a share of their depth; > 0.
   * The smaller one counts.  Infinity: occluders have no back; model */
  float thickness;
  float relative_thickness;
  cl_uint slices;         /* per pixel, 1..32; default 2 */
  cl_uint steps_per_side; /* samples per side of a slice, 1..256; default 48 */
  /* g: the last step is (1+g)^2 times the first one; 0..64; default 2 */
  float step_growth;
  hbil_sample_grid sample_grid; /* default FULL_RESOLUTION */
  /* CL_TRUE: corrects AO and E_near for occluders between the samples.  What
   * half of the samples miss tells what all miss (jackknife; doc/method.md,
   * section 7); model */
  cl_bool extrapolate;
  /* The radiance of a sample fades in as the cosine between its normal and the
   * direction to the pixel rises from the first to the second value;
   * back_facing_fallback fills the rest.  -1..1, ascending; -1, -1: the light
   * of all samples counts; model */
  float facing_fade[2];
  hbil_back_facing_fallback back_facing_fallback; /* model */
  /* CL_TRUE (default): emission lights other surfaces.  CL_FALSE: it doesn't,
   * because `direct` contains that light already. */
  cl_bool gather_emission;
  hbil_reprojection reprojection; /* default SCATTER */
  hbil_feedback feedback;         /* model */
  /* Light is not carried over to pixels whose depth differs by more than this
   * share.  > 0; infinity: no limit; default 0.05 */
  float disocclusion_threshold;
  /* Averages AO, E_near and the bent normal over up to this many frames, which
   * reduces noise; 0..1024; 0 (default): off.  Use 2 to 4 for moving cameras
   * and 8 or more for static ones, and increase hbil_frame.frame_index by 1 in
   * every frame, static ones included.  The newest frame weighs
   * 1/max_history_frames, and older ones fade out.  HBIL_REPROJECTION_MOTION
   * follows surfaces by motion vectors, the others by the cameras.  A pixel
   * starts anew if disocclusion_threshold or a change of its normal by 33
   * degrees tells that another surface was there.  Changes of light lag behind
   * by some frames. */
  cl_uint max_history_frames;
  hbil_far_field far_field; /* default NONE */
  cl_bool unfiltered; /* CL_TRUE: recompose has no filter; default CL_FALSE */

  /* How it runs. */
  hbil_storage storage; /* default PACKED */
  cl_uint skip;         /* a sum of hbil_skip; default HBIL_SKIP_ALL */
  /* Pixels in a vector, 1, 4, 8 or 16; 0 (default): chosen for the device. */
  cl_uint vector_width;
  /* CL_TRUE: hbil_plan_timings() works, and queues must have
   * CL_QUEUE_PROFILING_ENABLE.  Default CL_FALSE */
  cl_bool profiling;
  /* Device memory for the horizon cache, in bytes; default 0.  The first static
   * frame stores how much the light of each sample counts for each pixel.
   * Later ones only add up light, which is faster and gives the same bits.  The
   * cache never takes more than all rows need, nor more than the device's
   * largest buffer; rows that don't fit are gathered as usual.  There is no
   * cache with max_history_frames, without HBIL_SKIP_STATIC, or if no light is
   * carried over.  hbil_plan_memory() includes it. */
  size_t horizon_cache_bytes;
} hbil_config;

/* Named models of light and occluders. */
typedef enum hbil_model {
  /* The default, chosen by its error on four path-traced scenes: infinite
   * thickness, relative_thickness 0.08, facing_fade -1, -1, extrapolate on,
   * HBIL_FALLBACK_FRAME_MEAN, HBIL_FEEDBACK_IRRADIANCE */
  HBIL_MODEL_DEFAULT = 0,
  /* The paper: both thicknesses infinite, facing_fade -0.1, 0,
   * HBIL_FALLBACK_LAST_ACCEPTED, HBIL_FEEDBACK_RADIANCE, extrapolate off */
  HBIL_MODEL_PAPER = 1
} hbil_model;

/* Sets thickness, relative_thickness, facing_fade, back_facing_fallback,
 * feedback and extrapolate.  Returns HBIL_INVALID_ARGUMENT if config is null or
 * model is not in the list. */
HBIL_API hbil_status hbil_config_set_model(hbil_config *config,
                                           hbil_model model);

/* Named presets of the sampling.  They differ in sampling error and time, of
 * which doc/measurements.md has the figures ("Sampling error and time"). */
typedef enum hbil_quality {
  HBIL_QUALITY_FAST = 0,     /* 1 slice, 16 steps per side, same layer */
  HBIL_QUALITY_BALANCED = 1, /* 2 slices, 32 steps per side, same layer */
  HBIL_QUALITY_HIGH = 2,     /* 2 slices, 64 steps per side, full resolution */
  /* 32 slices, 256 equal steps per side, full resolution, unfiltered, float32:
   * the densest settings, for comparisons */
  HBIL_QUALITY_REFERENCE = 3
} hbil_quality;

/* Sets slices, steps_per_side, step_growth, sample_grid, unfiltered and
 * storage.  Returns HBIL_INVALID_ARGUMENT if config is null or quality is not
 * in the list. */
HBIL_API hbil_status hbil_config_set_quality(hbil_config *config,
                                             hbil_quality quality);

/* Returns "fast", "balanced", "high" or "reference", else NULL. */
HBIL_API const char *hbil_quality_name(hbil_quality quality);

/* Sets the defaults in a struct of struct_size bytes.  width, height and the
 * formats are 0 and must be set by the caller.  Use the macro. */
HBIL_API void hbil_config_init_sized(hbil_config *config, size_t struct_size);
#define hbil_config_init(config)                                               \
  hbil_config_init_sized((config), sizeof(hbil_config))

/* ------------------------------------------------------------------------ */
/* Frame: camera, planes and environment                                     */

typedef struct hbil_camera {
  double fx, fy; /* focal lengths, > 0: pixels; orthographic: pixels per unit */
  double cx, cy; /* principal point, pixels from the top left corner */
  /* The camera's position and rotation.  It must be rigid, to 1e-3; scaling and
   * mirroring matrices are rejected. */
  double world_from_view[16];
} hbil_camera;

/* Fills a camera from the convention of OpenGL and Blender, where x is right, y
 * is up and the camera looks along -z.  camera_to_world is row-major. */
HBIL_API void hbil_camera_from_opengl(hbil_camera *camera,
                                      const double camera_to_world[16],
                                      double fx, double fy, double cx,
                                      double cy);

typedef struct hbil_frame {
  size_t struct_size; /* set by hbil_frame_init(); see hbil_config */
  hbil_camera camera;
  /* Inputs and outputs.  Exactly those planes that have a format in the plan
   * must have a buffer. */
  hbil_plane depth, normal, albedo, f0, direct, emission, motion;
  hbil_plane near_irradiance, far_irradiance, ao, bent_normal, cone_cosine,
      indirect, beauty, error_estimate;
  /* The far field, RGB radiance in world space.  HBIL_FAR_CONSTANT reads
   * environment[0].  HBIL_FAR_FRAME reads environment[0] as the radiance of a
   * sky that `direct` already contains, 0 if it contains none.  HBIL_FAR_SH
   * reads nine coefficients of the real orthonormal basis in the order
   *   (0,0) (1,-1) (1,0) (1,1) (2,-2) (2,-1) (2,0) (2,1) (2,2) */
  float environment[9][3];
  /* Rotates the sampling pattern.  Use the number of the frame with
   * max_history_frames, else one constant, which avoids flicker. */
  cl_uint frame_index;
  /* CL_TRUE: nothing has moved since the plan's last frame.  Camera,
   * environment, frame_index and the contents of all inputs are the same, and
   * motion is 0; camera and frame_index are checked.  Only the carried light is
   * updated.  When it stops changing, bit for bit, nothing is gathered or
   * filtered.  With max_history_frames, frame_index may differ, and all frames
   * are gathered.  Ignored in a plan's first frame.  Callers who write to a
   * plan's stages must not set it. */
  cl_bool static_frame;
} hbil_frame;

/* Sets all members of a struct of struct_size bytes to 0.  The camera must be
 * set by the caller, since 0 is not valid.  Use the macro. */
HBIL_API void hbil_frame_init_sized(hbil_frame *frame, size_t struct_size);
#define hbil_frame_init(frame)                                                 \
  hbil_frame_init_sized((frame), sizeof(hbil_frame))

/* Projects a latitude-longitude map to order-2 spherical harmonics, on the
 * host.  rgb has `height` rows of `width` pixels of 3 floats.  Rows are
 * row_pitch bytes apart; 0 means without gaps.  The top row is the map's +z
 * pole, and a direction d has, as in Blender,
 *   column = width (0.5 - atan2(d.y, d.x) / (2 pi))
 *   row    = height acos(d.z) / pi
 * world_from_map is a row-major 3x3 rotation; NULL means the identity.  NaN,
 * negative and infinite values count as 0. */
HBIL_API hbil_status hbil_environment_from_latlong(
    const float *rgb, size_t width, size_t height, size_t row_pitch,
    const float world_from_map[9], float environment[9][3]);

/* ------------------------------------------------------------------------ */
/* Plan: kernels, buffers and history of one configuration                   */

typedef struct hbil_plan hbil_plan;

/* Computes how many bytes of device memory hbil_plan_create() would allocate,
 * as the exact sum of its buffers.  Checks config in the same way. */
HBIL_API hbil_status hbil_plan_memory(hbil_context *context,
                                      const hbil_config *config, size_t *bytes);

/* Builds the kernels and allocates the buffers, and waits for both.  config is
 * copied.  On failure *out is NULL and everything is released. */
HBIL_API hbil_status hbil_plan_create(hbil_context *context,
                                      const hbil_config *config,
                                      hbil_plan **out);

/* Releases a plan.  Commands already enqueued complete.  NULL is allowed. */
HBIL_API void hbil_plan_destroy(hbil_plan *plan);

/* Discards the history, so that the next frame is a first frame. */
HBIL_API void hbil_plan_reset(hbil_plan *plan);

/* ------------------------------------------------------------------------ */
/* Enqueue: a whole frame or single passes                                   */

/* hbil_enqueue_frame() enqueues all passes of a frame, in this order:
 *   reproject   history -> carried light of this frame, with holes
 *   push_pull   fills the holes from coarser levels
 *   split       G-buffer -> 4x4 interleaved layers
 *   gather      horizon search: layers -> AO, E_near and bent normal, in layers
 *   recompose   layers -> full resolution, filtered
 *   temporal    averages with the frames before (max_history_frames)
 *   composite   far light; writes the outputs and the history
 * The other functions enqueue one pass each, for callers who replace passes by
 * their own.  Such callers enqueue the passes in the same order, on one
 * in-order queue or chained by events, and access the data between the passes
 * with hbil_plan_buffer() of hbil_stages.h.  hbil_enqueue_composite() makes the
 * frame the plan's last frame.
 *
 * The queue must belong to the plan's context and device; it may be in-order or
 * out-of-order.  wait_count and wait_list work as in clEnqueueNDRangeKernel().
 * If event is not NULL, it receives an event that completes when the pass or
 * the frame is done; the caller releases it.  A pass with nothing to do, such
 * as reproject without a history, gives an event that follows the wait list.
 * frame is read during the call only. */
HBIL_API hbil_status hbil_enqueue_frame(hbil_plan *plan, cl_command_queue queue,
                                        const hbil_frame *frame,
                                        cl_uint wait_count,
                                        const cl_event *wait_list,
                                        cl_event *event);
HBIL_API hbil_status hbil_enqueue_reproject(
    hbil_plan *plan, cl_command_queue queue, const hbil_frame *frame,
    cl_uint wait_count, const cl_event *wait_list, cl_event *event);
HBIL_API hbil_status hbil_enqueue_push_pull(
    hbil_plan *plan, cl_command_queue queue, const hbil_frame *frame,
    cl_uint wait_count, const cl_event *wait_list, cl_event *event);
HBIL_API hbil_status hbil_enqueue_split(hbil_plan *plan, cl_command_queue queue,
                                        const hbil_frame *frame,
                                        cl_uint wait_count,
                                        const cl_event *wait_list,
                                        cl_event *event);
HBIL_API hbil_status hbil_enqueue_gather(
    hbil_plan *plan, cl_command_queue queue, const hbil_frame *frame,
    cl_uint wait_count, const cl_event *wait_list, cl_event *event);
HBIL_API hbil_status hbil_enqueue_recompose(
    hbil_plan *plan, cl_command_queue queue, const hbil_frame *frame,
    cl_uint wait_count, const cl_event *wait_list, cl_event *event);
HBIL_API hbil_status hbil_enqueue_temporal(
    hbil_plan *plan, cl_command_queue queue, const hbil_frame *frame,
    cl_uint wait_count, const cl_event *wait_list, cl_event *event);
HBIL_API hbil_status hbil_enqueue_composite(
    hbil_plan *plan, cl_command_queue queue, const hbil_frame *frame,
    cl_uint wait_count, const cl_event *wait_list, cl_event *event);

/* ------------------------------------------------------------------------ */
/* Figures: timings, statistics and sanitized pixels of the last frame       */

typedef enum hbil_pass {
  HBIL_PASS_REPROJECT = 0,
  HBIL_PASS_PUSH_PULL = 1,
  HBIL_PASS_SPLIT = 2,
  HBIL_PASS_GATHER = 3,
  HBIL_PASS_RECOMPOSE = 4,
  HBIL_PASS_TEMPORAL = 5,
  HBIL_PASS_COMPOSITE = 6,
  HBIL_PASS_COUNT = 7
} hbil_pass;

/* Returns "reproject", "push_pull" and so on, NULL for any other number. */
HBIL_API const char *hbil_pass_name(hbil_pass pass);

/* Computes how many milliseconds the device spent in each pass of the last
 * frame, 0 for passes that did not run.  Waits for the frame's commands.
 * Returns HBIL_INVALID_CONFIG if hbil_config.profiling is off. */
HBIL_API hbil_status hbil_plan_timings(hbil_plan *plan,
                                       double milliseconds[HBIL_PASS_COUNT]);

/* A span is what a work-item of the gather handles: up to 32 pixels of a
 * layer's row, and one pixel if vector_width is 1. */
typedef struct hbil_count {
  size_t pixels, spans;
} hbil_count;

/* What the last frame left out.  Pixels and spans outside the picture are not
 * counted.  All counts but `all` are 0 if the gather did not run. */
typedef struct hbil_statistics {
  hbil_count all;    /* the picture */
  hbil_count sky;    /* pixels of sky; spans with nothing else */
  hbil_count open;   /* nothing can block these (HBIL_SKIP_OPEN) */
  hbil_count dark;   /* no light is in reach (HBIL_SKIP_DARK) */
  hbil_count unused; /* no output shows their light (HBIL_SKIP_UNUSED) */
  /* Their light came from the horizon cache.  The rows of the cache have no
   * dark spans, neither in frames that fill it nor in those that read it. */
  hbil_count from_cache;
  cl_bool not_run[HBIL_PASS_COUNT]; /* passes that had nothing to do */
} hbil_statistics;

/* Reads the statistics of the last frame.  queue must be the one that the frame
 * was enqueued to; the call waits for everything in it.  Returns
 * HBIL_INVALID_ARGUMENT if there is no last frame or if it failed. */
HBIL_API hbil_status hbil_plan_statistics(hbil_plan *plan,
                                          cl_command_queue queue,
                                          hbil_statistics *out);

/* Numbers of pixels whose input was replaced, by the rules beside the formats
 * in hbil_config.  depth and emission count in all pixels, the others where
 * there is a surface.  What the plan does not read counts 0, like motion in
 * first and static frames.  A static frame has the last one's other counts. */
typedef struct hbil_sanitized {
  size_t depth, normal, albedo, f0, direct, emission, motion;
} hbil_sanitized;

/* Reads these numbers.  Waits and fails like hbil_plan_statistics(). */
HBIL_API hbil_status hbil_plan_sanitized(hbil_plan *plan,
                                         cl_command_queue queue,
                                         hbil_sanitized *out);

#ifdef __cplusplus
}
#endif

#endif
