/* How far an answer's indirect light is from the truth. */
#include "bench/truth_measure.h"

#include <math.h>

#include "bench/colour.h"
#include "tool/compare_measure.h"

/* Rec. 709. */
static const double luminance_weights[3] = {0.2126, 0.7152, 0.0722};
/* Of the mean: darker pixels show their noise alone. */
static const double least_luminance = 1e-3;

static size_t pixels_of(const compare_side *s) {
  return (size_t)s->planes.width * s->planes.height;
}

/* --- chroma --- */

static double luminance(const double rgb[3]) {
  double sum = 0.0;
  for (int c = 0; c < 3; c++)
    sum += luminance_weights[c] * rgb[c];
  return sum;
}

/* Reads a pixel.  Returns whether it is finite. */
static int pixel_of(const compare_side *s, size_t i, double rgb[3]) {
  for (int c = 0; c < 3; c++)
    rgb[c] = (double)s->planes.planes[c].pixels[i];
  return isfinite(rgb[0]) && isfinite(rgb[1]) && isfinite(rgb[2]);
}

/* A truth that is a difference of two pictures may be negative by its noise. */
static void chromaticity(const double rgb[3], double out[3]) {
  double sum = 0.0;
  for (int c = 0; c < 3; c++) {
    out[c] = fmax(rgb[c], 0.0);
    sum += out[c];
  }
  for (int c = 0; c < 3; c++)
    out[c] = sum > 0.0 ? out[c] / sum : 1.0 / 3.0;
}

/* Reads pixel i of both, if it may count at all. */
static int pixels_at(const compare_side *answer, const compare_side *truth,
                     const channel_mask masks[3], size_t i, double a[3],
                     double t[3]) {
  for (int c = 0; c < 3; c++)
    if (!channel_mask_has(&masks[c], i))
      return 0;
  return pixel_of(answer, i, a) && pixel_of(truth, i, t);
}

static double chroma_error(const compare_side *answer,
                           const compare_side *truth,
                           const compare_mask *mask) {
  double a[3], t[3], sum = 0.0, weights = 0.0, mean = 0.0, count = 0.0;
  channel_mask masks[3];
  for (int c = 0; c < 3; c++)
    masks[c] = compare_mask_channel(mask, truth->planes.planes[c].name);
  for (size_t i = 0; i < pixels_of(truth); i++)
    if (pixels_at(answer, truth, masks, i, a, t)) {
      mean += luminance(t);
      count += 1.0;
    }
  mean /= count;
  for (size_t i = 0; i < pixels_of(truth); i++) {
    double ca[3], ct[3], square = 0.0;
    if (!pixels_at(answer, truth, masks, i, a, t) ||
        !(luminance(t) > least_luminance * mean))
      continue;
    chromaticity(a, ca);
    chromaticity(t, ct);
    for (int c = 0; c < 3; c++)
      square += (ca[c] - ct[c]) * (ca[c] - ct[c]);
    sum += luminance(t) * square;
    weights += luminance(t);
  }
  return sqrt(sum / weights);
}

/* --- all figures --- */

int truth_measure(const compare_side *answer, const compare_side *truth,
                  const compare_mask *mask, truth_figures *out,
                  image_error *error) {
  compare_result there, back; /* back: for the answer's mean */
  if (compare_measure(answer, truth, mask, NULL, &there, error) != 0 ||
      compare_measure(truth, answer, mask, NULL, &back, error) != 0)
    return -1;
  if (there.values + there.not_finite == 0)
    return image_fail(error,
                      "%s: its frame has no pixel to compare; surfaces whose "
                      "albedo is above 0.02 are needed",
                      truth->path);
  *out = (truth_figures){.rmse = there.rmse,
                         .mean = back.mean,
                         .chroma = chroma_error(answer, truth, mask),
                         .not_finite = there.not_finite};
  return 0;
}

int truth_measure_constant(const double rgb[3], const compare_side *truth,
                           const compare_mask *mask, truth_figures *out,
                           image_error *error) {
  compare_side answer;
  int failed = bench_colour_fill(&truth->planes, rgb, &answer, error);
  if (!failed)
    failed = truth_measure(&answer, truth, mask, out, error);
  compare_side_free(&answer);
  return failed;
}

void truth_mean_colour(const compare_side *truth, const compare_mask *mask,
                       double rgb[3]) {
  for (int c = 0; c < 3; c++) {
    const image_plane *plane = &truth->planes.planes[c];
    const channel_mask m = compare_mask_channel(mask, plane->name);
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < pixels_of(truth); i++)
      if (channel_mask_has(&m, i) && isfinite(plane->pixels[i])) {
        sum += (double)plane->pixels[i];
        count += 1.0;
      }
    rgb[c] = count > 0.0 ? sum / count : 0.0;
  }
}
