/*
 * hbil: horizon-based indirect lighting from a G-buffer, through OpenCL.
 *
 * From depth, normals, albedo and diffuse light, hbil computes per pixel the
 * light that near surfaces send (E_near), ambient occlusion, the bent cone
 * through which far light comes in, that far light (E_far), and the lit
 * picture; its result is fed back, so light bounces once more every frame.
 * Method: B. Mayaux, "Horizon-Based Indirect Lighting", 2018, with the
 * corrections that HACKING.md derives.
 *
 * HOW A PROGRAM USES IT
 *   1. hbil_context_create() on an OpenCL context and device that you own.
 *   2. Fill an hbil_config (hbil_config_init() sets good defaults): size,
 *      formats of inputs and outputs, settings.  hbil_plan_memory() says how
 *      much device memory it needs; hbil_plan_create() builds the kernels and
 *      allocates the buffers, once.
 *   3. Every frame: fill an hbil_frame (camera, images) and call
 *      hbil_enqueue_frame(), or the passes one by one.
 *
 * CONVENTIONS
 *   View space: right-handed, x right, y down, z forward.  Pixel (i,j) has its
 *   centre at (i+0.5, j+0.5), origin at the top left, and looks along
 *   r = ((i+0.5-cx)/fx, (j+0.5-cy)/fy, 1).  Matrices: row-major 4x4 for column
 *   vectors.  Light: linear, any RGB primaries (they are never mixed).
 *   Radiance L in W/(m2 sr), irradiance E in W/m2; a diffuse surface sends
 *   L = (1-F0) albedo/pi E, plus its emission.
 *
 * THREADS
 *   A context and its plans may be used by one thread at a time.  Different
 *   contexts are independent, even on the same cl_context.
 *
 * BLOCKING
 *   The hbil_enqueue_* functions never wait for the device and allocate
 *   nothing themselves.  hbil_context_create(), hbil_plan_create() (compiles
 *   kernels) and hbil_plan_timings() may take long and may wait.
 *
 * ERRORS
 *   Every function that can fail returns an hbil_status; HBIL_SUCCESS is 0.
 *   hbil_context_message() gives one sentence on the context's last failure.
 *   Arguments are checked before anything is enqueued.  The library never
 *   prints, exits or aborts.
 *   A frame that fails half-way is none: the same one again, or another, has
 *   the history that it would have had.  What was enqueued of it still runs; on
 *   an out-of-order queue, wait for that first (clFinish).
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

/* Pixels across a frame, and from top to bottom, at most. */
#define HBIL_MAX_SIZE 16384

#if defined(_WIN32)
#define HBIL_API
#else
#define HBIL_API __attribute__((visibility("default")))
#endif

/* ------------------------------------------------------------------------ */
/* Status                                                                    */

typedef enum hbil_status {
  HBIL_SUCCESS = 0,
  HBIL_INVALID_ARGUMENT = 1, /* a null or malformed argument */
  HBIL_INVALID_CONFIG = 2,   /* a field of hbil_config is out of range */
  HBIL_INVALID_FRAME = 3,    /* a field of hbil_frame is missing or wrong */
  HBIL_OUT_OF_HOST_MEMORY = 4,
  HBIL_OUT_OF_DEVICE_MEMORY = 5, /* the device could not hold the buffers */
  HBIL_UNSUPPORTED_DEVICE = 6,   /* below OpenCL 1.2 or without a compiler */
  HBIL_BUILD_FAILED = 7,         /* a kernel did not compile; see the message */
  HBIL_OPENCL_ERROR = 8          /* any other OpenCL failure; see the message */
} hbil_status;

/* A short English sentence for a status; never NULL; static storage. */
HBIL_API const char *hbil_status_string(hbil_status status);

/* "major.minor.patch" of the library that is running; static storage. */
HBIL_API const char *hbil_version(void);

/* ------------------------------------------------------------------------ */
/* Context                                                                   */

typedef struct hbil_context hbil_context;

