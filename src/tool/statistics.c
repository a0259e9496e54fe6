/* The library's statistics of a frame, as text and as JSON. */
#include "tool/statistics.h"

#include <string.h>

static double percent(size_t part, size_t of) {
  return of ? 100.0 * (double)part / (double)of : 0.0;
}

void statistics_print(const hbil_statistics *s, FILE *out) {
  const struct {
    const char *name;
    const hbil_count *share;
  } shares[] = {{"sky", &s->sky},
                {"open", &s->open},
                {"dark", &s->dark},
                {"unused", &s->unused},
                {"from the horizon cache", &s->from_cache}};
  const char *between = "";
  for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
    if (!shares[i].share->pixels)
      continue;
    fprintf(out, "%s%s %.1f %% of pixels, %.1f %% of spans", between,
            shares[i].name, percent(shares[i].share->pixels, s->all.pixels),
            percent(shares[i].share->spans, s->all.spans));
    between = "; ";
  }
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    if (s->not_run[p]) {
      fprintf(out, "%sno %s", between, hbil_pass_name((hbil_pass)p));
      between = "; ";
    }
}

static json_t *count_json(const hbil_count *s) {
  return json_pack("{s:I, s:I}", "pixels", (json_int_t)s->pixels, "spans",
                   (json_int_t)s->spans);
}

json_t *statistics_json(const hbil_statistics *s) {
  json_t *passes = json_array();
  for (int p = 0; p < HBIL_PASS_COUNT; p++)
    if (s->not_run[p])
      json_array_append_new(passes, json_string(hbil_pass_name((hbil_pass)p)));
  return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "all",
                   count_json(&s->all), "sky", count_json(&s->sky), "open",
                   count_json(&s->open), "dark", count_json(&s->dark), "unused",
                   count_json(&s->unused), "cached", count_json(&s->from_cache),
                   "not_run", passes);
}

enum { SANITIZED_INPUTS = 8 };

typedef struct sanitized_input {
  const char *name;
  size_t pixels;
} sanitized_input;

static void list_sanitized(const hbil_sanitized *s,
                           sanitized_input out[SANITIZED_INPUTS]) {
  const sanitized_input inputs[SANITIZED_INPUTS] = {
      {"depth", s->depth},   {"normal", s->normal},
      {"albedo", s->albedo}, {"f0", s->f0},
      {"direct", s->direct}, {"emission", s->emission},
      {"motion", s->motion}, {"facing_away", s->facing_away}};
  memcpy(out, inputs, sizeof inputs);
}

int sanitized_print(const hbil_sanitized *s, const char *before, FILE *out) {
  sanitized_input inputs[SANITIZED_INPUTS];
  int some = 0;
  list_sanitized(s, inputs);
  for (int i = 0; i < SANITIZED_INPUTS; i++) {
    if (!inputs[i].pixels)
      continue;
    fprintf(out, "%s%s %zu", some ? ", " : before, inputs[i].name,
            inputs[i].pixels);
    some = 1;
  }
  return some;
}

json_t *sanitized_json(const hbil_sanitized *s) {
  sanitized_input inputs[SANITIZED_INPUTS];
  json_t *object = json_object();
  list_sanitized(s, inputs);
  for (int i = 0; i < SANITIZED_INPUTS; i++)
    json_object_set_new(object, inputs[i].name,
                        json_integer((json_int_t)inputs[i].pixels));
  return object;
}
