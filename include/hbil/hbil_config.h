/*
 * hbil: the configuration of a plan, in groups: inputs, outputs, model,
 * sampling, history and execution.  Programs include hbil/hbil.h.
 */
#ifndef HBIL_HBIL_CONFIG_H
#define HBIL_HBIL_CONFIG_H

#include <hbil/hbil_formats.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------ */
/* Inputs: the planes of the G-buffer, and how they are read                 */

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
  HBIL_SPACE_VIEW = 0, /* the camera's: x towards the next column of pixels, y
                          towards the next row, z forward */
  HBIL_SPACE_WORLD = 1
} hbil_space;

typedef enum hbil_normal_encoding {
  HBIL_NORMAL_XYZ = 0, /* 3 channels, of any length */
  /* 2 channels: octahedral coordinates u, v in -1..1 (Cigolle and others 2014,
   * "A Survey of Efficient Representations for Independent Unit Vectors").
   * The direction is (u, v, 1 - |u| - |v|) where that z is not negative, else
   * ((1 - |v|) sign(u), (1 - |u|) sign(v), 1 - |u| - |v|); sign(0) is 1. */
  HBIL_NORMAL_OCTAHEDRAL = 1
} hbil_normal_encoding;

typedef struct hbil_inputs {
  /* Formats.  depth is needed; the others may be HBIL_NONE.  Without a plane,
   * albedo is 1, normals are rebuilt from depth, and the others are 0.
   * Results are finite whatever the inputs hold.  Unusable values are replaced,
   * and hbil_plan_sanitized() counts the pixels:
   *   depth     NaN, negative, below 1e-15 except 0: sky; of hardware depth:
   *             NaN, and what means a depth below 1e-15
   *   normal    NaN, infinite, shorter than 1e-10, longer than 1e19: the
   *             direction to the eye
   *   albedo, f0        NaN, infinite, negative: 0; above 1: 1
   *   direct, emission  NaN, negative, above 1e30 (after direct_scale): 0
   *   motion    NaN, infinite: nothing is carried over to the pixel
   * Depths here are those after depth_scale.
   * Depths of 0, and from 1e15 or sky_depth on, are sky and not counted.
   * Normals that face away are turned until nearly edge on, and counted apart
   * (hbil_sanitized.facing_away).
   * Components: HBIL_FLOAT32, HBIL_FLOAT16, and the others that are named. */
  /* 1 channel; see depth_kind, sky_depth.  Hardware depth: HBIL_UNORM16,
   * HBIL_UNORM24 */
  hbil_plane_format depth;
  /* 3 channels, or 2; see normal_encoding, normal_space.  HBIL_UNORM8,
   * HBIL_UNORM16, HBIL_RGB10A2_UNORM: a value v stands for 2v - 1.
   * HBIL_SNORM8, HBIL_SNORM16.
   * HBIL_NONE: each frame's normals are rebuilt from depth, which must have
   * more than 16 bits to be exact enough.  They lack what normal maps and
   * smooth shading add (doc/method.md, section 21; errors:
   * doc/measurements.md). */
  hbil_plane_format normal;
  /* Colours, linear light: HBIL_UNORM8, HBIL_UNORM16, HBIL_RGB10A2_UNORM,
   * HBIL_R11G11B10_FLOAT, HBIL_RGB9E5_FLOAT.  HBIL_SRGB8 is made linear. */
  hbil_plane_format albedo;   /* 3 channels, diffuse reflectance, 0..1 */
  hbil_plane_format f0;       /* 3 channels, reflectance at normal incidence */
  hbil_plane_format direct;   /* 3 channels; see direct_kind, direct_scale */
  hbil_plane_format emission; /* 3 channels, radiance */
  /* 2 channels; see motion_scale.  HBIL_SNORM16.  Read with
   * HBIL_REPROJECTION_MOTION alone */
  hbil_plane_format motion;

  hbil_projection projection; /* of all cameras; default PERSPECTIVE */
  hbil_depth_kind depth_kind; /* default PLANAR */
  /* Depths, after depth_scale, from here on are sky; > 0; default infinity. */
  float sky_depth;
  hbil_space normal_space; /* default VIEW */
  float direct_scale; /* `direct` is multiplied by this; 0..1e30; default 1 */
  /* `motion` times this is the previous position minus the current one, in
   * pixels, x towards the next column, y towards the next row.  -1e6..1e6;
   * default 1, 1.  If pictures are jittered, the vectors may have the
   * difference of both jitters or not: light differs by .4 % (doc/guide.md). */
  float motion_scale[2];
  hbil_normal_encoding normal_encoding; /* default XYZ */
  /* Planar depth and distances from the eye are `depth` times this, in the
   * camera's units.  -1 is for depths that count backwards, such as z of
   * OpenGL's view space.  Of hardware depth, hardware_depth tells the unit, and
   * this is not used.  -1e6..1e6, not 0; default 1 */
  float depth_scale;
  /* Normals are x, y and z of `normal`, decoded, times these, in the space
   * normal_space.  They turn axes round.  If the first row of the planes is the
   * top one, 1, -1, -1 is for OpenGL's view space (y up, z backward), and 1,
   * -1, 1 for Direct3D's (y up, z forward).  If it is the lowest one
   * (HBIL_MATRIX_Y_DOWN), the sign of y stays: 1, 1, -1 and 1, 1, 1.
   * -1e6..1e6, not 0; default 1, 1, 1 */
  float normal_scale[3];
  hbil_direct_kind direct_kind; /* default IRRADIANCE */
} hbil_inputs;