/*
 * A context binds the library to a cl_context and one of its devices.  Both
 * are retained until hbil_context_destroy().  Needs OpenCL 1.2 and an online
 * compiler; images, sub-groups and 64-bit atomics are not used.
 * Environment: HBIL_KERNEL_DIR names a folder from which the .cl files are
 * read in place of the embedded ones (for work on the kernels).
 */
HBIL_API hbil_status hbil_context_create(cl_context context,
                                         cl_device_id device,
                                         hbil_context **out);

/* Destroys a context whose plans are all destroyed.  NULL is allowed. */
HBIL_API void hbil_context_destroy(hbil_context *context);

/*
 * One sentence on the last failure in this context or one of its plans, with
 * the OpenCL error's name, and the build log where a kernel did not compile.
 * Empty if nothing has failed.  Valid until the next call on the context.
 */
HBIL_API const char *hbil_context_message(const hbil_context *context);

/* ------------------------------------------------------------------------ */
/* Images: a caller's buffer seen as pixels                                  */

typedef enum hbil_component {
  HBIL_NONE = 0,    /* no such image */
  HBIL_FLOAT32 = 1, /* 4 bytes */
  HBIL_FLOAT16 = 2, /* 2 bytes, IEEE half */
  HBIL_UNORM8 = 3   /* 1 byte, 0..255 for 0..1; inputs only */
} hbil_component;

/*
 * How pixels lie in a buffer; fixed per plan, since kernels are built for it.
 * stride: components from a pixel to its right-hand neighbour.  1 is planar
 * (each channel is a plane of its own, hbil_plane.plane_pitch apart), 3 or 4
 * is RGB or RGBA interleaved (channels are adjacent, extra ones untouched).
 * Single-channel images have stride 1, or more to pick one of a wider pixel.
 * 0 stands for the number of channels the image has.
 */
typedef struct hbil_plane_format {
  hbil_component component;
  cl_uint stride;
} hbil_plane_format;

/*
 * A caller's buffer holding one image.  The caller keeps ownership; the
 * commands that hbil enqueues use it until their event completes.
 * offset, row_pitch and plane_pitch are bytes and multiples of the component
 * size.  row_pitch 0: width * stride components.  plane_pitch (planar images
 * with more than one channel) 0: row_pitch * height.
 * The library checks that the last pixel lies inside the buffer.
 */
typedef struct hbil_plane {
  cl_mem buffer;
  size_t offset;
  size_t row_pitch;
  size_t plane_pitch;
} hbil_plane;

/* ------------------------------------------------------------------------ */
/* Configuration: everything that decides about kernels and memory           */

typedef enum hbil_depth_kind {
  HBIL_DEPTH_PLANAR = 0, /* z, along the camera's axis */
  HBIL_DEPTH_RAY = 1     /* distance from the eye */
} hbil_depth_kind;

/* How pixels look at the scene. */
typedef enum hbil_projection {
  /* all from one point: pixel (i,j) along ((i+0.5-cx)/fx, (j+0.5-cy)/fy, 1) */
  HBIL_PROJECTION_PERSPECTIVE = 0,
  /* all along z, from ((i+0.5-cx)/fx, (j+0.5-cy)/fy, 0): fx and fy are pixels
   * to a world unit.  Where other settings speak of a share of a depth, it is
   * one of the picture's width, in world units, since depths have no scale. */
  HBIL_PROJECTION_ORTHOGRAPHIC = 1
} hbil_projection;

typedef enum hbil_space {
  HBIL_SPACE_VIEW = 0, /* x right, y down, z forward */
  HBIL_SPACE_WORLD = 1
} hbil_space;

typedef enum hbil_reprojection {
  HBIL_REPROJECTION_NONE = 0,    /* no history: a single bounce */
  HBIL_REPROJECTION_SCATTER = 1, /* from camera movement; the nearest wins */
  HBIL_REPROJECTION_MOTION = 2   /* from motion vectors */
} hbil_reprojection;

/* What is carried to the next frame. */
typedef enum hbil_feedback {
  /* The indirect irradiance; the new frame's own albedo, direct light and
   * emission make radiance of it.  Direct light and texture have no lag. */
  HBIL_FEEDBACK_IRRADIANCE = 0,
  /* The diffuse radiance, direct light included, as in the paper (3.2). The
   * new frame's direct light serves only where nothing was carried over. */
  HBIL_FEEDBACK_RADIANCE = 1
} hbil_feedback;

