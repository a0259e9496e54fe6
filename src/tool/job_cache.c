/* The radiance cache of a job. */
#include "tool/job_cache.h"

#include "dump/read_gbuffer.h"
#include "exact/saved_cache.h"
#include "image/clock.h"
#include "tool/extent.h"
#include "tool/frame_source.h"
#include "tool/layers.h"
#include "tool/report.h"
#include "tool/refusal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Bounces after what is known before the first frame, and after each frame. */
enum { ROUNDS_AT_FIRST = 16, ROUNDS_OF_A_FRAME = 4 };
/* Steps of light propagation volumes likewise: once and a quarter across them.
 */
enum { STEPS_AT_FIRST = 64, STEPS_OF_A_FRAME = 8 };

/* Planes of a picture on the device. */
typedef struct planes {
  cl_mem input[INPUTS];
  size_t room[INPUTS]; /* bytes of each */
} planes;

struct job_cache {
  const device *device;
  hbil_context *context;
  const job *job;
  hbil_cache_config config;
  hbil_cache *cache;
  planes views, lights[HBIL_MAX_LIGHT_VIEWS];
  cl_event written; /* the last upload, if one is under way; NULL: none */
  size_t memory;
  double seconds; /* of learning */
};

static const unsigned roles = 1u << ROLE_DEPTH | 1u << ROLE_NORMAL |
                              1u << ROLE_ALBEDO | 1u << ROLE_DIRECT |
                              1u << ROLE_EMISSION | 1u << ROLE_INDIRECT;

/* path: the frame or view, or NULL. */
static int library_failed(const job_cache *jc, const char *path,
                          hbil_status status, image_error *error) {
  return refusal(jc->device, path, status, jc->context, error);
}

static int opencl_failed(const job_cache *jc, cl_int status, const char *doing,
                         image_error *error) {
  return refusal_of_opencl(jc->device, NULL, status, doing, error);
}

/* ------------------------------------------------------------------------ */
/* Injection                                                                 */

/* The channels of an input that the cache reads: those that frames or some view
 * have; 0: none. */
static size_t channels_of(const job_cache *jc, int input) {
  const job *j = jc->job;
  const role r = input_table[input].role;
  size_t channels = j->frames[0].map.count[r];
  if (r == ROLE_MOTION ||
      (r == ROLE_EMISSION && !j->config.model.gather_emission))
    return 0;
  for (int i = 0; i < j->view_count && !channels; i++)
    channels = j->views[i].map.count[r];
  return channels;
}

/* Waits until the host may change or free what was being uploaded. */
static int finish_upload(job_cache *jc, image_error *error) {
  if (!jc->written)
    return 0;
  const cl_int status = clWaitForEvents(1, &jc->written);
  clReleaseEvent(jc->written);
  jc->written = NULL;
  return status == CL_SUCCESS
             ? 0
             : opencl_failed(jc, status, "writing a buffer", error);
}

/* Begins to write a plane, which must stay until finish_upload().  The queue is
 * in order, so its last command ends last. */
static cl_int write_plane(job_cache *jc, cl_mem to, size_t offset, size_t bytes,
                          const float *from) {
  cl_event written;
  const cl_int status = clEnqueueWriteBuffer(
      jc->device->queue, to, CL_FALSE, offset, bytes, from, 0, NULL, &written);
  if (status != CL_SUCCESS)
    return status;
  if (jc->written)
    clReleaseEvent(jc->written);
  jc->written = written;
  return CL_SUCCESS;
}

/* Brings a plane's channels to the device.  Without albedo surfaces are white,
 * as those of frames are; other roles that the picture hasn't are zeros.  The
 * buffer grows where a picture is larger than those before. */
