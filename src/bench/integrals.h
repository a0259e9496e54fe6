/* The exact integral of the measured frame, one bounce, model by model: what
 * sampling errors are measured against. */
#ifndef HBIL_BENCH_INTEGRALS_H
#define HBIL_BENCH_INTEGRALS_H

#include "bench/content.h"
#include "bench/settings.h"

typedef struct bench_integrals {
  int slices;
  /* Planes of the compared pixels; NULL where the model is not in use, and of
   * light where it computes AO alone. */
  float *ao[BENCH_MODELS], *light[BENCH_MODELS];
} bench_integrals;

/* Of the models of the settings in the list. */
int bench_integrals_make(const bench_options *options,
                         const bench_content *content,
                         const bench_setting *list, size_t count,
                         bench_integrals *out, image_error *error);
/* Of one configuration of the content, with bench_integral_slices(): planes
 * of AO, and of E_near unless light is NULL.  The caller frees both. */
int bench_integral_make(const bench_content *content, const hbil_config *config,
                        int slices, float **ao, float **light,
                        image_error *error);
int bench_integral_slices(const bench_options *options);
void bench_integrals_free(bench_integrals *integrals);

#endif