/* What is computed, through the same march and the same passes. */
typedef enum hbil_mode {
  /* Near light, cosine-weighted AO, bent cone: Mayaux 2018. */
  HBIL_MODE_HBIL = 0,
  /* Ground-truth ambient occlusion (Jimenez et al. 2016): cosine-weighted AO
   * and bent normal; no near light.  The same AO as HBIL's. */
  HBIL_MODE_GTAO = 1,
  /* Horizon-based ambient occlusion (Bavoil et al. 2008): AO alone, every
   * direction of the hemisphere counting alike, and an occluder at distance r
   * only by its falloff W(r):
   *   AO = 1 - 1/(2 pi) integral over slices and elevations, from the tangent
   *        plane to the horizon, of W(r) cos(elevation)
   * with r the distance of the sample that raised the horizon there
   * (their "per-sample attenuation").  No near light, no bent cone. */
  HBIL_MODE_HBAO = 2
} hbil_mode;

/* Weight W of an occluder at distance r, for HBIL_MODE_HBAO; 1 where the radius
 * R is unlimited.  Occluders farther than R never count. */
typedef enum hbil_falloff {
  HBIL_FALLOFF_LINEAR = 0, /* max(0, 1 - r/R) */
  HBIL_FALLOFF_SOFT = 1,   /* 1 - r/(3R) */
  HBIL_FALLOFF_NONE = 2    /* 1 */
} hbil_falloff;

typedef enum hbil_far_field {
  HBIL_FAR_NONE = 0,     /* E_far = 0 */
  HBIL_FAR_CONSTANT = 1, /* the same radiance from everywhere */
  HBIL_FAR_SH = 2,       /* order-2 spherical harmonics, 9 coefficients */
  /* What the frame's own surfaces send on average towards the bent normal: for
   * rooms that close outside the picture.  With a sky's radiance in
   * environment[0], the same for the share of unblocked directions that the
   * direct light, which holds the sky's, leaves dark. */
  HBIL_FAR_FRAME = 3
} hbil_far_field;

/* Light of an interval that is blocked by a sample facing away. */
typedef enum hbil_back_facing_fallback {
  /* The last accepted radiance along the half-slice (paper, 3.4); at first
   * the pixel's own. */
  HBIL_FALLBACK_LAST_ACCEPTED = 0,
  HBIL_FALLBACK_BLACK = 1,
  /* What the frame's own surfaces send on average towards the pixel's normal:
   * the side that faces the pixel is one that the screen doesn't show. */
  HBIL_FALLBACK_FRAME_MEAN = 2
} hbil_back_facing_fallback;

/* Where the samples of a slice may lie. */
typedef enum hbil_sample_grid {
  HBIL_GRID_SAME_LAYER = 0, /* every fourth pixel, in the pixel's own layer */
  HBIL_GRID_FULL_RESOLUTION = 1 /* any pixel */
} hbil_sample_grid;

/*
 * How the layers between split and recompose are stored.  Depth is always fp32.
 * Fewer words are faster wherever memory is the limit.  PACKED differs from
 * FLOAT32 by at most 1e-3 of E_near's mean and 5e-4 of AO (RMSE, path-traced
 * dumps, doc/measurements.md), while sampling is off by hundreds of times that.
 * Where all surfaces send one even radiance, all samples are rounded alike:
 * there E_near is off by 2.1e-3; roundings allow 5e-3.  PACKED has one exponent
 * for three channels: what is less than a 500th of the brightest is lost.
 */
typedef enum hbil_storage {
  /* 3 + 3 words a pixel.  Normals octahedral in 2 x 16 bits; radiance, up to
   * 1e30, with 8 bits a channel and a common exponent, E_near with 10; AO in 16
   * bits, the unknown share in 8, the bent normal in 11, 11 and 10, dithered
   * over the 16 layers. */
  HBIL_STORAGE_PACKED = 0,
  HBIL_STORAGE_FLOAT32 = 1 /* 7 + 7 or 8 floats a pixel */
} hbil_storage;

