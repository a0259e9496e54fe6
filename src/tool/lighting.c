/* Computes the light of a job's frames. */
#define _DEFAULT_SOURCE 1 /* RLIMIT_AS */
#include "tool/lighting.h"

#include "image/camera_json.h"
#include "image/error.h"
#include "image/image.h"
#include "tool/exact.h"
#include "tool/last_words.h"
#include "tool/refusal.h"
#include "tool/report.h"

#include <stdint.h>
#include <string.h>

int lighting_prepare(lighting *l, const job *j, image_error *error) {
  if (j->settings->exact)
    return exact_sequence_check(&j->config, error);
  if (device_open(j->settings->device, j->settings->timings, &l->device,
                  error) != 0)
    return -1;
  if (l->device.note && !j->settings->quiet)
    report_note(l->device.name, "", l->device.note);
  const hbil_status status =
      hbil_context_create(l->device.context, l->device.id, &l->context);
  if (status != HBIL_SUCCESS)
    return refusal(&l->device, NULL, status, NULL, error);
  l->programs = program_folder_of_device(l->context, l->device.id);
  return 0;
}

static int open_exact(lighting *l, const job *j, image_error *error) {
  exact_work work = {.frames = (unsigned)j->count, .quiet = j->settings->quiet};
  for (int i = 0; i < j->count; i++)
    work.runs += job_runs(j, i);
  return exact_sequence_open(&j->config, &j->frames[0].map, job_lit_layers(j),
                             &work, &l->exact, error);
}

static int open_sequence(lighting *l, const job *j, image_error *error) {
  return sequence_open(&l->device, l->context, &j->config, &j->frames[0].map,
                       job_lit_layers(j), job_halves(j), &l->sequence, error);
}

static int open_cache(lighting *l, const job *j, image_error *error) {
  if (!j->has_cache)
    return 0;
  if (job_cache_open(&l->device, l->context, j, &l->cache, error) != 0)
    return -1;
  sequence_set_cache(l->sequence, l->cache);
  return 0;
}

int lighting_open(lighting *l, job *j, image_error *error) {
  if (j->settings->exact)
    return open_exact(l, j, error);
  last_words_driver("built kernels");
  return open_sequence(l, j, error) != 0 ? -1 : open_cache(l, j, error);
}

void lighting_end(lighting *l) {
  job_cache_close(l->cache);
  sequence_close(l->sequence);
  exact_sequence_close(l->exact);
  l->cache = NULL;
  l->sequence = NULL;
  l->exact = NULL;
}

void lighting_close(lighting *l) {
  lighting_end(l);
  hbil_context_destroy(l->context);
  program_folder_close(l->programs);
  device_close(&l->device);
  memset(l, 0, sizeof *l);
}

size_t lighting_memory(const lighting *l) {
  return l->exact ? 0
                  : sequence_memory(l->sequence) +
                        (l->cache ? job_cache_memory(l->cache) : 0);
}

int lighting_learn(lighting *l, image_error *error) {
  if (!l->cache)
    return 0;
  last_words_driver("filled the radiance cache");
  return job_cache_learn(l->cache, error);
}

int lighting_see(lighting *l, const char *path, const gbuffer *g,
                 image_error *error) {
  return l->cache ? job_cache_see_frame(l->cache, path, g, NULL, error) : 0;
}

int lighting_cache_bytes(lighting *l, void **bytes, size_t *size,
                         image_error *error) {
  return job_cache_bytes(l->cache, bytes, size, error);
}

int lighting_save(lighting *l, image_error *error) {
  return l->cache ? job_cache_save(l->cache, error) : 0;
}

uint64_t lighting_hash(const lighting *l, const gbuffer *g) {
  return l->exact ? 0 : sequence_hash(l->sequence, g);
}

int lighting_run(lighting *l, const job *j, size_t item, const gbuffer *g,
                 uint64_t hash, image *result, image *hidden, timing_row *row,
                 image_error *error) {
  const job_frame *f = &j->frames[item];
  const unsigned runs = job_runs(j, (int)item);
  if (l->exact)
    return exact_sequence_run(l->exact, g, &f->camera, &j->far, runs, result,
                              hidden, error);
  last_words_driver("lit frames");
  return sequence_run(l->sequence, g, hash, &j->far, runs, result, hidden, row,
                      error);
}

size_t lighting_history_size(const lighting *l) {
  return l->exact ? exact_sequence_light_size(l->exact)
                  : sequence_history_size(l->sequence);
}

int lighting_history_save(lighting *l, void *bytes, image_error *error) {
  if (!l->exact)
    return sequence_history_save(l->sequence, bytes, error);
  exact_sequence_take_light(l->exact, bytes);
  return 0;
}

int lighting_history_restore(lighting *l, const job *j, int item, void *bytes,
                             image_error *error) {
  const camera_file *camera = &j->frames[item].camera;
  if (!l->exact)
    return sequence_history_restore(l->sequence, bytes, error);
  exact_sequence_give_light(l->exact, camera, bytes);
  return 0;
}

void lighting_expect(lighting *l, unsigned frames, unsigned runs) {
  if (l->exact)
    exact_sequence_expect(l->exact, frames, runs);
}
