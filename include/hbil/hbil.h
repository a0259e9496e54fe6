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
 * below).  doc/method.md derives it, with corrections; what these headers call
 * doc/ and examples/ is installed in the folder of hbil's documents.
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
 *   In view space x points towards the next column of pixels, y towards the
 *   next row, and z forward.  If the first row is the top one, x is right
 *   and y down, and the space is right-handed.  Pixel (i,j) has its centre at
 *   (i+0.5, j+0.5) from the first pixel's corner and looks along
 *   r = ((i+0.5-cx)/fx, (j+0.5-cy)/fy, 1).  Matrices are row-major 4x4 matrices
 *   for column vectors.  Lengths are in world units of the caller's choice.
 *   Light is linear, in any RGB primaries; the channels are never mixed.
 *   Radiance L is in W/(m2 sr), irradiance E in W/m2.  A diffuse surface sends
 *   L = (1-F0) albedo/pi E, plus its emission.
 *
 * THREADS
 *   Only one thread at a time may use a context and its plans, and destroy
 *   them.  Different contexts are independent, even on the same cl_context.
 *
 * PROCESSES
 *   The library starts no threads. Its only state outside its objects is the
 *   text of hbil_context_message(NULL), which each thread has of its own.
 *   OpenCL drivers do start threads, and a child has none of these after fork()
 *   (test_lifetimes).
 *   A child that was forked after the first OpenCL call must not create, use or
 *   destroy contexts, plans or caches. It may call exec or _exit(), and the
 *   functions that use no OpenCL, such as hbil_config_init() and
 *   hbil_status_string().
 *   The parent goes on as if nothing had happened.  If a process
 *   forks before it calls OpenCL for the first time, parent and child may both
 *   create contexts of their own.
 *
 * BLOCKING
 *   The hbil_enqueue_* functions never wait for commands on the device and
 *   allocate no memory.  They may call clFlush().  hbil_plan_create() builds
 *   kernels, which takes long, and launches each once without any work, for
 *   drivers that compile at the first launch.  Frames compile nothing.
 *   hbil_plan_timings(), hbil_plan_statistics() and hbil_plan_sanitized() wait
 *   for the plan's commands.
 *
 * ORDER
 *   A plan's commands run in the order of the calls, on in-order and on
 *   out-of-order queues, and when calls alternate between queues.  You need not
 *   chain frames or passes by events.  What a plan can't know are your own
 *   commands: wait_list must have those that write the inputs or still use the
 *   outputs, unless the queue orders them, and your commands that read the
 *   outputs wait for the frame's event.  When that event is complete, so are
 *   all earlier commands of the plan.
 *
 * ERRORS
 *   Every function that can fail returns an hbil_status; HBIL_SUCCESS is 0.
 *   It tells where the mistake is: HBIL_INVALID_CONFIG in a member of a
 *   configuration, HBIL_INVALID_FRAME in a member of a frame or view or the
 *   memory that it names, HBIL_INVALID_ARGUMENT in any other argument, queues
 *   and scratch memory among them.
 *   hbil_context_message() describes the last failure in one sentence, and
 *   hbil_context_set_callback() has every failure and warning reported.  The
 *   library never prints, exits or aborts.  It checks arguments before it
 *   enqueues anything.  If a frame fails later, the plan's history is the same
 *   as before, and you may enqueue the same frame again or another one.  What
 *   was enqueued already still runs, and later calls wait for it.  If commands
 *   fail on the device, or an event of wait_list does, the status can't tell,
 *   and the frame's event has an error.  What the cl_context and its queues do
 *   afterwards is up to the OpenCL implementation.
 */
#ifndef HBIL_HBIL_H
#define HBIL_HBIL_H

#include <hbil/hbil_base.h>
#include <hbil/hbil_formats.h>
#include <hbil/hbil_config.h>
#include <hbil/hbil_cache.h>
#include <hbil/hbil_frame.h>
#include <hbil/hbil_suggest.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------ */
/* Context: the library on one device                                        */

/* Creates a context, which binds the library to a cl_context and one of its
 * devices.  The context retains both.  The device needs OpenCL 1.2 and a
 * compiler, and images only if a plane is an HBIL_IMAGE.  Sub-groups and 64-bit
 * atomics are not used.  On failure
 * *out is NULL, and hbil_context_message(NULL) says why.  If the environment
 * variable HBIL_KERNEL_DIR names a folder, plans read the kernels from there;
 * this is meant for work on the kernels.  Programs that run with other rights
 * than their user's (setuid) ignore it. */
HBIL_API hbil_status hbil_context_create(cl_context context,
                                         cl_device_id device,
                                         hbil_context **out);

