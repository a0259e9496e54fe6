/*
 * hbil: a radiance cache in world space.  Programs include hbil/hbil.h.
 */
#ifndef HBIL_HBIL_CACHE_H
#define HBIL_HBIL_CACHE_H

#include <hbil/hbil_base.h>
#include <hbil/hbil_config.h>
#include <hbil/hbil_frame.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------ */
/* Cache: what views have shown of a place                                   */

/*
 * A cache holds what views of a place have shown: for each voxel whether there
 * is a surface, whether a view looked through it, or whether nothing has seen
 * it; and of surfaces the normal, the diffuse reflectance and the light that
 * they send.  A view is a picture with depth, normals and light: a frame, an
 * earlier frame of a sequence, or a picture that was made for this purpose.
 *
 * HOW A PROGRAM USES IT
 *   1. hbil_cache_config_init(); set voxel_size and centre.
 *   2. hbil_config_use_cache() with the configuration of the plan, which makes
 *      both fit each other; then hbil_cache_create() and hbil_plan_create().
 *   3. For every frame: hbil_view_from_frame() and hbil_enqueue_cache_inject(),
 *      or any other views; hbil_enqueue_cache_update(), which lets light bounce
 *      between the cache's surfaces, four times by default; and
 *      hbil_enqueue_frame() with hbil_frame.cache set.
 *   4. When the camera moves: hbil_enqueue_cache_move().
 *
 * WHAT IT DOES TO A FRAME
 *   Directions that the frame leaves open get the light that the cache has
 *   there, as far as its views have seen it: light of surfaces, and of the far
 *   field where a ray leaves the cache, has met nothing unseen, and a view saw
 *   the sky behind the last voxel.  What the frame shows itself within
 *   model.radius is left out, because E_near has it.  What no view has seen
 *   gets what it gets without a cache.  So an empty cache changes nothing, bit
 *   for bit (test_cache).  With rays and HBIL_FAR_FRAME, that is mixed with the
 *   light of surfaces around it, where it is a hole in what views have seen
 *   (doc/method.md, section 13).  Volumes and reflective shadow maps don't tell
 *   what has not been seen, and their light is all that open directions get.
 *   What the cache's light adds to a frame is a mean over four frames, which
 *   follows the surfaces by the cameras and begins anew where it has changed by
 *   a quarter.  Nothing is averaged with HBIL_REPROJECTION_NONE.
 *   Where the last update has found that a region has less light, or light was
 *   forgotten, what the last frame hands on falls by the same factor there, and
 *   so does the light of slices that frames share (sampling.slice_frames).
 *
 * ORDER
 *   Commands of a cache run in the order of the calls, like those of a plan,
 *   and frames that use the cache are among them, whatever queues they are in.
 *   Any number of plans of its context may use a cache.
 *
 * Results have the same bits in every run (test_cache).  A surface that has
 * moved away stays until a view looks through its place, or until
 * hbil_enqueue_cache_forget() or hbil_enqueue_cache_reset().  A voxel is the
 * mean of the views that saw it, in which a new one counts 1/16 or more.  Light
 * that is less than half or more than twice of what it was replaces that mean
 * at once.  All views that are injected between two updates are taken to show
 * one moment.  Where they agree that there is less light than before, by a
 * tenth or more, what they don't see is dimmed by as much, region by region (a
 * quarter of the coarsest level's width); it is never brightened.  Light that
 * has gone altogether counts where it was more than half of what is seen: next
 * to a patch of sun, views of the same voxel may see its lit part or its dark
 * part.
 */
typedef struct hbil_cache hbil_cache;

/* A good radius of the near field beside a cache, in voxels of the first level:
 * what is farther away, the cache knows better (doc/measurements.md). */
#define HBIL_CACHE_NEAR_VOXELS 4.0

