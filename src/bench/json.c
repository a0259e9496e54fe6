/* The report as JSON. */
#include "bench/bench.h"

#include <jansson.h>

#include <math.h>

/* JSON has no NaN and no infinity. */
static json_t *number(double value) {
  return isfinite(value) ? json_real(value) : json_null();
}

/* Without a document nothing is written, which the caller notices. */
static void write_document(json_t *root, FILE *out) {
  if (root)
    json_dumpf(root, out, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
  json_decref(root);
  fputc('\n', out);
}

static json_t *spread(bench_spread s) {
  return json_pack("{s:o, s:o, s:o}", "median", number(s.median), "min",
                   number(s.low), "max", number(s.high));
}

static json_t *machine(const bench_machine *m) {
  return json_pack("{s:s, s:i, s:s, s:s, s:s}", "device", m->device,
                   "compute_units", (int)m->units, "platform", m->platform,
                   "version", m->version, "driver", m->driver);
}

static json_t *content(const bench_content *c) {
  return json_pack("{s:s, s:i, s:i, s:i, s:s}", "name", c->name, "width",
                   (int)c->width, "height", (int)c->height, "frames",
                   (int)c->frames, "note", c->note);
}

static json_t *copy(const bench_copy *c) {
  return json_pack("{s:i, s:I, s:o, s:o}", "planes", (int)c->planes, "bytes",
                   (json_int_t)c->bytes, "milliseconds",
                   spread(c->milliseconds), "gigabytes_per_second",
                   number((double)c->bytes * 1e-6 / c->milliseconds.median));
}

static json_t *literal(const bench_literal *l) {
  return json_pack("{s:i, s:i, s:o, s:o, s:o}", "slices", 2, "samples", 8,
                   "milliseconds", spread(l->milliseconds), "light_error",
                   number(l->light_error), "ao_error", number(l->ao_error));
}

static json_t *truth(const bench_content *c) {
  if (!c->truth)
    return json_null();
  return json_pack("{s:i, s:o, s:o}", "bounces", BENCH_TRUTH_BOUNCES, "zero",
                   number(bench_model_error(c, NULL)), "constant_mean",
                   number(bench_mean_error(c)));
}

static json_t *most(float error) {
  return error > 0.0f ? number((double)error) : json_null();
}

static json_t *settings(const bench_configuration *c) {
  return json_pack(
      "{s:s, s:s?, s:i, s:i, s:f, s:s, s:b, s:s, s:b, s:o, s:o}", "model",
      *bench_model_name(c->model) ? bench_model_name(c->model) : "paper",
      "preset", c->preset, "slices", (int)c->slices, "samples", (int)c->samples,
      "growth", (double)c->growth, "lattice",
      c->lattice == HBIL_GRID_FULL_RESOLUTION ? "full" : "layer", "raw", c->raw,
      "storage", bench_storage_name(c), "extrapolate", !c->plain,
      "max_ao_error", most(c->most_ao), "max_light_error", most(c->most_light));
}

/* Copies of their bytes that the memory-bound passes take. */
static json_t *copies(const bench_report *report, const bench_row *row) {
  static const hbil_pass passes[] = {HBIL_PASS_SPLIT, HBIL_PASS_PUSH_PULL,
                                     HBIL_PASS_COMPOSITE};
  json_t *out = json_object();
  for (int i = 0; i < 3; i++) {
    const double bytes = bench_pass_bytes(report->content, passes[i]);
    json_object_set_new(out, hbil_pass_name(passes[i]),
                        number(row->pass[passes[i]].median /
                               bench_copy_time(&report->copy, bytes)));
  }
  return out;
}

static json_t *ratios(const bench_report *report, const bench_row *row) {
  const double literal_time = report->literal.milliseconds.median;
  const double gather = row->pass[HBIL_PASS_GATHER].median;
  return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "literal_over_gather",
                   number(literal_time / gather), "literal_over_total",
                   number(literal_time / row->total.median),
                   "gather_over_start", number(row->gather_over_start),
                   "total_over_start", number(row->total_over_start),
                   "gather_over_endless", number(row->over_endless), "copies",
                   bench_is_ao_alone(row->configuration.model)
                       ? json_null()
                       : copies(report, row));
}

