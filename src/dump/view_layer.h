/*
 * Which of several pictures in one file is read: a view layer, whose name
 * stands in front of the passes ("ViewLayer.Depth.Z"), and an eye of a
 * multi-view file, whose name stands behind them ("ViewLayer.Depth.left.Z").
 */
#ifndef HBIL_DUMP_VIEW_LAYER_H
#define HBIL_DUMP_VIEW_LAYER_H

#include "dump/channel_map.h"
#include "dump/source.h"
#include "image/error.h"
#include "image/image.h"

/* What surrounds the name of a pass in its channels' names. */
typedef struct view_layer {
  char before[256]; /* "ViewLayer.", or "" */
  char behind[80];  /* ".left", or "" */
  int plain;        /* 1: passes without `behind` belong to the eye, too: those
                       of the eye that OpenEXR calls the default view */
} view_layer;

/* Whether the file has a view layer with passes that are called like this
 * program's. */
int view_layer_exists(const image *header, dump_kind kind);

/*
 * Chooses view layer and eye: those of the options, else the view layer with
 * most of the passes that are of use and the file's first eye.  What was chosen
 * unasked of several goes to map->picked.  path: for messages.  Returns 0, or
 * -1 with `error` filled if there is no such view layer or eye.
 */
int view_layer_choose(const char *path, const image *header,
                      const source_options *options, channel_map *map,
                      view_layer *out, image_error *error);

#endif