static int upload(job_cache *jc, const gbuffer *g, int input, planes *p,
                  image_error *error) {
  const size_t plane = gbuffer_pixels(g) * sizeof(float);
  const size_t channels = channels_of(jc, input);
  const role r = input_table[input].role;
  const float missing = r == ROLE_ALBEDO ? 1.0f : 0.0f;
  cl_int status = CL_SUCCESS;
  if (p->room[input] < channels * plane) {
    if (p->input[input])
      clReleaseMemObject(p->input[input]);
    p->room[input] = 0;
    p->input[input] = clCreateBuffer(jc->device->context, CL_MEM_READ_ONLY,
                                     channels * plane, NULL, &status);
    if (status != CL_SUCCESS)
      return opencl_failed(jc, status, "making a buffer", error);
    p->room[input] = channels * plane;
  }
  for (size_t c = 0; c < channels && status == CL_SUCCESS; c++) {
    const float *from = gbuffer_plane(g, r, c);
    const cl_mem to = p->input[input];
    status = from ? write_plane(jc, to, c * plane, plane, from)
                  : clEnqueueFillBuffer(jc->device->queue, to, &missing,
                                        sizeof missing, c * plane, plane, 0,
                                        NULL, NULL);
  }
  return status == CL_SUCCESS
             ? 0
             : opencl_failed(jc, status, "writing a buffer", error);
}

/* The picture must stay until finish_upload(), whether or not this fails.
 * given: buffers that hold planes of it already; NULL, or NULL for an input:
 * none does. */
static int view_of(job_cache *jc, const gbuffer *g, const device_plane *given,
                   hbil_view_light light, planes *p, hbil_view *view,
                   image_error *error) {
  hbil_plane *const planes_of[] = {&view->depth,    &view->normal,
                                   &view->albedo,   &view->direct,
                                   &view->emission, NULL};
  hbil_view_init(view);
  view->width = g->planes.width;
  view->height = g->planes.height;
  view->camera = g->map.camera;
  view->projection = g->map.projection;
  view->light = light;
  channel_map_hardware_depth(&g->map, view->hardware_depth);
  for (int i = 0; i < INPUTS; i++) {
    if (!channels_of(jc, i))
      continue;
    const int is_given = given && given[i].buffer;
    if (!is_given && upload(jc, g, i, p, error) != 0)
      return -1;
    if (planes_of[i])
      *planes_of[i] = is_given ? (hbil_plane){.buffer = given[i].buffer,
                                              .plane_pitch = given[i].pitch}
                               : (hbil_plane){.buffer = p->input[i]};
  }
  return 0;
}

static int inject(job_cache *jc, const char *path, const gbuffer *g,
                  const device_plane *given, hbil_view_light light,
                  image_error *error) {
  hbil_view view;
  if (view_of(jc, g, given, light, &jc->views, &view, error) != 0)
    return -1;
  const hbil_status status = hbil_enqueue_cache_inject(
      jc->cache, jc->device->queue, &view, 1, 0, NULL, NULL);
  return status == HBIL_SUCCESS ? 0 : library_failed(jc, path, status, error);
}

static int update(job_cache *jc, unsigned bounces, unsigned steps,
                  image_error *error) {
  hbil_cache_update how;
  hbil_cache_update_init(&how);
  how.bounces = bounces;
  how.steps = steps;
  how.far_field = jc->job->config.model.far_field;
  memcpy(how.environment, jc->job->far.environment, sizeof how.environment);
  const hbil_status status = hbil_enqueue_cache_update(
      jc->cache, jc->device->queue, &how, 0, NULL, NULL);
  return status == HBIL_SUCCESS ? 0 : library_failed(jc, NULL, status, error);
}

int job_cache_see_frame(job_cache *jc, const char *path, const gbuffer *g,
                        const device_plane *given, image_error *error) {
  if (jc->job->settings->cache_fixed)
    return 0;
  const int failed =
      inject(jc, path, g, given, HBIL_VIEW_DIRECT, error) != 0 ||
      update(jc, ROUNDS_OF_A_FRAME, STEPS_OF_A_FRAME, error) != 0;
  return finish_upload(jc, failed ? NULL : error) != 0 || failed ? -1 : 0;
}

/* ------------------------------------------------------------------------ */
/* Learning                                                                  */

