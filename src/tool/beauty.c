/* The frame's own picture, in other indirect light. */
#include "tool/beauty.h"

#include "tool/layers.h"
#include "tool/report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ------------------------------------------------------------------------ */
/* What beauty is                                                            */

static const role needed[] = {ROLE_PICTURE, ROLE_INDIRECT, ROLE_ALBEDO};

/* The first of the needed roles that a frame lacks, or ROLE_COUNT. */
static role missing(const job_frame *f) {
  for (size_t i = 0; i < sizeof needed / sizeof *needed; i++)
    if (!f->map.count[needed[i]])
      return needed[i];
  return ROLE_COUNT;
}

/* The first frame that lacks a needed role, or NULL. */
static const job_frame *find_incomplete(const job *j) {
  for (int i = 0; i < j->count; i++)
    if (missing(&j->frames[i]) != ROLE_COUNT)
      return &j->frames[i];
  return NULL;
}

static int all_have_alpha(const job *j) {
  for (int i = 0; i < j->count; i++)
    if (!j->frames[i].map.count[ROLE_ALPHA])
      return 0;
  return 1;
}

static int fail_incomplete(const job_frame *f, image_error *error) {
  return image_fail(error,
                    "%s: has no %s; --beauty replace needs the finished "
                    "picture, its diffuse indirect light and albedo (Blender's "
                    "Combined, DiffInd and DiffCol)",
                    f->path, role_name(missing(f)));
}

static void tell(const job *j) {
  char text[240];
  snprintf(text, sizeof text,
           "beauty is the file's picture (%.80s), with hbil's light in place "
           "of its diffuse indirect light",
           j->frames[0].map.names[ROLE_PICTURE][0]);
  if (!j->settings->quiet)
    report_note(j->frames[0].path, "", text);
}

int beauty_choose(job *j, image_error *error) {
  const beauty_kind asked = j->settings->beauty;
  const job_frame *incomplete = find_incomplete(j);
  if (asked == BEAUTY_REPLACE && !(j->layers >> LAYER_BEAUTY & 1))
    return image_fail(error, "--beauty replace: --layers is without beauty");
  if (asked == BEAUTY_REPLACE && incomplete)
    return fail_incomplete(incomplete, error);
  j->replaces =
      asked != BEAUTY_DIFFUSE && !incomplete && (j->layers >> LAYER_BEAUTY & 1);
  if (!j->replaces)
    return 0;
  if (all_have_alpha(j))
    j->layers |= 1u << LAYER_ALPHA;
  tell(j);
  return 0;
}

/* ------------------------------------------------------------------------ */
/* Its pixels                                                                */

/* One channel of a pixel.  A picture's colour may be negative, outside of its
 * primaries' gamut; noise that a denoiser took from it may not make it so. */
static float replace(float picture, float albedo, float theirs, float ours) {
  const float light = albedo * (ours - theirs);
  return isfinite(light) ? fmaxf(picture + light, fminf(picture, 0.0f))
                         : picture;
}

void beauty_replace(const gbuffer *g, const image *hidden, image *result) {
  const size_t pixels = gbuffer_pixels(g);
  const float *alpha = gbuffer_plane(g, ROLE_ALPHA, 0);
  const float *coverage =
      g->map.how.premultiplied ? gbuffer_plane(g, ROLE_COVERAGE, 0) : NULL;
  float *alpha_out = layers_plane(result, LAYER_ALPHA, 0);
  for (size_t c = 0; c < 3; c++) {
    const float *picture = gbuffer_plane(g, ROLE_PICTURE, c);
    const float *albedo = gbuffer_plane(g, ROLE_ALBEDO, c);
    const float *theirs = gbuffer_plane(g, ROLE_INDIRECT, c);
    const float *ours = layers_plane_of(result, hidden, LAYER_INDIRECT, c);
    float *out = layers_plane(result, LAYER_BEAUTY, c);
    for (size_t i = 0; i < pixels; i++)
      out[i] =
          replace(picture[i], coverage ? coverage[i] * albedo[i] : albedo[i],
                  theirs[i], ours[i]);
  }
  if (alpha_out && alpha)
    memcpy(alpha_out, alpha, pixels * sizeof *alpha);
}
