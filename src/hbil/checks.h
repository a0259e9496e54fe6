/* What callers hand in with a frame or a view, checked before anything is
 * enqueued. */
#ifndef HBIL_CHECKS_H
#define HBIL_CHECKS_H

#include "buffers.h"
#include "staging.h"

/* What planes have to fit. */
typedef struct plane_rules {
  hbil_context *context;
  const hbil_config *config; /* size and formats, those of staged planes as the
                                passes see them */
  const staging *staged;
  const char *owner; /* of the formats: "plan" or "cache" */
  memory_range lent; /* scratch memory, in which no plane may lie */
} plane_rules;

/* Those planes of a frame, and the projection of its depths. */
hbil_status check_planes(const plane_rules *rules, const hbil_frame *frame,
                         unsigned planes);

/* A member that is true or false. */
hbil_status check_flag(hbil_context *context, hbil_status wrong,
                       const char *name, cl_bool flag);

/* Exposures that callers may give, beside 0.  With these, light from 1e-20 to
 * 1e20 remains far from the ends of floats. */
#define LEAST_EXPOSURE 1e-12
#define MOST_EXPOSURE 1e12

/* The exposure of a frame, a view or an update. */
hbil_status check_exposure(hbil_context *context, hbil_status wrong,
                           float exposure);

/* The far field that such an environment is.  Its brightest is that of direct
 * light, which is replaced above it; here it is an error. */
hbil_status check_environment(hbil_context *context, hbil_status wrong,
                              hbil_far_field far_field,
                              const float environment[9][3]);

/* The factor that a caller's exposure stands for. */
static inline float light_exposure(float given) {
  return given > 0.0f ? given : 1.0f;
}

/* A wait list of a public function. */
hbil_status check_wait_list(hbil_context *context, const char *function,
                            cl_uint wait_count, const cl_event *wait_list);

/* That the queue is for the context's device, and has profiling if that is
 * asked for; *in_order tells its kind. */
hbil_status check_queue(hbil_context *context, cl_command_queue queue,
                        bool profiling, bool *in_order);

#endif
