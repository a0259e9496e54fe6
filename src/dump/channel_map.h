/*
 * A channel map: which channels of a frame have which role, in which files they
 * are, and what their numbers mean.
 */
#ifndef HBIL_DUMP_CHANNEL_MAP_H
#define HBIL_DUMP_CHANNEL_MAP_H

#include "dump/source.h"
#include "hbil/hbil.h"
#include "image/error.h"
#include "image/image.h"
#include "image/window.h"

typedef struct channel_map {
  dump_kind kind;
  conventions how;
  size_t count[ROLE_COUNT]; /* channels of each role; 0: the dump has none */
  char names[ROLE_COUNT][ROLE_CHANNELS][256];
  char *files[ROLE_COUNT]; /* the role's file, if it is not the frame's own; the
                              map owns the names */
  int gamma[ROLE_COUNT];   /* 1: the file's colours are sRGB */
  int floats[ROLE_COUNT];  /* 1: the file has floats, which are linear if they
                              are light */
  char lacks[ROLE_COUNT][256]; /* a role that is left out, since a layer has
                                  its other channels: the first that isn't
                                  there; "": none */
  unsigned chosen;             /* roles that --map names, a bit mask */
  int unnamed;                 /* 1: the file's channels are ch00, ch01, ... */
  int emission_is_sky; /* 1: emission is the pass of the background alone */
  char picked[2][256]; /* what was chosen unasked of several view layers and
                          eyes; "": nothing */
  int is_beauty;       /* 1: by its name, direct light is a finished image */
  hbil_camera camera;  /* for conversions; fx 0: unknown */
  hbil_projection projection; /* of the camera */
  double exposure;            /* light in the files has this factor; 0: none */
  int mirrored;      /* 1: the dump's world is left-handed, and z of world space
                        changes its sign (see frame_camera.h) */
  image_window data; /* where the file has pixels */
  image_window display;     /* the part that is shown */
  image_window window;      /* what the planes shall cover; at first `data` */
  struct held_planes *held; /* of the frame's own file (held_planes.h), the
                               caller's; NULL: each reader reads it */
} channel_map;

/* An empty map with the conventions of a source. */
void channel_map_init(channel_map *out, dump_kind kind);

/* How the colours of the file are stored that has the role's channels. */
void channel_map_encode(channel_map *map, role r, const image *header);

/* Frees what the map owns.  It may be called twice. */
void channel_map_free(channel_map *map);

/* Whether the map has what the computation cannot do without: depth, normals
 * unless they are rebuilt from it, and no more pixels than the library takes.
 * 0, or -1 with `error` filled. */
int channel_map_check(const channel_map *map, const char *path,
                      image_error *error);

/* Whether frames with these maps may follow each other in a job: the channels
 * of the first one, whose kernels serve all, and pictures of its size.  0, or
 * -1 with `error` filled. */
int channel_map_follows(const channel_map *map, const char *path,
                        const channel_map *first, const char *first_path,
                        image_error *error);

/* Takes the conventions of the first frame, whose pixels have decided them. The
 * clipping planes stay those of the own camera. */
void channel_map_read_alike(channel_map *map, const channel_map *first);

/* What each axis of vectors of that space is multiplied by (1 or -1): the flips
 * of the conventions, then those that lead to view space or to a right-handed
 * world. */
void channel_map_signs(const channel_map *map, dump_space space, float sign[3]);

/* Whether depth is that of a depth buffer. */
int channel_map_depth_is_hardware(const channel_map *map);

/* hbil_frame.hardware_depth of this frame; 0, 0 for other kinds of depth. */
void channel_map_hardware_depth(const channel_map *map, double out[2]);

/* Describes to the library how the planes of a G-buffer are to be read (see
 * convert.h): sets projection, depth_kind, depth_scale, sky_depth,
 * normal_space, normal_scale, direct_scale and motion_scale. */
void channel_map_configure(const channel_map *map, hbil_config *config);

#endif