/*
 * Work that cannot change a result, and is left out; hbil_config.skip is a sum
 * of these.  Whether there is such work is found out on the device, by the
 * frame itself: nothing is read back for it.  Results are the same bits with
 * and without, up to what is said here.
 */
typedef enum hbil_skip {
  /* gather: spans of pixels that are all sky */
  HBIL_SKIP_SKY = 1,
  /* gather: spans where nothing in reach stands above any tangent plane, by
   * bounds over cells of 64x64 pixels */
  HBIL_SKIP_OPEN = 2,
  /* gather: the light of samples that have none */
  HBIL_SKIP_DARK = 4,
  /* gather: surfaces whose irradiance nothing that is asked for shows, because
   * they reflect none of it (albedo 0, F0 1).  Only where `radiance` is the one
   * output, and no irradiance is carried over: with HBIL_REPROJECTION_NONE or
   * HBIL_FEEDBACK_RADIANCE.  The GATHERED and RESOLVED stages do differ. */
  HBIL_SKIP_UNUSED = 8,
  /* gather: samples that must be farther than the radius */
  HBIL_SKIP_RADIUS = 16,
  /* push_pull, where nothing is to be filled */
  HBIL_SKIP_HOLES = 32,
  /* all passes of frames with hbil_frame.static_frame; see horizon_cache_bytes
   */
  HBIL_SKIP_STATIC = 64,
  HBIL_SKIP_ALL = 127
} hbil_skip;