static json_t *errors(const bench_row *row) {
  return json_pack("{s:o, s:o, s:o, s:b, s:b, s:o, s:o, s:o, s:o}", "light",
                   number(row->light_error), "ao", number(row->ao_error),
                   "model", number(row->model_error), "light_front",
                   row->light_front, "ao_front", row->ao_front, "light_95",
                   number(row->light_95), "ao_95", number(row->ao_95),
                   "light_loss", number(row->light_loss), "ao_loss",
                   number(row->ao_loss));
}

static json_t *row_json(const bench_report *report, const bench_row *row) {
  json_t *times = json_object();
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    json_object_set_new(times, hbil_pass_name((hbil_pass)p),
                        spread(row->pass[p]));
  json_object_set_new(times, "total", spread(row->total));
  return json_pack("{s:s, s:b, s:o, s:o, s:o, s:I, s:o, s:o}", "label",
                   row->label, "default", bench_is_default(&row->configuration),
                   "settings", settings(&row->configuration), "milliseconds",
                   times, "host_milliseconds", spread(row->host),
                   "device_bytes", (json_int_t)row->memory, "errors",
                   errors(row), "ratios", ratios(report, row));
}

/* --- scaling --- */

static json_t *note(const char *text) {
  return *text ? json_string(text) : json_null();
}

static json_t *timing(const bench_timing *t) {
  return json_pack("{s:o, s:o, s:o}", "frame", spread(t->total), "gather",
                   spread(t->pass[HBIL_PASS_GATHER]), "host", spread(t->host));
}

static json_t *size_json(const bench_scaling *s, const bench_size *size) {
  const bench_timing *t = &size->timing;
  const int there = !size->skipped[0];
  return json_pack(
      "{s:i, s:i, s:o, s:o, s:o, s:o, s:I, s:I}", "width", (int)size->width,
      "height", (int)size->height, "skipped", note(size->skipped),
      "milliseconds", there ? timing(t) : json_null(), "frame_ratio",
      number(there ? bench_size_ratio(s, size, t->total_ratio) : NAN),
      "gather_ratio",
      number(there ? bench_size_ratio(s, size, t->pass_ratio[HBIL_PASS_GATHER])
                   : NAN),
      "plan_bytes", (json_int_t)size->memory.plan, "plane_bytes",
      (json_int_t)size->memory.planes);
}

static json_t *sampling_json(const bench_scaling *s,
                             const bench_sampling *sampling) {
  return json_pack("{s:i, s:i, s:o, s:o}", "slices", 2, "samples",
                   (int)sampling->samples, "milliseconds",
                   timing(&sampling->timing), "gather_ratio",
                   number(bench_sampling_ratio(s, sampling)));
}

static json_t *threads(const bench_threads *t) {
  if (t->left_out[0])
    return json_pack("{s:s}", "left_out", t->left_out);
  return json_pack("{s:n, s:i, s:[o, o], s:[o, o], s:f, s:f}", "left_out",
                   "count", (int)t->count, "frame_milliseconds",
                   spread(t->total[0]), spread(t->total[1]),
                   "gather_milliseconds", spread(t->gather[0]),
                   spread(t->gather[1]), "frame_gain", t->total_gain,
                   "gather_gain", t->gather_gain);
}

static json_t *opening(const bench_opening *o) {
  if (o->left_out[0])
    return json_pack("{s:s}", "left_out", o->left_out);
  return json_pack("{s:n, s:o, s:[o, o, o], s:o}", "left_out", "plan",
                   spread(o->plan), "frames", spread(o->frame[0]),
                   spread(o->frame[1]), spread(o->frame[2]),
                   "first_less_second", spread(o->extra));
}