typedef struct hbil_cache_config {
  size_t struct_size; /* set by hbil_cache_config_init(); see hbil_config */
  /* Voxels across a level, each way: 16, 32, 64 (default), 128 or 256. */
  cl_uint voxels;
  /* Levels, each with as many voxels as the one before, twice as wide; 1..4;
   * default 2 */
  cl_uint levels;
  /* Width of a voxel of the first level, in world units, 1e-6..1e6.  No
   * default.  The cache is voxels x voxel_size x 2^(levels - 1) wide, and
   * should hold what can send light to the picture, for instance twice the
   * depth of its surfaces. */
  double voxel_size;
  /* The cache's middle in the world; default 0, 0, 0.  It is rounded to a
   * multiple of the coarsest voxel. */
  double centre[3];
  /* The views' planes: formats and meaning, as in hbil_config.  depth and
   * normal are needed; HBIL_IMAGE is not possible, and motion is ignored. */
  hbil_inputs inputs;
  /* CL_TRUE (default): emission of views with direct light is sent, too; as
   * hbil_model.gather_emission. */
  cl_bool gather_emission;
  /* In bounces between surfaces, what no view has seen sends this many times
   * the radiance that a surface's other rays meet on average; 0..1; default 0.8
   * (doc/method.md, section 13; doc/measurements.md). */
  float unseen_light;
  /* How plans find its light; default HBIL_CACHE_METHOD_RAYS.  The others need
   * memory and time of their own in every update. */
  hbil_cache_method method;
} hbil_cache_config;

/* Sets the defaults.  Use the macro. */
HBIL_API void hbil_cache_config_init_sized(hbil_cache_config *config,
                                           size_t struct_size);
#define hbil_cache_config_init(config)                                         \
  hbil_cache_config_init_sized((config), sizeof(hbil_cache_config))

/* Makes the configurations of a plan and of a cache fit each other, before
 * either is created and after their own members are set.  The cache gets the
 * plan's inputs and gather_emission, for views that are like the plan's frames.
 * The plan gets the cache's method, and what is best beside a cache: a radius
 * of HBIL_CACHE_NEAR_VOXELS voxels, and a near_relative_thickness of 0.02 if
 * relative_thickness is the default, 0.06.  All of it can be changed
 * afterwards.  Where several plans use a cache, name last the one whose frames
 * become its views: the cache's inputs are those of the last call.
 * With a cache_method and a finite radius, near light has three fifths of
 * sampling.steps_per_side, unless outputs of occlusion share its search (same
 * radius and thickness).
 * HBIL_INVALID_ARGUMENT, which changes neither, if one of them is null, or if
 * voxel_size, which the radius depends on, isn't above 0. */
HBIL_API hbil_status hbil_config_use_cache(hbil_config *config,
                                           hbil_cache_config *cache);

/* Computes how much device memory hbil_cache_create() would allocate, in bytes.
 * Rejects what that rejects before it builds anything. */
HBIL_API hbil_status hbil_cache_memory(hbil_context *context,
                                       const hbil_cache_config *config,
                                       size_t *bytes);

/* Builds the kernels, allocates the buffers, forgets everything, and waits for
 * all this.  Nothing is compiled later.  config is copied.  On failure *out is
 * NULL and everything is released.  A wrong member of config is
 * HBIL_INVALID_CONFIG. */
HBIL_API hbil_status hbil_cache_create(hbil_context *context,
                                       const hbil_cache_config *config,
                                       hbil_cache **out);

/* Releases a cache, before or after its context.  Commands already enqueued
 * complete.  NULL is allowed. */
HBIL_API void hbil_cache_destroy(hbil_cache *cache);

/* What the plane `direct` of a view holds. */
typedef enum hbil_view_light {
  /* Direct light, as inputs.direct_kind says.  The cache adds the bounces
   * itself (hbil_enqueue_cache_update()). */
  HBIL_VIEW_DIRECT = 0,
  /* The radiance that surfaces send after all bounces, emission included.  It
   * is used as it is, without inputs.direct_scale, and replaces direct light of
   * other views. */
  HBIL_VIEW_FINISHED = 1
} hbil_view_light;

typedef struct hbil_view {
  size_t struct_size;         /* set by hbil_view_init(); see hbil_config */
  cl_uint width, height;      /* pixels, 1..HBIL_MAX_SIZE */
  hbil_projection projection; /* of this view; inputs.projection isn't read */
  hbil_camera camera;
  /* Exactly those that have a format in hbil_cache_config.inputs; checked like
   * those of a frame (hbil_plane). */
  hbil_plane depth, normal, albedo, f0, direct, emission;
  hbil_view_light light;
  double hardware_depth[2]; /* as in hbil_frame */
  /* Of this view's light, as in hbil_frame; 0 (default) stands for 1 */
  float exposure;
  /* CL_TRUE: the same as the view that was injected last, pixels too (CL_FALSE
   * by default; a frame's static_frame, if every frame is injected).  After
   * HBIL_STATIC_VIEWS of them in a row, each injected alone, means have
   * settled, and no more are injected.  Without injections, updates trace no
   * rays, and leave out bounces once these change nothing.  A view whose camera
   * or exposure differs from the one before isn't static, whatever this says;
   * moves, resets, hbil_cache_load() and hbil_enqueue_cache_forget() begin
   * anew. */
  cl_bool static_view;
} hbil_view;

