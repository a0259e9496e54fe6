/*
 * A clock for durations.
 */
#ifndef HBIL_IMAGE_CLOCK_H
#define HBIL_IMAGE_CLOCK_H

/* Seconds since some fixed time, by a clock that is never set back.  Any
 * thread. */
double seconds_now(void);

#endif