/* ------------------------------------------------------------------------ */
/* Outputs: what is asked for                                                */

typedef struct hbil_outputs {
  /* Formats: HBIL_FLOAT32, HBIL_FLOAT16 or HBIL_IMAGE, at least one.  What
   * is HBIL_NONE is computed only if another output needs it.  At the sky ao is
   * 1 and the others are 0, except for beauty. */
  /* 3 channels each: light of surfaces within model.radius that the screen
   * shows, E_near; and light through all other directions, E_far */
  hbil_plane_format near_irradiance, far_irradiance;
  /* Of occluders within model.ao_radius, whatever model.radius is.
   * 1 channel: 1 is open, 0 is closed */
  hbil_plane_format ao;
  /* 3 channels: unit vector, 0 if nothing is open; see bent_normal_space */
  hbil_plane_format bent_normal;
  hbil_plane_format cone_cosine; /* 1: cosine of the half-angle, sqrt(1-AO) */
  hbil_plane_format indirect;    /* 3 channels: (1-F0) (E_near + E_far) / pi */
  /* 3 channels: albedo ((1-F0) E_direct/pi + indirect) + emission.  At the sky:
   * the emission if there is such a plane, else the radiance of
   * HBIL_FAR_CONSTANT or HBIL_FAR_SH, else 0. */
  hbil_plane_format beauty;
  /* 2 channels: estimates of the sampling errors of ao and of E_near (per
   * channel, irradiance), which 95 % of the pixels don't exceed in most scenes
   * (doc/method.md, section 19).  Both are 0 with sampling.unfiltered, and the
   * second also if no E_near is computed. */
  hbil_plane_format error_estimate;
  /* 1 channel: the share of the hemisphere, cosine weighted, whose light is a
   * guess because the screen does not show it; 0: all is known .. 1: all is
   * guessed.  With HBIL_FAR_FRAME the open directions that get the frame's
   * estimate count; with HBIL_FALLBACK_FRAME_MEAN, what surfaces facing away
   * block (facing_fade).  No other far field or fallback counts as a guess.  In
   * the rest of the hemisphere, light comes from surfaces that the screen
   * shows, from the far field, or is known to be none (doc/method.md, section
   * 11). */
  hbil_plane_format unknown;
  /* 3 channels: the mean indirect radiance that a mirror of model.roughness
   * reflects to the eye, without its colour.  For HBIL_MODE_HBIL and the
   * cache methods NONE and RAYS (doc/method.md, section 23). */
  hbil_plane_format glossy;

  hbil_space bent_normal_space; /* default VIEW */
} hbil_outputs;