/* Destroys a context.  Its plans stay usable and may be destroyed later; the
 * last of them releases what they share.  No function may be called with the
 * context itself any more, so messages of its plans reach the callback alone.
 * NULL is allowed. */
HBIL_API void hbil_context_destroy(hbil_context *context);

/* Returns one sentence on the last failure in this context or in one of its
 * plans.  It has the name of the OpenCL error, the kernel's name if there is
 * one, and the build log if a kernel did not compile.  The string is empty if
 * nothing has failed.  It is valid until the next call on the context or one of
 * its plans.  Ask for it in a statement of its own, behind the call that
 * failed: among the arguments of one call, C may evaluate it first.
 *
 * If context is NULL, the sentence is on the calling thread's last failure that
 * had no context: hbil_context_create(), functions whose context or plan was
 * null, and functions that take neither.  It is valid until the next such
 * failure on this thread. */
HBIL_API const char *hbil_context_message(const hbil_context *context);

typedef enum hbil_message_kind {
  HBIL_MESSAGE_ERROR = 0,  /* a function is about to return another status than
                            * HBIL_SUCCESS */
  HBIL_MESSAGE_WARNING = 1 /* it goes on, but you may want to know */
} hbil_message_kind;

/* Receives a message, which is valid during the call only. */
typedef void (*hbil_message_callback)(hbil_message_kind kind,
                                      const char *message, void *user);

/* Has every message of the context and its plans reported, NULL: none.  Errors
 * are what hbil_context_message() returns.  Warnings are a compiler's remarks
 * on a kernel that did compile, kernels that are read from HBIL_KERNEL_DIR,
 * programs that could not be loaded or stored, and timings that were lost.  The
 * callback is called by the functions that the message is about, on the thread
 * that called them, before they return; OpenCL's own threads never call it.  It
 * must return, and must not call functions of this library other than
 * hbil_context_message().  It stays in effect, and user must stay valid, until
 * the context and all its plans are destroyed. */
HBIL_API hbil_status hbil_context_set_callback(hbil_context *context,
                                               hbil_message_callback callback,
                                               void *user);

/* ------------------------------------------------------------------------ */
/* Programs: what is built once and stored                                   */

/* Creating a plan builds up to sixteen OpenCL programs, and creating a radiance
 * cache up to eleven, which takes seconds.  A context holds the last 64 of them
 * that were built, and later plans and caches that need the same ones build
 * none.  For programs, sizes are of four kinds: the width is a multiple of 4
 * execution.vector_width (64 is, on any device) or isn't, and pixels are fewer
 * than HBIL_HALF_RESOLUTION_PIXELS or aren't (test_binaries).
 *
 * A store is for other processes.  It has the driver's binaries
 * of programs that were built before, by a key: a file name of at most 47
 * letters, digits, "-" and "_".  The key depends on the device, its driver,
 * this library's version, the kernels' text and all settings that kernels are
 * built with.  What the store has is used only if it is whole and was made by
 * this library for the same program and device; whatever else it may have, the
 * program is built from its text and stored again, with a warning to the
 * callback.  It must come from where nobody else may write, because binaries
 * are executed. */

/* Copies what is stored under a key to `data`, `size` bytes, and returns how
 * many bytes are stored, 0 for none.  If `size` is 0, `data` is NULL. */
typedef size_t (*hbil_program_load)(void *user, const char *key, void *data,
                                    size_t size);

/* Stores `size` bytes under a key, in place of those that are there.  If that
 * fails, the program will be built again in the next run. */
typedef void (*hbil_program_store)(void *user, const char *key,
                                   const void *data, size_t size);

/* Gives a context a store; if both functions are NULL, it has none, as at
 * first.  hbil_plan_create() and hbil_cache_create() call them, on their
 * thread; they must not call functions of this library.  They and user must
 * stay valid until the context is destroyed or has another store.  Binaries are
 * stored after the kernels have been launched.  With PoCL they have the kernels
 * for the plan's work-groups, so that nothing is compiled in the next run
 * (test_binaries), and PoCL compiles each kernel once more for a binary's sake,
 * when it is stored. */
HBIL_API hbil_status hbil_context_set_program_store(hbil_context *context,
                                                    hbil_program_load load,
                                                    hbil_program_store store,
                                                    void *user);

/* The same with a folder as the store: a file KEY.bin for each program.  Files
 * appear whole or not at all, so any number of processes may share the folder.
 * They are never removed.  It is used when plans and radiance caches are
 * created.  While it doesn't exist, programs are built as without it, and one
 * warning says that they can't be stored. */
HBIL_API hbil_status hbil_context_set_program_folder(hbil_context *context,
                                                     const char *folder);