typedef struct hbil_config {
  /* Set by hbil_config_init().  This struct and hbil_frame may grow in later
   * versions, at their ends; programs that were compiled with a smaller one
   * get the defaults of what they don't know.  A larger one than the library
   * has, of a newer header, is refused. */
  size_t struct_size;

  cl_uint width, height; /* pixels, 1..HBIL_MAX_SIZE */

  /* Formats of the inputs.  depth and normal are needed, the others optional
   * (HBIL_NONE): albedo then is 1, all others 0.
   * Whatever they hold, results are finite.  What cannot be used is repaired,
   * pixel by pixel, before anything else looks at it; hbil_plan_sanitized()
   * counts it.  The rules:
   *   depth     NaN, negative, below 1e-15 (but not 0): sky.  That 0, what is
   *             1e15 or more, infinity and what is behind `background` are sky
   *             is no repair.
   *   normal    NaN, infinite, shorter than 1e-10, longer than 1e19: the
   *             direction to the eye.  (One that faces away is bent towards the
   *             eye until it is seen edge on; that is not counted.)
   *   albedo, f0        NaN, infinite, negative: 0; above 1: 1
   *   direct, emission  NaN, negative, above 1e30: 0.  (Of direct after
   *             direct_scale.)
   *   motion    NaN, infinite: nothing is carried over to that pixel. */
  hbil_plane_format depth;  /* 1 channel; see depth_kind, background */
  hbil_plane_format normal; /* 3 channels, any length; see normal_space */
  hbil_plane_format albedo; /* 3 channels, diffuse reflectance, 0..1 */
  hbil_plane_format f0; /* 3 channels, reflectance at normal incidence, 0..1 */
  hbil_plane_format direct;   /* 3 channels, irradiance of direct light; see
                           direct_scale */
  hbil_plane_format emission; /* 3 channels, radiance */
  hbil_plane_format motion;   /* 2 channels, pixels; see motion_scale */

  /* Formats of the outputs (FLOAT32 or FLOAT16), at least one; those left
   * HBIL_NONE are not computed where nothing else needs them. */
  hbil_plane_format near_irradiance; /* 3: E_near, irradiance */
  hbil_plane_format far_irradiance;  /* 3: E_far, irradiance */
  hbil_plane_format ao;          /* 1: ambient visibility, 1 open .. 0 closed */
  hbil_plane_format bent_normal; /* 3: unit bent normal (see bent_space), 0 for
                        sky and where nothing at all is open */
  hbil_plane_format cone_cosine; /* 1: cosine of the bent cone's half-angle */
  hbil_plane_format indirect;    /* 3: (1-F0) (E_near + E_far) / pi */
  hbil_plane_format beauty;      /* 3: albedo ((1-F0) E_direct/pi + indirect)
                                   + emission; at the sky: emission if given,
                                   else the far field */

  hbil_plane_format error_estimate; /* 2: an estimate of how far AO and E_near
                        (each of its channels, irradiance) may be off because
                        samples are few: 95 % of the pixels are off by
                        less.  From how much the pixels differ that the
                        filter brings together; 0 for sky.  Of AO alone,
                        and 0, where there is no light.  HACKING.md,
                        "Adaptive sampling".  Measured with occluders
                        that don't end; with others it is too small */

  /* How inputs are read. */
  hbil_projection projection; /* of all frames' cameras; default PERSPECTIVE */
  hbil_depth_kind depth_kind;
  float sky_depth;         /* depths >= this are sky, like 0 and all from 1e15
                               on; default infinity */
  hbil_space normal_space; /* default view */
  hbil_space bent_normal_space; /* default view */
  float direct_scale;    /* factor that makes E_direct of `direct`; default 1 */
  float motion_scale[2]; /* factors that make (previous - current) position,
                            in pixels, x right, y down, of `motion` */

  /* The method. */
  hbil_mode mode;       /* default HBIL.  GTAO cannot have near_irradiance nor
                           HBIL_FAR_FRAME; HBAO neither, nor bent, cone,
                           HBIL_FAR_SH.  Their `indirect` is far light alone. */
  hbil_falloff falloff; /* with HBIL_MODE_HBAO only; default LINEAR */
  float radius;         /* world units; occluders farther from the point are
                           ignored; infinity (default): unlimited */
  float thickness;      /* of occluders, world units, > 0; infinity (default):
                           they never end, as in the paper */
  float relative_thickness; /* the same as a share of the occluder's depth; the
                               smaller of both counts; default infinity */
  /* Per pixel, 1..32; default 2.  A single one gets most out of its time where
   * it has neighbours on the same surface, and leaves streaks on what is hardly
   * wider than a pixel. */
  cl_uint slices;
  cl_uint steps_per_side; /* per side of a slice, 1..256; default 8 */
  float step_growth;      /* spacing of samples, 0..64: 0 equal steps; g: the
                             last step is (1+g)^2 times the first; default 2 */
  hbil_sample_grid sample_grid; /* default FULL */
  /* What lies between the samples is judged by how much half of them miss
   * (jackknife; HACKING.md, "What lies between the samples"): so much is added
   * to what is blocked, with as much light as was found there on average, 3/2
   * of it at most.  AO stays in 0..1, E_near below pi times the largest
   * radiance; where samples are all the pixels nothing changes.  Costs an angle
   * a half-slice: a seventh of the gather at 2 x 8.  Default CL_TRUE. */
  cl_bool extrapolate;
  float facing_fade[2]; /* radiance of a sample fades in as the cosine between
                      its normal and the direction back to the point goes
                      from facing[0] to facing[1]; -1..1, ascending;
                      -1, -1: none is refused; default -0.1, 0 */
  hbil_back_facing_fallback back_facing_fallback; /* default LAST */
  cl_bool gather_emission; /* emission lights neighbours too (CL_TRUE), or is
                              in `direct` already (CL_FALSE); default CL_TRUE */
  hbil_reprojection reprojection; /* default SCATTER */
  hbil_feedback feedback;         /* default IRRADIANCE */
  float disocclusion_threshold; /* carried-over light is dropped where its depth
                         is off the new depth by more than this share; > 0;
                         infinity: never; default 0.05 */
  /* Temporal filter: AO, E_near and the bent normal become means over as many
   * frames, of what each surface was given in them; 0 (default): off, and
   * nothing of it is there; at most 1024.  A surface is looked up in the frame
   * before by its motion vector with HBIL_REPROJECTION_MOTION, else by the
   * cameras, and begins anew where it was not to be seen: where depth is off
   * its tangent plane by more than `disocclusion`, or normals differ by more
   * than 33 degrees.  The first `temporal` frames weigh alike, then the newest
   * one weighs 1/temporal and older ones fade out.
   * What differs from frame to frame is the sampling: hbil_frame.index must go
   * on by 1 every frame, still ones included; with one index for all the mean
   * is no better than a frame.  2 to 4 where the camera moves, 8 and more where
   * nothing does.  Light that changes, shadows that move, and whatever moves
   * without the cameras or motion vectors telling, lags by some frames; so does
   * light that is fed back, which is the mean's. */
  cl_uint max_history_frames;
  hbil_far_field far_field; /* default NONE */
  cl_bool unfiltered;       /* CL_TRUE: recompose only undoes the 4x4 split and
                                   filters nothing, the dither of packed storage
                                   included; default CL_FALSE */

  /* How it runs. */
  hbil_storage storage; /* default PACKED */
  cl_uint skip;         /* of hbil_skip; default ALL */
  cl_uint vector_width; /* 1, 4, 8, 16; 0 (default): chosen for the device */
  cl_bool profiling; /* keep events for hbil_plan_timings(); needs queues made
                        with CL_QUEUE_PROFILING_ENABLE; default CL_FALSE */
  /* Form factors: what each sample's light counts for a pixel.  Shapes alone
   * decide that; so the first of several still frames (hbil_frame.still) keeps
   * them, in the time that a moving one takes, and those after it look for no
   * horizons, but add up light: the same bits in two fifths of the gather's
   * time.  This is how many bytes of device memory they may take.  All pixels
   * take
   *   P (4 (2 S (F N + X) + S + 1) + 8 S (N + 1) / W)
   * with S slices, N samples, W = vector_width, X = 1 with extrapolate, else 0,
   * F = 2 with HBIL_FALLBACK_LAST_ACCEPTED, unless facing refuses none, else 1,
   * and P pixels: width rounded up to a multiple of 128 (of 4 where W is 1)
   * times height rounded up to one of 4.  Where this is less, or the device has
   * no such buffer, as many rows are kept as fit and the others gathered as
   * ever. None are with max_history_frames, without HBIL_SKIP_STATIC, or
   * where no light is carried over.  Default 0 */
  size_t horizon_cache_bytes;
} hbil_config;

