/*
 * Sources: the programs that write dumps.  Each has a row with the names of its
 * passes and its conventions.  What the user says about a dump overrules the
 * row.
 */
#ifndef HBIL_DUMP_SOURCE_H
#define HBIL_DUMP_SOURCE_H

#include "dump/conventions.h"
#include "dump/roles.h"

/* In the order of source_words. */
typedef enum dump_kind {
  DUMP_PLAIN = 0, /* "generic": descriptive names, hbil's own conventions */
  DUMP_CYCLES,    /* Blender's pass names and conventions */
  DUMP_PBRT,
  DUMP_MITSUBA,
  DUMP_LUXCORE,
  DUMP_ARNOLD,
  DUMP_VRAY,
  DUMP_RENDERMAN,
  DUMP_UNREAL,
  DUMP_KINDS
} dump_kind;

typedef struct pass_name {
  role role;
  const char *pass; /* a layer; "": the channels without a layer; "*.T": the
                       first channel that ends so; "*RGBA": the first layer of
                       these four channels.  With in_files: a file's name */
} pass_name;

typedef struct source_info {
  const char *word, *about; /* the word of --source; a description */
  const pass_name *passes;  /* the preferred name of a role first; ends with
                               pass NULL */
  const char *const *marks; /* parts of names that only this program uses; ends
                               with NULL; may be NULL itself */
  int in_files;             /* 1: each pass is a file (output_files.h) */
  conventions how;          /* as the program writes by default */
} source_info;

extern const source_info source_table[DUMP_KINDS];

/* The words of --source in the order of dump_kind, then "auto"; ends with NULL.
 */
extern const char *const source_words[];

/* What the user says about a dump.  The program's command line fills it; -1, 0
 * or NaN stand for "not said", as noted. */
typedef struct source_options {
  int source;      /* dump_kind or -1 */
  int depth;       /* depth_kind or -1 */
  int normals;     /* dump_space or -1 */
  int encoded;     /* 0, 1 or -1 */
  int from_depth;  /* 1: normals are rebuilt from depth */
  int positions;   /* dump_space or -1 */
  int direct;      /* direct_kind or -1 */
  int gamma;       /* 1: colours are sRGB, 0: linear, -1: as their file says */
  const char *map; /* the value of --map, or NULL; see chosen_passes.h */
  const char *view_layer; /* NULL: see view_layer.h */
  const char *eye;        /* the same */
  const char *exposure;   /* the header's number that is it; NULL: not said */
  unsigned flips;         /* as in conventions */
  float fov;              /* degrees across the picture's width; 0: not said */
  float orthographic;     /* camera units across the picture's width; 0 */
  float sky_depth;        /* NaN: not said; 0: there is no such depth */
  float unit;             /* as in conventions; 0: not said */
  float clip[2];          /* near and far plane; clip[1] 0: not said */
  float motion_scale[2];  /* motion_scale[0] 0: not said */
} source_options;

/* Nothing is said. */
void source_options_init(source_options *options);

/* A source's conventions with what the user says in their place. */
conventions source_conventions(dump_kind kind, const source_options *options);

#endif