/* ------------------------------------------------------------------------ */
/* Model: what is computed                                                   */

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
   * section 18).  HBAO rejects what GTAO rejects, and also bent_normal,
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
  /* An estimate for places that continue outside the picture: offscreen_light
   * times the mean of what the frame's own surfaces send towards the bent
   * normal, after all bounces, so a first frame has nearly the same.  It
   * is mixed with the mean of what the pixel itself sees.  If
   * `direct` contains a sky, environment[0] tells its radiance, and only
   * directions that the sky does not light get the estimate.  If the picture
   * does not show that sky, use hbil_frame.sky_share (doc/method.md, section
   * 11). */
  HBIL_FAR_FRAME = 3,
  /* What hbil_config_suggest() chooses for a frame that shows no sky:
   * HBIL_FAR_FRAME with HBIL_MODE_HBIL, else HBIL_FAR_NONE */
  HBIL_FAR_AUTO = 4
} hbil_far_field;

/* The light of directions that are blocked by a surface facing away, whose
 * other side the screen does not show; see hbil_model.facing_fade. */
typedef enum hbil_back_facing_fallback {
  /* the last accepted radiance on the same half-slice, at first the pixel's own
   * (paper, 3.4) */
  HBIL_FALLBACK_LAST_ACCEPTED = 0,
  HBIL_FALLBACK_BLACK = 1, /* none */
  /* the mean of what the frame's surfaces send towards the pixel's normal */
  HBIL_FALLBACK_FRAME_MEAN = 2
} hbil_back_facing_fallback;

/* How the light of a radiance cache (hbil_cache.h) is found, at probes all over
 * the picture.  Their errors and times are in doc/measurements.md. */
typedef enum hbil_cache_method {
  HBIL_CACHE_METHOD_NONE = 0, /* frames have no cache */
  /* Rays from surface to surface: the most accurate one */
  HBIL_CACHE_METHOD_RAYS = 1,
  /* Cones through coarser and coarser means of the cache (Crassin and others
   * 2011, "Interactive Indirect Illumination Using Voxel Cone Tracing") */
  HBIL_CACHE_METHOD_CONES = 2,
  /* Light propagation volumes: light spreads from the cache's surfaces from
   * cell to cell (Kaplanyan and Dachsbacher 2010, "Cascaded Light Propagation
   * Volumes for Real-Time Indirect Illumination") */
  HBIL_CACHE_METHOD_LPV = 3,
  /* Reflective shadow maps: the first bounce of the lights whose views are
   * given to hbil_enqueue_cache_light_views(), without occlusion (Dachsbacher
   * and Stamminger 2005, "Reflective Shadow Maps") */
  HBIL_CACHE_METHOD_RSM = 4
} hbil_cache_method;

/* Stand-ins for the light that occluders reflect, where no near light is
 * computed: the far irradiance, which knows only the open share AO, is
 * multiplied by F / AO. */
typedef enum hbil_ao_bounces {
  HBIL_AO_BOUNCES_NONE = 0, /* F = AO: occluders are black */
  /* F0(AO) = AO (1 + (1 - AO)^0.75 / 2), whatever the albedo (Mayaux 2018,
   * "Horizon-Based Indirect Lighting", 2.2.3); up to 1.0062, where AO is .98 */
  HBIL_AO_BOUNCES_PAPER = 1,
  /* F = max(AO, ((a AO + b) AO + c) AO) for each channel of the pixel's own
   * albedo r: a = 2.0404 r - 0.3324, b = -4.7951 r + 0.6417, c = 2.7552 r +
   * 0.6903 (Jimenez, Wu, Pesce and Jarabo 2016, "Practical Realtime Strategies
   * for Accurate Indirect Occlusion", a fit to path tracing where all surfaces
   * have that albedo).  Without the input albedo, r is 1. */
  HBIL_AO_BOUNCES_ALBEDO = 2
} hbil_ao_bounces;