void bench_write_scaling_json(const bench_report *report, FILE *out) {
  const bench_scaling *s = report->scaling;
  json_t *sizes = json_array(), *samplings = json_array();
  for (size_t i = 0; i < BENCH_SIZES; i++)
    json_array_append_new(sizes, size_json(s, &s->size[i]));
  for (size_t i = 0; i < BENCH_SAMPLINGS; i++)
    json_array_append_new(samplings, sampling_json(s, &s->sampling[i]));
  json_t *root = json_pack(
      "{s:s, s:o, s:s, s:i, s:i, s:i, s:o, s:o, s:o, s:o}", "hbil",
      hbil_version(), "machine", machine(&report->machine), "label", s->label,
      "runs", (int)s->runs, "warm_up", BENCH_WARM_UP, "processes",
      (int)s->rounds, "sizes", sizes, "samplings", samplings, "threads",
      threads(&s->threads), "start_milliseconds", opening(&s->opening));
  write_document(root, out);
}

/* --- skips --- */

static json_t *skip_json(const bench_skip *s) {
  return json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "name", s->name,
                   "whole_milliseconds", timing(&s->full), "milliseconds",
                   timing(&s->timing), "frame_ratio",
                   number(s->timing.total_ratio), "frame_aim",
                   number(s->frame_aim), "gather_ratio",
                   number(s->timing.pass_ratio[HBIL_PASS_GATHER]), "gather_aim",
                   number(s->gather_aim), "skipped",
                   timings_skipped_json(&s->timing.skipped));
}

void bench_write_skips_json(const bench_report *report, FILE *out) {
  json_t *rows = json_array();
  for (int i = 0; i < BENCH_SKIPS; i++)
    json_array_append_new(rows, skip_json(&report->skips[i]));
  write_document(json_pack("{s:s, s:o, s:o, s:i, s:i, s:o}", "hbil",
                           hbil_version(), "machine", machine(&report->machine),
                           "content", content(report->content), "runs",
                           (int)report->runs, "warm_up", BENCH_WARM_UP, "skips",
                           rows),
                 out);
}

/* --- adaptive sampling over scenes --- */

static json_t *sampling(const cl_uint slices_samples[2]) {
  return json_pack("[i, i]", (int)slices_samples[0], (int)slices_samples[1]);
}

static json_t *taken_json(const bench_taken *t) {
  return json_pack("{s:o, s:o, s:o, s:i}", "least", sampling(t->least), "most",
                   sampling(t->most), "worst_frame", number(t->worst), "beyond",
                   (int)t->beyond);
}

static json_t *way_json(const bench_promises *p, const bench_promise *promise,
                        int way, unsigned every) {
  const bench_way *w = &promise->way[way];
  json_t *scenes = json_array();
  for (size_t s = 0; s < p->scene_count; s++)
    json_array_append_new(scenes, taken_json(&w->taken[s]));
  return json_pack(
      "{s:i, s:o, s:o, s:o, s:i, s:o, s:o, s:o}", "choose_every", (int)every,
      "gather", number(w->gather), "choosing",
      number(w->choosing[BENCH_OWN_SIZE]), "choosing_720p",
      number(w->choosing[BENCH_ROOM_SIZE]), "beyond", (int)w->beyond,
      "over_uniform", number(bench_way_ratio(promise, way, BENCH_OWN_SIZE)),
      "over_uniform_720p",
      number(bench_way_ratio(promise, way, BENCH_ROOM_SIZE)), "scenes", scenes);
}

