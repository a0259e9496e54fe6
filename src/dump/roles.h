/*
 * Roles: what the channels of a dump are to the light computation.  A dump is
 * a file (or several) in which a renderer stored a frame's G-buffer.
 */
#ifndef HBIL_DUMP_ROLES_H
#define HBIL_DUMP_ROLES_H

#include <stddef.h>

typedef enum role {
  ROLE_DEPTH = 0,
  ROLE_NORMAL,
  ROLE_ALBEDO,
  ROLE_DIRECT,     /* diffuse direct light */
  ROLE_EMISSION,   /* radiance that surfaces emit */
  ROLE_BACKGROUND, /* radiance of the sky, if it is stored as its own pass */
  ROLE_MOTION,
  ROLE_POSITION,
  ROLE_INDIRECT, /* radiance of diffuse indirect light, without albedo */
  ROLE_COVERAGE, /* share of a pixel that surfaces fill, 0 .. 1 */
  ROLE_PICTURE,  /* radiance of the finished picture */
  ROLE_ALPHA,    /* its opacity, 0 .. 1 */
  ROLE_COUNT
} role;

/* The largest number of channels that a role has. */
enum { ROLE_CHANNELS = 3 };

/* The word for a role in --map and in messages. */
const char *role_name(role r);

/* The number of channels of a role: 1, 2 or 3. */
size_t role_channels(role r);

/* Whether a role holds RGB values: albedo, light or emission. */
int role_is_colour(role r);

#endif