typedef struct hbil_model {
  hbil_mode mode;       /* default HBIL */
  hbil_falloff falloff; /* for HBIL_MODE_HBAO only; default LINEAR */
  /* Of the near field, world units, > 0; default infinity.  Farther surfaces
   * send no near light and block no far light. */
  float radius;
  /* Thickness of occluders in world units, and as a share of their depth; > 0.
   * The smaller one counts.  Infinity: occluders have no back; model */
  float thickness;
  float relative_thickness;
  /* CL_TRUE: finds what lies between the samples (doc/method.md, section 7): a
   * sample stands for its whole step.  Without effect where both thicknesses
   * are infinite; model */
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
  hbil_feedback feedback;   /* model */
  hbil_far_field far_field; /* default AUTO; model */
  /* HBIL_FAR_FRAME and HBIL_FALLBACK_FRAME_MEAN guess the radiance of surfaces
   * that the picture doesn't show: it is this many times the mean radiance of
   * the surfaces that it shows.  0..1; 1 is for places that are alike on all
   * sides; default 0.76, chosen by its error on path-traced scenes
   * (doc/measurements.md) */
  float offscreen_light;
  /* Frames may have a radiance cache of this method (hbil_frame.cache), and
   * open directions get the light that it knows.  For HBIL_MODE_HBIL;
   * hbil_config_use_cache() sets it.  Default HBIL_CACHE_METHOD_NONE */
  hbil_cache_method cache_method;
  /* Of outputs.glossy: the root of GGX's alpha; 0.3..1; default 0.5 */
  float roughness;
  /* Changes far_irradiance, indirect and beauty; `ao` stays as it is.  Near
   * light has these bounces, so NONE is needed where it is computed: for
   * HBIL_MODE_HBIL, unless of all outputs only far_irradiance, ao, bent_normal,
   * cone_cosine and error_estimate are asked for, and far_field isn't
   * HBIL_FAR_FRAME.  Default NONE */
  hbil_ao_bounces ao_bounces;
  /* Of the occluders that outputs.ao, bent_normal and cone_cosine count, world
   * units, > 0; default infinity.  Where radius or near_relative_thickness
   * make the near field another one, and these outputs or error_estimate are
   * asked for beside light, they need a search of their own (time:
   * doc/measurements.md).  HBIL_MODE_HBAO has `radius` in its place. */
  float ao_radius;
  /* relative_thickness of the near field where that is larger; > 0; default
   * infinity.  hbil_config_use_cache() sets it.  Not for HBIL_MODE_HBAO */
  float near_relative_thickness;
} hbil_model;

/* Named models of light and occluders. */
typedef enum hbil_model_name {
  /* The default, chosen by its error on four path-traced scenes: infinite
   * thickness, relative_thickness 0.06, facing_fade -1, -1, extrapolate on,
   * HBIL_FALLBACK_FRAME_MEAN, HBIL_FEEDBACK_IRRADIANCE, HBIL_FAR_AUTO */
  HBIL_MODEL_DEFAULT = 0,
  /* The paper: both thicknesses infinite, facing_fade -0.1, 0,
   * HBIL_FALLBACK_LAST_ACCEPTED, HBIL_FEEDBACK_RADIANCE, extrapolate off,
   * HBIL_FAR_NONE */
  HBIL_MODEL_PAPER = 1
} hbil_model_name;

/* Sets thickness, relative_thickness, facing_fade, back_facing_fallback,
 * feedback, extrapolate and far_field.  Returns HBIL_INVALID_ARGUMENT if
 * model is null or name is not in the list. */
HBIL_API hbil_status hbil_model_set(hbil_model *model, hbil_model_name name);

/* ------------------------------------------------------------------------ */
/* Sampling: how well it is computed                                         */

/* The pixels that can be samples of a pixel. */
typedef enum hbil_sample_grid {
  HBIL_GRID_SAME_LAYER = 0,     /* every fourth one in x and y (paper, 3.3) */
  HBIL_GRID_FULL_RESOLUTION = 1 /* all */
} hbil_sample_grid;