/* After these, what was there before counts 1.6 %. */
#define HBIL_STATIC_VIEWS 64

/* Sets struct_size, and all other members to 0.  Use the macro. */
HBIL_API void hbil_view_init_sized(hbil_view *view, size_t struct_size);
#define hbil_view_init(view) hbil_view_init_sized((view), sizeof(hbil_view))

/* Makes a view of what a frame shows: its camera, its inputs with their
 * exposure, and the size and projection of its plan's configuration.  `light`
 * is HBIL_VIEW_DIRECT.  Use the macro.
 * HBIL_INVALID_ARGUMENT if one of them is null. */
HBIL_API hbil_status hbil_view_from_frame_sized(hbil_view *view,
                                                size_t struct_size,
                                                const hbil_config *config,
                                                const hbil_frame *frame);
#define hbil_view_from_frame(view, config, frame)                              \
  hbil_view_from_frame_sized((view), sizeof(hbil_view), (config), (frame))

/* Enqueues the injection of `count` views.  Their order doesn't matter, bit for
 * bit, unless two of them have the same camera, size and kind of light.  Of
 * views with more than 2^17 pixels every n-th pixel of every n-th row is read.
 * Views that show nothing of the cache's extent change nothing.  queue,
 * wait_count, wait_list and event are as in hbil_enqueue_frame(), and the
 * planes must stay as they are until the event completes.  A wrong view is
 * HBIL_INVALID_FRAME, whose message says which one of several; then nothing is
 * enqueued. */
HBIL_API hbil_status hbil_enqueue_cache_inject(
    hbil_cache *cache, cl_command_queue queue, const hbil_view *views,
    cl_uint count, cl_uint wait_count, const cl_event *wait_list,
    cl_event *event);

/* Reflective shadow maps of a cache at most. */
#define HBIL_MAX_LIGHT_VIEWS 4

/* With HBIL_CACHE_METHOD_RSM: enqueues that these views become the cache's
 * reflective shadow maps, in place of all earlier ones: pictures from where
 * lights are (perspective from a spot, orthographic along the sun's rays),
 * whose surfaces light the frames.  `direct` must be that light's alone, or
 * surfaces count twice that several views show.  Of views with more than 2^16
 * pixels every n-th pixel of every n-th row is read.  All else is as in
 * hbil_enqueue_cache_inject(), which takes the same views. */
HBIL_API hbil_status hbil_enqueue_cache_light_views(
    hbil_cache *cache, cl_command_queue queue, const hbil_view *views,
    cl_uint count, cl_uint wait_count, const cl_event *wait_list,
    cl_event *event);

typedef struct hbil_cache_update {
  size_t struct_size; /* set by hbil_cache_update_init(); see hbil_config */
  /* Bounces of light to compute, 0..1024; default 4, a good number for each
   * frame.  Some 16 should follow a first injection.  Further ones cost little,
   * since an update traces rays once for all of them.  It traces those of new
   * surfaces and of a quarter of the old ones, in turn, and those that have hit
   * what is gone; so four updates pass until all see what has moved into their
   * way.  After moves, loads and resets, all are traced. */
  cl_uint bounces;
  /* An update handles every n-th voxel, in all its bounces, and the next update
   * handles others, so n updates handle all: 1..4096; default 1 */
  cl_uint phases;
  /* The frames' far field: hbil_model.far_field, and environment of hbil_frame.
   * Rays that leave the cache into the sky get it; with HBIL_FAR_FRAME they get
   * none, because `direct` contains the sky.  HBIL_FAR_AUTO (default) is the
   * latter.
   */
  hbil_far_field far_field;
  float environment[9][3];
  /* With HBIL_CACHE_METHOD_LPV: steps of light from cell to cell, 0..1024;
   * default
   * 16.  Light needs as many steps as its way is long in cells, which are two
   * voxels wide; after changes a few a frame follow them.  Moves, resets and
   * hbil_cache_load() empty the cells. */
  cl_uint steps;
  /* Of `environment`, as in hbil_frame; 0 (default) stands for 1 */
  float exposure;
} hbil_cache_update;

/* Sets the defaults.  Use the macro. */
HBIL_API void hbil_cache_update_init_sized(hbil_cache_update *update,
                                           size_t struct_size);