/* Warns of a loaded cache that knows less than a tenth of what the first frame
 * shows.  One of the same place knows nine tenths; in another place, surfaces
 * and voxels meet by accident, the more often the wider voxels are. */
static int check_place(const job_cache *jc, const void *bytes, size_t size,
                       image_error *error) {
  const job_frame *first = &jc->job->frames[0];
  const extent_picture shows = {first->path, &first->map};
  exact_saved_cache cache;
  double(*at)[3];
  size_t count, known = 0;
  char text[256];
  if (jc->job->settings->quiet ||
      exact_saved_open(bytes, size, &cache) != EXACT_SUCCESS)
    return 0;
  if (extent_places(&shows, &at, &count, error) != 0)
    return -1;
  for (size_t i = 0; i < count; i++)
    known += exact_saved_has_surface(
        &cache, exact_cache_from_world(&cache.where,
                                       vec(at[i][0], at[i][1], at[i][2])));
  free(at);
  if (10 * known >= count)
    return 0;
  snprintf(text, sizeof text,
           "knows %.0f %% of the surfaces of the first frame, as if it were of "
           "another place; a cache of this place is needed, or none, for one "
           "that the frames make",
           100.0 * (double)known / (double)count);
  report_note(jc->job->settings->cache_load, "warning: ", text);
  return 0;
}

static int load(job_cache *jc, image_error *error) {
  const char *path = jc->job->settings->cache_load;
  const cache_file *file = &jc->job->loaded;
  if (file->size != hbil_cache_size(jc->cache))
    return image_fail(error, "%s: %llu bytes of a cache that has %zu", path,
                      (unsigned long long)file->size,
                      hbil_cache_size(jc->cache));
  void *bytes = malloc(file->size);
  if (!bytes)
    return image_no_memory(error, path);
  int failed = cache_file_read_bytes(path, file, bytes, error);
  if (!failed) {
    const hbil_status status =
        hbil_cache_load(jc->cache, jc->device->queue, bytes, file->size);
    failed = status == HBIL_SUCCESS ? check_place(jc, bytes, file->size, error)
                                    : library_failed(jc, path, status, error);
  }
  free(bytes);
  return failed;
}

/* Direct light becomes the finished radiance, albedo (direct + indirect).  The
 * library multiplies direct light by its scale over pi, radiance by nothing. */
static void finish_radiance(const gbuffer *g, float direct_scale) {
  const double to_radiance = (double)direct_scale / 3.14159265358979323846;
  for (size_t c = 0; c < 3; c++) {
    float *direct = gbuffer_plane(g, ROLE_DIRECT, c);
    const float *indirect = gbuffer_plane(g, ROLE_INDIRECT, c);
    const float *albedo = gbuffer_plane(g, ROLE_ALBEDO, c);
    for (size_t i = 0; i < gbuffer_pixels(g); i++)
      direct[i] =
          (float)((albedo ? (double)albedo[i] : 1.0) *
                  (to_radiance * (double)direct[i] + (double)indirect[i]));
  }
}

static int read_picture(const job_cache *jc, const job_frame *f, int is_view,
                        gbuffer *g, image_error *error) {
  if (frame_source_read_learnt(jc->job, f, is_view, roles, g, error) != 0)
    return -1;
  if (is_view && jc->job->settings->view_light == HBIL_VIEW_FINISHED)
    finish_radiance(g, jc->config.inputs.direct_scale);
  return 0;
}

/* Injects a picture that is learnt, and lets what it doesn't show follow it. */
static int learn_picture(job_cache *jc, const char *path, const gbuffer *g,
                         hbil_view_light light, image_error *error) {
  return inject(jc, path, g, NULL, light, error) != 0 ||
                 update(jc, 0, 0, error) != 0
             ? -1
             : 0;
}

/* Injects the views and, with --learn, all frames: the last one first, so that
 * in the end the cache is at the time of the first one.  While the device takes
 * a picture, the next one is read. */