/* Named models: what is computed, apart from how well it is sampled. */
typedef enum hbil_model {
  /* The default, which has the smallest error against path-traced light on the
   * scenes of doc/measurements.md: occluders are as thick as 8 % of their
   * depth, and all visible light counts. */
  HBIL_MODEL_DEFAULT = 0,
  /* Mayaux 2018: occluders never end, the light of samples that face away fades
   * between the cosines -0.1 and 0, the last accepted radiance stands in for
   * it, radiance is carried over, and nothing is extrapolated. */
  HBIL_MODEL_PAPER = 1
} hbil_model;

/* Sets thickness, relative_thickness, facing_fade, back_facing_fallback,
 * feedback and extrapolate.  The far field is the caller's choice.
 * HBIL_INVALID_ARGUMENT for a null config or a number that is no model. */
HBIL_API hbil_status hbil_config_set_model(hbil_config *config,
                                           hbil_model model);

/*
 * Presets of the sampling (slices, samples, step_growth, lattice,
 * unfiltered, storage); nothing else is touched, so they go with every
 * model.
 * Chosen from `hbil bench` (README.md has the plot, HACKING.md the figures).
 */
typedef enum hbil_quality {
  HBIL_QUALITY_FAST = 0,
  HBIL_QUALITY_BALANCED = 1,
  HBIL_QUALITY_HIGH = 2,
  /* As dense as the settings go, without the filter: what the others are
   * compared with where the exact integral is out of reach. */
  HBIL_QUALITY_REFERENCE = 3
} hbil_quality;

/* HBIL_INVALID_ARGUMENT for a null config or a number that is no preset. */
HBIL_API hbil_status hbil_config_set_quality(hbil_config *config,
                                             hbil_quality quality);

/* "fast", "balanced", "high", "reference"; NULL for any other number. */
HBIL_API const char *hbil_quality_name(hbil_quality quality);

/* Defaults, in struct_size bytes; width, height and the formats are left at 0
 * for the caller. */
