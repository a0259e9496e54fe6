/*
 * hbil: settings that a frame's pixels decide.  Programs include hbil/hbil.h.
 *
 * Which far field fits, and whether emission should be gathered, depends on
 * what the direct light of a renderer contains.  A program that knows its
 * renderer sets model.far_field and model.gather_emission itself.  One that
 * takes frames from elsewhere, as the tool does, lets the first frame decide.
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
/* Suggest: settings that the pixels of a first frame decide                 */

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
  hbil_host_plane direct;   /* 3 channels or 1; irradiance / direct_scale */
  hbil_host_plane emission; /* 3 channels or 1; the sky's, too */
} hbil_host_planes;

/* What a frame shows of a source of light. */
typedef enum hbil_source {
  HBIL_SOURCE_NOT_SEEN = 0,
  HBIL_SOURCE_IN_DIRECT = 1,    /* `direct` contains its light */
  HBIL_SOURCE_NOT_IN_DIRECT = 2 /* `direct` does not contain its light */
} hbil_source;

typedef struct hbil_sources {
  hbil_source sky;   /* a bright sky: pixels without a surface that emit */
  hbil_source lamps; /* surfaces that emit */
} hbil_sources;

/* Chooses config->model.far_field, frame->environment[0], frame->sky_share and
 * config->model.gather_emission by the planes of a sequence's first frame:
 *   sky               far_field            environment[0]      sky_share
 *   not seen          HBIL_FAR_FRAME       0                   0 .. 0.9
 *   in direct         HBIL_FAR_FRAME       the sky's radiance  0
 *   not in direct     HBIL_FAR_CONSTANT    the sky's radiance  0
 * gather_emission is CL_TRUE if there are lamps whose light `direct` does not
 * contain, else CL_FALSE.  Without a plane of normals they are taken from
 * depth.
 *
 * Unblocked directions end in the sky or on surfaces outside the picture.  For
 * those, the mean of the frame's own surfaces is a better guess than black.
 * sky_share tells a place in the open, whose shadows the sky lights, from a
 * room, whose shadows are black: it is 0.9 if at most 5 % of the surfaces have
 * less than a tenth of the typical direct light (the mean of the square roots,
 * squared), and falls to 0 at 9 %.  The
 * sky counts as seen if more than 0.1 % of the pixels show it.  Its radiance is
 * the mean of the square roots, squared, so that the sun's disc counts for
 * little.  `direct` contains the sky if it would make a white surface send
 * more than 2 % of this radiance, at over 0.1 % of the pixels.  It contains
 * the lamps if it has at least half of the light that they would send, without
 * obstacles, to the surfaces that don't emit, or, where nothing else faces a
 * lamp, to those that do.
 *
 * Of config, the function reads width, height, inputs and model.mode; formats
 * are not needed yet.  Of frame, it reads the camera and hardware_depth.  In
 * modes other than HBIL_MODE_HBIL, which look at no light, it sets
 * HBIL_FAR_NONE and CL_FALSE and does not read the planes.  sources receives
 * what was found; NULL is allowed.
 *
 * The function runs on the host, needs no device and no context, and takes
 * about as long as reading the planes three times.  Any thread may call it.
 * Returns HBIL_INVALID_ARGUMENT if config, frame or planes is null, if a plane
 * or channel is missing, or if a row_pitch is too small, or a pitch not a
 * multiple of four; HBIL_INVALID_CONFIG if width, height or depth_kind is out
 * of range; and HBIL_INVALID_FRAME if the camera's fx or fy is not positive or
 * hardware_depth is needed and invalid.  Then nothing is changed. */
HBIL_API hbil_status hbil_config_suggest(const hbil_host_planes *planes,
                                         hbil_config *config, hbil_frame *frame,
                                         hbil_sources *sources);

#ifdef __cplusplus
}
#endif

#endif