/* Which pixels are gathered. */
typedef enum hbil_resolution {
  /* HALF for frames of HBIL_HALF_RESOLUTION_PIXELS and more that are filtered,
   * otherwise FULL.  Smaller pictures have more edges and take little time
   * anyway. */
  HBIL_RESOLUTION_AUTO = 0,
  HBIL_RESOLUTION_FULL = 1, /* all */
  /* Every second one in x and in y.  The filter, which this needs, fills in the
   * others. */
  HBIL_RESOLUTION_HALF = 2
} hbil_resolution;

/* AUTO is HALF from this width * height on; doc/measurements.md, "Half
 * resolution" */
#define HBIL_HALF_RESOLUTION_PIXELS 400000

/* How planes between the passes are stored.  Depth is a 32-bit float in both.
 * PACKED is faster wherever memory limits the speed, and its error is far below
 * that of sampling (doc/measurements.md, "Storage"). */
typedef enum hbil_storage {
  /* Per pixel 3 words of 32 bits for the G-buffer, 3 for its light, 2 each for
   * HISTORY and CARRIED (hbil_stages.h); radiance up to 1e30.  Channels share
   * an exponent, so one below 1/500 of the brightest is lost. */
  HBIL_STORAGE_PACKED = 0,
  HBIL_STORAGE_FLOAT32 = 1 /* in floats: 7; 7 or 8; 4 each */
} hbil_storage;

typedef struct hbil_sampling {
  cl_uint slices;         /* per pixel, 1..32; default 4 */
  cl_uint steps_per_side; /* samples per side of a slice, 1..256; default 40 */
  /* g: the last step is (1+g)^2 times the first one; 0..64; default 3 */
  float step_growth;
  hbil_sample_grid sample_grid; /* default FULL_RESOLUTION */
  hbil_resolution resolution;   /* default AUTO */
  cl_bool unfiltered;   /* CL_TRUE: recompose has no filter; default CL_FALSE */
  hbil_storage storage; /* default PACKED */
  /* Frames that share the slices of a pixel, 1..4, of which `slices` is a
   * multiple.  Each frame searches 1/slice_frames of them, and takes what the
   * others found from the frames before, where the same surface was: light has
   * nearly the error of all slices at the price of a part.  0 (default): 2, or
   * 1 if `slices` is odd, if `unfiltered`, or with HBIL_REPROJECTION_NONE.
   *
   * What moves in front of a surface, and light that changes, lag by up to
   * slice_frames - 1 frames.  Pixels side by side are searched in full if more
   * than a quarter of them have no past: not seen before, beyond
   * history.disocclusion_threshold, or a normal that has turned by more than 33
   * degrees.  HBIL_REPROJECTION_MOTION follows surfaces by motion vectors, all
   * else by the cameras.  Static frames search all slices, and so does the
   * frame behind them.  Without effect with the output glossy. */
  cl_uint slice_frames;
} hbil_sampling;

/* Presets; doc/measurements.md, "Slices that frames share", has figures. */
typedef enum hbil_quality {
  HBIL_QUALITY_FAST = 0,     /* 2 slices, 20 steps per side */
  HBIL_QUALITY_BALANCED = 1, /* 2 slices, 56 steps per side */
  HBIL_QUALITY_HIGH = 2,     /* 6 slices, 56 steps per side */
  /* 32 slices, 256 equal steps per side, unfiltered, float32: the densest */
  HBIL_QUALITY_REFERENCE = 3
} hbil_quality;

/* Sets all of hbil_sampling.  Returns HBIL_INVALID_ARGUMENT if sampling is null
 * or quality is not in the list. */
HBIL_API hbil_status hbil_sampling_set(hbil_sampling *sampling,
                                       hbil_quality quality);

/* Returns "fast", "balanced", "high" or "reference", else NULL. */
HBIL_API const char *hbil_quality_name(hbil_quality quality);

/* ------------------------------------------------------------------------ */
/* History: what passes from frame to frame                                 */

/* How light is carried over from the last frame. */
typedef enum hbil_reprojection {
  /* not at all: a single bounce; frames don't depend on earlier ones */
  HBIL_REPROJECTION_NONE = 0,
  HBIL_REPROJECTION_CAMERA = 1, /* by the cameras */
  HBIL_REPROJECTION_MOTION = 2  /* by motion vectors */
} hbil_reprojection;

