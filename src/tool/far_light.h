/* The far light of a job's frames. */
#ifndef HBIL_TOOL_FAR_LIGHT_H
#define HBIL_TOOL_FAR_LIGHT_H

/* The members of hbil_frame with these names.  All have four bytes, so there is
 * no padding, and jobs hash it (job_key.c). */
typedef struct far_light {
  float environment[9][3];
  float sky_share;
} far_light;

#endif
