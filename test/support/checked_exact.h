/*
 * The functions of src/exact that can fail, for tests: a failure fails the test
 * that runs.  Parameters are those of the function of the same name, without
 * the status.
 */
#ifndef HBIL_TEST_CHECKED_EXACT_H
#define HBIL_TEST_CHECKED_EXACT_H

#include "exact/passes.h"

#define PI 3.14159265358979323846

exact_planes checked_planes(int width, int height, int count);
/* Frees each of some planes. */
#define planes_free(...) planes_free_all((exact_planes *[]){__VA_ARGS__, NULL})
void planes_free_all(exact_planes *const *list);
void checked_reproject(const exact_frame *frame, const exact_planes *history,
                       exact_planes *carried);
void checked_push_pull(exact_planes *carried);
void checked_gather(const exact_frame *frame, const exact_planes *split,
                    exact_planes *gathered);
void checked_gather_dense(const exact_frame *frame, const exact_planes *split,
                          const exact_dense *how, exact_planes *gathered);
void checked_state(exact_state *state, int width, int height);
void checked_run_frame(exact_state *state, exact_frame *frame);
void checked_run_frame_dense(exact_state *state, exact_frame *frame,
                             const exact_dense *how);

#endif