#define hbil_cache_update_init(update)                                         \
  hbil_cache_update_init_sized((update), sizeof(hbil_cache_update))

/* Enqueues bounces of light between the cache's surfaces.  An update must come
 * between an injection and the frames that shall see it; 0 bounces suffice.
 * NULL stands for the defaults.  A wrong member is HBIL_INVALID_ARGUMENT. */
HBIL_API hbil_status hbil_enqueue_cache_update(
    hbil_cache *cache, cl_command_queue queue, const hbil_cache_update *update,
    cl_uint wait_count, const cl_event *wait_list, cl_event *event);

/* Enqueues a move of the cache's middle, which is rounded to a multiple of the
 * coarsest voxel.  What stays inside stays known, and nothing is copied. */
HBIL_API hbil_status hbil_enqueue_cache_move(
    hbil_cache *cache, cl_command_queue queue, const double centre[3],
    cl_uint wait_count, const cl_event *wait_list, cl_event *event);

/* A change of the world: where it is, and what share of what the cache knows
 * there means nothing any more. */
typedef struct hbil_cache_change {
  size_t struct_size; /* set by hbil_cache_change_init(); see hbil_config */
  /* A box in world space, with all voxels that it overlaps.  By default it is
   * everywhere: from -infinity to infinity. */
  double low[3], high[3];
  /* Share of what is known of surfaces, 0..1.  1: all of the box is unseen.
   * Less: earlier views lose that share of their weight, so the next one counts
   * for more. */
  float surfaces;
  /* Share of the light that they send, 0..1.  They send so much less until a
   * view shows them, and earlier views lose weight likewise.  The bounces of
   * the next update light them anew.  What the last frame hands on falls
   * likewise in those regions (4 x 4 x 4 of the coarsest level) whose middle is
   * in the box. */
  float light;
} hbil_cache_change;

/* Sets the defaults: everywhere, and shares of 0.  Use the macro. */
HBIL_API void hbil_cache_change_init_sized(hbil_cache_change *change,
                                           size_t struct_size);
#define hbil_cache_change_init(change)                                         \
  hbil_cache_change_init_sized((change), sizeof(hbil_cache_change))

/* Enqueues that a cache forgets what the caller knows to have changed, before
 * views show it: a lamp that was switched off (`light`), a wall that was blown
 * up (`surfaces`).  What views show is followed without this; what they don't
 * show is only guessed.  Frames see it after the next update.  queue,
 * wait_count, wait_list and event are as in hbil_enqueue_frame().  A box whose
 * high isn't above its low, and a share outside 0..1, are
 * HBIL_INVALID_ARGUMENT. */
HBIL_API hbil_status hbil_enqueue_cache_forget(
    hbil_cache *cache, cl_command_queue queue, const hbil_cache_change *change,
    cl_uint wait_count, const cl_event *wait_list, cl_event *event);

/* Enqueues a reset: everything becomes unseen. */
HBIL_API hbil_status hbil_enqueue_cache_reset(hbil_cache *cache,
                                              cl_command_queue queue,
                                              cl_uint wait_count,
                                              const cl_event *wait_list,
                                              cl_event *event);

/* Numbers of voxels, of all levels; `empty` has those with sky behind them,
 * too. */
typedef struct hbil_cache_counts {
  size_t unseen, empty, surfaces;
} hbil_cache_counts;

/* Counts them.  The call waits for the cache's commands. */
HBIL_API hbil_status hbil_cache_statistics(hbil_cache *cache,
                                           cl_command_queue queue,
                                           hbil_cache_counts *out);

/* Copies all that a cache knows to `size` bytes of memory, or back from there.
 * hbil_cache_size() is that size.  The bytes begin with the library's version,
 * voxels, levels, voxel_size and the middle.  A cache takes only what a cache
 * of the same library version, voxels, levels and voxel_size has given; its
 * middle becomes the one of the bytes.  Anything else, and bytes that were
 * damaged, are HBIL_INVALID_ARGUMENT and change nothing.  Both wait for the
 * cache's commands.  Frames see what was loaded.  Where rays end isn't saved:
 * the next update traces all of them. */
HBIL_API size_t hbil_cache_size(const hbil_cache *cache);
HBIL_API hbil_status hbil_cache_save(hbil_cache *cache, cl_command_queue queue,
                                     void *bytes, size_t size);
HBIL_API hbil_status hbil_cache_load(hbil_cache *cache, cl_command_queue queue,
                                     const void *bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