static json_t *promise_json(const bench_promises *p,
                            const bench_promise *promise) {
  const bench_configuration *c = &promise->limit;
  const cl_uint uniform[2] = {promise->uniform.slices,
                              promise->uniform.samples};
  return json_pack(
      "{s:o, s:o, s:[o, o], s:o, s:o}", "max_ao_error",
      c->most_ao > 0.0f ? number((double)c->most_ao) : json_null(),
      "max_light_error",
      c->most_light > 0.0f ? number((double)c->most_light) : json_null(),
      "ways", way_json(p, promise, 0, 1), way_json(p, promise, 1, CHOOSE_EVERY),
      "uniform", isnan(promise->uniform_cost) ? json_null() : sampling(uniform),
      "uniform_gather", number(promise->uniform_cost));
}

/* What each setting does in a frame. */
static json_t *case_json(const bench_promises *p, const bench_case *frame) {
  json_t *rows = json_array();
  for (size_t i = 0; i < p->row_count; i++) {
    const bench_row *row = &frame->rows[i];
    json_array_append_new(
        rows, json_pack("{s:s, s:i, s:i, s:o, s:o, s:o}", "label", row->label,
                        "slices", (int)row->slices, "samples",
                        (int)row->samples, "gather_milliseconds",
                        spread(row->pass[HBIL_PASS_GATHER]), "ao_95",
                        number(row->ao_95), "light_95", number(row->light_95)));
  }
  return json_pack("{s:s, s:i, s:o}", "frame",
                   frame->path ? frame->path : p->scene[frame->scene].name,
                   "scene", (int)frame->scene, "rows", rows);
}

void bench_write_promises_json(const bench_report *report, FILE *out) {
  const bench_promises *p = report->promises;
  json_t *scenes = json_array(), *promises = json_array();
  json_t *frames = json_array();
  for (size_t f = 0; f < p->frame_count; f++)
    json_array_append_new(frames, case_json(p, &p->frame[f]));
  for (size_t s = 0; s < p->scene_count; s++)
    json_array_append_new(scenes,
                          json_pack("{s:s, s:i}", "name", p->scene[s].name,
                                    "frames", (int)p->scene[s].frames));
  for (size_t i = 0; i < p->count; i++)
    json_array_append_new(promises, promise_json(p, &p->promise[i]));
  write_document(
      json_pack("{s:s, s:o, s:i, s:i, s:i, s:s, s:o, s:o, s:o}", "hbil",
                hbil_version(), "machine", machine(&report->machine), "runs",
                (int)report->runs, "warm_up", BENCH_WARM_UP, "exact_slices",
                report->exact_slices, "unit", "nanoseconds a pixel", "scenes",
                scenes, "promises", promises, "frames", frames),
      out);
}

/* --- all else --- */

/* Reprojection by motion vectors. */
static json_t *motion(const bench_report *report) {
  const double bytes = bench_motion_bytes(report->content);
  return json_pack(
      "{s:o, s:o}", "milliseconds", spread(report->motion), "copies",
      number(report->motion.median / bench_copy_time(&report->copy, bytes)));
}

/* Images of half floats beside such of floats. */
static json_t *halves(const bench_report *report) {
  return json_pack("{s:o, s:o, s:o}", "floats_milliseconds",
                   timing(&report->halves[0]), "milliseconds",
                   timing(&report->halves[1]), "frame_ratio",
                   number(report->halves[1].total_ratio));
}

void bench_write_json(const bench_report *report, FILE *out) {
  json_t *rows = json_array();
  char reference[64];
  bench_reference(report, reference, sizeof reference);
  for (size_t i = 0; i < report->count; i++)
    json_array_append_new(rows, row_json(report, &report->rows[i]));
  json_t *root = json_pack(
      "{s:s, s:o, s:o, s:i, s:i, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o}",
      "hbil", hbil_version(), "machine", machine(&report->machine), "content",
      content(report->content), "runs", (int)report->runs, "warm_up",
      BENCH_WARM_UP, "reference", reference, "truth", truth(report->content),
      "literal", literal(&report->literal), "copy", copy(&report->copy),
      "estimate_milliseconds", number(report->estimate), "motion",
      motion(report), "halves", halves(report), "rows", rows);
  write_document(root, out);
}