static int learn_pictures(job_cache *jc, image_error *error) {
  const job *j = jc->job;
  const int count = j->view_count + (j->settings->learn ? j->count : 0);
  gbuffer taken = {0}, next;
  progress shown;
  int failed = 0;
  progress_start(&shown, "radiance cache", 0.0, j->settings->quiet);
  for (int i = 0; i < count && !failed; i++) {
    const int is_view = i < j->view_count;
    const job_frame *f = is_view ? &j->views[i] : &j->frames[count - 1 - i];
    const hbil_view_light light =
        is_view ? j->settings->view_light : HBIL_VIEW_DIRECT;
    failed = read_picture(jc, f, is_view, &next, error);
    if (failed)
      break;
    failed = finish_upload(jc, error);
    gbuffer_free(&taken);
    taken = next;
    if (!failed)
      failed = learn_picture(jc, f->path, &taken, light, error);
    if (!failed)
      progress_show(&shown, (double)(i + 1) / count);
  }
  if (finish_upload(jc, failed ? NULL : error) != 0)
    failed = -1;
  gbuffer_free(&taken);
  progress_clear();
  return failed;
}

/* The views of lights become the cache's reflective shadow maps. */
static int learn_lights(job_cache *jc, image_error *error) {
  const job *j = jc->job;
  hbil_view views[HBIL_MAX_LIGHT_VIEWS];
  for (int i = 0; i < j->light_count; i++) {
    gbuffer g;
    if (gbuffer_read(j->lights[i].path, &j->lights[i].map, roles, &g, error) !=
        0)
      return -1;
    int failed = view_of(jc, &g, NULL, HBIL_VIEW_DIRECT, &jc->lights[i],
                         &views[i], error);
    if (finish_upload(jc, failed ? NULL : error) != 0)
      failed = -1;
    gbuffer_free(&g);
    if (failed)
      return -1;
  }
  const hbil_status status =
      hbil_enqueue_cache_light_views(jc->cache, jc->device->queue, views,
                                     (cl_uint)j->light_count, 0, NULL, NULL);
  return status == HBIL_SUCCESS
             ? 0
             : library_failed(jc, j->lights[0].path, status, error);
}

int job_cache_learn(job_cache *jc, image_error *error) {
  const process_settings *s = jc->job->settings;
  const double start = seconds_now();
  /* The bounces of a loaded cache were computed before it was saved. */
  const unsigned bounces =
      s->cache_load && !s->view_count && !s->learn ? 0 : ROUNDS_AT_FIRST;
  if ((s->cache_load && load(jc, error) != 0) ||
      learn_pictures(jc, error) != 0 ||
      (jc->job->light_count && learn_lights(jc, error) != 0) ||
      update(jc, bounces, STEPS_AT_FIRST, error) != 0)
    return -1;
  const cl_int status = clFinish(jc->device->queue);
  jc->seconds = seconds_now() - start;
  return status == CL_SUCCESS ? 0
                              : opencl_failed(jc, status, "learning", error);
}

double job_cache_learning_seconds(const job_cache *jc) {
  return jc->seconds;
}

int job_cache_bytes(job_cache *jc, void **bytes, size_t *size,
                    image_error *error) {
  *size = hbil_cache_size(jc->cache);
  *bytes = malloc(*size);
  if (!*bytes)
    return image_no_memory(error, "radiance cache");
  const hbil_status status =
      hbil_cache_save(jc->cache, jc->device->queue, *bytes, *size);
  if (status == HBIL_SUCCESS)
    return 0;
  free(*bytes);
  return library_failed(jc, NULL, status, error);
}

int job_cache_save(job_cache *jc, image_error *error) {
  const hbil_cache_config *c = &jc->config;
  const char *path = jc->job->settings->cache_save;
  cache_file file = {
      .voxels = c->voxels, .levels = c->levels, .voxel_size = c->voxel_size};
  void *bytes;
  size_t size;
  memcpy(file.centre, c->centre, sizeof file.centre);
  if (job_cache_bytes(jc, &bytes, &size, error) != 0)
    return -1;
  file.size = size;
  const int failed =
      cache_file_write(path, &file, bytes, job_existing(jc->job), error);
  free(bytes);
  return failed;
}

