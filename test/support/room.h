/*
 * A box-shaped room, views of it, and a radiance cache that has seen it: what
 * the tests of caches share.
 */
#ifndef HBIL_TEST_ROOM_H
#define HBIL_TEST_ROOM_H

#include "test/support/fixture.h"

/* The walls, and the directions in which a camera looks: rows of pixels go
 * down, so FLOOR is at the positive end of y. */
typedef enum wall { LEFT, RIGHT, CEILING, FLOOR, BEHIND, AHEAD } wall;
enum { WALLS = 6 };

/* About the origin; all walls are grey. */
typedef struct room {
  double half[3];
  float albedo;
  float direct[WALLS]; /* irradiance, or what else the plane holds */
  float emission[WALLS];
  bool roofless; /* there is sky in place of the ceiling */
} room;

/* Size that fits into a cache of room_cache_config(). */
room room_dark(void);

/* A camera at `eye` that looks towards a wall, with a horizontal field of view
 * in degrees. */
hbil_camera room_camera(const double eye[3], wall towards, int width,
                        int height, double fov);
/* The same in orthographic projection, `across` world units wide. */
hbil_camera room_flat_camera(const double eye[3], wall towards, int width,
                             int height, double across);

/* A setup of the room as the camera sees it: the model for caches, all outputs,
 * everything that isn't needed left out; then setup_start(). */
void room_setup(setup *s, const room *r, const hbil_camera *camera, int width,
                int height);
/* Replaces the inputs, in the configured projection. */
void room_load(setup *s, const room *r, const hbil_camera *camera);

/* --- caches and views --- */

/* 32 voxels, two levels, voxels of ROOM_VOXEL, and the formats of the views. */
#define ROOM_VOXEL 0.125
hbil_cache_config room_cache_config(void);
/* Must succeed. */
hbil_cache *room_cache(const device_fixture *d);

/* A picture with buffers of its own; room_view_free() releases them. */
hbil_view room_view(const device_fixture *d, const room *r,
                    const hbil_camera *camera, hbil_projection projection,
                    int width, int height, hbil_view_light light);
void room_view_free(hbil_view *view);
/* Six views of 90 degrees from `eye`. */
void room_views(const device_fixture *d, const room *r, const double eye[3],
                int size, hbil_view_light light, hbil_view views[WALLS]);
void room_views_free(hbil_view *views, int count);
/* Shows them to a cache, from the middle, and updates it. */
void room_show(hbil_cache *cache, const room *r, int size,
               hbil_view_light light, cl_uint bounces);

/* Injects and updates, and must succeed. */
void room_inject(const device_fixture *d, hbil_cache *cache,
                 const hbil_view *views, cl_uint count, cl_uint bounces);
hbil_cache_counts room_statistics(const device_fixture *d, hbil_cache *cache);
/* --- a frame, a cache and its views --- */

extern const double room_middle[3];

/* A room with light, most of it behind the camera of room_start(). */
room room_lit(void);

/* A small frame that has few samples, and the cache of six views. */
enum { ROOM_WIDTH = 40, ROOM_HEIGHT = 24 };
typedef struct room_scene {
  setup s; /* s.frame.cache is the cache */
  hbil_view views[WALLS];
  exact_planes want; /* the frame with what the views have shown */
} room_scene;
void room_start(room_scene *t);
void room_stop(room_scene *t);
/* Injects, which may fail. */
hbil_status room_try(const room_scene *t, const hbil_view *views, cl_uint count,
                     cl_event *event);
/* Fails unless the status is that one, and the message names `field`. */
void room_rejected(hbil_status got, hbil_status want, const char *field);

/* A frame's outputs, with the cache that s->frame has. */
exact_planes room_outputs(setup *s);
/* Fails where two frames differ in a bit. */
void room_same_bits(setup *s, const exact_planes *want, const char *what);

#endif