/* ------------------------------------------------------------------------ */
/* Plan: kernels, buffers and history of one configuration                   */

typedef struct hbil_plan hbil_plan;

/* Device memory of a plan, in bytes: exact sums of its buffers. */
typedef struct hbil_memory {
  size_t persistent; /* what frames leave to later ones: history, tables */
  size_t scratch;    /* what the passes of a frame leave to each other */
} hbil_memory;

/* Computes how much device memory hbil_plan_create() would allocate.  Rejects
 * what hbil_plan_create() rejects before it builds anything: with
 * HBIL_INVALID_CONFIG what it has no settings for, with
 * HBIL_OUT_OF_DEVICE_MEMORY what needs a larger buffer than the device has. */
HBIL_API hbil_status hbil_plan_memory(hbil_context *context,
                                      const hbil_config *config,
                                      hbil_memory *out);

/* Builds the kernels, allocates the buffers, launches each kernel once without
 * any work, in a queue of its own, and waits for all this.  It can take many
 * seconds; nothing is compiled later.  config is copied.  On failure *out is
 * NULL and everything is released. */
HBIL_API hbil_status hbil_plan_create(hbil_context *context,
                                      const hbil_config *config,
                                      hbil_plan **out);

/* The same, with `scratch` as the plan's scratch memory.  Between two frames of
 * the plan it is free: other passes, and other plans, may use it.
 *
 * It is a buffer or a sub-buffer of the context's cl_context that kernels may
 * read and write, and has at least hbil_memory.scratch bytes.  The plan retains
 * it.  Neither creating nor destroying a plan changes what is in it.  A frame
 * uses it from wait_list to the frame's event; whoever else uses it waits for
 * that event, or is in the same in-order queue.  A frame's planes must not lie
 * in it.
 *
 * If anyone has written there since the last frame, hbil_frame.static_frame
 * must be CL_FALSE, and the stages SPLIT, GATHERED, CARRIED and RESOLVED no
 * longer hold that frame (hbil_plan_buffer()).  The history is in the plan's
 * own memory.  Such a plan's frames clear the padding of their layers first,
 * which other plans do once, when they are created. */
HBIL_API hbil_status hbil_plan_create_in(hbil_context *context,
                                         const hbil_config *config,
                                         cl_mem scratch, hbil_plan **out);

/* Releases a plan, before or after its context.  Commands already enqueued
 * complete.  NULL is allowed. */
HBIL_API void hbil_plan_destroy(hbil_plan *plan);

/* Discards the history, so that the next frame is a first frame.  Frames that
 * are under way are not affected. */
HBIL_API void hbil_plan_reset(hbil_plan *plan);

/*
 * Lets the next frame of `plan` continue after the last frame of another plan:
 * it reprojects that plan's light as if it were its own.  With it, resolution
 * may change from frame to frame: make a plan for each size beforehand, which
 * share their programs, and may share scratch memory if they run in turn
 * (hbil_plan_create_in()).  Where sizes change, the plan of the new size
 * follows that of the old one.  The call allocates, enqueues and waits for
 * nothing.
 *
 * The plans may differ in size, sampling and outputs.  If they differ in
 * nothing, the frame has the bits that `last` itself would have given.  Each
 * pixel takes the light of that pixel of the last frame in which its surface
 * was; motion vectors are in pixels of the new frame.  What several frames make
 * together (sampling.slice_frames, the light of a radiance cache) begins anew,
 * and the next frame's static_frame is ignored, as in a plan's first frame.  A
 * call in which `last` is `plan` changes nothing.
 *
 * `last` may be destroyed at once; its memory is released when that frame is
 * enqueued.  Otherwise it must run no frame before.  A frame that is a
 * rectangle of larger planes has these planes' offset and row_pitch
 * (hbil_plane).  If `last` has had no frame since it followed another plan,
 * that one is followed; if it has had none at all, the next frame is a first
 * one.  HBIL_INVALID_ARGUMENT if one of both is null, or their light isn't of
 * one kind (another context, projection, storage or feedback, or one of them
 * carries no light over); `plan` is then as before.
 */
HBIL_API hbil_status hbil_plan_follow(hbil_plan *plan, hbil_plan *last);

/* ------------------------------------------------------------------------ */
/* Enqueue: a frame                                                          */