/* ------------------------------------------------------------------------ */
/* The cache                                                                 */

static int make_cache(job_cache *jc, image_error *error) {
  const hbil_plane_format planes_of_floats = {HBIL_FLOAT32, 4};
  jc->config = jc->job->cache;
  jc->config.inputs = jc->job->config.inputs;
  jc->config.gather_emission = jc->job->config.model.gather_emission;
  jc->config.method = jc->job->config.model.cache_method;
  hbil_plane_format *const formats[] = {
      &jc->config.inputs.depth, &jc->config.inputs.normal,
      &jc->config.inputs.albedo, &jc->config.inputs.direct,
      &jc->config.inputs.emission};
  for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
    if (channels_of(jc, (int)i))
      *formats[i] = planes_of_floats;
  /* a view may show a sky, whose depth counts for all, where no frame does */
  for (int i = 0; i < jc->job->view_count; i++) {
    hbil_config view;
    hbil_config_init(&view);
    channel_map_configure(&jc->job->views[i].map, &view);
    jc->config.inputs.sky_depth =
        fminf(jc->config.inputs.sky_depth, view.inputs.sky_depth);
  }
  hbil_status status = hbil_cache_memory(jc->context, &jc->config, &jc->memory);
  if (status == HBIL_SUCCESS)
    status = hbil_cache_create(jc->context, &jc->config, &jc->cache);
  return status == HBIL_SUCCESS ? 0 : library_failed(jc, NULL, status, error);
}

/* "hbil: radiance cache: 64 x 64 x 64 voxels of 0.1 and 0.2 units, 43.1 MiB; 6
 * views" */
static void tell(const job_cache *jc) {
  const job *j = jc->job;
  const process_settings *s = j->settings;
  const hbil_cache_config *c = &jc->config;
  const char *before = "; ";
  fprintf(stderr, "hbil: radiance cache: %u x %u x %u voxels of %.3g",
          (unsigned)c->voxels, (unsigned)c->voxels, (unsigned)c->voxels,
          c->voxel_size);
  for (unsigned l = 1; l < c->levels; l++)
    fprintf(stderr, "%s%.3g", l + 1 < c->levels ? ", " : " and ",
            ldexp(c->voxel_size, (int)l));
  fprintf(stderr, " units, %.1f MiB", (double)jc->memory / 1048576.0);
  if (s->cache_load) {
    fputs(before, stderr);
    report_text(s->cache_load, stderr);
    before = ", ";
  }
  if (j->view_count) {
    fprintf(stderr, "%s%d view%s", before, j->view_count,
            j->view_count > 1 ? "s" : "");
    before = ", ";
  }
  if (s->learn)
    fprintf(stderr, "%sall frames", before);
  else if (j->count > 1 && !s->cache_fixed)
    fprintf(stderr, "%searlier frames", before);
  fputc('\n', stderr);
}

int job_cache_open(const device *d, hbil_context *context, const job *j,
                   job_cache **out, image_error *error) {
  job_cache *jc = calloc(1, sizeof *jc);
  *out = NULL;
  if (!jc)
    return image_no_memory(error, "the radiance cache");
  jc->device = d;
  jc->context = context;
  jc->job = j;
  if (make_cache(jc, error) != 0) {
    job_cache_close(jc);
    return -1;
  }
  if (!j->settings->quiet)
    tell(jc);
  *out = jc;
  return 0;
}

static void free_planes(const planes *p) {
  for (int i = 0; i < INPUTS; i++)
    if (p->input[i])
      clReleaseMemObject(p->input[i]);
}

void job_cache_close(job_cache *jc) {
  if (!jc)
    return;
  free_planes(&jc->views);
  for (int i = 0; i < HBIL_MAX_LIGHT_VIEWS; i++)
    free_planes(&jc->lights[i]);
  hbil_cache_destroy(jc->cache);
  free(jc);
}

hbil_cache *job_cache_of(const job_cache *jc) {
  return jc->cache;
}

size_t job_cache_memory(const job_cache *jc) {
  return jc->memory;
}