HBIL_API void hbil_config_init_sized(hbil_config *config, size_t struct_size);
#define hbil_config_init(config)                                               \
  hbil_config_init_sized((config), sizeof(hbil_config))

/* ------------------------------------------------------------------------ */
/* Frame: camera and images                                                  */

/* A camera.  world_from_view must be rigid (rotation and translation); it is
 * checked to 1e-3, and a mirroring (left-handed) one is refused. */
typedef struct hbil_camera {
  double fx, fy; /* focal lengths, pixels, > 0; orthographic: pixels to a world
                    unit */
  double cx, cy; /* principal point, pixels from the top left corner */
  double world_from_view[16];
} hbil_camera;

/*
 * Makes a camera from the convention of OpenGL and Blender: camera_to_world
 * with x right, y up, looking down -z.
 */
HBIL_API void hbil_camera_from_opengl(hbil_camera *camera,
                                      const double camera_to_world[16],
                                      double fx, double fy, double cx,
                                      double cy);

typedef struct hbil_frame {
  size_t struct_size; /* set by hbil_frame_init(); see hbil_config's */
  hbil_camera camera;
  /* Inputs and outputs: exactly those whose format the plan has. */
  hbil_plane depth, normal, albedo, f0, direct, emission, motion;
  hbil_plane near_irradiance, far_irradiance, ao, bent_normal, cone_cosine,
      indirect, beauty, error_estimate;
  /* Far field: radiance in environment[0] for HBIL_FAR_CONSTANT; radiance of
   * the sky that is in the direct light already, or 0, for HBIL_FAR_FRAME; for
   * HBIL_FAR_SH the coefficients of the real orthonormal basis in world space,
   * order (0,0) (1,-1) (1,0) (1,1) (2,-2) (2,-1) (2,0) (2,1) (2,2). */
  float environment[9][3];
  cl_uint
      frame_index; /* turns the sampling pattern; constant for a still pattern,
                the number of the frame with hbil_config.temporal */
  /* CL_TRUE: the camera, the contents of all inputs, environment and index are
   * those of the plan's last frame (this is checked of camera and index), and
   * motion, if there is any, is 0: nothing has moved since that frame.  Then
   * nothing is reprojected or split again but the light, and where that has
   * settled, bit for bit, nothing is gathered or filtered: outputs are written
   * from what there is.  With hbil_config.temporal index may differ, and every
   * frame is gathered, so that the mean goes on converging.  Ignored in a
   * plan's first frame.  Not for callers who write to a plan's buffers between
   * the passes. */
  cl_bool static_frame;
} hbil_frame;

/* Everything zero, in struct_size bytes: no images, no far light, an invalid
 * camera. */
HBIL_API void hbil_frame_init_sized(hbil_frame *frame, size_t struct_size);
#define hbil_frame_init(frame)                                                 \
  hbil_frame_init_sized((frame), sizeof(hbil_frame))

/*
 * Projects a latitude-longitude map onto order-2 SH, on the host.
 * rgb: height rows of width pixels of 3 floats, row_pitch bytes apart (0:
 * packed), top row = the +z pole of the map.  A direction d has column
 * width * (0.5 - atan2(d.y, d.x) / (2 pi)) and row height * acos(d.z) / pi, as
 * in Blender.  world_from_map: row-major 3x3 rotation, NULL for identity.
 */
HBIL_API hbil_status hbil_environment_from_latlong(
    const float *rgb, size_t width, size_t height, size_t row_pitch,
    const float world_from_map[9], float environment[9][3]);

/* ------------------------------------------------------------------------ */
/* Plan                                                                      */

typedef struct hbil_plan hbil_plan;

/* Bytes of device memory that hbil_plan_create() will allocate for config:
 * the exact sum of its buffer sizes.  Checks config. */
HBIL_API hbil_status hbil_plan_memory(hbil_context *context,
                                      const hbil_config *config, size_t *bytes);

/* Builds kernels and allocates buffers.  config is copied.  On failure *out is
 * NULL and nothing is left behind. */
HBIL_API hbil_status hbil_plan_create(hbil_context *context,
                                      const hbil_config *config,
                                      hbil_plan **out);