typedef struct hbil_history {
  hbil_reprojection reprojection; /* default CAMERA */
  /* Light is carried over if the old pixel's depth is off by at most this share
   * from what is expected there (orthographic: of the picture's width).  > 0;
   * infinity: no limit; default 0.05 */
  float disocclusion_threshold;
} hbil_history;

/* ------------------------------------------------------------------------ */
/* Execution: how it runs                                                    */

/* Work that the library leaves out because it cannot change the outputs;
 * hbil_execution.skip is a sum of these.  The device decides in every frame
 * what to leave out, and the host reads nothing back.  The outputs have the
 * same bits with and without (test_skip).  One exception: HBIL_SKIP_STATIC,
 * after HBIL_EXACT_STATIC_FRAMES static frames in a row. */
typedef enum hbil_skip {
  HBIL_SKIP_SKY = 1,  /* gather: spans of pixels that are all sky */
  HBIL_SKIP_OPEN = 2, /* gather: spans where nothing rises above the surface */
  /* gather: the light of samples that send none; nothing with
   * HBIL_FALLBACK_FRAME_MEAN and facing_fade[1] above -1, where such samples
   * stand for unknown light */
  HBIL_SKIP_DARK = 4,
  /* gather: surfaces that reflect no diffuse light (albedo 0 or F0 1), if
   * beauty is the only output and no irradiance is carried over.  The data of
   * HBIL_STAGE_GATHERED and HBIL_STAGE_RESOLVED do differ. */
  HBIL_SKIP_UNUSED = 8,
  HBIL_SKIP_RADIUS = 16, /* gather: samples certainly beyond the radius */
  HBIL_SKIP_HOLES = 32,  /* push_pull: frames without holes */
  /* all passes: what a static frame does not change; after
   * HBIL_EXACT_STATIC_FRAMES of them also light that is lower by a rounding */
  HBIL_SKIP_STATIC = 64,
  HBIL_SKIP_ALL = 127
} hbil_skip;

typedef struct hbil_execution {
  cl_uint skip; /* a sum of hbil_skip; default HBIL_SKIP_ALL */
  /* Pixels in a vector, 1, 4, 8 or 16; 0 (default): chosen for the device. */
  cl_uint vector_width;
  /* CL_TRUE: hbil_plan_timings() works, and queues must have
   * CL_QUEUE_PROFILING_ENABLE.  Default CL_FALSE */
  cl_bool profiling;
} hbil_execution;

/* ------------------------------------------------------------------------ */
/* Configuration: all groups                                                 */

typedef struct hbil_config {
  /* Set by hbil_config_init().  Later versions may add groups at the end, and
   * programs that were compiled without them get their defaults.  A struct
   * larger than the library's is rejected. */
  size_t struct_size;
  cl_uint width, height; /* pixels, 1..HBIL_MAX_SIZE */
  hbil_inputs inputs;
  hbil_outputs outputs;
  hbil_model model;
  hbil_sampling sampling;
  hbil_history history;
  hbil_execution execution;
} hbil_config;

/* Sets the defaults in a struct of struct_size bytes.  width, height and the
 * formats are 0 and must be set by the caller.  Use the macro. */
HBIL_API void hbil_config_init_sized(hbil_config *config, size_t struct_size);
#define hbil_config_init(config)                                               \
  hbil_config_init_sized((config), sizeof(hbil_config))

/* Returns the resolution that a plan of this configuration has.  If
 * sampling.resolution is AUTO, width, height and unfiltered decide between FULL
 * and HALF.  Returns AUTO if config is null.  Doesn't check config. */
HBIL_API hbil_resolution hbil_config_resolution(const hbil_config *config);

/* Returns how many frames share slices in a plan of this configuration
 * (sampling.slice_frames); 0 if config is null.  Doesn't check config. */
HBIL_API cl_uint hbil_config_slice_frames(const hbil_config *config);

#ifdef __cplusplus
}
#endif

#endif