/* Enqueues all passes of a frame, in this order:
 *   reproject   history -> carried light of this frame, with holes
 *   push_pull   fills the holes from coarser levels
 *   split       G-buffer -> 4x4 interleaved layers
 *   gather      horizon search: layers -> AO, E_near and bent normal, in layers
 *   recompose   layers -> full resolution, filtered
 *   composite   far light; writes the outputs and the history
 * Images are copied before the first pass and after composite (HBIL_IMAGE), and
 * normals are rebuilt before the first pass if inputs.normal is HBIL_NONE.
 * Callers who replace passes by their own enqueue the others by
 * hbil_enqueue_passes() (hbil_stages.h).
 *
 * The queue must belong to the plan's context and device; it may be in-order or
 * out-of-order, and another one at each call.  The commands wait for those of
 * the plan's earlier calls, and for wait_list, which works as in
 * clEnqueueNDRangeKernel().  A call on another queue than the last one flushes
 * that queue; if that is an in-order queue, it waits for everything in it.  A
 * plan retains the queue that it used last.
 *
 * If event is not NULL, it receives an event that completes when the frame is
 * done; the caller releases it.  If the call fails, event is not written.
 * frame is read during the call only. */
HBIL_API hbil_status hbil_enqueue_frame(hbil_plan *plan, cl_command_queue queue,
                                        const hbil_frame *frame,
                                        cl_uint wait_count,
                                        const cl_event *wait_list,
                                        cl_event *event);

/* ------------------------------------------------------------------------ */
/* Figures: timings, statistics and sanitized pixels of the last frame       */

typedef enum hbil_pass {
  HBIL_PASS_REPROJECT = 0,
  HBIL_PASS_PUSH_PULL = 1,
  HBIL_PASS_SPLIT = 2,
  HBIL_PASS_GATHER = 3,
  HBIL_PASS_RECOMPOSE = 4,
  HBIL_PASS_COMPOSITE = 5,
  HBIL_PASS_IMPORT = 6, /* before the others; see HBIL_IMAGE, inputs.normal */
  HBIL_PASS_EXPORT = 7, /* after the others; see HBIL_IMAGE */
  HBIL_PASS_COUNT = 8
} hbil_pass;

/* Returns "reproject", "push_pull" and so on, NULL for any other number. */
HBIL_API const char *hbil_pass_name(hbil_pass pass);

/* Computes how many milliseconds the device spent in each pass of the last
 * frame, 0 for passes that did not run, and before a first frame.  Waits for
 * the frame's commands.  Returns HBIL_INVALID_CONFIG if execution.profiling is
 * off. */
HBIL_API hbil_status hbil_plan_timings(hbil_plan *plan,
                                       double milliseconds[HBIL_PASS_COUNT]);

/* A span is what a work-item of the gather handles: up to 32 pixels of a
 * layer's row, and one pixel if vector_width is 1. */
typedef struct hbil_count {
  size_t pixels, spans;
} hbil_count;

/* What the last frame left out.  Pixels and spans outside the picture are not
 * counted, nor are those that half resolution leaves out.  All counts
 * but `all` are 0 if the gather did not run. */
typedef struct hbil_statistics {
  hbil_count all;    /* the picture, as far as it is gathered */
  hbil_count sky;    /* pixels of sky; spans with nothing else */
  hbil_count open;   /* nothing can block these (HBIL_SKIP_OPEN) */
  hbil_count dark;   /* no light is in reach (HBIL_SKIP_DARK) */
  hbil_count unused; /* no output shows their light (HBIL_SKIP_UNUSED) */
  cl_bool not_run[HBIL_PASS_COUNT]; /* passes that had nothing to do */
} hbil_statistics;

/* Reads the statistics of the last frame, by way of any queue of the plan's
 * cl_context.  The call waits for the plan's commands, whatever queue they are
 * in, and for what an in-order queue does before.  Returns
 * HBIL_INVALID_ARGUMENT if there is no last frame or if it failed. */
HBIL_API hbil_status hbil_plan_statistics(hbil_plan *plan,
                                          cl_command_queue queue,
                                          hbil_statistics *out);

/* Numbers of pixels whose input was replaced, by the rules beside the formats
 * in hbil_inputs.  depth and emission count in all pixels, the others where
 * there is a surface.  What the plan does not read counts 0, like motion in
 * first and static frames.  A static frame has the last one's other counts. */
typedef struct hbil_sanitized {
  size_t depth, normal, albedo, f0, direct, emission, motion;
  /* Normals that face away from the eye by a cosine of 0.2 or more, which no
   * visible surface has.  They are turned until nearly edge on.  If they are
   * more than a few, normal_space, normal_scale or the camera is wrong.  A
   * count of 0 proves little: a camera that looks down faces the floor even if
   * rows are counted from the wrong end. */
  size_t facing_away;
} hbil_sanitized;

/* Reads these numbers.  Waits and fails like hbil_plan_statistics(). */
HBIL_API hbil_status hbil_plan_sanitized(hbil_plan *plan,
                                         cl_command_queue queue,
                                         hbil_sanitized *out);

#ifdef __cplusplus
}
#endif

#endif