/* Releases a plan.  Commands already enqueued still complete (OpenCL keeps
 * what they use).  NULL is allowed. */
HBIL_API void hbil_plan_destroy(hbil_plan *plan);

/* Forgets the history: the next frame is treated as a first frame. */
HBIL_API void hbil_plan_reset(hbil_plan *plan);

/* ------------------------------------------------------------------------ */
/* Enqueue: one frame, or pass by pass                                       */

/*
 * All enqueue functions: queue belongs to the plan's context and device, in
 * order or out of order; wait_list as in clEnqueueNDRangeKernel; event, if not
 * NULL, receives an event that completes when the pass (frame) is done, and
 * must be released by the caller.  frame is read during the call only.
 *
 * hbil_enqueue_frame() runs, in this order:
 *   reproject   history -> carried light of this frame, with holes
 *   push_pull   fills the holes from coarser levels
 *   split       G-buffer -> 4x4 interleaved layers
 *   gather      horizon search -> AO, E_near, bent normal, per layer
 *   recompose   layers -> full-resolution planes, filtered
 *   temporal    the same and those of the frames before -> their mean; nothing
 *               unless hbil_config.temporal asks for it
 *   composite   far light, outputs, history for the next frame
 * A caller who replaces passes enqueues the others alone, in that order and on
 * one queue or chained by events, and reaches what they exchange through
 * hbil_plan_buffer().  reproject and push_pull enqueue nothing when there is
 * no history; the event then follows the wait list.
 * hbil_enqueue_composite() makes the frame the plan's history.
 */
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
/* Figures: what the last frame took                                         */

/* Device time of the last frame, pass by pass. */
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

/* "reproject", "push_pull", ...; NULL for a number that is no pass. */
HBIL_API const char *hbil_pass_name(hbil_pass pass);

/* Milliseconds the device spent in each pass since the last hbil_enqueue_frame
 * began (0 for a pass that did not run).  Waits for those commands.  Needs
 * config.profiling and a queue with profiling. */
HBIL_API hbil_status hbil_plan_timings(hbil_plan *plan,
                                       double milliseconds[HBIL_PASS_COUNT]);

/* What the last frame left out (hbil_skip). */
typedef struct hbil_count {
  size_t pixels, spans;
} hbil_count;
typedef struct hbil_statistics {
  hbil_count all; /* of the picture; a span is what a work-item of the gather
                     takes together: up to 32 pixels of a layer's row */
  /* What the gather had no need of; pixels and spans outside the picture are
   * not counted.  All 0 where the gather itself did not run. */
  hbil_count sky;    /* pixels of sky; spans of nothing else */
  hbil_count open;   /* nothing there can be blocked */
  hbil_count dark;   /* no light is in reach: AO and bent normals alone */
  hbil_count unused; /* no irradiance is asked for */
  /* light was gathered by hbil_config.horizon_cache_bytes; where it is, or they
   * are kept in this frame, nothing is left out as dark */
  hbil_count from_cache;
  /* passes that had nothing to do, or found on the device that they had not */
  cl_bool not_run[HBIL_PASS_COUNT];
} hbil_statistics;

/* Reads them; waits for all that is in `queue`, which must be the one that the
 * frame was enqueued to. */
HBIL_API hbil_status hbil_plan_statistics(hbil_plan *plan,
                                          cl_command_queue queue,
                                          hbil_statistics *out);

/* Pixels of the last frame of which an input could not be used as it was, by
 * the rules beside the inputs' formats (hbil_config).  Normals and what
 * surfaces send are counted where there is a surface, emission at the sky, too;
 * an input that the plan doesn't look at is never counted.  Of a still frame
 * (hbil_frame.still), whose inputs are those of the frame before, it is that
 * one's numbers; motion is not looked at then, nor in a first frame. */
typedef struct hbil_sanitized {
  size_t depth, normal, albedo, f0, direct, emission, motion;
} hbil_sanitized;

/* Reads them, as hbil_plan_statistics() does. */
HBIL_API hbil_status hbil_plan_sanitized(hbil_plan *plan,
                                         cl_command_queue queue,
                                         hbil_sanitized *out);

#ifdef __cplusplus
}
#endif

#endif
