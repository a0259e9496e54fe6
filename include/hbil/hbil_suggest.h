/*
 * hbil: settings that the pixels of frames decide.  Programs include
 * hbil/hbil.h.
 *
 * Which far field fits, and whether emission should be gathered, depends on
 * what the direct light of a renderer contains.  A program that knows its
 * renderer sets model.far_field and model.gather_emission itself.  One that
 * takes frames from elsewhere, as the tool does, lets them decide: the first
 * one, and whatever else shows the place before that is lit.
 */
#ifndef HBIL_HBIL_SUGGEST_H
#define HBIL_HBIL_SUGGEST_H

#include <hbil/hbil_base.h>
#include <hbil/hbil_config.h>
#include <hbil/hbil_frame.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------ */
/* Suggest: settings that the pixels of frames decide                        */

/* A plane in host memory, of floats. */
typedef struct hbil_host_plane {
  /* The first pixel of each channel; all NULL: the plane does not exist.
   * Interleaved RGB is p, p + 1, p + 2 with a pixel_pitch of 12.  Grey light
   * has one channel, and the others are NULL. */
  const float *channel[3];
  size_t pixel_pitch; /* bytes from a pixel to its right neighbour; 0: 4 */
  size_t row_pitch;   /* bytes from a row to the next; 0: width * pixel_pitch */
} hbil_host_plane;

/* Planes of config.width x config.height pixels.  Their values mean what
 * config.inputs says of the planes of the same names, apart from the formats
 * and normal_encoding.  depth is needed. */
typedef struct hbil_host_planes {
  hbil_host_plane depth;    /* 1 channel */
  hbil_host_plane normal;   /* 3 channels: x, y, z, of any length */
  hbil_host_plane direct;   /* 3 channels or 1; inputs.direct_kind */
  hbil_host_plane emission; /* 3 channels or 1; the sky's, too */
  /* 3 channels or 1; read with HBIL_DIRECT_RADIANCE alone */
  hbil_host_plane albedo;
} hbil_host_planes;

/* What frames show of a source of light. */
typedef enum hbil_source {
  HBIL_SOURCE_NOT_SEEN = 0,
  HBIL_SOURCE_IN_DIRECT = 1,    /* `direct` contains its light */
  HBIL_SOURCE_NOT_IN_DIRECT = 2 /* `direct` does not contain its light */
} hbil_source;

/* What decides where open directions end, which sky_share says. */
typedef enum hbil_place {
  HBIL_PLACE_SKY_SEEN = 0, /* a frame shows a bright sky: nothing to guess */
  HBIL_PLACE_EMPTY = 1,    /* frames show nothing behind the surfaces */
  HBIL_PLACE_OPEN = 2,     /* lit ground, no ceiling, no walls around */
  HBIL_PLACE_DARK = 3,     /* no light reaches most shadows */
  HBIL_PLACE_ENCLOSED = 4, /* a ceiling, or walls that face each other */
  HBIL_PLACE_NO_GROUND = 5 /* too little ground to tell */
} hbil_place;

/* What the frames of a place have shown.  `hbil_sources found = {0}` begins
 * without any; each call of hbil_config_suggest() adds one. */
typedef struct hbil_sources {
  hbil_source sky;   /* a bright sky: pixels without a surface that emit */
  hbil_source lamps; /* surfaces that emit */
  hbil_place place;
  /* The sums that decide; the library's own. */
  struct {
    double sky_roots[3], sky_pixels;
    double lamps, from_lamps[2], contained[2];
    double pictures, nothing, squares, shadows, ground, enclosed;
  } known;
} hbil_sources;

/* Chooses config->model.far_field, frame->environment[0], frame->sky_share and
 * config->model.gather_emission by the planes of a frame or another view of the
 * place, and of all that `sources` was in before:
 *   sky               far_field            environment[0]      sky_share
 *   not seen          HBIL_FAR_FRAME       0                   0 .. 0.9
 *   in direct         HBIL_FAR_FRAME       the sky's radiance  0
 *   not in direct     HBIL_FAR_CONSTANT    the sky's radiance  0
 * gather_emission is CL_TRUE if there are lamps whose light `direct` does not
 * contain, else CL_FALSE.  Without a plane of normals they are taken from
 * depth.
 *
 * To decide by several pictures, call the function for each of them with the
 * same `sources`, and with the width, height, projection and camera of that
 * picture; what the last call has set counts.  Settle this before the first
 * frame is lit, and give all frames of a sequence the same: light that is
 * guessed anew jumps.
 *
 * A frame shows the sky if more than 0.1 % of its pixels do; the sky's radiance
 * is the mean of the square roots over such frames, squared, so that the sun's
 * disc counts for little.  `direct` contains the sky if it would make a white
 * surface send more than 2 % of this radiance, at over 0.1 % of the pixels of a
 * frame that shows the sky.  It contains the lamps if it has at least half of
 * the light that they would send, without obstacles, to the surfaces that don't
 * emit, or, where nothing else faces a lamp, to those that do.
 *
 * Unblocked directions end in the sky or on surfaces outside the picture.  For
 * those, the mean of the frame's own surfaces is a better guess than black.
 * sky_share is how many end in a sky that no frame shows, or in nothing: 0 in
 * rooms, up to 0.9 in the open, by the larger one of
 *   1.5 times the mean share of the pixels that show neither a surface nor
 *     light;
 *   0.9, if at most 5 % of the surfaces have less than a tenth of the typical
 *     direct light (0 from 9 % on), 35 % of them face up (0 below 20 %), fewer
 *     than 1 % face down in any frame (0 from 3 % on), and upright ones
 *     face each other in less than 4 % of all pairs of a frame (0 from 10 %
 *     on).
 * Up is the axis of the world that is the most upright one in the picture.
 *
 * Of config, the function reads width, height, inputs and model.mode; formats
 * are not needed yet.  Of frame, it reads the camera and hardware_depth.  In
 * modes other than HBIL_MODE_HBIL, which look at no light, it sets
 * HBIL_FAR_NONE and CL_FALSE and does not read the planes.  sources: NULL for
 * one picture alone.
 *
 * The function runs on the host, needs no device and no context, and takes
 * about as long as reading the planes three times.  Threads may call it at the
 * same time with different `sources`.  Returns HBIL_INVALID_ARGUMENT if config,
 * frame or planes is null, if a plane or channel is missing, or if a row_pitch
 * is too small, or a pitch not a multiple of four; HBIL_INVALID_CONFIG if
 * width, height or depth_kind is out of range; and HBIL_INVALID_FRAME if the
 * camera's fx or fy is not positive or hardware_depth is needed and invalid.
 * Then nothing is changed. */
HBIL_API hbil_status hbil_config_suggest(const hbil_host_planes *planes,
                                         hbil_config *config, hbil_frame *frame,
                                         hbil_sources *sources);

#ifdef __cplusplus
}
#endif

#endif
